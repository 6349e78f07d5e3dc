"""Tighten a path among boxes: from any free path to one that no window of it can shorten."""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put, put_all, towards
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance, length_of
from skyverse.numerics.tolerances import MIN_WINDOW_SHARE, TIGHTEN_CONVERGED
from skyverse.search.path_shortening.shortcut import shortcut
from skyverse.search.taut.edge_geometry import pieces_within
from skyverse.search.taut.shorten_window import MAX_PIECES, shorten_window
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free

MAX_PASSES = 6
"""Passes of windows over the path at most."""
WINDOW_SHRINKAGE = 0.7
"""By which factor a window with too many edges in reach is narrowed."""


@inner
def tighten(space: Space, edges: Edges, path: Floats, spent: Ints) -> Floats:
    """Shorten a free path (k, 3) until no window of it gets shorter; `spent` counts searches and states expanded.

    A window is as wide as it can be with at most `MAX_PIECES` pieces of edges in reach; consecutive windows overlap.
    """
    path = shortcut(space, path)
    for _ in range(MAX_PASSES):
        before = length_of(path)
        middle = 0.0
        reach = 2.0 * before
        while True:
            total = length_of(path)
            reach *= 2.0
            while True:
                reach *= WINDOW_SHRINKAGE
                begin, stop = max(middle - reach, 0.0), min(middle + reach, total)
                first, last = _point_at(path, begin), _point_at(path, stop)
                pieces = pieces_within(edges, first, last, stop - begin, MAX_PIECES)
                if len(pieces) <= MAX_PIECES or reach <= MIN_WINDOW_SHARE * total:
                    break
            pieces = pieces[:MAX_PIECES]
            if len(pieces):
                head, part, tail = _split(path, begin, stop)
                if len(part) > 2 or not segment_free(space, part[0], part[-1]):
                    part = shorten_window(space, edges, pieces, part, spent)
                    path = _join(head, part, tail)
            if stop >= total:
                break
            middle += reach
        path = shortcut(space, path)
        if length_of(path) > before * (1.0 - TIGHTEN_CONVERGED):
            break
    return path


@inner
def _point_at(path: Floats, along: float) -> Floats:
    """Return the point (3,) of a path so many metres from its begin."""
    for i in range(1, len(path)):
        leg = distance(path[i - 1], path[i])
        if along <= leg and leg > 0.0:
            return towards(path[i - 1], path[i], along / leg)
        along -= leg
    return path[-1].copy()


@inner
def _split(path: Floats, begin: float, stop: float) -> tuple[Floats, Floats, Floats]:
    """Cut a path at two places, metres along it; return what is before, between (with both places) and after."""
    total = 0.0
    first, last = 1, len(path) - 1
    for i in range(1, len(path)):
        if total <= begin:
            first = i
        total += distance(path[i - 1], path[i])
        if total >= stop:
            last = i
            break
    between = np.empty((last - first + 2, 3))
    put(between, 0, _point_at(path, begin))
    put_all(between, 1, path[first:last])
    put(between, len(between) - 1, _point_at(path, stop))
    head = path[: first if begin > 0.0 else 0]
    tail = path[last if distance(between[-1], path[-1]) > 0.0 else len(path) :]
    return head, between, tail


@inner
def _join(head: Floats, part: Floats, tail: Floats) -> Floats:
    """Return the path that consists of three parts."""
    path = np.empty((len(head) + len(part) + len(tail), 3))
    put_all(path, 0, head)
    put_all(path, len(head), part)
    put_all(path, len(head) + len(part), tail)
    return path
