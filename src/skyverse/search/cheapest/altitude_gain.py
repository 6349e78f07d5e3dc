"""What a path pays for its climbs outside the altitude band, beside what its way over the map costs.

Let C be the price of a metre at some altitude, m that of a metre in the band, and f(t) that of a metre flown at the
angle t to the horizon. For each metre of altitude, a path pays at least

    q = min over t of (C + f(t) - m cos t) / sin t

more than m for each metre of its way over the map. The numerator is never negative, so that the rest of the path costs
at least m for each metre of its way.
"""

import math

from skyverse.cost import Rates
from skyverse.numerics.kernel import inner

LEVELS = 64
"""In how many levels altitudes outside the band are cut."""
HALVINGS = 50
"""How often the interval that holds the cheapest angle is halved."""


@inner
def altitude_gain(rates: Rates, start_z: float, goal_z: float, across: float, map_bound: float) -> float:
    """Return what a path costs at least.

    Parameters
    ----------
    rates
        The prices; the altitude band must not be above ground.
    start_z, goal_z
        The altitudes of its ends, metres.
    across
        The distance of its ends on the map, metres.
    map_bound
        What the way over the map costs at least, if no metre outside the band is dearer than one in it for being there.
    """
    below = _on_one_side(rates, rates.low - start_z, rates.low - goal_z, across, map_bound)
    return _on_one_side(rates, start_z - rates.high, goal_z - rates.high, across, below)


@inner
def _on_one_side(rates: Rates, start: float, goal: float, across: float, bound: float) -> float:
    """Return a bound raised by the climbs on one side of the band, from whose edge the ends are so many metres away.

    Where both ends are outside, the path may never reach the band. It then comes as near as some level, above which it
    climbs from both ends, and all of it is flown at the price of the next level or a higher one.
    """
    near, far = max(0.0, min(start, goal)), max(0.0, max(start, goal))
    between = _gain(rates, near, far)
    if near == 0.0:
        return bound + between
    least = math.inf
    climbed = 0.0
    for k in range(LEVELS):
        high, low = near * (LEVELS - k) / LEVELS, near * (LEVELS - k - 1) / LEVELS
        outside = (rates.metre + rates.altitude * low) * across
        least = min(least, max(bound + between + 2.0 * climbed, outside))
        climbed += (high - low) * _metre_of_altitude(rates, low)
    return min(least, bound + between + 2.0 * climbed)


@inner
def _gain(rates: Rates, near: float, far: float) -> float:
    """Return what it costs at least to climb from `far` to `near` metres outside the band."""
    gain = 0.0
    for k in range(LEVELS):
        gain += (far - near) / LEVELS * _metre_of_altitude(rates, near + (far - near) * k / LEVELS)
    return gain


@inner
def _metre_of_altitude(rates: Rates, outside: float) -> float:
    """Return q, see above, so many metres outside the band.

    Up to the angle without a price the numerator is least where cos t = m / C. Above it, the derivative has the sign of
    m + w sin t - (C + w (t - t0)) cos t, which grows with t; w is the price of a radian above the angle t0.
    """
    metre, dear = rates.metre, rates.metre + rates.altitude * outside
    best = math.acos(min(1.0, metre / dear))
    if rates.climb > 0.0 and best > rates.steepest:
        flat, steep = rates.steepest, best
        for _ in range(HALVINGS):
            best = (flat + steep) / 2
            slope = metre + rates.climb * math.sin(best)
            if slope < (dear + rates.climb * (best - rates.steepest)) * math.cos(best):
                flat = best
            else:
                steep = best
    if best <= 0.0:
        return 0.0
    dear += rates.climb * max(0.0, best - rates.steepest)
    return (dear - metre * math.cos(best)) / math.sin(best)


@inner
def is_counted(rates: Rates, start_z: float, goal_z: float) -> tuple[bool, bool]:
    """Tell whether `altitude_gain` counts altitudes below the band, and above it."""
    return min(start_z, goal_z) < rates.low, max(start_z, goal_z) > rates.high
