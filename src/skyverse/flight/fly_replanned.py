"""Flies a mission in rotorpy that is replanned in flight, among what sensors see, and judges the flight."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from skyverse.errors import InputError, require_number
from skyverse.flight.approaches import approaches, too_near
from skyverse.flight.commands import COMMAND_RATE
from skyverse.flight.judge import measure, passings, strayed
from skyverse.flight.replanned_fleet import ReplannedFleet, true_scenario
from skyverse.flight.simulate import require_simulator
from skyverse.flight.vehicle import refuse_weak, told_airspeeds, vehicle_of
from skyverse.flight.weather import weather_of
from skyverse.live.replanner import Replanner
from skyverse.model.disturbances import Disturbances
from skyverse.model.flight_record import Flight
from skyverse.model.quantities import derived
from skyverse.model.replanned_flight import ReplannedFlight
from skyverse.model.scenario import Scenario
from skyverse.model.sensor import Sensor
from skyverse.model.simulated_vehicle import simulated_vehicle
from skyverse.model.temporary_zones import is_closed_at_times
from skyverse.model.verdict import Fault, Violation
from skyverse.planners.base import Seed, seeded
from skyverse.referee import certify
from skyverse.space.world import World

OnSeconds = Callable[[int, int], None]
"""Called with the seconds into the mission that have been flown, and those that are flown at most."""


def fly_replanned(
    replanner: Replanner,
    truth: Scenario,
    sensor: Sensor | None = None,
    *,
    vehicle: str | None = None,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    disturbances: Disturbances | None = None,
    margin: float | None = None,
    rng: Seed = None,
    longest: float | None = None,
    on_progress: OnSeconds | None = None,
) -> ReplannedFlight:
    """Fly a mission in rotorpy that is replanned in flight, among what its sensors see, and judge the flight.

    All UAVs of the fleet are simulated together. At the sensor's rate each sees what is within range of where it really
    is; the observation arrives after the delay, and the motions that the replanner answers are followed by the
    controller of `fly`. A UAV that is found farther from its motion than the margin, or than its tracking error if it
    has one, is made known to the replanner, and goes on from where it is.

    The flight is judged as by `fly`, and by movers as they truly moved: it is safe if every UAV arrives, and keeps the
    scenario's clearance less the margin from obstacles and movers. What was commanded is judged by the referee.

    Parameters
    ----------
    replanner
        Of the mission, and new: it has not observed anything yet.
    truth
        A scenario with movers and obstacles that are there besides those that the mission knows of. Movers are where
        they state to be; their doubt is left out. The rest of it is not looked at.
    sensor
        What UAVs see with; by default everything ten times a second, at once and exactly.
    vehicle, wind, noise, disturbances, margin, rng
        As those of `fly`. Gusts are drawn for the airspeed and the height of the mission as it was planned.
    longest
        Seconds into the mission after which the flight is given up; by default a minute more than the mission takes
        twice.
    on_progress
        Called after each observation.

    Raises
    ------
    InputError
        If rotorpy is not installed, the vehicle is too weak, an argument is out of range, the mission has aeroplanes or
        zones that are closed at times, or observations would arrive after the motions that answer them begin.
    """
    mission, sensor = replanner.mission, Sensor() if sensor is None else sensor
    scenario = mission.scenario
    weather = weather_of(wind, noise, disturbances)
    margin = scenario.clearance / 2 if margin is None else margin
    longest = 2.0 * mission.makespan + 60.0 if longest is None else longest
    require_number(margin, "margin", "metres", 0.0)
    require_number(longest, "longest", "seconds", 0.0)
    if longest == 0:
        raise InputError("expected seconds above 0, found 0", field="longest")
    _refuse_what_is_not_flown(replanner, sensor)
    generator, seed = seeded(rng)
    require_simulator()
    kind = vehicle_of(simulated_vehicle(scenario.uavs) if vehicle is None else vehicle)
    refuse_weak(kind, scenario.uavs, weather.wind)
    fleet = ReplannedFleet(replanner, true_scenario(scenario, truth), sensor, kind, weather, margin, generator, longest)
    steps = tuple(fleet.fly(on_progress))
    real, samples = fleet.truth, fleet.samples()
    references = tuple(replanner.flown(uav) for uav in range(len(scenario.uavs)))
    commanded = replace(mission, scenario=real, trajectories=references, violations=(), deconfliction=None)
    proven = certify(real, commanded)
    commanded = replace(commanded, certificates=proven.trajectories, apart=proven.apart)
    world = World(derived(real, terrain=None, movers=()))
    flown = tuple(measure(world, commanded, uav, one, kind) for uav, one in enumerate(samples))
    near, (found, wrong) = approaches(real, flown), passings(commanded, flown, margin)
    due = [fleet.ended if one.lost else 0.0 for one in samples]
    speeds = [told_airspeeds(kind, reference, weather.wind) for reference in references]
    wrong = [
        *(fault for one in flown for fault in strayed(real, one, margin, due[one.uav], speeds[one.uav])),
        *too_near(real, flown, near, margin),
        *wrong,
        *_not_arrived(scenario, fleet.arrivals, fleet.ended, speeds),
    ]
    drawn = weather.random or sensor.error > 0.0
    flight = Flight(
        commanded,
        kind.name,
        weather.wind,
        weather.noise,
        seed if drawn else None,
        float(margin),
        flown,
        tuple(found),
        tuple(wrong),
        disturbances=weather.others,
    )
    return ReplannedFlight(mission, sensor, flight, steps, fleet.arrivals, near, replanner.lead, replanner.horizon)


def _refuse_what_is_not_flown(replanner: Replanner, sensor: Sensor) -> None:
    """Raise `InputError` where a mission cannot be flown, or observations come too often or too late."""
    scenario = replanner.mission.scenario
    if replanner.now > 0.0:
        raise InputError("expected a replanner that has not observed anything yet")
    for uav in scenario.uavs:
        if uav.fixed_wing is not None:
            raise InputError(f"{uav.name} is an aeroplane; only multirotors are flown in rotorpy")
    if any(map(is_closed_at_times, scenario.zones)):
        said = "flights among zones that are closed at times cannot be simulated; this scenario has such"
        raise InputError(f"{scenario.name}: {said}")
    if sensor.rate > COMMAND_RATE:
        raise InputError(
            f"expected at most {COMMAND_RATE:g} observations a second, found {sensor.rate:g}", field="Sensor.rate"
        )
    if not sensor.delay < replanner.lead:
        expected = f"expected less than the replanner's lead, {replanner.lead:g} s"
        raise InputError(f"{expected}, but it is {sensor.delay:g} s", field="Sensor.delay")


def _not_arrived(
    scenario: Scenario, arrivals: tuple[float | None, ...], ended: float, speeds: list[str]
) -> list[Violation]:
    """Return the violations of UAVs that had not arrived when the flight ended, seconds."""
    left = {uav: scenario.uavs[uav].name for uav, arrival in enumerate(arrivals) if arrival is None}
    said = f"has not arrived when the flight ends at {ended:.2f} s"
    return [
        Violation(Fault.TRAJECTORY_ENDS, (uav,), f"{name} {said}{speeds[uav]}", ended) for uav, name in left.items()
    ]
