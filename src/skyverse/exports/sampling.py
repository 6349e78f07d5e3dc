"""Trajectories sampled at even intervals, and times as map formats write them."""

from datetime import UTC, datetime, timedelta
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, is_number
from skyverse.model.mission import Mission
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import SAME_INSTANT

MAX_SAMPLES = 1e6
EPOCH = datetime(2000, 1, 1, tzinfo=UTC)
"""The date and time that stand for second 0 of a mission, which has no date of its own."""


class SampledTrajectory(NamedTuple):
    """One UAV's trajectory: (n,) seconds into the mission; position, velocity and acceleration, (n, 3) each.

    The yaw, rad counterclockwise from east, its rate, rad/s, and the camera's pitch, rad, are (n,) each.
    """

    uav: int
    name: str
    seconds: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats
    yaw: Floats
    yaw_rate: Floats
    pitch: Floats


def sample_trajectories(mission: Mission, rate: float) -> list[SampledTrajectory]:
    """Return every trajectory sampled `rate` times a second, at its ends, and where its pieces meet."""
    if not (is_number(rate) and rate > 0):
        raise InputError(f"expected samples a second above 0, found {rate!r}", field="rate")
    made = []
    for k, (uav, trajectory) in enumerate(zip(mission.scenario.uavs, mission.trajectories, strict=True)):
        if trajectory is not None:
            t = instants(trajectory, rate)
            made.append(SampledTrajectory(k, uav.name, t, *trajectory.at(t), *trajectory.heading(t)))
    return made


def instants(trajectory: Trajectory, rate: float) -> Floats:
    """Return the times of the samples of a trajectory, (n,) seconds, rising."""
    count = (trajectory.end - trajectory.start) * rate
    if count > MAX_SAMPLES:
        raise InputError(
            f"expected at most {MAX_SAMPLES:g} samples a UAV, found {rate:g} a second, which is {count:.3g}",
            field="rate",
        )
    ticks = np.arange(np.ceil(trajectory.start * rate), np.floor(trajectory.end * rate) + 1) / rate
    t = np.unique(np.r_[trajectory.knots, ticks])
    return t[np.r_[True, np.diff(t) > SAME_INSTANT]]


def clock(seconds: float) -> str:
    """Return a time in seconds into the mission as a date in ISO 8601, to the microsecond."""
    when = EPOCH + timedelta(seconds=seconds)
    return when.strftime("%Y-%m-%dT%H:%M:%S.%fZ")
