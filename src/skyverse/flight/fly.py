"""Flies a mission in simulation, each UAV in rotorpy, and judges the flight."""

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

from skyverse.errors import InputError, require_kind, require_number
from skyverse.flight.commands import commands
from skyverse.flight.judge import measure, passings, strayed
from skyverse.flight.simulate import Samples, SimulationJob, require_simulator, simulate_in_rotorpy
from skyverse.flight.vehicle import refuse_weak, told_airspeeds, vehicle_of
from skyverse.flight.weather import weather_of
from skyverse.model.disturbances import Disturbances
from skyverse.model.flight_record import Flight, Flown
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.simulated_vehicle import simulated_vehicle
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
