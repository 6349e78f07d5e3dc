"""Resolve the conflicts of a fleet by delays, slower flights, detours and exchanges of targets."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyverse.deconfliction.among_movers import STAY
from skyverse.deconfliction.candidate import Candidate, PlacedFlight, flown_length
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.detours import MakeTrajectory
from skyverse.deconfliction.find_conflicts import ellipsoid_holds, find_conflicts
from skyverse.deconfliction.prioritized_planning import cost_of, place_flights
from skyverse.interrupt import interrupted
from skyverse.model.geodesy import told_place
from skyverse.model.mission import Mission
from skyverse.model.result import Result
from skyverse.model.short_lines import listed
from skyverse.model.timed_shapes import is_closed_at_times, told_zone
from skyverse.model.verdict import Action, ActionKind, Conflict, Deconfliction
from skyverse.problem import Airspace, Problem
from skyverse.space.timed_shapes import timed_parts

Replan = Callable[[Problem], Result]
"""Plans the path of a UAV to another target."""

MAX_LATER_ENDS = 4
"""How often all flights are placed among movers, each time for a mission that ends later."""
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


def resolve_conflicts(
    airspace: Airspace,
    mission: Mission,
    *,
    make_trajectory: MakeTrajectory,
    replan: Replan | None = None,
) -> Mission:
    """Resolve the conflicts between trajectories; UAVs of lower priority give way to those of higher priority.

    An interruption ends that with the best that was found.

    One UAV after another takes the flight by which it arrives first without a conflict: its own path, later or more
    slowly or both, or, where that costs much, a detour around the others. Where UAVs are left in conflict or come late,
    pairs of them may exchange their targets. Every flight is tested against those before it in continuous time.

    Parameters
    ----------
    airspace
        The airspace of the scenario.
    mission
        As it was planned.
    make_trajectory
        Turns a problem's result into a trajectory.
    replan
        Plans a UAV's path to another's target; without it, no targets are exchanged.

    Returns
    -------
    Mission
        With its conflicts resolved, and with what was done. Conflicts that are left could not be resolved, or are given
        by starts or targets.
    """
    scenario, trajectories = mission.scenario, mission.trajectories
    found = find_conflicts(scenario, trajectories)
    total, makespan = mission.total_time, mission.makespan
    pool = CandidatePool(airspace, make_trajectory)
    flights = zip(range(len(trajectories)), mission.assignment, mission.results, trajectories, strict=True)
    if all(conflict.given for conflict in found) and not pool.is_dynamic:
        unchanged = Deconfliction(found, found, (), total, total, makespan, makespan)
        return replace(mission, interrupted=interrupted(), deconfliction=unchanged)
    planned = [pool.add_planned(*flight) for flight in flights]
    pool.end = makespan + STAY
    for _ in range(MAX_LATER_ENDS):
        resolution = resolve_by_placing(pool, planned, found)
        if replan is not None:
            resolution = exchange_targets(pool, resolution, replan)
        end = max((flight.arrival for flight in resolution.placed), default=0.0) + STAY
        if not pool.is_dynamic or end <= pool.end or interrupted():
            break
        pool.end = end  # those that have arrived must be clear of movers until the last UAV has arrived
    targets, paths, flown = list(mission.assignment), list(mission.results), list(trajectories)
    for uav, flight in enumerate(resolution.placed):
        if trajectories[uav] is not None:
            candidate = flight.candidate
            targets[uav], paths[uav] = candidate.target, candidate.result
            flown[uav] = candidate.trajectory.retimed(flight.departure, flight.time_scale)
    resolved = replace(
        mission, assignment=tuple(targets), results=tuple(paths), trajectories=tuple(flown), interrupted=interrupted()
    )
    actions = tuple(_actions(mission, resolution, pool))
    left = find_conflicts(scenario, flown)
    done = Deconfliction(found, left, actions, total, resolved.total_time, makespan, resolved.makespan)
    return replace(resolved, deconfliction=done)


def _actions(mission: Mission, resolution: Resolution, pool: CandidatePool) -> Iterator[Action]:
    """Yield what was done to each UAV of a mission, in sentences that compare with its flight before."""
    scenario = mission.scenario
    flights = zip(resolution.placed, mission.assignment, mission.trajectories, resolution.planned, strict=True)
    for uav, (flight, target, before, own) in enumerate(flights):
        name, candidate = scenario.uavs[uav].name, flight.candidate
        if before is None or target is None:
            continue
        was = f"instead of {flown_length(before):.4g} m in {before.end - before.start:.2f} s"
        if candidate.target is not None and candidate.target != target:
            there, instead = scenario.targets[candidate.target].name, scenario.targets[target].name
            now = f"{own.metres:.4g} m in {own.seconds:.2f} s"
            yield Action(uav, "exchange", f"{name} flies to {there}, not to {instead}: {now} {was}.")
        figures = f"{candidate.metres:.4g} m in {candidate.seconds:.2f} s {was}"
        for kind, told in _way_taken(pool, resolution, uav):
            yield Action(uav, kind, f"{name} {told}: {figures}." if figures else f"{name} {told}.")
            figures = ""  # they are told once
        if flight.time_scale > 1.0:
            seconds = flight.time_scale * candidate.seconds
            now = f"{seconds:.2f} s instead of {candidate.seconds:.2f} s"
            yield Action(uav, "slow down", f"{name} flies {flight.time_scale:g} times as slowly: {now}.")
        if flight.departure > candidate.trajectory.start:
            delay = flight.departure - candidate.trajectory.start
            yield Action(uav, "delay", f"{name} departs {delay:.2f} s later.")


def _way_taken(pool: CandidatePool, resolution: Resolution, uav: int) -> Iterator[tuple[ActionKind, str]]:
    """Yield what a UAV does on its way that it does not do on its planned one, and of which kind that is."""
    scenario, candidate = pool.scenario, resolution.placed[uav].candidate
    heeded = sorted(candidate.heeds)
    closed = [told_zone(scenario, number) for number in heeded if is_closed_at_times(scenario.zones[number])]
    slow = [told_zone(scenario, number) for number in heeded if not is_closed_at_times(scenario.zones[number])]
    turns = [f"flies around {listed(closed)}"] if closed else []
    turns += [f"leaves its path to avoid {_avoided(pool, resolution, uav)}"] if candidate.gates else []
    if candidate.in_time and not candidate.hovers:
        turns.append("flies another way to let others pass")
    if turns:
        yield "detour", " and ".join(turns)
    if slow:
        yield "slow down", f"keeps the speed {'limit' if len(slow) == 1 else 'limits'} of {listed(slow)}"
    waits = [f"{seconds:.2f} s at {told_place(scenario.frame.origin, place)}" for seconds, place in candidate.hovers]
    if waits:
        yield "wait", f"waits {', then '.join(waits)} to let others pass"


def _avoided(pool: CandidatePool, resolution: Resolution, uav: int) -> str:
    """Name the UAVs, movers and zones that a UAV would meet on its path, flown at once among the final flights.

    Zones that it heeds are left out.
    """
    own, scenario = resolution.planned[uav], pool.scenario
    others = [flight for flight in resolution.placed if flight.candidate.uav != uav]
    names = [scenario.uavs[flight.candidate.uav].name for flight in others]
    names += [mover.name for mover in scenario.movers]
    zones = timed_parts(scenario, own.heeds)[len(scenario.movers) :]
    heeded = resolution.placed[uav].candidate.heeds
    names += ["" if shape.zone in heeded else told_zone(scenario, shape.zone) for shape in zones]
    met = pool.conflicts(own, own.trajectory.start, pool.traffic(own, others))
    return (
        listed(list(dict.fromkeys(name for name, meets in zip(names, met, strict=True) if meets and name))) or "others"
    )


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
        if interrupted():
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
    before, after = (
        ellipsoid_holds(places[:, None] - places, pool.semi_axis_xy, pool.semi_axis_z) for places in (ends, ends[order])
    )
    return bool((after & ~before).any())


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
