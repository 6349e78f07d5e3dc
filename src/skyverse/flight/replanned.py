"""A fleet in rotorpy that is told what its sensors see, and follows what a replanner answers.

Flies a mission in rotorpy that is replanned in flight, among what sensors see, and judges the flight.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from pydantic import ValidationError

from skyverse._typing import Floats
from skyverse.deconfliction.curves import stay_at_start
from skyverse.errors import InputError, require_kind, require_number
from skyverse.extras import require_libraries
from skyverse.flight.commands import COMMAND_RATE, HOVER_SECONDS, SETTLING_SECONDS, commanded, reference
from skyverse.flight.disturbances import draw
from skyverse.flight.fly import chosen_vehicle, planned_wind
from skyverse.flight.judge import approaches, measure, missed, passings, strayed, too_near
from skyverse.flight.simulator import ControlledUAV, Samples, samples
from skyverse.flight.vehicle import Vehicle, refuse_weak, told_airspeeds
from skyverse.live.closed_loop import LEAST_FLIGHT, FleetSensors, Observation
from skyverse.live.replan import Replan
from skyverse.live.replanner import Replanner
from skyverse.model.conditions import Conditions, Sensor
from skyverse.model.flight_record import Flight
from skyverse.model.mission import Mission
from skyverse.model.mover import Doubt, Mover
from skyverse.model.mover_motions import WaypointMotion
from skyverse.model.quantities import derived
from skyverse.model.replanned_flight import Prediction, ReplanAnswer, ReplannedFlight, ReplanStep
from skyverse.model.scenario import Scenario
from skyverse.model.sortie import Sortie
from skyverse.model.timed_shapes import is_closed_at_times
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Fault, Violation, with_global_places
from skyverse.model.wrong_values import complaint
from skyverse.planners.base import Seed, seeded
from skyverse.referee import certify
from skyverse.space.world import World

SAME_PLACE = 1e-6
"""Metres: a motion that is farther than this from the one before, at the instant of an observation, began anew."""
HOVER = round(HOVER_SECONDS * COMMAND_RATE)
"""Samples for which UAVs hover before the mission begins."""


def true_scenario(known: Scenario, truth: Scenario) -> Scenario:
    """Return a scenario with the movers and obstacles of another one besides its own; movers have no doubt in it.

    Raises
    ------
    InputError
        If two movers that differ have one name.
    """
    movers = [*known.movers, *(one for one in truth.movers if one not in known.movers)]
    obstacles = [*known.obstacles, *(one for one in truth.obstacles if one not in known.obstacles)]
    certain = [derived(one, doubt=Doubt()) for one in movers]
    try:
        return Scenario.model_validate({**dict(known), "movers": certain, "obstacles": obstacles})
    except ValidationError as error:
        raise InputError(complaint(error.errors()[0]), field="truth") from None


class ReplannedFleet:
    """A fleet in rotorpy that is told what its sensors see, and follows what a replanner answers.

    Parameters
    ----------
    replanner
        Of the mission.
    truth
        What there is; see `true_scenario`.
    sensor, vehicle, conditions
        What UAVs see with, what flies, and what disturbs it.
    margin
        Metres from its motion beyond which a UAV without a tracking error is made known to the replanner.
    rng
        Draws what disturbs UAVs, and the sensor's errors.
    longest
        Seconds after which the flight ends at the latest.

    Attributes
    ----------
    truth
        As given.
    arrivals
        When each UAV's motion ends at its target, seconds; ``None`` for one that has not arrived.
    ended
        Seconds into the mission at which the flight ended.
    """

    def __init__(
        self,
        replanner: Replanner,
        truth: Scenario,
        sensor: Sensor,
        vehicle: Vehicle,
        conditions: Conditions,
        margin: float,
        rng: np.random.Generator,
        longest: float,
    ) -> None:
        known = replanner.mission.scenario
        self.truth, self.ended = truth, 0.0
        self.arrivals: tuple[float | None, ...] = (None,) * len(known.uavs)
        self._replanner, self._vehicle, self._margin = replanner, vehicle, margin
        self._sensors = FleetSensors(replanner, truth, sensor, rng)
        self._numbers = {mover.name: number for number, mover in enumerate(truth.movers)}
        self._last = math.ceil(longest * COMMAND_RATE)
        seeds = rng.integers(2**62, size=len(known.uavs)).tolist()
        self._uavs = []
        for uav, seed in enumerate(seeds):
            told = commanded(known, _as_planned(replanner.mission, uav), vehicle, longest)
            flown = draw(told, vehicle, conditions, seed)
            self._uavs.append(ControlledUAV(vehicle, *flown, np.array(known.uavs[uav].start, dtype=np.float64)))

    def fly(self, on_progress: Callable[[int, int], None] | None) -> Iterator[ReplanStep]:
        """Fly until all UAVs have arrived and settled, or for the longest time; yield what was observed."""
        self._follow(-HOVER, 0)
        k, looks, first = 0, 0, True
        while True:
            if k == self._sample_of(looks):
                self._look(k)
                looks += 1
            for one in self._sensors.arrived(k / COMMAND_RATE):
                yield self._observe(one, k, first)
                first = False
                if on_progress is not None:
                    on_progress(int(k / COMMAND_RATE), math.ceil(self._last / COMMAND_RATE))
            if k >= self._last or self._all_settled(k):
                break
            arrives = min(self._sensors.next_arrival * COMMAND_RATE, self._last)
            stop = min(self._sample_of(looks), self._last, math.ceil(arrives - 1e-9))
            self._follow(k, stop)
            k = stop
        self.ended = k / COMMAND_RATE
        ends = [self._replanner.arrival(uav) for uav in range(len(self._uavs))]
        self.arrivals = tuple(end if end is not None and end <= self.ended else None for end in ends)

    def samples(self) -> tuple[Samples, ...]:
        """Return how each UAV flew from the beginning of the mission on."""
        times = np.arange(-HOVER, round(self.ended * COMMAND_RATE)) / COMMAND_RATE
        return tuple(samples(times, uav.states, HOVER) for uav in self._uavs)

    def _sample_of(self, look: int) -> int:
        """Return the sample at which sensors look for the given time, counted from 0."""
        return math.ceil(look * COMMAND_RATE / self._sensors.sensor.rate - 1e-9)

    def _follow(self, first: int, stop: int) -> None:
        """Let all UAVs fly the samples from one up to another one, by what the replanner last answered."""
        times = np.arange(first, stop) / COMMAND_RATE
        for number, uav in enumerate(self._uavs):
            uav.follow(reference(self._replanner.flown(number), self._vehicle, times, 1.0 / COMMAND_RATE))

    def _look(self, k: int) -> None:
        """Let the sensors look at a sample."""
        states = {n: (uav.place.copy(), uav.velocity.copy()) for n, uav in enumerate(self._uavs) if not uav.lost}
        self._sensors.look(k / COMMAND_RATE, np.array([uav.place for uav in self._uavs]), states)

    def _observe(self, look: Observation, k: int, first: bool) -> ReplanStep:
        """Tell the replanner what was seen, and return that and its answers."""
        replanner, uavs = self._replanner, range(len(self._uavs))
        before = [replanner.motion(uav).at([look.time]).position[0] for uav in uavs]
        errors = [uav.tracking_error for uav in self.truth.uavs]
        far = {
            uav: state
            for uav, state in look.states.items()
            if max(errors[uav].horizontal, errors[uav].vertical) > 0.0
            or np.linalg.norm(state[0] - before[uav]) > self._margin
        }
        answers = self._sensors.told(look, far)
        return ReplanStep(
            time=look.time,
            arrival=k / COMMAND_RATE,
            movers=tuple(self._numbers[one.name] for one in look.movers),
            obstacles=tuple(self.truth.obstacles.index(one) for one in look.obstacles),
            predictions=tuple(map(self._prediction, replanner.predicted())),
            answers=tuple(self._answer(answer, before[answer.uav], first) for answer in answers),
        )

    def _prediction(self, mover: Mover) -> Prediction:
        assert isinstance(mover.motion, WaypointMotion)
        return Prediction(self._numbers[mover.name], mover.motion, mover.doubt)

    def _answer(self, answer: Replan, before: Floats, first: bool) -> ReplanAnswer:
        """Return the record of an answer to a UAV that should have been at a place (3,)."""
        motion = self._replanner.motion(answer.uav)
        restarted = bool(np.linalg.norm(motion.at([answer.time]).position[0] - before) > SAME_PLACE)
        new = first or restarted or not answer.kept
        return ReplanAnswer(
            uav=answer.uav,
            kept=answer.kept,
            proven=answer.proven,
            clear_until=answer.clear_until,
            sentence=answer.sentence,
            motion=self._replanner.motion(answer.uav) if new else None,
            restarted=restarted,
        )

    def _all_settled(self, k: int) -> bool:
        """Tell whether each UAV is lost, or has arrived and settled since."""
        arrivals = (self._replanner.arrival(uav) for uav in range(len(self._uavs)))
        settled = k / COMMAND_RATE - SETTLING_SECONDS
        return all(
            uav.lost or (arrival is not None and arrival <= settled)
            for uav, arrival in zip(self._uavs, arrivals, strict=True)
        )


def _as_planned(mission: Mission, uav: int) -> Trajectory:
    """Return a UAV's planned trajectory, from 0 s on; where it has none, it stays at its start."""
    trajectory = mission.trajectories[uav]
    return stay_at_start(mission.scenario.uavs[uav]) if trajectory is None else trajectory.retimed(0.0)


