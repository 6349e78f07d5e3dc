"""Straight segments: how far points are from them, and where two of them are nearest to each other."""

import numpy as np

from skyverse._typing import Floats


def share_of(part: Floats, whole: Floats) -> Floats:
    """Return which shares parts are of wholes, between 0 and 1; 0 of a whole that is nothing."""
    share: Floats = np.clip(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0), 0.0, 1.0)
    return share


def distance_to_segment(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distances (n,) of points (n, d) from the segments between a (n, d) and b (n, d), metres."""
    way = b - a
    share = share_of(np.sum((points - a) * way, axis=1), np.sum(way**2, axis=1))
    distance: Floats = np.sqrt(np.sum((a + share[:, None] * way - points) ** 2, axis=1))
    return distance


def nearest_points(p: Floats, q: Floats, r: Floats, s: Floats) -> tuple[Floats, Floats, Floats]:
    """Return where segments p-q and r-s, (m, 3) metres, are nearest: both shares and the distance, (m,) each.

    The squared distance is convex in both shares. Its least value is inside, where both derivatives are 0, or on an
    edge of the unit square; the least of all candidates is taken, so that rounding only ever chooses among distances.
    """
    u, v, w = q - p, s - r, p - r
    uu, uv, vv, uw, vw = (np.einsum("ij,ij->i", x, y) for x, y in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    inner = share_of(uv * vw - vv * uw, uu * vv - uv * uv)
    candidates = []
    for share in (np.zeros(len(p)), np.ones(len(p)), inner):
        other = share_of(vw + share * uv, vv)
        candidates.append((share_of(other * uv - uw, uu), other))
    candidates += [(share_of(other * uv - uw, uu), other) for other in (np.zeros(len(p)), np.ones(len(p)))]
    shares, others = (np.array(column) for column in zip(*candidates, strict=True))
    between = np.linalg.norm(w + shares[..., None] * u - others[..., None] * v, axis=2)
    best = np.argmin(between, axis=0)
    rows = np.arange(len(p))
    return shares[best, rows], others[best, rows], between[best, rows]
