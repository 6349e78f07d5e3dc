"""From any way to a taut one: window by window, search over the edges near, slide the bends, search again."""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put, put_all, towards
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import (
    DETOUR_GAIN,
    LENGTH_ROUNDING,
    MIN_DRAW_SHARE,
    MIN_WINDOW_SHARE,
    ON_EDGE,
    SLIDE_CONVERGED,
    TIGHTEN_CONVERGED,
    WINDOW_CONVERGED,
)
from skyverse.search.taut.bends import Points, closest, distance, nearby, reach_on, search, spheroid, through
from skyverse.space import tree
from skyverse.space.edges import Edges
from skyverse.space.world import Space

PIECES = 100
"""Pieces of edges in a window at most."""
EACH = 4
"""Points spread over each of them, beside three that are chosen; one less where they are many."""
ROUNDS = 12
"""Searches in a window at most."""


@kernel
def length_of(way: Floats) -> float:
    """Return the length of a way (k, 3), metres."""
    total = 0.0
    for i in range(1, len(way)):
        total += distance(way[i - 1], way[i])
    return total


@inner
def visible(space: Space, growth: float, a: Floats, b: Floats) -> bool:
    """Tell whether a segment within the bounds meets no box grown by `growth`."""
    return tree.crossed(space.tree, space.boxes, growth, a, b) < 0


@inner
def slide(edges: Edges, at: Floats, edge: Ints) -> None:
    """Slide all bends along their edges until the path is shortest, as if nothing but the edges stood in the way."""
    for _ in range(500):
        moved = 0.0
        for i in range(1, len(at) - 1):
            if edge[i] >= 0:
                axis = edges.axis[edge[i]]
                x = closest(edges, edge[i], at[i - 1], at[i + 1])
                moved = max(moved, abs(x - at[i, axis]))
                put(at, i, edges.ends[edge[i], :3])
                at[i, axis] = x
        if moved <= SLIDE_CONVERGED * (1.0 + abs(at[0, 0])):
            break


@inner
def solve(space: Space, growth: float, edges: Edges, pieces: Ints, way: Floats, spent: Ints) -> Floats:
    """Shorten a way (k, 3) between its ends over some pieces of edges; it stays free throughout."""
    space, own = _around(space, growth, way)
    best = way
    best_edge = np.full(len(way), -1)
    length = length_of(way)
    each = EACH if len(pieces) <= PIECES // 2 else EACH - 1
    more_at = np.empty((0, 3))
    more_edge = np.empty(0, np.int64)
    for turn in range(ROUNDS):
        points = _sample(edges, pieces, each, best, best_edge, more_at, more_edge, length)
        found = search(space, growth, edges, points, length * (1.0 + LENGTH_ROUNDING))
        spent[0] += 1
        spent[1] += found.expanded
        if len(found.points) == 0:
            break
        path, edge = points.at[found.points], points.edge[found.points]
        _recognise(edges, pieces, path, edge)
        slid = path.copy()
        for _ in range(len(path)):
            slide(edges, slid, edge)
            if not _turn_over(edges, pieces, slid, edge):
                break
        more_at, more_edge = _conflicts(space, own, growth, edges, pieces, slid)
        trial, share = np.empty(path.shape), 1.0
        while share > MIN_DRAW_SHARE:
            for i in range(len(path)):
                for axis in range(3):
                    trial[i, axis] = path[i, axis] + share * (slid[i, axis] - path[i, axis])
            if _free(space, growth, trial):
                path = trial
                break
            share *= 0.5
        before = length
        if length_of(path) < length:
            best, best_edge, length = path, edge, length_of(path)
        if length > before * (1.0 - WINDOW_CONVERGED) and (len(more_at) == 0 or turn > 3):
            break
    return best


