"""Resolve the conflicts of a fleet by delays, slower flights, detours and exchanges of targets."""

from collections.abc import Iterator

from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.detours import MakeTrajectory
from skyverse.deconfliction.exchange_targets import Replan, Resolution, exchange_targets, resolve_by_placing
from skyverse.deconfliction.find_conflicts import find_conflicts
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Action, Deconfliction
from skyverse.problem import Airspace
from skyverse.stop import Stop

Targets = tuple[int | None, ...]
Results = tuple[Result | None, ...]
Trajectories = tuple[Trajectory | None, ...]


def resolve_conflicts(
    airspace: Airspace,
    assignment: Targets,
    results: Results,
    trajectories: Trajectories,
    *,
    make_trajectory: MakeTrajectory,
    replan: Replan | None = None,
    stop: Stop | None = None,
) -> tuple[Targets, Results, Trajectories, Deconfliction]:
    """Resolve the conflicts between trajectories; UAVs of lower priority give way to those of higher priority.

    One UAV after another takes the flight by which it arrives first without a conflict: its own path, later or more
    slowly or both, or, where that costs much, a detour around the others. Where UAVs are left in conflict or come late,
    pairs of them may exchange their targets. Every flight is tested against those before it in continuous time.

    Parameters
    ----------
    airspace
        Of the scenario.
    assignment, results, trajectories
        The mission as it was planned: each UAV's target, path and trajectory, ``None`` where it has none.
    make_trajectory
        Turns a problem's result into a trajectory.
    replan
        Plans a UAV's path to another's target; without it, no targets are exchanged.
    stop
        A `Cancelled` rule that is met ends the search with the best that it has found.

    Returns
    -------
    assignment, results, trajectories, Deconfliction
        The mission with its conflicts resolved, and what was done. Conflicts that are left could not be resolved, or
        are given by starts or targets.
    """
    scenario = airspace.scenario
    found = find_conflicts(scenario, trajectories)
    total, makespan = _arrivals(trajectories)
    if all(conflict.given for conflict in found):
        unchanged = Deconfliction(found, found, (), total, total, makespan, makespan)
        return assignment, results, trajectories, unchanged
    pool = CandidatePool(airspace, make_trajectory, stop)
    mission = zip(range(len(results)), assignment, results, trajectories, strict=True)
    resolution = resolve_by_placing(pool, [pool.add_planned(*uav) for uav in mission], found)
    if replan is not None:
        resolution = exchange_targets(pool, resolution, replan)
    targets, paths, flown = list(assignment), list(results), list(trajectories)
    for uav, flight in enumerate(resolution.placed):
        if trajectories[uav] is not None:
            candidate = flight.candidate
            targets[uav], paths[uav] = candidate.target, candidate.result
            flown[uav] = candidate.trajectory.retimed(flight.departure, flight.time_scale)
    actions = tuple(_actions(scenario, assignment, trajectories, resolution))
    total_after, makespan_after = _arrivals(tuple(flown))
    left = find_conflicts(scenario, flown)
    done = Deconfliction(found, left, actions, total, total_after, makespan, makespan_after)
    return tuple(targets), tuple(paths), tuple(flown), done


def _arrivals(trajectories: Trajectories) -> tuple[float, float]:
    """Return the sum of the arrival times and the makespan, seconds."""
    ends = [t.end for t in trajectories if t is not None]
    return float(sum(ends)), float(max(ends, default=0.0))


def _actions(
    scenario: Scenario, assignment: Targets, trajectories: Trajectories, resolution: Resolution
) -> Iterator[Action]:
    """Yield what was done to each UAV, in sentences."""
    for uav, (flight, planned, own) in enumerate(zip(resolution.placed, trajectories, resolution.planned, strict=True)):
        name, candidate = scenario.uavs[uav].name, flight.candidate
        if planned is None:
            continue
        if candidate.target is not None and candidate.target != assignment[uav]:
            yield Action(uav, "exchange", f"{name} flies to {scenario.targets[candidate.target].name}.")
        if candidate.gates:
            aside = ", then ".join(gate.beside for gate in candidate.gates)
            metres = f"{candidate.metres:.4g} m instead of {own.metres:.4g} m"
            yield Action(uav, "detour", f"{name} flies {aside} of the others: {metres}.")
        if flight.time_scale > 1.0:
            yield Action(uav, "slow down", f"{name} flies {flight.time_scale:g} times as slowly.")
        if flight.departure > candidate.trajectory.start:
            delay = flight.departure - candidate.trajectory.start
            yield Action(uav, "delay", f"{name} departs {delay:.2f} s later.")
