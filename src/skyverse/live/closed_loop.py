"""What a UAV's sensor sees of movers and of obstacles that nobody knew of.

Flights in which a replanner is told what sensors see, and UAVs fly exactly what it answers.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, require_kind, require_number
from skyverse.live.replan import Replan
from skyverse.live.replanner import Replanner
from skyverse.live.tracks import Sighting
from skyverse.model.conditions import Sensor
from skyverse.model.mover import Mover, MoverShape
from skyverse.model.mover_motions import motion_bounds
from skyverse.model.quantities import MAX_INSTANT, derived
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Shape, Sphere
from skyverse.numerics.tolerances import LIMIT_EASE
from skyverse.planners.base import Seed, seeded
from skyverse.space.world import World

LEAST_FLIGHT = 1e-3
"""Seconds into the mission up to which one is flown at least."""
LEAST_TOP_SPEED = 1e-3
"""M/s: the least top speed that a sighting may state."""


def seen_movers(
    sensor: Sensor, movers: Sequence[Mover], t: float, places: Floats, rng: np.random.Generator
) -> list[Sighting]:
    """Return sightings of the movers that are within range of UAVs at an instant.

    A sighting states the mover's largest speed and acceleration, which is how much its kind is known to do.

    Parameters
    ----------
    sensor
        What UAVs see with.
    movers
        As they truly move.
    t
        Seconds into the mission.
    places
        (n, 3) metres: where the UAVs are.
    rng
        Draws the errors, uniformly from a ball.
    """
    found = []
    for number, mover in enumerate(movers):
        at = mover.at([t])[0]
        if _distances(mover.shape, places - at).min(initial=np.inf) > sensor.reach:
            continue
        if sensor.error > 0.0:
            off = rng.normal(size=3)
            at = at + sensor.error * rng.uniform() ** (1.0 / 3.0) / math.hypot(*off) * off
        fastest, hardest = motion_bounds(mover.motion)
        found.append(
            Sighting(
                name=mover.name or f"mover {number}",
                shape=mover.shape,
                position=tuple(at.tolist()),
                error=sensor.error,
                top_speed=max(fastest, LEAST_TOP_SPEED),
                max_acceleration=hardest,
            )
        )
    return found


def out_of_reach(
    sensor: Sensor, scenario: Scenario, held: Sequence[Mover], seen: Sequence[Sighting], seconds: float
) -> list[str]:
    """Return the names of movers that no UAV can come too near to within some seconds, since they are out of range.

    Parameters
    ----------
    sensor, scenario
        What UAVs see with, and the UAVs.
    held
        Movers that are kept in mind.
    seen
        What was seen at an instant: all others are farther away from every UAV than the sensor's range.
    seconds
        From that instant on.
    """
    names = {one.name for one in seen}
    errors = [uav.tracking_error for uav in scenario.uavs]
    kept = scenario.clearance + max(math.hypot(error.horizontal, error.vertical) for error in errors)
    fastest = max(uav.max_speed for uav in scenario.uavs) * (1.0 + LIMIT_EASE)
    far = []
    for mover in held:
        doubt = mover.doubt
        speed = fastest + (doubt.growth if doubt.top_speed is None else doubt.top_speed)
        if mover.name not in names and sensor.reach > kept + seconds * speed:
            far.append(mover.name)
    return far


def _distances(shape: MoverShape, places: Floats) -> Floats:
    """Return how far places (n, 3) in a mover's frame are from its shape, or from the box around it, (n,) metres."""
    if isinstance(shape, Sphere):
        return np.maximum(np.linalg.norm(places - np.array(shape.centre), axis=1) - shape.radius, 0.0)
    return np.asarray(np.linalg.norm(places - np.clip(places, *extent(shape)), axis=1))


OnAnswers = Callable[[tuple[Replan, ...]], None]
"""Called with the answers to each observation."""


