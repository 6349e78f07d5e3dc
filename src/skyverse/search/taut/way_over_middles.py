"""Ways round: A* over the middles of the intervals that are left, guided by what is known of their lengths."""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put
from skyverse.numerics.heap import make_heap, push
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance
from skyverse.numerics.tolerances import SIGHT_MARGIN
from skyverse.search.taut.edge_geometry import move_off
from skyverse.search.taut.edge_search import next_leg, walk_back
from skyverse.search.taut.interval_graph import FACES, IntervalGraph, LegLists
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free


@inner
def way_over_middles(
    space: Space, edges: Edges, graph: IntervalGraph, lists: LegLists, source: int, length: float, spent: Ints
) -> Floats:
    """Return the shortest free path (k, 3) from start to goal over middles of intervals; empty if `length` or longer.

    The search leads from the start (source 0) or from the goal (1), with lazy visibility. No path of the graph from the
    other end falls short of the values that guide it, so that it expands few states.
    """
    at, legs = graph.intervals.middle.copy(), graph.legs
    for i in range(2, len(at)):  # where lines of sight have their margin
        move_off(edges, graph.intervals.piece[i], at[i], SIGHT_MARGIN)
    guide = graph.behind if source == 0 else graph.ahead
    states = 2 * len(at)
    price, came = np.full(states, np.inf), np.full(states, -1)
    target = 2 * (1 - source)
    heap = push(make_heap(1024), 0.0, 2 * source)
    spent[0] += 1
    while price[target] == np.inf:
        _, before, state = next_leg(heap, price)
        if state < 0:
            return np.empty((0, 3))
        i = state >> 1
        if i == source:
            price[state] = 0.0
        else:
            if not segment_free(space, at[before >> 1], at[i]):
                continue
            price[state] = price[before] + distance(at[before >> 1], at[i])
            came[state] = before
        spent[1] += 1
        for k in range(lists.first[i], lists.first[i + 1]):
            leg, end = lists.order[k] >> 1, lists.order[k] & 1
            j = legs[leg, 1 - end]
            if i > 1 and not legs[leg, FACES + end] & (2 - (state & 1)):
                continue
            for face in range(2 if j > 1 else 1):
                other = 2 * j + face
                if price[other] < np.inf or not legs[leg, FACES + 1 - end] >> face & 1:
                    continue
                rest = guide.at[other ^ 1 if j > 1 else other]  # the way from the other end comes along the other face
                key = price[state] + distance(at[i], at[j]) + rest
                if key < length:
                    heap = push(heap, key, state * states + other)
    back = walk_back(came, target)
    way = np.empty((len(back), 3))
    for k in range(len(back)):
        put(way, k if source else len(back) - 1 - k, at[back[k]])
    return way
