"""Grids of voxels, how many and how long they may be, and their plainest file, MovingAI's .3dmap.

A .3dmap has a line ``voxel X Y Z``, then a line ``x y z`` for each blocked voxel.

Source: T. Nobes, D. Harabor, M. Wybrow, S. Walsh, "Voxel Benchmarks for 3D Pathfinding", 2023; https://movingai.com
"""

import io
import math
import re
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError, unreadable
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


DEFAULT_3DMAP_VOXEL_SIZE = 1.0
"""Metres; the benchmark has no unit."""


def read_3dmap(path: Path, size: float | None = None) -> Voxels:
    """Read a .3dmap file.

    Parameters
    ----------
    path
        The file.
    size
        How long a voxel is, metres; 1 when left out.

    Raises
    ------
    InputError
        If the file is not such a map; the message names the line.
    """
    require_voxel_size(size)
    with unreadable(path), path.open("rb") as file:
        head, body = file.readline(200), file.read()
    found = re.fullmatch(rb"voxel\s+(\d{1,9})\s+(\d{1,9})\s+(\d{1,9})\s*", head)
    if found is None:
        raise InputError(f"{path}: line 1: expected 'voxel' and three whole numbers, found {head[:40]!r}")
    counts = (int(found[1]), int(found[2]), int(found[3]))
    require_voxel_count(path, counts)
    if not min(counts):
        raise InputError(f"{path}: line 1: expected voxels along every axis, found {counts}")
    occupied = np.zeros(counts, dtype=bool)
    if body.strip():
        with unreadable(path, "expected x y z in every line after the first", ValueError, OverflowError):
            cells = np.loadtxt(io.BytesIO(body), dtype=np.int64, ndmin=2, comments=None, encoding="latin-1")
        if cells.shape[1] != 3:
            raise InputError(f"{path}: expected x y z in every line after the first, found {cells.shape[1]} numbers")
        outside = np.flatnonzero(((cells < 0) | (cells >= counts)).any(axis=1))
        if len(outside):
            raise InputError(f"{path}: voxel {cells[outside[0]].tolist()} is outside of the {list(counts)} there are")
        occupied[cells[:, 0], cells[:, 1], cells[:, 2]] = True
    return voxels_of_grid(np.zeros(3, dtype=np.int64), size or DEFAULT_3DMAP_VOXEL_SIZE, occupied)
