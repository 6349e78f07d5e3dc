"""The soft terms of a path's cost, computed anew: the altitude band, the climb limit, and the risk of zones."""

import itertools

import numpy as np

from skyverse._typing import Floats
from skyverse.model.scenario import AltitudeBand, ClimbLimit, Scenario
from skyverse.referee.ground import GrownGround
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.zones import metres_inside, shares_between, zone_hulls

_OFFSETS = LET_PASS * np.array([(0, 0, 0), *(n for n in itertools.product((-1, 0, 1), repeat=3) if any(n))])


def altitude_term(band: AltitudeBand, path: Floats, ground: GrownGround | None = None) -> float:
    """Return the integral along a path (n, 3) of the metres that it is outside the band, m^2.

    Where the band counts from the ground, so do the heights.
    """
    total = 0.0
    for a, b in itertools.pairwise(path):
        if band.above == "ground" and ground is not None:
            total += float(np.linalg.norm(b - a)) * _mean_outside(band, *ground.heights_along(a, b))
            continue
        # linear between the places where the leg crosses the band's edges, so that the mean of both ends is exact
        cuts = shares_between(
            [(edge - a[2]) / (b[2] - a[2]) if a[2] != b[2] else 0.0 for edge in (band.low, band.high)]
        )
        z = a[2] + cuts * (b[2] - a[2])
        outside = np.maximum(0.0, np.maximum(band.low - z, z - band.high))
        total += float(np.linalg.norm(b - a) * np.sum(np.diff(cuts) * (outside[:-1] + outside[1:]) / 2))
    return total


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
    angles = np.arcsin(np.minimum(np.abs(steps[:, 2]) / lengths, 1.0))
    return float(np.sum(lengths * np.maximum(0.0, angles - np.radians(limit.angle))))


def risk_term(scenario: Scenario, path: Floats) -> tuple[float, float, float]:
    """Return the sum over the zones of their risk times the metres of a path (n, 3) inside: as it is, least and most.

    A leg along the surface of a zone may count as inside or as outside. The least and the most are therefore taken leg
    by leg over all legs that are moved by at most `LET_PASS` along each axis.
    """
    as_it_is = least = most = 0.0
    low, high = zone_hulls(scenario.zones)
    near = np.all(path.min(axis=0) <= high + LET_PASS, axis=1) & np.all(path.max(axis=0) >= low - LET_PASS, axis=1)
    for k in np.flatnonzero(near):
        zone = scenario.zones[k]
        for a, b in itertools.pairwise(path):
            if np.all(np.minimum(a, b) <= high[k] + LET_PASS) and np.all(np.maximum(a, b) >= low[k] - LET_PASS):
                inside = [(zone.risk or 0.0) * metres_inside(zone, a + offset, b + offset) for offset in _OFFSETS]
                as_it_is, least, most = as_it_is + inside[0], least + min(inside), most + max(inside)
    return as_it_is, least, most
