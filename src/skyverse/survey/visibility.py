"""Shortest ways in the plane among polygons: straight legs that bend at corners of what is not free.

A shortest way bends only at corners that stick into the free area (Lozano-Perez and Wesley 1979, doi
10.1145/359156.359164), so the cheapest ways in the graph of what sees what are exact, for lengths and for every price
of legs that grows with their length less than in proportion.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import SWEEP_CONTACT

LegPrice = Callable[[Floats], Floats]


@dataclass(frozen=True)
class PlanarWays:
    """The cheapest ways between all pairs of places.

    Attributes
    ----------
    price
        What the way from each place to each costs (k, k): metres, or as `shortest_ways` was told; infinite without one.
    places, corners
        The places (k, 2) and the corners (c, 2) at which ways may bend, metres.
    direct
        Which places see each other (k, k).
    out, back, first, between
        The price from places to corners (k, c), from corners to places (c, k), the corner that follows on the way from
        a corner to a corner (c, c), and the price of that way (c, c).
    """

    price: Floats
    places: Floats
    corners: Floats
    direct: Bools
    out: Floats
    back: Floats
    first: Ints
    between: Floats

    def points(self, start: int, end: int) -> Floats:
        """Return the points (n, 2) of the way from one place to another, both places included."""
        bends: list[Floats] = []
        if not self.direct[start, end]:
            whole = self.out[start][:, None] + self.between + self.back[:, end][None]
            at, last = np.unravel_index(int(np.argmin(whole)), whole.shape)
            while at != last:
                bends.append(self.corners[at])
                at = self.first[at, last]
            bends.append(self.corners[last])
        return np.array([self.places[start], *bends, self.places[end]])


def shortest_ways(free: Any, places: Floats, price: LegPrice | None = None) -> PlanarWays:
    """Find the cheapest ways between all pairs of places in the plane.

    Parameters
    ----------
    free
        shapely Polygon or MultiPolygon in which ways stay, its border included; None: everywhere.
    places
        Places (k, 2), metres.
    price
        Gives for vectors (..., 2) of straight legs what each costs; None: their lengths.
    """
    price = price or (lambda legs: np.hypot(legs[..., 0], legs[..., 1]))
    places = np.ascontiguousarray(places, dtype=float)
    edges, corners = outline(free), reflex_corners(free)
    everywhere = free is None
    direct = np.ones((len(places),) * 2, bool) if everywhere else _sight(edges, places, places, True)
    seen = _sight(edges, places, corners, False)
    between = np.where(_sight(edges, corners, corners, True), price(corners[None] - corners[:, None]), np.inf)
    np.fill_diagonal(between, 0.0)
    first = _all_pairs(between)
    out = np.where(seen, price(corners[None] - places[:, None]), np.inf)
    back = np.where(seen.T, price(places[None] - corners[:, None]), np.inf)
    straight = np.where(direct, price(places[None] - places[:, None]), np.inf)
    return PlanarWays(_by_corners(straight, out, between, back), places, corners, direct, out, back, first, between)


def outline(area: Any) -> Floats:
    """Return the edges (n, 4) of a shapely area as x0, y0, x1, y1, with the area to the left of each."""
    import shapely

    if area is None or area.is_empty:
        return np.empty((0, 4))
    rings = shapely.get_rings(shapely.orient_polygons(shapely.get_parts(area)))
    points = [shapely.get_coordinates(ring) for ring in rings]
    return np.ascontiguousarray(np.concatenate([np.hstack([ring[:-1], ring[1:]]) for ring in points]))


def reflex_corners(area: Any) -> Floats:
    """Return the corners (c, 2) of a shapely area at which it takes more than half a turn."""
    import shapely

    if area is None or area.is_empty:
        return np.empty((0, 2))
    found = []
    for ring in shapely.get_rings(shapely.orient_polygons(shapely.get_parts(area))):
        points = shapely.get_coordinates(ring)[:-1]
        before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
        found.append(points[before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] < 0.0])
    return np.ascontiguousarray(np.concatenate(found))


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
    """Tell whether a point is inside the edges (even-odd) or on one of them; without edges all is inside."""
    odd = len(edges) == 0
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
def _all_pairs(price: Floats) -> Ints:
    """Lower prices (c, c) of legs to those of the cheapest ways, and return which corner follows (Floyd, Warshall)."""
    n = len(price)
    first = np.empty((n, n), dtype=np.int64)
    for i in range(n):
        for j in range(n):
            first[i, j] = j
    for k in range(n):
        for i in range(n):
            if price[i, k] < np.inf:
                for j in range(n):
                    if price[i, k] + price[k, j] < price[i, j]:
                        price[i, j] = price[i, k] + price[k, j]
                        first[i, j] = first[i, k]
    return first


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
