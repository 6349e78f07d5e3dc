"""Meshes as voxels: STL, OBJ and PLY files, read by trimesh; the surface, and the inside of closed meshes."""

import io
import logging
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from skyverse.errors import InputError, unreadable
from skyverse.maps.georeference.libraries import require_libraries
from skyverse.maps.readers.point_cloud import voxels_of_points
from skyverse.maps.readers.voxel_grid import grid_around, voxels_of_grid
from skyverse.maps.readers.voxelise import touched
from skyverse.model.shapes import Voxels

MAX_MESH_BYTES = 2**29
MAX_VOXEL_COLUMNS = 2e9
"""Columns of voxels below all triangles at most; they take some tens of seconds."""


def read_mesh(path: Path, size: float | None = None) -> Voxels:
    """Read a mesh, or a PLY file of points, in metres.

    Parameters
    ----------
    path
        An .stl, .obj or .ply file.
    size
        How long a voxel is, metres; see `skyverse.maps.readers.voxel_grid.DEFAULT_VOXEL_SIZE`. A voxel is occupied if
        a triangle touches it, or if it is inside a closed mesh.

    Raises
    ------
    InputError
        If the file cannot be read, holds nothing, or takes too many voxels.
    """
    require_libraries(path.name, "trimesh")
    vertices, faces = _loaded(path)
    if not len(faces):
        return voxels_of_points(path, lambda: iter([vertices]), size)
    corners = vertices[faces]
    if not np.isfinite(corners).all():
        raise InputError(f"{path}: expected coordinates, found NaN or infinity")
    occupied, first, length = voxels_of_triangles(path, corners, size)
    if _is_closed(corners):
        occupied = ndimage.binary_fill_holes(occupied)
    return voxels_of_grid(first, length, occupied)


def voxels_of_triangles(
    where: object, corners: NDArray[np.float64], size: float | None = None
) -> tuple[NDArray[np.bool_], NDArray[np.int64], float]:
    """Return the voxels that triangles (n, 3, 3) touch, the first one's number on each axis, and their size."""
    length, first, counts = grid_around(where, corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), size)
    spans = (corners.max(axis=1) - corners.min(axis=1)) / length + 2
    if float(np.sum(np.prod(spans, axis=1) / spans.min(axis=1))) > MAX_VOXEL_COLUMNS:
        raise InputError(f"{where}: expected fewer or smaller triangles, found {len(corners)}; take larger voxels")
    occupied = np.zeros(counts, dtype=bool)
    touched(np.ascontiguousarray(corners / length - first), occupied)
    return occupied, first, length


def _is_closed(corners: NDArray[np.float64]) -> bool:
    """Tell whether a mesh is closed: each edge belongs to two triangles."""
    _, numbers = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    a, b, c = numbers.reshape(-1, 3).T
    some = (a != b) & (b != c) & (c != a)
    edges = np.concatenate([np.stack([p[some], q[some]], axis=1) for p, q in ((a, b), (b, c), (c, a))])
    _, counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    return bool(len(counts) and (counts == 2).all())


def _loaded(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the vertices (n, 3), and the triangles (m, 3) as numbers of vertices."""
    import trimesh

    logging.getLogger("trimesh").addHandler(logging.NullHandler())  # trimesh would print what is raised below
    with unreadable(path, f"cannot be read as {path.suffix[1:].upper()}", Exception):
        if path.stat().st_size > MAX_MESH_BYTES:
            raise InputError(f"{path}: expected at most {MAX_MESH_BYTES >> 20} MB, found {path.stat().st_size >> 20}")
        # from a stream trimesh opens no other files of the folder
        with io.BytesIO(path.read_bytes()) as file, np.errstate(all="ignore"):
            kind = path.suffix.lower()[1:]
            options: dict[str, Any] = {"skip_materials": True} if kind == "obj" else {}
            read: Any = trimesh.load(file, file_type=kind, process=False, **options)
            read = read.to_geometry() if isinstance(read, trimesh.Scene) else read
            vertices = np.array(read.vertices, dtype=np.float64)
            vertices = vertices if vertices.size else np.empty((0, 3))
            faces = np.array(getattr(read, "faces", ()), dtype=np.int64).reshape(-1, 3)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InputError(f"{path}: expected x, y and z of every vertex, found {vertices.shape[-1]} numbers")
    wrong = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))
    if len(wrong):
        raise InputError(f"{path}: triangle {wrong[0] + 1} has a vertex that is none of the {len(vertices)}")
    return vertices, faces
