"""One window of a path: searched over the edges near it, its bends slid along their edges, and searched again."""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance, length_of
from skyverse.numerics.tolerances import (
    DETOUR_GAIN,
    LENGTH_ROUNDING,
    MIN_DRAW_SHARE,
    ON_EDGE,
    SLIDE_CONVERGED,
    WINDOW_CONVERGED,
)
from skyverse.search.taut.edge_geometry import best_crossing, crossings_within, length_over, spheroid_bounds
from skyverse.search.taut.edge_search import BendPoints, search_edges
from skyverse.space import tree
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space, box_crossed, boxes_near
from skyverse.space.world import path_free

MAX_PIECES = 100
"""Pieces of edges in a window at most."""
POINTS_A_PIECE = 4
"""Points spread over each piece, beside three that are chosen; one less where more than half of `MAX_PIECES` are."""
MAX_SEARCHES = 12
"""Searches in a window at most."""
MAX_EXPANDED = 1_000_000
"""States that a search may expand: no search in a window needs so many."""
MAX_SLIDES = 500
"""How often all bends are slid along their edges at most."""
FRUITLESS_SEARCHES = 3
"""After so many more searches, new points at blocking boxes are no reason to search again."""


@inner
def shorten_window(space: Space, edges: Edges, pieces: Ints, path: Floats, spent: Ints) -> Floats:
    """Shorten a free path (k, 3) between its ends, with bends on some pieces of edges; it stays free throughout."""
    space, own = local_space(space, path)
    best = path
    best_edge = np.full(len(path), -1)
    length = length_of(path)
    each = POINTS_A_PIECE if len(pieces) <= MAX_PIECES // 2 else POINTS_A_PIECE - 1
    more_at = np.empty((0, 3))
    more_edge = np.empty(0, np.int64)
    for turn in range(MAX_SEARCHES):
        points = _sample(edges, pieces, each, best, best_edge, more_at, more_edge, length)
        found = search_edges(space, edges, points, length * (1.0 + LENGTH_ROUNDING), MAX_EXPANDED)
        spent[0] += 1
        spent[1] += found.expanded
        if len(found.points) == 0:
            break
        corners, edge = points.at[found.points], points.edge[found.points]
        _assign_edges(edges, pieces, corners, edge)
        slid = corners.copy()
        for _ in range(len(corners)):
            _slide(edges, slid, edge)
            if not _change_edges(edges, pieces, slid, edge):
                break
        more_at, more_edge = _points_at_blockers(space, own, edges, pieces, slid)
        trial, share = np.empty(corners.shape), 1.0
        while share > MIN_DRAW_SHARE:
            for i in range(len(corners)):
                for axis in range(3):
                    trial[i, axis] = corners[i, axis] + share * (slid[i, axis] - corners[i, axis])
            if path_free(space, trial):
                corners = trial
                break
            share *= 0.5
        before = length
        if length_of(corners) < length:
            best, best_edge, length = corners, edge, length_of(corners)
        if length > before * (1.0 - WINDOW_CONVERGED) and (len(more_at) == 0 or turn > FRUITLESS_SEARCHES):
            break
    return best


@inner
def local_space(space: Space, path: Floats) -> tuple[Space, Ints]:
    """Return a space of only those boxes that a shorter path can meet, with its own index, and which boxes they are."""
    low, high = spheroid_bounds(path[0], path[-1], length_of(path))
    own = boxes_near(space, 0.0, low, high)
    boxes, which = np.empty((len(own), 6)), np.empty(len(own), np.int64)
    for k in range(len(own)):
        put(boxes, k, space.boxes[own[k]])
    index, order = tree.build(boxes)
    for k in range(len(own)):
        which[k] = own[order[k]]
        put(boxes, k, space.boxes[which[k]])
    return Space(space.low, space.high, boxes, space.clearance, index, space.solids, space.ground, space.ceiling), which


@inner
def _slide(edges: Edges, at: Floats, edge: Ints) -> None:
    """Slide all bends along their edges, in place, until the path is shortest, whatever stands in the way."""
    for _ in range(MAX_SLIDES):
        moved = 0.0
        for i in range(1, len(at) - 1):
            if edge[i] >= 0:
                axis = edges.axis[edge[i]]
                x = best_crossing(edges, edge[i], at[i - 1], at[i + 1])
                moved = max(moved, abs(x - at[i, axis]))
                put(at, i, edges.ends[edge[i], :3])
                at[i, axis] = x
        if moved <= SLIDE_CONVERGED * (1.0 + abs(at[0, 0])):
            break


