"""An oracle of the soft terms of a path's cost: the altitude band, the climb limit, and the risk of zones.

A leg is cut wherever it meets the surface of a zone, and a piece is inside if its middle is.
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.model.elementary import arctan2
from skyverse.model.scenario import AltitudeBand, ClimbLimit, Scenario
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Sphere
from skyverse.referee.ground import GrownGround
from skyverse.referee.tolerances import LET_PASS

EDGE_OVERHANG = 1e-3
"""Share of an edge: a leg is also cut where it passes this close to an edge's ends; a cut too many changes nothing."""
_OFFSETS = LET_PASS * np.array([(0, 0, 0), *(n for n in itertools.product((-1, 0, 1), repeat=3) if any(n))])


def altitude_term(band: AltitudeBand, path: Floats, ground: GrownGround | None = None) -> float:
    """Return the integral along a path (n, 3) of the metres that it is outside the band, m^2.

    Where the band counts from the ground, so do the heights.
    """
    total = 0.0
    for a, b in itertools.pairwise(path):
        if band.above == "ground" and ground is not None:
            total += math.dist(b, a) * _mean_outside(band, *_heights_along(ground, a, b))
            continue
        # linear between the places where the leg crosses the band's edges, so that the mean of both ends is exact
        cuts = _shares_between(
            [(edge - a[2]) / (b[2] - a[2]) if a[2] != b[2] else 0.0 for edge in (band.low, band.high)]
        )
        z = a[2] + cuts * (b[2] - a[2])
        outside = np.maximum(0.0, np.maximum(band.low - z, z - band.high))
        total += float(math.dist(b, a) * np.sum(np.diff(cuts) * (outside[:-1] + outside[1:]) / 2))
    return total


def _heights_along(ground: GrownGround, a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Cut the straight leg from a to b, (3,) metres, where it passes from one cell to the next.

    Returns
    -------
    cuts
        (n + 1,) shares of the leg, from 0 to 1.
    above
        (n, 3) metres: the leg's height above ground between two cuts, as the coefficients of a quadratic in the share
        of the leg, the constant first.
    """
    way = b - a
    shares = [np.array([0.0, 1.0])]
    for axis in (0, 1):
        if way[axis] != 0:
            low, high = np.sort((np.array([a[axis], b[axis]]) - ground.origin[axis]) / ground.step[axis])
            borders = np.arange(max(np.floor(low), 0), min(np.ceil(high), ground.heights.shape[axis] - 1) + 1)
            shares.append((ground.origin[axis] + borders * ground.step[axis] - a[axis]) / way[axis])
    cuts = np.unique(np.clip(np.concatenate(shares), 0.0, 1.0))
    middles = a[:2] + ((cuts[:-1] + cuts[1:]) / 2)[:, None] * way[:2]
    last = np.array(ground.heights.shape) - 2
    cell = np.clip(np.nan_to_num(np.floor((middles - ground.origin) / ground.step)), 0, last).astype(np.intp)
    i, j = cell.T
    h, along_x, along_y, far = (ground.heights[i + di, j + dj] for di, dj in ((0, 0), (1, 0), (0, 1), (1, 1)))
    p, q, e = along_x - h, along_y - h, far - along_x - along_y + h
    u, v = ((a[:2] - (ground.origin + cell * ground.step)) / ground.step).T
    du, dv = way[:2] / ground.step
    constant = a[2] - (h + p * u + q * v + e * u * v)
    slope = way[2] - (p * du + q * dv + e * (u * dv + v * du))
    return cuts, np.column_stack([constant, slope, -e * du * dv])


def _mean_outside(band: AltitudeBand, cuts: Floats, above: Floats) -> float:
    """Return the mean over a leg of the metres that it is outside the band.

    The height above ground is a quadratic (n, 3) between each two of the cuts (n + 1,). If the leg is also cut where it
    crosses the band's edges, the metres outside are quadratics too, and Simpson's rule is exact.
    """
    roots = [root for edge in (band.low, band.high) for root in _roots(above - [edge, 0.0, 0.0])]
    ends = np.sort(np.column_stack([np.clip(each, cuts[:-1], cuts[1:]) for each in (cuts[:-1], *roots, cuts[1:])]))
    total = 0.0
    for begin, end in zip(ends[:, :-1].T, ends[:, 1:].T, strict=True):
        for share, weight in ((0.0, 1 / 6), (0.5, 4 / 6), (1.0, 1 / 6)):
            t = begin + share * (end - begin)
            height = above[:, 0] + t * (above[:, 1] + t * above[:, 2])
            outside = np.maximum(0.0, np.maximum(band.low - height, height - band.high))
            total += weight * float(np.sum((end - begin) * outside))
    return total


def _roots(rows: Floats) -> tuple[Floats, Floats]:
    """Return both roots, (n,) each, of quadratics (n, 3) with the constant first; 0 where there are none."""
    c, b, a = rows.T
    square = b**2 - 4 * a * c
    q = -(b + np.copysign(np.sqrt(np.maximum(square, 0.0)), b)) / 2
    first = np.where((square >= 0) & (a != 0), q / np.where(a != 0, a, 1.0), 0.0)
    second = np.where((square >= 0) & (q != 0), c / np.where(q != 0, q, 1.0), 0.0)
    return np.nan_to_num(first), np.nan_to_num(second)


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
