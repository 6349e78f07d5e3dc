"""How many metres of a straight leg are inside a zone.

The leg is cut wherever it meets the surface of the zone, and a piece is inside if its middle is.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Sphere
from skyverse.referee.tolerances import EDGE_OVERHANG


def zone_hulls(zones: Sequence[AnyShape]) -> tuple[Floats, Floats]:
    """Return the corners (m, 3), (m, 3) of boxes about zones, metres."""
    return (
        np.array([_hull(zone)[0] for zone in zones]).reshape(-1, 3),
        np.array([_hull(zone)[1] for zone in zones]).reshape(-1, 3),
    )


def _hull(zone: AnyShape) -> tuple[Floats, Floats]:
    if isinstance(zone, Box):
        return np.array(zone.min), np.array(zone.max)
    if isinstance(zone, Sphere):
        return np.array(zone.centre) - zone.radius, np.array(zone.centre) + zone.radius
    if isinstance(zone, Cylinder):
        low, high = np.array(zone.centre) - zone.radius, np.array(zone.centre) + zone.radius
    elif isinstance(zone, Prism):
        low, high = np.min(zone.vertices, axis=0), np.max(zone.vertices, axis=0)
    else:
        return np.array(zone.origin), np.array(zone.origin) + np.array(zone.step) * zone.occupied.shape
    return np.array([*low, zone.low]), np.array([*high, zone.high])


def metres_inside(zone: AnyShape, a: Floats, b: Floats) -> float:
    """Return how many metres of the leg from a to b, (3,) metres, are inside a zone."""
    ends = shares_between(_cuts(zone, a, b))
    middles = a + ((ends[:-1] + ends[1:]) / 2)[:, None] * (b - a)
    return float(np.linalg.norm(b - a) * np.sum(np.diff(ends)[_holds(zone, middles)]))


def shares_between(cuts: Sequence[float]) -> Floats:
    """Return the shares, from 0 to 1, at which the pieces of a leg begin and end that is cut at some shares."""
    return np.unique(np.clip([0.0, *cuts, 1.0], 0.0, 1.0))


def _cuts(zone: AnyShape, a: Floats, b: Floats) -> list[float]:
    """Return all shares of a leg at which it meets the surface of a zone; there may be others among them."""
    if isinstance(zone, Box):
        return [t for axis in range(3) for t in _crossings(a, b, axis, np.array([zone.min[axis], zone.max[axis]]))]
    if isinstance(zone, Sphere):
        return _at_radius(a - np.array(zone.centre), b - a, zone.radius)
    if isinstance(zone, Cylinder):
        circle = _at_radius(a[:2] - np.array(zone.centre), (b - a)[:2], zone.radius)
        return circle + _crossings(a, b, 2, np.array([zone.low, zone.high]))
    if isinstance(zone, Prism):
        walls = [t for ring in (zone.vertices, *zone.holes) for t in _outline_cuts(np.array(ring), a[:2], b[:2])]
        return walls + _crossings(a, b, 2, np.array([zone.low, zone.high]))
    planes = [
        zone.origin[axis] + zone.step[axis] * np.arange(zone.occupied.shape[axis] + 1, dtype=np.float64)
        for axis in range(3)
    ]
    return [t for axis in range(3) for t in _crossings(a, b, axis, planes[axis])]


def _crossings(a: Floats, b: Floats, axis: int, levels: Floats) -> list[float]:
    """Return the shares at which the leg from a to b, (3,), crosses planes across an axis."""
    return [float(t) for t in (levels - a[axis]) / (b[axis] - a[axis])] if a[axis] != b[axis] else []


def _at_radius(to: Floats, way: Floats, radius: float) -> list[float]:
    """Return the shares at which the line `to` + share `way` is at a radius from zero, or else nearest to zero."""
    return [float(t.real) for t in np.roots([way @ way, 2 * to @ way, to @ to - radius**2])]


def _outline_cuts(ring: Floats, a: Floats, b: Floats) -> list[float]:
    """Return the shares at which the line from a to b, (2,), meets the edges of an outline (n, 2) or nearly does."""
    edge, to, way = np.roll(ring, -1, axis=0) - ring, ring - a, b - a
    turn = way[0] * edge[:, 1] - way[1] * edge[:, 0]
    slanted = np.where(turn != 0, turn, 1.0)
    along = (to[:, 0] * edge[:, 1] - to[:, 1] * edge[:, 0]) / slanted
    share = (to[:, 0] * way[1] - to[:, 1] * way[0]) / slanted
    return [float(t) for t in along[(turn != 0) & (share > -EDGE_OVERHANG) & (share < 1 + EDGE_OVERHANG)]]


def _holds(zone: AnyShape, points: Floats) -> NDArray[np.bool_]:
    """Tell which of the points (n, 3) are inside a zone."""
    inside: NDArray[np.bool_]
    if isinstance(zone, Box):
        inside = np.all((points >= zone.min) & (points <= zone.max), axis=1)
    elif isinstance(zone, Sphere):
        inside = np.linalg.norm(points - zone.centre, axis=1) <= zone.radius
    elif isinstance(zone, Cylinder):
        inside = np.linalg.norm(points[:, :2] - zone.centre, axis=1) <= zone.radius
        inside &= (points[:, 2] >= zone.low) & (points[:, 2] <= zone.high)
    elif isinstance(zone, Prism):
        inside = (points[:, 2] >= zone.low) & (points[:, 2] <= zone.high)
        inside &= _goes_round(np.array(zone.vertices), points)
        for hole in zone.holes:
            inside &= ~_goes_round(np.array(hole), points)
    else:
        cell = np.floor((points - zone.origin) / zone.step)
        held = np.all((cell >= 0) & (cell < zone.occupied.shape), axis=1)
        i, j, k = np.where(held[:, None], cell, 0).astype(np.intp).T
        inside = held & zone.occupied[i, j, k]
    return inside


def _goes_round(ring: Floats, points: Floats) -> NDArray[np.bool_]:
    """Tell which of the points (n, 3), seen from above, an outline (m, 2) goes round, by the sum of its angles."""
    seen = ring[None] - points[:, None, :2]
    following = np.roll(seen, -1, axis=1)
    across = seen[..., 0] * following[..., 1] - seen[..., 1] * following[..., 0]
    turned: Floats = np.arctan2(across, np.sum(seen * following, axis=2)).sum(axis=1)
    return np.abs(turned) > np.pi
