"""Polynomials as Bernstein coefficients, with proven bounds on the rounding errors of the coefficients.

On its interval a polynomial lies between its least and its greatest Bernstein coefficient, and at the ends of the
interval it takes the values of the first and the last one. Halving the interval makes these bounds four times as tight
(G. Farin, "Curves and Surfaces for CAGD").
"""

from dataclasses import dataclass
from functools import reduce
from math import comb
from typing import Self

import numpy as np

from skyverse._typing import Floats
from skyverse.referee.tolerances import MACHINE_EPSILON as EPS


@dataclass(frozen=True, eq=False)
class Polynomials:
    """A batch of polynomials of one degree.

    Attributes
    ----------
    b
        (n, degree + 1) Bernstein coefficients, one polynomial in each row.
    error
        (n,) bounds on the absolute errors of the coefficients in each row.
    """

    b: Floats
    error: Floats

    @property
    def degree(self) -> int:
        """The degree of all polynomials in the batch."""
        return int(self.b.shape[1]) - 1

    @property
    def size(self) -> Floats:
        """(n,) upper bounds on the absolute values of the polynomials."""
        return np.abs(self.b).max(axis=1) + self.error

    def raised(self, degree: int) -> Self:
        """Return the same polynomials with the coefficients of a higher degree."""
        if degree == self.degree:
            return self
        return self * type(self)(np.ones((1, degree - self.degree + 1)), np.zeros(1))

    def __add__(self, other: Self | float) -> Self:
        """Add polynomials, or a number."""
        if isinstance(other, Polynomials):
            degree = max(self.degree, other.degree)
            one, two = self.raised(degree), other.raised(degree)
            b, error = one.b + two.b, one.error + two.error
        else:
            b, error = self.b + other, self.error
        return type(self)(b, error + EPS * np.abs(b).max(axis=1))

    def __mul__(self, other: Self | float) -> Self:
        """Multiply by polynomials, or by a number."""
        if not isinstance(other, Polynomials):
            return type(self)(self.b * other, self.error * abs(other) + EPS * self.size * abs(other))
        m, n = self.degree, other.degree
        one, two = self.b * _binomials(m), other.b * _binomials(n)
        b = np.zeros((max(len(one), len(two)), m + n + 1))
        for i in range(m + 1):
            b[:, i : i + n + 1] += one[:, i : i + 1] * two
        # each coefficient is a weighted mean of products: its error comes from the factors and from rounding one sum
        error = self.size * other.error + other.size * self.error + (m + n + 8) * EPS * self.size * other.size
        return type(self)(b / _binomials(m + n), error)

    def __sub__(self, other: Self) -> Self:
        """Subtract polynomials."""
        return self + other * -1.0


def _binomials(n: int) -> Floats:
    return np.array([comb(n, k) for k in range(n + 1)], dtype=np.float64)


def bernstein(rows: Floats, durations: Floats) -> list[Polynomials]:
    """Return x, y and z, as batches of n, of (n, degree + 1, 3) power-basis rows on [0, duration], (n,) seconds."""
    degree = rows.shape[1] - 1
    scaled = rows * (durations[:, None] ** np.arange(degree + 1))[:, :, None]
    mix = np.array([[comb(i, j) / comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)])
    b = np.einsum("ij,njk->nik", mix, scaled)
    error = (3 * degree + 8) * EPS * np.abs(scaled).sum(axis=1)
    return [Polynomials(np.ascontiguousarray(b[:, :, axis]), error[:, axis]) for axis in range(3)]


def squared(parts: list[Polynomials]) -> Polynomials:
    """Return the sum of the squares of polynomials, row by row."""
    return reduce(lambda total, part: total + part, [part * part for part in parts])


def stack(parts: list[Polynomials]) -> Polynomials:
    """Return batches of one degree as one batch."""
    return Polynomials(np.concatenate([part.b for part in parts]), np.concatenate([part.error for part in parts]))


def halve(b: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients (n, degree + 1, ...) on both halves of the intervals, by de Casteljau's algorithm."""
    degree = b.shape[1] - 1
    left, right = b.copy(), b.copy()
    for k in range(1, degree + 1):
        b = (b[:, 1:] + b[:, :-1]) / 2
        left[:, k], right[:, degree - k] = b[:, 0], b[:, -1]
    return left, right
