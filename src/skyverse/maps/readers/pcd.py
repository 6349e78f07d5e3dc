"""Point clouds of the Point Cloud Library, .pcd: as text, binary, or compressed by LZF; metres of a local frame.

What a header claims is compared with the file's size before anything of that size is made. Points without a place, as
depth cameras write them, are left out and told.

Sources: https://pointclouds.org/documentation/tutorials/pcd_file_format.html; liblzf, lzf_d.c, for the compression.
"""

import io
import math
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError, shown, unreadable
from skyverse.maps.readers.voxel_grid import voxels_of_points
from skyverse.model.shapes import Voxels
from skyverse.model.short_lines import counted
from skyverse.numerics.kernel import kernel

Bytes = NDArray[np.uint8]
Columns = list[NDArray[Any]]
"""All x, all y and all z, (n,) each."""
AXES = ("x", "y", "z")
TYPES = {f"{kind}{size}": f"<{kind.lower()}{size}" for kind in "IU" for size in (1, 2, 4, 8)} | {
    "F4": "<f4",
    "F8": "<f8",
}
"""Kinds of numbers by TYPE and SIZE, as numpy calls them."""
UNMOVED = ["0", "0", "0", "1", "0", "0", "0"]
"""The VIEWPOINT of points that are counted from zero: no shift, and a quaternion that does not turn."""
MAX_HEADER_BYTES = 2**16
MOST_UNPACKED = 88
"""Bytes that LZF makes of one at most: 264 of three."""


class _Header(NamedTuple):
    """What a point holds, how many points there are, how they are kept, and at which byte they begin."""

    point: np.dtype[Any]
    points: int
    kept: str
    begin: int


def read_pcd(path: Path, size: float | None = None, tell: Callable[[str], object] = lambda said: None) -> Voxels:
    """Read a point cloud, .pcd, in metres; `tell` is called with what is left out.

    Raises
    ------
    InputError
        If the file cannot be read, or says that its points are counted from elsewhere, or takes too many voxels.
    """
    with unreadable(path):
        data = path.read_bytes()
    head = _header(path, data)
    readers = {"ascii": _text, "binary": _plain, "binary_compressed": _packed}
    if head.kept not in readers:
        raise InputError(f"{path}: DATA: expected {', '.join(readers)}, found {shown(head.kept)}")
    with np.errstate(invalid="ignore"):  # as of a NaN that signals
        points = np.array(readers[head.kept](path, head, data[head.begin :]), dtype=np.float64).T
    placed = np.isfinite(points).all(axis=1)
    if not placed.all():
        tell(f"{counted(int((~placed).sum()), 'point')} of {len(points):,} left out, as they have no place (NaN).")
    return voxels_of_points(path, lambda: iter([points[placed]]), size)


def _header(path: Path, data: bytes) -> _Header:
    said, begin = dict[str, list[str]](), 0
    while "DATA" not in said:
        end = data.find(b"\n", begin, MAX_HEADER_BYTES)
        if end < 0:
            raise InputError(f"{path}: expected the header of a point cloud, which ends with DATA, found none")
        key, *words = data[begin:end].decode("latin-1").split() or ["#"]
        said[key], begin = words, end + 1
    names, kinds, sizes = (said.get(key, []) for key in ("FIELDS", "TYPE", "SIZE"))
    counts = _whole(path, "COUNT", said.get("COUNT", ["1"] * len(names)))
    fields = zip(names, kinds, sizes, counts, strict=True)
    try:
        point = np.dtype(
            [
                (name if name in AXES else f"_{k}", TYPES[kind + size], () if count == 1 else (count,))
                for k, (name, kind, size, count) in enumerate(fields)
            ]
        )
        if any(point[axis].shape for axis in AXES):
            raise ValueError
    except (KeyError, ValueError):
        found = shown(" ".join([*names, *kinds, *sizes]), 60)
        raise InputError(
            f"{path}: FIELDS, SIZE, TYPE, COUNT: expected x, y and z once, and a type and its size for each field, "
            f"found {found}"
        ) from None
    width, height = (math.prod(_whole(path, key, said.get(key, ["1"]))) for key in ("WIDTH", "HEIGHT"))
    if "POINTS" in said and _whole(path, "POINTS", said["POINTS"]) != [width * height]:
        found = shown(" ".join(said["POINTS"]))
        raise InputError(f"{path}: POINTS: expected WIDTH times HEIGHT, {width * height}, found {found}")
    viewpoint = said.get("VIEWPOINT", UNMOVED)
    if [word.rstrip("0").rstrip(".").removeprefix("-") or "0" for word in viewpoint] != UNMOVED:
        raise InputError(
            f"{path}: VIEWPOINT: expected {' '.join(UNMOVED)}, as programs differ in whether points are counted from "
            f"it, found {shown(' '.join(viewpoint), 60)}"
        )
    return _Header(point, width * height, " ".join(said["DATA"]), begin)


