"""How high a scenario reaches, what its lattice is, and which heights it keeps to."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from skyverse.errors import InputError
from skyverse.maps.assembly.obstacles import Placed
from skyverse.maps.assembly.terrain import height_of
from skyverse.maps.readers.raster import Rectangle
from skyverse.model.altitude import AboveGround, AboveHome, Altitude
from skyverse.model.scenario import AltitudeBand, Bounds, Origin
from skyverse.model.shapes import Terrain, Voxels

ABOVE = 30.0
"""Metres from the highest ground, building, UAV or target to the ceiling when nothing is said."""
MOST_NODES = 2e6
"""Of the lattice when nothing is said."""
_STEPS = [digit * 10.0**power for power in range(-1, 5) for digit in (1, 2, 5)]


def heights(
    relief: Terrain | None,
    these: Sequence[Placed],
    solids: Sequence[Voxels],
    points: Sequence[tuple[float, float, float]],
) -> tuple[float, float]:
    """Return the lowest and the highest z of what is there."""
    z = [point[2] for point in points]
    for one in these:
        standing = np.array([feature.kind == "building" for feature in one.features], dtype=bool)
        ends = np.concatenate([one.low[standing], one.high[standing]])
        z += ends[np.isfinite(ends)].tolist()
    for solid in solids:
        z += [solid.origin[2], solid.origin[2] + solid.step[2] * solid.occupied.shape[2]]
    if relief is not None:
        return float(np.floor(relief.heights.min())), max([float(relief.heights.max()), *z])
    if not z:
        z = [end for one in these for end in [*one.low, *one.high] if math.isfinite(end)] or [0.0]
    return math.floor(min(z)), max(z)


def ceiling(
    asked: Altitude | None,
    band: tuple[float, float] | None,
    frame: Origin,
    region: Rectangle,
    relief: Terrain | None,
    floor: float,
    highest: float,
) -> float:
    """Return z of the bounds' upper end."""
    ground = None if relief is None else float(relief.heights.max())
    if asked is None:
        if band is not None and ground is not None:
            highest = max(highest, ground + band[1])
        return float(math.ceil(highest + ABOVE))
    if isinstance(asked, AboveHome):
        raise InputError("--ceiling: expected agl (above the highest ground) or amsl, found home")
    if isinstance(asked, AboveGround):
        if ground is None:
            raise InputError("--ceiling: agl needs the ground: --terrain FILE, or --ground '0 m amsl'")
        top = ground + asked.metres
    else:  # lowest where it is farthest away
        x, y = (np.array([max(region[k], region[k + 2], key=abs)]) for k in (0, 1))
        top = float(height_of(frame, x, y, np.array([asked.metres]))[0])
    if top <= floor + 1:
        raise InputError(
            f"--ceiling: expected an altitude above the lowest ground, {frame.altitude + floor:.0f} m amsl, found "
            f"{frame.altitude + top:.0f} m amsl"
        )
    return top


def refuse_high(points: Mapping[str, tuple[float, float, float]], top: float) -> None:
    """Refuse a point above the ceiling."""
    for name, point in points.items():
        if point[2] > top:
            raise InputError(
                f"{name}: expected a point below the ceiling, found it {point[2] - top:.1f} m above; raise --ceiling"
            )


def lattice(bounds: Bounds, step: float | None) -> tuple[float, float, float]:
    """Return the lattice's step along each axis: what is asked for, or what makes not too many nodes."""
    sizes = [high - low for low, high in zip(bounds.min, bounds.max, strict=True)]
    if step is None:
        step = next(
            (s for s in _STEPS if s >= 1 and math.prod(size / min(s, size) + 1 for size in sizes) <= MOST_NODES),
            _STEPS[-1],
        )
    x, y, z = (min(step, size) for size in sizes)
    return x, y, z


def band(band: tuple[float, float] | None, weight: float, relief: Terrain | None) -> AltitudeBand | None:
    """Return the heights above ground to keep to."""
    if band is None:
        return None
    if relief is None:
        raise InputError("--band: metres above ground need the ground: --terrain FILE, or --ground '0 m amsl'")
    if not 0 <= band[0] <= band[1]:
        raise InputError(f"--band: expected low,high metres above ground, low not above high, found {band}")
    return AltitudeBand(low=band[0], high=band[1], weight=weight, above="ground")
