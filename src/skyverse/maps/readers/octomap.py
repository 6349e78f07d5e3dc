"""OctoMap's octrees as voxels: .bt files (occupied, free or unknown) and .ot files (log-odds).

A file begins with a few lines of text, the last of which is ``data``. The nodes follow depth first, the children of a
node in the order of their numbers; the three bits of a child's number say whether it lies above the middle along x, y
and z. In a .bt file a node takes two bytes, two bits for each child: 0 is unknown, 1 free, 2 occupied, and 3 an inner
node, which follows. In a .ot file a node takes 4 bytes for its log-odds, occupied from 0 on, and one byte with a bit
for each child that follows.

Source: octomap/src and include/octomap/OccupancyOcTreeBase.hxx of https://octomap.github.io, which write these formats.
"""

import math
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError, unreadable
from skyverse.maps.readers.voxel_grid import (
    KIND_OF_UNKNOWN,
    MAX_VOXELS,
    Unknown,
    require_voxel_count,
    require_voxel_size,
    trimmed,
    voxels_of_grid,
)
from skyverse.model.shapes import Voxels
from skyverse.numerics.kernel import kernel

_TREE_DEPTH = 16
_FREE_LEAF, _OCCUPIED_LEAF = 1, 2
_BYTES_OF_COLOUR = {"OcTree": 0, "ColorOcTree": 3}


def read_octomap(path: Path, size: float | None = None, unknown: Unknown | None = None) -> Voxels:
    """Read an octree of OctoMap.

    Parameters
    ----------
    path
        A .bt or .ot file.
    size
        How long a voxel is, metres: the octree's resolution, or that times a power of two. When left out, it is the
        smallest of these with which there are at most `skyverse.maps.readers.voxel_grid.MAX_VOXELS`. A voxel is
        occupied if any part of it is.
    unknown
        What space that nobody has seen is taken for, within the box of what has been seen. When left out it is
        occupied, but free where the octree has no free leaf, as then it does not record what was seen.

    Returns
    -------
    Voxels
        Their kind is one of `KIND_OF_UNKNOWN`. Where unknown space is occupied, the grid is the box of all that has
        been seen, otherwise that of what is occupied.

    Raises
    ------
    InputError
        If the file is not an octree, nothing is occupied, or there are too many voxels.
    """
    leaves, resolution = _leaves(path)
    if unknown is None:
        unknown = "occupied" if (leaves[:, 4] == _FREE_LEAF).any() else "free"
    kept = leaves if unknown == "occupied" else leaves[leaves[:, 4] == _OCCUPIED_LEAF]
    if not len(kept):
        raise InputError(f"{path}: expected something occupied, found all of it free")
    low, high = kept[:, :3].min(axis=0), (kept[:, :3] + kept[:, 3:4]).max(axis=0)
    coarser = _coarser(path, low, high, resolution, size)
    first = low >> coarser
    counts = tuple(int(n) for n in ((high - 1) >> coarser) - first + 1)
    require_voxel_count(path, counts)
    filled = np.zeros(counts, dtype=np.int64)
    wanted = leaves[leaves[:, 4] == (_FREE_LEAF if unknown == "occupied" else _OCCUPIED_LEAF)]
    _fill(filled, np.ascontiguousarray(wanted), first, coarser)
    occupied = filled < 8**coarser if unknown == "occupied" else filled > 0
    if not occupied.any():
        raise InputError(f"{path}: expected something occupied, found all of it free")
    if unknown == "free":
        first, occupied = trimmed(first, occupied)
    made = voxels_of_grid(first - (1 << (_TREE_DEPTH - 1 - coarser)), resolution * 2**coarser, occupied)
    return made.model_copy(update={"kind": KIND_OF_UNKNOWN[unknown], "solid": unknown == "free"})


def _coarser(path: Path, low: NDArray[np.int64], high: NDArray[np.int64], resolution: float, size: float | None) -> int:
    """Return how many times the size of the octree's voxels is doubled."""
    require_voxel_size(size)
    if size is None:
        coarser = 0
        while math.prod(int(n) for n in ((high - 1) >> coarser) - (low >> coarser) + 1) > MAX_VOXELS:
            coarser += 1
        return coarser
    coarser = round(math.log2(size / resolution))
    if not (0 <= coarser < _TREE_DEPTH and math.isclose(resolution * 2**coarser, size, rel_tol=1e-6)):
        raise InputError(f"{path}: size: expected the tree's {resolution:g} m times a power of two, found {size:g}")
    return coarser


