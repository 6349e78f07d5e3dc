"""Flies a mission, made easier until it is flown safely, or gives it up: slower, or farther from all else."""

import math
from dataclasses import replace
from functools import partial
from typing import overload

from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.errors import InputError, require_kind, require_whole
from skyverse.flight.fly import OnFlown, fly, fly_runs, planned_wind
from skyverse.flight.judge import planned_close
from skyverse.flight.vehicle import refuse_stand_in
from skyverse.mission.plan_mission import MissionOptions, plan_mission
from skyverse.model.conditions import Conditions, simulated_vehicle
from skyverse.model.flight_record import Flight, FlightRuns
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.result import Result, Status
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Fault
from skyverse.planners.auto import Auto
from skyverse.planners.base import Seed, seeded
from skyverse.referee import check, judged
from skyverse.summary import with_flight_summaries

_SLOWED = "Slowed down with the whole mission, to be flown safely."


def slowed(mission: Mission, factor: float) -> Mission:
    """Return a mission in which all times are multiplied by `factor`, those of departures included.

    All places and their order stay, so that UAVs keep clear of obstacles and apart as before. Stays at targets are as
    many times as long; a window may be missed then, which the referee tells.

    Raises
    ------
    InputError
        If an aeroplane flies in it, since its airspeed is given.
    """
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if uav.fixed_wing is not None and trajectory is not None:
            raise InputError(f"{mission.scenario.name}: cannot be slowed down: {uav.name} keeps its airspeed")
    trajectories = tuple(None if t is None else _stretched(t, factor) for t in mission.trajectories)
    sorties = tuple(tuple(one.retimed(0.0, 0.0, factor) for one in own) for own in mission.sorties)
    told = mission.deconfliction
    if told is not None:
        told = replace(told, total_after=told.total_after * factor, makespan_after=told.makespan_after * factor)
    slow = replace(mission, trajectories=trajectories, sorties=sorties, deconfliction=told)
    return judged(slow.scenario, with_flight_summaries(slow))


def _stretched(trajectory: Trajectory, factor: float) -> Trajectory:
    return replace(
        trajectory.retimed(trajectory.start * factor, factor),
        note=trajectory.note if _SLOWED in trajectory.note else f"{trajectory.note} {_SLOWED}".strip(),
    )