@inner
def _around(space: Space, growth: float, way: Floats) -> tuple[Space, Ints]:
    """Return the space of the boxes that a shorter way can meet, with an index of its own, and which they are."""
    low, high = spheroid(way[0], way[-1], length_of(way))
    own = tree.touching(space.tree, space.boxes, growth, low, high)
    boxes, which = np.empty((len(own), 6)), np.empty(len(own), np.int64)
    for k in range(len(own)):
        put(boxes, k, space.boxes[own[k]])
    index, order = tree.build(boxes)
    for k in range(len(own)):
        which[k] = own[order[k]]
        put(boxes, k, space.boxes[which[k]])
    return Space(space.low, space.high, boxes, space.clearance, index, space.solids, space.ground), which


@inner
def _recognise(edges: Edges, pieces: Ints, at: Floats, edge: Ints) -> None:
    """Let bends that lie on a piece of an edge, within rounding, know it, so that they can slide."""
    for i in range(1, len(at) - 1):
        for e in pieces:
            if edge[i] < 0 and _on(edges, e, at[i]):
                edge[i] = e


@inner
def _turn_over(edges: Edges, pieces: Ints, at: Floats, edge: Ints) -> bool:
    """Move bends from the end of their edge on to others that begin there, if that shortens; tell whether any did."""
    turned = False
    for i in range(1, len(at) - 1):
        e = edge[i]
        if e < 0 or edges.ends[e, edges.axis[e]] < at[i, edges.axis[e]] < edges.ends[e, edges.axis[e] + 3]:
            continue
        least = distance(at[i - 1], at[i]) + distance(at[i], at[i + 1])
        for other in pieces:
            if other != e and _on(edges, other, at[i]):
                x = closest(edges, other, at[i - 1], at[i + 1])
                if through(edges, other, x, at[i - 1], at[i + 1]) < least - DETOUR_GAIN:
                    edge[i] = other
                    turned = True
    return turned


@inner
def _on(edges: Edges, e: int, p: Floats) -> bool:
    """Tell whether a point lies on a piece of an edge, within a micrometre."""
    near = True
    for axis in range(3):
        near &= edges.ends[e, axis] - ON_EDGE < p[axis] < edges.ends[e, axis + 3] + ON_EDGE
    return near


@inner
def _free(space: Space, growth: float, way: Floats) -> bool:
    i = 1
    while i < len(way) and visible(space, growth, way[i - 1], way[i]):
        i += 1
    return i >= len(way)


@inner
def _sample(
    edges: Edges,
    pieces: Ints,
    each: int,
    way: Floats,
    way_edge: Ints,
    more_at: Floats,
    more_edge: Ints,
    length: float,
) -> Points:
    """Choose points: start, goal, the way's own bends, what is given, and some on all pieces that can matter."""
    most = len(way) + len(more_at) + len(pieces) * (each + 3)
    at = np.empty((most, 3))
    edge = np.empty(most, np.int64)
    start, goal = way[0], way[-1]
    put(at, 0, start)
    put(at, 1, goal)
    edge[0] = edge[1] = -1
    n = 2
    for i in range(1, len(way) - 1):
        put(at, n, way[i])
        edge[n] = way_edge[i]
        n += 1
    for i in range(len(more_at)):
        put(at, n, more_at[i])
        edge[n] = more_edge[i]
        n += 1
    for e in pieces:
        axis = edges.axis[e]
        x = closest(edges, e, start, goal)
        low, high = reach_on(edges, e, x, start, goal, length)
        if high < low:
            continue
        for i in range(each):
            put(at, n, edges.ends[e, :3])
            at[n, axis] = low + (high - low) * i / (each - 1)
            edge[n] = e
            n += 1
        for place in (x, _nearest(edges, e, way, 1), _nearest(edges, e, way, 2)):
            put(at, n, edges.ends[e, :3])
            at[n, axis] = place
            edge[n] = e
            n += 1
    return Points(at[:n], edge[:n])


@inner
def _nearest(edges: Edges, e: int, way: Floats, legs: int) -> float:
    """Return where on piece e, along its axis, a way goes over it at the least cost in place of so many of its legs."""
    best, least = edges.ends[e, edges.axis[e]], np.inf
    for i in range(len(way) - legs):
        x = closest(edges, e, way[i], way[i + legs])
        detour = through(edges, e, x, way[i], way[i + legs]) - distance(way[i], way[i + 1])
        if legs == 2:
            detour -= distance(way[i + 1], way[i + 2])
        if detour < least:
            best, least = x, detour
    return best


