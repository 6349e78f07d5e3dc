"""Points, and the prices of the straight legs between them; cheap ways over them."""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.cost import Rates, leg_price
from skyverse.numerics.kernel import by_reference, inner
from skyverse.numerics.norm import distance
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free

START, GOAL = 0, 1
"""The numbers of the first two points."""


@by_reference
class BendRoadmap(NamedTuple):
    """Points and legs.

    Attributes
    ----------
    points
        (c, 3) metres, of which the first ``size[0]`` are there.
    price
        (c, c) the price of each leg, infinite where it is not free, or leads too far about.
    size
        (1,) how many points there are.
    """

    points: Floats
    price: Floats
    size: Ints


@inner
def make_roadmap(space: Space, rates: Rates, start: Floats, goal: Floats, capacity: int) -> BendRoadmap:
    """Return a roadmap of start and goal, (3,) metres each, and of the straight leg between them if that is free."""
    roadmap = BendRoadmap(np.empty((capacity, 3)), np.full((capacity, capacity), math.inf), np.full(1, 2))
    roadmap.points[START], roadmap.points[GOAL] = start, goal
    if segment_free(space, start, goal):
        roadmap.price[START, GOAL] = roadmap.price[GOAL, START] = leg_price(rates, start, goal, np.empty(3))
    return roadmap


@inner
def add_point(space: Space, rates: Rates, roadmap: BendRoadmap, place: Floats, near: float, most: float) -> int:
    """Add a point with its legs, unless there is no room or another one is near; return how many legs were priced.

    Parameters
    ----------
    space, rates
        What is kept clear of, and what is priced.
    roadmap
        Where the point is added.
    place
        (3,) metres.
    near
        Metres up to which another point will do.
    most
        No leg is priced over which even the straight lines to the ends cost more.
    """
    points, n = roadmap.points, roadmap.size[0]
    if n == len(points):
        return 0
    for j in range(n):
        if distance(points[j], place) <= near:
            return 0
    for axis in range(3):
        points[n, axis] = place[axis]
    roadmap.size[0] = n + 1
    shares = np.empty(3)
    from_start, to_goal = distance(points[START], place), distance(place, points[GOAL])
    priced = 0
    for j in range(n):
        size = distance(points[j], place)
        about = min(from_start + distance(points[j], points[GOAL]), distance(points[START], points[j]) + to_goal)
        if rates.metre * (size + about) < most and segment_free(space, points[j], place):
            roadmap.price[j, n] = roadmap.price[n, j] = leg_price(rates, points[j], place, shares)
            priced += 1
    return priced


@inner
def cheapest_ways(roadmap: BendRoadmap, turn: float, dearer: Floats, root: int, least: Floats, before: Ints) -> None:
    """Find the cheapest way from one point to each other one (E. Dijkstra), each joint at the price of a turn.

    Parameters
    ----------
    roadmap, turn
        The legs, and the price of a turn.
    dearer
        (c,) by which shares legs at each point are dearer than they are.
    root
        The point.
    least, before
        (c,) the prices that are found, and the point before each.
    """
    n = roadmap.size[0]
    done = np.zeros(n, np.bool_)
    for k in range(n):
        least[k] = math.inf
        before[k] = -1
    least[root] = 0.0
    for _ in range(n):
        at, price = -1, math.inf
        for k in range(n):
            if not done[k] and least[k] < price:
                at, price = k, least[k]
        if at < 0:
            return
        done[at] = True
        if at != root:
            price += turn
        for k in range(n):
            if not done[k]:
                way = price + roadmap.price[at, k] * (1.0 + dearer[at] + dearer[k])
                if way < least[k]:
                    least[k] = way
                    before[k] = at


@inner
def way_to(before: Ints, point: int, way: Ints) -> int:
    """Write into `way` the points of the way from the start to a point; return how many they are, 0 if there is none.

    `before` is what `cheapest_ways` found from the start.
    """
    size = 0
    while point >= 0 and size < len(way):
        way[size] = point
        size += 1
        point = before[point]
    if size == 0 or way[size - 1] != START:
        return 0
    way[:size] = way[:size][::-1].copy()
    return size


@inner
def way_over(before: Ints, after: Ints, point: int, way: Ints) -> int:
    """Write into `way` the points of the way from start to goal over a point; return how many, 0 if there is none.

    `before` and `after` are what `cheapest_ways` found from the start and from the goal.
    """
    size = way_to(before, point, way)
    point = after[point]
    while size and point >= 0 and size < len(way):
        way[size] = point
        size += 1
        point = after[point]
    return size if size and way[size - 1] == GOAL else 0
