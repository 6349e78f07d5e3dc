"""Voxel maps of the MovingAI benchmark, .3dmap: a line ``voxel X Y Z``, then a line ``x y z`` for each blocked voxel.

Source: T. Nobes, D. Harabor, M. Wybrow, S. Walsh, "Voxel Benchmarks for 3D Pathfinding", 2023; https://movingai.com
"""

import io
import re
from pathlib import Path

import numpy as np

from skyverse.errors import InputError, unreadable
from skyverse.maps.readers.voxel_grid import require_voxel_count, require_voxel_size, voxels_of_grid
from skyverse.model.shapes import Voxels

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
