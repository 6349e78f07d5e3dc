"""A flight along straight legs, followed in small steps of its length, and how long it is inside movers.

The largest speed at a place is the least of what the corners allow there: that at the corner, raised by the distance
from it at the largest acceleration.
"""

import numpy as np

from movers import depth_at

REACH = 2.0
METRES = 1e-3


def allowed_at(corners, speed, acceleration):
    """The largest speed at each corner, (n,) m/s: none at the ends."""
    steps = np.diff(corners, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    ways = steps / lengths[:, None]
    angles = np.arccos(np.clip(np.sum(ways[1:] * ways[:-1], axis=1), -1, 1))
    reach = np.minimum(np.minimum(lengths[1:], lengths[:-1]) / 2, REACH)
    with np.errstate(divide="ignore"):
        turning = np.sqrt(acceleration * reach / np.sin(angles / 2))
    return np.r_[0.0, np.minimum(speed, turning), 0.0]


def flown(corners, speed, acceleration):
    """Instants (m,) after the departure, and the places (m, 3) of the flight then."""
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    at = np.r_[0.0, np.cumsum(lengths)]
    along = np.unique(np.r_[at, np.linspace(0, at[-1], max(int(at[-1] / METRES), 2000))])
    allowed = allowed_at(corners, speed, acceleration)
    speeds = np.sqrt(allowed[:, None] ** 2 + 2 * acceleration * np.abs(along - at[:, None])).min(axis=0)
    speeds = np.minimum(speeds, speed)
    instants = np.r_[0.0, np.cumsum(2 * np.diff(along) / (speeds[1:] + speeds[:-1]))]
    return instants, np.column_stack([np.interp(along, at, corners[:, axis]) for axis in range(3)])


def seconds_inside(movers, kept, corners, speed, acceleration, departs, stays, samples=20_000):
    """How many seconds the flight is inside movers, added up over them, by evenly spaced samples."""
    instants, places = flown(corners, speed, acceleration)
    sampled = np.linspace(0, instants[-1] + stays, samples)
    at = np.column_stack([np.interp(sampled, instants, places[:, axis]) for axis in range(3)])
    share = sum(float(np.mean(depth_at(mover, departs + sampled, at, kept) > 0)) for mover in movers)
    return share * (instants[-1] + stays)
