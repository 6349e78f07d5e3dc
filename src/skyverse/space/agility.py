"""What aeroplanes can do: how tightly they turn, how steeply they climb, and how soon."""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.uav import UAV, FixedWing
from skyverse.numerics.kernel import by_reference
from skyverse.numerics.tolerances import ARC_MARGIN

TURNING_SHARE = 0.98
"""The share of `max_acceleration` that turns may take; the rest is for climbs."""
CLIMB_SHARE = 0.75
"""The share of its steepest slope by which an aeroplane climbs from one place where it is level to the next."""


@by_reference
class Agility(NamedTuple):
    """What the aeroplane can do, by metres of way.

    Attributes
    ----------
    radii
        Of its turns, metres, the least one first.
    slope
        The steepest slope of its climbs.
    rate
        The largest change of the slope for each metre of way, 1/m.
    """

    radii: Floats
    slope: float
    rate: float


def fixed_wing(uav: UAV) -> FixedWing:
    """Return the limits of an aeroplane, or raise `ValueError` if the UAV is none."""
    if uav.fixed_wing is None:
        raise ValueError(f"{uav.name or 'the UAV'} has no fixed_wing")
    return uav.fixed_wing


def agility_of(uav: UAV) -> Agility:
    """Return what an aeroplane can do, with turns of its least radius only."""
    wing = fixed_wing(uav)
    least = max(wing.turn_radius * (1.0 + ARC_MARGIN), wing.speed**2 / (TURNING_SHARE * uav.max_acceleration))
    vertical = math.sqrt(uav.max_acceleration**2 - (wing.speed**2 / least) ** 2)
    slope = math.tan(math.radians(wing.climb))
    return Agility(np.array([least]), slope * (1.0 - ARC_MARGIN), vertical / wing.speed**2 * (1.0 - ARC_MARGIN))


def link_of(uav: UAV) -> float:
    """Return the metres of way in which an aeroplane, level at both ends, rises by `CLIMB_SHARE` of its slope.

    On a longer way it can do so too, and on a shorter one by as much less as that is shorter.
    """
    able = agility_of(uav)
    return 1.5 * able.slope / (able.rate * (1.0 - CLIMB_SHARE))
