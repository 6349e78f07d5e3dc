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
from typing import Any

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
UNMOVED = "0 0 0 1 0 0 0"
"""The VIEWPOINT of points that are counted from zero: no shift, and a quaternion that does not turn."""
MAX_HEADER_BYTES = 2**16
MOST_UNPACKED = 88
"""Bytes that LZF makes of one at most: 264 of three."""


def read_pcd(path: Path, size: float | None = None, tell: Callable[[str], object] = lambda said: None) -> Voxels:
    """Read a point cloud, .pcd, in metres; `tell` is called with what is left out.

    Raises
    ------
    InputError
        If the file cannot be read, or says that its points are counted from elsewhere, or takes too many voxels.
    """
    with unreadable(path):
        data = path.read_bytes()
    said, begin = dict[str, str](), 0
    while "DATA" not in said:
        end = data.find(b"\n", begin, MAX_HEADER_BYTES)
        if end < 0:
            raise InputError(f"{path}: expected the header of a point cloud, which ends with DATA, found none")
        key, _, words = data[begin:end].decode("latin-1").strip().partition(" ")
        said[key], begin = words, end + 1
    readers = {"ascii": _text, "binary": _plain, "binary_compressed": _packed}
    if said["DATA"] not in readers:
        raise InputError(f"{path}: DATA: expected {', '.join(readers)}, found {shown(said['DATA'])}")
    point, count = _layout(path, said)
    if not count:
        raise InputError(f"{path}: expected points, found none")
    wrong = f"its {len(data) - begin:,} bytes after DATA are not {counted(count, 'point')}"
    with unreadable(path, wrong, ValueError, struct.error):
        columns = readers[said["DATA"]](point, count, data[begin:])
    with np.errstate(invalid="ignore"):  # as of a NaN that signals
        points = np.array(columns, dtype=np.float64).T
    placed = np.isfinite(points).all(axis=1)
    if not placed.all():
        tell(f"{counted(int((~placed).sum()), 'point')} of {len(points):,} left out, as they have no place (NaN).")
    return voxels_of_points(path, lambda: iter([points[placed]]), size)


def _layout(path: Path, said: dict[str, str]) -> tuple[np.dtype[Any], int]:
    """Return what a point holds, and how many points there are."""
    names = said.get("FIELDS", "").split()
    usual = {"COUNT": "1 " * len(names), "WIDTH": "1", "HEIGHT": "1", "POINTS": ""}
    for key in usual:
        if not all(word.isascii() and word.isdigit() and len(word) < 10 for word in said.get(key, "").split()):
            raise InputError(f"{path}: {key}: expected whole numbers, found {shown(said[key], 60)}")
    counts, width, height, points = (list(map(int, said.get(key, one).split())) for key, one in usual.items())
    forms = list(map("".join, zip(said.get("TYPE", "").split(), said.get("SIZE", "").split(), strict=False)))
    called = [name if name in AXES else f"_{k}" for k, name in enumerate(names)]
    try:
        fields = [(name, TYPES[form], (count,)) for name, form, count in zip(called, forms, counts, strict=True)]
        point = np.dtype(fields)
        if any(point[axis].shape != (1,) for axis in AXES):
            raise ValueError
    except (KeyError, ValueError):
        found = shown(" ".join([*names, *forms, *map(str, counts)]), 60)
        wrong = f"expected x, y and z once, and a type and a size for each field, found {found}"
        raise InputError(f"{path}: FIELDS, SIZE, TYPE, COUNT: {wrong}") from None
    count = math.prod(width + height)
    if points not in ([], [count]):
        raise InputError(f"{path}: POINTS: expected WIDTH times HEIGHT, {count}, found {points[0]}")
    moved = said.get("VIEWPOINT", UNMOVED)
    if [word.strip("-.0") for word in moved.split()] != [word.strip("0") for word in UNMOVED.split()]:
        wrong = (
            f"expected {UNMOVED}, as programs differ in whether points are counted from it, found {shown(moved, 60)}"
        )
        raise InputError(f"{path}: VIEWPOINT: {wrong}")
    return point, count


def _text(point: np.dtype[Any], count: int, body: bytes) -> Columns:
    """Return the columns of lines of numbers; raise `ValueError` for others, and for another number of lines."""
    names = list(point.names or ())
    at = [sum(point[name].shape[0] for name in names[: names.index(axis)]) for axis in AXES]
    lines = [line for line in body.split(b"\n") if line.strip()]
    if len(lines) != count:
        raise ValueError(f"found {counted(len(lines), 'line')}")
    rows = np.loadtxt(io.BytesIO(body), usecols=at, ndmin=2, encoding="latin-1")
    return list(rows.T)


def _plain(point: np.dtype[Any], count: int, body: bytes) -> Columns:
    """Return the columns of binary numbers, point after point; raise `ValueError` if there are too few."""
    rows = np.frombuffer(body, point, count)
    return [rows[axis][:, 0] for axis in AXES]


def _packed(point: np.dtype[Any], count: int, body: bytes) -> Columns:
    """Return the columns of binary numbers, field after field, compressed; raise `ValueError` if they are not."""
    size, length = struct.unpack_from("<II", body)
    packed, fields = np.frombuffer(body, np.uint8, size, 8).copy(), dict(point.fields or ())
    if length != count * point.itemsize or length > MOST_UNPACKED * size:
        raise ValueError(f"found {size:,} bytes that claim to be {length:,}")
    whole = np.empty(length, np.uint8)
    if unpack(packed, whole) != length:
        raise ValueError("they are cut off or damaged")
    return [np.frombuffer(whole, point[axis].base, count, fields[axis][1] * count) for axis in AXES]


@kernel
def unpack(packed: Bytes, whole: Bytes) -> int:
    """Unpack what LZF has packed; return how many bytes that made, or -1 where the bytes are none of LZF's.

    A run of up to 32 bytes follows its length; longer stretches are copies of what was made up to 8 KiB before.
    """
    at = made = 0
    while at + 1 < len(packed):
        control = int(packed[at])
        at += 1
        copied, source, count = packed, at, control + 1
        if control >= 32:
            copied, count = whole, (control >> 5) + 2
            if count == 9 and at + 1 < len(packed):
                count += int(packed[at])
                at += 1
            source = made - 1 - ((control & 31) << 8) - int(packed[at])
        at += count if control < 32 else 1
        if source < 0 or at > len(packed) or made + count > len(whole):
            return -1
        for k in range(count):
            whole[made + k] = copied[source + k]
        made += count
    return made
