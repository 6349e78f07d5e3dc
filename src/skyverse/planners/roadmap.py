"""A lazy roadmap: random points, and the prices of the legs between them as far as priced paths have shown them.

A priced path shows the price of each of its legs. The price of any other leg is assumed to be that of its length, which
is a lower bound. So the cheapest path over the roadmap either consists of known legs or is worth an evaluation. This is
the lazy shortest path of C. Dellin, S. Srinivasa, "A Unifying Formalism for Shortest Path Problems with Expensive Edge
Evaluations via Lazy Best-First Search over Paths with Edge Selectors", ICAPS 2016.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from skyverse import cost
from skyverse._typing import Bools, Floats, Ints
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.planners.moves import Workspace, exhausted
from skyverse.planners.polyline_moves import altitude_in_band, clamp_to_bounds, move_beside_threat
from skyverse.planners.straight_legs import Polylines, StraightTask, judge_legs
from skyverse.space.world import segment_free

_MAX_REDRAWS = 20
"""How many points are drawn anew, at most, until the cheapest path has a leg of unknown price."""


@by_reference
class Roadmap(NamedTuple):
    """Points, of which the first is the start and the second the goal, and the prices of the legs between them.

    Attributes
    ----------
    points
        (k, 3) metres.
    price
        (k, k) the price of each leg: that of its length where no path has shown it, infinite where it is not safe.
    known
        (k, k) whether a path has shown the price.
    """

    points: Floats
    price: Floats
    known: Bools


@kernel
def make_roadmap(task: StraightTask, U: Polylines, rng: Generator, size: int) -> Roadmap:
    """Return a roadmap of so many points: start, goal, the joints of the universes, and random ones."""
    roadmap = Roadmap(np.empty((size, 3)), np.full((size, size), math.inf), np.zeros((size, size), np.bool_))
    roadmap.points[0], roadmap.points[1] = task.start, task.goal
    roadmap.price[0, 1] = roadmap.price[1, 0] = _length_price(task, task.start, task.goal)
    k = 2
    for i in range(len(U.length)):
        for j in range(1, U.length[i] - 1):
            if k < size:
                roadmap.points[k] = U.points[i, j]
                _reset_legs(task, roadmap, k, k)
                k += 1
    for new in range(k, size):
        _redraw_point(task, roadmap, rng, new, new, U.points[0], 2)
    return roadmap


@inner
def _length_price(task: StraightTask, a: Floats, b: Floats) -> float:
    """Return the price of a leg's length, infinite where the leg is not safe."""
    if not segment_free(task.space, a, b):
        return math.inf
    return task.rates.metre * math.sqrt(((a - b) ** 2).sum())


@inner
def _reset_legs(task: StraightTask, roadmap: Roadmap, k: int, size: int) -> None:
    """Set the prices of the legs from point k to the first `size` points to those of their lengths."""
    for j in range(size):
        price = math.inf if j == k else _length_price(task, roadmap.points[j], roadmap.points[k])
        roadmap.price[j, k] = roadmap.price[k, j] = price
        roadmap.known[j, k] = roadmap.known[k, j] = False


@inner
def _redraw_point(
    task: StraightTask, roadmap: Roadmap, rng: Generator, k: int, size: int, path: Floats, n: int
) -> None:
    """Replace point k by a random one: near a joint of a path of n points, beside a threat, or anywhere."""
    space, rates = task.space, task.rates
    point = roadmap.points[k]
    near = n > 2 and rng.random() < 0.5
    j = 1 + int(rng.random() * (n - 2)) if near else 0
    reach = 0.2 * math.exp(-3.0 * rng.random())
    for axis in range(3):
        extent = space.high[axis] - space.low[axis]
        if near:
            point[axis] = path[j, axis] + reach * extent * rng.standard_normal()
        else:
            point[axis] = space.low[axis] + rng.random() * extent
    if not near:
        if rng.random() < 0.7:
            move_beside_threat(task, rng, point)
        if rates.altitude > 0.0 and rng.random() < 0.7:
            point[2] = altitude_in_band(rates, rng.random(), point)
    clamp_to_bounds(task, point)
    _reset_legs(task, roadmap, k, size)


