"""Shorten a free path until no single move of a bend shortens it, among shapes of any kind.

Nothing is known of the shapes but which segments are free. A bend is drawn towards the line between its neighbours as
far as both of its legs stay free; it slides aside and is drawn again; and its corner is cut off, which makes two bends
of one.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance, length_of
from skyverse.numerics.tolerances import BEND_WORTH, MIN_CROSS_PRODUCT, MIN_SLIDE, PATH_CONVERGED, SHORTER
from skyverse.search.path_shortening.shortcut import drop_redundant, shortcut
from skyverse.space.obstacles import Space, in_bounds
from skyverse.space.world import segment_free

MAX_ROUNDS = 120
"""Rounds of moves over all bends at most."""
BISECTIONS = 9
"""How often the interval between a share that is free and one that is not is halved."""


@kernel
def shorten(space: Space, path: Floats) -> Floats:
    """Return a path (k, 3) with the same ends as a free path (n, 3), and never a longer one.

    It ends where a round shortens the path by less than `PATH_CONVERGED`, and one more bend by less than `BEND_WORTH`.
    """
    path = shortcut(space, path)
    reach = _first_reach(path)
    here, there = np.empty(3), np.empty(3)
    last = length_of(path)
    for _ in range(MAX_ROUNDS):
        before = length_of(path)
        for i in range(1, len(path) - 1):
            _draw_bend(space, path, i, here)
            _slide_bend(space, path, i, reach, here, there)
        path, kept = drop_redundant(space, path)
        reach = reach[kept]
        now = length_of(path)
        if len(path) == 2:
            break
        if now > before * (1.0 - 10.0 * PATH_CONVERGED):
            cut = _cut_corners(space, path)
            if len(cut) == len(path) and now > before * (1.0 - PATH_CONVERGED):
                break
            if len(cut) > len(path):
                if now > last * (1.0 - BEND_WORTH):
                    break
                last = now
                path = cut
                reach = _first_reach(path)
    return path


@inner
def _first_reach(path: Floats) -> Floats:
    """Return how many metres aside each bend is moved at first, (n,)."""
    reach = np.zeros(len(path))
    for i in range(1, len(path) - 1):
        reach[i] = 0.25 * min(distance(path[i - 1], path[i]), distance(path[i], path[i + 1]))
    return reach


@inner
def _draw_bend(space: Space, path: Floats, i: int, trial: Floats) -> None:
    """Draw bend i, in place, towards the line between its neighbours while both of its legs stay free."""
    a, v, b = path[i - 1], path[i], path[i + 1]
    share = _free_share(space, a, v, b, trial)
    if share > 0.0:
        _drawn(a, v, b, share, trial)
        for axis in range(3):
            path[i, axis] = trial[axis]


@inner
def _free_share(space: Space, a: Floats, v: Floats, b: Floats, trial: Floats) -> float:
    """Return how far the bend v between a and b can be drawn to the line a-b, as a share from 0 to 1."""
    inside, outside = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        _drawn(a, v, b, middle, trial)
        if segment_free(space, a, trial) and segment_free(space, trial, b):
            inside = middle
        else:
            outside = middle
    return inside


@inner
def _drawn(a: Floats, v: Floats, b: Floats, share: float, trial: Floats) -> None:
    """Write into `trial` the point a share of the way from v to the point of a-b that divides it as v divides a-v-b."""
    to_a, to_b = distance(a, v), distance(v, b)
    along = to_a / (to_a + to_b) if to_a + to_b > 0.0 else 0.5
    for axis in range(3):
        trial[axis] = v[axis] + share * (a[axis] + along * (b[axis] - a[axis]) - v[axis])


@inner
def _slide_bend(space: Space, path: Floats, i: int, reach: Floats, aside: Floats, trial: Floats) -> None:
    """Move bend i, in place, to a side from which it can be drawn tighter; lengthen its reach if so, else halve it.

    It is moved where the path over it hardly gets longer at first: across the plane of its legs, and along the ellipse
    whose foci are its neighbours. With unit vectors p along the leg to it and q along the leg from it, these
    directions are p x q and p + q.
    """
    a, v, b = path[i - 1], path[i], path[i + 1]
    to_a, to_b = distance(a, v), distance(v, b)
    if reach[i] < MIN_SLIDE * (to_a + to_b) or to_a == 0.0 or to_b == 0.0:
        return
    px, py, pz = (v[0] - a[0]) / to_a, (v[1] - a[1]) / to_a, (v[2] - a[2]) / to_a
    qx, qy, qz = (b[0] - v[0]) / to_b, (b[1] - v[1]) / to_b, (b[2] - v[2]) / to_b
    wx, wy, wz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    size = math.sqrt(wx * wx + wy * wy + wz * wz)
    if size < MIN_CROSS_PRODUCT:
        return
    ex, ey, ez = px + qx, py + qy, pz + qz
    norm = math.sqrt(ex * ex + ey * ey + ez * ez)
    if norm < MIN_CROSS_PRODUCT:
        return
    least = to_a + to_b
    for turn in range(4):
        sign = 1.0 if turn & 1 else -1.0
        step = sign * reach[i] / (size if turn < 2 else norm)
        aside[0] = v[0] + step * (wx if turn < 2 else ex)
        aside[1] = v[1] + step * (wy if turn < 2 else ey)
        aside[2] = v[2] + step * (wz if turn < 2 else ez)
        if not (in_bounds(space, aside) and segment_free(space, a, aside) and segment_free(space, aside, b)):
            continue
        share = _free_share(space, a, aside, b, trial)
        _drawn(a, aside, b, share, trial)
        if distance(a, trial) + distance(trial, b) < least * (1.0 - SHORTER):
            for axis in range(3):
                path[i, axis] = trial[axis]
            reach[i] *= 1.5
            return
    reach[i] *= 0.5


@inner
def _cut_corners(space: Space, path: Floats) -> Floats:
    """Return a path with those corners cut off, as far out as is free, where that is worth one more bend."""
    cut = np.empty((2 * len(path), 3))
    worth = BEND_WORTH * length_of(path)
    p, q = np.empty(3), np.empty(3)
    count = 0
    for i in range(len(path)):
        share = 0.0
        if 0 < i < len(path) - 1:
            before, after = distance(path[i - 1], path[i]), distance(path[i], path[i + 1])
            most = 0.5 * min(before, after)  # the other half of a leg is left to its other bend
            _on_legs(path, i, most, before, after, p, q)
            if 2.0 * most - distance(p, q) > worth:
                share = _cut_share(space, path, i, most, before, after, p, q)
                _on_legs(path, i, share * most, before, after, p, q)
                if 2.0 * share * most - distance(p, q) <= worth:
                    share = 0.0
        for axis in range(3):
            cut[count, axis] = p[axis] if share > 0.0 else path[i, axis]
        count += 1
        if share > 0.0:
            for axis in range(3):
                cut[count, axis] = q[axis]
            count += 1
    return cut[:count].copy()


@inner
def _cut_share(
    space: Space, path: Floats, i: int, most: float, before: float, after: float, p: Floats, q: Floats
) -> float:
    """Return the greatest share of `most` metres from bend i at which the places on its legs see each other."""
    if segment_free(space, p, q):
        return 1.0
    inside, outside = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        _on_legs(path, i, middle * most, before, after, p, q)
        if segment_free(space, p, q):
            inside = middle
        else:
            outside = middle
    return inside


@inner
def _on_legs(path: Floats, i: int, metres: float, before: float, after: float, p: Floats, q: Floats) -> None:
    """Write into p and q the places so many metres from bend i on its two legs, which are `before` and `after` long."""
    for axis in range(3):
        p[axis] = path[i, axis] + (path[i - 1, axis] - path[i, axis]) * (metres / before)
        q[axis] = path[i, axis] + (path[i + 1, axis] - path[i, axis]) * (metres / after)
