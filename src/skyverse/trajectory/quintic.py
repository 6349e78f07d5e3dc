"""Rest-to-rest quintics: the UAV stands still at every waypoint, as the thesis flies it.

Along a segment of L metres it moves by ``L (10 s^3 - 15 s^4 + 6 s^5)``, ``s = t / T``: at most 15/8 L/T fast,
accelerating by at most 10/sqrt(3) L/T^2, either way, with a jerk of at most 60 L/T^3. The thesis takes
T = 1.3 sqrt(L) s, whatever the UAV can do; here T is the shortest that keeps its limits.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.trajectory.limits import GRAVITY, limits_of

_PEAK_SPEED = 15.0 / 8.0
_PEAK_ACCELERATION = 10.0 / math.sqrt(3.0)
_PEAK_JERK = 60.0
_STANDSTILL = 1e-12
"""Metres below which a segment is passed over: its duration would be lost in rounding."""
_SHAPE = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])


def rest_to_rest(waypoints: Floats, uav: UAV, start: float = 0.0) -> Trajectory:
    """Fly straight from waypoint to waypoint, standing still at each.

    Parameters
    ----------
    waypoints
        (n, 3) metres, n >= 2 unless the UAV is to stay where it is.
    uav
        A multirotor, whose limits to keep.
    start
        The first instant, seconds.

    Returns
    -------
    Trajectory
        One quintic piece a segment; a single piece of no motion for one waypoint.
    """
    points = np.asarray(waypoints, dtype=np.float64)
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    moving = lengths > _STANDSTILL
    if not moving.any():
        stay = np.zeros((1, 6, 3))
        stay[0, 0] = points[0]
        return Trajectory(np.array([start, start + 1.0]), stay)
    begins, steps, lengths = points[:-1][moving], steps[moving], lengths[moving]
    durations = np.max(
        [
            _PEAK_SPEED * lengths / uav.max_speed,
            np.sqrt(_PEAK_ACCELERATION * lengths / _either_way(steps / lengths[:, None], uav)),
            np.cbrt(_PEAK_JERK * lengths / uav.max_jerk),
        ],
        axis=0,
    )
    # rounding must not push a peak past its limit
    durations *= 1.0 + 1e-9
    coefficients = _SHAPE[None, :, None] / durations[:, None, None] ** np.arange(6)[None, :, None] * steps[:, None, :]
    coefficients[:, 0] = begins
    return Trajectory(start + np.r_[0.0, np.cumsum(durations)], coefficients)


def _either_way(directions: Floats, uav: UAV) -> Floats:
    """Return how hard a multirotor may accelerate both along unit vectors (n, 3) and against them, (n,) m/s^2."""
    limits = limits_of(uav)
    up, level = np.abs(directions[:, 2]), np.hypot(directions[:, 0], directions[:, 1])
    by_thrust = np.sqrt((GRAVITY * up) ** 2 + limits.thrust**2 - GRAVITY**2) - GRAVITY * up
    by_tilt = limits.tilt * GRAVITY / np.maximum(level + limits.tilt * up, limits.tilt * up * GRAVITY / limits.fall)
    hardest: Floats = np.minimum(limits.acceleration, np.minimum(by_thrust, by_tilt))
    return hardest
