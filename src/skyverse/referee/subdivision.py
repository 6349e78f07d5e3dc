"""Branch and bound over the pieces of curves: whether a value is anywhere too large, and where it is largest.

A part of a piece whose upper bound is small enough is done; any other is cut in two until it is decided. Parts that
cannot be decided are not dropped: the question they belong to stays undecided.
"""

import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.interrupt import raise_if_interrupted
from skyverse.referee.polynomial import halve
from skyverse.referee.tolerances import MACHINE_EPSILON, WORST_INSTANT

MAX_DEPTH = 45
"""How often a piece may be cut in two, each time one of the halves before."""
MAX_UNDECIDED_PARTS = 2**15
"""Undecided parts of one question at one depth, beyond which the question stays undecided."""


class Peaks(NamedTuple):
    """The answers to questions, (questions,) each.

    Attributes
    ----------
    value
        The greatest value found, less what rounding may have added to it.
    piece, share
        Where it was found: the index of the piece, and how far along the piece, 0 to 1.
    stuck, stuck_share
        The first place that stayed undecided, the same way; `stuck` is -1 where everything was decided.
    halvings
        How often pieces were cut in two.
    """

    value: Floats
    piece: Indices
    share: Floats
    stuck: Indices
    stuck_share: Floats
    halvings: Indices

    @property
    def refuted(self) -> NDArray[np.bool_]:
        """(questions,) whether some value is above 0."""
        return self.value > 0.0

    @property
    def proven(self) -> NDArray[np.bool_]:
        """(questions,) whether no value is above 0 anywhere."""
        return ~self.refuted & (self.stuck < 0)

    def place(self, k: int = 0) -> tuple[int, float]:
        """Return the piece and the share where a question was refuted, or else where it first stayed undecided."""
        if self.refuted[k]:
            return int(self.piece[k]), float(self.share[k])
        return int(self.stuck[k]), float(self.stuck_share[k])


UpperBound = Callable[[Floats, Indices], Floats]


def greatest_coefficient(b: Floats, piece: Indices) -> Floats:
    """Bound polynomials from above by their greatest Bernstein coefficient."""
    return b.max(axis=1)


def find_peaks(
    b: Floats,
    error: Floats,
    upper_bound: UpperBound = greatest_coefficient,
    question: Indices | None = None,
    questions: int = 1,
) -> Peaks:
    """Tell whether values stay at or below 0, and where they do not, how large they get, to within `WORST_INSTANT`.

    Parameters
    ----------
    b, error
        (n, degree + 1, ...) Bernstein coefficients of pieces, and (n,) bounds on the errors of the values.
    upper_bound
        Takes the coefficients of m parts and the (m,) indices of their pieces, and returns (m,) upper bounds on the
        values; of a single coefficient it must return the value itself.
    question, questions
        (n,) the question that each piece belongs to, and their number; by default all belong to one.
    """
    count = len(b)
    question = np.zeros(count, dtype=np.intp) if question is None else question
    value, where, share = np.full(questions, -np.inf), np.zeros(questions, dtype=np.intp), np.zeros(questions)
    stuck, stuck_share, halvings = np.full(questions, -1), np.zeros(questions), np.zeros(questions, dtype=np.intp)
    # a halving takes `degree` means one after another, and each of them rounds
    error = error + MAX_DEPTH * b.shape[1] * MACHINE_EPSILON * np.abs(b).max(axis=tuple(range(1, b.ndim)))
    max_parts = np.maximum(MAX_UNDECIDED_PARTS, 2 * np.bincount(question, minlength=questions))
    piece, begin, width = np.arange(count), np.zeros(count), 1.0
    for depth in itertools.count():
        raise_if_interrupted()
        of = question[piece]
        ends = [upper_bound(end, piece) - error[piece] for end in (b[:, :1], b[:, -1:])]
        for end, at in zip(ends, (begin, begin + width), strict=True):
            better = np.flatnonzero(end > value[of])
            better = better[np.argsort(end[better])]  # of several in one question the last one, the largest, is kept
            for kept, new in ((value, end), (where, piece), (share, at)):
                kept[of[better]] = new[better]
        upper = upper_bound(b, piece) + error[piece]
        alive = ~(upper <= np.where(value > 0.0, value + WORST_INSTANT, 0.0)[of])
        hopeless = ~(upper - np.maximum(*ends) > 4 * error[piece])  # only rounding is left, or everything is NaN
        crowded = np.bincount(of[alive], minlength=questions) > max_parts
        given_up = np.flatnonzero(alive & (hopeless | crowded[of] | (depth == MAX_DEPTH)))[::-1]
        given_up = given_up[stuck[of[given_up]] < 0]
        stuck[of[given_up]] = piece[given_up]
        stuck_share[of[given_up]] = np.where(ends[0] > ends[1], begin, begin + width)[given_up]
        going_on = alive & ~hopeless & ~crowded[of]
        if depth == MAX_DEPTH or not going_on.any():
            break
        halvings += np.bincount(of[going_on], minlength=questions)
        b, piece, width = np.concatenate(halve(b[going_on])), np.tile(piece[going_on], 2), width / 2
        begin = np.concatenate([begin[going_on], begin[going_on] + width])
    return Peaks(value, where, share, stuck, stuck_share, halvings)
