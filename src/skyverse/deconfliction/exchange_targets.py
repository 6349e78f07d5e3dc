"""Exchange of targets: two UAVs in each other's way may fly to each other's targets."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.find_conflicts import find_conflicts
from skyverse.deconfliction.prioritized_planning import cost_of, place_flights
from skyverse.model.result import Result
from skyverse.model.verdict import Conflict
from skyverse.problem import Problem

Replan = Callable[[Problem], Result]
"""Plans the path of a UAV to another target."""

MAX_EXCHANGES = 4
"""Pairs whose exchange is tried."""
LATE = 0.5
"""The share of its flight time by which a UAV must arrive later before an exchange is tried."""


@dataclass(frozen=True)
class Resolution:
    """The flights that resolve the conflicts of a fleet.

    Attributes
    ----------
    planned
        Each UAV's planned path.
    conflicts
        Between the planned paths.
    placed
        Each UAV's flight.
    """

    planned: list[Candidate]
    conflicts: tuple[Conflict, ...]
    placed: list[PlacedFlight]


def resolve_by_placing(pool: CandidatePool, planned: list[Candidate], conflicts: tuple[Conflict, ...]) -> Resolution:
    """Resolve the conflicts between planned paths by delays, slower flights and detours."""
    in_conflict = {uav for conflict in conflicts if not conflict.given for uav in conflict.uavs}
    return Resolution(planned, conflicts, place_flights(pool, planned, in_conflict))


def exchange_targets(pool: CandidatePool, first: Resolution, replan: Replan) -> Resolution:
    """Let pairs in conflict exchange their targets; return the best resolution that this gives, or the first one."""
    best = first
    for _, (a, b) in zip(range(MAX_EXCHANGES), _late_pairs(first), strict=False):
        if pool.cancelled:
            break
        planned = list(best.planned)
        for uav, other in ((a, b), (b, a)):
            target = best.planned[other].target
            assert target is not None
            problem = Problem(pool.airspace, uav, target)
            result = replan(problem)
            trajectory = pool.make_trajectory(problem, result)
            if trajectory is None:
                break
            planned[uav] = pool.add_planned(uav, target, result, trajectory)
        else:
            flown = [None if own.target is None else own.trajectory for own in planned]
            resolution = resolve_by_placing(pool, planned, find_conflicts(pool.scenario, flown))
            if cost_of(resolution.placed) < cost_of(best.placed):
                best = resolution
    return best


def _late_pairs(resolution: Resolution) -> Iterator[tuple[int, int]]:
    """Yield pairs in conflict of which one is left in conflict or comes late, the latest first; each UAV once."""
    late: Sequence[float] = [
        float("inf") if flight.in_conflict else flight.arrival / own.trajectory.end - 1.0
        for flight, own in zip(resolution.placed, resolution.planned, strict=True)
    ]
    taken: set[int] = set()
    for conflict in sorted(resolution.conflicts, key=lambda c: -max(late[uav] for uav in c.uavs)):
        a, b = conflict.uavs
        both_fly = resolution.planned[a].target is not None and resolution.planned[b].target is not None
        if both_fly and not taken & {a, b} and max(late[a], late[b]) > LATE:
            taken |= {a, b}
            yield a, b
