"""Parts of a curve that is judged for seams, with the shapes that are near each of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.referee.polynomial import halve
from skyverse.referee.solids import GrownSolids
from skyverse.referee.tolerances import HALF_SEAM, LET_PASS, SEAM_SEARCH

WIDENED = LET_PASS + HALF_SEAM
"""Metres by which shapes are widened here: what was let pass is taken back, since seams need no such grace."""


@dataclass(frozen=True, eq=False)
class NearShapes:
    """The shapes of one kind that are near parts of the curve: (k,) numbers of parts and of shapes, and errors."""

    kind: GrownSolids
    part: Indices
    shape: Indices
    error: Floats

    def of(self, parts: Indices) -> "NearShapes":
        """Return what is near some of the parts, rising numbers (m,), which are numbered anew."""
        place = np.searchsorted(parts, self.part)
        some = np.flatnonzero(parts[np.minimum(place, len(parts) - 1)] == self.part) if len(parts) else parts
        return NearShapes(self.kind, place[some], self.shape[some], self.error[some])

    def kept(self, some: NDArray[np.bool_]) -> "NearShapes":
        """Return only some of the pairs."""
        return NearShapes(self.kind, self.part[some], self.shape[some], self.error[some])

    def depth(self, b: Floats) -> Floats:
        """Return upper bounds (k,) on how deep the parts b (n, degree + 1, 3) are inside the widened shapes, metres."""
        if not len(self.part):
            return np.zeros(0)
        return self.kind.depth(b[self.part], self.shape) + WIDENED + self.error

    def deepest(self, b: Floats) -> Floats:
        """Return the greatest of `depth` of each part, (n,) metres; minus infinity where no shape is near."""
        deepest = np.full(len(b), -np.inf)
        np.maximum.at(deepest, self.part, self.depth(b))
        return deepest


@dataclass(frozen=True, eq=False)
class CurveParts:
    """Parts of the curve: coefficients (n, degree + 1, 3), the piece, begin and width of each, and what is near."""

    b: Floats
    piece: Indices
    begin: Floats
    width: Floats
    near: tuple[NearShapes, ...]

    def of(self, which: Indices) -> "CurveParts":
        """Return some of the parts, rising numbers (m,)."""
        near = tuple(near.of(which) for near in self.near)
        return CurveParts(self.b[which], self.piece[which], self.begin[which], self.width[which], near)

    def halved(self) -> "CurveParts":
        """Return both halves of each part: all first ones, then all second ones."""
        width, n = self.width / 2, len(self.b)
        near = tuple(
            NearShapes(one.kind, np.r_[one.part, one.part + n], np.tile(one.shape, 2), np.tile(one.error, 2))
            for one in self.near
        )
        begin = np.concatenate([self.begin, self.begin + width])
        return CurveParts(np.concatenate(halve(self.b)), np.tile(self.piece, 2), begin, np.tile(width, 2), near)

    def points(self, end: int) -> "CurveParts":
        """Return the places where the parts begin (0) or end (-1), as parts."""
        begin = self.begin + (self.width if end else 0.0)
        return CurveParts(self.b[:, [end]], self.piece, begin, np.zeros(len(self.b)), self.near)

    @property
    def extent(self) -> Floats:
        """The longest side of the box around each part, (n,) metres."""
        return (self.b.max(axis=1) - self.b.min(axis=1)).max(axis=1)


@dataclass(frozen=True, eq=False)
class MovableParts:
    """Parts that can be moved, and (n, k) by which of `STEPS`."""

    parts: CurveParts
    allowed: NDArray[np.bool_]

    def with_others(self, other: "MovableParts") -> "MovableParts":
        """Return these and other parts."""
        a, b = self.parts, other.parts
        if not len(a.b):
            return other
        near = tuple(
            NearShapes(
                one.kind,
                np.r_[one.part, two.part + len(a.b)],
                np.r_[one.shape, two.shape],
                np.r_[one.error, two.error],
            )
            for one, two in zip(a.near, b.near, strict=True)
        )
        begin, width = np.r_[a.begin, b.begin], np.r_[a.width, b.width]
        parts = CurveParts(np.concatenate([a.b, b.b]), np.r_[a.piece, b.piece], begin, width, near)
        return MovableParts(parts, np.concatenate([self.allowed, other.allowed]))

    def in_order(self) -> "MovableParts":
        """Return the parts in the order in which they follow one another."""
        parts = self.parts
        order = np.lexsort([parts.begin, parts.piece])
        rank = np.argsort(order)
        near = tuple(NearShapes(one.kind, rank[one.part], one.shape, one.error) for one in parts.near)
        ordered = CurveParts(parts.b[order], parts.piece[order], parts.begin[order], parts.width[order], near)
        return MovableParts(ordered, self.allowed[order])


def shapes_near(kind: GrownSolids, b: Floats, error: Floats) -> NearShapes:
    """Return which shapes of one kind are so near to pieces that a step may meet them."""
    wrong = kind.error(b, error)
    reach = (wrong + WIDENED + SEAM_SEARCH)[:, None]
    pairs = kind.tree.overlapping(b.min(axis=1) - reach, b.max(axis=1) + reach)
    part, shape = np.concatenate([np.zeros((0, 2), dtype=np.intp), *pairs]).T
    return NearShapes(kind, part, shape, wrong[part])
