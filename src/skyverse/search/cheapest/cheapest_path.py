"""The cheapest path of straight legs that a roadmap and descents find.

The roadmap holds places where cheap paths may bend: around obstacles and zones, random ones, and where the paths bend
that are known already. Ways over it, each another than those before, are made cheaper by descent, and so are random
changes of the best path. The joints of good paths become points of the roadmap, so that good parts of several paths are
joined.
"""

import numpy as np
from numpy.random import Generator

from skyverse._typing import Bools, Floats, Ints
from skyverse.cost import Rates
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance
from skyverse.numerics.tolerances import SEARCH_GAIN
from skyverse.search.cheapest.bend_points import bend_points
from skyverse.search.cheapest.descent import descend
from skyverse.search.cheapest.elite import Elite, best_of, keep, no_elite
from skyverse.search.cheapest.random_changes import changed_path, draw_place
from skyverse.search.cheapest.roadmap import (
    GOAL,
    START,
    BendRoadmap,
    add_point,
    cheapest_ways,
    make_roadmap,
    way_over,
    way_to,
)
from skyverse.space.obstacles import Space

PATHS, LEGS = 0, 1
"""Where it is counted how many paths were made, and how many legs were priced."""
POINTS, ROOM = 300, 400
"""How many places around obstacles and zones the roadmap holds, about, and how many other points may be added."""
GAP, NEAR, APART = 0.1, 0.05, 2.0
"""Lattice steps: how far those places are from what they are around; up to where two points count as one; and up to
where points count as beside those of a way."""
WAYS, DRAWN, CHANGES = 16, 10, 8
"""How many ways are tried in a round, then how many random places are added, and random changes are tried."""
IDLE = 20
"""After so many rounds in a row that find nothing the search ends."""
WORTH, IN_VAIN = 5e-4, 0.2
"""The search also ends when as many legs as before the last gain of such a share, and this part of all, gained none."""
LONGEST_WAY = 64
"""Points of a way, at most."""
DEARER, FORGOTTEN = 0.08, 0.95
"""By what share a way makes legs dearer beside its joints, so that the next one is another; and which share of that is
kept from round to round."""
COARSE, FINE, FINEST = 0.2, 0.02, 0.001
"""The smallest steps of descents, in lattice steps: of all ways, of good ones, and of the answer."""
GOOD, PROMISING = 1.05, 1.15
"""A way that costs at most so many times the best is descended finely, and gives its joints to the roadmap."""
QUICK, THOROUGH = 4_000, 1_000_000
"""Legs that are priced in one descent, at most: of a way, and of the answer."""


