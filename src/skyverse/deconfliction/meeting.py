"""When two flights are too close, in continuous time: nearness^2 in Bernstein form, cut in two where in doubt.

The coefficients enclose the polynomial, so what is called apart is apart; what is too close is found to `SHORTEST`.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.curves import Curves, length, piece_at, place, resting, stretch
from skyverse.numerics.arrays import put
from skyverse.numerics.bernstein import halve, product
from skyverse.numerics.kernel import inner, kernel

SHORTEST = 1e-6
"""Seconds below which a doubt counts as too close."""
SAME = 1e-7
"""By how much nearer than its starts or targets a pair may come and still count as given: less than is forgiven."""
MOST = 64
"""Spans that are told apart, of one pair."""


@inner
def nearness(a: Floats, b: Floats, wide: float, tall: float) -> float:
    """Return how near two places are, as a share of an ellipsoid's semi-axes."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return math.sqrt((x * x + y * y) / (wide * wide) + z * z / (tall * tall))


@kernel
def meetings(
    curves: Curves,
    a: int,
    at_a: float,
    scale_a: float,
    b: int,
    at_b: float,
    scale_b: float,
    wide: float,
    tall: float,
    end: float,
    hasty: bool,
) -> Floats:
    """Return the spans of [0, end] in which two flights are too close, (n, 4): begin, end, when closest, nearness^2.

    In haste, a part of the first one is enough.
    """
    spans = np.empty((MOST, 4))
    count = 0
    now = 0.0
    while now < end:
        k, share_a, until_a = _stage(curves, a, at_a, scale_a, now)
        m, share_b, until_b = _stage(curves, b, at_b, scale_b, now)
        until = min(min(until_a, until_b), end)
        if _boxes_meet(curves, k, m, wide, tall):
            one = _part(curves, k, share_a, at_a, scale_a, now, until)
            other = _part(curves, m, share_b, at_b, scale_b, now, until)
            count = _below_one(_gap_square(one, other, wide, tall), now, until, spans, count, hasty)
            if hasty and count > 0:
                break
        now = until
    return spans[:count]


@inner
def _stage(curves: Curves, c: int, at: float, scale: float, now: float) -> tuple[int, int, float]:
    """Return the piece flown just after `now`, whether it moves (0: before, 1: in flight, 2: after), and until when."""
    local = (now - at) / scale
    last = curves.first[c + 1] - 1
    if now < at:
        return curves.first[c], 0, at
    k = piece_at(curves, c, local)
    finish = at + scale * (curves.begin[k] + curves.duration[k])
    while finish <= now and k < last:
        k += 1
        finish = at + scale * (curves.begin[k] + curves.duration[k])
    if finish <= now:
        return last, 2, np.inf
    return k, 1, finish


@inner
def _part(curves: Curves, k: int, stage: int, at: float, scale: float, now: float, until: float) -> Floats:
    if stage == 1:
        return stretch(curves, k, (now - at) / scale, (until - at) / scale)
    here = curves.rows[k, 0 if stage == 0 else curves.rows.shape[1] - 1]
    return resting(here, curves.rows.shape[1])


@inner
def _gap_square(one: Floats, other: Floats, wide: float, tall: float) -> Floats:
    """Return the coefficients of the squared gap of two UAVs, as a share of what keeps them apart; (2 n + 1, 1)."""
    n = len(one)
    gap, squares, square = np.empty(n), np.empty((3, 2 * n - 1)), np.empty((2 * n - 1, 1))
    for axis in range(3):
        for i in range(n):
            gap[i] = one[i, axis] - other[i, axis]
        put(squares, axis, product(gap, gap))
    for i in range(2 * n - 1):
        square[i, 0] = (squares[0, i] + squares[1, i]) / (wide * wide) + squares[2, i] / (tall * tall)
    return square


@inner
def _boxes_meet(curves: Curves, k: int, m: int, wide: float, tall: float) -> bool:
    square = 0.0
    for axis in range(3):
        gap = max(max(curves.low[k, axis] - curves.high[m, axis], curves.low[m, axis] - curves.high[k, axis]), 0.0)
        gap /= wide if axis < 2 else tall
        square += gap * gap
    return square < 1.0


