"""The Newton step of a spline: a banded matrix for its control points, bordered by a few durations.

With the gradients p of the control points and x of the logarithms of durations, the step (dp, dx) solves

    [ A    C^T ] [ dp ]     [ p ]
    [ C    D   ] [ dx ] = - [ x ].

A is banded, since a control point depends on its neighbours only, and is factored as ``A = L L^T`` (Cholesky). With
``w = L^-1 p`` and ``K = C L^-T`` the durations follow from the small Schur complement S,

    S dx = -(x - K w),    S = D - K K^T,    and then    dp = -L^-T (w + K^T dx).

The square of the Newton decrement, by which the objective decreases per unit of the step, is
``w . w + (x - K w) . S^-1 (x - K w)``.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner
from skyverse.numerics.tolerances import DIAGONAL_FLOOR, MIN_PIVOT

BAND = 15
"""Entries of a row of A from its diagonal on: five control points of three coordinates."""
FIRST_SHIFT, SHIFT_FACTOR, MAX_SHIFT = 1e-3, 4.0, 1e12
"""Multiples of D's diagonal that are added to S where it is not positive definite: the first, the next, the largest."""


class NewtonSystem(NamedTuple):
    """Newton's equations by the coordinates of F free control points and by the logarithms of B durations.

    Attributes
    ----------
    band
        (3 F, BAND) the upper half of A, row by row from its diagonal on.
    by_points
        (3 F,) the gradient p.
    cross
        (B, 3 F) the block C.
    small
        (B, B) the block D.
    by_durations
        (B,) the gradient x.
    """

    band: Floats
    by_points: Floats
    cross: Floats
    small: Floats
    by_durations: Floats


@inner
def solve_newton_system(system: NewtonSystem) -> float:
    """Replace the gradients by the step, and return the square of the Newton decrement.

    Where S is not positive definite, multiples of D's diagonal are added to it, so that the durations change less.
    """
    band, n, boxes = system.band, len(system.by_points), len(system.by_durations)
    _factor(band)
    first = np.zeros(boxes, np.int64)
    for b in range(boxes):
        while first[b] < n and system.cross[b, first[b]] == 0.0:
            first[b] += 1
        _forward(band, system.cross[b], first[b])
    step = system.by_points.copy()
    _forward(band, step, 0)
    decrement = 0.0
    for i in range(n):
        decrement += step[i] ** 2
    schur, slope = system.small.copy(), system.by_durations.copy()
    for b in range(boxes):
        for i in range(first[b], n):
            slope[b] -= system.cross[b, i] * step[i]
        for c in range(b + 1):
            total = 0.0
            for i in range(max(first[b], first[c]), n):
                total += system.cross[b, i] * system.cross[c, i]
            schur[b, c] -= total
    more = 0.0
    factor = schur.copy()
    while not _cholesky(factor):
        more = max(SHIFT_FACTOR * more, FIRST_SHIFT)
        if not more < MAX_SHIFT:  # numbers have overflowed: return no step
            system.by_points.fill(0.0)
            system.by_durations.fill(0.0)
            return 0.0
        factor = schur.copy()
        for b in range(boxes):
            factor[b, b] += more * (abs(system.small[b, b]) + DIAGONAL_FLOOR)
    change = np.empty(boxes)
    for b in range(boxes):
        change[b] = -slope[b]
        for c in range(b):
            change[b] -= factor[b, c] * change[c]
        change[b] /= factor[b, b]
    for b in range(boxes - 1, -1, -1):
        for c in range(b + 1, boxes):
            change[b] -= factor[c, b] * change[c]
        change[b] /= factor[b, b]
    for b in range(boxes):
        decrement -= slope[b] * change[b]
        for i in range(first[b], n):
            step[i] += system.cross[b, i] * change[b]
    _backward(band, step)
    for i in range(n):
        system.by_points[i] = -step[i]
    for b in range(boxes):
        system.by_durations[b] = change[b]
    return decrement


@inner
def _cholesky(a: Floats) -> bool:
    """Factor the lower half of a symmetric matrix in place (Cholesky); tell whether it is positive definite."""
    n = len(a)
    for i in range(n):
        for j in range(i + 1):
            total = a[i, j]
            for k in range(j):
                total -= a[i, k] * a[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                a[i, i] = np.sqrt(total)
            else:
                a[i, j] = total / a[j, j]
    return True


@inner
def _factor(band: Floats) -> None:
    """Factor a banded positive definite matrix in place (Cholesky)."""
    n = len(band)
    for i in range(n):
        pivot = 1.0 / np.sqrt(max(band[i, 0], MIN_PIVOT))
        last = min(BAND, n - i)
        for j in range(last):
            band[i, j] *= pivot
        for p in range(1, last):
            c = band[i, p]
            if c != 0.0:
                for q in range(p, last):
                    band[i + p, q - p] -= c * band[i, q]


@inner
def _forward(band: Floats, x: Floats, first: int) -> None:
    """Multiply x by L^-1 in place; its entries before `first` are 0."""
    n = len(x)
    for i in range(first, n):
        x[i] /= band[i, 0]
        for p in range(1, min(BAND, n - i)):
            x[i + p] -= band[i, p] * x[i]


@inner
def _backward(band: Floats, x: Floats) -> None:
    """Multiply x by L^-T in place."""
    n = len(x)
    for i in range(n - 1, -1, -1):
        for p in range(1, min(BAND, n - i)):
            x[i] -= band[i, p] * x[i + p]
        x[i] /= band[i, 0]