def _leaves(path: Path) -> tuple[NDArray[np.int64], float]:
    """Return the leaves (n, 5), and the resolution, metres.

    A leaf is the number of its first voxel on each axis, how many voxels wide it is, and whether free or occupied.
    """
    with unreadable(path):
        data = path.read_bytes()
    binary = data.startswith(b"# Octomap OcTree binary file")
    if not binary and not data.startswith(b"# Octomap OcTree file"):
        raise InputError(f"{path}: expected an OctoMap file, which begins with '# Octomap OcTree', found {data[:30]!r}")
    end = re.search(rb"^data[ \r]*\n", data[:10_000], re.MULTILINE)
    if end is None:
        raise InputError(f"{path}: expected a line 'data' after the header, found none")
    head = dict(re.findall(r"^(id|size|res)[ \t]+(\S+)", data[: end.start()].decode("latin-1"), re.MULTILINE))
    kind = head.get("id", "")
    if kind not in _BYTES_OF_COLOUR:
        raise InputError(f"{path}: id: expected {' or '.join(_BYTES_OF_COLOUR)}, found {kind!r:.40}")
    resolution, nodes = _number(path, head, "res"), _number(path, head, "size")
    if not 1e-3 <= resolution <= 1e3:
        raise InputError(f"{path}: res: expected metres a voxel, 0.001 to 1000, found {resolution:g}")
    width = 2 if binary else 5 + _BYTES_OF_COLOUR[kind]
    tree = np.frombuffer(data, np.uint8, offset=end.end())
    if not len(tree) or len(tree) % width:
        raise InputError(f"{path}: expected nodes of {width} bytes, found {len(tree)} bytes in all")
    table = tree.reshape(-1, width).astype(np.int64)
    if binary:
        children = table[:, 0] | table[:, 1] << 8
        known = sum(int(np.count_nonzero(children >> 2 * k & 3)) for k in range(8))
        states, there = np.zeros(len(children), dtype=np.int64), known + 1
    else:
        odds = np.ascontiguousarray(tree.reshape(-1, width)[:, :4]).view("<f4")[:, 0]
        if np.isnan(odds).any():
            raise InputError(f"{path}: expected log-odds, found NaN")
        children, states, there = table[:, -1], np.where(odds >= 0, _OCCUPIED_LEAF, _FREE_LEAF), len(table)
    if there != nodes:
        raise InputError(f"{path}: size: expected {nodes:.0f} nodes as the header says, found {there}")
    leaves = np.empty((there, 5), dtype=np.int64)
    found, used = _walk(children, states, binary, leaves)
    if used < 0:
        raise InputError(f"{path}: expected a tree {_TREE_DEPTH} deep at most, found a deeper one")
    if used != len(table):
        raise InputError(
            f"{path}: expected one tree of {len(table)} nodes, found that {used} belong to it or are missing"
        )
    if not found:
        raise InputError(f"{path}: expected something occupied or free, found nothing")
    return leaves[:found], resolution


def _number(path: Path, head: dict[str, str], key: str) -> float:
    try:
        return float(head[key])
    except KeyError:
        raise InputError(f"{path}: {key}: is missing in the header") from None
    except ValueError:
        raise InputError(f"{path}: {key}: expected a number, found {head[key]!r:.40}") from None


@kernel
def _walk(
    children: NDArray[np.int64], states: NDArray[np.int64], binary: bool, leaves: NDArray[np.int64]
) -> tuple[int, int]:
    """Fill in `leaves`; return how many there are, and how many nodes were used.

    Nodes used are one more than there are where some are missing, and -1 where the octree is too deep.
    """
    corner = np.zeros((_TREE_DEPTH + 1, 3), dtype=np.int64)
    node = np.zeros(_TREE_DEPTH + 1, dtype=np.int64)
    following = np.zeros(_TREE_DEPTH + 1, dtype=np.int64)
    found, used, depth = 0, 1, 0
    if not binary and children[0] == 0:
        leaves[0, 0] = leaves[0, 1] = leaves[0, 2] = 0
        leaves[0, 3] = 1 << _TREE_DEPTH
        leaves[0, 4] = states[0]
        return 1, 1
    while depth >= 0:
        k = following[depth]
        if k == 8:
            depth -= 1
            continue
        following[depth] = k + 1
        width = 1 << (_TREE_DEPTH - 1 - depth)
        here = children[node[depth]]
        state = here >> 2 * k & 3 if binary else here >> k & 1
        if state == 0:
            continue
        inner = state == 3
        child = 0
        if inner or not binary:
            child = used
            used += 1
            if child == len(children):
                return found, used
            if not binary:
                inner = children[child] != 0
                state = states[child]
        if inner:
            if depth + 1 == _TREE_DEPTH:
                return found, -1
            for axis in range(3):
                corner[depth + 1, axis] = corner[depth, axis] + (k >> axis & 1) * width
            depth += 1
            node[depth] = child
            following[depth] = 0
        else:
            for axis in range(3):
                leaves[found, axis] = corner[depth, axis] + (k >> axis & 1) * width
            leaves[found, 3] = width
            leaves[found, 4] = state
            found += 1
    return found, used


@kernel
def _fill(filled: NDArray[np.int64], leaves: NDArray[np.int64], first: NDArray[np.int64], coarser: int) -> None:
    """Add to each coarse voxel the number of its small voxels that the leaves fill."""
    for row in range(len(leaves)):
        width = leaves[row, 3]
        cells = max(1, width >> coarser)
        volume = min(width, 1 << coarser) ** 3
        x = (leaves[row, 0] >> coarser) - first[0]
        y = (leaves[row, 1] >> coarser) - first[1]
        z = (leaves[row, 2] >> coarser) - first[2]
        for i in range(x, x + cells):
            for j in range(y, y + cells):
                for k in range(z, z + cells):
                    filled[i, j, k] += volume
