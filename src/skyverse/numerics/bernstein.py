"""Polynomials in Bernstein form: the coefficients enclose the values, and halving the interval tightens that.

A polynomial of degree n on [0, duration] has n + 1 coefficients, or as many rows of them for several polynomials. On
the whole interval it stays between the least and the greatest coefficient (Farouki, "The Bernstein polynomial basis: a
centennial retrospective", Computer Aided Geometric Design 29 (2012) 379-419).
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel


@kernel
def binomials(n: int) -> Floats:
    """Return row n of Pascal's triangle, (n + 1,)."""
    row = np.ones(n + 1)
    for i in range(n):
        row[i + 1] = row[i] * (n - i) / (i + 1)
    return row


@kernel
def to_bernstein(rows: Floats, duration: float) -> Floats:
    """Turn power-basis coefficients in local time, (n + 1, k), into Bernstein coefficients on [0, duration]."""
    n = len(rows) - 1
    row = binomials(n)
    scaled = np.empty(rows.shape)
    power = 1.0
    for i in range(n + 1):
        for column in range(rows.shape[1]):
            scaled[i, column] = rows[i, column] * (power / row[i])
        power *= duration
    # b_j = sum over i of C(j, i) scaled_i, as running sums of Pascal's rule
    for first in range(n, 0, -1):
        for i in range(first, n + 1):
            for column in range(rows.shape[1]):
                scaled[i, column] += scaled[i - 1, column]
    return scaled


@kernel
def halve(b: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients of both halves of the interval, (n + 1, k) each (de Casteljau)."""
    left, right = np.empty(b.size), b.copy().reshape(-1)
    split(right, left, b.shape[1])
    return left.reshape(b.shape), right.reshape(b.shape)


@inner
def split(b: Floats, left: Floats, k: int) -> None:
    """Halve the interval without new arrays: `b` becomes the right half, `left` the left one; rows of k, end to end."""
    last = len(b) - k
    for column in range(k):
        left[column] = b[column]
    for begin in range(k, last + k, k):
        for i in range(last + k - begin):
            b[i] = 0.5 * (b[i] + b[i + k])
        for column in range(k):
            left[begin + column] = b[column]


@kernel
def part(b: Floats, u: float, v: float) -> Floats:
    """Return the coefficients (n + 1, k) of the piece between the shares u < v of the interval."""
    left, _ = _cut(b, v)
    _, piece = _cut(left, u / v)
    return piece


@inner
def _cut(b: Floats, u: float) -> tuple[Floats, Floats]:
    """Return the coefficients (n + 1, k) before and after the share u of the interval."""
    n, k = len(b) - 1, b.shape[1]
    left, right = np.empty((n + 1, k)), np.empty((n + 1, k))
    for column in range(k):  # numbers, not rows: slices of arrays are slow to make
        for i in range(n + 1):
            right[i, column] = b[i, column]
        left[0, column] = b[0, column]
        for step in range(1, n + 1):
            for i in range(n + 1 - step):
                right[i, column] = (1.0 - u) * right[i, column] + u * right[i + 1, column]
            left[step, column] = right[0, column]
    return left, right


@kernel
def product(a: Floats, b: Floats) -> Floats:
    """Return the coefficients (m + n + 1,) of the product of two polynomials, (m + 1,) and (n + 1,)."""
    m, n = len(a) - 1, len(b) - 1
    of_a, of_b = binomials(m), binomials(n)
    result = np.zeros(m + n + 1)
    for i in range(m + 1):
        for j in range(n + 1):
            result[i + j] += of_a[i] * a[i] * of_b[j] * b[j]
    of_both = binomials(m + n)
    for k in range(m + n + 1):
        result[k] /= of_both[k]
    return result
