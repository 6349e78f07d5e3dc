"""Triangulation of polygons by ear clipping, after their holes are joined to the outline."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, kernel


def area(ring: Floats) -> float:
    """Return the area inside an outline, (n, 2); negative where the outline runs clockwise."""
    x, y = (ring[1:] - ring[0]).T
    return float(x[:-1] @ y[1:] - y[:-1] @ x[1:]) / 2


def turned(ring: Floats, sense: int) -> Floats:
    """Return an outline that runs counter-clockwise for a `sense` of 1, clockwise for -1."""
    return ring if area(ring) * sense > 0 else ring[::-1]


def joined(rings: Sequence[Floats]) -> Ints:
    """Return the indices of the corners, counted through all rings, in one order that runs around polygon and holes.

    The first ring is the outline, counter-clockwise; the others are holes, clockwise. Each hole is joined to the
    outline by a seam that is followed in both directions (D. Eberly, "Triangulation by Ear Clipping").
    """
    corners = np.concatenate(rings)
    starts = np.cumsum([0, *map(len, rings)])
    around = list(range(len(rings[0])))
    for k in sorted(range(1, len(rings)), key=lambda k: -rings[k][:, 0].max()):
        first = int(np.argmax(rings[k][:, 0]))
        hole = [int(starts[k] + (first + step) % len(rings[k])) for step in range(len(rings[k]) + 1)]
        seam = _seen(corners, np.array(around), corners[hole[0]])
        around[seam : seam + 1] = [around[seam], *hole, around[seam]]
    return np.array(around)


def triangles(rings: Sequence[Floats]) -> Ints:
    """Return the triangles of a polygon, (m, 3) indices of corners, counter-clockwise; rings are as in `joined`."""
    corners = np.concatenate(rings)
    around = joined(rings)
    places = np.ascontiguousarray(corners[around] - corners[0])
    return around[_ears(places)]


def _seen(corners: Floats, around: Ints, place: Floats) -> int:
    """Return which corner of the outline `around` is visible along x from a place inside it."""
    a, b = corners[around], corners[np.roll(around, -1)]
    # the ray along x leaves a counter-clockwise outline at edges that go upwards
    crossed = np.flatnonzero((a[:, 1] <= place[1]) & (b[:, 1] > place[1]))
    share = (place[1] - a[crossed, 1]) / (b[crossed, 1] - a[crossed, 1])
    at = a[crossed, 0] + share * (b[crossed, 0] - a[crossed, 0])
    ahead = at >= place[0]
    edge = int(crossed[ahead][np.argmin(at[ahead])])
    met = np.array([at[ahead].min(), place[1]])
    n = len(around)
    best = edge if a[edge, 0] > b[edge, 0] else (edge + 1) % n
    # other corners inside the triangle of place, met and tip may hide the tip: take the one nearest to the ray
    tip = corners[around[best]]
    triangle = np.array([place, met, tip] if tip[1] > place[1] else [place, tip, met])
    hidden = [i for i in np.flatnonzero(_inside(triangle, a)).tolist() if _opens_to(a, i, place)]
    if _opens_to(a, best, place) and best not in hidden:
        hidden.append(best)
    to = [a[i] - place for i in hidden]
    slopes = [(abs(y) / x if x > 0 else np.inf, x) for x, y in to]
    return int(hidden[min(range(len(hidden)), key=lambda i: slopes[i])]) if hidden else best


def _opens_to(ring: Floats, i: int, place: Floats) -> bool:
    """Return whether a place lies between the two edges at corner i, on the inner side."""
    before, corner, after = ring[i - 1], ring[i], ring[(i + 1) % len(ring)]
    left = _cross(corner - before, place - before) >= 0
    right = _cross(after - corner, place - corner) >= 0
    return left and right if _cross(corner - before, after - corner) >= 0 else left or right


def _cross(u: Floats, v: Floats) -> float:
    return float(u[0] * v[1] - u[1] * v[0])


def _inside(triangle: Floats, points: Floats) -> NDArray[np.bool_]:
    inside = np.ones(len(points), dtype=bool)
    for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        inside &= (b[0] - a[0]) * (points[:, 1] - a[1]) >= (b[1] - a[1]) * (points[:, 0] - a[0])
    return inside


@inner
def _turn(places: Floats, i: int, j: int, k: int) -> float:
    ahead: float = (places[j, 0] - places[i, 0]) * (places[k, 1] - places[i, 1])
    aside: float = (places[j, 1] - places[i, 1]) * (places[k, 0] - places[i, 0])
    return ahead - aside


@kernel
def _ears(places: Floats) -> Ints:
    """Return the triangles, (n - 2, 3), of a counter-clockwise ring, (n, 2), which may touch itself along seams."""
    n = len(places)
    before, after = np.arange(n) - 1, np.arange(n) + 1
    before[0], after[n - 1] = n - 1, 0
    found = np.empty((n - 2, 3), np.int64)
    j, refused = 0, 0
    left = n
    for m in range(n - 2):
        while True:
            i, k = before[j], after[j]
            ear = _turn(places, i, j, k) > 0.0
            p = after[k]
            while ear and p != i:
                # only reflex corners can lie in an ear; those at the place of its own corners belong to a seam
                if _turn(places, before[p], p, after[p]) <= 0.0:
                    own = False
                    for c in (i, j, k):
                        own = own or (places[p, 0] == places[c, 0] and places[p, 1] == places[c, 1])
                    if not own:
                        ear = not (
                            _turn(places, i, j, p) >= 0.0
                            and _turn(places, j, k, p) >= 0.0
                            and _turn(places, k, i, p) >= 0.0
                        )
                p = after[p]
            # collinear corners are cut off as triangles of area 0 once no ear is left
            if ear or refused >= left:
                break
            refused += 1
            j = k
        found[m, 0], found[m, 1], found[m, 2] = i, j, k
        after[i], before[k] = k, i
        left -= 1
        refused = 0
        j = after[k] if left > 3 else k
    return found
