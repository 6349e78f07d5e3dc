"""Voxels as few boxes: runs along x, then equal runs side by side along y, then equal plates above one another."""

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Ints


def merged(occupied: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """Return boxes that hold the occupied cells and no others, each cell once.

    Parameters
    ----------
    occupied
        (nx, ny, nz) booleans.

    Returns
    -------
    first, beyond
        (m, 3) indices of each box's first cell, and of the one diagonally after its last.
    """
    edges = np.diff(np.pad(occupied.astype(np.int8), ((1, 1), (0, 0), (0, 0))), axis=0)
    # with x last, the run that begins as the n-th also ends as the n-th
    starts = np.argwhere(np.moveaxis(edges == 1, 0, -1))
    stops = np.argwhere(np.moveaxis(edges == -1, 0, -1))
    first = np.column_stack([starts[:, 2], starts[:, :2]]).astype(np.int64)
    beyond = np.column_stack([stops[:, 2], stops[:, :2] + 1]).astype(np.int64)
    for axis in (1, 2):
        first, beyond = _joined(first, beyond, axis)
    return first, beyond


def covered(occupied: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """Return boxes as `merged` does, but overlapping: none of the borders between cells is left between them.

    A place within the cells may be on the border of two, four or eight of them. So boxes are also made of all pairs of
    cells along each axis, and of pairs of pairs.
    """
    firsts, beyonds = [], []
    for axes in ((), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)):
        together = occupied
        for axis in axes:
            last = together.shape[axis] - 1
            together = together.take(range(last), axis) & together.take(range(1, last + 1), axis)
        first, beyond = merged(together)
        beyond[:, list(axes)] += 1
        firsts.append(first)
        beyonds.append(beyond)
    both = np.unique(np.hstack([np.concatenate(firsts), np.concatenate(beyonds)]), axis=0)
    return both[:, :3], both[:, 3:]


def _joined(first: Ints, beyond: Ints, axis: int) -> tuple[Ints, Ints]:
    """Join boxes that follow one another along an axis and are equal along the others."""
    same = np.zeros(len(first), dtype=np.int64)  # one number for what must be equal
    for other in (k for k in range(3) if k != axis):
        most = int(beyond[:, other].max(initial=0)) + 1
        same = (same * most + first[:, other]) * most + beyond[:, other]
    order = np.lexsort([first[:, axis], same])
    first, beyond, same = first[order], beyond[order], same[order]
    follows = (same[1:] == same[:-1]) & (first[1:, axis] == beyond[:-1, axis])
    begins = np.r_[True, ~follows][: len(first)]
    ends = np.r_[~follows, True][: len(first)]
    joined = beyond[begins].copy()
    joined[:, axis] = beyond[ends][:, axis]
    return first[begins], joined
