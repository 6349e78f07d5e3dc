"""What a replanner answers, and in which turns UAVs choose what they fly."""

from collections.abc import Callable, Sequence
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

    def __repr__(self) -> str:
        return f"Replan at t = {self.time:.6g} s\n  {self.sentence}"


def in_turns(order: Sequence[int], replan: Callable[[int], Replan]) -> dict[int, Replan]:
    """Return the answers of UAVs, each of which is true of what all others fly in the end.

    A UAV whose motion was proven before another one took a motion that is not proven, maybe through its own, has
    another turn.

    Parameters
    ----------
    order
        The UAVs' indices, in the order of their turns.
    replan
        Chooses what a UAV flies among what the others fly now.
    """
    answers: dict[int, Replan] = {}
    waiting, turns = list(order), 0
    last = dict.fromkeys(order, 0)
    while waiting:
        uav, turns = waiting.pop(0), turns + 1
        found, before = replan(uav), answers.get(uav)
        if before is not None:  # efforts add up
            tried, seconds = before.tried + found.tried, before.seconds + found.seconds
            found = replace(found, kept=before.kept and found.kept, tried=tried, seconds=seconds)
        answers[uav], last[uav] = found, turns
        if not waiting:
            unproven = max((last[k] for k in order if not answers[k].proven), default=0)
            waiting = [k for k in order if answers[k].proven and last[k] < unproven][:1]
    return answers