def _whole(path: Path, key: str, words: list[str]) -> list[int]:
    if not all(word.isascii() and word.isdigit() and len(word) < 10 for word in words):
        raise InputError(f"{path}: {key}: expected whole numbers, found {shown(' '.join(words), 60)}")
    return [int(word) for word in words]


def _text(path: Path, head: _Header, body: bytes) -> Columns:
    """Return the columns of lines of numbers."""
    names = list(head.point.names or ())
    widths = [math.prod(head.point[name].shape) for name in names]
    at = [sum(widths[: names.index(axis)]) for axis in AXES]
    rows = np.zeros((0, 3))
    if body.strip():
        with unreadable(path, "expected numbers in each line after DATA", ValueError, OverflowError):
            rows = np.loadtxt(io.BytesIO(body), usecols=at, ndmin=2, comments=None, encoding="latin-1")
    if len(rows) != head.points:
        raise InputError(f"{path}: POINTS: expected as many as there are lines, {len(rows):,}, found {head.points:,}")
    return list(rows.T)


def _plain(path: Path, head: _Header, body: bytes) -> Columns:
    """Return the columns of binary numbers, point after point."""
    if head.points * head.point.itemsize > len(body):
        raise InputError(f"{path}: claims {head.points:,} points of {head.point.itemsize} bytes in {len(body):,} bytes")
    rows = np.frombuffer(body, head.point, head.points)
    return [rows[axis] for axis in AXES]


def _packed(path: Path, head: _Header, body: bytes) -> Columns:
    """Return the columns of binary numbers, field after field, that were compressed."""
    size, length = struct.unpack("<II", body[:8]) if len(body) >= 8 else (0, 0)
    fits = length <= MOST_UNPACKED * size <= MOST_UNPACKED * (len(body) - 8)
    if length != head.points * head.point.itemsize or not fits:
        raise InputError(
            f"{path}: claims {head.points:,} points of {head.point.itemsize} bytes, compressed to {size:,}, in "
            f"{len(body):,} bytes"
        )
    whole = np.empty(length, np.uint8)
    if unpack(np.frombuffer(body, np.uint8, size, 8).copy(), whole) != length:
        raise InputError(f"{path}: its points cannot be unpacked, it is cut off or damaged")
    fields = dict(head.point.fields or ())
    return [np.frombuffer(whole, head.point[axis], head.points, fields[axis][1] * head.points) for axis in AXES]


@kernel
def unpack(packed: Bytes, whole: Bytes) -> int:
    """Unpack what LZF has packed; return how many bytes that made, or -1 where the bytes are none of LZF's.

    A run of up to 32 bytes follows its length; longer stretches are copies of what was made up to 8 KiB before.
    """
    at = made = 0
    while at < len(packed):
        control = int(packed[at])
        at += 1
        count, source = control + 1, -1
        if control >= 32:
            count = (control >> 5) + 2
            if count == 9 and at < len(packed):
                count += int(packed[at])
                at += 1
            source = made - 1 - ((control & 31) << 8) - (int(packed[at]) if at < len(packed) else made)
            at += 1
        if made + count > len(whole) or (source < 0 if control >= 32 else at + count > len(packed)):
            return -1
        for k in range(count):
            whole[made + k] = packed[at + k] if control < 32 else whole[source + k]
        at += count if control < 32 else 0
        made += count
    return made
