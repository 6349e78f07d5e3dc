"""Makes a mission easier to fly: slower, or farther from obstacles and ground."""

from dataclasses import replace
from functools import partial

from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.errors import InputError
from skyverse.mission.flight_summaries import with_flight_summaries
from skyverse.mission.plan_mission import plan_mission
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.result import Result, Status
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.planners.auto import Auto
from skyverse.referee import certify, check
from skyverse.trajectory import Shape

_SLOWED = "Slowed down with the whole mission, to be flown safely."


def slowed(mission: Mission, factor: float) -> Mission:
    """Return a mission in which all times are multiplied by `factor`, those of departures included.

    All places and their order stay, so that UAVs keep clear of obstacles and apart as before.

    Raises
    ------
    InputError
        If an aeroplane flies in it, since its airspeed is given.
    """
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if uav.fixed_wing is not None and trajectory is not None:
            raise InputError(f"{mission.scenario.name}: cannot be slowed down: {uav.name} keeps its airspeed")
    trajectories = tuple(None if t is None else _stretched(t, factor) for t in mission.trajectories)
    told = mission.deconfliction
    if told is not None:
        told = replace(told, total_after=told.total_after * factor, makespan_after=told.makespan_after * factor)
    return judged(replace(mission, trajectories=trajectories, deconfliction=told))


def _stretched(trajectory: Trajectory, factor: float) -> Trajectory:
    return replace(
        trajectory.retimed(trajectory.start * factor, factor),
        note=trajectory.note if _SLOWED in trajectory.note else f"{trajectory.note} {_SLOWED}".strip(),
    )


def farther(mission: Mission, more: float, shape: Shape, apart: float = 0.0) -> Mission | None:
    """Return a mission with the same starts and targets, planned by `Auto` with `more` metres of additional clearance.

    UAVs are planned with `apart` metres of additional separation. Where the paths of a fleet are apart in space, those
    planned anew are led around each other too. The mission remains an answer to its own scenario, and is judged with
    that clearance and separation. There is none where so much clearance leaves no room below a ceiling.
    """
    scenario = mission.scenario
    changes: dict[str, object] = {"clearance": scenario.clearance + more}
    if scenario.terrain is not None:
        if scenario.max_height is not None and scenario.ground_clearance + more >= scenario.max_height:
            return None
        changes["terrain"] = derived(scenario.terrain, clearance=scenario.ground_clearance + more)
    if apart:
        changes["uavs"] = tuple(_separated(uav, apart) for uav in scenario.uavs)
    flying = sum(trajectory is not None for trajectory in mission.trajectories)
    in_space = flying > 1 and not apart_by_timing_only(mission)
    resolve = in_space or mission.deconfliction is not None or apart > 0
    seed = mission.provenance.seed
    plan = partial(plan_mission, planner=Auto(), rng=seed, shape=shape, keep_apart=resolve, apart_in_space=in_space)
    sent = [target for target in mission.assignment if target is not None]
    if len(sent) == len(mission.assignment):  # keep the assignment
        changes["targets"] = tuple(scenario.targets[target] for target in sent)
        planned = plan(derived(scenario, **changes), assignment="identity")
        assigned = tuple(None if own is None else sent[own] for own in planned.assignment)
    else:
        planned = plan(derived(scenario, **changes))
        assigned = planned.assignment
    results = tuple(None if result is None else _unbounded(result) for result in planned.results)
    return judged(replace(planned, scenario=scenario, assignment=assigned, results=results))


def _separated(uav: UAV, apart: float) -> UAV:
    """Return a UAV with so many metres of additional separation, horizontal and vertical."""
    level, upright = uav.ellipsoid
    return derived(uav, separation=level + apart, vertical_separation=upright + apart)


def _unbounded(result: Result) -> Result:
    """Return a result without claims of optimality, which do not hold among paths nearer to obstacles."""
    status = Status.COMPLETE if result.status is Status.OPTIMAL else result.status
    return replace(result, status=status, bound=None, straight_bound=False)


def judged(mission: Mission) -> Mission:
    """Return a mission with new summaries of its flights, and new certificates and violations from the referee."""
    mission = with_flight_summaries(mission)
    said = certify(mission.scenario, mission)
    fresh = replace(mission, certificates=said.trajectories, apart=said.apart)
    return replace(fresh, violations=tuple(check(fresh.scenario, fresh)))
