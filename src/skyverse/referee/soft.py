"""The soft terms of a path, computed anew: altitude band, climb limit, and the metres flown inside zones."""

import itertools

import numpy as np

from skyverse.referee.boxes import TOLERANCE, Floats
from skyverse.scenario import AltitudeBand, ClimbLimit, Scenario
from skyverse.shapes import Cylinder, Prism

_NUDGES = TOLERANCE * np.array([(0, 0, 0), *(n for n in itertools.product((-1, 0, 1), repeat=3) if any(n))])


def altitude(band: AltitudeBand, path: Floats) -> float:
    """Return the integral over the path (n, 3) of the metres outside the band."""
    total = 0.0
    for a, b in itertools.pairwise(path):
        # straight between the ends and where it crosses the band's edges: there the mean of both ends is exact
        cuts = _pieces([_crossing(a[2], b[2], edge) for edge in (band.low, band.high)])
        z = a[2] + cuts * (b[2] - a[2])
        outside = np.maximum(0.0, np.maximum(band.low - z, z - band.high))
        total += float(np.linalg.norm(b - a) * np.sum(np.diff(cuts) * (outside[:-1] + outside[1:]) / 2))
    return total


def climb(limit: ClimbLimit, path: Floats) -> float:
    """Return the integral over the path (n, 3) of the radians above the limit."""
    steps = np.diff(path, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    steps, lengths = steps[lengths > 0], lengths[lengths > 0]
    angles = np.arcsin(np.minimum(np.abs(steps[:, 2]) / lengths, 1.0))
    return float(np.sum(lengths * np.maximum(0.0, angles - np.radians(limit.angle))))


def risk(scenario: Scenario, path: Floats) -> tuple[float, float, float]:
    """Return the sum of the zones' risks times the metres flown inside: as it stands, at least, and at most.

    A leg along a zone's surface is as good inside as outside: at least and at most are taken leg by leg over all
    places that are off by no more than the tolerance along each axis.
    """
    stands = least = most = 0.0
    for zone in scenario.zones:
        low, high = _hull(zone)
        for a, b in itertools.pairwise(path):
            if np.all(np.minimum(a, b) <= high + TOLERANCE) and np.all(np.maximum(a, b) >= low - TOLERANCE):
                inside = [zone.risk * _metres_inside(zone, a + nudge, b + nudge) for nudge in _NUDGES]
                stands, least, most = stands + inside[0], least + min(inside), most + max(inside)
    return stands, least, most


def _hull(zone: Cylinder | Prism) -> tuple[Floats, Floats]:
    if isinstance(zone, Cylinder):
        low, high = np.array(zone.centre) - zone.radius, np.array(zone.centre) + zone.radius
    else:
        low, high = np.min(zone.vertices, axis=0), np.max(zone.vertices, axis=0)
    return np.array([*low, zone.low]), np.array([*high, zone.high])


def _metres_inside(zone: Cylinder | Prism, a: Floats, b: Floats) -> float:
    """Cut the segment wherever it meets the surface; a piece is inside if its middle is."""
    cuts = [_crossing(a[2], b[2], level) for level in (zone.low, zone.high)]
    if isinstance(zone, Cylinder):
        to, way = a[:2] - np.array(zone.centre), (b - a)[:2]
        cuts += [float(t.real) for t in np.roots([way @ way, 2 * to @ way, to @ to - zone.radius**2])]
    else:
        corners = np.array(zone.vertices)
        for p, q in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            columns = np.column_stack([(b - a)[:2], p - q])
            if np.linalg.det(columns) != 0:
                cuts.append(float(np.linalg.solve(columns, p - a[:2])[0]))
    ends = _pieces(cuts)
    middles = a + ((ends[:-1] + ends[1:]) / 2)[:, None] * (b - a)
    inside = [_holds(zone, middle) for middle in middles]
    return float(np.linalg.norm(b - a) * np.sum(np.diff(ends)[inside]))


def _holds(zone: Cylinder | Prism, point: Floats) -> bool:
    if not zone.low <= point[2] <= zone.high:
        return False
    if isinstance(zone, Cylinder):
        return float(np.hypot(*(point[:2] - zone.centre))) <= zone.radius
    seen = np.array(zone.vertices) - point[:2]  # from inside, the outline goes once round
    following = np.roll(seen, -1, axis=0)
    turned = np.arctan2(
        seen[:, 0] * following[:, 1] - seen[:, 1] * following[:, 0], np.sum(seen * following, axis=1)
    ).sum()
    return bool(abs(turned) > np.pi)


def _crossing(start: float, end: float, level: float) -> float:
    return (level - start) / (end - start) if start != end else 0.0


def _pieces(cuts: list[float]) -> Floats:
    """Return the shares at which a segment's pieces begin and end."""
    return np.unique(np.clip([0.0, *cuts, 1.0], 0.0, 1.0))
