"""Meshes as voxels, STL, OBJ and PLY, read by trimesh: the surface, and the inside where there is one."""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from skyverse.errors import InputError
from skyverse.maps.cloud import voxels_of_points
from skyverse.maps.extra import needs
from skyverse.maps.grid import grid_around, voxels
from skyverse.maps.voxelise import touched
from skyverse.shapes import Voxels

MAX_BYTES = 2**29
MAX_COLUMNS = 2e9
"""Columns of voxels at most below all triangles, some tens of seconds of work."""


def read_mesh(path: Path, size: float | None = None, at_least: int = 1) -> Voxels:
    """Read a mesh, or a PLY of points, in metres.

    Parameters
    ----------
    path
        An .stl, .obj or .ply file.
    size
        How long a voxel is, metres; see `skyverse.maps.grid.SIZE`. A voxel is occupied if a triangle touches it, or if
        it is inside a mesh without gaps.
    at_least
        Of points without triangles: a voxel with fewer is free.

    Raises
    ------
    InputError
        If the file cannot be read, holds nothing, or takes too many voxels.
    """
    needs(path.name, "trimesh")
    read = _loaded(path)
    corners = getattr(read, "triangles", None)
    if corners is None or not len(corners):
        points = np.asarray(getattr(read, "vertices", np.empty((0, 3))), dtype=np.float64).reshape(-1, 3)

        def once() -> Iterator[NDArray[np.float64]]:
            yield points

        return voxels_of_points(path, once, size, at_least)
    corners = np.asarray(corners, dtype=np.float64)
    if not np.isfinite(corners).all():
        raise InputError(f"{path}: expected coordinates, found NaN or infinity")
    occupied, first, length = voxels_of_triangles(path, corners, size)
    if _closed(read):
        occupied = ndimage.binary_fill_holes(occupied)
    return voxels(first, length, occupied)


def voxels_of_triangles(
    where: object, corners: NDArray[np.float64], size: float | None = None
) -> tuple[NDArray[np.bool_], NDArray[np.int64], float]:
    """Return the voxels that triangles (n, 3, 3) touch, the first one's number on each axis, and their size."""
    length, first, counts = grid_around(where, corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), size)
    spans = (corners.max(axis=1) - corners.min(axis=1)) / length + 2
    if float(np.sum(np.prod(spans, axis=1) / spans.min(axis=1))) > MAX_COLUMNS:
        raise InputError(f"{where}: expected fewer or smaller triangles, found {len(corners)}; take larger voxels")
    occupied = np.zeros(counts, dtype=bool)
    touched(np.ascontiguousarray(corners / length - first), occupied)
    return occupied, first, length


def _closed(mesh: Any) -> bool:
    """Tell whether a mesh has no gaps, its equal corners taken for one."""
    if not mesh.is_watertight:
        mesh = mesh.copy()
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return bool(mesh.is_watertight)


def _loaded(path: Path) -> Any:
    import trimesh

    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f"{path}: expected at most {MAX_BYTES >> 20} MB, found {path.stat().st_size >> 20}")
        # a stream has no folder, so that nothing beside the file is opened
        with io.BytesIO(path.read_bytes()) as file, np.errstate(all="ignore"):
            kind = path.suffix.lower()[1:]
            options: dict[str, Any] = {"skip_materials": True} if kind == "obj" else {}
            read = trimesh.load(file, file_type=kind, process=False, **options)
            return read.to_geometry() if isinstance(read, trimesh.Scene) else read
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except Exception as error:
        said = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise InputError(f"{path}: cannot be read as {path.suffix[1:].upper()}: {said[:200]}") from None
