"""Polynomials that can be bounded for certain: Bernstein coefficients, with their rounding errors.

On its interval a polynomial lies between its least and its greatest Bernstein coefficient, and takes the first and the
last at its ends. Halving the interval makes the bounds four times as tight (G. Farin, "Curves and Surfaces for CAGD").
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from math import comb
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices

DEPTH = 45
"""How often a piece may be cut in two, one within the other."""
MOST = 2**15
"""Undecided parts of one question, beyond which it stays undecided."""
EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Polynomials:
    """(n, degree + 1) Bernstein coefficients, one polynomial a row, and (n,) bounds on the errors in each row."""

    b: Floats
    error: Floats

    @property
    def degree(self) -> int:
        """The same for all."""
        return int(self.b.shape[1]) - 1

    @property
    def size(self) -> Floats:
        """(n,) upper bounds on the absolute values."""
        size: Floats = np.abs(self.b).max(axis=1) + self.error
        return size

    def raised(self, degree: int) -> Self:
        """Return the same polynomials, written with a higher degree."""
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
        # each coefficient is a mean, so its error is that of the factors and of the roundings of one sum
        error = self.size * other.error + other.size * self.error + (m + n + 8) * EPS * self.size * other.size
        return type(self)(b / _binomials(m + n), error)

    def __sub__(self, other: Self) -> Self:
        """Subtract polynomials."""
        return self + other * -1.0


def _binomials(n: int) -> Floats:
    return np.array([comb(n, k) for k in range(n + 1)], dtype=np.float64)


def bernstein(rows: Floats, durations: Floats) -> list[Polynomials]:
    """Return x, y and z of (n, degree + 1, 3) power-basis rows, each on [0, duration]."""
    degree = rows.shape[1] - 1
    scaled = rows * (durations[:, None] ** np.arange(degree + 1))[:, :, None]
    mix = np.array([[comb(i, j) / comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)])
    b = np.einsum("ij,njk->nik", mix, scaled)
    error = (3 * degree + 8) * EPS * np.abs(scaled).sum(axis=1)
    return [Polynomials(np.ascontiguousarray(b[:, :, axis]), error[:, axis]) for axis in range(3)]


def squared(parts: list[Polynomials]) -> Polynomials:
    """Return the sum of the squares."""
    return reduce(lambda total, part: total + part, [part * part for part in parts])


def stack(parts: list[Polynomials]) -> Polynomials:
    """Return polynomials of one degree as one batch."""
    return Polynomials(np.concatenate([part.b for part in parts]), np.concatenate([part.error for part in parts]))


def halve(b: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients (n, degree + 1, ...) on both halves: de Casteljau's algorithm."""
    degree = b.shape[1] - 1
    left, right = b.copy(), b.copy()
    for k in range(1, degree + 1):
        b = (b[:, 1:] + b[:, :-1]) / 2
        left[:, k], right[:, degree - k] = b[:, 0], b[:, -1]
    return left, right


class Peaks(NamedTuple):
    """What was found of each question.

    Attributes
    ----------
    value
        The greatest value seen, less what rounding may have added.
    piece, share
        Where: index of the piece, and how far along it, 0 to 1.
    stuck, stuck_share
        The first place that stayed undecided, -1 where none did.
    halvings
        How often pieces were cut in two.
    """

    value: Floats
    piece: Indices
    share: Floats
    stuck: Indices
    stuck_share: Floats
    halvings: Indices

    def refuted(self, enough: float) -> NDArray[np.bool_]:
        """Tell whose greatest value is above `enough`."""
        return self.value > enough

    def proven(self, enough: float) -> NDArray[np.bool_]:
        """Tell whose values are nowhere above `enough`."""
        return ~self.refuted(enough) & (self.stuck < 0)


Bound = Callable[[Floats, Indices], Floats]


def largest(b: Floats, piece: Indices) -> Floats:
    """Bound polynomials from above by their coefficients."""
    bound: Floats = b.max(axis=1)
    return bound


def greatest(
    b: Floats,
    error: Floats,
    enough: float,
    fine: float,
    bound: Bound = largest,
    group: Indices | None = None,
    groups: int = 1,
) -> Peaks:
    """Tell whether values stay at or below `enough`, and where they do not, how high they go, to within `fine`.

    Parameters
    ----------
    b, error
        (n, degree + 1, ...) Bernstein coefficients, and (n,) bounds on their errors.
    enough, fine
        In the unit of the values.
    bound
        Gives upper bounds (m,) from coefficients and the indices (m,) of the pieces that they are parts of; of a single
        coefficient it must be the value itself.
    group, groups
        Which of so many questions each piece belongs to, (n,); all to one, by default.
    """
    count = len(b)
    group = np.zeros(count, dtype=np.intp) if group is None else group
    value, where, share = np.full(groups, -np.inf), np.zeros(groups, dtype=np.intp), np.zeros(groups)
    stuck, stuck_share, halvings = np.full(groups, -1), np.zeros(groups), np.zeros(groups, dtype=np.intp)
    # halving takes means, `degree` one after another
    error = error + DEPTH * b.shape[1] * EPS * np.abs(b).max(axis=tuple(range(1, b.ndim)))
    crowd = np.maximum(MOST, 2 * np.bincount(group, minlength=groups))
    piece, at, width = np.arange(count), np.zeros(count), 1.0
    for depth in range(DEPTH + 1):
        of = group[piece]
        ends = [bound(end, piece) - error[piece] for end in (b[:, :1], b[:, -1:])]
        for end, there in zip(ends, (at, at + width), strict=True):
            better = np.flatnonzero(end > value[of])
            better = better[np.argsort(end[better])]  # of several in a group the last one, the highest, is kept
            for kept, new in ((value, end), (where, piece), (share, there)):
                kept[of[better]] = new[better]
        upper = bound(b, piece) + error[piece]
        alive = ~(upper <= np.where(value > enough, value + fine, enough)[of])
        hopeless = ~(upper - np.maximum(*ends) > 4 * error[piece])  # rounding is all that is left, or all is NaN
        crowded = np.bincount(of[alive], minlength=groups) > crowd
        gives_up = np.flatnonzero(alive & (hopeless | crowded[of] | (depth == DEPTH)))[::-1]
        gives_up = gives_up[stuck[of[gives_up]] < 0]
        stuck[of[gives_up]] = piece[gives_up]
        stuck_share[of[gives_up]] = np.where(ends[0] > ends[1], at, at + width)[gives_up]
        going = alive & ~hopeless & ~crowded[of]
        if depth == DEPTH or not going.any():
            break
        halvings += np.bincount(of[going], minlength=groups)
        b, piece, width = np.concatenate(halve(b[going])), np.tile(piece[going], 2), width / 2
        at = np.concatenate([at[going], at[going] + width])
    return Peaks(value, where, share, stuck, stuck_share, halvings)
