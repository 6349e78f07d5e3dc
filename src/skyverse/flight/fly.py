"""Flies a mission in simulation, each UAV in rotorpy, and judges the flight.

Flies a mission many times in the compiled simulator, each time with other disturbances.
"""

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed

import numpy as np

from skyverse._typing import Ints
from skyverse.errors import InputError, require_kind, require_number
from skyverse.flight.commands import commands
from skyverse.flight.disturbances import weather_of
from skyverse.flight.judge import measure, passings, strayed
from skyverse.flight.runs import (
    ErrorCounts,
    RunSummary,
    cross_check_nearest,
    first_touch,
    prepare,
    summarise_run,
    total,
)
from skyverse.flight.simulate import Samples, SimulationJob, require_simulator, simulate_in_rotorpy
from skyverse.flight.vehicle import refuse_weak, told_airspeeds, vehicle_of
from skyverse.model.disturbances import Disturbances
from skyverse.model.flight_record import Flight, Flown
from skyverse.model.flight_runs import FlightRuns, TrackingErrors
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.simulated_vehicle import simulated_vehicle
from skyverse.numerics.cores import cores
from skyverse.planners.base import Seed, seeded
from skyverse.space.world import World

OnFlown = Callable[[int, int], None]
"""Called with the number of UAVs that have been flown and the number of all UAVs to fly."""


def fly(
    mission: Mission,
    *,
    vehicle: str | None = None,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    disturbances: Disturbances | None = None,
    margin: float | None = None,
    rng: Seed = None,
    workers: int = 1,
    on_progress: OnFlown | None = None,
) -> Flight:
    """Fly every trajectory of a mission in rotorpy, a quadrotor simulator, and judge the flight.

    rotorpy's SE3 controller follows each trajectory with its own gains; the documentation's page on flight describes
    the commands that it gets. Each UAV has hovered in the wind for some seconds when it departs. Aeroplanes are not
    flown; the other UAVs are judged against their trajectories.

    The flight is safe if every UAV keeps the scenario's clearance less the margin, leaves the bounds by at most the
    margin, and ends within the margin of the end of its trajectory, and if no two UAVs enter each other's ellipsoid of
    separation, made smaller by twice the margin. Where starts or targets are given closer than the separation, UAVs
    must only keep the nearness that is given.

    Parameters
    ----------
    mission
        The mission to fly; its scenario's limits say what the vehicle must be able to do.
    vehicle
        ``"thesis"``, ``"camera"``, ``"crazyflie"`` or ``"hummingbird"``, which flies in place of every multirotor. By
        default it is the vehicle that the mission was planned for where that is one of them, and otherwise the
        thesis's.
    wind
        The velocity of the air, (3,) m/s towards east, north and up; or its speed, m/s, and the direction in which it
        moves, degrees counter-clockwise from east.
    noise
        The standard deviation, on each axis, of the white normal noise in what the controller measures: this many
        metres of position and m/s of velocity.
    disturbances
        Gusts, mismatch of the vehicle, drift of measured positions and delay; none by default.
    margin
        The allowed deviation of a UAV, metres; half the scenario's clearance by default.
    rng
        Seed or generator of all that is random; every UAV has a random stream of its own.
    workers
        The number of processes. A script that asks for more than 1 must start under ``if __name__ == "__main__":``.
    on_progress
        Called whenever a UAV has been flown.

    Raises
    ------
    InputError
        If rotorpy is not installed, there is nothing to fly, the vehicle is too weak, or a parameter is out of range.
    """
    require_kind(mission, Mission, "mission")
    weather = weather_of(wind, noise, disturbances)
    if margin is None:
        margin = mission.scenario.clearance / 2
    require_number(margin, "margin", "metres", 0.0)
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise InputError(f"workers is a whole number from 1 on, not {workers!r}")
    generator, seed = seeded(rng)
    require_simulator()
    scenario = mission.scenario
    kind = vehicle_of(simulated_vehicle(scenario.uavs) if vehicle is None else vehicle)
    flying = {
        uav: trajectory
        for uav, trajectory in enumerate(mission.trajectories)
        if trajectory is not None and scenario.uavs[uav].fixed_wing is None
    }
    if not flying:
        raise InputError(f"{scenario.name}: expected a trajectory of a multirotor to fly, found none")
    refuse_weak(kind, tuple(scenario.uavs[uav] for uav in flying), weather.wind)
    seeds = generator.integers(2**62, size=len(scenario.uavs)).tolist()
    jobs = {uav: SimulationJob(commands(mission, uav, kind), kind, weather, seeds[uav]) for uav in flying}
    world = World(derived(scenario, terrain=None))
    flown: list[Flown | None] = [None] * len(scenario.uavs)
    for done, (uav, samples) in enumerate(_simulated(jobs, min(workers, len(jobs))), 1):
        flown[uav] = measure(world, mission, uav, samples, kind)
        if on_progress is not None:
            on_progress(done, len(jobs))
    found, wrong = passings(mission, tuple(flown), margin)
    due = {uav: (one.end, told_airspeeds(kind, one, weather.wind)) for uav, one in flying.items()}
    violations = [v for f in flown if f is not None for v in strayed(scenario, f, margin, *due[f.uav])] + wrong
    return Flight(
        mission,
        kind.name,
        weather.wind,
        weather.noise,
        seed if weather.random else None,
        float(margin),
        tuple(flown),
        tuple(found),
        tuple(violations),
        disturbances=weather.others,
    )


