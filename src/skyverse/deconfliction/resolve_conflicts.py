"""A fleet kept apart: what is in conflict departs later, flies more slowly, takes another way or another's target."""

from collections.abc import Iterator

from skyverse.deconfliction.conflicts import find_conflicts
from skyverse.deconfliction.exchange import Replan, Solved, exchange_targets, solve
from skyverse.deconfliction.fleet import Fleet
from skyverse.deconfliction.options import Fly
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Action, Deconfliction
from skyverse.problem import Airspace
from skyverse.stop import Stop

Targets = tuple[int | None, ...]
Results = tuple[Result | None, ...]
Trajectories = tuple[Trajectory | None, ...]


def keep_apart(
    airspace: Airspace,
    assignment: Targets,
    results: Results,
    trajectories: Trajectories,
    *,
    fly: Fly,
    replan: Replan | None = None,
    stop: Stop | None = None,
) -> tuple[Targets, Results, Trajectories, Deconfliction]:
    """Resolve the conflicts between trajectories; UAVs of lower priority give way to those of higher.

    One UAV after another takes the place in which it arrives first: its own path, later or more slowly or both; or,
    where that costs much, a way around the others. Where some find no place, or come late, pairs may exchange their
    targets. Every place is tested against all others in continuous time before it is taken.

    Parameters
    ----------
    airspace
        Of the scenario.
    assignment, results, trajectories
        The mission as it was planned.
    fly
        Turns a problem's result into a trajectory.
    replan
        Plans a UAV's path to another's target; without it, no targets are exchanged.
    stop
        A `Cancelled` that is met ends this with the best that was found.

    Returns
    -------
    assignment, results, trajectories, Deconfliction
        The mission as it is kept apart, and what was done. What is left could not be resolved, or was given.
    """
    scenario = airspace.scenario
    found = find_conflicts(scenario, trajectories)
    before = _ends(trajectories)
    if all(conflict.given for conflict in found):
        return assignment, results, trajectories, Deconfliction(found, found, (), *_twice(before))
    fleet = Fleet(airspace, fly, stop)
    planned = zip(range(len(results)), assignment, results, trajectories, strict=True)
    solved = solve(fleet, [fleet.own(*given) for given in planned], found)
    if replan is not None:
        solved = exchange_targets(fleet, solved, replan)
    flies = [t is not None for t in trajectories]
    places = solved.places
    targets = tuple(p.option.target if f else t for p, f, t in zip(places, flies, assignment, strict=True))
    kept = tuple(p.option.result if f else r for p, f, r in zip(places, flies, results, strict=True))
    flown = tuple(p.option.trajectory.retimed(p.at, p.scale) if f else None for p, f in zip(places, flies, strict=True))
    after = _ends(flown)
    actions = tuple(_actions(scenario, assignment, trajectories, solved))
    deconfliction = Deconfliction(
        found, find_conflicts(scenario, flown), actions, before[0], after[0], before[1], after[1]
    )
    return targets, kept, flown, deconfliction


def _ends(trajectories: Trajectories) -> tuple[float, float]:
    """Return the total time and the makespan, seconds."""
    ends = [t.end for t in trajectories if t is not None]
    return float(sum(ends)), float(max(ends, default=0.0))


def _twice(before: tuple[float, float]) -> tuple[float, float, float, float]:
    return before[0], before[0], before[1], before[1]


def _actions(scenario: Scenario, assignment: Targets, trajectories: Trajectories, solved: Solved) -> Iterator[Action]:
    """Say what was done to whom."""
    for uav, (place, given, own) in enumerate(zip(solved.places, trajectories, solved.own, strict=True)):
        name, option = scenario.uavs[uav].name, place.option
        if given is None:
            continue
        if option.target is not None and option.target != assignment[uav]:
            yield Action(uav, "exchange", f"{name} flies to {scenario.targets[option.target].name}.")
        if option.gates:
            aside = ", then ".join(gate.beside for gate in option.gates)
            metres = f"{option.metres:.4g} m instead of {own.metres:.4g} m"
            yield Action(uav, "detour", f"{name} flies {aside} of the others: {metres}.")
        if place.scale > 1.0:
            yield Action(uav, "slow down", f"{name} flies {place.scale:g} times as slowly.")
        if place.at > option.trajectory.start:
            yield Action(uav, "delay", f"{name} departs {place.at - option.trajectory.start:.2f} s later.")
