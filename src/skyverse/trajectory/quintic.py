"""Rest-to-rest quintics: the UAV stops at every waypoint, as in the thesis.

Along a segment of L metres that takes T seconds it moves by ``L (10 s^3 - 15 s^4 + 6 s^5)`` with ``s = t / T``. Its
speed is at most ``15/8 L / T``, and upwards or downwards ``15/8`` of the segment's rise by T; its acceleration is at
most ``10/sqrt(3) L / T^2`` forwards and backwards, and its jerk ``60 L / T^3``. The thesis takes T = 1.3 sqrt(L) s for
every UAV; here T is the shortest that keeps the UAV's limits.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import LIMIT_MARGIN, MIN_SEGMENT
from skyverse.trajectory.limits import GRAVITY, limits_of

_PEAK_SPEED = 15.0 / 8.0
_PEAK_ACCELERATION = 10.0 / math.sqrt(3.0)
_PEAK_JERK = 60.0
_SHAPE = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
"""Coefficients of the way along a segment, by powers of s."""


def rest_to_rest(waypoints: Floats, uav: UAV, start: float = 0.0) -> Trajectory:
    """Fly straight from waypoint to waypoint and stop at each.

    Parameters
    ----------
    waypoints
        (n, 3) metres; a single one for a UAV that stays where it is.
    uav
        A multirotor, whose limits are kept.
    start
        The first instant, seconds.

    Returns
    -------
    Trajectory
        One quintic piece for each segment; a single piece that does not move where the UAV stays.
    """
    points = np.asarray(waypoints, dtype=np.float64)
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    moving = lengths > MIN_SEGMENT
    if not moving.any():
        stay = np.zeros((1, 6, 3))
        stay[0, 0] = points[0]
        return Trajectory(np.array([start, start + 1.0]), stay)
    begins, steps, lengths = points[:-1][moving], steps[moving], lengths[moving]
    limits = limits_of(uav)
    durations = np.max(
        [
            _PEAK_SPEED * lengths / uav.max_speed,
            _PEAK_SPEED * steps[:, 2] / limits.ascent,
            _PEAK_SPEED * -steps[:, 2] / limits.descent,
            np.sqrt(_PEAK_ACCELERATION * lengths / _either_way(steps / lengths[:, None], uav)),
            np.cbrt(_PEAK_JERK * lengths / uav.max_jerk),
        ],
        axis=0,
    )
    durations *= 1.0 + LIMIT_MARGIN
    coefficients = _SHAPE[None, :, None] / durations[:, None, None] ** np.arange(6)[None, :, None] * steps[:, None, :]
    coefficients[:, 0] = begins
    return Trajectory(start + np.r_[0.0, np.cumsum(durations)], coefficients)


def _either_way(directions: Floats, uav: UAV) -> Floats:
    """Return the acceleration, (n,) m/s^2, that a multirotor may have both along and against unit vectors (n, 3)."""
    limits = limits_of(uav)
    up, level = np.abs(directions[:, 2]), np.hypot(directions[:, 0], directions[:, 1])
    by_thrust = np.sqrt((GRAVITY * up) ** 2 + limits.thrust**2 - GRAVITY**2) - GRAVITY * up
    by_tilt = limits.tilt * GRAVITY / np.maximum(level + limits.tilt * up, limits.tilt * up * GRAVITY / limits.fall)
    return np.minimum(limits.acceleration, np.minimum(by_thrust, by_tilt))