@kernel
def cheapest_path(
    space: Space,
    rates: Rates,
    known: Floats,
    lengths: Ints,
    steps: Floats,
    enough: float,
    spend: int,
    rng: Generator,
) -> tuple[Floats, Ints]:
    """Return a cheap path with the same ends as some known ones.

    Parameters
    ----------
    space, rates
        What must be kept clear of, and what is priced.
    known, lengths
        (n, 3) metres: the points of one or more free paths, one after the other, and how many each has.
    steps
        (3,) metres: the steps of the lattice, by which joints move at first.
    enough
        A price at which the search ends.
    spend
        After about so many priced legs the search for other ways ends.
    rng
        For random places and changes.

    Returns
    -------
    path
        (k, 3) metres.
    spent
        (2,) see `PATHS` and `LEGS`.
    """
    spent = np.zeros(2, np.int64)
    longest = lengths.max() + LONGEST_WAY
    elite = no_elite(2 * longest)
    joints = np.empty((0, 3))
    first = 0
    for count in lengths:
        path, price, legs = descend(space, rates, known[first : first + count], steps, FINE, THOROUGH // 4)
        first += count
        spent[PATHS] += 1
        spent[LEGS] += legs
        joints = np.concatenate((joints, path[1:-1]))
        keep(elite, path, price)
    best, least = best_of(elite), elite.price.min()
    around = bend_points(space, rates, best[0], best[-1], GAP * steps[0], POINTS)
    roadmap = make_roadmap(space, rates, best[0], best[-1], 2 + len(joints) + len(around) + ROOM)
    for places in (joints, around):
        spent[LEGS] += _add(space, rates, roadmap, places, steps, least)
    tried, dearer = np.empty(0, np.int64), np.zeros(len(roadmap.points))
    idle, gained = 0, spent[LEGS]
    while spent[LEGS] < min(spend, 2 * gained + int(IN_VAIN * spend)) and least > enough and idle < IDLE:
        price = least
        tried = _try_ways(space, rates, roadmap, steps, elite, tried, dearer, spent)
        dearer *= FORGOTTEN
        _try_changes(space, rates, roadmap, steps, elite, spent, rng)
        least = elite.price.min()
        idle = 0 if least < price * (1.0 - SEARCH_GAIN) else idle + 1
        if least < price * (1.0 - WORTH):
            gained = spent[LEGS]
    path, _, legs = descend(space, rates, best_of(elite), steps, FINEST, THOROUGH)
    spent[LEGS] += legs
    return path, spent


@inner
def _add(space: Space, rates: Rates, roadmap: BendRoadmap, places: Floats, steps: Floats, least: float) -> int:
    """Add places (n, 3) to the roadmap; return how many legs were priced."""
    priced = 0
    for place in places:
        priced += add_point(space, rates, roadmap, place, NEAR * steps[0], least)
    return priced


@inner
def _try_ways(
    space: Space,
    rates: Rates,
    roadmap: BendRoadmap,
    steps: Floats,
    elite: Elite,
    tried: Ints,
    dearer: Floats,
    spent: Ints,
) -> Ints:
    """Descend from ways over the roadmap, each another than those tried; return those that are tried then.

    By turns it is the cheapest way where legs beside earlier ways are dearer, and the cheapest over a point that is on
    none of them.
    """
    capacity = len(roadmap.points)
    as_it_is, used = np.zeros(capacity), np.zeros(capacity, np.bool_)
    to, back, before, after = (
        np.empty(capacity),
        np.empty(capacity),
        np.empty(capacity, np.int64),
        np.empty(capacity, np.int64),
    )
    first = np.empty(capacity, np.int64)
    way = np.empty(LONGEST_WAY, np.int64)
    cheapest_ways(roadmap, rates.turn, as_it_is, START, to, before)
    cheapest_ways(roadmap, rates.turn, as_it_is, GOAL, back, after)
    over = np.argsort(to[: roadmap.size[0]] + back[: roadmap.size[0]])
    for turn in range(WAYS):
        if turn % 2 == 0:
            cheapest_ways(roadmap, rates.turn, dearer, START, np.empty(capacity), first)
            size = way_to(first, GOAL, way)
            _make_dearer(roadmap, way[:size], APART * steps[0], dearer)
        else:
            size = _way_over_unused(over, before, after, used, way)
        for point in way[:size]:
            used[point] = True
        name = _name(way[:size])
        if size < 3 or np.any(tried == name):
            continue
        tried = np.append(tried, name)
        path, price, legs = descend(space, rates, roadmap.points[way[:size]], steps, COARSE, QUICK)
        spent[PATHS] += 1
        spent[LEGS] += legs
        least = elite.price.min()
        if price < GOOD * least:
            path, price, legs = descend(space, rates, path, steps, FINE, QUICK)
            spent[LEGS] += legs
        keep(elite, path, price)
        if price < PROMISING * least:
            spent[LEGS] += _add(space, rates, roadmap, path[1:-1], steps, least)
    return tried


@inner
def _make_dearer(roadmap: BendRoadmap, way: Ints, near: float, dearer: Floats) -> None:
    """Make legs dearer at all points that are near the joints of a way, metres."""
    for j in way[1:-1]:
        for k in range(2, roadmap.size[0]):
            if distance(roadmap.points[k], roadmap.points[j]) < near:
                dearer[k] += DEARER


@inner
def _way_over_unused(over: Ints, before: Ints, after: Ints, used: Bools, way: Ints) -> int:
    """Write into `way` the one over the first point of `over` that is not used; return its size, 0 if there is none."""
    for point in over:
        if not used[point] and point not in (START, GOAL):
            used[point] = True
            return way_over(before, after, point, way)
    return 0


@inner
def _name(way: Ints) -> int:
    """Return a number that hardly any other way has."""
    name = 0
    for point in way:
        name = (name * 1_000_003 + point) % 2_305_843_009_213
    return name


@inner
def _try_changes(
    space: Space,
    rates: Rates,
    roadmap: BendRoadmap,
    steps: Floats,
    elite: Elite,
    spent: Ints,
    rng: Generator,
) -> None:
    """Add random places to the roadmap, and descend from random changes of the best paths."""
    best = best_of(elite)
    least = elite.price.min()
    place = np.empty((1, 3))
    for _ in range(DRAWN):
        if draw_place(space, rates, rng, best, least, steps, place[0]):
            spent[LEGS] += _add(space, rates, roadmap, place, steps, least)
    for _ in range(CHANGES):
        k = np.argsort(elite.price)[int(rng.random() * rng.random() * len(elite.size))]
        spent[LEGS] += 1  # so that it ends where nothing is free
        if elite.size[k] == 0:
            continue
        path = changed_path(space, rng, elite.points[k, : elite.size[k]], steps)
        if len(path) == 0:
            continue
        path, price, legs = descend(space, rates, path, steps, FINE, QUICK)
        spent[PATHS] += 1
        spent[LEGS] += legs
        if price < PROMISING * least:
            spent[LEGS] += _add(space, rates, roadmap, path[1:-1], steps, least)
        keep(elite, path, price)
