"""A string pulled tight among shapes of any kind, along exact lines of sight.

Nothing is known of the shapes but which segments are free. A bend is drawn towards the line between its neighbours as
far as both of its legs stay free, slides aside and is drawn again, and is cut off, which leaves two for one.
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import (
    BEND_WORTH,
    COLLINEAR_DOT,
    MIN_CROSS_PRODUCT,
    MIN_SLIDE,
    PATH_CONVERGED,
    SHORTER,
)
from skyverse.search.taut.bends import distance
from skyverse.search.taut.tighten import length_of
from skyverse.space.world import Space, in_bounds, segment_free

ROUNDS = 120
"""At most."""
HALVINGS = 9
"""How often what is too far and what is not are halved."""


@kernel
def pull(space: Space, way: Floats) -> Floats:
    """Shorten a free way (k, 3) until nothing near it is shorter, but for very little; its ends stay."""
    way = skip(space, way)
    reach = _reaches(way)
    here, there = np.empty(3), np.empty(3)
    last = length_of(way)
    for _ in range(ROUNDS):
        before = length_of(way)
        for i in range(1, len(way) - 1):
            _draw(space, way, i, here)
            _slide(space, way, i, reach, here, there)
        kept = _seen_past(space, way)
        if not kept.all():
            way, reach = way[kept], reach[kept]
        now = length_of(way)
        if len(way) == 2:
            break
        if now > before * (1.0 - 10.0 * PATH_CONVERGED):
            cut = _cut(space, way)
            if len(cut) == len(way) and now > before * (1.0 - PATH_CONVERGED):
                break
            if len(cut) > len(way):
                if now > last * (1.0 - BEND_WORTH):
                    break
                last = now
                way = cut
                reach = _reaches(way)
    return way


@inner
def skip(space: Space, way: Floats) -> Floats:
    """Leave out what a straight line can skip: from each bend on to the farthest in sight."""
    kept = np.zeros(len(way), np.bool_)
    kept[0] = kept[len(way) - 1] = True
    i = 0
    while i < len(way) - 1:
        j = len(way) - 1
        while j > i + 1 and not segment_free(space, way[i], way[j]):
            j -= 1
        kept[j] = True
        i = j
    return way[kept]


@inner
def _reaches(way: Floats) -> Floats:
    """Return how far each bend is tried aside at first."""
    reach = np.zeros(len(way))
    for i in range(1, len(way) - 1):
        reach[i] = 0.25 * min(distance(way[i - 1], way[i]), distance(way[i], way[i + 1]))
    return reach


@inner
def _seen_past(space: Space, way: Floats) -> np.ndarray:
    """Tell which points are needed: the others are those whose neighbours see each other."""
    kept = np.ones(len(way), np.bool_)
    last = 0
    for i in range(1, len(way) - 1):
        if segment_free(space, way[last], way[i + 1]):
            kept[i] = False
        else:
            last = i
    return kept


@inner
def _draw(space: Space, way: Floats, i: int, trial: Floats) -> None:
    """Draw bend i towards the line between its neighbours while its legs stay free."""
    a, v, b = way[i - 1], way[i], way[i + 1]
    share = _drawn(space, a, v, b, trial)
    if share > 0.0:
        _towards(a, v, b, share, trial)
        for axis in range(3):
            way[i, axis] = trial[axis]


@inner
def _drawn(space: Space, a: Floats, v: Floats, b: Floats, trial: Floats) -> float:
    """Return how far a free bend v between a and b can be drawn to the line between, as a share."""
    inside, outside = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        _towards(a, v, b, middle, trial)
        if segment_free(space, a, trial) and segment_free(space, trial, b):
            inside = middle
        else:
            outside = middle
    return inside


@inner
def _towards(a: Floats, v: Floats, b: Floats, share: float, trial: Floats) -> None:
    """Write the point so far from v to where it divides a-b as it does the way over it."""
    to_a, to_b = distance(a, v), distance(v, b)
    along = to_a / (to_a + to_b) if to_a + to_b > 0.0 else 0.5
    for axis in range(3):
        trial[axis] = v[axis] + share * (a[axis] + along * (b[axis] - a[axis]) - v[axis])


@inner
def _slide(space: Space, way: Floats, i: int, reach: Floats, aside: Floats, trial: Floats) -> None:
    """Move bend i, in place, to a side where it can be drawn tighter; what it tries next time is longer or shorter.

    It goes where the way over it hardly gets longer at first: across the plane of its legs, and along the ellipse.
    """
    a, v, b = way[i - 1], way[i], way[i + 1]
    to_a, to_b = distance(a, v), distance(v, b)
    if reach[i] < MIN_SLIDE * (to_a + to_b) or to_a == 0.0 or to_b == 0.0:
        return
    px, py, pz = (v[0] - a[0]) / to_a, (v[1] - a[1]) / to_a, (v[2] - a[2]) / to_a
    qx, qy, qz = (b[0] - v[0]) / to_b, (b[1] - v[1]) / to_b, (b[2] - v[2]) / to_b
    wx, wy, wz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    size = np.sqrt(wx * wx + wy * wy + wz * wz)
    if size < MIN_CROSS_PRODUCT:
        return
    ex, ey, ez = px + qx, py + qy, pz + qz  # along the ellipse
    norm = np.sqrt(ex * ex + ey * ey + ez * ez)
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
        share = _drawn(space, a, aside, b, trial)
        _towards(a, aside, b, share, trial)
        if distance(a, trial) + distance(trial, b) < least * (1.0 - SHORTER):
            for axis in range(3):
                way[i, axis] = trial[axis]
            reach[i] *= 1.5
            return
    reach[i] *= 0.5


@inner
def _cut(space: Space, way: Floats) -> Floats:
    """Return a way with those bends cut off, as far out as is free, that this is worth a bend more."""
    cut = np.empty((2 * len(way), 3))
    worth = BEND_WORTH * length_of(way)
    p, q = np.empty(3), np.empty(3)
    count = 0
    for i in range(len(way)):
        share = 0.0
        if 0 < i < len(way) - 1:
            before, after = distance(way[i - 1], way[i]), distance(way[i], way[i + 1])
            most = 0.5 * min(before, after)  # the other half is the next bend's
            _off(way, i, most, before, after, p, q)
            if 2.0 * most - distance(p, q) > worth:
                share = _cut_share(space, way, i, most, before, after, p, q)
                _off(way, i, share * most, before, after, p, q)
                if 2.0 * share * most - distance(p, q) <= worth:
                    share = 0.0
        for axis in range(3):
            cut[count, axis] = p[axis] if share > 0.0 else way[i, axis]
        count += 1
        if share > 0.0:
            for axis in range(3):
                cut[count, axis] = q[axis]
            count += 1
    return cut[:count].copy()


@inner
def _cut_share(
    space: Space, way: Floats, i: int, most: float, before: float, after: float, p: Floats, q: Floats
) -> float:
    """Return at which share of `most` metres from bend i its legs see each other."""
    if segment_free(space, p, q):
        return 1.0
    inside, outside = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        _off(way, i, middle * most, before, after, p, q)
        if segment_free(space, p, q):
            inside = middle
        else:
            outside = middle
    return inside


@inner
def _off(way: Floats, i: int, far: float, before: float, after: float, p: Floats, q: Floats) -> None:
    """Write the points so far from bend i on both of its legs."""
    for axis in range(3):
        p[axis] = way[i, axis] + (way[i - 1, axis] - way[i, axis]) * (far / before)
        q[axis] = way[i, axis] + (way[i + 1, axis] - way[i, axis]) * (far / after)


@kernel
def slacken(space: Space, way: Floats) -> Floats:
    """Return a free way with few bends for many: neighbours give way to one bend farther out, where that is free.

    On a curved surface bends hold each other; fewer slide far.
    """
    apex = np.empty(3)
    merged = True
    while merged and len(way) > 3:
        merged = False
        looser = np.empty_like(way)
        count, i = 0, 0
        while i < len(way):
            both = 0 < i < len(way) - 2 and _apex(looser[count - 1], way[i], way[i + 1], way[i + 2], apex)
            if both and segment_free(space, looser[count - 1], apex) and segment_free(space, apex, way[i + 2]):
                merged = True
                i += 1
            else:
                for axis in range(3):
                    apex[axis] = way[i, axis]
            for axis in range(3):
                looser[count, axis] = apex[axis]
            count += 1
            i += 1
        way = looser[:count].copy()
    return way


@inner
def _apex(a: Floats, v: Floats, w: Floats, b: Floats, apex: Floats) -> bool:
    """Write where the legs a-v and b-w, prolonged, come nearest to each other, a little farther out; tell if so."""
    to_v, to_w = distance(a, v), distance(b, w)
    if to_v == 0.0 or to_w == 0.0:
        return False
    along = from_v = from_w = 0.0
    for axis in range(3):
        p, q, gap = (v[axis] - a[axis]) / to_v, (w[axis] - b[axis]) / to_w, w[axis] - v[axis]
        along += p * q
        from_v += p * gap
        from_w += q * gap
    if along > 0.7 or along < -1.0 + COLLINEAR_DOT:  # they come back, or are one straight line
        return False
    s, t = (from_v - along * from_w) / (1.0 - along**2), (along * from_v - from_w) / (1.0 - along**2)
    if s <= 0.0 or t <= 0.0:
        return False
    for axis in range(3):
        p, q, middle = (v[axis] - a[axis]) / to_v, (w[axis] - b[axis]) / to_w, 0.5 * (v[axis] + w[axis])
        meeting = 0.5 * (v[axis] + s * p + w[axis] + t * q)
        apex[axis] = meeting + 0.02 * (meeting - middle)
    return True
