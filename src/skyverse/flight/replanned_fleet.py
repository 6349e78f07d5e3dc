"""A fleet in rotorpy that is told what its sensors see, and follows what a replanner answers."""

import math
from collections import deque
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from pydantic import ValidationError

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.flight.commands import COMMAND_RATE, HOVER_SECONDS, SETTLING_SECONDS, commanded
from skyverse.flight.controlled_uav import ControlledUAV
from skyverse.flight.draw_disturbances import draw
from skyverse.flight.feedforward import reference
from skyverse.flight.simulate import Samples, samples
from skyverse.flight.vehicle import Vehicle
from skyverse.flight.weather import Weather
from skyverse.live.replan import Replan
from skyverse.live.replanner import Replanner
from skyverse.live.sensor import HiddenObstacles, out_of_reach, seen_movers
from skyverse.live.sighting import Sighting
from skyverse.model.mission import Mission
from skyverse.model.mover import Doubt, Mover
from skyverse.model.mover_motions import WaypointMotion
from skyverse.model.quantities import derived
from skyverse.model.replanned_flight import Prediction, ReplanAnswer, ReplanStep
from skyverse.model.scenario import Scenario
from skyverse.model.sensor import Sensor
from skyverse.model.shapes import Shape
from skyverse.model.trajectory import Trajectory
from skyverse.model.wrong_values import complaint

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


class _Look(NamedTuple):
    """What the sensors of a fleet saw at an instant, where the UAVs were then, and the sample at which it arrives."""

    time: float
    arrives: int
    movers: tuple[Sighting, ...]
    obstacles: tuple[Shape, ...]
    states: dict[int, tuple[Floats, Floats]]


class ReplannedFleet:
    """A fleet in rotorpy that is told what its sensors see, and follows what a replanner answers.

    Parameters
    ----------
    replanner
        Of the mission.
    truth
        What there is; see `true_scenario`.
    sensor, vehicle, weather
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
        weather: Weather,
        margin: float,
        rng: np.random.Generator,
        longest: float,
    ) -> None:
        known = replanner.mission.scenario
        self.truth, self.ended = truth, 0.0
        self.arrivals: tuple[float | None, ...] = (None,) * len(known.uavs)
        self._replanner, self._sensor, self._vehicle, self._margin, self._rng = replanner, sensor, vehicle, margin, rng
        self._unknown = truth.movers[len(known.movers) :]
        self._numbers = {mover.name: number for number, mover in enumerate(truth.movers)}
        self._hidden = HiddenObstacles(known, truth.obstacles[len(known.obstacles) :])
        self._last = math.ceil(longest * COMMAND_RATE)
        seeds = rng.integers(2**62, size=len(known.uavs)).tolist()
        self._uavs = []
        for uav, seed in enumerate(seeds):
            told = commanded(known, _as_planned(replanner.mission, uav), vehicle, longest)
            drawn = draw(told, vehicle, weather, seed)
            self._uavs.append(ControlledUAV(vehicle, drawn, np.array(known.uavs[uav].start, dtype=np.float64)))

    def fly(self, on_progress: Callable[[int, int], None] | None) -> Iterator[ReplanStep]:
        """Fly until all UAVs have arrived and settled, or for the longest time; yield what was observed."""
        self._follow(-HOVER, 0)
        waiting: deque[_Look] = deque()
        k, looks, first = 0, 0, True
        while True:
            if k == self._sample_of(looks):
                waiting.append(self._look(k))
                looks += 1
            while waiting and waiting[0].arrives <= k:
                yield self._observe(waiting.popleft(), k, first)
                first = False
                if on_progress is not None:
                    on_progress(int(k / COMMAND_RATE), math.ceil(self._last / COMMAND_RATE))
            if k >= self._last or self._all_settled(k):
                break
            stop = min(self._sample_of(looks), self._last, waiting[0].arrives if waiting else self._last)
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
        return math.ceil(look * COMMAND_RATE / self._sensor.rate - 1e-9)

    def _follow(self, first: int, stop: int) -> None:
        """Let all UAVs fly the samples from one up to another one, by what the replanner last answered."""
        times = np.arange(first, stop) / COMMAND_RATE
        for number, uav in enumerate(self._uavs):
            uav.follow(reference(self._replanner.flown(number), self._vehicle, times, 1.0 / COMMAND_RATE))

    def _look(self, k: int) -> _Look:
        """Return what the sensors see at a sample."""
        t, places = k / COMMAND_RATE, np.array([uav.place for uav in self._uavs])
        seen = seen_movers(self._sensor, self._unknown, t, places, self._rng)
        states = {n: (uav.place.copy(), uav.velocity.copy()) for n, uav in enumerate(self._uavs) if not uav.lost}
        arrives = k + math.ceil(self._sensor.delay * COMMAND_RATE - 1e-9)
        return _Look(t, arrives, tuple(seen), tuple(self._hidden.seen(self._sensor, places)), states)

    def _observe(self, look: _Look, k: int, first: bool) -> ReplanStep:
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
        gone = out_of_reach(self._sensor, self.truth, replanner.predicted(), look.movers, replanner.horizon)
        answers = replanner.observe(look.time, movers=look.movers, obstacles=look.obstacles, states=far, gone=gone)
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
    if trajectory is not None:
        return trajectory.retimed(0.0)
    return Trajectory([0.0, 1.0], np.array([[mission.scenario.uavs[uav].start]]))  # type: ignore[arg-type]
