"""The graph of intervals of edges: which of them a short path could join by a leg, coarse at first, then ever finer."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import doubled, put
from skyverse.numerics.kernel import inner, inner_query
from skyverse.numerics.tolerances import SIGHT_MARGIN
from skyverse.search.taut.edge_geometry import move_off, pieces_within
from skyverse.search.taut.legs import (
    ALL_BLOCKED,
    ALL_FREE,
    SOME_FREE,
    Intervals,
    faces_beside,
    least_distance,
    legs_free,
    middle_leg,
)
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space

PAIRS_A_LEG = 8
"""How many pairs are told to be too far apart in about the time in which it is asked whether obstacles are between."""
FACES, KNOWN = 2, 4
"""Columns of `IntervalGraph.legs`: beside which faces of one end the other lies, for either end; what is known."""


class Values(NamedTuple):
    """Lengths that no path between one end of the whole and a state falls short of, as linear functions.

    A state is an interval and the face of its edge along which the path reached it: 2 * interval for the first face,
    2 * interval + 1 for the second. A path goes on along the other face.

    Attributes
    ----------
    at
        (2n,) metres: the value at the middle of the interval.
    slope
        (2n,) how much it rises per metre along the edge.
    """

    at: Floats
    slope: Floats


class IntervalGraph(NamedTuple):
    """Intervals, the pairs of them that legs may join, and what is known of the way to each.

    Attributes
    ----------
    intervals
        Start and goal first.
    legs
        (k, 5): two intervals, then the columns `FACES` (two) and `KNOWN`.
    ahead, behind
        Lengths from the start to each state, and from the goal to each state of paths the other way.
    """

    intervals: Intervals
    legs: Ints
    ahead: Values
    behind: Values


class LegLists(NamedTuple):
    """The legs of each interval: (n + 1,) where its list begins, and all lists in one: 2 * leg + end of the leg."""

    first: Ints
    order: Ints


@inner
def first_graph(
    space: Space, edges: Edges, start: Floats, goal: Floats, limit: float, spacing: float, most: int
) -> tuple[IntervalGraph, int]:
    """Return the graph of all intervals, of at most `spacing` metres, that a path shorter than `limit` can touch.

    Also return how many pairs were looked at; where that would be more than `most`, the graph is incomplete. The space
    counts `SIGHT_MARGIN` more than the clearance, and the intervals lie on its boxes; the edges lie another margin off.
    """
    most_intervals = int(np.sqrt(2.0 * PAIRS_A_LEG * max(most, 0)))
    pieces = pieces_within(edges, start, goal, limit, most_intervals)
    count = 2
    for e in pieces:
        count += _parts(edges, e, spacing)
    intervals = _empty_intervals(count)
    put(intervals.middle, 0, start)
    put(intervals.middle, 1, goal)
    n = 2
    for e in pieces:
        axis = edges.axis[e]
        parts = _parts(edges, e, spacing)
        length = (edges.ends[e, axis + 3] - edges.ends[e, axis]) / parts
        for k in range(parts):
            put(intervals.middle, n, edges.ends[e, :3])
            intervals.middle[n, axis] += (k + 0.5) * length
            move_off(edges, e, intervals.middle[n], -SIGHT_MARGIN)
            intervals.half[n], intervals.axis[n], intervals.piece[n] = 0.5 * length, axis, e
            if least_distance(intervals, 0, n) + least_distance(intervals, n, 1) < limit:
                n += 1
    intervals = _first(intervals, n)
    ahead, behind = _straight(intervals, 0), _straight(intervals, 1)
    legs, found, looked = np.empty((1024, 5), np.int64), 0, n * n // (2 * PAIRS_A_LEG)
    for i in range(n):
        if looked > most:
            break
        for j in range(max(i, 1) + 1, n):
            if _could_join(intervals, ahead, behind, i, j, limit):
                looked += 1
                legs, found = _join(space, edges, intervals, i, j, SOME_FREE, legs, found)
    return IntervalGraph(intervals, legs[:found], ahead, behind), looked


@inner
def finer(
    space: Space, edges: Edges, graph: IntervalGraph, limit: float, spacing: float, most: int
) -> tuple[IntervalGraph, int]:
    """Return the graph without what no path shorter than `limit` touches, with intervals of `spacing` metres at most.

    Longer ones are halved. Also return how many pairs were looked at; where that would be more than `most`, the graph
    is incomplete.
    """
    old, ahead, behind = graph.intervals, graph.ahead, graph.behind
    first, parts = np.zeros(len(old.half), np.int64), np.zeros(len(old.half), np.int64)
    n = 0
    for i in range(len(old.half)):
        if i < 2 or _could_touch(graph, i, limit):
            first[i], parts[i] = n, 2 if 2.0 * old.half[i] > spacing else 1
            n += parts[i]
    new = _empty_intervals(n)
    new_ahead, new_behind = _empty_values(n), _empty_values(n)
    for i in range(len(old.half)):
        for part in range(parts[i]):
            k = first[i] + part
            put(new.middle, k, old.middle[i])
            new.half[k], new.axis[k], new.piece[k] = old.half[i] / parts[i], old.axis[i], old.piece[i]
            new.blocker[k] = old.blocker[i]
            aside = (2 * part - 1) * new.half[k] if parts[i] == 2 else 0.0
            if old.axis[i] >= 0:
                new.middle[k, old.axis[i]] += aside
            for face in range(2):
                _inherit(ahead, 2 * i + face, aside, new_ahead, 2 * k + face)
                _inherit(behind, 2 * i + face, aside, new_behind, 2 * k + face)
    legs, found, looked = np.empty((1024, 5), np.int64), 0, 0
    for leg in range(len(graph.legs)):
        a, b = graph.legs[leg, 0], graph.legs[leg, 1]
        looked += parts[a] * parts[b]
        if looked > most:
            break
        for i in range(first[a], first[a] + parts[a]):
            for j in range(first[b], first[b] + parts[b]):
                if _could_join(new, new_ahead, new_behind, i, j, limit):
                    legs, found = _join(space, edges, new, i, j, graph.legs[leg, KNOWN], legs, found)
    return IntervalGraph(new, legs[:found], new_ahead, new_behind), looked


@inner
def legs_by_interval(graph: IntervalGraph) -> LegLists:
    """Return the legs of each interval."""
    n, legs = len(graph.intervals.half), graph.legs
    first = np.zeros(n + 2, np.int64)
    for leg in range(len(legs)):
        first[legs[leg, 0] + 2] += 1
        first[legs[leg, 1] + 2] += 1
    for i in range(2, n + 2):
        first[i] += first[i - 1]
    order = np.empty(2 * len(legs), np.int64)
    for leg in range(len(legs)):
        for end in range(2):
            i = legs[leg, end]
            order[first[i + 1]] = 2 * leg + end
            first[i + 1] += 1
    return LegLists(first[: n + 1], order)


@inner_query
def _parts(edges: Edges, e: int, spacing: float) -> int:
    """Return into how many intervals of at most so many metres piece e is cut."""
    return 1 + int((edges.ends[e, edges.axis[e] + 3] - edges.ends[e, edges.axis[e]]) / spacing)


@inner
def _empty_intervals(n: int) -> Intervals:
    """Return so many intervals, all of them points, whose places are not set."""
    return Intervals(np.empty((n, 3)), np.zeros(n), np.full(n, -1), np.full(n, -1), np.full(n, -1))


@inner
def _first(intervals: Intervals, n: int) -> Intervals:
    """Return the first n intervals."""
    middle, half, axis, piece, blocker = intervals
    return Intervals(middle[:n], half[:n], axis[:n], piece[:n], blocker[:n])


@inner
def _empty_values(n: int) -> Values:
    """Return values of the states of so many intervals, which are not set."""
    return Values(np.empty(2 * n), np.empty(2 * n))


@inner_query
def _inherit(old: Values, i: int, aside: float, new: Values, k: int) -> None:
    """Write the value of state i, as seen from a place aside of the middle, as that of state k."""
    new.at[k], new.slope[k] = old.at[i] + aside * old.slope[i], old.slope[i]


@inner
def _straight(intervals: Intervals, source: int) -> Values:
    """Return the lengths of the straight lines from start (0) or goal (1) to all intervals."""
    n = len(intervals.half)
    values = _empty_values(n)
    for i in range(n):
        length, _, along = middle_leg(intervals, source, i)
        for state in (2 * i, 2 * i + 1):
            values.at[state], values.slope[state] = length, along
    return values


@inner_query
def _could_touch(graph: IntervalGraph, i: int, limit: float) -> bool:
    """Tell whether a path shorter than `limit` could touch interval i."""
    half, ahead, behind = graph.intervals.half[i], graph.ahead, graph.behind
    could = False
    for state in (2 * i, 2 * i + 1):
        back = state ^ 1  # a path the other way comes along the other face
        least = ahead.at[state] + behind.at[back] - half * abs(ahead.slope[state] + behind.slope[back])
        could |= least < limit
    return could


@inner_query
def _could_join(intervals: Intervals, ahead: Values, behind: Values, i: int, j: int, limit: float) -> bool:
    """Tell whether a path shorter than `limit` could have a leg between two intervals, whatever is in its way.

    Legs are bounded by the tangent at the middles, as by `quick_leg_bound`.
    """
    length, along_i, along_j = middle_leg(intervals, i, j)
    there = _least_beside(intervals, ahead, i, along_i) + _least_beside(intervals, behind, j, -along_j)
    back = _least_beside(intervals, ahead, j, -along_j) + _least_beside(intervals, behind, i, along_i)
    return length + min(there, back) < limit


@inner_query
def _least_beside(intervals: Intervals, values: Values, i: int, slope: float) -> float:
    """Return the least of value(x) - slope x over interval i and both of its faces."""
    first = values.at[2 * i] - intervals.half[i] * abs(values.slope[2 * i] - slope)
    second = values.at[2 * i + 1] - intervals.half[i] * abs(values.slope[2 * i + 1] - slope)
    return min(first, second)


@inner
def _join(
    space: Space, edges: Edges, intervals: Intervals, i: int, j: int, known: int, legs: Ints, found: int
) -> tuple[Ints, int]:
    """Write two intervals as leg number `found` unless there is no leg; return all legs and their number."""
    at_i, at_j = faces_beside(intervals, edges, i, j), faces_beside(intervals, edges, j, i)
    if not (at_i and at_j):
        return legs, found
    if known != ALL_FREE:
        known = legs_free(space, intervals, i, j)
        if known == ALL_BLOCKED:
            return legs, found
    if found == len(legs):
        legs = doubled(legs)
    legs[found, 0], legs[found, 1] = i, j
    legs[found, FACES], legs[found, FACES + 1], legs[found, KNOWN] = at_i, at_j, known
    return legs, found + 1
