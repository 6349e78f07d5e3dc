"""All that is read as voxels, by suffix."""

from collections.abc import Callable
from pathlib import Path

from skyverse.errors import InputError
from skyverse.maps.readers.grid import UNKNOWN, Unknown
from skyverse.maps.readers.lattice import CLEARANCE, lattice_of
from skyverse.model.scenario import Bounds, Scenario, Source
from skyverse.model.shapes import Voxels

SUFFIXES = (".3dmap", ".bt", ".ot", ".las", ".laz", ".ply", ".stl", ".obj")
TREES = (".bt", ".ot")
MARGIN = 10
"""Voxels of free space that `voxel_scenario` leaves about what is occupied."""


def read_voxels(path: str | Path, size: float | None = None, unknown: Unknown | None = None) -> Voxels:
    """Read an OctoMap tree, a .3dmap, a point cloud or a mesh as voxels, in the file's own coordinates, metres.

    Parameters
    ----------
    path
        A file that ends in one of `SUFFIXES`.
    size
        How long a voxel is, metres; each reader has its own default.
    unknown
        What an OctoMap's unknown space is taken for.

    Raises
    ------
    InputError
        If the file cannot be read; the message names it and says why.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: expected a file ending in {', '.join(SUFFIXES)}, found {path.suffix!r}")
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        return _reader(path.suffix.lower(), unknown)(path, size)
    except MemoryError:
        raise InputError(f"{path}: does not fit into memory") from None


def _reader(suffix: str, unknown: Unknown | None) -> Callable[[Path, float | None], Voxels]:
    """Return what reads such files; the others' libraries are not loaded."""
    if suffix == ".3dmap":
        from skyverse.maps.readers.moving_ai import read_3dmap

        return read_3dmap
    if suffix in TREES:
        from skyverse.maps.readers.octomap import read_octomap

        return lambda path, size: read_octomap(path, size, unknown)
    if suffix in (".las", ".laz"):
        from skyverse.maps.readers.cloud import read_las

        return read_las
    from skyverse.maps.readers.mesh import read_mesh

    return read_mesh


def voxel_scenario(path: str | Path, size: float | None = None, unknown: Unknown | None = None) -> Scenario:
    """Read such a file as a scenario without UAVs.

    Its bounds are the grid of a .3dmap, or what an OctoMap has seen where unknown space is occupied; else what is
    occupied and `MARGIN` voxels about. The clearance is 0.25 m, the lattice's step a voxel, or that doubled until there
    are a million nodes at most.

    Parameters
    ----------
    path, size
        As for `read_voxels`.
    unknown
        What an OctoMap's unknown space is taken for; see `read_octomap`. What it was is the kind of the voxels.
    """
    path = Path(path)
    solid = read_voxels(path, size, unknown)
    margin = 0 if path.suffix.lower() == ".3dmap" or solid.kind == UNKNOWN["occupied"] else MARGIN
    step = solid.step[0]
    bounds = Bounds(
        min=tuple(start - margin * step for start in solid.origin),
        max=tuple(start + (n + margin) * step for start, n in zip(solid.origin, solid.occupied.shape, strict=True)),
    )
    return Scenario(
        name=path.stem or path.name,
        bounds=bounds,
        obstacles=(solid,),
        clearance=CLEARANCE,
        lattice=lattice_of(bounds, step),
        sources=(Source(file=path.name, gives="voxels"),),
    )