def farther(mission: Mission, more: float, apart: float = 0.0) -> Mission | None:
    """Return a mission with the same starts and targets, planned by `Auto` with `more` metres of additional clearance.

    UAVs are planned with `apart` metres of additional separation. Where the paths of a fleet are apart in space, those
    planned anew are led around each other too. Tours are made anew, among all targets. The mission remains an answer to
    its own scenario, and is judged with that clearance and separation. There is none where so much clearance leaves no
    room below a ceiling.
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
    in_space = flying > 1 and not mission.sorties and not apart_by_timing_only(mission)
    resolve = in_space or mission.deconfliction is not None or apart > 0
    seed = mission.provenance.seed
    plan = partial(
        plan_mission, planner=Auto(), rng=seed, options=MissionOptions(keep_apart=resolve, apart_in_space=in_space)
    )
    sent = [target for target in mission.assignment if target is not None]
    if mission.sorties:
        planned = plan(derived(scenario, **changes), assignment="tours")
        assigned = planned.assignment
    elif len(sent) == len(mission.assignment):  # keep the assignment
        changes["targets"] = tuple(scenario.targets[target] for target in sent)
        planned = plan(derived(scenario, **changes), assignment="identity")
        assigned = tuple(None if own is None else sent[own] for own in planned.assignment)
    else:
        planned = plan(derived(scenario, **changes))
        assigned = planned.assignment
    results = tuple(None if result is None else _unbounded(result) for result in planned.results)
    anew = replace(planned, scenario=scenario, assignment=assigned, results=results)
    return judged(scenario, with_flight_summaries(anew))


def _separated(uav: UAV, apart: float) -> UAV:
    """Return a UAV with so many metres of additional separation, horizontal and vertical."""
    level, upright = uav.ellipsoid
    return derived(uav, separation=level + apart, vertical_separation=upright + apart)


def _unbounded(result: Result) -> Result:
    """Return a result without claims of optimality, which do not hold among paths nearer to obstacles."""
    status = Status.COMPLETE if result.status is Status.OPTIMAL else result.status
    return replace(result, status=status, bound=None, straight_bound=False)


SLOWDOWN, SLOWDOWN_OF_MANY = 1.25, 1.5
"""The factors by which a mission that is flown once, or many times, takes longer after a round."""
ROUNDS, ROUNDS_OF_MANY = 5, 8
"""How many rounds there are at most by default."""
SPARE = 0.02
"""Metres added to what was missing, since another flight may come nearer than the nearest that was flown."""


@overload
def fly_until_safe(
    mission: Mission,
    conditions: Conditions | None = None,
    *,
    runs: None = None,
    rounds: int | None = None,
    margin: float | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnFlown | None = None,
) -> Flight: ...


@overload
def fly_until_safe(
    mission: Mission,
    conditions: Conditions | None = None,
    *,
    runs: int,
    rounds: int | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnFlown | None = None,
) -> FlightRuns: ...


def fly_until_safe(
    mission: Mission,
    conditions: Conditions | None = None,
    *,
    runs: int | None = None,
    rounds: int | None = None,
    margin: float | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnFlown | None = None,
) -> Flight | FlightRuns:
    """Fly a mission once or many times; while that is not safe, make the mission easier and fly it again.

    A round makes the whole mission take longer, by a quarter for one flight and by half for many, which keeps all that
    is proven of it. If that did not halve what was missing to obstacles, ground or, in many flights, to other UAVs, or
    is impossible because of an aeroplane, the next round instead plans the mission again with `Auto`, with what was
    missing added to clearance and separation, and as slow as before. A mission that is still not safe after all
    rounds, or for which there is no way left, is refused.

    Parameters
    ----------
    mission, conditions, runs, margin, rng, workers, on_progress
        As for `fly`; every round flies with the same seed. Of many flights a round ends soon after something was
        touched.
    rounds
        How many rounds there are at most; by default 5, or 8 with `runs`.

    Returns
    -------
    Flight or FlightRuns
        What came of the first mission that is safe; or else of the last, with a `refusal`. Its `mission` is the one
        that was flown; its `rounds` describe what was changed.

    Raises
    ------
    InputError
        As for `fly`, if `rounds` is not a whole number from 1 on, or if the vehicle is not the planned one.
    """
    if rounds is not None:
        require_whole(rounds, "rounds", 1)
    require_kind(mission, Mission, "mission")
    conditions = Conditions(wind=planned_wind(mission)) if conditions is None else conditions
    require_kind(conditions, Conditions, "conditions")
    refuse_stand_in(conditions.vehicle or simulated_vehicle(mission.scenario.uavs), mission.scenario.uavs)
    factor = SLOWDOWN if runs is None else SLOWDOWN_OF_MANY
    rounds = rounds or (ROUNDS if runs is None else ROUNDS_OF_MANY)
    winged = any(uav.fixed_wing is not None for uav in mission.scenario.uavs)
    seed = rng if isinstance(rng, int) else int(seeded(rng)[0].integers(2**62))

    def again(one: Mission) -> Flight | FlightRuns:
        if runs is None:
            return fly(one, conditions, margin=margin, rng=seed, workers=workers, on_progress=on_progress)
        return fly_runs(one, conditions, runs, seed, workers, on_progress, until_touch=True)

    flown, said, why = again(mission), list[str](), ""
    slowness, more, apart, before = 1.0, 0.0, 0.0, math.inf
    while not flown.safe:
        if len(said) == rounds:
            why = f"after {rounds} rounds, {_first_wrong(flown)}"
            break
        if pair := _planned_close(flown):
            why = f"{pair} are planned too close, which no slower flight mends"
            break
        near, close = _missing(flown)
        short = max(near, close)
        if short > 0 and (winged or short > before / 2):
            more += near + SPARE if near > 0 else 0.0
            apart += close + 2 * SPARE if close > 0 else 0.0
            done = f"planned anew with {more:.3g} m more clearance and {apart:.3g} m more separation"
            anew = farther(mission, more, apart)
            if anew is None or _leaves_more_out(mission, anew) or not is_no_worse(mission, anew):
                why = f"{done}, there is no way left"
                break
            easier, before = slowed(anew, slowness) if slowness > 1 else anew, math.inf
        elif winged:
            why = "an aeroplane keeps its airspeed, so that nothing can be slowed down"
            break
        else:
            slowness *= factor
            easier, before = slowed(flown.mission, factor), short if short > 0 else math.inf
            done = f"slowed down to {1 / slowness:.0%} of its speed"
        if easier.sorties and not is_no_worse(mission, easier):
            why = f"{done}, {easier.violations[0].message.rstrip('.')}"
            break
        flown = again(easier)
        said.append(f"Round {len(said) + 1}: {done}; {'safe' if flown.safe else _first_wrong(flown)}.")
    if why:
        slow = f" at {1 / slowness:.0%} of its speed" if slowness > 1 else ""
        why = f"Refused: {mission.scenario.name}{slow} is too tight for {flown.conditions.sentence}: {why}."
    return replace(flown, rounds=tuple(said), refusal=why)


def _first_wrong(flown: Flight | FlightRuns) -> str:
    """Return what went wrong first."""
    wrong = flown.violations.values() if isinstance(flown, FlightRuns) else flown.violations
    return next(iter(wrong)).message


def _planned_close(flown: Flight | FlightRuns) -> str:
    """Return the names of two UAVs whose planned trajectories also violate their separation, or an empty string."""
    if isinstance(flown, FlightRuns):
        return ""
    names = [uav.name for uav in flown.mission.scenario.uavs]
    wrong = (violation.uavs for violation in flown.violations if violation.fault is Fault.SEPARATION)
    return next((f"{names[i]} and {names[j]}" for i, j in wrong if planned_close(flown.mission, i, j)), "")


def _missing(flown: Flight | FlightRuns) -> tuple[float, float]:
    """Return by how many metres obstacles or ground, and another UAV, came nearer than they may; 0 or less if not."""
    if isinstance(flown, FlightRuns):
        return flown.radius - float(flown.clearance.min()), 2 * flown.radius - float(flown.separation.min())
    scenario, missing = flown.mission.scenario, [0.0]
    near = {violation.uavs[0] for violation in flown.violations if violation.fault is Fault.TRAJECTORY_CLEARANCE}
    for one in flown.flown:
        if one is not None and one.uav in near:
            missing.append(scenario.clearance - flown.margin - one.clearance)
            if one.above_ground is not None:
                missing.append(scenario.ground_clearance - flown.margin - one.above_ground)
    return max(missing), 0.0


def _leaves_more_out(before: Mission, after: Mission) -> bool:
    """Tell whether a mission that was planned anew is not complete, or if no more was asked, visits fewer targets."""
    return not after.complete and (not before.unvisited or len(after.unvisited) > len(before.unvisited))


def is_no_worse(before: Mission, after: Mission) -> bool:
    """Tell whether a mission that was planned anew is no worse in the referee's eyes."""
    given = {violation.fault for violation in check(before.scenario, before)}  # a file may tell any of it
    return {violation.fault for violation in after.violations} <= given
