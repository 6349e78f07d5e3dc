"""Makes a mission easier to fly: slower, or farther from obstacles and ground.

Flies a mission repeatedly, made easier after each unsafe flight, until it is safe.

Flies a mission many times, made easier until no run touches anything, or gives it up as too tight.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.errors import InputError
from skyverse.flight.fly import Flights, OnFlown, OnRuns, fly
from skyverse.flight.judge import planned_close
from skyverse.flight.vehicle import refuse_stand_in
from skyverse.mission.plan_mission import plan_mission
from skyverse.model.disturbances import Disturbances
from skyverse.model.flight_record import Flight
from skyverse.model.flight_runs import FlightRuns
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.result import Result, Status
from skyverse.model.simulated_vehicle import simulated_vehicle
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Fault
from skyverse.planners.auto import Auto
from skyverse.planners.base import Seed, seeded
from skyverse.referee import certify, check
from skyverse.summary import with_flight_summaries
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


SLOWDOWN = 1.25
"""The factor by which a mission takes longer after a round."""


def fly_until_safe(
    mission: Mission,
    *,
    rounds: int = 5,
    shape: Shape = "minimum-time",
    vehicle: str | None = None,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    disturbances: Disturbances | None = None,
    margin: float | None = None,
    rng: Seed = None,
    workers: int = 1,
    on_progress: OnFlown | None = None,
    on_round: Callable[[str], None] | None = None,
) -> Flight:
    """Fly a mission; while the flight is not safe, make the mission easier and fly it again.

    A round makes the whole mission take a quarter longer, which keeps all that is proven of it. If that did not halve
    the distance by which a UAV came too near to an obstacle, or is impossible because of an aeroplane, the next round
    instead plans the mission again with `Auto`, with the missing distance added to the clearance, and as slow as
    before.

    Parameters
    ----------
    rounds
        The largest number of rounds.
    shape
        The shape of trajectories that are planned again; see `plan_mission`.
    on_round
        Called with a sentence about each round.

    The other parameters are those of `fly`; every round flies with the same seed.

    Returns
    -------
    Flight
        The first safe flight, or else the last. Its `mission` is the one that was flown; its `rounds` describe what was
        changed.

    Raises
    ------
    InputError
        As for `fly`, if `rounds` is not a whole number from 1 on, or if the vehicle is not the planned one.
    """
    if isinstance(rounds, bool) or not isinstance(rounds, int) or rounds < 1:
        raise InputError(f"rounds is a whole number from 1 on, not {rounds!r}")
    refuse_stand_in(vehicle or simulated_vehicle(mission.scenario.uavs), mission.scenario.uavs)
    seed = rng if isinstance(rng, int) else int(seeded(rng)[0].integers(2**62))
    said: list[str] = []
    slowness, more, before = 1.0, 0.0, float("inf")
    flown = partial(
        fly,
        vehicle=vehicle,
        wind=wind,
        noise=noise,
        disturbances=disturbances,
        margin=margin,
        rng=seed,
        workers=workers,
        on_progress=on_progress,
    )

    def say(sentence: str) -> None:
        said.append(sentence)
        if on_round is not None:
            on_round(sentence)

    flight = flown(mission)
    winged = any(uav.fixed_wing is not None for uav in mission.scenario.uavs)
    for number in range(1, rounds + 1):
        if flight.safe:
            break
        if pair := _planned_close(flight):
            say(f"Round {number}: {pair} are planned too close, which no slower flight mends; ended.")
            break
        short = _shortfall(flight)
        if short > 0 and (winged or short > before / 2):
            more += 1.1 * short
            anew = farther(mission, more, shape)
            done = f"planned anew at a clearance of {mission.scenario.clearance + more:.3g} m"
            if anew is None or not anew.complete:
                say(f"Round {number}: {done}, which leaves no way; ended.")
                break
            easier, before = slowed(anew, slowness) if slowness > 1 else anew, float("inf")
        elif winged:
            say(f"Round {number}: nothing can be slowed down while an aeroplane keeps its airspeed.")
            break
        else:
            slowness *= SLOWDOWN
            easier, before = slowed(flight.mission, SLOWDOWN), short
            done = f"slowed down to {1 / slowness:.0%} of its speed"
        flight = flown(easier)
        verdict = "safe" if flight.safe else f"not safe: {flight.violations[0].message}"
        say(f"Round {number}: {done}; {verdict}.")
    return replace(flight, rounds=tuple(said))


def _planned_close(flight: Flight) -> str:
    """Return the names of two UAVs whose planned trajectories also violate their separation, or an empty string."""
    names = [uav.name for uav in flight.mission.scenario.uavs]
    wrong = (violation.uavs for violation in flight.violations if violation.fault is Fault.SEPARATION)
    return next((f"{names[i]} and {names[j]}" for i, j in wrong if planned_close(flight.mission, i, j)), "")


def _shortfall(flight: Flight) -> float:
    """Return the largest shortfall of clearance from obstacles and ground, metres; 0 where there is none."""
    scenario, missing = flight.mission.scenario, [0.0]
    near = {violation.uavs[0] for violation in flight.violations if violation.fault is Fault.TRAJECTORY_CLEARANCE}
    for flown in flight.flown:
        if flown is not None and flown.uav in near:
            missing.append(scenario.clearance - flight.margin - flown.clearance)
            if flown.above_ground is not None:
                missing.append(scenario.ground_clearance - flight.margin - flown.above_ground)
    return max(missing)


RUNS_SLOWDOWN = 1.5
"""The factor by which a mission takes longer after a round."""
SPARE = 0.02
"""Metres added to what was missing, since another run may come nearer than the nearest that was flown."""


def fly_many_until_safe(
    mission: Mission,
    *,
    rounds: int = 8,
    shape: Shape = "minimum-time",
    runs: int = 100,
    vehicle: str | None = None,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    disturbances: Disturbances | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnRuns | None = None,
    on_round: Callable[[str], None] | None = None,
) -> FlightRuns:
    """Fly a mission many times; while any run touches something, make the mission easier and fly it again.

    A round makes the whole mission take half as long again, which keeps all that is proven of it. If that did not halve
    what was missing to the vehicle's radius, or is impossible because of an aeroplane, the next round instead plans the
    mission again with `Auto`, with what was missing added to clearance and separation, and as slow as before. A round
    ends soon after a run has touched something. A mission that is still not safe after all rounds, or for which there
    is no way left, is refused.

    Parameters
    ----------
    rounds
        The largest number of rounds.
    shape
        The shape of trajectories that are planned again; see `plan_mission`.
    on_round
        Called with a sentence about each round.

    The other parameters are those of `fly_many`; every round flies with the same seeds.

    Returns
    -------
    FlightRuns
        Those of the first mission of which no run touches anything; or else the last, with a `refusal`.

    Raises
    ------
    InputError
        As for `fly_many`, if `rounds` is not a whole number from 1 on, or if the vehicle is not the planned one.
    """
    if isinstance(rounds, bool) or not isinstance(rounds, int) or rounds < 1:
        raise InputError(f"rounds is a whole number from 1 on, not {rounds!r}")
    vehicle = vehicle or simulated_vehicle(mission.scenario.uavs)
    refuse_stand_in(vehicle, mission.scenario.uavs)
    flights = Flights(runs, vehicle, wind, noise, disturbances, rng, workers)
    winged = any(uav.fixed_wing is not None for uav in mission.scenario.uavs)
    said: list[str] = []
    slowness, more, apart, before = 1.0, 0.0, 0.0, math.inf

    def say(sentence: str) -> None:
        said.append(sentence)
        if on_round is not None:
            on_round(sentence)

    flown = flights.fly(mission, until_touch=True, on_progress=on_progress)
    why = ""
    while not flown.safe and not why:
        if len(said) == rounds:
            why = f"after {rounds} rounds, {flown.touches[0].sentence}"
            break
        near, close = _missing(flown)
        short = max(near, close)
        if short > 0 and (winged or short > before / 2):
            more += near + SPARE if near > 0 else 0.0
            apart += close + 2 * SPARE if close > 0 else 0.0
            done = f"planned anew with {more:.3g} m more clearance and {apart:.3g} m more separation"
            anew = farther(mission, more, shape, apart)
            if anew is None or not anew.complete or not _kept(mission, anew):
                why = f"{done}, there is no way left"
                break
            easier, before = slowed(anew, slowness) if slowness > 1 else anew, math.inf
        elif winged:
            why = "an aeroplane keeps its airspeed, so that nothing can be slowed down"
            break
        else:
            slowness *= RUNS_SLOWDOWN
            easier, before = slowed(flown.mission, RUNS_SLOWDOWN), short if short > 0 else math.inf
            done = f"slowed down to {1 / slowness:.0%} of its speed"
        flown = flights.fly(easier, until_touch=True, on_progress=on_progress)
        verdict = "safe" if flown.safe else flown.touches[0].sentence
        say(f"Round {len(said) + 1}: {done}; {verdict}.")
    if why:
        slow = f" at {1 / slowness:.0%} of its speed" if slowness > 1 else ""
        why = f"Refused: {mission.scenario.name}{slow} is too tight for {_weather(flown)}: {why}."
    return replace(flown, rounds=tuple(said), refusal=why)


def _missing(flown: FlightRuns) -> tuple[float, float]:
    """Return by how many metres obstacles or ground, and another UAV, came nearer than the vehicle's reach."""
    return flown.radius - float(flown.clearance.min()), 2 * flown.radius - float(flown.separation.min())


def _kept(before: Mission, after: Mission) -> bool:
    """Tell whether a mission that was planned anew is no worse in the referee's eyes."""
    given = {violation.fault for violation in check(before.scenario, before)}  # a file may tell any of it
    return {violation.fault for violation in after.violations} <= given


def _weather(flown: FlightRuns) -> str:
    """Return what disturbs, in words."""
    speed = math.hypot(*flown.wind)
    noise = f"noise of {flown.noise:g} m" if flown.noise else ""
    told = filter(None, [f"a wind of {speed:.3g} m/s" if speed else "", noise, flown.disturbances.sentence])
    return ", ".join(told) or "still air"
