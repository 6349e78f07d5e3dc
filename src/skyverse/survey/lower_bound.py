"""What no route along strips is faster than.

Two bounds, each proven for what it is said to hold for. With straight strips in whatever places and directions, a
strip of length l sees l times the width at most, and takes at least as long per metre as the longest one that fits.
With given strips, hops pair the ends of strips, the start and the end with one another, so that they cost no less than
the cheapest such pairs; half the cost of an assignment is a bound of that.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from skyverse._typing import Floats, Ints
from skyverse.survey.leg_time import LegTime

_NO_WAY = 1e9
"""Seconds that stand for no way at all."""


class SweepBound(NamedTuple):
    """Seconds that no route is faster than.

    Attributes
    ----------
    any_strips
        Along whatever straight strips that see, across them, as much as the plan's strips do; 0 with wind.
    these_strips
        Along the plan's strips, in whatever order and directions.
    """

    any_strips: float
    these_strips: float


def any_strips_bound(length: float, longest: float, cost: LegTime) -> float:
    """Return a bound for routes along any straight strips that see an area.

    The time of a leg over its length falls with the length, so that no strip is faster per metre than the longest one.

    Parameters
    ----------
    length
        The area that is seen over the width that strips see, metres.
    longest
        No strip is longer, metres.
    cost
        What legs take.
    """
    if cost.ground_speed is not None or length <= 0.0:
        return 0.0
    return length / longest * float(cost(np.array([longest, 0.0])))


def these_strips_bound(costs: Floats, strips: Ints, start: int, end: int) -> float:
    """Return a bound for routes along given strips, from a place to a place; parameters are those of `order_strips`."""
    strips = np.asarray(strips, dtype=np.int64).reshape(-1, 2)
    count = 2 * len(strips)
    if count == 0:
        return float(costs[start, end])
    places = np.r_[strips.ravel(), start, end]
    price = costs[np.ix_(places, places)]
    price = np.minimum(np.minimum(price, price.T), _NO_WAY)
    ends = np.arange(count + 2)
    flown = price[ends[:-2:2], ends[1:-2:2]].sum()
    price[ends, ends] = price[ends, ends ^ 1] = 2 * _NO_WAY  # no hop from a strip to itself, or from start to end
    bound = float(flown + 0.5 * price[linear_sum_assignment(price)].sum())
    return bound if bound < _NO_WAY else np.inf
