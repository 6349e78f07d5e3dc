"""Random places for a roadmap, and random changes of the best path, for descents to begin from."""

import math

import numpy as np
from numpy.random import Generator

from skyverse._typing import Floats
from skyverse.cost import Rates
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance
from skyverse.search.cheapest.bend_points import usual_altitude
from skyverse.space.obstacles import Space, in_bounds
from skyverse.space.world import point_free, segment_free

ATTEMPTS = 20
"""How often a place is drawn, at most, until it is one that a cheaper path may lead over."""
NEAR_JOINT, IN_BAND, ADDED = 0.5, 0.7, 0.3
"""The shares of places that are drawn beside a joint, of others that are at a usual altitude, and of added joints."""
FAR_BESIDE, FAR_MOVED = 8.0, 6.0
"""Lattice steps by which places are beside a joint, and joints are moved, at most, in the mean."""
DECAY = 3.0
"""Smaller steps are drawn as often as larger ones, down to exp(-3) of the largest."""


@inner
def draw_place(
    space: Space, rates: Rates, rng: Generator, best: Floats, least: float, steps: Floats, place: Floats
) -> bool:
    """Write into `place` a random one over which a path may cost less than `least`; tell whether there is one.

    It is free, and beside a joint of the best path (n, 3), or anywhere, mostly at a usual altitude.
    """
    for _ in range(ATTEMPTS):
        if rng.random() < NEAR_JOINT and len(best) > 2:
            j = 1 + int(rng.random() * (len(best) - 2))
            size = FAR_BESIDE * math.exp(-DECAY * rng.random())
            for axis in range(3):
                place[axis] = best[j, axis] + size * steps[axis] * rng.standard_normal()
        else:
            for axis in range(3):
                place[axis] = space.low[axis] + rng.random() * (space.high[axis] - space.low[axis])
            if rng.random() < IN_BAND:
                place[2] = usual_altitude(rates, best[0], best[-1], place[0], place[1], rng.random())
        if rates.metre * (distance(best[0], place) + distance(place, best[-1])) < least:
            return in_bounds(space, place) and point_free(space, place)
    return False


@inner
def changed_path(space: Space, rng: Generator, best: Floats, steps: Floats) -> Floats:
    """Return a path (n, 3) with one joint moved at random, or one more; empty where that is not free."""
    n = len(best)
    more = 1 if n == 2 or rng.random() < ADDED else 0
    i = 1 + int(rng.random() * (n - 2 + more))
    path = np.empty((n + more, 3))
    path[:i] = best[:i]
    path[i + more :] = best[i:]
    if more:
        share = rng.random()
        for axis in range(3):
            path[i, axis] = best[i - 1, axis] + share * (best[i, axis] - best[i - 1, axis])
    size = FAR_MOVED * math.exp(-DECAY * rng.random())
    for axis in range(3):
        path[i, axis] += size * steps[axis] * rng.standard_normal()
    if (
        in_bounds(space, path[i])
        and segment_free(space, path[i - 1], path[i])
        and segment_free(space, path[i], path[i + 1])
    ):
        return path
    return np.empty((0, 3))
