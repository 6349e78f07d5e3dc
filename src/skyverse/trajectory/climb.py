"""How an aeroplane climbs or descends along its way: the slope rises smoothly from 0, is held, and falls to 0 again.

Along a ramp of r metres the slope rises as ``slope (3 u^2 - 2 u^3)`` with ``u = s / r`` after s metres, so that the
vertical acceleration does not jump. All lengths are metres of way seen from above.
"""

import math
from typing import NamedTuple

from skyverse.numerics.kernel import inner
from skyverse.numerics.tolerances import MIN_FLOWN

ALL_ALONG, AT_BEGINNING, AT_END = range(3)
"""Where along a leg its climb is flown; these are the profiles of a climb."""


class Climb(NamedTuple):
    """A change of height, level before and after.

    Attributes
    ----------
    begin
        The level way before it, metres.
    ramp
        The length of each of its two ramps, metres.
    hold
        The length at constant slope between the ramps, metres.
    slope
        Metres of height for each metre of way, negative for a descent.
    """

    begin: float
    ramp: float
    hold: float
    slope: float


@inner
def climb_length(rise: float, slope: float, rate: float) -> float:
    """Return the metres of way that a change of height takes at least.

    Parameters
    ----------
    rise
        The change of height, metres.
    slope
        The steepest slope.
    rate
        The largest change of the slope for each metre of way, 1/m.
    """
    if abs(rise) <= MIN_FLOWN:
        return 0.0
    ramp, hold = _steepest(abs(rise), slope, rate)
    return 2.0 * ramp + hold


@inner
def _steepest(rise: float, slope: float, rate: float) -> tuple[float, float]:
    """Return ramp and hold of the shortest climb, metres; see `climb_length`."""
    slope = min(slope, math.sqrt(rise * rate / 1.5))
    ramp = 1.5 * slope / rate
    return ramp, max(0.0, rise / slope - ramp)


@inner
def climb_along(rise: float, length: float, slope: float, rate: float, profile: int) -> Climb:
    """Return a change of height within a leg that is long enough for it, by a profile; see `climb_length`."""
    if abs(rise) <= MIN_FLOWN:
        return Climb(0.0, 0.0, 0.0, 0.0)
    up = abs(rise)
    if profile == ALL_ALONG:
        gentle = 2.0 * up / (length + math.sqrt(max(0.0, length * length - 6.0 * up / rate)))
        ramp = 1.5 * gentle / rate
        hold = max(0.0, length - 2.0 * ramp)
    else:
        ramp, hold = _steepest(up, slope, rate)
    begin = max(0.0, length - 2.0 * ramp - hold) if profile == AT_END else 0.0
    return Climb(begin, ramp, hold, rise / (ramp + hold))


@inner
def height_gained(climb: Climb, s: float) -> tuple[float, float, float, float, float]:
    """Return the height gained after s metres of way, and its first four derivatives by the way.

    Where a derivative jumps, its value is the one just after.
    """
    s -= climb.begin
    ramp, hold, slope = climb.ramp, climb.hold, climb.slope
    if s < 0.0 or slope == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    if s >= 2.0 * ramp + hold:
        return slope * (ramp + hold), 0.0, 0.0, 0.0, 0.0
    if ramp <= s < ramp + hold:
        return slope * (0.5 * ramp + s - ramp), slope, 0.0, 0.0, 0.0
    rising = s < ramp
    u = s / ramp if rising else (2.0 * ramp + hold - s) / ramp  # the second ramp is the first one backwards
    direction = 1.0 if rising else -1.0
    gained = slope * ramp * u * u * u * (1.0 - 0.5 * u)
    return (
        gained if rising else slope * (ramp + hold) - gained,
        slope * u * u * (3.0 - 2.0 * u),
        direction * slope * 6.0 * u * (1.0 - u) / ramp,
        slope * (6.0 - 12.0 * u) / (ramp * ramp),
        -direction * 12.0 * slope / (ramp * ramp * ramp),
    )
