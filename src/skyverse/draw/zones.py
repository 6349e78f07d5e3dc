"""Zones as surfaces: an outline that stands upright, whatever the shape."""

import numpy as np
from numpy.typing import NDArray

from skyverse.draw.track import Floats
from skyverse.shapes import Cylinder, Prism

_CORNERS_OF_A_CIRCLE = 48


def outline(zone: Cylinder | Prism) -> Floats:
    """Return the corners (n, 2) of a zone's ground plan, against the clock; a circle has many."""
    if isinstance(zone, Cylinder):
        turn = 2 * np.pi * np.arange(_CORNERS_OF_A_CIRCLE) / _CORNERS_OF_A_CIRCLE
        return np.array(zone.centre) + zone.radius * np.column_stack([np.cos(turn), np.sin(turn)])
    corners = np.array(zone.vertices, dtype=np.float64)
    return corners if _area(corners) > 0 else corners[::-1]


def surface(zone: Cylinder | Prism) -> tuple[Floats, NDArray[np.int64]]:
    """Return a zone's points (2 n, 3), those of the floor first, and the triangles (m, 3) of floor, roof and walls."""
    corners = outline(zone)
    n = len(corners)
    points = np.vstack([np.column_stack([corners, np.full(n, level)]) for level in (zone.low, zone.high)])
    floor = _triangles(corners)
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    walls = np.vstack([np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])])
    return points, np.vstack([floor, floor + n, walls])


def _area(corners: Floats) -> float:
    return float(np.sum(corners[:, 0] * np.roll(corners[:, 1], -1) - corners[:, 1] * np.roll(corners[:, 0], -1)))


def _triangles(corners: Floats) -> NDArray[np.int64]:
    """Cut a simple polygon (n, 2), against the clock, into n - 2 triangles, ear by ear."""
    left = list(range(len(corners)))
    ears = []
    while len(left) > 3:
        for k in range(len(left)):
            ear = left[k - 1], left[k], left[(k + 1) % len(left)]
            others = corners[[i for i in left if i not in ear]]
            if _area(corners[list(ear)]) > 0 and not _inside(corners[list(ear)], others).any():
                break
        else:
            k, ear = 0, (left[-1], left[0], left[1])  # rounding has left no proper ear
        ears.append(ear)
        del left[k]
    return np.array([*ears, left])


def _inside(triangle: Floats, points: Floats) -> NDArray[np.bool_]:
    inside = np.ones(len(points), dtype=bool)
    for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        inside &= (b[0] - a[0]) * (points[:, 1] - a[1]) >= (b[1] - a[1]) * (points[:, 0] - a[0])
    return inside
