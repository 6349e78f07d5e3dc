"""Meshes as voxels: STL, OBJ and PLY files, read by trimesh; the surface, and the inside of closed meshes.

The voxels that triangles touch are found by exact tests of separating axes.

Source: T. Akenine-Möller, "Fast 3D triangle-box overlap testing", Journal of Graphics Tools 6 (2001), 29-33.
"""

import io
import logging
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from skyverse.errors import InputError, unreadable
from skyverse.extras import require_libraries
from skyverse.maps.readers.voxel_grid import grid_around, voxels_of_grid, voxels_of_points
from skyverse.model.shapes import Voxels
from skyverse.numerics.kernel import inner, kernel

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


_VOXEL_TOUCH = 1e-9
"""Voxels; a triangle this near to a voxel touches it, so that rounding leaves no voxel out."""


@kernel
def touched(corners: NDArray[np.float64], occupied: NDArray[np.bool_]) -> None:
    """Mark the voxels that triangles touch.

    Parameters
    ----------
    corners
        (n, 3, 3) corners of triangles in voxels: voxel i, j, k reaches from (i, j, k) to (i + 1, j + 1, k + 1).
    occupied
        (nx, ny, nz); voxels that are touched become true.
    """
    low, high, cell = np.empty(3, dtype=np.int64), np.empty(3, dtype=np.int64), np.empty(3, dtype=np.int64)
    axes, least, most = np.empty((10, 3)), np.empty(10), np.empty(10)
    for t in range(len(corners)):
        base = np.floor(corners[t, 0])  # places are counted from here, so that rounding stays as small as the triangle
        a, b, c = corners[t, 0] - base, corners[t, 1] - base, corners[t, 2] - base
        for axis in range(3):
            lowest, highest = min(a[axis], b[axis], c[axis]), max(a[axis], b[axis], c[axis])
            low[axis] = max(0, int(base[axis] + np.ceil(lowest - _VOXEL_TOUCH)) - 1)
            high[axis] = min(occupied.shape[axis] - 1, int(base[axis] + np.floor(highest + _VOXEL_TOUCH)))
        _axes_of_triangle(a, b, c, axes, least, most)
        normal = axes[9]
        # along the axis that is nearest to the normal, a column of voxels meets the plane in few voxels
        face = int(np.argmax(np.abs(normal)))
        u, v = (face + 1) % 3, (face + 2) % 3
        for i in range(low[u], high[u] + 1):
            for j in range(low[v], high[v] + 1):
                first, last = low[face], high[face]
                if normal[face] != 0:
                    beside = normal[u] * (i + 0.5 - base[u] - a[u]) + normal[v] * (j + 0.5 - base[v] - a[v])
                    middle = base[face] + a[face] - beside / normal[face]
                    reach = (abs(normal[u]) + abs(normal[v])) / abs(normal[face]) / 2 + 1e-6
                    first = max(first, int(np.floor(middle - reach)) - 1)
                    last = min(last, int(np.floor(middle + reach)) + 1)
                for k in range(first, last + 1):
                    cell[u], cell[v], cell[face] = i, j, k
                    if not occupied[cell[0], cell[1], cell[2]]:
                        x, y, z = cell[0] + 0.5 - base[0], cell[1] + 0.5 - base[1], cell[2] + 0.5 - base[2]
                        occupied[cell[0], cell[1], cell[2]] = _is_met(axes, least, most, x, y, z)


@inner
def _axes_of_triangle(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    c: NDArray[np.float64],
    axes: NDArray[np.float64],
    least: NDArray[np.float64],
    most: NDArray[np.float64],
) -> None:
    """Fill in the axes that may separate a triangle from a voxel whose box meets that of the triangle.

    They are the products of its edges and the voxel's axes, and its normal, the last. Where it touches a voxel, the
    voxel's middle lies between `least` and `most`, (10,), along each of `axes`, (10, 3).
    """
    for row in range(10):
        begin, end = (a, b) if row < 3 else ((b, c) if row < 6 else (c, a))
        side, u, v = row % 3, (row + 1) % 3, (row + 2) % 3
        axes[row, side], axes[row, u], axes[row, v] = 0.0, begin[v] - end[v], end[u] - begin[u]
        if row == 9:
            for k in range(3):
                u, v = (k + 1) % 3, (k + 2) % 3
                axes[row, k] = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u])
        x, y, z = axes[row, 0], axes[row, 1], axes[row, 2]
        p, q, r = x * a[0] + y * a[1] + z * a[2], x * b[0] + y * b[1] + z * b[2], x * c[0] + y * c[1] + z * c[2]
        reach = (abs(x) + abs(y) + abs(z)) * (0.5 + _VOXEL_TOUCH)
        least[row], most[row] = min(p, q, r) - reach, max(p, q, r) + reach


@inner
def _is_met(
    axes: NDArray[np.float64], least: NDArray[np.float64], most: NDArray[np.float64], x: float, y: float, z: float
) -> bool:
    """Tell whether a triangle touches the voxel around x, y, z: none of its axes separates them."""
    for row in range(10):
        along = axes[row, 0] * x + axes[row, 1] * y + axes[row, 2] * z
        if along < least[row] or along > most[row]:
            return False
    return True
