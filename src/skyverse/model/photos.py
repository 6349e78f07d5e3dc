"""Photos: where a camera is and how it is turned when each is taken; those that a mission takes along its strips."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.errors import InputError, require_kind
from skyverse.model.arrays import ArrayRecord, arctan2
from skyverse.model.mission import Mission
from skyverse.model.short_lines import counted
from skyverse.model.sortie import Strip
from skyverse.model.trajectory import Trajectory

STEPS_IN_PIECE = 64
"""Samples in each polynomial piece of a trajectory from which the length of the way is found."""

SAME_COURSE = 5.0
"""Degrees by which the ways from photo to photo differ that are of strips in one direction."""


@dataclass(frozen=True, eq=False)
class Photos(ArrayRecord):
    """Photos, in the order in which they are taken by each UAV.

    Attributes
    ----------
    position
        (n, 3) metres.
    heading, pitch, roll
        (n,) degrees: where the top of the picture points, or the optical axis where it is not upright, clockwise from
        north; the optical axis above the horizon, -90 straight down; and how far the picture is turned clockwise.
    time
        (n,) seconds into the mission; NaN where it is not known.
    uav, strip
        (n,) the index of the UAV, and the number of the strip among all of its strips; -1 where there is none.
    name
        (n,) what each is called in its file, such as the name of the picture; empty where it has no name.
    """

    position: Floats
    heading: Floats
    pitch: Floats
    roll: Floats
    time: Floats
    uav: Ints
    strip: Ints
    name: NDArray[np.str_] = field(default_factory=lambda: np.array(""))

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", np.broadcast_to(self.name, len(self)))
        super().__post_init__()

    def __len__(self) -> int:
        return len(self.position)

    @property
    def frames(self) -> Floats:
        """Where the cameras look, and where the right and the top of their pictures are: (n, 3, 3)."""
        heading, pitch, roll = (np.radians(angle) for angle in (self.heading, self.pitch, self.roll))
        none = np.zeros(len(self))
        ahead, up = np.stack([np.sin(heading), np.cos(heading), none], axis=1), np.array([0.0, 0.0, 1.0])
        rise, level = np.sin(pitch)[:, None], np.cos(pitch)[:, None]
        axis, top = level * ahead + rise * up, level * up - rise * ahead
        right = np.stack([np.cos(heading), -np.sin(heading), none], axis=1)
        turned, straight = np.sin(roll)[:, None], np.cos(roll)[:, None]
        return np.stack([axis, straight * right - turned * top, straight * top + turned * right], axis=1)

    def taken(self, which: Ints) -> "Photos":
        """Return some of the photos, by their numbers or by a truth value for each."""
        return Photos(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def joined(self, more: "Photos") -> "Photos":
        """Return these photos, and more that were taken after them."""
        return Photos(
            *(np.concatenate([getattr(one, name) for one in (self, more)]) for name in self.__dataclass_fields__)
        )

    @property
    def direction(self) -> float | None:
        """Of most strips, degrees clockwise from north, below 180; ``None`` where there is but one photo."""
        steps = np.diff(self.position[:, :2], axis=0)
        steps = steps[np.hypot(*steps.T) > 0]
        if not len(steps):
            return None
        course = np.degrees(arctan2(*steps.T)) % 180.0
        off = np.abs((course[:, None] - course + 90.0) % 180.0 - 90.0)
        most = course[(off < SAME_COURSE).sum(axis=1).argmax()]
        near = (course - most + 90.0) % 180.0 - 90.0
        return float((most + np.median(near[np.abs(near) < SAME_COURSE])) % 180.0)


def strips_of(mission: Mission, survey: int | None = None) -> Iterator[tuple[int, int, Strip]]:
    """Yield the strips of a mission, each with its UAV and its number among that UAV's strips; those of one survey."""
    for uav in range(len(mission.scenario.uavs)):
        strips = [strip for sortie in mission.sorties_of(uav) for strip in sortie.strips]
        yield from ((uav, number, one) for number, one in enumerate(strips) if survey in (None, one.survey))


def photos_of(mission: Mission, survey: int | None = None) -> Photos:
    """Return the photos of a mission, or those of one of its surveys, by its index.

    Raises
    ------
    InputError
        If it is no mission, or has no such survey.
    """
    require_kind(mission, Mission, "mission")
    if survey is not None and survey not in range(len(mission.scenario.surveys)):
        many = counted(len(mission.scenario.surveys), "survey")
        raise InputError(f"expected the index of one of {many}, found {survey!r}", field="survey")
    rows: list[Floats] = []
    for uav, number, strip in strips_of(mission, survey):
        trajectory = mission.trajectories[uav]
        if trajectory is None:
            continue
        times = photo_times(trajectory, strip)
        motion = trajectory.at(times)
        if strip.heading is not None:
            ahead = np.full(len(times), strip.heading)
        elif mission.scenario.uavs[uav].fixed_wing is not None and mission.scenario.wind is not None:
            through_air = motion.velocity - mission.scenario.wind.at(motion.position[:, 2])
            ahead = np.degrees(arctan2(through_air[:, 0], through_air[:, 1])) % 360.0
        else:
            ahead = _course(trajectory, strip, times)
        alike = np.tile([strip.pitch, 0.0, uav, number], (len(times), 1))
        rows.append(np.column_stack([motion.position, ahead, times, alike]))
    table = np.concatenate(rows) if rows else np.zeros((0, 9))
    heading, time, pitch, roll, uavs, numbers = table[:, 3:].T
    return Photos(table[:, :3], heading, pitch, roll, time, uavs.astype(np.int64), numbers.astype(np.int64))


def photo_times(trajectory: Trajectory, strip: Strip) -> Floats:
    """Return when the photos of a strip are taken, (n,) seconds: every so many metres of the way seen from above.

    The first is taken where the strip begins, and one where it ends.
    """
    if strip.every <= 0 or strip.end <= strip.begin:
        return np.array([strip.begin])
    way, t = _way(trajectory, strip)
    count = round(way[-1] / strip.every)
    return np.interp(np.linspace(0.0, way[-1], count + 1), way, t)


def _way(trajectory: Trajectory, strip: Strip) -> tuple[Floats, Floats]:
    """Return metres flown along a strip, seen from above, and when, seconds."""
    t = trajectory.instants(STEPS_IN_PIECE, strip.begin, strip.end)
    at = trajectory.at(t).position[:, :2]
    return np.r_[0.0, np.cumsum(np.hypot(*np.diff(at, axis=0).T))], t


def _course(trajectory: Trajectory, strip: Strip, times: Floats) -> Floats:
    """Return where a UAV flies to at some instants of a strip, degrees clockwise from north, also where it stands."""
    way, t = _way(trajectory, strip)
    at, near = np.interp(times, t, way), 0.01 * way[-1]
    before, after = (
        trajectory.at(np.interp(np.clip(at + off, 0.0, way[-1]), way, t)).position for off in (-near, near)
    )
    east, north = (after - before)[:, :2].T
    return np.degrees(arctan2(east, north)) % 360.0
