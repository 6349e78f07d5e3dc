"""The cheapest paths that a search has found so far, each another, so that it does not keep to one of them."""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import by_reference, inner

PATHS_KEPT = 6
"""How many paths are kept."""
ALIKE = 2e-3
"""Relative: two paths whose prices differ by less count as the same one."""


@by_reference
class Elite(NamedTuple):
    """The cheapest paths so far, each another.

    Attributes
    ----------
    points
        (e, c, 3) metres.
    size
        (e,) how many points each has, 0 where there is none yet.
    price
        (e,) their prices.
    """

    points: Floats
    size: Ints
    price: Floats


@inner
def keep(elite: Elite, path: Floats, price: float) -> None:
    """Keep a path instead of one that costs about the same, or else of the dearest one, if it is cheaper than that."""
    if len(path) > elite.points.shape[1]:
        return
    k = np.argmax(elite.price)
    for j in range(len(elite.price)):
        if abs(elite.price[j] - price) < ALIKE * price:
            k = np.int64(j)
    if price < elite.price[k]:
        elite.points[k, : len(path)] = path
        elite.size[k], elite.price[k] = len(path), price


@inner
def no_elite(longest: int) -> Elite:
    """Return memory for paths of at most so many points, none of which is there yet."""
    return Elite(np.empty((PATHS_KEPT, longest, 3)), np.zeros(PATHS_KEPT, np.int64), np.full(PATHS_KEPT, math.inf))


@inner
def best_of(elite: Elite) -> Floats:
    """Return the cheapest path."""
    k = np.argmin(elite.price)
    return elite.points[k, : elite.size[k]]
