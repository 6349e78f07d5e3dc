"""How far legs that are straight on the globe are off straight lines in local metres, because Earth is round."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.scenario import Origin

MIN_EARTH_RADIUS = 6_335_439.0
"""Metres: the least radius of curvature of the WGS84 ellipsoid."""
BEND_MARGIN = 1.1
"""By what a bend that is measured in the middle of a leg, or reckoned on a sphere, is multiplied."""


def bend(origin: Origin, ends: Floats) -> float:
    """Return how many metres a line between two ends, (2, 3) metres, bends because the Earth is round.

    It holds for great circles, which PX4 follows, and for straight lines in latitude and longitude.
    """
    level = math.hypot(*(ends[1] - ends[0])[:2])
    globe = to_wgs84(origin, ends)
    globe[:, 1] = np.unwrap(globe[:, 1], period=360)  # the shorter way, also across the antimeridian
    middle = to_local(origin, globe.mean(axis=0, keepdims=True))[0]
    return BEND_MARGIN * max(math.dist(middle, ends.mean(axis=0)), level**2 / (8 * MIN_EARTH_RADIUS))


def tilt(points: Floats) -> float:
    """Return a bound of the angle, radians, between z and the vertical at the farthest of points, (n, 3) metres."""
    return BEND_MARGIN * float(np.linalg.norm(points[:, :2], axis=1).max()) / MIN_EARTH_RADIUS
