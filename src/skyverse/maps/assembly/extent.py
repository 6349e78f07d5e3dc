"""How high a scenario's bounds reach, the step of its lattice, and the heights that its paths keep to."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from skyverse.errors import InputError, Remedy
from skyverse.maps.assembly.bad_points import BadPoint
from skyverse.maps.assembly.obstacles import LocalFeatures
from skyverse.maps.assembly.terrain import GIVE_GROUND
from skyverse.model.altitude import AboveGround, AboveHome, Altitude
from skyverse.model.frame import Origin
from skyverse.model.round_steps import round_steps
from skyverse.model.scenario import AltitudeBand, Bounds
from skyverse.model.shapes import Terrain, Voxels

DEFAULT_HEADROOM = 30.0
"""Metres from the highest ground, building, UAV or target to the ceiling by default."""
LEAST_DEFAULT_STEP = 1.0
"""Metres between the lattice's nodes at least where its step is not given."""
VERY_LOW_LEVEL = 152.4
"""Metres, 500 feet: how high the airspace is in which UAVs fly; zones that begin higher than this above the highest
ground, building, UAV or target do not raise the ceiling."""


def heights(
    relief: Terrain | None,
    these: Sequence[LocalFeatures],
    solids: Sequence[Voxels],
    points: Sequence[tuple[float, float, float]],
) -> tuple[float, float]:
    """Return the lowest and the highest z of ground, buildings, voxels and points, and of where zones begin."""
    z = [point[2] for point in points]
    for one in these:
        standing = np.array([feature.kind == "building" for feature in one.features], dtype=bool)
        ends = np.concatenate([one.low[standing], one.high[standing]])
        z += ends[np.isfinite(ends)].tolist()
    for solid in solids:
        z += [solid.origin[2], solid.origin[2] + solid.step[2] * solid.occupied.shape[2]]
    if relief is not None:
        highest = max([float(relief.heights.max()), *z])
        return float(np.floor(relief.heights.min())), max([highest, *_beginnings(these, highest)])
    if not z:
        z = [end for one in these for end in [*one.low, *one.high] if math.isfinite(end)] or [0.0]
    return math.floor(min(z)), max([*z, *_beginnings(these, max(z))])


def _beginnings(these: Sequence[LocalFeatures], highest: float) -> list[float]:
    """Return the z at which zones begin that UAVs could reach from below, so that the bounds do not end before them."""
    lows = np.concatenate([np.empty(0), *(one.low for one in these)])
    return lows[np.isfinite(lows) & (lows <= highest + VERY_LOW_LEVEL)].tolist()


def ceiling(
    asked: Altitude | None,
    band: tuple[float, float] | None,
    frame: Origin,
    relief: Terrain | None,
    floor: float,
    highest: float,
) -> float:
    """Return z of the bounds' upper end.

    Parameters
    ----------
    asked
        What the user asks for, if anything.
    band
        The heights above ground that paths keep to, metres.
    frame, relief
        The local frame's origin, and the ground, if it is known.
    floor, highest
        z of the bounds' lower end, and of the highest thing in the scenario.
    """
    ground = None if relief is None else float(relief.heights.max())
    if asked is None:
        if band is not None and ground is not None:
            highest = max(highest, ground + band[1])
        return float(math.ceil(highest + DEFAULT_HEADROOM))
    if isinstance(asked, AboveHome):
        raise InputError("expected agl (above the ground below) or amsl, found home", field="ceiling")
    if isinstance(asked, AboveGround):
        if ground is None:
            raise InputError("metres above ground need the ground", field="max_height", give=GIVE_GROUND)
        top = ground + asked.metres
    else:
        top = asked.metres - frame.altitude
    if top <= floor + 1:
        raise InputError(
            f"expected an altitude above the lowest ground, {frame.altitude + floor:.0f} m amsl, found "
            f"{frame.altitude + top:.0f} m amsl",
            field="ceiling",
        )
    return top


def high_points(points: Iterable[tuple[str, tuple[float, float, float]]], top: float) -> list[BadPoint]:
    """Return those points, given with their names, that are above the ceiling."""
    return [
        BadPoint(
            name,
            point,
            f"expected a point below the ceiling, found it {point[2] - top:.1f} m above",
            give=(Remedy("ceiling", None, "to raise it"),),
        )
        for name, point in points
        if point[2] > top
    ]


def lattice_step(bounds: Bounds, step: float | None, upright: float = math.inf) -> tuple[float, float, float]:
    """Return the lattice's step along each axis, metres: the one asked for, or the shortest of few enough nodes.

    One that is not asked for is no longer along z than `upright`, metres.
    """
    sizes = [high - low for low, high in zip(bounds.min, bounds.max, strict=True)]
    if step is None:
        return round_steps(sizes, LEAST_DEFAULT_STEP, upright)
    x, y, z = (min(step, size) for size in sizes)
    return x, y, z


def altitude_band(band: tuple[float, float] | None, weight: float, relief: Terrain | None) -> AltitudeBand | None:
    """Return the heights above ground that paths keep to, and the price of leaving them."""
    if band is None:
        return None
    if relief is None:
        raise InputError("metres above ground need the ground", field="band", give=GIVE_GROUND)
    if not 0 <= band[0] <= band[1]:
        raise InputError(f"expected low,high metres above ground, low not above high, found {band}", field="band")
    return AltitudeBand(low=band[0], high=band[1], weight=weight, above="ground")
