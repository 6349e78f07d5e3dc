"""Routes along the strips of a sweep, place by place, so that others can judge them."""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from skyverse.survey.leg_time import LegTime
from skyverse.survey.strip_order import order_strips
from skyverse.survey.visibility import reflex_corners, way_prices

ROUNDS = 2000
SAME = 1e-12


class SweepRoute(NamedTuple):
    """The strips (m, 2, 2) as they are flown, what the route costs, and its legs: points (k, 2), one for no way."""

    strips: np.ndarray
    cost: float
    legs: list[np.ndarray]

    @property
    def points(self) -> np.ndarray:
        """All places at which it bends or a strip begins or ends, (n, 2)."""
        return np.concatenate([*(leg[:-1] for leg in self.legs), self.legs[-1][-1:]])


def sweep_route(strips: np.ndarray, free: Any, cost: LegTime, start: np.ndarray | None = None) -> SweepRoute:
    """Return a quick route along strips in free space, from a place and back, or from any strip to any other."""
    count, places = 2 * len(strips), strips.reshape(-1, 2)
    places = places if start is None else np.concatenate([places, start[None]])
    nodes = np.concatenate([places, reflex_corners(free)])
    every = way_prices(free, nodes, cost)
    prices = every[:count, :count] if start is None else every[: count + 1, : count + 1]
    prices = np.pad(prices, (0, 1)) if start is None else prices
    found = order_strips(prices, np.arange(count).reshape(-1, 2), count, count, rounds=ROUNDS)
    visits = np.stack([2 * found.order + found.flipped, 2 * found.order + 1 - found.flipped], 1)
    stops = visits.ravel().tolist() if start is None else [count, *visits.ravel().tolist(), count]
    return SweepRoute(places[visits], found.cost, [nodes[way(every, a, b)] for a, b in pairwise(stops)])


def way(prices: np.ndarray, start: int, end: int) -> list[int]:
    """Return the nodes of a cheapest way by the prices between all nodes; the start alone if there is none."""
    found = [start]
    while found[-1] != end and np.isfinite(prices[start, end]):
        at = found[-1]
        on = prices[at] + prices[:, end] <= prices[at, end] * (1 + SAME)
        on[found] = False
        left = np.flatnonzero(on)
        found.append(int(left[np.argmin(prices[at, left])]))
    return found