OnSeconds = Callable[[int, int], None]
"""Called with the seconds into the mission that have been flown, and those that are flown at most."""


def fly_replanned(
    replanner: Replanner,
    truth: Scenario,
    sensor: Sensor | None = None,
    conditions: Conditions | None = None,
    *,
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
    conditions, margin, rng
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
    sensor = Sensor() if sensor is None else sensor
    require_kind(replanner, Replanner, "replanner")
    conditions = Conditions(wind=planned_wind(replanner.mission)) if conditions is None else conditions
    for field, value, wanted in (
        ("truth", truth, Scenario),
        ("sensor", sensor, Sensor),
        ("conditions", conditions, Conditions),
    ):
        require_kind(value, wanted, field)
    mission = replanner.mission
    scenario = mission.scenario
    margin = scenario.clearance / 2 if margin is None else margin
    longest = 2.0 * mission.makespan + 60.0 if longest is None else longest
    require_number(margin, "margin", "metres", 0.0)
    require_number(longest, "longest", "seconds", LEAST_FLIGHT)
    _refuse_what_is_not_flown(replanner, sensor)
    generator, seed = seeded(rng)
    require_libraries("flying", "rotorpy")
    kind, conditions = chosen_vehicle(mission, conditions)
    refuse_weak(kind, scenario.uavs, conditions.wind)
    real = true_scenario(scenario, truth)
    fleet = ReplannedFleet(replanner, real, sensor, kind, conditions, margin, generator, longest)
    steps = tuple(fleet.fly(on_progress))
    samples = fleet.samples()
    references = tuple(replanner.flown(uav) for uav in range(len(scenario.uavs)))
    sorties = tuple(_spanning(replanner.sorties(uav), flown) for uav, flown in enumerate(references))
    commanded = replace(
        mission,
        scenario=real,
        trajectories=references,
        sorties=sorties if mission.sorties else (),
        violations=(),
        deconfliction=None,
    )
    proven = certify(real, commanded)
    commanded = replace(commanded, certificates=proven.trajectories, apart=proven.apart)
    world = World(derived(real, terrain=None, movers=()))
    flown = tuple(measure(world, commanded, uav, one, kind) for uav, one in enumerate(samples))
    near, (found, wrong) = approaches(real, flown), passings(commanded, flown, margin)
    due = [fleet.ended if one.lost else 0.0 for one in samples]
    speeds = [told_airspeeds(kind, reference, conditions.wind) for reference in references]
    wrong = [
        *(fault for one in flown for fault in strayed(real, one, margin, due[one.uav], speeds[one.uav])),
        *too_near(real, flown, near, margin),
        *wrong,
        *_not_arrived(scenario, fleet.arrivals, fleet.ended, speeds),
    ]
    drawn = conditions.random or sensor.error > 0.0
    flight = Flight(
        commanded,
        conditions,
        seed if drawn else None,
        float(margin),
        flown,
        tuple(found),
        (),
    )
    wrong = with_global_places(scenario.frame, [*wrong, *missed(real, flight.visits)])
    flight = replace(flight, violations=tuple(wrong))
    return ReplannedFlight(mission, sensor, flight, steps, fleet.arrivals, near, replanner.lead, replanner.horizon)


def _spanning(sorties: tuple[Sortie, ...], flown: Trajectory) -> tuple[Sortie, ...]:
    """Return sorties in which a UAV also hovers before its tour begins, and after it has ended."""
    if not sorties:
        return ()
    first = (replace(sorties[0], begin=flown.start), *sorties[1:])
    return (*first[:-1], replace(first[-1], end=flown.end))


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


def _not_arrived(
    scenario: Scenario, arrivals: tuple[float | None, ...], ended: float, speeds: list[str]
) -> list[Violation]:
    """Return the violations of UAVs that had not arrived when the flight ended, seconds."""
    left = {uav: scenario.uavs[uav].name for uav, arrival in enumerate(arrivals) if arrival is None}
    said = f"has not arrived when the flight ends at {ended:.2f} s"
    return [
        Violation(Fault.TRAJECTORY_ENDS, (uav,), f"{name} {said}{speeds[uav]}", ended) for uav, name in left.items()
    ]