@dataclass(frozen=True, eq=False)
class Observation:
    """What the sensors of a fleet saw at an instant, seconds into the mission, and how its UAVs moved then."""

    time: float
    movers: tuple[Sighting, ...]
    obstacles: tuple[Shape, ...]
    states: Mapping[int, tuple[Floats, Floats]]


class FleetSensors:
    """What the sensors of a fleet see of all that a replanner does not know, which arrives there some time later.

    Parameters
    ----------
    replanner
        Of the mission.
    truth
        The mission's scenario with all movers, and all obstacles that there are: nobody knows of new ones until a UAV
        comes within range of them.
    sensor
        What UAVs see with.
    rng
        Draws the errors.

    Raises
    ------
    InputError
        If observations arrive after the motions that answer them would begin.
    """

    def __init__(self, replanner: Replanner, truth: Scenario, sensor: Sensor, rng: np.random.Generator) -> None:
        if not sensor.delay < replanner.lead:
            expected = f"expected less than the replanner's lead, {replanner.lead:g} s"
            raise InputError(f"{expected}, but it is {sensor.delay:g} s", field="Sensor.delay")
        known = replanner.mission.scenario
        bare = derived(known, zones=(), terrain=None, movers=())
        self.replanner, self.sensor, self._rng = replanner, sensor, rng
        self._unknown = [one for one in truth.movers if one not in known.movers]
        new = [one for one in truth.obstacles if one not in known.obstacles]
        self._hidden = [(one, World(derived(bare, obstacles=(one,)))) for one in new]
        self._waiting: deque[Observation] = deque()

    def look(self, t: float, places: Floats, states: Mapping[int, tuple[Floats, Floats]]) -> None:
        """See what is within range of UAVs at places (n, 3), metres, at an instant, seconds."""
        movers = seen_movers(self.sensor, self._unknown, t, places, self._rng)
        near = [world.distance(places).min() <= self.sensor.reach for _, world in self._hidden]
        found = tuple(one for (one, _), seen in zip(self._hidden, near, strict=True) if seen)
        self._hidden = [one for one, seen in zip(self._hidden, near, strict=True) if not seen]
        self._waiting.append(Observation(t, tuple(movers), found, states))

    @property
    def next_arrival(self) -> float:
        """The instant at which the next observation arrives, seconds; infinite if none is under way."""
        return self._waiting[0].time + self.sensor.delay if self._waiting else math.inf

    def arrived(self, t: float) -> Iterator[Observation]:
        """Yield the observations that have arrived by an instant, one after another."""
        while self.next_arrival <= t + 1e-9:
            yield self._waiting.popleft()

    def told(self, one: Observation, states: Mapping[int, tuple[Floats, Floats]]) -> tuple[Replan, ...]:
        """Tell the replanner of an observation, and of the states of some UAVs; return its answers."""
        replanner = self.replanner
        known = replanner.mission.scenario
        gone = out_of_reach(self.sensor, known, replanner.predicted(), one.movers, replanner.horizon)
        return replanner.observe(one.time, movers=one.movers, obstacles=one.obstacles, states=states, gone=gone)


def fly_closed_loop(
    replanner: Replanner,
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
        Of the mission. Afterwards, its `flown` tells what was flown.
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
    require_kind(replanner, Replanner, "replanner")
    require_kind(truth, Scenario, "truth")
    require_kind(sensor, Sensor, "sensor")
    require_number(longest, "longest", "seconds", LEAST_FLIGHT, MAX_INSTANT)
    uavs = range(len(replanner.mission.scenario.uavs))
    sensors = FleetSensors(replanner, truth, sensor, seeded(rng)[0])
    for k in range(int(longest * sensor.rate) + 1):
        t = k / sensor.rate
        sensors.look(t, np.array([replanner.motion(uav).at([t]).position[0] for uav in uavs]), {})
        for one in sensors.arrived(t):
            answers = sensors.told(one, {})
            if on_answers is not None:
                on_answers(answers)
        arrivals = [replanner.arrival(uav) for uav in uavs]
        if all(arrival is not None and arrival <= t for arrival in arrivals):
            return True
    return False
