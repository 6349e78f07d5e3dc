"""Voxels as few boxes: runs along x, equal runs side by side joined along y, and equal plates joined along z."""

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Ints


def disjoint_boxes(occupied: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """Return boxes that hold exactly the occupied cells, each cell in one box.

    Parameters
    ----------
    occupied
        (nx, ny, nz) booleans.

    Returns
    -------
    first, beyond
        (m, 3) indices of each box's first cell, and of the cell diagonally beyond its last one.
    """
    edges = np.diff(occupied.astype(np.int8), axis=0, prepend=0, append=0)
    # in this order of axes, the n-th run to begin is also the n-th to end
    starts = np.argwhere(np.moveaxis(edges == 1, 0, -1))
    stops = np.argwhere(np.moveaxis(edges == -1, 0, -1))
    first = np.column_stack([starts[:, 2], starts[:, :2]]).astype(np.int64)
    beyond = np.column_stack([stops[:, 2], stops[:, :2] + 1]).astype(np.int64)
    for axis in (1, 2):
        first, beyond = _joined(first, beyond, axis)
    return first, beyond


def overlapping_boxes(occupied: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """Return boxes as `disjoint_boxes` does, but with overlaps, so that every border between cells is inside some box.

    A point inside the voxels may lie on the border of two, four or eight cells. Boxes hold whole runs of cells along x,
    and so all borders within these. They are therefore also made of all pairs of neighbouring cells along y, along z,
    and along both.
    """
    firsts, beyonds = [], []
    for axes in ((), (1,), (2,), (1, 2)):
        together = occupied
        for axis in axes:
            last = together.shape[axis] - 1
            together = together.take(range(last), axis) & together.take(range(1, last + 1), axis)
        first, beyond = disjoint_boxes(together)
        beyond[:, list(axes)] += 1
        firsts.append(first)
        beyonds.append(beyond)
    both = np.unique(np.hstack([np.concatenate(firsts), np.concatenate(beyonds)]), axis=0)
    return both[:, :3], both[:, 3:]


def _joined(first: Ints, beyond: Ints, axis: int) -> tuple[Ints, Ints]:
    """Join boxes that touch along one axis and extend equally along the others."""
    same = np.zeros(len(first), dtype=np.int64)  # one number for the extent along the other axes
    for other in (k for k in range(3) if k != axis):
        count = int(beyond[:, other].max(initial=0)) + 1
        same = (same * count + first[:, other]) * count + beyond[:, other]
    order = np.lexsort([first[:, axis], same])
    first, beyond, same = first[order], beyond[order], same[order]
    follows = (same[1:] == same[:-1]) & (first[1:, axis] == beyond[:-1, axis])
    begins = np.r_[True, ~follows][: len(first)]
    ends = np.r_[~follows, True][: len(first)]
    joined = beyond[begins].copy()
    joined[:, axis] = beyond[ends][:, axis]
    return first[begins], joined
