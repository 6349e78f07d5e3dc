"""One UAV's order of strips, and which way round it flies each."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.survey.strip_fleet import StripFleet
from skyverse.survey.strip_search import StripSearch

_NO_WAY = 1e9
"""Seconds that stand for no way at all, finite so that differences are numbers."""


class StripOrder(NamedTuple):
    """The order of strips in one route.

    Attributes
    ----------
    order
        Strips in the order flown (m,).
    flipped
        Of each in that order, whether it is flown from its second end to its first (m,).
    cost
        What the route costs, strips included; infinite if there is none.
    """

    order: Ints
    flipped: Bools
    cost: float


def order_strips(
    costs: Floats, strips: Ints, start: int, end: int | None, *, seed: int = 0, rounds: int = 1000
) -> StripOrder:
    """Order strips, and choose the direction of each, so that the whole route costs little.

    Parameters
    ----------
    costs
        What it costs to go from place to place (n, n), infinite where there is no way. From a strip's first end to its
        second, and back, it is what flying the strip costs.
    strips
        The places (m, 2) at which each strip has its first and second end.
    start, end
        The places where the route begins and ends; no end: wherever the last strip does.
    seed, rounds
        Of the kicks, and how many there are.
    """
    strips = np.asarray(strips, dtype=np.int64).reshape(-1, 2)
    if not len(strips):
        return StripOrder(strips[:, 0], np.empty(0, dtype=np.bool_), 0.0 if end is None else float(costs[start, end]))
    enter, leave, n = strips.ravel(), strips[:, ::-1].ravel(), strips.size
    legs = np.zeros((1, n + 3, n + 3))
    legs[0, :n, :n] = costs[np.ix_(leave, enter)]
    legs[0, n : n + 2, :n] = costs[start, enter]
    legs[0, :n, n + 1] = 0.0 if end is None else costs[leave, end]
    legs[0, :, :n] += costs[enter, leave]
    legs = np.minimum(legs, _NO_WAY)
    alone, limits = np.zeros(1, dtype=np.int64), np.array([(0.0, np.inf, np.inf, 0.0)])
    does, left = np.tile((0.0, 0.0, np.inf, 0.0), (n + 3, 1)), 10.0 * _NO_WAY
    numbers = legs, legs, legs, alone, alone == 0, limits, np.arange(n) ^ 1, does, np.arange(2), left, 10.0 * n * left
    fleet = StripFleet(*numbers, squares=0, swaps=0, simple=True)
    search = StripSearch(fleet, np.random.default_rng(seed))
    search.run(rounds)
    (((*visits,),),) = search.tours
    cost = search.value if search.value < _NO_WAY else np.inf
    return StripOrder(np.array(visits) // 2, np.array(visits) % 2 == 1, cost)