@inner
def _below_one(square: Floats, begin: float, end: float, spans: Floats, count: int, hasty: bool) -> int:
    """Add where a polynomial is below 1 to the spans, in order; neighbours are joined."""
    waiting = [(square, begin, end)]
    while len(waiting) > 0:
        b, since, until = waiting.pop()
        if b.min() >= 1.0:
            continue
        if b.max() >= 1.0 and until - since > SHORTEST:
            left, right = halve(b)
            middle = (since + until) / 2
            waiting.append((right, middle, until))
            waiting.append((left, since, middle))
            continue
        if hasty:
            spans[0, 0], spans[0, 1] = since, until
            return 1
        share, best = _least(b)
        when = since + (until - since) * share
        if count > 0 and since - spans[count - 1, 1] <= SHORTEST:
            spans[count - 1, 1] = until
        elif count < MOST:
            spans[count, 0], spans[count, 1], spans[count, 3] = since, until, np.inf
            count += 1
        else:
            spans[count - 1, 1] = until
        if best < spans[count - 1, 3]:
            spans[count - 1, 2], spans[count - 1, 3] = when, best
    return count


@inner
def _value(b: Floats, u: float) -> float:
    c = b[:, 0].copy()
    for step in range(1, len(c)):
        for i in range(len(c) - step):
            c[i] = (1.0 - u) * c[i] + u * c[i + 1]
    return c[0]


@inner
def _least(b: Floats) -> tuple[float, float]:
    """Return where in its interval a polynomial is about least, as a share, and its value there."""
    best, at = np.inf, 0.0
    for i in range(9):
        value = _value(b, i / 8)
        if value < best:
            best, at = value, i / 8
    low, high = max(at - 1 / 8, 0.0), min(at + 1 / 8, 1.0)
    for _ in range(30):  # by thirds
        u, v = low + (high - low) / 3, high - (high - low) / 3
        if _value(b, u) < _value(b, v):
            high = v
        else:
            low = u
    value = _value(b, (low + high) / 2)
    return ((low + high) / 2, value) if value < best else (at, best)


@kernel
def near_at_ends(curves: Curves, a: int, b: int, wide: float, tall: float) -> tuple[float, float]:
    """Return how near two curves' beginnings are, and how near their ends."""
    begins = nearness(place(curves, a, 0.0), place(curves, b, 0.0), wide, tall)
    ends = nearness(place(curves, a, length(curves, a)), place(curves, b, length(curves, b)), wide, tall)
    return begins, ends


@kernel
def is_given(span: Floats, begins: float, ends: float, end: float) -> bool:
    """Tell whether a pair is too close in a span of `meetings` only as its starts or its targets are, never closer.

    Parameters
    ----------
    begins, ends
        How near its starts and its targets are; 1 or more where they are not too close.
    end
        Until when the spans were looked for.
    """
    least = math.sqrt(max(span[3], 0.0)) + SAME
    at_start = begins < 1.0 and span[0] <= 0.0 and least >= begins
    return at_start or (ends < 1.0 and span[1] >= end and least >= ends)


@inner
def clash(
    curves: Curves,
    a: int,
    at_a: float,
    scale_a: float,
    b: int,
    at_b: float,
    scale_b: float,
    wide: float,
    tall: float,
) -> bool:
    """Tell whether two flights are ever too close, and closer than their starts and targets leave no choice about."""
    end = max(at_a + scale_a * length(curves, a), at_b + scale_b * length(curves, b)) + 1.0
    begins, ends = near_at_ends(curves, a, b, wide, tall)
    hasty = min(begins, ends) >= 1.0
    spans = meetings(curves, a, at_a, scale_a, b, at_b, scale_b, wide, tall, end, hasty)
    if hasty:
        return len(spans) > 0
    ordinary = 0
    for span in spans:
        ordinary += not is_given(span, begins, ends, end)
    return ordinary > 0
