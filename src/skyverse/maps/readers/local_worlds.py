"""Worlds in local metres as scenarios: files of voxels, whose suffix tells the format, and those of rotorpy.

Source: rotorpy.world.World, https://github.com/spencerfolk/rotorpy
"""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from skyverse.errors import InputError, require_file, shown
from skyverse.maps.georeference.feature import are_numbers, require_type
from skyverse.maps.readers.voxel_grid import KIND_OF_UNKNOWN, Unknown
from skyverse.model.scenario import Bounds, Lattice, Scenario, Source
from skyverse.model.shapes import Box, Voxels

DEFAULT_CLEARANCE = 0.25
"""Metres from a map's obstacles, as in the maps of the MEAM 620 course."""
MAX_LATTICE_NODES = 1e6
"""Nodes at most in a lattice."""


def default_lattice(bounds: Bounds, step: float) -> Lattice:
    """Return a lattice of cubes whose side is a step, metres, doubled until there are at most `MAX_LATTICE_NODES`."""
    sides = [high - low for low, high in zip(bounds.min, bounds.max, strict=True)]
    while math.prod(side / step + 1 for side in sides) > MAX_LATTICE_NODES:
        step *= 2
    x, y, z = (min(step, side) for side in sides)
    return Lattice(step=(x, y, z))


VOXEL_SUFFIXES = (".3dmap", ".bt", ".ot", ".las", ".laz", ".pcd", ".ply", ".stl", ".obj")
OCTOMAP_SUFFIXES = (".bt", ".ot")
FREE_VOXELS_AROUND = 10
"""Voxels of free space that `voxel_scenario` leaves around what is occupied."""


def read_voxels(
    path: str | Path,
    size: float | None = None,
    unknown: Unknown | None = None,
    tell: Callable[[str], object] = lambda said: None,
) -> Voxels:
    """Read an OctoMap tree, a .3dmap, a point cloud or a mesh as voxels, in the file's own coordinates, metres.

    Parameters
    ----------
    path
        A file that ends in one of `VOXEL_SUFFIXES`.
    size
        How long a voxel is, metres; each format has its own default.
    unknown
        What an OctoMap's unknown space is taken for.
    tell
        Called with what is left out of the file.

    Raises
    ------
    InputError
        If the file cannot be read; the message names it and says why.
    """
    path = Path(path)
    if path.suffix.lower() not in VOXEL_SUFFIXES:
        raise InputError(f"{path}: expected a file ending in {', '.join(VOXEL_SUFFIXES)}, found {path.suffix!r}")
    require_file(path)
    try:
        return _reader(path.suffix.lower(), unknown, tell)(path, size)
    except MemoryError:
        raise InputError(f"{path}: does not fit into memory") from None


def _reader(
    suffix: str, unknown: Unknown | None, tell: Callable[[str], object]
) -> Callable[[Path, float | None], Voxels]:
    """Return the function that reads such files; it loads the libraries of its format when it reads."""
    from skyverse.maps.readers import mesh, octomap, pcd, voxel_grid

    readers: dict[str, Callable[[Path, float | None], Voxels]] = {
        ".3dmap": voxel_grid.read_3dmap,
        **dict.fromkeys(OCTOMAP_SUFFIXES, partial(octomap.read_octomap, unknown=unknown)),
        **dict.fromkeys((".las", ".laz"), voxel_grid.read_las),
        ".pcd": partial(pcd.read_pcd, tell=tell),
        **dict.fromkeys((".ply", ".stl", ".obj"), mesh.read_mesh),
    }
    return readers[suffix]


def voxel_scenario(path: str | Path, unknown: Unknown | None = None) -> Scenario:
    """Read a file of voxels as a scenario without UAVs.

    Its bounds are the grid of a .3dmap, and of an OctoMap whose unknown space is occupied the box of all that it has
    seen; otherwise they reach `FREE_VOXELS_AROUND` voxels beyond what is occupied. The clearance is 0.25 m. The
    lattice's step is a voxel's size, doubled until there are at most a million nodes.

    Parameters
    ----------
    path
        As for `read_voxels`.
    unknown
        What an OctoMap's unknown space is taken for; see `read_octomap`. The kind of the voxels tells which it was.
    """
    path, left_out = Path(path), list[str]()
    solid = read_voxels(path, unknown=unknown, tell=left_out.append)
    margin = 0 if path.suffix.lower() == ".3dmap" or solid.kind == KIND_OF_UNKNOWN["occupied"] else FREE_VOXELS_AROUND
    step = solid.step[0]
    bounds = Bounds(
        min=tuple(start - margin * step for start in solid.origin),
        max=tuple(start + (n + margin) * step for start, n in zip(solid.origin, solid.occupied.shape, strict=True)),
    )
    return Scenario(
        name=path.stem or path.name,
        bounds=bounds,
        obstacles=(solid,),
        clearance=DEFAULT_CLEARANCE,
        lattice=default_lattice(bounds, step),
        sources=(Source(file=path.name, gives="voxels", cautions=tuple(left_out)),),
    )


def is_rotorpy_world(data: object) -> bool:
    """Tell whether the data of a JSON file are a world of rotorpy."""
    return isinstance(data, dict) and isinstance(data.get("bounds"), dict) and "extents" in data["bounds"]


def rotorpy_world(path: Path, data: dict[str, Any]) -> Scenario:
    """Return a rotorpy world as a scenario without UAVs: its bounds, and its blocks as boxes; the rest is not read.

    Raises
    ------
    InputError
        If a field is not as it should be; the message names it.
    """
    low, high = _corners(f"{path}: bounds.extents", data["bounds"]["extents"])
    blocks = require_type(list, data.get("blocks", []), f"{path}: blocks", "a list")
    boxes = []
    for k, block in enumerate(blocks):
        if not isinstance(block, dict) or "extents" not in block:
            raise InputError(f"{path}: blocks[{k}]: expected an object with 'extents', found {shown(block)}")
        corners = _corners(f"{path}: blocks[{k}].extents", block["extents"])
        boxes.append(Box(min=corners[0], max=corners[1]))
    bounds = Bounds(min=low, max=high)
    try:
        return Scenario(
            name=path.stem,
            bounds=bounds,
            obstacles=tuple(boxes),
            clearance=DEFAULT_CLEARANCE,
            lattice=default_lattice(bounds, DEFAULT_CLEARANCE),
            sources=(Source(file=path.name, gives="bounds and boxes"),),
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _corners(where: str, extents: Any) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    if not are_numbers(extents, (6,), 1e9):
        raise InputError(f"{where}: expected xmin, xmax, ymin, ymax, zmin, zmax in metres, found {shown(extents, 60)}")
    x, xx, y, yy, z, zz = map(float, extents)
    if not (x < xx and y < yy and z < zz):
        raise InputError(f"{where}: expected each minimum below its maximum, found {shown(extents, 60)}")
    return (x, y, z), (xx, yy, zz)
