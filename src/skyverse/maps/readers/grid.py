"""Grids of voxels: how large they may be, and how long a voxel is where nobody says."""

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError
from skyverse.model.shapes import Voxels

MAX_VOXELS = 2**23
"""Voxels at most in one grid, some eight million."""
SIZE = 0.5
"""How long a voxel is unless said otherwise, metres; doubled until the grid has no more than `MAX_VOXELS`."""

Unknown = Literal["free", "occupied"]
UNKNOWN: dict[Unknown, str] = {"free": "occupied space", "occupied": "occupied or unknown space"}
"""The kind of an OctoMap's voxels, by what space was taken for that nobody has seen."""

_FAR = 1e8
"""Metres from zero beyond which no coordinate makes sense."""


def require_few(where: object, counts: tuple[int, ...]) -> None:
    """Refuse a grid of more than `MAX_VOXELS`, before it takes memory."""
    if math.prod(counts) > MAX_VOXELS:
        shown = " x ".join(map(str, counts))
        raise InputError(f"{where}: expected at most {MAX_VOXELS:,} voxels, found {shown}; take larger voxels, or crop")


def require_size(size: float | None) -> None:
    """Refuse a size of voxels that is not a length."""
    if size is not None and not (isinstance(size, int | float) and 1e-3 <= size <= 1e6):
        raise InputError(f"size: expected metres, 0.001 to 1e6, found {size!r:.40}")


def grid_around(
    where: object, low: NDArray[np.float64], high: NDArray[np.float64], size: float | None
) -> tuple[float, NDArray[np.int64], tuple[int, int, int]]:
    """Return a grid that holds a box with all that touches its faces.

    Returns
    -------
    tuple
        The voxels' size, metres; the number of the first one on each axis, voxel i reaching from ``i * size`` to
        ``(i + 1) * size``; how many there are on each axis.

    Raises
    ------
    InputError
        If the box is not one, or takes too many voxels.
    """
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise InputError(f"{where}: expected coordinates, found NaN or infinity")
    if max(np.abs(low).max(), np.abs(high).max()) > _FAR:
        raise InputError(f"{where}: expected coordinates in metres, {_FAR:.0e} at most, found {np.abs(high).max():.3g}")
    require_size(size)
    length = SIZE if size is None else size
    while True:
        first = np.ceil(low / length - 1e-9).astype(np.int64) - 1
        last = np.floor(high / length + 1e-9).astype(np.int64)
        counts = (int(last[0] - first[0]) + 1, int(last[1] - first[1]) + 1, int(last[2] - first[2]) + 1)
        if size is not None or math.prod(counts) <= MAX_VOXELS:
            require_few(where, counts)
            return length, first, counts
        length *= 2


def voxels(first: NDArray[np.int64], size: float, occupied: NDArray[np.bool_]) -> Voxels:
    """Return the shape of a grid whose first voxel has the number `first` on each axis."""
    x, y, z = (float(i) * size for i in first)
    return Voxels(origin=(x, y, z), step=(size, size, size), occupied=occupied)


def trimmed(first: NDArray[np.int64], occupied: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the smallest part of a grid that holds all that is occupied."""
    spans = []
    for axis in range(3):
        some = np.flatnonzero(occupied.any(axis=tuple(k for k in range(3) if k != axis)))
        spans.append((int(some[0]), int(some[-1]) + 1))
    part = occupied[spans[0][0] : spans[0][1], spans[1][0] : spans[1][1], spans[2][0] : spans[2][1]]
    return first + np.array([low for low, _ in spans]), part