@inner
def _conflicts(space: Space, own: Ints, growth: float, edges: Edges, pieces: Ints, way: Floats) -> tuple[Floats, Ints]:
    """Where a way is blocked, return the points of the blocking boxes' edges that are nearest to it."""
    at = np.empty((12 * len(way), 3))
    edge = np.empty(12 * len(way), np.int64)
    n = 0
    for i in range(1, len(way)):
        box = tree.crossed(space.tree, space.boxes, growth, way[i - 1], way[i])
        if box < 0:
            continue
        for e in pieces:
            if edges.box[e] == own[box] and n < len(at):
                put(at, n, edges.ends[e, :3])
                at[n, edges.axis[e]] = closest(edges, e, way[i - 1], way[i])
                edge[n] = e
                n += 1
    return at[:n], edge[:n]


@inner
def tighten(space: Space, growth: float, edges: Edges, way: Floats, spent: Ints) -> Floats:
    """Shorten a way (k, 3) that is free until no window of it gets shorter."""
    way = straighten(space, growth, way)
    for _ in range(6):
        before = length_of(way)
        middle = 0.0
        reach = 2.0 * before
        while True:
            total = length_of(way)
            reach *= 2.0
            while True:
                reach *= 0.7
                begin, stop = max(middle - reach, 0.0), min(middle + reach, total)
                first, last = point_at(way, begin), point_at(way, stop)
                pieces = nearby(edges, first, last, stop - begin, PIECES)
                if len(pieces) <= PIECES or reach <= MIN_WINDOW_SHARE * total:
                    break
            pieces = pieces[:PIECES]
            if len(pieces):
                head, part, tail = split(way, begin, stop)
                if len(part) > 2 or not visible(space, growth, part[0], part[-1]):
                    part = solve(space, growth, edges, pieces, part, spent)
                    way = join(head, part, tail)
            if stop >= total:
                break
            middle += reach
        way = straighten(space, growth, way)
        if length_of(way) > before * (1.0 - TIGHTEN_CONVERGED):
            break
    return way


@inner
def straighten(space: Space, growth: float, way: Floats) -> Floats:
    """Leave out of a way what a straight line can skip: from each point on to the farthest in sight."""
    kept = np.zeros(len(way), np.bool_)
    kept[0] = kept[-1] = True
    i = 0
    while i < len(way) - 1:
        j = len(way) - 1
        while j > i + 1 and not visible(space, growth, way[i], way[j]):
            j -= 1
        kept[j] = True
        i = j
    return way[kept]


@inner
def point_at(way: Floats, along: float) -> Floats:
    """Return the point of a way so many metres from its begin."""
    for i in range(1, len(way)):
        leg = distance(way[i - 1], way[i])
        if along <= leg and leg > 0.0:
            return towards(way[i - 1], way[i], along / leg)
        along -= leg
    return way[-1].copy()


@inner
def split(way: Floats, begin: float, stop: float) -> tuple[Floats, Floats, Floats]:
    """Cut a way at two places along it: return what is before, between (with both places) and after."""
    total = 0.0
    first, last = 1, len(way) - 1
    for i in range(1, len(way)):
        if total <= begin:
            first = i
        total += distance(way[i - 1], way[i])
        if total >= stop:
            last = i
            break
    between = np.empty((last - first + 2, 3))
    put(between, 0, point_at(way, begin))
    put_all(between, 1, way[first:last])
    put(between, len(between) - 1, point_at(way, stop))
    head = way[: first if begin > 0.0 else 0]
    tail = way[last if distance(between[-1], way[-1]) > 0.0 else len(way) :]
    return head, between, tail


@inner
def join(head: Floats, part: Floats, tail: Floats) -> Floats:
    """Put a way together again."""
    way = np.empty((len(head) + len(part) + len(tail), 3))
    put_all(way, 0, head)
    put_all(way, len(head), part)
    put_all(way, len(head) + len(part), tail)
    return way
