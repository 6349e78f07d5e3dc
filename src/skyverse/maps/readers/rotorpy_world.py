"""Worlds of the simulator rotorpy: JSON with ``bounds`` and ``blocks``, each of which has ``extents``.

Source: rotorpy.world.World, https://github.com/spencerfolk/rotorpy
"""

from pathlib import Path
from typing import Any

from skyverse.errors import InputError, shown
from skyverse.maps.georeference.fields import are_numbers, require_type
from skyverse.maps.readers.scenario_defaults import DEFAULT_CLEARANCE, default_lattice
from skyverse.model.scenario import Bounds, Scenario, Source
from skyverse.model.shapes import Box


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
