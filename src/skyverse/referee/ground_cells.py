"""The ground that is to be seen, cut into cells: whole ones on a grid, and parts of cells along outlines.

No cell reaches beyond a cell of the terrain, unless the terrain is finer: its ground lies in the hull of its corners,
but for `slack` upwards and downwards.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from skyverse._typing import Bools, Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.referee.photo_views import PhotoView
from skyverse.referee.tolerances import AREA_ROUNDING, LET_PASS

SIZES = (0.5, 2.0)
"""Metres: the least and the greatest size of cells."""
PIXELS_IN_CELL = 50.0
"""Ground sample distances in a cell, at most, between these sizes."""
MOST_CELLS = 2e7
"""Cells at most: larger areas have larger ones."""
IN_TILE = 32
"""Cells along each side of the tiles by which areas are cut."""
MOST_CORNERS = 12
"""Corners of a part of a cell; parts with more are judged with the box about them."""


class Pieces(NamedTuple):
    """Flat parts of what is to be seen, each in the hull of its corners but for its slack.

    Attributes
    ----------
    outline
        (n,) polygons seen from above.
    corners
        (n, k, 3) metres, some of them repeated.
    slack
        (n,) metres.
    area
        (n,) square metres.
    """

    outline: NDArray[np.object_]
    corners: Floats
    slack: Floats
    area: Floats

    @property
    def reach(self) -> Floats:
        """How far any ground of a piece is from its nearest corner, at most, (n,) metres."""
        found: Floats = np.linalg.norm(np.ptp(self.corners, axis=1), axis=1) + self.slack
        return found

    def of(self, some: Indices | Bools) -> "Pieces":
        """Return some of them."""
        return Pieces(self.outline[some], self.corners[some], self.slack[some], self.area[some])


NO_PIECES = Pieces(np.zeros(0, dtype=object), np.zeros((0, 4, 3)), np.zeros(0), np.zeros(0))


def joined(one: Pieces, other: Pieces) -> Pieces:
    """Return two lots of pieces as one."""
    most = max(one.corners.shape[1], other.corners.shape[1])
    corners = [
        np.pad(lot.corners, [(0, 0), (0, most - lot.corners.shape[1]), (0, 0)], mode="edge") for lot in (one, other)
    ]
    rest = ((a, b) for name, a, b in zip(one._fields, one, other, strict=True) if name != "corners")
    outline, slack, area = (np.concatenate(pair) for pair in rest)
    return Pieces(outline, np.concatenate(corners), slack, area)


@dataclass(frozen=True, eq=False)
class CellGrid:
    """The cells of the ground about an area.

    Attributes
    ----------
    x, y
        (n + 1,), (m + 1,) metres: where cells meet.
    z
        (n + 1, m + 1) metres: the ground there.
    slack
        (n, m) metres by which the ground of a cell is off the surface through its corners, at most.
    whole
        (n, m) whether all of a cell is to be seen.
    pieces
        The parts that are to be seen of other cells.
    """

    x: Floats
    y: Floats
    z: Floats
    slack: Floats
    whole: Bools
    pieces: Pieces

    @property
    def size(self) -> float:
        """The area of a cell, square metres."""
        return float((self.x[1] - self.x[0]) * (self.y[1] - self.y[0]))

    @cached_property
    def reach(self) -> Floats:
        """How far any ground of a cell is from its nearest corner, at most, (n, m) metres."""
        z = np.stack([self.z[:-1, :-1], self.z[1:, :-1], self.z[:-1, 1:], self.z[1:, 1:]])
        level = np.hypot(self.x[1] - self.x[0], self.y[1] - self.y[0]) / 2
        found: Floats = level + np.ptp(z, axis=0) + self.slack
        return found

    @cached_property
    def ends(self) -> tuple[Floats, Floats]:
        """The least and the greatest corner, (3,) metres."""
        low, high = (np.array([pick(self.x), pick(self.y), pick(self.z)]) for pick in (np.min, np.max))
        return low, high

    def nodes(self, here: tuple[slice, slice]) -> tuple[Floats, Floats, Floats]:
        """Return x (n + 1,), y (m + 1,) and z (n + 1, m + 1) of the corners of rows and columns of cells."""
        i, j = (slice(s.start, s.stop + 1) for s in here)
        return self.x[i], self.y[j], self.z[i, j]

    def within(self, view: PhotoView) -> tuple[slice, slice] | None:
        """Return the rows and columns of cells that a photo may show; ``None`` where there are none."""
        low, high = self.ends
        here = self.between(view.window(low, high))
        if here is None:
            return None
        return self.between(view.window(np.array([*low[:2], self.z[here].min()]), high)) or here

    def between(self, window: Floats) -> tuple[slice, slice] | None:
        """Return the rows and columns of cells between the least and the greatest x and y, (2, 2) metres."""
        found = []
        for line, (least, most) in zip((self.x, self.y), window.T, strict=True):
            first = max(int(np.searchsorted(line, least, side="right")) - 1, 0)
            last = min(int(np.searchsorted(line, most, side="left")), len(line) - 1)
            if first >= last:
                return None
            found.append(slice(first, last))
        return found[0], found[1]

    def cells(self, which: Bools, first: tuple[int, int] = (0, 0)) -> Pieces:
        """Return some cells as pieces; `which` begins at a row and a column."""
        i, j = (found + k for found, k in zip(np.nonzero(which), first, strict=True))
        return self.cut(shapely.box(self.x[i], self.y[j], self.x[i + 1], self.y[j + 1]))

    def cut(self, polygons: NDArray[np.object_]) -> Pieces:
        """Return polygons, each within a cell, as pieces of the ground."""
        polygons = convex_parts(polygons)
        if not len(polygons):
            return NO_PIECES
        crowded = shapely.get_num_coordinates(polygons) > MOST_CORNERS + 1
        hulls = polygons.copy()
        hulls[crowded] = shapely.envelope(polygons[crowded])
        places, of = shapely.get_coordinates(hulls, return_index=True)
        count = np.bincount(of, minlength=len(polygons))
        rank = np.arange(int(count.max()) - 1) % (count - 1)[:, None]
        corners = places[(np.cumsum(count) - count)[:, None] + rank]
        middle = (corners.min(axis=1) + corners.max(axis=1)) / 2
        i, j = (
            np.clip(np.searchsorted(line, middle[:, axis]) - 1, 0, len(line) - 2)
            for axis, line in enumerate((self.x, self.y))
        )
        u = (corners[:, :, 0] - self.x[i, None]) / (self.x[1] - self.x[0])
        v = (corners[:, :, 1] - self.y[j, None]) / (self.y[1] - self.y[0])
        h, a, b, far = (self.z[i + di, j + dj][:, None] for di, dj in ((0, 0), (1, 0), (0, 1), (1, 1)))
        twist = far - a - b + h
        z = h + (a - h) * u + (b - h) * v + twist * u * v
        # of places in a polygon, u v is off what the corners make of it by their covariance, at most
        bulge = np.abs(twist[:, 0]) * np.ptp(u, axis=1) * np.ptp(v, axis=1) / 4
        return Pieces(polygons, np.dstack([corners, z]), self.slack[i, j] + bulge, shapely.area(polygons))

    def halved(self, pieces: Pieces) -> Pieces:
        """Return pieces cut in four, along their middles."""
        low, high = np.split(shapely.bounds(pieces.outline), 2, axis=1)
        return self.cut(quarters(pieces.outline, (low + high) / 2))

    def parted(self, pieces: Pieces, places: Floats, normals: Floats) -> Pieces:
        """Return pieces, those at places (n, 2) cut along lines through these, with unit normals (n, 2)."""
        which, at = shapely.STRtree(pieces.outline).query(shapely.points(places), "dwithin", distance=LET_PASS)
        at, first = np.unique(at, return_index=True)
        place, normal = places[which[first]][:, None], normals[which[first]][:, None]
        far = 2 * float(np.ptp(pieces.corners[at], axis=1).max(initial=0.0))
        lines = shapely.linestrings(place + far * np.array([[-1.0], [1.0]]) * normal[:, :, ::-1] * [-1.0, 1.0])
        half, whole = shapely.buffer(lines, far, cap_style="flat", single_sided=True), pieces.outline[at]
        cut = _polygons(np.concatenate([shapely.intersection(whole, half), shapely.difference(whole, half)]))
        return joined(pieces.of(np.delete(np.arange(len(pieces.area)), at)), self.cut(cut))


def quarters(polygons: NDArray[np.object_], at: Floats) -> NDArray[np.object_]:
    """Return polygons cut in four, each at a place (n, 2), along x and along y."""
    low, high = np.split(shapely.bounds(polygons), 2, axis=1)
    ends = (low, high, np.column_stack([low[:, 0], high[:, 1]]), np.column_stack([high[:, 0], low[:, 1]]))
    boxes = [shapely.box(*np.minimum(at, end).T, *np.maximum(at, end).T) for end in ends]
    return _polygons(np.concatenate([shapely.intersection(polygons, box) for box in boxes]))


def _polygons(shapes: NDArray[np.object_]) -> NDArray[np.object_]:
    """Return the polygons among shapes and their parts, without what has no area."""
    parts = shapely.get_parts(shapely.get_parts(shapes))
    return parts[(shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & (shapely.area(parts) > 0)]


def convex_parts(polygons: NDArray[np.object_]) -> NDArray[np.object_]:
    """Return polygons cut at their inward corners, until they are convex but for rounding."""
    for _ in range(MOST_CORNERS):
        bent = np.flatnonzero(
            shapely.area(shapely.convex_hull(polygons)) > shapely.area(polygons) * (1 + AREA_ROUNDING) + AREA_ROUNDING
        )
        if not len(bent):
            break
        inward = shapely.difference(
            shapely.extract_unique_points(polygons[bent]), shapely.boundary(shapely.convex_hull(polygons[bent]))
        )
        inward = np.where(shapely.is_empty(inward), shapely.centroid(polygons[bent]), inward)
        at = np.array([shapely.get_coordinates(points)[0] for points in inward])
        polygons = np.concatenate([np.delete(polygons, bent), quarters(polygons[bent], at)])
    return polygons


def grid_of(scenario: Scenario, survey: Survey, asked: shapely.Geometry) -> CellGrid:
    """Return the cells of the ground about what is to be seen of it."""
    low, high = (np.array(corner) for corner in np.split(np.array(shapely.bounds(asked)), 2))
    pixel = survey.camera.gsd(survey.distance)
    size = max(min(max(PIXELS_IN_CELL * pixel, SIZES[0]), SIZES[1]), float(np.sqrt(np.prod(high - low) / MOST_CELLS)))
    terrain = scenario.terrain
    if terrain is None:
        counts = np.maximum(np.ceil((high - low) / size), 1).astype(int)
        x, y = (np.linspace(a, b, n + 1) for a, b, n in zip(low, high, counts, strict=True))
        z, slack = np.full((len(x), len(y)), scenario.bounds.min[2]), np.zeros((len(x) - 1, len(y) - 1))
    else:
        origin, step, last = np.array(terrain.origin), np.array(terrain.step), np.array(terrain.heights.shape) - 1
        block = np.maximum(np.floor(size / step), 1).astype(int)
        first = np.clip(np.floor((low - origin) / step), 0, last - 1).astype(int)
        count = np.ceil(np.clip((high - origin) / step - first, 1, last - first) / block).astype(int)
        h = np.pad(terrain.heights, [(0, b) for b in block], mode="edge")
        h = h[tuple(slice(a, a + n * b + 1) for a, n, b in zip(first, count, block, strict=True))]
        parts = np.maximum(np.ceil(step / size), 1).astype(int)
        z, slack = h[:: block[0], :: block[1]], _off(h, block)
        for axis in (0, 1):
            z, slack = _between(z, parts[axis], axis), np.repeat(slack, parts[axis], axis=axis)
        wide = step * block / parts
        x, y = (origin[k] + step[k] * first[k] + wide[k] * np.arange(z.shape[k]) for k in (0, 1))
    whole, outlines = cut_by_grid(asked, x, y)
    grid = CellGrid(x, y, z, slack, whole, NO_PIECES)
    return replace(grid, pieces=grid.cut(outlines))


def _off(h: Floats, block: Indices) -> Floats:
    """Return by how much heights are off the surfaces through the corners of blocks of cells, at most, metres."""
    found = np.zeros(tuple((np.array(h.shape) - 1) // block))
    z = h[:: block[0], :: block[1]]
    for a in range(block[0] + 1):
        for b in range(block[1] + 1):
            u, v = a / block[0], b / block[1]
            low, high = z[:-1, :-1] * (1 - u) + z[1:, :-1] * u, z[:-1, 1:] * (1 - u) + z[1:, 1:] * u
            here = h[a : a + (len(z) - 1) * block[0] : block[0], b : b + (z.shape[1] - 1) * block[1] : block[1]]
            np.maximum(found, np.abs(here - (low * (1 - v) + high * v)), out=found)
    return found


def _between(z: Floats, parts: int, axis: int) -> Floats:
    """Return heights with others between them along an axis, so that every step has as many parts."""
    z = np.moveaxis(z, axis, 0)
    share = (np.arange(parts) / parts)[None, :, None]
    inner = z[:-1, None] * (1 - share) + z[1:, None] * share
    return np.moveaxis(np.concatenate([inner.reshape(-1, z.shape[1]), z[-1:]]), 0, axis)


def cut_by_grid(asked: shapely.Geometry, x: Floats, y: Floats) -> tuple[Bools, NDArray[np.object_]]:
    """Return which cells between lines of a grid lie wholly in what is asked, (n, m), and its parts in other cells."""
    whole, parts = np.zeros((len(x) - 1, len(y) - 1), dtype=np.bool_), []
    for i in range(0, len(x) - 1, IN_TILE):
        band = shapely.intersection(asked, shapely.box(x[i], y[0], x[min(i + IN_TILE, len(x) - 1)], y[-1]))
        for j in range(0, len(y) - 1, IN_TILE):
            here = slice(i, min(i + IN_TILE, len(x) - 1)), slice(j, min(j + IN_TILE, len(y) - 1))
            corners = x[i], y[j], x[here[0].stop], y[here[1].stop]
            tile = shapely.box(*corners)
            within = shapely.intersection(band, tile)
            if not shapely.area(within):
                continue
            if shapely.area(within) >= shapely.area(tile) * (1 - AREA_ROUNDING):
                whole[here] = True
                continue
            k, m = (grid.ravel() for grid in np.meshgrid(*(np.arange(s.start, s.stop) for s in here), indexing="ij"))
            boxes = shapely.box(x[k], y[m], x[k + 1], y[m + 1])
            shapely.prepare(within)
            inside = shapely.covers(within, boxes)
            whole[k[inside], m[inside]] = True
            met = np.flatnonzero(~inside & shapely.intersects(within, boxes))
            parts.append(_polygons(shapely.intersection(within, boxes[met])))
    return whole, np.concatenate(parts) if parts else np.zeros(0, dtype=object)
