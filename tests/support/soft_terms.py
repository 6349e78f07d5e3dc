"""An oracle of the soft terms of a path's cost: the altitude band, the climb limit, and the risk of zones.

A leg is cut wherever it meets the surface of a zone, and a piece is inside if its middle is.
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.model.arrays import arctan2
from skyverse.model.scenario import AltitudeBand, ClimbLimit, Scenario
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Sphere
from skyverse.referee.tolerances import LET_PASS

EDGE_OVERHANG = 1e-3
"""Share of an edge: a leg is also cut where it passes this close to an edge's ends; a cut too many changes nothing."""
_OFFSETS = LET_PASS * np.array([(0, 0, 0), *(n for n in itertools.product((-1, 0, 1), repeat=3) if any(n))])


def altitude_term(band: AltitudeBand, path: Floats) -> float:
    """Return the integral along a path (n, 3) of the metres that it is outside a band above zero, m^2."""
    total = 0.0
    for a, b in itertools.pairwise(path):
        # linear between the places where the leg crosses the band's edges, so that the mean of both ends is exact
        cuts = _shares_between(
            [(edge - a[2]) / (b[2] - a[2]) if a[2] != b[2] else 0.0 for edge in (band.low, band.high)]
        )
        z = a[2] + cuts * (b[2] - a[2])
        outside = np.maximum(0.0, np.maximum(band.low - z, z - band.high))
        total += float(math.dist(b, a) * np.sum(np.diff(cuts) * (outside[:-1] + outside[1:]) / 2))
    return total


def climb_term(limit: ClimbLimit, path: Floats) -> float:
    """Return the integral along a path (n, 3) of the radians that it is steeper than the limit, m rad."""
    steps = np.diff(path, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    steps, lengths = steps[lengths > 0], lengths[lengths > 0]
    angles = arctan2(np.abs(steps[:, 2]), np.hypot(steps[:, 0], steps[:, 1]))
    return float(np.sum(lengths * np.maximum(0.0, angles - np.radians(limit.angle))))


def risk_term(scenario: Scenario, path: Floats) -> tuple[float, float, float]:
    """Return the sum over the zones of their risk times the metres of a path (n, 3) inside: as it is, least and most.

    A leg along the surface of a zone may count as inside or as outside. The least and the most are therefore taken leg
    by leg over all legs that are moved by at most `LET_PASS` along each axis.
    """
    as_it_is = least = most = 0.0
    low, high = _zone_hulls(scenario.zones)
    near = np.all(path.min(axis=0) <= high + LET_PASS, axis=1) & np.all(path.max(axis=0) >= low - LET_PASS, axis=1)
    for k in np.flatnonzero(near):
        zone = scenario.zones[k]
        for a, b in itertools.pairwise(path):
            if np.all(np.minimum(a, b) <= high[k] + LET_PASS) and np.all(np.maximum(a, b) >= low[k] - LET_PASS):
                inside = [(zone.risk or 0.0) * metres_inside(zone, a + offset, b + offset) for offset in _OFFSETS]
                as_it_is, least, most = as_it_is + inside[0], least + min(inside), most + max(inside)
    return as_it_is, least, most


def _zone_hulls(zones: Sequence[AnyShape]) -> tuple[Floats, Floats]:
    """Return the corners (m, 3), (m, 3) of boxes about zones, metres."""
    corners = np.reshape([_hull(zone) for zone in zones], (len(zones), 2, 3))
    return corners[:, 0], corners[:, 1]


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
    ends = _shares_between(_cuts(zone, a, b))
    middles = a + ((ends[:-1] + ends[1:]) / 2)[:, None] * (b - a)
    return float(math.dist(b, a) * np.sum(np.diff(ends)[_holds(zone, middles)]))


def _shares_between(cuts: Sequence[float]) -> Floats:
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
    square, on = float(np.sum(way**2)), float(np.sum(to * way))
    apart = math.sqrt(max(on**2 - square * (float(np.sum(to**2)) - radius**2), 0.0))
    return [(-on - apart) / square, (-on + apart) / square] if square > 0.0 else []


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
    turned: Floats = arctan2(across, np.sum(seen * following, axis=2)).sum(axis=1)
    return np.abs(turned) > np.pi
