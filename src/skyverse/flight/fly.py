"""Flies a mission in simulation, and judges the flight: once in rotorpy, or many times in the compiled simulator."""

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from dataclasses import replace
from functools import reduce
from typing import overload

import numpy as np

from skyverse._typing import Ints
from skyverse.errors import InputError, require_kind, require_number, require_whole
from skyverse.extras import require_libraries
from skyverse.flight.commands import Commands, commands_to
from skyverse.flight.judge import measure, missed, passings, strayed
from skyverse.flight.runs import (
    SimulatedRun,
    added,
    cross_check_nearest,
    distribution,
    first_violation,
    prepare,
    summarise_run,
)
from skyverse.flight.simulator import Samples, simulate_in_rotorpy
from skyverse.flight.vehicle import Vehicle, refuse_weak, told_airspeeds, vehicle_of
from skyverse.model.conditions import Conditions, simulated_vehicle
from skyverse.model.flight_record import Flight, FlightRuns, Flown, TrackingErrors
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.verdict import with_global_places
from skyverse.numerics.cores import cores
from skyverse.planners.base import Seed, seeded
from skyverse.space.world import World

OnFlown = Callable[[int, int], None]
"""Called with how many UAVs, or runs, have been flown, and how many are flown in all."""

Job = tuple[Commands, Vehicle, Conditions, int]
"""The flight of one UAV: its commands, its vehicle, what disturbs it, and the seed of that."""
MAX_RUNS = 1_000_000
FIRST_RUNS, MORE_RUNS = 10, 50
"""Runs that are flown together, at first and later; a touch that is to end the flights does so after such a part."""


@overload
def fly(
    mission: Mission,
    conditions: Conditions | None = None,
    *,
    runs: None = None,
    margin: float | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnFlown | None = None,
) -> Flight: ...


@overload
def fly(
    mission: Mission,
    conditions: Conditions | None = None,
    *,
    runs: int,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnFlown | None = None,
) -> FlightRuns: ...


def fly(
    mission: Mission,
    conditions: Conditions | None = None,
    *,
    runs: int | None = None,
    margin: float | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnFlown | None = None,
) -> Flight | FlightRuns:
    """Fly every trajectory of a mission in a simulator, once or many times, and judge the flight.

    rotorpy's SE3 controller follows each trajectory with its own gains; the documentation's page on flight describes
    the commands that it gets. Each UAV has hovered in the wind for some seconds when it departs. Aeroplanes are not
    flown; the other UAVs are judged against their trajectories.

    One flight is simulated by rotorpy. It is safe if every UAV keeps the scenario's clearance less the margin, leaves
    the bounds by at most the margin, and ends within the margin of the end of its trajectory, and if no two UAVs enter
    each other's ellipsoid of separation, made smaller by twice the margin. Where starts or targets are given closer
    than the separation, UAVs must only keep the nearness that is given.

    Many flights are simulated by compiled code that does the same, each with other gusts, another vehicle and other
    noise. They are safe if nothing is touched in any: a UAV touches something where its centre is no farther from an
    obstacle or the ground than the vehicle's radius, or two centres no farther apart than two radii. The distances of
    the runs that came nearest are held against the referee's code.

    Parameters
    ----------
    mission
        The mission to fly; its scenario's limits say what the vehicle must be able to do.
    conditions
        The vehicle, the wind, and what else disturbs; by default the scenario's wind alone.
    runs
        How often to fly it in the compiled simulator; by default it is flown once, in rotorpy.
    margin
        The allowed deviation of a UAV in one flight, metres; half the scenario's clearance by default.
    rng
        Seed or generator of all that is random; every UAV and run has a random stream of its own.
    workers
        The number of processes for one flight, 1 by default: a script that asks for more must start under
        ``if __name__ == "__main__":``. The number of threads for many, as many as there are cores by default. The
        answer does not depend on it.
    on_progress
        Called whenever a UAV, or some runs, have been flown.

    Raises
    ------
    InputError
        If rotorpy is not installed, there is nothing to fly, the vehicle is too weak, or a parameter is out of range.
    """
    require_kind(mission, Mission, "mission")
    conditions = Conditions(wind=planned_wind(mission)) if conditions is None else conditions
    require_kind(conditions, Conditions, "conditions")
    for name, value in (("runs", runs), ("workers", workers)):
        if value is not None:
            require_whole(value, name, 1, MAX_RUNS)
    if runs is None:
        return _fly_once(mission, conditions, margin, rng, workers or 1, on_progress)
    if margin is not None:
        raise InputError("expected a single flight with it, found many", field="margin")
    return fly_runs(mission, conditions, runs, rng, workers, on_progress)


def planned_wind(mission: Mission) -> tuple[float, float, float]:
    """Return the wind, (3,) m/s, for which a mission was planned, at the mean altitude of its flights."""
    wind = mission.scenario.wind
    if wind is None:
        return 0.0, 0.0, 0.0
    heights = [one.coefficients[:, 0, 2].mean() for one in mission.trajectories if one is not None]
    east, north, up = wind.at(np.mean(heights or [0.0])).tolist()
    return east, north, up


def chosen_vehicle(mission: Mission, conditions: Conditions) -> tuple[Vehicle, Conditions]:
    """Return the vehicle that flies a mission, and the conditions with its name."""
    name = conditions.vehicle or simulated_vehicle(mission.scenario.uavs)
    return vehicle_of(name), replace(conditions, vehicle=name)


