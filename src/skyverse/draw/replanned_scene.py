"""The scene of a replanned flight: what was known, seen, predicted and committed to, and when."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.scenes import MissionScene, flight_scene, scene
from skyverse.draw.shape_geometry import DrawnShape
from skyverse.model.mover import Mover
from skyverse.model.quantities import derived
from skyverse.model.replanned_flight import ReplannedFlight, ReplanStep
from skyverse.model.trajectory import Trajectory

Tick = Literal["kept", "replaced", "no way out"]
"""How an answer is marked on the time line."""
WAY_STEP = 0.05
"""Seconds between the samples of a motion."""
STILL = 1e-3
"""M/s below which a UAV counts as at rest."""


@dataclass(frozen=True, eq=False)
class CommittedWay:
    """What a UAV was committed to by one answer.

    Attributes
    ----------
    since
        The instant at which the answer was given, seconds into the mission.
    times, places
        (n,) seconds and (n, 3) metres, from the observation to rest.
    brakes
        The instant from which on the motion only brakes: its way out.
    """

    since: float
    times: Floats
    places: Floats
    brakes: float

    def ahead(self, t: float) -> tuple[Floats, Floats]:
        """Return what is left of the way at an instant, up to where it brakes and from there on, (n, 3) metres each."""
        turn = min(max(self.brakes, t), float(self.times[-1]))
        at = [np.array([np.interp(s, self.times, column) for column in self.places.T]) for s in (t, turn)]
        before, after = (self.times > t) & (self.times < turn), self.times > turn
        return np.vstack([at[0], self.places[before], at[1]]), np.vstack([at[1], self.places[after]])


@dataclass(frozen=True, eq=False)
class ReplannedScene:
    """What pictures of a replanned flight show besides the scene of its flight."""

    flight: ReplannedFlight

    @cached_property
    def scene(self) -> MissionScene:
        """The flight among the truth, without the obstacles that nobody knew of; see `flight_scene`."""
        there = self.flight.truth
        known = there.obstacles[: len(there.obstacles) - len(self.unknown)]
        return replace(flight_scene(self.flight), scenario=derived(there, obstacles=known))

    @cached_property
    def planned(self) -> tuple[tuple[str, Floats], ...]:
        """The name of each UAV, and its trajectory as the mission was planned, (n, 3) metres; empty without one."""
        tracks = scene(self.flight.mission).tracks
        return tuple((track.name, track.positions) for track in tracks)

    @property
    def unknown(self) -> tuple[DrawnShape, ...]:
        """The obstacles that nobody knew of."""
        return self.flight.truth.obstacles[len(self.flight.mission.scenario.obstacles) :]

    @cached_property
    def seen(self) -> tuple[float | None, ...]:
        """The instant at which each of the unknown obstacles became known, seconds; ``None`` for never."""
        first = len(self.flight.mission.scenario.obstacles)
        when = {number: step.arrival for step in self.flight.steps for number in step.obstacles}
        return tuple(when.get(first + number) for number in range(len(self.unknown)))

    @cached_property
    def committed(self) -> tuple[tuple[CommittedWay, ...], ...]:
        """What each UAV was committed to, in the order of the answers."""
        ways: list[list[CommittedWay]] = [[] for _ in self.flight.truth.uavs]
        for step in self.flight.steps:
            for answer in step.answers:
                if answer.motion is not None:
                    ways[answer.uav].append(_way(answer.motion, step))
        return tuple(map(tuple, ways))

    @cached_property
    def ticks(self) -> tuple[tuple[tuple[float, Tick], ...], ...]:
        """The marks on the time line of each UAV: when, and how it was answered."""
        return tuple(
            tuple((step.arrival, _tick(step, uav)) for step in self.flight.steps)
            for uav in range(len(self.flight.truth.uavs))
        )

    @cached_property
    def arrivals(self) -> Floats:
        """The instants at which observations arrived, (n,) seconds, rising."""
        return np.array([step.arrival for step in self.flight.steps])

    def way(self, uav: int, t: float) -> CommittedWay | None:
        """Return what a UAV is committed to at an instant; ``None`` before the first answer."""
        ways = self.committed[uav]
        given = [way for way in ways if way.since <= t + 1e-9]
        return given[-1] if given else None

    def predicted(self, t: float, ahead: float = 0.0) -> list[tuple[Mover, Floats, float]]:
        """Return what the replanner holds of movers at an instant: each, where its point will be, and the doubt.

        Parameters
        ----------
        t
            Seconds into the mission, at which the last observation counts that has arrived by then.
        ahead
            Seconds after it at which the movers are looked at.

        Returns
        -------
        list of tuple
            A mover, its predicted point (3,) metres, and how far it may be from there, metres.
        """
        k = int(np.searchsorted(self.arrivals, t + 1e-9)) - 1
        if k < 0:
            return []
        found = []
        for one in self.flight.steps[k].predictions:
            doubt = float(one.doubt.at(t + ahead)[0])
            found.append((self.flight.truth.movers[one.mover], one.motion.at([t + ahead])[0], doubt))
        return found


def _way(motion: Trajectory, step: ReplanStep) -> CommittedWay:
    """Return a motion from an observation on, sampled."""
    end = max(motion.end, step.time + WAY_STEP)
    times = np.linspace(step.time, end, int(np.ceil((end - step.time) / WAY_STEP)) + 1)
    moved = motion.at(times)
    speeds = np.linalg.norm(moved.velocity, axis=1)
    k = len(times) - 1
    while k > 0 and (speeds[k - 1] > speeds[k] + 1e-9 or speeds[k - 1] <= STILL):
        k -= 1
    return CommittedWay(step.arrival, times, moved.position, float(times[k]))


def _tick(step: ReplanStep, uav: int) -> Tick:
    answer = step.answers[uav]
    if not answer.proven:
        return "no way out"
    return "kept" if answer.kept else "replaced"
