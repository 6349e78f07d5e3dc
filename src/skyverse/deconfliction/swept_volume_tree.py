"""Boxes around every part of a curve, in a binary tree over its time; and what departures they forbid.

A flight that departs at d is where its curve is at tau when the time is d + scale tau. Where that is too close to where
another flight is at t, departing at d = t - scale tau is forbidden. Branch and bound over pairs of boxes finds all such
instants d among the multiples of `TICK`, and a few more, since boxes are a little larger than what they are around.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.deconfliction.curves import Curves, Placed, length, place, point
from skyverse.deconfliction.meeting import clash, near_at_ends
from skyverse.numerics.arrays import put, put_box
from skyverse.numerics.kernel import inner, kernel

LEAF = 0.01
"""Seconds of a curve that a leaf's box is around, at most."""
TICK = 0.02
"""Seconds between the delays that are considered."""
MOST_LEAVES = 1 << 16
STRIDE = 4
"""Delays from one that is asked exactly to the next."""
COARSENESS = 0.15
"""Metres, more than two leaves' boxes are wide: what is so much too close in boxes is too close in truth."""
COARSE = 4
"""Leaves that are taken together where an estimate is enough."""
SPREAD = 0.5
"""Seconds after the earliest arrival estimated up to which others are estimated too."""


class Tubes(NamedTuple):
    """The trees of many curves, one after another.

    Attributes
    ----------
    base
        (n,) where each begins: with the point where the curve begins, then the tree with its root at `base + 1` and
        the children of node i at 2 i and 2 i + 1, then the point where it ends.
    leaves
        (n,) how many each has, a power of 2.
    boxes
        (m, 6) low and high corners, metres.
    """

    base: Ints
    leaves: Ints
    boxes: Floats


@kernel
def grow_tree(curves: Curves, c: int) -> Floats:
    """Return the boxes of curve c's tree, (2 leaves + 1, 6)."""
    whole = length(curves, c)
    leaves = 1
    while leaves < MOST_LEAVES and whole > leaves * LEAF and not _stands(curves, c):
        leaves *= 2
    boxes = np.empty((2 * leaves + 1, 6))
    at, end = place(curves, c, 0.0), place(curves, c, whole)
    put_box(boxes, 0, at, at)
    put_box(boxes, 2 * leaves, end, end)
    bends = np.empty((curves.first[c + 1] - curves.first[c], 3))
    for k in range(len(bends)):
        put(bends, k, _bend(curves.rows[curves.first[c] + k], curves.duration[curves.first[c] + k]))
    step = whole / leaves
    final = curves.first[c + 1] - 1
    k = curves.first[c]
    low, high, most = np.empty(3), np.empty(3), np.empty(3)
    for leaf in range(leaves):
        until = (leaf + 1) * step
        for axis in range(3):
            low[axis], high[axis], most[axis] = at[axis], at[axis], bends[k - curves.first[c], axis]
        while k < final and curves.begin[k + 1] < until:  # at a knot both pieces count
            _widen(low, high, curves.rows[k, curves.rows.shape[1] - 1])
            k += 1
            _widen(low, high, curves.rows[k, 0])
            for axis in range(3):
                most[axis] = max(most[axis], bends[k - curves.first[c], axis])
        point(curves.rows[k], min((until - curves.begin[k]) / curves.duration[k], 1.0), at)
        _widen(low, high, at)
        for axis in range(3):
            slack = most[axis] * (step * step / 8) + 1e-9
            boxes[leaves + leaf, axis], boxes[leaves + leaf, 3 + axis] = low[axis] - slack, high[axis] + slack
    _join(boxes, leaves)
    return boxes


@inner
def _widen(low: Floats, high: Floats, place: Floats) -> None:
    for axis in range(3):
        low[axis] = min(low[axis], place[axis])
        high[axis] = max(high[axis], place[axis])


@inner
def _join(boxes: Floats, leaves: int) -> None:
    """Put boxes around the pairs of boxes, from the leaves up."""
    for node in range(leaves - 1, 0, -1):
        for axis in range(3):
            boxes[node, axis] = min(boxes[2 * node, axis], boxes[2 * node + 1, axis])
            boxes[node, 3 + axis] = max(boxes[2 * node, 3 + axis], boxes[2 * node + 1, 3 + axis])


@inner
def _stands(curves: Curves, c: int) -> bool:
    for k in range(curves.first[c], curves.first[c + 1]):
        for axis in range(3):
            if curves.low[k, axis] != curves.high[k, axis]:
                return False
    return True


@inner
def _bend(rows: Floats, duration: float) -> Floats:
    """Return the largest acceleration along each axis within a piece, (3,)."""
    n = len(rows) - 1
    most = np.zeros(3)
    for i in range(n - 1):
        for axis in range(3):
            second = rows[i, axis] - 2 * rows[i + 1, axis] + rows[i + 2, axis]
            most[axis] = max(most[axis], abs(second) * (n * (n - 1) / (duration * duration)))
    return most


