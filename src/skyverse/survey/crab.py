"""Noses that point into the wind: pictures of aeroplanes, which do not lie along their strips in a wind across them."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import shapely
from shapely import affinity

from skyverse.errors import InputError
from skyverse.model.uav import UAV
from skyverse.model.wind import Wind

HALVINGS = 40
"""How often distances between photos are cut in two to find where they overlap as asked."""


def crab_angle(uavs: tuple[UAV, ...], wind: Wind | None) -> float:
    """Return by how many radians the nose of an aeroplane is turned from its course at most; 0 without one, or wind."""
    across = 0.0 if wind is None else float(np.hypot(*wind.table[1][:, :2].T).max())
    speeds = [uav.fixed_wing.speed for uav in uavs if uav.fixed_wing is not None]
    return max((math.asin(min(across / speed, 1.0)) for speed in speeds), default=0.0)


def inscribed(sides: Sequence[float], angle: float) -> list[float]:
    """Return the sides of the largest rectangle within one with positive `sides` that is turned by 0 to pi/2."""
    c, s, long = math.cos(angle), math.sin(angle), max(sides)
    if min(sides) <= long * math.sin(2.0 * angle):  # two of its corners lie midway between the long sides
        return [min(sides) / (2.0 * (s if own == long else c)) for own in sides]
    return [(own * c - other * s) / math.cos(2.0 * angle) for own, other in zip(sides, reversed(sides), strict=True)]


def overlap_to_plan(asked: tuple[float, float], half_widths: tuple[float, float], angle: float) -> tuple[float, float]:
    """Return the shares along and between strips that straight photos have, where turned ones have what is asked.

    Photos on one strip are turned alike; those of strips that are flown in opposite directions are turned apart.

    Parameters
    ----------
    asked
        The shares.
    half_widths
        Of pictures, across the flight and along it.
    angle
        Radians.

    Raises
    ------
    InputError
        However near they are, turned photos do not overlap as asked.
    """
    if angle == 0.0:
        return asked
    wide, long = half_widths
    right, left = (
        affinity.rotate(shapely.box(-wide, -long, wide, long), turn, use_radians=True) for turn in (angle, -angle)
    )

    def along(way: float) -> float:
        return float(right.intersection(affinity.translate(right, 0.0, way)).area)

    def between(way: float) -> float:
        return min(float(right.intersection(affinity.translate(one, way, 0.0)).area) for one in (left, right))

    def planned(shared: Callable[[float], float], share: float, size: float) -> float:
        most = shared(0.0) / right.area
        if most < share:
            turned = f"which photos share at most where the wind turns aeroplanes by up to {math.degrees(angle):.0f}"
            raise InputError(
                f"expected less than {math.floor(100 * most)} %, {turned} degrees, found {100 * share:.0f} %",
                field="overlap",
            )
        low, high = 0.0, size
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if shared(middle) >= share * right.area else (low, middle)
        return 1.0 - low / size

    return planned(along, asked[0], 2.0 * long), planned(between, asked[1], 2.0 * wide)
