"""Quartic splines over spans of unequal durations h_0, h_1, and so on, by their control points P_0, P_1, and so on.

They are three times continuously differentiable, and each span lies within the hull of its five control points. The
control points of a derivative are differences of those of the derivative before it, divided by the duration of some
spans; spans before the first and after the last take no time:

    velocity        V_i = 4 (P_{i+1} - P_i) / (h_{i-3} + ... + h_i)
    acceleration    A_i = 3 (V_{i+1} - V_i) / (h_{i-2} + ... + h_i)
    jerk            J_i = 2 (A_{i+1} - A_i) / (h_{i-1} + h_i)
    snap            S_i =   (J_{i+1} - J_i) / h_i.

So control point i of a derivative is a row of coefficients times the control points from P_i on. The row depends on the
durations of the corridor boxes in which its spans lie, and these are two boxes at most. With each coefficient its
derivatives by the logarithms of both durations are kept, together a jet of six numbers: the value; its derivatives by
the first and by the second; its second derivatives by the first twice, by both, and by the second twice.
"""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, kernel

DEGREE = 4
JET = 6


@kernel
def time_of(spans: Floats, first: int, last: int) -> float:
    """Return the duration of spans `first` to `last`, both included, seconds; spans that do not exist take no time."""
    total = 0.0
    for k in range(max(first, 0), min(last, len(spans) - 1) + 1):
        total += spans[k]
    return total


@kernel
def make_rows(spans: Floats, order: int) -> Floats:
    """Return the rows (N - order, order + 1) of the derivative of an order: 1 for velocity to 4 for snap."""
    n = len(spans) + DEGREE
    rows = np.ones((n, 1))
    for k in range(1, order + 1):
        lower = np.zeros((n - k, k + 1))
        for i in range(n - k):
            per = (DEGREE + 1 - k) / time_of(spans, i - DEGREE + k, i)
            for j in range(k):
                lower[i, j] -= per * rows[i, j]
                lower[i, j + 1] += per * rows[i + 1, j]
        rows = lower
    return rows


@inner
def multiply(a: Floats, b: Floats, out: Floats, sign: float) -> None:
    """Add the product of two jets, times a sign, to a third jet (Leibniz's rule)."""
    out[0] += sign * a[0] * b[0]
    out[1] += sign * (a[1] * b[0] + a[0] * b[1])
    out[2] += sign * (a[2] * b[0] + a[0] * b[2])
    out[3] += sign * (a[3] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[3])
    out[4] += sign * (a[4] * b[0] + a[1] * b[2] + a[2] * b[1] + a[0] * b[4])
    out[5] += sign * (a[5] * b[0] + 2.0 * a[2] * b[2] + a[0] * b[5])


@inner
def _per_time(spans: Floats, box_of: Ints, left: int, first: int, last: int, degree: float, out: Floats) -> None:
    """Write the jet of ``degree / time_of(spans, first, last)``."""
    one = two = 0.0
    for k in range(max(first, 0), min(last, len(spans) - 1) + 1):
        if box_of[k] == left:
            one += spans[k]
        else:
            two += spans[k]
    r = 1.0 / (one + two)
    out[0] = degree * r
    out[1] = -degree * one * r * r
    out[2] = -degree * two * r * r
    out[3] = degree * (2.0 * one * one * r - one) * r * r
    out[4] = degree * 2.0 * one * two * r * r * r
    out[5] = degree * (2.0 * two * two * r - two) * r * r


@kernel
def row_jet(spans: Floats, box_of: Ints, left: int, i: int, order: int, work: Floats, out: Floats) -> None:
    """Write the jets of row i of a derivative into ``out[: order + 1]``, by the durations of box `left` and the next.

    `work`, (2, 5, 5, 6), holds the rows from i on of two successive derivatives in turn.
    """
    per = work[0, 4, 4]
    for j in range(order + 1):
        for e in range(JET):
            work[0, j, 0, e] = 0.0
        work[0, j, 0, 0] = 1.0
    for k in range(1, order + 1):
        above, below = work[(k + 1) % 2], work[k % 2]
        for j in range(order + 1 - k):
            for c in range(k + 1):
                for e in range(JET):
                    below[j, c, e] = 0.0
            at = i + j
            per = out[5]
            _per_time(spans, box_of, left, at - DEGREE + k, at, float(DEGREE + 1 - k), per)
            for c in range(k):
                multiply(per, above[j, c], below[j, c], -1.0)
                multiply(per, above[j + 1, c], below[j, c + 1], 1.0)
    for c in range(order + 1):
        for e in range(JET):
            out[c, e] = work[order % 2, 0, c, e]


@kernel
def refine(points: Floats, spans: Floats, parts: Ints) -> tuple[Floats, Floats]:
    """Return the control points and spans of the same spline with every span cut into a number of equal parts.

    A control point is the value of the spline's polar form (blossom) at four consecutive knots.
    """
    begins = _instants(spans)
    count = parts.sum()
    finer, old = np.empty(count), np.empty(count, np.int64)
    at = 0
    for k in range(len(spans)):
        for _ in range(parts[k]):
            finer[at], old[at] = spans[k] / parts[k], k
            at += 1
    knots = _instants(finer)
    knots[-1] = begins[-1]
    n = count + DEGREE
    result = np.empty((n, 3))
    work = np.empty((DEGREE + 1, 3))
    for i in range(n):
        k = old[min(max(i - DEGREE // 2, 0), count - 1)]  # the middle one of the spans that the point influences
        for j in range(DEGREE + 1):
            for a in range(3):
                work[j, a] = points[k + j, a]
        for level in range(1, DEGREE + 1):
            t = knots[min(max(i - DEGREE + level, 0), count)]
            for j in range(DEGREE + 1 - level):
                before = begins[max(k + j - DEGREE + level, 0)]
                after = begins[min(k + j + 1, len(spans))]
                share = (t - before) / (after - before)
                for a in range(3):
                    work[j, a] += share * (work[j + 1, a] - work[j, a])
        for a in range(3):
            result[i, a] = work[0, a]
    return result, finer


@inner
def _instants(spans: Floats) -> Floats:
    """Return the instants (S + 1,) at which the spans begin and the last one ends."""
    instants = np.zeros(len(spans) + 1)
    for k in range(len(spans)):
        instants[k + 1] = instants[k] + spans[k]
    return instants
