"""A length that no path beats: what remains of a graph of intervals of edges once all is struck out that is too long.

Edges are cut into intervals. A leg may join two intervals unless one box blocks all legs between them. Let a search
over this graph find for each state, an interval and the face along which it is reached, a linear function

    value(x) = at + slope x

of the place x on the interval, metres from its middle, such that no path from the start to x is shorter. That holds if

    at_j + slope_j y  <=  at_i + slope_i x + |leg from x to y|

for all legs from all states i to state j, and the value of the start is 0. The slope is that of the length of a good
path to the middle, so what is lost falls with the square of the interval's length. A search from the goal does the same
for paths the other way. Where the sum of both values is never below a limit, no path shorter than the limit touches the
interval, and it is struck out. The others are halved, and all is repeated. When the goal is out of reach, the limit is
proven to be a lower bound. Until then it is the value of the goal.
"""

import numpy as np

from skyverse._typing import Ints
from skyverse.numerics.heap import make_heap, pop, push
from skyverse.numerics.kernel import inner, inner_query
from skyverse.numerics.tolerances import DETOUR_GAIN
from skyverse.search.taut.interval_graph import FACES, IntervalGraph, LegLists, Values
from skyverse.search.taut.legs import Intervals, leg_bound, middle_leg, quick_leg_bound

MAX_REVISITS = 6
"""How often the value of a state is lowered before its slope is given up, so that searches end."""


@inner
def sharpen(graph: IntervalGraph, lists: LegLists, source: int, limit: float) -> tuple[IntervalGraph, float]:
    """Bound the lengths from the start (0) or from the goal (1) anew.

    Return the graph with these values, and a length of at most `limit` that no path from start to goal beats.
    """
    values, to_other_end = _bound_lengths(graph, lists, source, limit)
    ahead, behind = (values, graph.behind) if source == 0 else (graph.ahead, values)
    return IntervalGraph(graph.intervals, graph.legs, ahead, behind), min(to_other_end, limit)


@inner
def _bound_lengths(graph: IntervalGraph, lists: LegLists, source: int, limit: float) -> tuple[Values, float]:
    """Bound the lengths of paths from start (0) or goal (1) to all states, and to the other end; see the file's top.

    A value is first set by the best leg to the interval's middle, which also decides the slope, and lowered later where
    a leg from another state demands it. States that no path shorter than `limit` touches are not left.
    """
    intervals, legs = graph.intervals, graph.legs
    known, rest = (graph.ahead, graph.behind) if source == 0 else (graph.behind, graph.ahead)
    states = 2 * len(intervals.half)
    guess, before, visits = np.full(states, np.inf), np.full(states, -1), np.zeros(states, np.int64)
    values = Values(np.full(states, np.inf), np.zeros(states))
    target = 2 * (1 - source)
    guess[2 * source] = 0.0
    heap = push(make_heap(1024), 0.0, 2 * source)
    while heap.size[0]:
        key, state = pop(heap)
        i = state >> 1
        if visits[state] == 0:
            visits[state] = 1
            if i == source:
                values.at[state] = 0.0
            else:
                _, _, values.slope[state] = middle_leg(intervals, before[state] >> 1, i)
                least = _least_value(graph, lists, source, visits, values, state)
                values.at[state] = max(least, _floor(intervals, known, state, values.slope[state]))
        elif key != values.at[state]:
            continue
        back = state ^ 1 if i > 1 else state
        aside = intervals.half[i] * abs(values.slope[state] + rest.slope[back])
        if state == target or values.at[state] + rest.at[back] - aside >= limit:
            continue
        for k in range(lists.first[i], lists.first[i + 1]):
            leg, end = lists.order[k] >> 1, lists.order[k] & 1
            j = legs[leg, 1 - end]
            if j == source or (i > 1 and not legs[leg, FACES + end] & (2 - (state & 1))):
                continue
            for face in range(2 if j > 1 else 1):
                other = 2 * j + face
                if not legs[leg, FACES + 1 - end] >> face & 1:
                    continue
                if visits[other] == 0:
                    reached = values.at[state] + middle_leg(intervals, i, j)[0]
                    if reached < guess[other]:
                        guess[other], before[other] = reached, state
                        heap = push(heap, reached, other)
                    continue
                to_gain = values.at[other] - values.at[state] - DETOUR_GAIN
                if quick_leg_bound(intervals, i, j, values.slope[state], -values.slope[other]) >= to_gain:
                    continue
                least = values.at[state] + leg_bound(intervals, i, j, values.slope[state], -values.slope[other])
                least = max(least, _floor(intervals, known, other, values.slope[other]))
                if least < values.at[other] - DETOUR_GAIN:
                    visits[other] += 1
                    if visits[other] > MAX_REVISITS:
                        least -= intervals.half[j] * abs(values.slope[other])
                        values.slope[other] = 0.0
                    values.at[other] = least
                    heap = push(heap, least, other)
    return values, values.at[target]


@inner
def _least_value(graph: IntervalGraph, lists: LegLists, source: int, visits: Ints, values: Values, state: int) -> float:
    """Return the greatest value that a state with this slope may have beside all states that have a value."""
    intervals, legs = graph.intervals, graph.legs
    i = state >> 1
    least = np.inf
    for k in range(lists.first[i], lists.first[i + 1]):
        leg, end = lists.order[k] >> 1, lists.order[k] & 1
        j = legs[leg, 1 - end]
        if j == 1 - source or not legs[leg, FACES + end] >> (state & 1) & 1:
            continue
        for face in range(2 if j > 1 else 1):
            other = 2 * j + face
            if visits[other] == 0 or (j > 1 and not legs[leg, FACES + 1 - end] & (2 - face)):
                continue
            rest = least - values.at[other]
            if quick_leg_bound(intervals, j, i, values.slope[other], -values.slope[state]) < rest:
                leg_least = leg_bound(intervals, j, i, values.slope[other], -values.slope[state])
                least = min(least, values.at[other] + leg_least)
    return least


@inner_query
def _floor(intervals: Intervals, known: Values, state: int, slope: float) -> float:
    """Return the greatest value with another slope that is nowhere on the interval above the known one."""
    return known.at[state] - intervals.half[state >> 1] * abs(known.slope[state] - slope)