@kernel
def explore_roadmap(
    task: StraightTask, workspace: Workspace, U: Polylines, best: Polylines, rng: Generator, roadmap: Roadmap
) -> bool:
    """Price as many paths as there are universes, each the cheapest for all that is known; keep the good ones.

    A path that is cheaper than the dearest universe replaces it.

    Returns
    -------
    bool
        Whether any path was worth pricing.
    """
    path, vertices = np.empty(U.points.shape[1:]), np.empty(U.points.shape[1], np.int64)
    for priced in range(len(U.length)):
        n = _next_path(task, rng, roadmap, path, vertices)
        if n == 0:
            return priced > 0
        if exhausted(workspace):
            return True
        price = judge_legs(task, workspace, best, path[:n])
        _record_prices(task, roadmap, path, vertices[:n])
        worst = np.argmax(U.cost)
        if price < U.cost[worst]:
            U.points[worst, :n] = path[:n]
            U.length[worst] = n
            U.cost[worst] = price
    return True


@inner
def _next_path(task: StraightTask, rng: Generator, roadmap: Roadmap, path: Floats, vertices: Ints) -> int:
    """Find the cheapest path that has a leg of unknown price.

    As long as the cheapest path has none, a random point that is not on it is drawn anew.

    Returns
    -------
    int
        How many points the path has: 0 if there is no such path.
    """
    size = len(roadmap.points)
    for _ in range(_MAX_REDRAWS):
        n = _cheapest_path(task, roadmap, vertices)
        for j in range(n):
            path[j] = roadmap.points[vertices[j]]
        for j in range(1, n):
            if not roadmap.known[vertices[j - 1], vertices[j]]:
                return n
        k = 2 + int(rng.random() * (size - 2))
        if not np.any(vertices[:n] == k):
            _redraw_point(task, roadmap, rng, k, size, path, n)
    return 0


@inner
def _record_prices(task: StraightTask, roadmap: Roadmap, path: Floats, vertices: Ints) -> None:
    """Record the prices of a priced path's legs, without turns and the end term, which belong to no single leg."""
    for j in range(1, len(vertices)):
        a, b = vertices[j - 1], vertices[j]
        shares = cost.legs(task.rates, path[j - 1 : j + 1], task.goal)
        roadmap.price[a, b] = roadmap.price[b, a] = shares.sum() - shares[2]
        roadmap.known[a, b] = roadmap.known[b, a] = True


@kernel
def _cheapest_path(task: StraightTask, roadmap: Roadmap, vertices: Ints) -> int:
    """Find the cheapest path from start to goal that has at most as many points as `vertices` has room for.

    ``least[h, b]`` is the least price of a path from the start to point b with at most h legs (Bellman and Ford):
    least[h, b] = min(least[h - 1, b], min over a of least[h - 1, a] + turn (if h > 1) + price[a, b]).

    Returns
    -------
    int
        How many points the path has, 0 if there is none.
    """
    size, most = len(roadmap.points), len(vertices)
    least = np.full((most, size), math.inf)
    before = np.full((most, size), -1)
    least[0, 0] = 0.0
    for hop in range(1, most):
        changed = False
        for b in range(1, size):
            least[hop, b] = least[hop - 1, b]
        for a in range(size):
            base = least[hop - 1, a]
            if a == 1 or base >= least[hop, 1] or (hop > 1 and base == least[hop - 2, a]):
                continue
            if hop > 1:
                base += task.rates.turn
            for b in range(1, size):
                price = base + roadmap.price[a, b]
                if price < least[hop, b]:
                    least[hop, b] = price
                    before[hop, b] = a
                    changed = True
        if not changed:
            break
    if not math.isfinite(least[hop, 1]):
        return 0
    b, n = 1, 0
    for h in range(hop, 0, -1):
        if before[h, b] >= 0:
            vertices[n] = b
            n += 1
            b = before[h, b]
    vertices[n] = 0
    vertices[: n + 1] = vertices[: n + 1][::-1].copy()
    return n + 1
