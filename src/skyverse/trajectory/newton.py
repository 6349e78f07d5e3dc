"""Newton's equations, solved: points hang on their neighbours only, and a few durations border them.

A banded Cholesky factorisation, and a small dense Schur complement.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner

BAND = 15
"""Entries of a row of the banded matrix from its diagonal on: five points, three axes."""


class System(NamedTuple):
    """Newton's equations: points (free ones only) and logarithms of durations.

    Attributes
    ----------
    band
        (3 F, BAND) the upper half of the points' matrix.
    rise
        (3 F,) the gradient by the points.
    cross
        (B, 3 F) points and durations.
    small
        (B, B) durations.
    slope
        (B,) the gradient by the durations.
    """

    band: Floats
    rise: Floats
    cross: Floats
    small: Floats
    slope: Floats


@inner
def solve(system: System) -> float:
    """Solve the equations in place; return the decrease that the step promises.

    Where they are not convex by the durations, those are made to move less.
    """
    band, n, boxes = system.band, len(system.rise), len(system.slope)
    _factor(band)
    first = np.zeros(boxes, np.int64)
    for b in range(boxes):
        while first[b] < n and system.cross[b, first[b]] == 0.0:
            first[b] += 1
        _forward(band, system.cross[b], first[b])
    step = system.rise.copy()
    _forward(band, step, 0)
    promise = 0.0
    for i in range(n):
        promise += step[i] ** 2
    schur, slope = system.small.copy(), system.slope.copy()
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
        more = max(4.0 * more, 1e-3)
        if not more < 1e12:  # numbers have overflowed: no step is worth taking
            system.rise.fill(0.0)
            system.slope.fill(0.0)
            return 0.0
        factor = schur.copy()
        for b in range(boxes):
            factor[b, b] += more * (abs(system.small[b, b]) + 1e-9)
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
        promise -= slope[b] * change[b]
        for i in range(first[b], n):
            step[i] += system.cross[b, i] * change[b]
    _backward(band, step)
    for i in range(n):
        system.rise[i] = -step[i]
    for b in range(boxes):
        system.slope[b] = change[b]
    return promise


@inner
def _cholesky(a: Floats) -> bool:
    """Factor a symmetric matrix in place, lower half; tell whether it is positive definite."""
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
    """Factor a banded positive definite matrix in place, by Cholesky's method."""
    n = len(band)
    for i in range(n):
        pivot = 1.0 / np.sqrt(max(band[i, 0], 1e-300))
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
    """Solve by the lower factor in place, from the first entry that is not zero."""
    n = len(x)
    for i in range(first, n):
        x[i] /= band[i, 0]
        for p in range(1, min(BAND, n - i)):
            x[i + p] -= band[i, p] * x[i]


@inner
def _backward(band: Floats, x: Floats) -> None:
    """Solve by the upper factor in place."""
    n = len(x)
    for i in range(n - 1, -1, -1):
        for p in range(1, min(BAND, n - i)):
            x[i] -= band[i, p] * x[i + p]
        x[i] /= band[i, 0]
