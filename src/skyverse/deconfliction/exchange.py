"""Two UAVs in each other's way may take each other's targets."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from skyverse.deconfliction.conflicts import find_conflicts
from skyverse.deconfliction.fleet import Fleet, Place
from skyverse.deconfliction.options import Option
from skyverse.deconfliction.resolve import resolve, worth
from skyverse.model.result import Result
from skyverse.model.verdict import Conflict
from skyverse.problem import Problem

Replan = Callable[[Problem], Result]

TRIED = 4
"""Pairs that are tried with each other's targets."""
LATE = 0.5
"""The share of its flight time by which a UAV must arrive later before it looks for another target."""


@dataclass(frozen=True)
class Solved:
    """The UAVs' own options, the conflicts between them, and the places that resolve them."""

    own: list[Option]
    conflicts: tuple[Conflict, ...]
    places: list[Place]


def solve(fleet: Fleet, own: list[Option], conflicts: tuple[Conflict, ...]) -> Solved:
    """Resolve the conflicts between the UAVs' own options."""
    clashing = {uav for conflict in conflicts if not conflict.given for uav in conflict.uavs}
    return Solved(own, conflicts, resolve(fleet, own, clashing))


def exchange_targets(fleet: Fleet, first: Solved, replan: Replan) -> Solved:
    """Let pairs in conflict exchange their targets, and return the best that comes out, or `first`."""
    best = first
    for _, (a, b) in zip(range(TRIED), _pairs(first), strict=False):
        if fleet.cancelled:
            break
        own = list(best.own)
        for uav, other in ((a, b), (b, a)):
            target = best.own[other].target
            assert target is not None
            problem = Problem(fleet.airspace, uav, target)
            result = replan(problem)
            trajectory = fleet.fly(problem, result)
            if trajectory is None:
                break
            own[uav] = fleet.own(uav, target, result, trajectory)
        else:
            flown = [None if option.target is None else option.trajectory for option in own]
            solved = solve(fleet, own, find_conflicts(fleet.scenario, flown))
            if worth(solved.places) < worth(best.places):
                best = solved
    return best


def _pairs(solved: Solved) -> Iterator[tuple[int, int]]:
    """Yield pairs in conflict one of which found no place or comes late, the latest first; each UAV once."""
    late: Sequence[float] = [
        float("inf") if place.clashes else place.arrival / option.trajectory.end - 1.0
        for place, option in zip(solved.places, solved.own, strict=True)
    ]
    taken: set[int] = set()
    for conflict in sorted(solved.conflicts, key=lambda c: -max(late[uav] for uav in c.uavs)):
        a, b = conflict.uavs
        both_fly = solved.own[a].target is not None and solved.own[b].target is not None
        if both_fly and not taken & {a, b} and max(late[a], late[b]) > LATE:
            taken |= {a, b}
            yield a, b
