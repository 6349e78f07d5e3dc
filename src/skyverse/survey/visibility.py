"""Shortest ways in the plane among polygons: straight legs that bend at corners of what is not free.

A shortest way bends only at corners that stick into the free area (Lozano-Perez and Wesley 1979, doi
10.1145/359156.359164), so the cheapest ways in the graph of what sees what are exact, for lengths and for every price
of legs that grows with their length less than in proportion.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import shapely
from scipy.sparse.csgraph import floyd_warshall

from skyverse._typing import Bools, Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import SWEEP_CONTACT

LegPrice = Callable[[Floats], Floats]


def way_prices(free: Any, places: Floats, price: LegPrice) -> Floats:
    """Return what the cheapest ways between all pairs of places (k, 2) in the plane cost, (k, k); infinite without one.

    Parameters
    ----------
    free
        shapely Polygon or MultiPolygon in which ways stay, its border included.
    places
        Metres.
    price
        Gives for vectors (..., 2) of straight legs what each costs.
    """
    places = np.ascontiguousarray(places, dtype=float)
    edges, corners = outline(free), reflex_corners(free)
    direct, seen = _sight(edges, places, places, True), _sight(edges, places, corners, False)
    legs = np.where(_sight(edges, corners, corners, True), price(corners[None] - corners[:, None]), np.inf)
    between = floyd_warshall(np.maximum(legs, np.finfo(float).tiny)) if len(corners) else legs  # 0 would be no leg
    out = np.where(seen, price(corners[None] - places[:, None]), np.inf)
    back = np.where(seen.T, price(places[None] - corners[:, None]), np.inf)
    straight = np.where(direct, price(places[None] - places[:, None]), np.inf)
    return _by_corners(straight, out, between, back)


def outline(area: Any) -> Floats:
    """Return the edges (n, 4) of a shapely area as x0, y0, x1, y1, with the area to the left of each."""
    return np.ascontiguousarray(np.concatenate([np.hstack([ring[:-1], ring[1:]]) for ring in _rings(area)]))


def reflex_corners(area: Any) -> Floats:
    """Return the corners (c, 2) of a shapely area at which it takes more than half a turn."""
    found = []
    for points in (ring[:-1] for ring in _rings(area)):
        before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
        found.append(points[before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] < 0.0])
    return np.ascontiguousarray(np.concatenate(found))


def _rings(area: Any) -> list[Floats]:
    rings = shapely.get_rings(shapely.orient_polygons(shapely.get_parts(area)))
    return [shapely.get_coordinates(ring) for ring in rings]


@kernel
def _sight(edges: Floats, a: Floats, b: Floats, same: bool) -> Bools:
    """Return which points of a (m, 2) see which of b (k, 2) inside the area left of the edges; `same`: b is a."""
    out = np.zeros((len(a), len(b)), dtype=np.bool_)
    touches = np.empty(len(edges) + 2)
    for i in range(len(a)):
        for j in range(len(b)):
            if not same or j > i:
                out[i, j] = _sees(edges, a[i, 0], a[i, 1], b[j, 0], b[j, 1], touches)
            elif j < i:
                out[i, j] = out[j, i]
            else:
                out[i, j] = _inside(edges, a[i, 0], a[i, 1])
    return out


@inner
def _sees(edges: Floats, ax: float, ay: float, bx: float, by: float, touches: Floats) -> bool:
    """Tell whether a segment stays in the area: it crosses no edge, and between touched corners it is inside."""
    length = np.hypot(bx - ax, by - ay)
    if length <= SWEEP_CONTACT:
        return _inside(edges, ax, ay)
    ux, uy = (bx - ax) / length, (by - ay) / length
    low_x, high_x = min(ax, bx) - SWEEP_CONTACT, max(ax, bx) + SWEEP_CONTACT
    low_y, high_y = min(ay, by) - SWEEP_CONTACT, max(ay, by) + SWEEP_CONTACT
    count = 0
    for e in range(len(edges)):
        px, py, qx, qy = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
        if (px < low_x and qx < low_x) or (px > high_x and qx > high_x):
            continue
        if (py < low_y and qy < low_y) or (py > high_y and qy > high_y):
            continue
        p, q = ux * (py - ay) - uy * (px - ax), ux * (qy - ay) - uy * (qx - ax)
        if abs(p) <= SWEEP_CONTACT:
            along = ux * (px - ax) + uy * (py - ay)
            if SWEEP_CONTACT < along < length - SWEEP_CONTACT:
                touches[count] = along
                count += 1
        elif abs(q) > SWEEP_CONTACT and (p > 0.0) != (q > 0.0):
            side = np.hypot(qx - px, qy - py)
            a = ((qx - px) * (ay - py) - (qy - py) * (ax - px)) / side
            b = ((qx - px) * (by - py) - (qy - py) * (bx - px)) / side
            if abs(a) > SWEEP_CONTACT and abs(b) > SWEEP_CONTACT and (a > 0.0) != (b > 0.0):
                return False
    touches[count] = length
    touches[: count + 1].sort()
    begin = 0.0
    for t in range(count + 1):
        middle = 0.5 * (begin + touches[t])
        if touches[t] - begin > SWEEP_CONTACT and not _inside(edges, ax + middle * ux, ay + middle * uy):
            return False
        begin = touches[t]
    return True


@inner
def _inside(edges: Floats, x: float, y: float) -> bool:
    """Tell whether a point is inside the edges (even-odd) or on one of them."""
    odd = False
    for e in range(len(edges)):
        px, py, qx, qy = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
        dx, dy = qx - px, qy - py
        if min(px, qx) - SWEEP_CONTACT <= x <= max(px, qx) + SWEEP_CONTACT:
            off = dx * (y - py) - dy * (x - px)
            near = min(py, qy) - SWEEP_CONTACT <= y <= max(py, qy) + SWEEP_CONTACT
            if near and abs(off) <= SWEEP_CONTACT * np.hypot(dx, dy):
                return True
        if (py > y) != (qy > y) and x < px + (y - py) / dy * dx:
            odd = not odd
    return odd


@kernel
def _by_corners(straight: Floats, out: Floats, between: Floats, back: Floats) -> Floats:
    """Return what the cheapest ways cost (k, k): straight on, or by corners."""
    n, corners = out.shape
    price = straight.copy()
    reach = np.empty(corners)
    for i in range(n):
        reach[:] = np.inf
        for c in range(corners):
            if out[i, c] < np.inf:
                for d in range(corners):
                    reach[d] = min(reach[d], out[i, c] + between[c, d])
        for c in range(corners):
            if reach[c] < np.inf:
                for j in range(n):
                    price[i, j] = min(price[i, j], reach[c] + back[c, j])
    return price
