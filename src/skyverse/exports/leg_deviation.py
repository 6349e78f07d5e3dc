"""How far the straight legs of autopilots are from straight lines in local metres."""

import math

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.model.geodesy import LEAST_RADIUS
from skyverse.model.scenario import Scenario

NEAR_POLE = math.radians(89.4)
"""The latitude, radians, up to which ArduPilot scales longitudes as they are."""
MARGIN = 1.1
"""By what a deviation that is reckoned on a sphere is multiplied."""


def leg_deviation(scenario: Scenario, lengths: ArrayLike) -> Floats:
    """Return how many metres legs (...) metres long may be flown beside straight lines, (...).

    PX4 flies straight on an azimuthal map about its home, ArduPilot in degrees that are scaled to metres, and DJI along
    geodesics. A leg of length d is off another line by d^2 / 8 times the difference of their curvatures. Between a
    geodesic and a straight line in degrees that is 1.16 tan(latitude) / R at most, what is off along the leg included,
    and between a geodesic and a straight line on a map r / R^2, where r is the distance from the map's origin, and R
    the Earth's radius. Altitudes change linearly along all of these lines.
    """
    origin, corners = scenario.frame.origin, np.abs([scenario.bounds.min, scenario.bounds.max])
    assert origin is not None
    far = math.hypot(*corners[:, :2].max(axis=0).tolist())
    latitude = math.radians(abs(origin.latitude)) + far / LEAST_RADIUS
    latitude = latitude if latitude < NEAR_POLE else math.pi / 2  # where nothing is known of legs
    # home, in the bounds as the leg is, is up to twice as far from it as the origin
    curvature = (1.16 * math.tan(latitude) + 3 * far / LEAST_RADIUS) / LEAST_RADIUS
    return np.asarray(MARGIN * curvature / 8 * np.asarray(lengths, dtype=np.float64) ** 2)
