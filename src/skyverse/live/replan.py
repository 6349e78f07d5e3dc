"""What is chosen for a UAV to fly from now on, what a replanner answers of it, and in which turns UAVs choose."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple


class Span(NamedTuple):
    """The instants that matter, seconds into the mission.

    Attributes
    ----------
    now, join
        Now, and when a new motion can begin.
    until
        Until when it is proven.
    apart
        Until when it is proven to keep its distance from other UAVs, no earlier than `until`.
    """

    now: float
    join: float
    until: float
    apart: float


class FirstContact(NamedTuple):
    """What a motion first comes too near to: when, infinite if never, and which mover, -1 for what stands still."""

    instant: float = math.inf
    mover: int = -1


class Choice(NamedTuple):
    """What is known of the motion that was chosen.

    Attributes
    ----------
    kept, proven
        Whether it is what was flown before, and whether it is proven up to the horizon.
    contact
        What it comes too near to first, up to the horizon.
    tried
        How many motions were made.
    held_up
        Whether another UAV is in the way of the motion that would arrive first.
    """

    kept: bool
    proven: bool
    contact: FirstContact
    tried: int
    held_up: bool = False


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
        found = replan(uav)
        answers[uav], last[uav] = found if uav not in answers else answers[uav].followed_by(found), turns
        if not waiting:
            unproven = max((last[k] for k in order if not answers[k].proven), default=0)
            waiting = [k for k in order if answers[k].proven and last[k] < unproven][:1]
    return answers
