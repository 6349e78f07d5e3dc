"""Files in local metres that are read as voxels; the suffix tells the format."""

from collections.abc import Callable
from pathlib import Path

from skyverse.errors import InputError, require_file
from skyverse.maps.readers.scenario_defaults import DEFAULT_CLEARANCE, default_lattice
from skyverse.maps.readers.voxel_grid import KIND_OF_UNKNOWN, Unknown
from skyverse.model.scenario import Bounds, Scenario, Source
from skyverse.model.shapes import Voxels

VOXEL_SUFFIXES = (".3dmap", ".bt", ".ot", ".las", ".laz", ".ply", ".stl", ".obj")
OCTOMAP_SUFFIXES = (".bt", ".ot")
FREE_VOXELS_AROUND = 10
"""Voxels of free space that `voxel_scenario` leaves around what is occupied."""


def read_voxels(path: str | Path, size: float | None = None, unknown: Unknown | None = None) -> Voxels:
    """Read an OctoMap tree, a .3dmap, a point cloud or a mesh as voxels, in the file's own coordinates, metres.

    Parameters
    ----------
    path
        A file that ends in one of `VOXEL_SUFFIXES`.
    size
        How long a voxel is, metres; each format has its own default.
    unknown
        What an OctoMap's unknown space is taken for.

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
        return _reader(path.suffix.lower(), unknown)(path, size)
    except MemoryError:
        raise InputError(f"{path}: does not fit into memory") from None


def _reader(suffix: str, unknown: Unknown | None) -> Callable[[Path, float | None], Voxels]:
    """Return the function that reads such files; the libraries of other formats are not loaded."""
    if suffix == ".3dmap":
        from skyverse.maps.readers.moving_ai import read_3dmap

        return read_3dmap
    if suffix in OCTOMAP_SUFFIXES:
        from skyverse.maps.readers.octomap import read_octomap

        return lambda path, size: read_octomap(path, size, unknown)
    if suffix in (".las", ".laz"):
        from skyverse.maps.readers.point_cloud import read_las

        return read_las
    from skyverse.maps.readers.mesh import read_mesh

    return read_mesh


def voxel_scenario(path: str | Path, size: float | None = None, unknown: Unknown | None = None) -> Scenario:
    """Read a file of voxels as a scenario without UAVs.

    Its bounds are the grid of a .3dmap, and of an OctoMap whose unknown space is occupied the box of all that it has
    seen; otherwise they reach `FREE_VOXELS_AROUND` voxels beyond what is occupied. The clearance is 0.25 m. The
    lattice's step is a voxel's size, doubled until there are at most a million nodes.

    Parameters
    ----------
    path, size
        As for `read_voxels`.
    unknown
        What an OctoMap's unknown space is taken for; see `read_octomap`. The kind of the voxels tells which it was.
    """
    path = Path(path)
    solid = read_voxels(path, size, unknown)
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
        sources=(Source(file=path.name, gives="voxels"),),
    )