def _simulated(jobs: dict[int, SimulationJob], workers: int) -> Iterator[tuple[int, Samples]]:
    """Yield the index and the samples of each UAV, as soon as it has been flown."""
    if workers == 1:
        for uav, job in jobs.items():
            yield uav, simulate_in_rotorpy(job)
        return
    context = multiprocessing.get_context("spawn")  # a forked process would inherit locks that other threads hold
    with ProcessPoolExecutor(workers, context, _deaf) as pool:
        waiting = {pool.submit(simulate_in_rotorpy, job): uav for uav, job in jobs.items()}
        try:
            for done in as_completed(waiting):
                yield waiting[done], done.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _deaf() -> None:
    """Ignore Ctrl-C; the parent process handles it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


OnRuns = Callable[[int, int], None]
"""Called with the number of runs that have been flown and the number of all runs."""

MAX_RUNS = 1_000_000
FIRST_RUNS, MORE_RUNS = 10, 50
"""Runs that are flown together, at first and later; a touch that is to end the flights does so after such a part."""


def fly_many(
    mission: Mission,
    *,
    runs: int = 100,
    vehicle: str | None = None,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    disturbances: Disturbances | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnRuns | None = None,
) -> FlightRuns:
    """Fly a mission many times, each time with other gusts, another vehicle and other noise, and tell what came of it.

    The simulator is compiled, and flies as `fly` does in rotorpy. A UAV touches something where its centre is no
    farther from an obstacle or the ground than the vehicle's radius, or two centres no farther apart than two radii.
    The distances of the runs that came nearest are held against the referee's code.

    Parameters
    ----------
    mission
        The mission to fly; its scenario's limits say what the vehicle must be able to do.
    runs
        How often to fly it.
    vehicle, wind, noise, disturbances
        As for `fly`.
    rng
        Seed or generator, from which the seed of every run is drawn.
    workers
        The number of threads; by default the number of cores. The answer does not depend on it.
    on_progress
        Called whenever some runs have been flown.

    Raises
    ------
    InputError
        If there is nothing to fly, the vehicle is too weak or not installed, or a parameter is out of range.
    """
    require_kind(mission, Mission, "mission")
    vehicle = vehicle or simulated_vehicle(mission.scenario.uavs)
    flights = Flights(runs, vehicle, wind, noise, disturbances, rng, workers)
    return flights.fly(mission, until_touch=False, on_progress=on_progress)


class Flights:
    """Everything but the mission that many flights need, checked; the parameters are those of `fly_many`."""

    def __init__(
        self,
        runs: int,
        vehicle: str,
        wind: Sequence[float],
        noise: float,
        disturbances: Disturbances | None,
        rng: Seed,
        workers: int | None,
    ) -> None:
        for name, value, most in (("runs", runs, MAX_RUNS), ("workers", workers, MAX_RUNS)):
            if value is not None and (isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most):
                raise InputError(f"expected a whole number from 1 to {most}, found {value!r}", field=name)
        self.weather = weather_of(wind, noise, disturbances)
        self.vehicle = vehicle_of(vehicle)
        generator, self.seed = seeded(rng)
        self.seeds = generator.integers(2**31, size=runs)
        self.workers = workers or cores()

    def fly(self, mission: Mission, *, until_touch: bool, on_progress: OnRuns | None) -> FlightRuns:
        """Fly a mission, until the end of the part of all runs in which something is touched if that is wanted."""
        scenario = mission.scenario
        fleet = prepare(mission, self.vehicle, self.weather)
        flown = [uav for uav, told in enumerate(fleet.commands) if told is not None]
        if not flown:
            raise InputError(f"{scenario.name}: expected a trajectory of a multirotor to fly, found none")
        refuse_weak(self.vehicle, tuple(scenario.uavs[uav] for uav in flown), self.weather.wind)
        done: list[RunSummary] = []
        by_uav = {uav: (ErrorCounts(), ErrorCounts()) for uav in flown}
        with ThreadPoolExecutor(self.workers) as pool:
            for part in _parts(self.seeds):
                for summary, errors in pool.map(lambda seed: summarise_run(fleet, int(seed)), part):
                    done.append(summary)
                    for uav, (horizontal, vertical) in errors.items():
                        by_uav[uav][0].add(horizontal)
                        by_uav[uav][1].add(vertical)
                if on_progress is not None:
                    on_progress(len(done), len(self.seeds))
                if until_touch and any(first_touch(fleet, k, summary) for k, summary in enumerate(done)):
                    break
        touches = [touch for k, summary in enumerate(done) if (touch := first_touch(fleet, k, summary))]
        largest = np.array([summary.largest for summary in done])

        def told(uavs: Sequence[int]) -> TrackingErrors:
            most = largest[:, uavs].max(axis=(0, 1))
            each = zip(zip(*(by_uav[uav] for uav in uavs), strict=True), most, strict=True)
            return TrackingErrors(*(total(counts).distribution(float(worst)) for counts, worst in each))

        return FlightRuns(
            mission=mission,
            vehicle=self.vehicle.name,
            radius=self.vehicle.radius,
            wind=self.weather.wind,
            noise=self.weather.noise,
            disturbances=self.weather.others,
            seed=self.seed if self.weather.random else None,
            seeds=np.array(self.seeds[: len(done)]),
            errors=tuple(told([uav]) if uav in by_uav else None for uav in range(len(scenario.uavs))),
            all_errors=told(flown),
            clearance=np.array([min(summary.obstacle, summary.ground).distance for summary in done]),
            separation=np.array([summary.pair.distance for summary in done]),
            nearness=np.array([summary.nearness for summary in done]),
            outside=np.array([summary.outside for summary in done]),
            largest=largest,
            touches=tuple(touches),
            checks=cross_check_nearest(fleet, done),
        )


def _parts(seeds: Ints) -> Iterator[Ints]:
    """Yield the seeds of the runs that are flown together; the first is flown alone, since it compiles the kernels."""
    yield seeds[:1]
    yield seeds[1:FIRST_RUNS]
    for first in range(FIRST_RUNS, len(seeds), MORE_RUNS):
        yield seeds[first : first + MORE_RUNS]
