"""A survey of a field: a few places, and the prices of legs between them that priced paths have shown.

A priced path shows the price of each of its legs. A leg that no path has shown yet is taken for its length; so the
cheapest way is either one that is known, or one worth pricing: the lazy shortest path of C. Dellin, S. Srinivasa, "A
Unifying Formalism for Shortest Path Problems with Expensive Edge Evaluations via Lazy Best-First Search over Paths with
Edge Selectors", ICAPS 2016.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.joints import beside, hold, in_band
from skyverse.planners.moves import Desk, exhausted
from skyverse.planners.straight import Course, Polylines, judge_legs
from skyverse.space.world import segment_free

_FRUITLESS = 20
"""How many places are renewed until one of them asks for an evaluation."""


class Survey(NamedTuple):
    """What is known of the legs between some places, the first of which is the start, the second the goal.

    Attributes
    ----------
    places
        (k, 3) metres.
    price
        (k, k) the price of each leg: its length's where it is not known, infinite where it is not safe.
    known
        (k, k) whether a path has shown the price.
    """

    places: Floats
    price: Floats
    known: NDArray[np.bool_]


@kernel
def open_survey(course: Course, U: Polylines, rng: np.random.Generator, size: int) -> Survey:
    """Lay out a survey of so many places: start, goal, the joints of the universes that are there, others drawn."""
    survey = Survey(np.empty((size, 3)), np.full((size, size), math.inf), np.zeros((size, size), np.bool_))
    survey.places[0], survey.places[1] = course.start, course.goal
    survey.price[0, 1] = survey.price[1, 0] = _length(course, course.start, course.goal)
    k = 2
    for i in range(len(U.length)):
        for j in range(1, U.length[i] - 1):
            if k < size:
                survey.places[k] = U.points[i, j]
                _measure(course, survey, k, k)
                k += 1
    for place in range(k, size):
        _renew(course, survey, rng, place, place, U.points[0], 2)
    return survey


@inner
def _length(course: Course, a: Floats, b: Floats) -> float:
    if not segment_free(course.space, a, b):
        return math.inf
    return course.rates.metre * math.sqrt(((a - b) ** 2).sum())


@inner
def _measure(course: Course, survey: Survey, k: int, size: int) -> None:
    """Forget the legs of place k, to all places before `size`."""
    for j in range(size):
        price = math.inf if j == k else _length(course, survey.places[j], survey.places[k])
        survey.price[j, k] = survey.price[k, j] = price
        survey.known[j, k] = survey.known[k, j] = False


@inner
def _renew(course: Course, survey: Survey, rng: np.random.Generator, k: int, size: int, path: Floats, n: int) -> None:
    """Draw place k anew: near a joint of a path (n,), beside a threat, or anywhere."""
    space, rates = course.space, course.rates
    place = survey.places[k]
    near = n > 2 and rng.random() < 0.5
    j = 1 + int(rng.random() * (n - 2)) if near else 0
    reach = 0.2 * math.exp(-3.0 * rng.random())
    for axis in range(3):
        far = space.high[axis] - space.low[axis]
        if near:
            place[axis] = path[j, axis] + reach * far * rng.standard_normal()
        else:
            place[axis] = space.low[axis] + rng.random() * far
    if not near:
        if rng.random() < 0.7:
            beside(course, rng, place)
        if rates.altitude > 0.0 and rng.random() < 0.7:
            place[2] = in_band(rates, rng.random(), place)
    hold(course, place)
    _measure(course, survey, k, size)


@kernel
def explore(
    course: Course, desk: Desk, U: Polylines, best: Polylines, rng: np.random.Generator, survey: Survey
) -> bool:
    """Price as many ways as there are universes, each the cheapest for all that is known; the best become universes.

    Returns
    -------
    bool
        Whether any way was worth pricing.
    """
    path, way = np.empty(U.points.shape[1:]), np.empty(U.points.shape[1], np.int64)
    for priced in range(len(U.length)):
        n = _open_way(course, rng, survey, path, way)
        if n == 0:
            return priced > 0
        if exhausted(desk):
            return True
        price = judge_legs(course, desk, best, path[:n])
        _note(course, survey, path, way[:n])
        worst = np.argmax(U.cost)
        if price < U.cost[worst]:
            U.points[worst, :n] = path[:n]
            U.length[worst] = n
            U.cost[worst] = price
    return True


@inner
def _open_way(course: Course, rng: np.random.Generator, survey: Survey, path: Floats, way: Ints) -> int:
    """Find the cheapest way with a leg that is not known; while it is all known, draw a place anew that is not on it.

    Returns
    -------
    int
        How many points the path has: 0 if there is no such way.
    """
    size = len(survey.places)
    for _ in range(_FRUITLESS):
        n = _cheapest(course, survey, way)
        for j in range(n):
            path[j] = survey.places[way[j]]
        for j in range(1, n):
            if not survey.known[way[j - 1], way[j]]:
                return n
        k = 2 + int(rng.random() * (size - 2))
        if not np.any(way[:n] == k):
            _renew(course, survey, rng, k, size, path, n)
    return 0


@inner
def _note(course: Course, survey: Survey, path: Floats, way: Ints) -> None:
    """Note the prices that a path has shown; turns are none of a leg's."""
    for j in range(1, len(way)):
        a, b = way[j - 1], way[j]
        shares = cost.legs(course.rates, path[j - 1 : j + 1], course.goal)
        survey.price[a, b] = survey.price[b, a] = shares.sum() - shares[2]
        survey.known[a, b] = survey.known[b, a] = True


@kernel
def _cheapest(course: Course, survey: Survey, way: Ints) -> int:
    """Find the cheapest way from start to goal that there is room for; return how many places it has, 0 if none."""
    size, room = len(survey.places), len(way)
    least = np.full((room, size), math.inf)
    before = np.full((room, size), -1)
    least[0, 0] = 0.0
    for hop in range(1, room):
        changed = False
        for b in range(1, size):
            least[hop, b] = least[hop - 1, b]
        for a in range(size):
            base = least[hop - 1, a]
            if a == 1 or base >= least[hop, 1] or (hop > 1 and base == least[hop - 2, a]):
                continue
            if hop > 1:
                base += course.rates.turn
            for b in range(1, size):
                price = base + survey.price[a, b]
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
            way[n] = b
            n += 1
            b = before[h, b]
    way[n] = 0
    way[: n + 1] = way[: n + 1][::-1].copy()
    return n + 1
