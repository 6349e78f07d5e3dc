"""What may hide places from cameras besides the ground: walls of solid obstacles, balls, and triangles of structures.

An upright solid that a straight line enters, it enters or leaves through a wall, or its bottom where it hangs.
Its walls count from its top down to any depth, so that nothing is seen through the air below it from beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely

from skyverse._typing import Bools, Floats, Indices
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Sphere
from skyverse.model.survey import Facet
from skyverse.referee.ground_cells import convex_parts
from skyverse.referee.photo_views import PhotoView
from skyverse.referee.tolerances import LET_PASS, NO_LENGTH

ROUND = 32
"""Corners of the polygons about cylinders, and about slices of spheres."""
SLABS = 8
"""Upright solids that stand for a sphere."""
TOUCHES = 3
"""How often the plane that touches a ball is turned to where the camera is worst."""
PAIRS_AT_ONCE = 2**18
"""Places and blockers looked at together, which bounds the memory."""


class Solid(NamedTuple):
    """An upright solid about an obstacle or a part of it.

    Attributes
    ----------
    polygon, core
        What it fills seen from above, and what the obstacle is certain to fill.
    low, high
        From which z to which, metres.
    obstacle
        The obstacle's number.
    ball
        x, y, z and radius, metres, of the sphere of which it is a slice.
    """

    polygon: shapely.Geometry
    core: shapely.Geometry
    low: float
    high: float
    obstacle: int
    ball: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Blockers:
    """Flat convex parts, each on a plane and within three lines on it; and balls, which have no plane and no lines.

    Attributes
    ----------
    low, high
        (n, 2) the least and the greatest x and y.
    top
        (n,) the greatest z.
    normal, anchor
        (n, 3) of the plane, to the outside, and a point on it; of balls, nothing and the centre.
    points, directions
        (n, 3, 3) of the lines, counterclockwise as seen from outside.
    closed
        (n,) whether it belongs to a solid, so that a rising line meets it from outside first.
    radius
        (n,) metres, of balls; 0 of others.
    """

    low: Floats
    high: Floats
    top: Floats
    normal: Floats
    anchor: Floats
    points: Floats
    directions: Floats
    closed: Bools
    radius: Floats

    @property
    def upright(self) -> tuple[Floats, Floats]:
        """One end and the unit normal of each upright part as seen from above, (m, 2), (m, 2)."""
        some = (self.normal[:, 2] == 0) & (self.radius == 0)
        return self.anchor[some, :2], self.normal[some, :2]

    def shadows(self, view: PhotoView, lowest: float, rising: bool) -> tuple[Indices, Floats, Floats]:
        """Return the parts that may hide what is above a height, and the boxes (k, 2), (k, 2) seen from above there.

        `rising` tells that all places are below the camera.
        """
        c, error = view.position, view.error
        eye, stray = c[2] - error.vertical, error.horizontal
        if rising:
            outside = np.einsum("ij,ij->i", self.normal, c - self.anchor) >= stray
            some = np.flatnonzero(~(outside & self.closed))
        else:
            some = np.arange(len(self.top))
        low, high, fall = self.low[some], self.high[some], eye - self.top[some]
        longer = (
            np.divide(max(eye - lowest, 0.0), fall, out=np.full(len(some), 1e9), where=fall > NO_LENGTH)[:, None] - 1.0
        )
        longer = np.maximum(longer, 0.0)
        least = np.minimum(low, low + longer * (low - c[:2] - stray))
        most = np.maximum(high, high + longer * (high - c[:2] + stray))
        return some, least, most

    def hide(self, corners: Floats, which: Indices, view: PhotoView) -> tuple[Bools, Bools]:
        """Return of hulls of corners (n, k, 3) whether some parts (n,) may hide places in them from the camera.

        And whether they hide all of them from where the camera is nominally.
        """
        found = np.zeros((2, len(which)), dtype=np.bool_)
        for begin in range(0, len(which), PAIRS_AT_ONCE):
            here = slice(begin, begin + PAIRS_AT_ONCE)
            found[:, here] = self._hide(corners[here], which[here], view)
        return found[0], found[1]

    def _hide(self, x: Floats, which: Indices, view: PhotoView) -> Bools:
        normal, anchor = self.normal[which], self.anchor[which]
        level, upright = view.error.horizontal, view.error.vertical
        side = np.einsum("ijk,ik->ij", x - anchor[:, None], normal)
        away = sum((view.position[k] - anchor[:, k]) * normal[:, k] for k in range(3))
        stray = level * np.hypot(normal[:, 0], normal[:, 1]) + upright * np.abs(normal[:, 2])
        outside, inside = side.min(axis=1) >= -LET_PASS, side.max(axis=1) <= LET_PASS
        before, behind = away - stray >= 0, away + stray <= 0
        some = np.flatnonzero(~((outside & before) | (inside & behind)))
        does = ((outside & behind) | (inside & before))[some]
        inward, outward = (outside | behind)[some], (inside | before)[some]  # which way lines pass that meet the plane
        for line in range(3):
            e, d = self.points[which[some], line], self.directions[which[some], line][:, None]
            a = x[some] - e[:, None]
            w = np.stack([a[:, :, i] * d[:, :, j] - a[:, :, j] * d[:, :, i] for i, j in ((1, 2), (2, 0), (0, 1))])
            turn = sum(w[k] * (view.position[k] - e[:, None, k]) for k in range(3))
            stray = level * np.hypot(w[0], w[1]) + upright * np.abs(w[2])
            does &= np.where(inward, turn.min(axis=1) > 0, turn.max(axis=1) < 0)
            may = ~(inward & (turn + stray <= LET_PASS).all(axis=1))
            may &= ~(outward & (turn - stray >= -LET_PASS).all(axis=1))
            some, does, inward, outward = some[may], does[may], inward[may], outward[may]
        found = np.zeros((2, len(outside)), dtype=np.bool_)
        found[0, some], found[1, some] = True, does
        round_ = np.flatnonzero(self.radius[which] > 0)
        found[:, round_] = _behind_balls(
            x[round_] - anchor[round_, None], self.radius[which[round_]], anchor[round_], view
        )
        return found


def _behind_balls(x: Floats, radius: Floats, centre: Floats, view: PhotoView) -> Bools:
    """Return of hulls of corners (n, k, 3), seen from the centres of balls, whether these may hide them, and do.

    They do not if hull and camera, wherever it may be, are beyond a plane that touches the ball. The plane is upright
    on the way from the ball to the nearest place between the middle of the hull and the camera where it is worst.
    """
    camera, level, upright = view.position - centre, view.error.horizontal, view.error.vertical
    worst, middle = camera, x.mean(axis=1)
    for _ in range(TOUCHES):
        near = _nearest(middle, worst)
        out = near / np.maximum(np.linalg.norm(near, axis=1), NO_LENGTH)[:, None]
        side = np.hypot(out[:, 0], out[:, 1])
        aside = out[:, :2] * (level / np.maximum(side, NO_LENGTH))[:, None]
        worst = camera - np.column_stack([aside, np.sign(out[:, 2]) * upright])
    clear = np.minimum(np.einsum("ikj,ij->ik", x, out).min(axis=1), np.einsum("ij,ij->i", worst, out))
    deep = np.linalg.norm(_nearest(x, camera[:, None]), axis=2).max(axis=1, initial=0.0)
    return np.stack([clear < radius - LET_PASS, deep < radius])


def _nearest(a: Floats, b: Floats) -> Floats:
    """Return the places between places (..., 3) and others that are nearest to (0, 0, 0)."""
    way = b - a
    share = -(a * way).sum(axis=-1) / np.maximum((way * way).sum(axis=-1), NO_LENGTH)
    found: Floats = a + np.clip(share, 0.0, 1.0)[..., None] * way
    return found


def solids_of(obstacles: Sequence[AnyShape]) -> list[Solid]:
    """Return upright solids that fill all solid obstacles."""
    found = []
    for number, shape in enumerate(obstacles):
        if shape.solid:
            ball = (*shape.centre, shape.radius) if isinstance(shape, Sphere) else None
            found += [Solid(*one, number, ball) for one in _upright(shape)]
    return found


def closed_between(obstacles: Sequence[AnyShape], low: float, high: float) -> shapely.Geometry:
    """Return where obstacles and zones, solid or not, are between two altitudes, as seen from above."""
    parts = [one for shape in obstacles for one in _upright(shape)]
    return shapely.union_all([polygon for polygon, _, bottom, top in parts if bottom < high and top > low])


def _upright(shape: AnyShape) -> list[tuple[shapely.Geometry, shapely.Geometry, float, float]]:
    if isinstance(shape, Box):
        polygon = shapely.box(*shape.min[:2], *shape.max[:2])
        return [(polygon, polygon, shape.min[2], shape.max[2])]
    if isinstance(shape, Prism):
        polygon = shapely.polygons(shape.vertices, list(shape.holes) or None)
        return [(polygon, polygon, shape.low, shape.high)]
    if isinstance(shape, Cylinder):
        return [(*_about(shape.centre, shape.radius, shape.radius), shape.low, shape.high)]
    if isinstance(shape, Sphere):
        z = np.linspace(-shape.radius, shape.radius, SLABS + 1)  # of which the middle one is 0
        wide = np.sqrt(np.maximum(shape.radius**2 - z**2, 0.0))
        (x, y, middle), most, least = shape.centre, np.maximum(wide[1:], wide[:-1]), np.minimum(wide[1:], wide[:-1])
        slabs = zip(most.tolist(), least.tolist(), (middle + z).tolist(), (middle + z[1:]).tolist(), strict=False)
        return [(*_about((x, y), r, inner), low, high) for r, inner, low, high in slabs]
    full = np.pad(shape.occupied, [(0, 0), (0, 0), (1, 1)])
    begins, ends = (np.argwhere(full[:, :, 1:] & ~full[:, :, :-1]), np.argwhere(~full[:, :, 1:] & full[:, :, :-1]))
    (x, y, z0), (dx, dy, dz) = shape.origin, shape.step
    found = []
    for low, high in np.unique(np.column_stack([begins[:, 2], ends[:, 2]]), axis=0).tolist():
        i, j = begins[(begins[:, 2] == low) & (ends[:, 2] == high), :2].T
        together = shapely.union_all(shapely.box(x + dx * i, y + dy * j, x + dx * (i + 1), y + dy * (j + 1)))
        found += [(part, part, z0 + dz * low, z0 + dz * high) for part in shapely.get_parts(together)]
    return found


def _about(centre: tuple[float, float], radius: float, inner: float) -> tuple[shapely.Geometry, shapely.Geometry]:
    """Return the polygon about a circle, and one in a smaller circle about the same centre."""
    angle = 2 * np.pi * np.arange(ROUND) / ROUND
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    around = shapely.polygons(np.array(centre) + radius / np.cos(np.pi / ROUND) * circle)
    return around, shapely.polygons(np.array(centre) + inner * circle)


def rings_of(polygon: shapely.Geometry) -> list[Floats]:
    """Return the outlines (k, 2) of a polygon and its holes, the polygon to the left; the first place is also last."""
    return [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.reverse(shapely.normalize(polygon)))]


def bottoms_of(solids: Sequence[Solid]) -> Floats:
    """Return triangles (n, 3, 3) that fill the bottoms of solids, counterclockwise as seen from below."""
    found = [np.zeros((0, 3, 3))]
    for solid in (one for one in solids if one.ball is None):
        parts = shapely.get_parts(shapely.delaunay_triangles(convex_parts(np.array([solid.polygon]))))
        level = shapely.get_coordinates(shapely.normalize(parts)).reshape(-1, 4, 2)[:, :3]
        found.append(np.dstack([level, np.full(level.shape[:2], solid.low)]))
    return np.concatenate(found)


def blockers_of(solids: Sequence[Solid], bottoms: Floats, facets: Sequence[Facet]) -> Blockers:
    """Return the walls of solids, triangles (n, 3, 3) of their bottoms, facets, and the spheres among the solids."""
    rings, top = [], []
    balls = np.array(sorted({one.ball for one in solids if one.ball is not None})).reshape(-1, 4)
    for solid in (one for one in solids if one.ball is None):
        own = rings_of(solid.polygon)
        rings += own
        top += [solid.high] * len(own)
    count = [len(ring) - 1 for ring in rings]
    a = np.concatenate([ring[:-1] for ring in rings]) if rings else np.zeros((0, 2))
    b = np.concatenate([ring[1:] for ring in rings]) if rings else np.zeros((0, 2))
    high = np.repeat(np.array(top, dtype=np.float64), count)
    way = (b - a) / np.maximum(np.hypot(*(b - a).T), NO_LENGTH)[:, None]
    none = np.zeros(len(a))
    up = np.tile([0.0, 0.0, 1.0], (len(a), 1))
    left, right = np.column_stack([a, high]), np.column_stack([b, high])
    back = np.column_stack([-way, none])
    corners = np.concatenate([bottoms, np.array(facets, dtype=np.float64).reshape(-1, 3, 3)])
    sides = np.roll(corners, -1, axis=1) - corners
    sides /= np.linalg.norm(sides, axis=2, keepdims=True)
    across = np.cross(sides[:, 0], sides[:, 1])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    around, lost = balls[:, 3:], np.zeros((len(balls), 3, 3))
    return Blockers(
        np.concatenate([np.minimum(a, b), corners[:, :, :2].min(axis=1), balls[:, :2] - around]),
        np.concatenate([np.maximum(a, b), corners[:, :, :2].max(axis=1), balls[:, :2] + around]),
        np.concatenate([high, corners[:, :, 2].max(axis=1), balls[:, 2] + balls[:, 3]]),
        np.concatenate([np.column_stack([way[:, 1], -way[:, 0], none]), across, lost[:, 0]]),
        np.concatenate([left, corners[:, 0], balls[:, :3]]),
        np.concatenate([np.stack([right, right, left], axis=1), corners, lost]),
        np.concatenate([np.stack([up, back, -up], axis=1), sides, lost]),
        np.arange(len(a) + len(corners) + len(balls)) < len(a) + len(bottoms),
        np.concatenate([np.zeros(len(a) + len(corners)), balls[:, 3]]),
    )
