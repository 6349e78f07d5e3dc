"""Grids of voxels: how many voxels they may have, and how long a voxel is by default."""

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError
from skyverse.model.shapes import Voxels

MAX_VOXELS = 2**23
"""Voxels at most in one grid, about eight million."""
DEFAULT_VOXEL_SIZE = 0.5
"""Metres; doubled until the grid has no more than `MAX_VOXELS`."""

Unknown = Literal["free", "occupied"]
KIND_OF_UNKNOWN: dict[Unknown, str] = {"free": "occupied space", "occupied": "occupied or unknown space"}
"""The kind of an OctoMap's voxels, by what its unknown space was taken for."""

_MAX_COORDINATE = 1e8
"""Metres from zero; no map has larger coordinates."""


def require_voxel_count(where: object, counts: tuple[int, ...]) -> None:
    """Raise `InputError` for a grid of more than `MAX_VOXELS`, before it takes memory."""
    if math.prod(counts) > MAX_VOXELS:
        shown = " x ".join(map(str, counts))
        raise InputError(f"{where}: expected at most {MAX_VOXELS:,} voxels, found {shown}; take larger voxels, or crop")


def require_voxel_size(size: float | None) -> None:
    """Raise `InputError` for a size of voxels that is not a length."""
    if size is not None and not (isinstance(size, int | float) and 1e-3 <= size <= 1e6):
        raise InputError(f"expected metres, 0.001 to 1e6, found {size!r:.40}", field="size")


def grid_around(
    where: object, low: NDArray[np.float64], high: NDArray[np.float64], size: float | None
) -> tuple[float, NDArray[np.int64], tuple[int, int, int]]:
    """Return the grid that holds a box, and all voxels that touch the box.

    Parameters
    ----------
    where
        The beginning of messages.
    low, high
        The corners (3,) of the box, metres.
    size
        The voxels' size, metres; `DEFAULT_VOXEL_SIZE` or longer when left out.

    Returns
    -------
    tuple
        The voxels' size, metres; the number of the first one on each axis, voxel i reaching from ``i * size`` to
        ``(i + 1) * size``; how many there are on each axis.

    Raises
    ------
    InputError
        If the corners are not finite, or the box takes too many voxels.
    """
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise InputError(f"{where}: expected coordinates, found NaN or infinity")
    if max(np.abs(low).max(), np.abs(high).max()) > _MAX_COORDINATE:
        raise InputError(
            f"{where}: expected coordinates in metres, {_MAX_COORDINATE:.0e} at most, found {np.abs(high).max():.3g}"
        )
    require_voxel_size(size)
    length = DEFAULT_VOXEL_SIZE if size is None else size
    while True:
        first = np.ceil(low / length - 1e-9).astype(np.int64) - 1
        last = np.floor(high / length + 1e-9).astype(np.int64)
        counts = (int(last[0] - first[0]) + 1, int(last[1] - first[1]) + 1, int(last[2] - first[2]) + 1)
        if size is not None or math.prod(counts) <= MAX_VOXELS:
            require_voxel_count(where, counts)
            return length, first, counts
        length *= 2


def voxels_of_grid(first: NDArray[np.int64], size: float, occupied: NDArray[np.bool_]) -> Voxels:
    """Return a grid as a shape; its first voxel has the number `first` on each axis."""
    x, y, z = (float(i) * size for i in first)
    return Voxels(origin=(x, y, z), step=(size, size, size), occupied=occupied)


def trimmed(first: NDArray[np.int64], occupied: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the smallest part of a grid that holds all occupied voxels, and the number of its first voxel."""
    spans = []
    for axis in range(3):
        some = np.flatnonzero(occupied.any(axis=tuple(k for k in range(3) if k != axis)))
        spans.append((int(some[0]), int(some[-1]) + 1))
    part = occupied[spans[0][0] : spans[0][1], spans[1][0] : spans[1][1], spans[2][0] : spans[2][1]]
    return first + np.array([low for low, _ in spans]), part
