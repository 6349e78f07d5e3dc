"""Changes of velocity along one direction, in the least time that acceleration and jerk allow.

A ramp changes the speed along a direction in three parts of constant jerk: the acceleration rises, is held, and falls
to 0 again. With the largest acceleration a and jerk j, a change of the speed by c takes

    a / j + c / a    where c is at least a^2 / j,    and    2 sqrt(c / j)    otherwise.

By symmetry the mean speed during a ramp is the mean of the speeds before and after it.
"""

import math

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner
from skyverse.numerics.tolerances import MIN_RAMP, MIN_SPEED_CHANGE
from skyverse.trajectory.limits import (
    ACCELERATION,
    SPEED,
    THROUGH_AIR,
    THRUST,
    TILT,
    VERTICAL_SPEED,
    Limits,
    used_share,
)

BISECTIONS = 60
"""How often an interval of speeds is halved."""


@inner
def largest_speed(limits: Limits, way: Floats) -> float:
    """Return the largest speed in a direction, a unit vector (3,), m/s."""
    used = used_share(limits, SPEED, way[0], way[1], way[2])
    used = max(used, used_share(limits, VERTICAL_SPEED, way[0], way[1], way[2]))
    return 1.0 / max(used, used_share(limits, THROUGH_AIR, way[0], way[1], way[2]))


@inner
def largest_acceleration(limits: Limits, way: Floats) -> float:
    """Return the largest acceleration of a multirotor in a direction, a unit vector (3,), m/s^2."""
    used = used_share(limits, ACCELERATION, way[0], way[1], way[2])
    used = max(used, used_share(limits, THRUST, way[0], way[1], way[2]))
    return 1.0 / max(used, used_share(limits, TILT, way[0], way[1], way[2]))


@inner
def ramp_parts(change: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Return the seconds for which the acceleration rises (and falls), and for which it is held, in a ramp.

    Parameters
    ----------
    change
        Of the speed, not negative, m/s.
    acceleration, jerk
        The largest ones, m/s^2 and m/s^3.
    """
    if change <= MIN_SPEED_CHANGE:
        return 0.0, 0.0
    rise = max(min(acceleration / jerk, math.sqrt(change / jerk)), MIN_RAMP)
    return rise, max(change / acceleration - rise, 0.0)


@inner
def ramp_seconds(change: float, acceleration: float, jerk: float) -> float:
    """Return the seconds that a ramp takes; see `ramp_parts`."""
    rise, hold = ramp_parts(change, acceleration, jerk)
    return 2.0 * rise + hold


@inner
def ramp_way(before: float, after: float, acceleration: float, jerk: float) -> float:
    """Return the metres that are covered while the speed along a straight line changes from one value to another."""
    return 0.5 * (before + after) * ramp_seconds(abs(after - before), acceleration, jerk)


@inner
def peak_speed(length: float, ends: tuple[float, float], most: float, rates: tuple[float, float, float]) -> float:
    """Return the largest speed on a straight line between two ramps.

    Parameters
    ----------
    length
        Metres, enough for one ramp from the first to the last speed.
    ends
        The first and the last speed, m/s.
    most
        The largest speed, m/s.
    rates
        The largest acceleration forwards and backwards, m/s^2, and the largest jerk, m/s^3.
    """
    low = max(ends[0], ends[1])
    high = max(low, most)  # by rounding, a speed at an end may be the larger one
    if both_ramps(ends, high, rates) <= length:
        return high
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if both_ramps(ends, middle, rates) <= length:
            low = middle
        else:
            high = middle
    return low


@inner
def both_ramps(ends: tuple[float, float], peak: float, rates: tuple[float, float, float]) -> float:
    """Return the metres that the ramps up to a peak speed and down from it cover; see `peak_speed`."""
    return ramp_way(ends[0], peak, rates[0], rates[2]) + ramp_way(peak, ends[1], rates[1], rates[2])
