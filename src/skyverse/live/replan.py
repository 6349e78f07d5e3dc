"""What a replanner answers for one UAV to what was observed."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Replan:
    """What a replanner answers for one UAV to what was observed.

    Attributes
    ----------
    time
        The instant of the observation, seconds into the mission.
    uav
        The UAV's index.
    kept
        Whether the UAV goes on with the motion that it was flying.
    proven
        Whether its motion is proven to have a way out: it keeps clear of everything up to the horizon, wherever movers
        may be as far as is known, and ends at rest; an aeroplane loiters, or ends its mission at its target.
    clear_until
        The instant up to which the motion is clear, seconds into the mission: the horizon if it is proven.
    mover
        What the motion may come too near to then, such as ``"mover 'ball'"``; empty if that is nothing that moves.
        Where it may be by then, `Replanner.predicted` tells.
    sentence
        One sentence that says what is proven; or which mover the UAV may come too near to, when and where.
    tried
        How many motions were made.
    seconds
        How long it took.
    out_of_bounds
        Metres by which the UAV is out of bounds.
    forgotten
        The names of movers that were kept in mind up to now, but were not seen for so long that they may be anywhere.
    """

    time: float
    uav: int
    kept: bool
    proven: bool
    clear_until: float
    mover: str
    sentence: str
    tried: int
    seconds: float
    out_of_bounds: float = 0.0
    forgotten: tuple[str, ...] = ()

    def followed_by(self, later: "Replan") -> "Replan":
        """Return the answer that takes the place of this one, to the same observation; efforts add up."""
        tried, seconds = self.tried + later.tried, self.seconds + later.seconds
        return replace(later, kept=self.kept and later.kept, tried=tried, seconds=seconds)

    def __repr__(self) -> str:
        return f"Replan at t = {self.time:.6g} s\n  {self.sentence}"
