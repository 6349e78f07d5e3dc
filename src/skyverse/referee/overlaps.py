"""Which bounding boxes overlap: the referee's own spatial index, a tree of boxes about boxes."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices

CHILDREN = 8
"""Boxes that follow one another in the order of the tree, and that one larger box holds."""
PAIRS_AT_ONCE = 500_000
"""Pairs of boxes compared in one call of NumPy, which bounds the memory."""


class BoxTree:
    """A tree of axis-aligned boxes (sort-tile-recursive, S. Leutenegger et al., ICDE 1997).

    The boxes are put into an order in which neighbours lie near each other. Every few of them are held by a larger box,
    every few of these by a still larger one, and so on. Boxes that overlap nothing larger need not be looked at.

    Parameters
    ----------
    low, high
        (m, 3) corners of the boxes, metres.
    """

    def __init__(self, low: Floats, high: Floats) -> None:
        with np.errstate(invalid="ignore"):  # the box about the ground reaches from minus infinity to infinity
            self.order = _tiled((low + high) / 2)
        self.levels = [(low[self.order], high[self.order])]
        while len(self.levels[-1][0]) > CHILDREN:
            lower, upper = self.levels[-1]
            begins = np.arange(0, len(lower), CHILDREN)
            self.levels.append((np.minimum.reduceat(lower, begins), np.maximum.reduceat(upper, begins)))

    def overlapping(self, low: Floats, high: Floats) -> Iterator[Indices]:
        """Yield (pairs, 2) indices of boxes with corners (n, 3), and of boxes of the tree that overlap them.

        A box whose corners are NaN overlaps everything.
        """
        return self._pairs(_Boxes(low, high))

    def near_segments(self, starts: Floats, ends: Floats, wide: Floats) -> Iterator[Indices]:
        """Yield (pairs, 2) indices of segments, and of boxes of the tree that they may run through.

        The box about a long slanted segment overlaps much that is far from it: here the segment itself is asked.
        A segment that is no number is near everything.

        Parameters
        ----------
        starts, ends
            (n, 3) metres.
        wide
            (n,) metres by which segments are thickened along each axis; it contains what rounding may make of them.
        """
        thick = wide[:, None]
        low, high = np.minimum(starts, ends) - thick, np.maximum(starts, ends) + thick
        return self._pairs(_Segments(_Boxes(low, high), (starts + ends) / 2, ends - starts, wide))

    def _pairs(self, asked: "_Boxes | _Segments") -> Iterator[Indices]:
        """Yield (pairs, 2) indices of what is asked for, and of boxes of the tree that it is near."""
        top = len(self.levels) - 1
        roots = len(self.levels[top][0])
        for some in (np.arange(asked.size)[block] for block in blocks(asked.size, PAIRS_AT_ONCE, roots)):
            one, node = np.repeat(some, roots), np.tile(np.arange(roots), len(some))
            for pairs in self._below(top, asked, one, node):
                yield np.column_stack([pairs[0], self.order[pairs[1]]])

    def _below(
        self, level: int, asked: "_Boxes | _Segments", one: Indices, node: Indices
    ) -> Iterator[tuple[Indices, Indices]]:
        """Yield all pairs that are near, below given pairs of what is asked for and nodes of a level of the tree."""
        lower, upper = self.levels[level]
        for block in blocks(len(one), PAIRS_AT_ONCE):
            some, at = one[block], node[block]
            some, at = asked.near(some, at, lower, upper)
            if level == 0:
                yield some, at
            elif len(some):
                child = (at[:, None] * CHILDREN + np.arange(CHILDREN)).ravel()
                parent = np.repeat(some, CHILDREN)
                real = child < len(self.levels[level - 1][0])
                yield from self._below(level - 1, asked, parent[real], child[real])


class _Boxes(NamedTuple):
    """Boxes with corners (n, 3), metres."""

    low: Floats
    high: Floats

    @property
    def size(self) -> int:
        """How many there are."""
        return len(self.low)

    def near(self, some: Indices, at: Indices, lower: Floats, upper: Floats) -> tuple[Indices, Indices]:
        """Return the pairs (k,) of some of the boxes, and of other boxes with corners (m, 3), that overlap.

        The altitude comes first: most of what is flown over or under ends there.
        """
        for axis in (2, 0, 1):
            apart = (self.low[some, axis] >= upper[at, axis]) | (self.high[some, axis] <= lower[at, axis])
            some, at = some[~apart], at[~apart]
        return some, at


class _Segments(NamedTuple):
    """Thick segments.

    Attributes
    ----------
    about
        The boxes about them.
    middle, way
        (n, 3) metres: their middles, and from their starts to their ends.
    wide
        (n,) metres by which they are thickened along each axis.
    """

    about: _Boxes
    middle: Floats
    way: Floats
    wide: Floats

    @property
    def size(self) -> int:
        """How many there are."""
        return self.about.size

    def near(self, some: Indices, at: Indices, lower: Floats, upper: Floats) -> tuple[Indices, Indices]:
        """Return the pairs (k,) of some of the segments, and of boxes with corners (m, 3) that they run through.

        Two convex shapes are apart if they are apart along an axis. For a segment and a box these are the three axes of
        the box, and the three that are perpendicular to one of these and to the segment.
        """
        some, at = self.about.near(some, at, lower, upper)
        low, high, way = lower[at], upper[at], self.way[some]
        apart = np.zeros(len(some), dtype=np.bool_)
        with np.errstate(invalid="ignore"):  # the ground's box is infinite, and nothing is apart from it
            off, half = self.middle[some] - (low + high) / 2, (high - low) / 2 + self.wide[some][:, None]
            reach = np.abs(way)
            for i, j in ((0, 1), (1, 2), (2, 0)):
                across = np.abs(off[:, i] * way[:, j] - off[:, j] * way[:, i])
                apart |= across > half[:, i] * reach[:, j] + half[:, j] * reach[:, i]
        return some[~apart], at[~apart]


def _tiled(middles: Floats) -> Indices:
    """Return an order of places (m, 3) in which neighbours are near: slabs along x, in them rows along y, then by z."""
    count = len(middles)
    if not count or not np.isfinite(middles).all():
        return np.arange(count)
    slabs = int(np.ceil((count / CHILDREN) ** (1 / 3)))
    along_x = _ranks(middles[:, 0]) * slabs // count
    row = _ranks(middles[:, 1] + along_x * (2 * np.ptp(middles[:, 1]) + 1)) * slabs**2 // count
    return np.lexsort((middles[:, 2], row))


def _ranks(values: Floats) -> Indices:
    """Return the place of each value (m,) in the order of size."""
    ranks = np.empty(len(values), dtype=np.intp)
    ranks[np.argsort(values, kind="stable")] = np.arange(len(values))
    return ranks


def blocks(count: int, most: int, size: int = 1) -> Iterator[slice]:
    """Yield the slices of consecutive blocks of `count` items that take `size` numbers each.

    A block takes `most` numbers, or less; one item may take more.
    """
    items = most // max(size, 1) or 1
    return (slice(first, first + items) for first in range(0, count, items))