@inner
def forbid(
    curves: Curves,
    tubes: Tubes,
    placed: Placed,
    p: int,
    both: tuple[float, float],
    boxes: Floats,
    base: int,
    leaves: int,
    seconds: float,
    coarse: int,
    free: Ints,
) -> None:
    """Strike out the instants of departure at which a flight would come too close to that number p of those placed.

    Parameters
    ----------
    both
        The semi-axes that count between the two.
    boxes, base, leaves, seconds
        The flight's tree, and how long it takes.
    coarse
        The other's tree is looked at down to where so many leaves are together.
    free
        (m + 1,) as from `all_free`.
    """
    a = placed.curve[p]
    begin = placed.at[p]
    end = begin + placed.scale[p] * length(curves, a)
    other, others = tubes.base[a], tubes.leaves[a]
    far = np.inf
    fewer = max(others // coarse, 1)
    theirs = tubes.boxes
    for mine in range(3):  # before it departs, flying, after it has arrived
        if mine == 0:
            my_base, my_leaves, since, until = base - 1, 1, -far, 0.0
        elif mine == 1:
            my_base, my_leaves, since, until = base, leaves, 0.0, seconds
        else:
            my_base, my_leaves, since, until = base + 2 * leaves - 1, 1, seconds, far
        if mine < 2:
            _strike(theirs, other + 2 * others - 1, 1, end, far, boxes, my_base, my_leaves, since, until, both, free)
        _strike(theirs, other, fewer, begin, end, boxes, my_base, my_leaves, since, until, both, free)
        if mine > 0 and begin > 0.0:
            _strike(theirs, other - 1, 1, 0.0, begin, boxes, my_base, my_leaves, since, until, both, free)


@inner
def _strike(
    boxes_a: Floats,
    base_a: int,
    leaves_a: int,
    begin_a: float,
    end_a: float,
    boxes_b: Floats,
    base_b: int,
    leaves_b: int,
    begin_b: float,
    end_b: float,
    both: tuple[float, float],
    free: Ints,
) -> None:
    """Strike out the delays at which the parts of two curves in these spans of time come too close."""
    nodes = np.empty((128, 2), np.int64)
    times = np.empty((128, 4))
    nodes[0, 0], nodes[0, 1] = 1, 1
    times[0, 0], times[0, 1], times[0, 2], times[0, 3] = begin_a, end_a, begin_b, end_b
    size = 1
    last = len(free) - 2
    while size > 0:
        size -= 1
        i, j = nodes[size, 0], nodes[size, 1]
        a0, a1, b0, b1 = times[size, 0], times[size, 1], times[size, 2], times[size, 3]
        least, most = (a0 - b1) / TICK, (a1 - b0) / TICK
        if most < 0.0 or least > last:
            continue
        first = 0 if least <= 0.0 else math.ceil(least - 1e-9)
        final = last if most >= last else math.floor(most + 1e-9)
        if _next_free(free, first) > final:
            continue
        p, q = base_a + i, base_b + j
        nearest, farthest = 0.0, 0.0
        for axis in range(3):
            size_of = both[0] if axis < 2 else both[1]
            ahead = boxes_b[q, axis] - boxes_a[p, 3 + axis]
            behind = boxes_a[p, axis] - boxes_b[q, 3 + axis]
            gap = max(ahead, behind, 0.0) / size_of
            span = max(-ahead, -behind) / size_of
            nearest += gap * gap
            farthest += span * span
        if nearest >= 1.0:
            continue
        whole_a, whole_b = i >= leaves_a, j >= leaves_b
        if farthest < 1.0 or (whole_a and whole_b):
            k = _next_free(free, first)
            while k <= final:
                free[k] = k + 1
                k = _next_free(free, k)
            continue
        if not whole_a and (whole_b or a1 - a0 >= b1 - b0):
            middle = (a0 + a1) / 2
            for half in range(2):
                nodes[size, 0], nodes[size, 1] = 2 * i + 1 - half, j
                times[size, 0], times[size, 1] = (middle, a1) if half == 0 else (a0, middle)
                times[size, 2], times[size, 3] = b0, b1
                size += 1
        else:
            middle = (b0 + b1) / 2
            for half in range(2):
                nodes[size, 0], nodes[size, 1] = i, 2 * j + half
                times[size, 0], times[size, 1] = a0, a1
                times[size, 2], times[size, 3] = (b0, middle) if half == 0 else (middle, b1)
                size += 1


@inner
def _next_free(free: Ints, i: int) -> int:
    """Return the least delay number from i on that is not struck out, halving the way for those who come later."""
    while free[i] != i:
        free[i] = free[free[i]]
        i = free[i]
    return i


@kernel
def all_free(latest: float, since: float = 0.0) -> Ints:
    """Return instants 0, `TICK` ... up to the latest; those before `since` are struck out.

    Each points to itself, or else farther on.
    """
    free = np.arange(max(math.floor(latest / TICK + 1e-9), -1) + 2)
    early = min(max(math.ceil(since / TICK - 1e-9), 0), len(free) - 1)
    for i in range(early):
        free[i] += 1
    return free


@kernel
def earliest(
    curves: Curves,
    tubes: Tubes,
    placed: Placed,
    wide: Floats,
    tall: Floats,
    tight: np.ndarray,
    c: int,
    scale: float,
    free: Ints,
) -> float:
    """Return the least delay, seconds, at which curve c is apart from all that are placed; -1 if there is none.

    Those whose starts or targets are so near to its own that boxes are too coarse, (n,) booleans, are asked every few
    delays; but where a smaller ellipsoid forbids it, unless they are given too close, or they never let it pass once
    they stand.
    """
    seconds = scale * length(curves, c)
    for p in range(len(placed.curve)):
        if wide[p] > 0.0 and _next_free(free, 0) < len(free) - 1:
            a, at, factor = placed.curve[p], placed.at[p], placed.scale[p]
            if not tight[p] or min(near_at_ends(curves, a, c, wide[p], tall[p])) >= 1.0:
                less = COARSENESS if tight[p] else 0.0
                both = max(wide[p] - less, 1e-3), max(tall[p] - less, 1e-3)
                forbid(curves, tubes, placed, p, both, tubes.boxes, tubes.base[c], tubes.leaves[c], seconds, 1, free)
            if not tight[p]:
                continue
            landed = math.ceil((at + factor * length(curves, a)) / TICK) + 1
            if landed < len(free) - 1 and clash(
                curves, a, at, factor, c, landed * TICK, scale, wide[p], tall[p]
            ):  # it stands from then on, so that all later departures are alike
                for k in range(landed, len(free) - 1):
                    free[k] = max(free[k], k + 1)
    i = _next_free(free, 0)
    while i < len(free) - 1:
        apart = True
        for p in range(len(placed.curve)):
            if tight[p] and wide[p] > 0.0 and apart:
                a, at, factor = placed.curve[p], placed.at[p], placed.scale[p]
                apart = not clash(curves, a, at, factor, c, i * TICK, scale, wide[p], tall[p])
        if apart:
            return i * TICK
        i = _next_free(free, min(i + STRIDE, len(free) - 1) if tight.any() else i + 1)
    return -1.0


@kernel
def survey(
    curves: Curves,
    tubes: Tubes,
    placed: Placed,
    wide: Floats,
    tall: Floats,
    tight: np.ndarray,
    c: int,
    aside: Floats,
    stretched: Floats,
    share: float,
    since: float,
    latest: float,
) -> Floats:
    """Estimate when curve c would arrive if it were led aside, after a share of its time, each of m ways; (m,) seconds.

    Parameters
    ----------
    aside
        (m, 3) metres.
    stretched
        (m,) by how much longer it takes.
    latest
        Later arrivals are infinite, and so are those after the earliest that was found before.
    """
    full = tubes.leaves[c]
    leaves = max(full // COARSE, 1)
    own = tubes.boxes[tubes.base[c] : tubes.base[c] + 2 * leaves + 1]
    boxes = own.copy()
    put(boxes, 2 * leaves, tubes.boxes[tubes.base[c] + 2 * full])
    arrivals = np.full(len(aside), np.inf)
    for way in range(len(aside)):
        for leaf in range(leaves):
            passed = (leaf + 0.5) / leaves
            part = passed / share if passed < share else (1.0 - passed) / (1.0 - share)
            for axis in range(6):
                boxes[leaves + leaf, axis] = own[leaves + leaf, axis] + part * aside[way, axis % 3]
        _join(boxes, leaves)
        seconds = length(curves, c) * stretched[way]
        free = all_free(latest - seconds, since)
        for p in range(len(placed.curve)):
            if wide[p] > 0.0 and not tight[p] and _next_free(free, 0) < len(free) - 1:
                forbid(curves, tubes, placed, p, (wide[p], tall[p]), boxes, 0, leaves, seconds, COARSE, free)
        i = _next_free(free, 0)
        if i < len(free) - 1:
            arrivals[way] = i * TICK + seconds
            latest = min(latest, arrivals[way] + SPREAD)
    return arrivals


@kernel
def clashes_with(
    curves: Curves, tubes: Tubes, placed: Placed, wide: Floats, tall: Floats, c: int, at: float, scale: float
) -> np.ndarray:
    """Tell whom of those placed curve c, flown so, comes too close to; (n,) booleans."""
    who = np.zeros(len(placed.curve), np.bool_)
    seconds = scale * length(curves, c)
    for p in range(len(who)):
        if wide[p] > 0.0:
            free = np.arange(2)  # is departing at once struck out, boxes against boxes? Then look closer
            if at == 0.0:
                both = wide[p], tall[p]
                forbid(curves, tubes, placed, p, both, tubes.boxes, tubes.base[c], tubes.leaves[c], seconds, 1, free)
            if at > 0.0 or free[0] > 0:
                a, begin, factor = placed.curve[p], placed.at[p], placed.scale[p]
                who[p] = clash(curves, a, begin, factor, c, at, scale, wide[p], tall[p])
    return who
