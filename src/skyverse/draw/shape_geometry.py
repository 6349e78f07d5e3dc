"""The geometry of shapes for pictures: surfaces, faces, edges, footprints, vertical spans, and movers grown."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.draw.triangulation import joined, triangles, turned
from skyverse.model.mover import Ellipsoid, Mover
from skyverse.model.quantities import derived
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import FENCE, AnyShape, Box, Cylinder, Prism, Sphere, Voxels

DrawnShape = Box | Cylinder | Sphere | Prism | Voxels | Ellipsoid

CIRCLE_SIDES = 48
"""The number of sides of the polygon that stands for a circle."""

_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_TRIANGLES = "013 032 467 475 045 051 237 276 026 064 157 173"  # two for each side, as numbers of corners
_FACES = np.array([[int(corner) for corner in triangle] for triangle in _TRIANGLES.split()])
_SIDES = np.array(((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)))
_STROKE = [int(corner) for corner in "0462015457673231"]  # one line along all twelve edges, three of them twice


def footprint(shape: DrawnShape, sides: int = CIRCLE_SIDES) -> list[Floats]:
    """Return a shape seen from above as rings, (n, 2) each: outlines counter-clockwise, holes clockwise."""
    if isinstance(shape, Prism):
        return [turned(np.array(shape.vertices), 1), *(turned(np.array(hole), -1) for hole in shape.holes)]
    if isinstance(shape, Voxels):
        low, step = np.array(shape.origin[:2]), np.array(shape.step[:2])
        return [low + step * corners for corners in _rectangles(np.asarray(shape.occupied.any(axis=2)))]
    if isinstance(shape, Box):
        (x, y, _), (far_x, far_y, _) = shape.min, shape.max
        return [np.array([(x, y), (far_x, y), (far_x, far_y), (x, far_y)])]
    turn = 2 * np.pi * np.arange(sides) / sides
    reach = shape.semi_axis_xy if isinstance(shape, Ellipsoid) else shape.radius
    return [np.array(shape.centre[:2]) + reach * np.column_stack([np.cos(turn), np.sin(turn)])]


def below(shape: DrawnShape, top: float) -> DrawnShape:
    """Return a shape without what is above z = `top`; spheres, voxels and what lies wholly above stay whole."""
    if isinstance(shape, Box) and shape.min[2] < top < shape.max[2]:
        return derived(shape, max=(*shape.max[:2], top))
    if isinstance(shape, Cylinder | Prism) and shape.low < top < shape.high:
        return derived(shape, high=top)
    return shape


WALL = 0.15
"""The height at which the wall is drawn that stands for a fence, as a share of the picture's."""


def drawn_fence(shape: AnyShape, low: Floats, high: Floats, ground: float) -> AnyShape:
    """Return what is drawn of a fence: a low wall from the bottom of a picture, whose corners (3,) are given.

    What crosses the picture's sides ends there; of such a prism nobody asks whether its outlines are sound. Other
    shapes stay as they are.
    """
    if not isinstance(shape, Prism) or not is_fence(shape):
        return shape
    rings = [np.clip(np.array(ring), low[:2], high[:2]).tolist() for ring in (shape.vertices, *shape.holes)]
    top = min(float(high[2]), ground + WALL * float(high[2] - low[2]))
    return derived(shape, vertices=tuple(rings[0]), holes=tuple(rings[1:]), low=float(low[2]), high=top)


def is_fence(shape: DrawnShape) -> bool:
    """Tell whether a shape is a fence, of which only the walls are drawn."""
    return isinstance(shape, Prism) and shape.kind == FENCE and not shape.solid


def surface(shape: DrawnShape, sides: int = CIRCLE_SIDES) -> tuple[Floats, Ints]:
    """Return the points, (n, 3), of a shape's closed surface and its triangles, (m, 3), as indices of points."""
    if isinstance(shape, Box):
        return _corners(shape), _FACES
    if isinstance(shape, Sphere | Ellipsoid):
        return _ball(shape, sides)
    if isinstance(shape, Voxels):
        quads = skin(shape)
        first = 4 * np.arange(len(quads))[:, None]
        return quads.reshape(-1, 3), np.vstack([first + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])
    rings = footprint(shape, sides)
    n = sum(map(len, rings))
    i, j = _around(rings)
    walls = np.vstack([np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])])
    if is_fence(shape):
        return _levels(rings, shape), walls
    floor = triangles(rings)
    return _levels(rings, shape), np.vstack([floor[:, ::-1], floor + n, walls])


def brightness(normals: Floats) -> Floats:
    """Return the brightness, (m,) from 0 to 1, of faces with normals (m, 3): most of roofs, then of walls along y."""
    x, _, z = np.abs(normals).T / np.maximum(np.linalg.norm(normals, axis=1), np.finfo(np.float64).tiny)
    return 0.66 + 0.12 * x + 0.34 * z