def _flying(mission: Mission, kind: Vehicle, conditions: Conditions) -> list[int]:
    """Return the UAVs that are flown, or raise `InputError` where there are none, or the vehicle is too weak."""
    scenario = mission.scenario
    both = enumerate(zip(scenario.uavs, mission.trajectories, strict=True))
    flying = [number for number, (uav, flown) in both if flown is not None and uav.fixed_wing is None]
    if not flying:
        raise InputError(f"{scenario.name}: expected a trajectory of a multirotor to fly, found none")
    refuse_weak(kind, tuple(scenario.uavs[uav] for uav in flying), conditions.wind)
    return flying


def _fly_once(
    mission: Mission,
    conditions: Conditions,
    margin: float | None,
    rng: Seed,
    workers: int,
    on_progress: OnFlown | None,
) -> Flight:
    """Fly a mission once, in rotorpy; see `fly`."""
    scenario = mission.scenario
    margin = scenario.clearance / 2 if margin is None else margin
    require_number(margin, "margin", "metres", 0.0)
    generator, seed = seeded(rng)
    require_libraries("flying", "rotorpy")
    kind, conditions = chosen_vehicle(mission, conditions)
    flying = _flying(mission, kind, conditions)
    seeds = generator.integers(2**62, size=len(scenario.uavs)).tolist()
    jobs = {uav: (commands_to(mission, uav, kind), kind, conditions, seeds[uav]) for uav in flying}
    world = World(derived(scenario, terrain=None))
    flown: list[Flown | None] = [None] * len(scenario.uavs)
    for done, (uav, samples) in enumerate(_simulated(jobs, min(workers, len(jobs))), 1):
        flown[uav] = measure(world, mission, uav, samples, kind)
        if on_progress is not None:
            on_progress(done, len(jobs))
    near, wrong = passings(mission, tuple(flown), margin)
    violations = []
    for one in flown:
        if one is not None:
            planned = mission.trajectories[one.uav]
            assert planned is not None
            speeds = told_airspeeds(kind, planned, conditions.wind)
            violations += strayed(scenario, one, margin, planned.end, speeds)
    drawn = seed if conditions.random else None
    flight = Flight(mission, conditions, drawn, float(margin), tuple(flown), tuple(near), ())
    violations += [*wrong, *missed(scenario, flight.visits)]
    return replace(flight, violations=tuple(with_global_places(scenario.frame, violations)))


def _simulated(
    jobs: dict[int, tuple[Commands, Vehicle, Conditions, int]], workers: int
) -> Iterator[tuple[int, Samples]]:
    """Yield the index and the samples of each UAV, as soon as it has been flown."""
    if workers == 1:
        for uav, job in jobs.items():
            yield uav, simulate_in_rotorpy(*job)
        return
    context = multiprocessing.get_context("spawn")  # a forked process would inherit locks that other threads hold
    with ProcessPoolExecutor(workers, context, _deaf) as pool:
        waiting = {pool.submit(simulate_in_rotorpy, *job): uav for uav, job in jobs.items()}
        try:
            for done in as_completed(waiting):
                yield waiting[done], done.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _deaf() -> None:
    """Ignore Ctrl-C; the parent process handles it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def fly_runs(
    mission: Mission,
    conditions: Conditions,
    runs: int,
    rng: Seed,
    workers: int | None,
    on_progress: OnFlown | None,
    until_touch: bool = False,
) -> FlightRuns:
    """Fly a mission many times; see `fly`. `until_touch`: until the part of all runs in which something is touched."""
    scenario = mission.scenario
    kind, conditions = chosen_vehicle(mission, conditions)
    generator, seed = seeded(rng)
    seeds = generator.integers(2**31, size=runs)
    flown = _flying(mission, kind, conditions)
    fleet = prepare(mission, kind, conditions)
    done: list[SimulatedRun] = []
    counted = {uav: [np.zeros(0, dtype=np.int64)] * 2 for uav in flown}
    with ThreadPoolExecutor(workers or cores()) as pool:
        for part in _parts(seeds):
            for summary, errors in pool.map(lambda seed: summarise_run(fleet, int(seed)), part):
                done.append(summary)
                for uav, counts in errors.items():
                    counted[uav] = [added(one, more) for one, more in zip(counted[uav], counts, strict=True)]
            if on_progress is not None:
                on_progress(len(done), runs)
            if until_touch and any(first_violation(fleet, k, summary) for k, summary in enumerate(done)):
                break
    wrong = {k: found for k, summary in enumerate(done) if (found := first_violation(fleet, k, summary))}
    largest = np.array([summary.largest for summary in done])

    def told(uavs: Sequence[int]) -> TrackingErrors:
        most = largest[:, uavs].max(axis=(0, 1))
        each = (reduce(added, (counted[uav][axis] for uav in uavs)) for axis in (0, 1))
        return TrackingErrors(*map(distribution, each, most.tolist()))

    return FlightRuns(
        mission=mission,
        conditions=conditions,
        radius=kind.radius,
        seed=seed if conditions.random else None,
        seeds=np.array(seeds[: len(done)]),
        errors=tuple(told([uav]) if uav in counted else None for uav in range(len(scenario.uavs))),
        all_errors=told(flown),
        clearance=np.array([min(summary.obstacle.distance, summary.ground.distance) for summary in done]),
        separation=np.array([summary.pair.distance for summary in done]),
        nearness=np.array([summary.nearness for summary in done]),
        outside=np.array([summary.outside for summary in done]),
        largest=largest,
        violations=wrong,
        checks=cross_check_nearest(fleet, done),
    )


def _parts(seeds: Ints) -> Iterator[Ints]:
    """Yield the seeds of the runs that are flown together; the first is flown alone, since it compiles the kernels."""
    yield seeds[:1]
    yield seeds[1:FIRST_RUNS]
    for first in range(FIRST_RUNS, len(seeds), MORE_RUNS):
        yield seeds[first : first + MORE_RUNS]