@inner
def _assign_edges(edges: Edges, pieces: Ints, at: Floats, edge: Ints) -> None:
    """Assign bends that lie on a piece of an edge, within rounding, to that piece, so that they can slide."""
    for i in range(1, len(at) - 1):
        for e in pieces:
            if edge[i] < 0 and _on_piece(edges, e, at[i]):
                edge[i] = e


@inner
def _change_edges(edges: Edges, pieces: Ints, at: Floats, edge: Ints) -> bool:
    """Assign bends at the end of their piece to another piece that begins there, if that shortens; tell if any was."""
    changed = False
    for i in range(1, len(at) - 1):
        e = edge[i]
        if e < 0 or edges.ends[e, edges.axis[e]] < at[i, edges.axis[e]] < edges.ends[e, edges.axis[e] + 3]:
            continue
        least = distance(at[i - 1], at[i]) + distance(at[i], at[i + 1])
        for other in pieces:
            if other != e and _on_piece(edges, other, at[i]):
                x = best_crossing(edges, other, at[i - 1], at[i + 1])
                if length_over(edges, other, x, at[i - 1], at[i + 1]) < least - DETOUR_GAIN:
                    edge[i] = other
                    changed = True
    return changed


@inner
def _on_piece(edges: Edges, e: int, p: Floats) -> bool:
    """Tell whether a point lies on a piece of an edge, within `ON_EDGE`."""
    near = True
    for axis in range(3):
        near &= edges.ends[e, axis] - ON_EDGE < p[axis] < edges.ends[e, axis + 3] + ON_EDGE
    return near


@inner
def _sample(
    edges: Edges,
    pieces: Ints,
    each: int,
    path: Floats,
    path_edge: Ints,
    more_at: Floats,
    more_edge: Ints,
    length: float,
) -> BendPoints:
    """Choose points: start, goal, the path's own bends, given ones, and some on all pieces that can matter."""
    most = len(path) + len(more_at) + len(pieces) * (each + 3)
    at = np.empty((most, 3))
    edge = np.empty(most, np.int64)
    start, goal = path[0], path[-1]
    put(at, 0, start)
    put(at, 1, goal)
    edge[0] = edge[1] = -1
    n = 2
    for i in range(1, len(path) - 1):
        put(at, n, path[i])
        edge[n] = path_edge[i]
        n += 1
    for i in range(len(more_at)):
        put(at, n, more_at[i])
        edge[n] = more_edge[i]
        n += 1
    for e in pieces:
        axis = edges.axis[e]
        x = best_crossing(edges, e, start, goal)
        low, high = crossings_within(edges, e, x, start, goal, length)
        if high < low:
            continue
        for i in range(each):
            put(at, n, edges.ends[e, :3])
            at[n, axis] = low + (high - low) * i / (each - 1)
            edge[n] = e
            n += 1
        for place in (x, _cheapest_detour(edges, e, path, 1), _cheapest_detour(edges, e, path, 2)):
            put(at, n, edges.ends[e, :3])
            at[n, axis] = place
            edge[n] = e
            n += 1
    return BendPoints(at[:n], edge[:n])


@inner
def _cheapest_detour(edges: Edges, e: int, path: Floats, legs: int) -> float:
    """Return where along piece e, metres, a detour over it costs least that replaces one leg or two of a path."""
    best, least = edges.ends[e, edges.axis[e]], np.inf
    for i in range(len(path) - legs):
        x = best_crossing(edges, e, path[i], path[i + legs])
        detour = length_over(edges, e, x, path[i], path[i + legs]) - distance(path[i], path[i + 1])
        if legs == 2:
            detour -= distance(path[i + 1], path[i + 2])
        if detour < least:
            best, least = x, detour
    return best


@inner
def _points_at_blockers(space: Space, own: Ints, edges: Edges, pieces: Ints, path: Floats) -> tuple[Floats, Ints]:
    """Return points nearest to a path's blocked legs on the edges of the boxes that block them, and their pieces."""
    at = np.empty((12 * len(path), 3))
    edge = np.empty(12 * len(path), np.int64)
    n = 0
    for i in range(1, len(path)):
        blocker = box_crossed(space, 0.0, path[i - 1], path[i])
        if blocker < 0:
            continue
        for e in pieces:
            if edges.box[e] == own[blocker] and n < len(at):
                put(at, n, edges.ends[e, :3])
                at[n, edges.axis[e]] = best_crossing(edges, e, path[i - 1], path[i])
                edge[n] = e
                n += 1
    return at[:n], edge[:n]