def faces(shape: DrawnShape, sides: int = CIRCLE_SIDES) -> list[Floats]:
    """Return the polygons, (n, 3) each, of a shape's surface; a roof with holes is one polygon with seams."""
    if isinstance(shape, Box):
        return list(_corners(shape)[_SIDES])
    if isinstance(shape, Cylinder | Prism):
        rings = footprint(shape, sides)
        points, n = _levels(rings, shape), sum(map(len, rings))
        i, j = _around(rings)
        walls = list(points[np.column_stack([i, j, j + n, i + n])])
        if is_fence(shape):
            return walls
        roof = joined(rings) + n
        return [*walls, points[roof - n], points[roof]]
    if isinstance(shape, Voxels):
        return list(skin(shape))
    points, triangle = _ball(shape, sides)
    return list(points[triangle])


def outline(shape: DrawnShape, sides: int = CIRCLE_SIDES) -> Floats:
    """Return a shape's edges as one line, (n, 3), with gaps of nan; voxels have no edges."""
    if isinstance(shape, Box):
        return np.vstack([_corners(shape)[_STROKE], _GAP])
    if isinstance(shape, Voxels):
        return np.empty((0, 3))
    if isinstance(shape, Sphere | Ellipsoid):
        turn = 2 * np.pi * np.arange(sides + 1) / sides
        flat = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
        circles = (_semi_axes(shape) * circle + shape.centre for circle in (flat, flat[:, [0, 2, 1]]))
        return np.vstack([stroke for circle in circles for stroke in (circle, _GAP)])
    rings = footprint(shape, sides)
    points, n = _levels(rings, shape), sum(map(len, rings))
    strokes, first = [], 0
    for ring in rings:
        loop = first + np.append(np.arange(len(ring)), 0)
        strokes += [points[loop], _GAP, points[loop + n], _GAP]
        first += len(ring)
    if isinstance(shape, Prism):
        posts = np.stack([points[:n], points[n:], np.full((n, 3), np.nan)], axis=1)
        strokes.append(posts.reshape(-1, 3))
    return np.vstack(strokes)


def span(shape: DrawnShape, places: Floats) -> Floats:
    """Return the lowest and highest z of a shape, (n, 2), over places, (n, 2); nan where the shape is not.

    A column of voxels extends from its lowest to its highest occupied one.
    """
    levels = np.full((len(places), 2), np.nan)
    low, high = extent(shape)
    near = np.flatnonzero(np.all((places >= low[:2]) & (places <= high[:2]), axis=1))
    at = places[near]
    if isinstance(shape, Box):
        levels[near] = low[2], high[2]
    elif isinstance(shape, Prism):
        levels[near[_covered(footprint(shape), at)]] = low[2], high[2]
    elif isinstance(shape, Voxels):
        cell = np.minimum(((at - low[:2]) / shape.step[:2]).astype(int), np.array(shape.occupied.shape[:2]) - 1)
        columns = shape.occupied[cell[:, 0], cell[:, 1]]
        some = columns.any(axis=1)
        first, last = columns.argmax(axis=1), columns.shape[1] - columns[:, ::-1].argmax(axis=1)
        levels[near[some]] = low[2] + shape.step[2] * np.column_stack([first, last])[some]
    else:
        squared = np.sum((at - np.array(shape.centre[:2])) ** 2, axis=1)
        reach, up = (shape.radius, 0.0) if isinstance(shape, Cylinder) else _semi_axes(shape)[1:]
        inside = squared <= reach**2
        levels[near[inside]] = low[2], high[2]
        if not isinstance(shape, Cylinder):
            half = up / reach * np.sqrt(reach**2 - squared[inside])
            levels[near[inside]] = shape.centre[2] + np.column_stack([-half, half])
    return levels


