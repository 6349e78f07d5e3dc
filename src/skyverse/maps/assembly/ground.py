"""The ground of a scenario: level ground, and the ground below outlines."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import Remedy
from skyverse.maps.georeference.rectangle import Rectangle
from skyverse.model.frame import Origin
from skyverse.model.shapes import Terrain

GIVE_GROUND = (Remedy("terrain"), Remedy("ground"))
"""What helps where something is counted from the ground, which is not known."""
FEW_CELLS = 400
"""Cells under an outline up to which they are intersected one by one; for more, drawing the outline is faster."""


def level_ground(origin: Origin, region: Rectangle, altitude: float, clearance: float | None = None) -> Terrain:
    """Return ground that is at an altitude above mean sea level, metres, over a region."""
    x0, y0, x1, y1 = region
    z = np.full((2, 2), altitude - origin.altitude)
    return Terrain(origin=(x0, y0), step=(x1 - x0, y1 - y0), heights=z, clearance=clearance)


def ground_range(terrain: Terrain, outlines: NDArray[Any]) -> tuple[Floats, Floats]:
    """Return bounds of the lowest and the highest ground (n,) below polygons of shapely, exact to a cell's slope.

    Of a polygon that leaves the terrain, what lies over the terrain counts; if nothing does, the nearest edge.
    """
    import shapely

    (x0, y0), (dx, dy), h = terrain.origin, terrain.step, terrain.heights
    corners = h[:-1, :-1], h[1:, :-1], h[:-1, 1:], h[1:, 1:]  # a bilinear cell lies between its corners' heights
    least, most = np.minimum.reduce(corners), np.maximum.reduce(corners)
    boxes = (shapely.bounds(outlines).reshape(-1, 4) - [x0, y0, x0, y0]) / [dx, dy, dx, dy]
    i, j, m, n = np.clip(np.floor(boxes), 0, np.array(least.shape * 2) - 1).astype(np.int64).T
    wide, deep = m - i + 1, n - j + 1
    low, high = np.empty(len(outlines)), np.empty(len(outlines))
    few = wide * deep <= FEW_CELLS
    for k in np.flatnonzero(~few):
        touched = _touched_cells(outlines[k], terrain, (int(i[k]), int(j[k])), (int(wide[k]), int(deep[k])))
        part = slice(i[k], m[k] + 1), slice(j[k], n[k] + 1)
        low[k], high[k] = least[part][touched].min(), most[part][touched].max()
    some = np.flatnonzero(few)
    for rows in np.array_split(some, 1 + len(some) // 5000):
        if not len(rows):
            continue
        sizes = wide[rows] * deep[rows]
        owner = np.repeat(rows, sizes)
        ends = np.cumsum(sizes)
        number = np.arange(ends[-1]) - np.repeat(ends - sizes, sizes)
        a, b = i[owner] + number // deep[owner], j[owner] + number % deep[owner]
        cells = shapely.box(x0 + a * dx, y0 + b * dy, x0 + (a + 1) * dx, y0 + (b + 1) * dy)
        under = shapely.intersects(outlines[owner], cells)
        under |= ~np.logical_or.reduceat(under, ends - sizes).repeat(sizes)
        low[rows] = np.minimum.reduceat(np.where(under, least[a, b], np.inf), ends - sizes)
        high[rows] = np.maximum.reduceat(np.where(under, most[a, b], -np.inf), ends - sizes)
    return low, high


def _touched_cells(outline: Any, terrain: Terrain, first: tuple[int, int], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Return which cells of a part of the terrain a polygon touches; all of them if it touches none."""
    from rasterio.features import rasterize
    from rasterio.transform import Affine

    (x0, y0), (dx, dy) = terrain.origin, terrain.step
    to_place = Affine(0, dx, x0 + first[0] * dx, dy, 0, y0 + first[1] * dy)  # the rows of the drawing go along x
    touched = rasterize([outline], shape, transform=to_place, all_touched=True, dtype="uint8").astype(bool)
    return touched if touched.any() else np.ones(shape, dtype=bool)
