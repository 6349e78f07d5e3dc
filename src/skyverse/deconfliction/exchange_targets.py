"""Exchange of targets: two UAVs in each other's way may fly to each other's targets."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Bools, Floats
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
    in_conflict |= {own.uav for own in planned if pool.meets_movers(own)}
    return Resolution(planned, conflicts, place_flights(pool, planned, in_conflict))


def exchange_targets(pool: CandidatePool, first: Resolution, replan: Replan) -> Resolution:
    """Let pairs in conflict exchange their targets; return the best resolution that this gives, or the first one.

    No exchange is tried that would bring two targets too close to each other for those that would then fly there.
    """
    best = first
    for _, (a, b) in zip(range(MAX_EXCHANGES), _late_pairs(first), strict=False):
        if pool.cancelled:
            break
        if _makes_targets_too_close(pool, best.planned, a, b):
            continue
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


def _makes_targets_too_close(pool: CandidatePool, planned: Sequence[Candidate], a: int, b: int) -> bool:
    """Tell whether an exchange brings the ends of two flights closer than their separation that were apart before.

    Such a conflict nobody could resolve: it would be given, by the exchange. Of two UAVs the larger separation counts,
    so that the same targets may be far enough from each other for some UAVs and not for others.
    """
    order = list(range(len(planned)))
    order[a], order[b] = b, a
    ends = np.array([own.end for own in planned])
    return bool((_too_close(pool, ends[order]) & ~_too_close(pool, ends)).any())


def _too_close(pool: CandidatePool, ends: Floats) -> Bools:
    """Tell of each two UAVs whether these ends of their flights, (n, 3) metres, are too close to each other, (n, n)."""
    gap = (ends[:, None] - ends) ** 2
    xy, z = pool.semi_axis_xy, pool.semi_axis_z
    close: Bools = (gap[..., 0] + gap[..., 1]) * z**2 + gap[..., 2] * xy**2 < (xy * z) ** 2
    return close


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
