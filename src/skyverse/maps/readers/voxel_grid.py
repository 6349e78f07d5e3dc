"""Grids of voxels, how many and how long they may be, and two kinds of files: MovingAI's .3dmap and point clouds.

A .3dmap has a line ``voxel X Y Z``, then a line ``x y z`` for each blocked voxel. Point clouds, LAS and LAZ, are read
by laspy. Libraries believe the counts in a header, and loop or allocate for as many records as it claims. So a file is
opened once its counts are known to fit its size. Whatever a damaged file makes laspy raise becomes one sentence.

Sources: T. Nobes, D. Harabor, M. Wybrow, S. Walsh, "Voxel Benchmarks for 3D Pathfinding", 2023; https://movingai.com;
ASPRS LAS 1.4 R15, the public header block; laszip.org for the LASzip record 22204.
"""

import io
import math
import re
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError, unreadable
from skyverse.extras import require_libraries
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
        with open_las(path) as file:
            for chunk in file.chunk_iterator(POINTS_AT_A_TIME):
                yield np.column_stack([chunk.x, chunk.y, chunk.z]).astype(np.float64)

    return voxels_of_points(path, parts, size)


def _require_metres(path: Path) -> None:
    with open_las(path) as file:
        crs = coordinate_system(file.header)
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


_LASZIP_RECORD = 22204
_MAX_POINTS = 2**31
_MAX_RECORD_BYTES = 2**26
_MAX_POINTS_PER_BYTE = 1000
"""Points that a compressed file may claim for each byte: many times what compression achieves."""
_MAX_CHUNK_POINTS = 10_000_000


@contextmanager
def open_las(path: Path) -> Iterator[Any]:
    """Open a point cloud; a damaged file raises `InputError`, here or while it is read."""
    import laspy  # type: ignore[import-untyped, unused-ignore]

    with unreadable(path), path.open("rb") as stream:
        problem = _first_problem(stream, path.stat().st_size)
    if problem is not None:
        raise InputError(f"{path}: cannot be read as LAS, it is cut off or damaged: {problem}")
    # a panic of the unpacker, which is written in Rust, is no `Exception`
    with unreadable(path, "cannot be read as LAS", BaseException), laspy.open(path) as file:
        yield file


def coordinate_system(header: Any) -> Any:
    """Return the coordinate system of laspy's header; ``None`` if it has none, or one that says nothing."""
    from pyproj.exceptions import CRSError

    try:
        return header.parse_crs()
    except CRSError:
        return None


def _first_problem(file: BinaryIO, size: int) -> str | None:
    """Return which of the header's counts does not fit a file of that many bytes, if any."""
    head = file.read(375)
    if len(head) < 227 or head[:4] != b"LASF":
        return "expected a header that begins with 'LASF'"
    begins, offset, records, form, width, count = struct.unpack_from("<HIIBHI", head, 94)
    compressed = form & 0x80 != 0
    if not begins <= offset <= size:
        return f"its points begin at byte {offset} of {size}"
    if 54 * records > offset - begins:
        return f"it claims {records} records before its points"
    if head[25] >= 4 and len(head) >= 255:  # the format from version 1.4 on
        start, more, points = struct.unpack_from("<QIQ", head, 235)
        if more and not (offset <= start <= size and 60 * more <= size - start):
            return f"it claims {more} records after its points"
        count = max(count, points)
    if not width:
        return "its points have no bytes"
    if count > min(_MAX_POINTS, (size - offset) * _MAX_POINTS_PER_BYTE if compressed else (size - offset) // width):
        return f"it claims {count} points in {size - offset} bytes"
    file.seek(begins)
    return _record_problem(file.read(min(offset - begins, _MAX_RECORD_BYTES)), records, width if compressed else 0) or (
        _chunk_problem(file, offset, size) if compressed else None
    )


def _record_problem(records: bytes, count: int, width: int) -> str | None:
    """Return what is wrong with the variable length records, where a compressed point has `width` bytes."""
    at, problem = 0, "it does not say how it is compressed" if width else None
    for number in range(1, count + 1):
        if at + 54 > len(records):
            return f"its record {number} is cut off"
        kind, length = struct.unpack_from("<HH", records, at + 18)
        following = at + 54 + length
        if following > len(records):
            return f"its record {number} is cut off"
        if kind == _LASZIP_RECORD and length >= 34 and width:
            problem, width = _compression_problem(records[at + 54 : following], width), 0
        at = following
    return problem


def _compression_problem(record: bytes, width: int) -> str | None:
    """Return what is wrong with the record that says how points of `width` bytes are compressed."""
    chunk, items = struct.unpack_from("<I", record, 12)[0], struct.unpack_from("<H", record, 32)[0]
    if chunk != 0xFFFFFFFF and not 0 < chunk <= _MAX_CHUNK_POINTS:
        return f"it claims {chunk} points a chunk"
    if len(record) < 34 + 6 * items:
        return f"it claims {items} parts of a point"
    parts = sum(struct.unpack_from("<H", record, 36 + 6 * k)[0] for k in range(items))
    return None if parts == width else f"its points have {width} bytes, their parts {parts}"


def _chunk_problem(file: BinaryIO, offset: int, size: int) -> str | None:
    """Return what is wrong with the table of the chunks of compressed points, which begin at `offset`."""
    if size < offset + 8:
        return "its points are missing"
    file.seek(offset)
    table = struct.unpack("<q", file.read(8))[0]
    if table == -1:  # the table's place stands at the end of the file
        file.seek(size - 8)
        table = struct.unpack("<q", file.read(8))[0]
    if not offset <= table <= size - 8:
        return "its table of chunks is missing"
    file.seek(table)
    chunks = struct.unpack("<II", file.read(8))[1]
    return f"it claims {chunks} chunks" if chunks > size else None
