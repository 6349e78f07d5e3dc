"""Flights in which a replanner is told what sensors see, and UAVs fly exactly what it answers."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skyverse.errors import InputError
from skyverse.live.replan import Replan
from skyverse.live.sensor import HiddenObstacles, out_of_reach, seen_movers
from skyverse.live.sighting import Sighting
from skyverse.model.mission import Mission
from skyverse.model.mover import Mover
from skyverse.model.quantities import MAX_INSTANT
from skyverse.model.scenario import Scenario
from skyverse.model.sensor import Sensor
from skyverse.model.shapes import Shape
from skyverse.model.trajectory import Trajectory
from skyverse.planners.base import Seed, seeded

OnAnswers = Callable[[tuple[Replan, ...]], None]
"""Called with the answers to each observation."""


@dataclass(frozen=True, eq=False)
class Observation:
    """What the sensors of a fleet saw at an instant, seconds into the mission."""

    time: float
    movers: tuple[Sighting, ...]
    obstacles: tuple[Shape, ...]


class InFlight(Protocol):
    """A mission in flight, as a `Replanner` or a `PolicyFlight`: observations in, motions out."""

    @property
    def mission(self) -> Mission:
        """What is flown."""

    @property
    def lead(self) -> float:
        """Seconds from an observation at which a new motion begins."""

    @property
    def horizon(self) -> float:
        """Seconds from an observation up to which motions are proven."""

    def observe(
        self, t: float, *, movers: Sequence[Sighting], obstacles: Sequence[Shape], gone: Sequence[str]
    ) -> tuple[Replan, ...]:
        """Take in what was seen at an instant, and replan all UAVs."""

    def predicted(self) -> tuple[Mover, ...]:
        """Return the movers that are kept in mind."""

    def motion(self, uav: int) -> Trajectory:
        """Return what a UAV flies from now on."""

    def arrival(self, uav: int) -> float | None:
        """Return the instant at which a UAV's motion ends at its target, or ``None``."""


def fly_closed_loop(
    replanner: InFlight,
    truth: Scenario,
    sensor: Sensor,
    *,
    longest: float,
    rng: Seed = None,
    on_answers: OnAnswers | None = None,
) -> bool:
    """Fly a mission among what its sensors see, with ideal tracking, until all UAVs have arrived.

    Parameters
    ----------
    replanner
        Of the mission, or another that answers observations. Afterwards, its `flown` tells what was flown.
    truth
        The mission's scenario with all movers, which move as they state, and all obstacles that there are.
    sensor
        What UAVs see with.
    longest
        Seconds into the mission after which the flight is given up.
    rng
        Seed or generator of the sensor's errors.
    on_answers
        Called after each observation.

    Returns
    -------
    bool
        Whether all UAVs have arrived.

    Raises
    ------
    InputError
        If observations arrive after the motions that answer them would begin, or `longest` is out of range.
    """
    if not isinstance(truth, Scenario) or not isinstance(sensor, Sensor):
        found = type(sensor if isinstance(truth, Scenario) else truth).__name__
        raise InputError(f"expected a Scenario as the truth, and a Sensor, found a {found}")
    if not isinstance(longest, int | float) or not 0.0 < longest < MAX_INSTANT:
        raise InputError(f"expected seconds above 0, found {longest!r}", field="longest")
    if not sensor.delay < replanner.lead:
        expected = f"expected less than the replanner's lead, {replanner.lead:g} s"
        raise InputError(f"{expected}, but it is {sensor.delay:g} s", field="delay")
    generator, _ = seeded(rng)
    known, uavs = replanner.mission.scenario, range(len(replanner.mission.scenario.uavs))
    hidden = HiddenObstacles(known, [one for one in truth.obstacles if one not in known.obstacles])
    unknown = [one for one in truth.movers if one not in known.movers]
    waiting: deque[Observation] = deque()
    for k in range(int(longest * sensor.rate) + 1):
        t = k / sensor.rate
        places = np.array([replanner.motion(uav).at([t]).position[0] for uav in uavs])
        seen = seen_movers(sensor, unknown, t, places, generator)
        waiting.append(Observation(t, tuple(seen), tuple(hidden.seen(sensor, places))))
        while waiting and waiting[0].time + sensor.delay <= t:
            one = waiting.popleft()
            gone = out_of_reach(sensor, known, replanner.predicted(), one.movers, replanner.horizon)
            answers = replanner.observe(one.time, movers=one.movers, obstacles=one.obstacles, gone=gone)
            if on_answers is not None:
                on_answers(answers)
        arrivals = [replanner.arrival(uav) for uav in uavs]
        if all(arrival is not None and arrival <= t for arrival in arrivals):
            return True
    return False
