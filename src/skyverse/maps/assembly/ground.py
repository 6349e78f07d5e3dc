"""The ground of a scenario: z of altitudes, level ground, and the ground below outlines."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import Remedy
from skyverse.maps.assembly.node_neighbourhood import greatest_around_nodes
from skyverse.maps.georeference.rectangle import Rectangle
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Origin
from skyverse.model.shapes import Terrain

GIVE_GROUND = (Remedy("terrain"), Remedy("ground"))
"""What helps where something is counted from the ground, which is not known."""
LEVEL_STEP = 200.0
"""Metres between the heights of level ground."""
LEAST_EARTH_RADIUS = 6.33e6
"""The least radius of curvature of the Earth, metres."""
LOW_AIRSPACE = 152.4
"""Metres, 500 feet: heights above ground up to this count along plumb lines, too, in every terrain of a map."""
FEW_CELLS = 400
"""Cells under an outline up to which they are intersected one by one; for more, drawing the outline is faster."""


def z_at_altitude(origin: Origin, x: Floats, y: Floats, altitude: Floats) -> Floats:
    """Return z (n,) in the local frame of altitudes above mean sea level, metres, at x, y."""
    z = altitude - origin.altitude
    for _ in range(4):  # each step gains three digits or more
        z = z + altitude - to_wgs84(origin, np.column_stack([x, y, z]))[:, 2]
    return z


def level_ground(
    origin: Origin, region: Rectangle, altitude: float, clearance: float | None = None, max_height: float = 0.0
) -> Terrain:
    """Return ground that is at an altitude above mean sea level, metres, or a little above it, over a region.

    Its `lowest` heights are nowhere above that altitude, also along plumb lines up to `max_height`, metres, and at
    least `LOW_AIRSPACE`.
    """
    x0, y0, x1, y1 = region
    nx, ny = (max(1, int(np.ceil((high - low) / LEVEL_STEP))) + 1 for low, high in ((x0, x1), (y0, y1)))
    x, y = np.linspace(x0, x1, nx), np.linspace(y0, y1, ny)
    each, other = (at.ravel() for at in np.meshgrid(x, y, indexing="ij"))
    sag = (LEVEL_STEP**2 / 4) / (2 * LEAST_EARTH_RADIUS)  # between heights the level bulges above the straight line
    z = z_at_altitude(origin, each, other, np.full(len(each), altitude)) + sag
    lowest = below_plumb_lines((z - sag).reshape(nx, ny), x, y, max(LOW_AIRSPACE, max_height))
    return Terrain(
        origin=(x0, y0),
        step=(float(x[1] - x[0]), float(y[1] - y[0])),
        heights=z.reshape(nx, ny),
        clearance=clearance,
        lowest=lowest,
    )


def below_plumb_lines(heights: Floats, x: Floats, y: Floats, height: float) -> Floats:
    """Lower a surface until what is so high above it along z is no higher above the surface given along a plumb line.

    At a distance r from the frame's zero, plumb lines lean from the frame's z by r / R, where R is the Earth's radius.
    Over a height h they lead r h / R to the side, where the ground may be lower, and h (1 - cos(r / R)) less far up.

    Parameters
    ----------
    heights
        (nx, ny) z of the surface, metres.
    x, y
        (nx,) and (ny,) where the heights stand, metres.
    height
        The height h, metres.
    """
    steps = float(x[1] - x[0]), float(y[1] - y[0])
    lean = np.hypot(np.abs(x)[:, None] + steps[0], np.abs(y)[None] + steps[1]) / LEAST_EARTH_RADIUS
    east, north = (np.abs(np.diff(heights, axis=axis)) / steps[axis] for axis in (0, 1))
    slope = np.hypot(np.maximum(east[:, 1:], east[:, :-1]), np.maximum(north[1:], north[:-1]))
    aside = height * float(lean.max())
    steepest = greatest_around_nodes(slope, [math.ceil(aside / step) for step in steps])
    return heights - height * lean * (steepest + lean / 2)


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
