"""Point clouds as voxels: LAS and LAZ by laspy, PLY by trimesh."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError
from skyverse.maps.georeference.libraries import require_libraries
from skyverse.maps.readers import las
from skyverse.maps.readers.voxel_grid import grid_around, trimmed, voxels_of_grid
from skyverse.model.shapes import Voxels

POINTS_AT_A_TIME = 1_000_000
PointParts = Callable[[], Iterator[NDArray[np.float64]]]
"""Yields all points in parts (n, 3), from the beginning at each call."""


def read_las(path: Path, size: float | None = None) -> Voxels:
    """Read a point cloud, .las or .laz, in metres.

    Parameters
    ----------
    path
        The file.
    size
        How long a voxel is, metres; see `skyverse.maps.readers.voxel_grid.DEFAULT_VOXEL_SIZE`.

    Raises
    ------
    InputError
        If the file cannot be read, is not in metres, has no points, or takes too many voxels.
    """
    require_libraries(path.name, "laspy", "lazrs")
    _require_metres(path)

    def parts() -> Iterator[NDArray[np.float64]]:
        with las.open_las(path) as file:
            for chunk in file.chunk_iterator(POINTS_AT_A_TIME):
                yield np.column_stack([chunk.x, chunk.y, chunk.z]).astype(np.float64)

    return voxels_of_points(path, parts, size)


def _require_metres(path: Path) -> None:
    with las.open_las(path) as file:
        crs = las.coordinate_system(file.header)
    for axis in [] if crs is None else crs.axis_info:
        if axis.unit_conversion_factor != 1 or axis.unit_name not in ("metre", "meter"):
            raise InputError(f"{path}: expected coordinates in metres, found {axis.name} in {axis.unit_name}")


def voxels_of_points(where: object, parts: PointParts, size: float | None = None) -> Voxels:
    """Return the voxels that hold points; see `read_las`."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for points in parts():
        if not np.isfinite(points).all():
            raise InputError(f"{where}: expected coordinates, found NaN or infinity")
        if len(points):
            low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    if not low[0] <= high[0]:
        raise InputError(f"{where}: expected points, found none")
    length, first, counts = grid_around(where, low, high, size)
    occupied = np.zeros(counts, dtype=bool)
    for points in parts():
        x, y, z = (np.floor(points / length).astype(np.int64) - first).clip(0, np.array(counts) - 1).T
        occupied[x, y, z] = True
    first, occupied = trimmed(first, occupied)
    return voxels_of_grid(first, length, occupied)
