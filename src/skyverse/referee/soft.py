"""The soft terms of a path, computed anew: altitude band, climb limit, and the metres flown inside zones."""

import itertools

import numpy as np

from skyverse._typing import Floats
from skyverse.model.scenario import AltitudeBand, ClimbLimit, Scenario
from skyverse.referee.boxes import TOLERANCE
from skyverse.referee.ground import Ground
from skyverse.referee.zones import hulls, metres_inside, pieces

_NUDGES = TOLERANCE * np.array([(0, 0, 0), *(n for n in itertools.product((-1, 0, 1), repeat=3) if any(n))])


def altitude(band: AltitudeBand, path: Floats, ground: Ground | None = None) -> float:
    """Return the integral over the path (n, 3) of the metres outside the band; above ground if it counts from there."""
    total = 0.0
    for a, b in itertools.pairwise(path):
        if band.above == "ground" and ground is not None:
            total += float(np.linalg.norm(b - a)) * _outside(band, *ground.pieces(a, b))
            continue
        # straight between the ends and where it crosses the band's edges: there the mean of both ends is exact
        cuts = pieces([(edge - a[2]) / (b[2] - a[2]) if a[2] != b[2] else 0.0 for edge in (band.low, band.high)])
        z = a[2] + cuts * (b[2] - a[2])
        outside = np.maximum(0.0, np.maximum(band.low - z, z - band.high))
        total += float(np.linalg.norm(b - a) * np.sum(np.diff(cuts) * (outside[:-1] + outside[1:]) / 2))
    return total


def _outside(band: AltitudeBand, cuts: Floats, above: Floats) -> float:
    """Return the integral over the leg, as a share of it, of the metres outside the band.

    The height above ground (n, 3) is a quadratic between two cuts (n + 1,). Cut where it crosses the band's edges too,
    what is outside is one as well, and Simpson's rule is exact.
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
    """Return both roots of quadratics (n, 3), the constant first; 0 where there are none."""
    c, b, a = rows.T
    square = b**2 - 4 * a * c
    q = -(b + np.copysign(np.sqrt(np.maximum(square, 0.0)), b)) / 2
    first = np.where((square >= 0) & (a != 0), q / np.where(a != 0, a, 1.0), 0.0)
    second = np.where((square >= 0) & (q != 0), c / np.where(q != 0, q, 1.0), 0.0)
    return np.nan_to_num(first), np.nan_to_num(second)


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
    low, high = hulls(scenario.zones)
    near = np.all(path.min(axis=0) <= high + TOLERANCE, axis=1) & np.all(path.max(axis=0) >= low - TOLERANCE, axis=1)
    for k in np.flatnonzero(near):
        zone = scenario.zones[k]
        for a, b in itertools.pairwise(path):
            if np.all(np.minimum(a, b) <= high[k] + TOLERANCE) and np.all(np.maximum(a, b) >= low[k] - TOLERANCE):
                inside = [(zone.risk or 0.0) * metres_inside(zone, a + nudge, b + nudge) for nudge in _NUDGES]
                stands, least, most = stands + inside[0], least + min(inside), most + max(inside)
    return stands, least, most
