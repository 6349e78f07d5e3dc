"""Which bounding boxes overlap: the referee's own spatial index, a tree of boxes about boxes."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.referee.blocks import blocks

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
        top = len(self.levels) - 1
        roots = len(self.levels[top][0])
        for some in (np.arange(len(low))[block] for block in blocks(len(low), PAIRS_AT_ONCE, roots)):
            box, node = np.repeat(some, roots), np.tile(np.arange(roots), len(some))
            for pairs in self._below(top, low, high, box, node):
                yield np.column_stack([pairs[0], self.order[pairs[1]]])

    def _below(
        self, level: int, low: Floats, high: Floats, box: Indices, node: Indices
    ) -> Iterator[tuple[Indices, Indices]]:
        """Yield the overlapping pairs below pairs of boxes and nodes of one level of the tree."""
        lower, upper = self.levels[level]
        for block in blocks(len(box), PAIRS_AT_ONCE):
            some, at = box[block], node[block]
            both = ~_disjoint(low[some], high[some], lower[at], upper[at])
            some, at = some[both], at[both]
            if level == 0:
                yield some, at
            elif len(some):
                child = (at[:, None] * CHILDREN + np.arange(CHILDREN)).ravel()
                parent = np.repeat(some, CHILDREN)
                real = child < len(self.levels[level - 1][0])
                yield from self._below(level - 1, low, high, parent[real], child[real])


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


def _disjoint(low: Floats, high: Floats, other_low: Floats, other_high: Floats) -> NDArray[np.bool_]:
    """Tell which boxes, with corners (..., 3), do not overlap."""
    disjoint = (low[..., 0] >= other_high[..., 0]) | (high[..., 0] <= other_low[..., 0])
    for axis in (1, 2):
        disjoint |= (low[..., axis] >= other_high[..., axis]) | (high[..., axis] <= other_low[..., axis])
    return disjoint
