"""Which bounding boxes overlap: the referee's own spatial index, of two levels."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices

GROUP = 16
"""Boxes that follow one another and are first compared as one."""
PAIRS_AT_ONCE = 1_000_000
"""Pairs of boxes compared in one call of NumPy, which bounds the memory."""


def overlapping_pairs(low: Floats, high: Floats, shape_low: Floats, shape_high: Floats) -> Iterator[Indices]:
    """Yield (pairs, 2) indices of boxes and of shapes' boxes that overlap.

    Groups of boxes are compared with the shapes first, and then each box of those groups that overlap one. A box whose
    corners are NaN overlaps everything.

    Parameters
    ----------
    low, high
        (n, 3) corners of the boxes, metres.
    shape_low, shape_high
        (m, 3) corners of the boxes about the shapes, metres.
    """
    bounds = np.arange(0, len(low), GROUP)
    group_low, group_high = np.minimum.reduceat(low, bounds), np.maximum.reduceat(high, bounds)
    some = np.flatnonzero(~_disjoint(group_low.min(axis=0), group_high.max(axis=0), shape_low, shape_high))
    at_once = max(1, PAIRS_AT_ONCE // len(bounds))
    for first in range(0, len(some), at_once):
        these = some[first : first + at_once]
        group, shape = np.nonzero(
            ~_disjoint(group_low[:, None], group_high[:, None], shape_low[None, these], shape_high[None, these])
        )
        for k in range(0, len(group), PAIRS_AT_ONCE // GROUP):
            member = (bounds[group[k : k + PAIRS_AT_ONCE // GROUP], None] + np.arange(GROUP)).ravel()
            of = np.repeat(these[shape[k : k + PAIRS_AT_ONCE // GROUP]], GROUP)
            member, of = member[member < len(low)], of[member < len(low)]
            both = ~_disjoint(low[member], high[member], shape_low[of], shape_high[of])
            yield np.column_stack([member[both], of[both]])


def _disjoint(low: Floats, high: Floats, other_low: Floats, other_high: Floats) -> NDArray[np.bool_]:
    """Tell which boxes, with corners (..., 3), do not overlap."""
    disjoint = (low[..., 0] >= other_high[..., 0]) | (high[..., 0] <= other_low[..., 0])
    for axis in (1, 2):
        disjoint |= (low[..., axis] >= other_high[..., axis]) | (high[..., axis] <= other_low[..., axis])
    return disjoint