def coarser(voxels: Voxels, most: int) -> Voxels:
    """Return voxels of at most `most` triangles; where needed, eight become one, occupied if any of them is."""
    while 2 * len(skin(voxels)) > most and max(voxels.occupied.shape) > 1:
        cells = np.pad(voxels.occupied, [(0, n % 2) for n in voxels.occupied.shape])
        nx, ny, nz = (n // 2 for n in cells.shape)
        eight = cells.reshape(nx, 2, ny, 2, nz, 2).any(axis=(1, 3, 5))
        step = tuple(2 * side for side in voxels.step)
        voxels = derived(voxels, step=step, occupied=eight)
    return voxels


def grown(mover: Mover, more: float) -> Box | Cylinder | Sphere | Ellipsoid:
    """Return a mover's shape, grown by some metres as by its doubt; an ellipsoid keeps its proportions."""
    shape = mover.shape
    match shape:
        case Box():
            low, high = np.array(shape.min) - more, np.array(shape.max) + more
            return Box(min=tuple(low.tolist()), max=tuple(high.tolist()))
        case Cylinder():
            update = {"radius": shape.radius + more, "low": shape.low - more, "high": shape.high + more}
            return derived(shape, **update)
        case Sphere():
            return derived(shape, radius=shape.radius + more)
        case Ellipsoid():
            larger = 1.0 + more / min(shape.semi_axis_xy, shape.semi_axis_z)
            axes = {name: larger * getattr(shape, name) for name in ("semi_axis_xy", "semi_axis_z")}
            return derived(shape, **axes)
    raise TypeError(f"a mover cannot be a {type(shape).__name__}")


_GAP = np.full((1, 3), np.nan)


def _corners(box: Box) -> Floats:
    return np.where(_CORNERS == 0, box.min, box.max).astype(np.float64)


def _levels(rings: Sequence[Floats], shape: Cylinder | Prism) -> Floats:
    corners = np.concatenate(rings)
    return np.vstack([np.column_stack([corners, np.full(len(corners), z)]) for z in (shape.low, shape.high)])


def _around(rings: Sequence[Floats]) -> tuple[Ints, Ints]:
    """Return the indices of the corners at which edges begin, and of those at which they end."""
    firsts = np.cumsum([0, *map(len, rings[:-1])])
    begin = [first + np.arange(len(ring)) for ring, first in zip(rings, firsts, strict=True)]
    return np.concatenate(begin), np.concatenate([np.append(row[1:], row[0]) for row in begin])


def _covered(rings: Sequence[Floats], places: Floats) -> NDArray[np.bool_]:
    """Return which places, (n, 2), lie inside: a ray from them along x crosses the rings an odd number of times."""
    odd = np.zeros(len(places), dtype=bool)
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            crosses = (a[1] > places[:, 1]) != (b[1] > places[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                odd ^= crosses & (a[0] + (places[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > places[:, 0])
    return odd


def _semi_axes(ball: Sphere | Ellipsoid) -> Floats:
    if isinstance(ball, Sphere):
        return np.full(3, ball.radius)
    return np.array([ball.semi_axis_xy, ball.semi_axis_xy, ball.semi_axis_z])


def _ball(ball: Sphere | Ellipsoid, sides: int) -> tuple[Floats, Ints]:
    belts = sides // 2
    turn, tilt = np.meshgrid(2 * np.pi * np.arange(sides) / sides, np.pi * (np.arange(1, belts) / belts - 0.5))
    unit = np.stack([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)], axis=-1).reshape(-1, 3)
    points = np.vstack([unit, [[0, 0, -1], [0, 0, 1]]]) * _semi_axes(ball) + np.array(ball.centre)
    i = np.arange(sides)
    j = np.roll(i, -1)
    cut = [(np.column_stack([j, i, np.full(sides, len(unit))]))]
    for belt in range(belts - 2):
        a, b, c, d = (k + belt * sides + up for k, up in ((i, 0), (j, 0), (j, sides), (i, sides)))
        cut += [np.column_stack([a, b, c]), np.column_stack([a, c, d])]
    last = (belts - 2) * sides
    cut.append(np.column_stack([i + last, j + last, np.full(sides, len(unit) + 1)]))
    return points, np.vstack(cut)


def skin(voxels: Voxels) -> Floats:
    """Return the faces between occupied and free cells as rectangles, (n, 4, 3), one for each row of such faces."""
    quads = []
    filled = np.pad(voxels.occupied, 1)
    inner = (slice(1, -1),) * 3
    for axis in range(3):
        across, along = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            bare = (filled & ~np.roll(filled, 1 - 2 * side, axis=axis))[inner]
            begin, end = _runs(np.moveaxis(bare, (axis, across, along), (0, 1, 2)))
            corners = np.empty((len(begin), 4, 3))
            corners[:, :, axis] = begin[:, :1] + side
            corners[:, :, across] = begin[:, 1:2] + [0, 1, 1, 0]
            corners[:, :, along] = np.stack([begin[:, 2], begin[:, 2], end, end], axis=1)
            quads.append(corners if side else corners[:, ::-1])
    return np.array(voxels.origin) + np.array(voxels.step) * np.concatenate(quads)


def _runs(cells: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """Return where each run of true cells along the last axis begins, as indices, and where it ends on that axis."""
    padded = np.concatenate([np.zeros((*cells.shape[:-1], 1), bool), cells, np.zeros((*cells.shape[:-1], 1), bool)], -1)
    begin = np.argwhere(padded[..., 1:] & ~padded[..., :-1])
    end = np.argwhere(padded[..., :-1] & ~padded[..., 1:])
    return begin, end[:, -1]


def _rectangles(cells: NDArray[np.bool_]) -> list[Floats]:
    begin, end = _runs(cells)
    return [np.array([(i, j), (i + 1, j), (i + 1, k), (i, k)], float) for (i, j), k in zip(begin, end, strict=True)]
