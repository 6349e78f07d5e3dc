"""The ground of a scenario: rasters become heights on a grid of the local frame, nowhere below those of the rasters.

A second grid of heights is nowhere above those of the rasters: ceilings above ground are counted from it. Where there
is no raster, the ground is level.
"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.maps.assembly.surface_excess import greatest_around_nodes, surface_excess
from skyverse.maps.georeference.feature import Rectangle
from skyverse.maps.georeference.reading import Raster
from skyverse.maps.readers.raster import open_raster
from skyverse.maps.readers.raster_tiles import Tile, pixel_size, tiles
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_wgs84
from skyverse.model.shapes import Terrain

MAX_HEIGHTS = 5_000_000
"""Heights of a terrain at most."""
STRIP_PIXELS = 500_000
"""Pixels that are handled together."""
ROUNDING_LIFT = 1e-6
"""Metres that the ground is raised above a pixel's height, so that rounding does not leave it below."""
TOLD_LIFT = 1e-3
"""Metres: nodes that are raised by less do not count as raised in what is told."""
_EDGE_PIXELS = 1e-3
"""Pixels that a place may lie outside of a raster and still be on its edge."""


@dataclass(frozen=True)
class TerrainChanges:
    """How a terrain differs from a plain interpolation of its rasters.

    Attributes
    ----------
    most, mean
        The most and the mean that nodes were raised by, metres, so that no height of a raster stands out.
    share
        The share of nodes that were raised.
    filled
        The share of nodes that had no data and were filled.
    step
        How far apart nodes are, metres.
    most_lowered, mean_lowered
        The most and the mean, over all nodes, by which the surface that ceilings are counted from is below the ground,
        metres.
    """

    most: float
    mean: float
    share: float
    filled: float
    step: float
    most_lowered: float
    mean_lowered: float


def read_terrain(
    rasters: Sequence[Raster],
    origin: Origin,
    region: Rectangle,
    *,
    step: float | None = None,
    fill: float | Literal["nearest"] | None = None,
    clearance: float | None = None,
) -> tuple[Terrain, TerrainChanges]:
    """Read the ground over a region of the local frame.

    The surface of a raster is bilinear between the centres of its pixels, and level in the half pixels at its edge. The
    bilinear surface of the result's `heights` is nowhere in the region below that of a raster, and that of its `lowest`
    heights is nowhere above. Where rasters overlap, the higher one counts for the former and the lower one for the
    latter.

    Parameters
    ----------
    rasters
        The files.
    origin
        The local frame's origin.
    region
        The least x and y, the greatest x and y, metres.
    step
        How far apart heights are at most, metres; when left out, as far as in the finest raster, or farther for at
        most four million nodes.
    fill
        What stands for the ground where there is no data: metres above mean sea level, or the nearest height. Holes
        are refused when left out.
    clearance
        The terrain's own clearance, metres.

    Raises
    ------
    InputError
        If a file cannot be used, or does not cover the region, or has holes.
    """
    level = origin.model_copy(update={"altitude": 0.0})
    x0, y0, x1, y1 = region
    with ExitStack() as stack:
        files = [stack.enter_context(open_raster(raster)) for raster in rasters]
        if step is None:
            finest = min(pixel_size(file, level) for file in files)
            step = max(finest, np.sqrt((x1 - x0) * (y1 - y0) / (0.8 * MAX_HEIGHTS)))
        nx, ny = (max(1, int(np.ceil((high - low) / step - 1e-9))) + 1 for low, high in ((x0, x1), (y0, y1)))
        if nx * ny > MAX_HEIGHTS:
            raise InputError(
                f"the terrain's step of {step:g} m makes {nx * ny:,} heights, above the {MAX_HEIGHTS:,} that are kept; "
                "take a longer step or a smaller area"
            )
        x, y = np.linspace(x0, x1, nx), np.linspace(y0, y1, ny)
        found = [tile for file in files for tile in tiles(file, level, region, step)]
    grid = _TerrainGrid(x, y)
    names = ", ".join(file.path for file in files)
    covered = np.zeros((nx, ny), dtype=bool)
    for tile in found:
        covered |= grid.covered(tile)
    if not covered.all():
        raise InputError(
            f"{names}: expected terrain over all of the area, but {1 - covered.mean():.1%} of it lies outside, "
            f"such as {grid.place(level, ~covered)}"
        )
    heights, lowest = np.full((2, nx, ny), np.nan)
    for tile in found:
        z = grid.sample(tile, tile.heights)
        heights = np.fmax(heights, z)
        lowest = np.fmin(lowest, z if tile.lowest is tile.heights else grid.sample(tile, tile.lowest))
    holes = np.isnan(heights)
    if holes.any():
        heights = _filled(names, level, grid, heights, fill)
        lowest = np.fmin(lowest, heights)
    lift = np.zeros_like(heights)
    for tile in found:
        grid.raise_to(tile, heights, lift)
    below, above = grid.excess(found, heights + lift, lowest)
    lift, lowest = lift + below, lowest - above
    terrain = Terrain(
        origin=(x0, y0),
        step=(float(x[1] - x[0]), float(y[1] - y[0])),
        heights=heights + lift - origin.altitude,
        clearance=clearance,
        lowest=lowest - origin.altitude,
    )
    assert terrain.lowest is not None
    lowered = terrain.heights - terrain.lowest
    raised = lift > TOLD_LIFT
    return terrain, TerrainChanges(
        most=float(lift.max()),
        mean=float(lift.mean()),
        share=float(raised.mean()),
        filled=float(holes.mean()),
        step=float(max(terrain.step)),
        most_lowered=float(lowered.max()),
        mean_lowered=float(lowered.mean()),
    )


class _TerrainGrid:
    """The nodes of a terrain; z is counted from an origin at altitude 0."""

    def __init__(self, x: Floats, y: Floats) -> None:
        self.x, self.y = x, y
        self.steps = float(x[1] - x[0]), float(y[1] - y[0])

    def place(self, origin: Origin, these: NDArray[np.bool_]) -> str:
        """Return the place of the first of some nodes (nx, ny) in words."""
        i, j = np.argwhere(these)[0]
        latitude, longitude, _ = to_wgs84(origin, [self.x[i], self.y[j], 0.0])[0]
        return f"latitude {latitude:.6f}, longitude {longitude:.6f}"

    def excess(self, found: Sequence[Tile], heights: Floats, lowest: Floats) -> tuple[Floats, Floats]:
        """Return how far nodes (nx, ny) have to rise, and lowest ones to sink, to be beyond all tiles, metres."""
        cells = np.zeros((2, len(self.x) - 1, len(self.y) - 1))
        for tile in found:
            beyond = surface_excess(tile, (self.x, self.y), heights, lowest)
            cells = np.maximum(cells, np.where(beyond > 0, beyond + ROUNDING_LIFT, 0.0))
        return greatest_around_nodes(cells[0]), greatest_around_nodes(cells[1])

    def covered(self, tile: Tile) -> NDArray[np.bool_]:
        """Return which nodes a tile covers, (nx, ny)."""
        return _inside(tile, *_blocks(tile, *tile.pixel.grid(self.x, self.y)))

    def sample(self, tile: Tile, values: Floats) -> Floats:
        """Return z (nx, ny) at the nodes, interpolated between pixels' centres; ``nan`` where the tile has no data.

        `values` are the heights of the tile's pixels, or the lowest ones of its blocks.
        """
        shape = len(self.x), len(self.y)
        heights = np.empty(shape)
        many = max(1, STRIP_PIXELS // shape[1])
        for first in range(0, shape[0], many):
            part = slice(first, first + many)
            heights[part] = _between(tile, values, *tile.pixel.grid(self.x[part], self.y))
        for strip in self._pixels(tile) if np.isnan(tile.heights).any() else ():
            i, j = strip.cells
            for k, m in ((0, 0), (1, 0), (0, 1), (1, 1)):  # the nodes around a pixel without data
                heights[i[strip.holes] + k, j[strip.holes] + m] = np.nan
        return heights

    def raise_to(self, tile: Tile, heights: Floats, lift: Floats) -> None:
        """Increase `lift` until no pixel stands above the bilinear surface of `heights + lift`."""
        for strip in self._pixels(tile):
            for x, y in strip.corners():
                i = np.clip(x.astype(np.int64), 0, len(self.x) - 2)
                j = np.clip(y.astype(np.int64), 0, len(self.y) - 2)
                u, v = x - i, y - j
                shares = (1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v
                nodes = (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)
                level = sum(share * heights[node] for share, node in zip(shares, nodes, strict=True))
                short = strip.z + ROUNDING_LIFT - level
                low = (short > 0) & ~strip.holes
                if not low.any():
                    continue
                weight = short[low] / sum(share[low] ** 2 for share in shares)
                for share, (a, b) in zip(shares, nodes, strict=True):
                    np.maximum.at(lift, (a[low], b[low]), weight * share[low])

    def _pixels(self, tile: Tile) -> Iterator["_PixelStrip"]:
        """Yield the tile's pixels that lie over the grid, some at a time."""
        rows, columns = tile.heights.shape
        across = tile.corner[0] + (np.arange(columns) + 0.5) * tile.block
        half = (tile.block - 1) / 2
        many = max(1, STRIP_PIXELS // columns)
        for first in range(0, rows, many):
            values = tile.heights[first : first + many].T
            down = tile.corner[1] + (np.arange(first, first + values.shape[1]) + 0.5) * tile.block
            middles = tile.local.grid(across, down)
            reach = np.zeros(2)
            if half:  # how far a block reaches from its middle
                ahead = tile.local.grid(across + half, down) - middles, tile.local.grid(across, down + half) - middles
                reach = sum(np.abs(part).max(axis=(1, 2)) for part in ahead)
            x, y = middles
            x, y = (x - self.x[0]) / self.steps[0], (y - self.y[0]) / self.steps[1]
            around = reach[0] / self.steps[0], reach[1] / self.steps[1]
            inside = (x >= -around[0]) & (x <= len(self.x) - 1 + around[0])
            inside &= (y >= -around[1]) & (y <= len(self.y) - 1 + around[1])
            ends = len(self.x) - 1.0, len(self.y) - 1.0
            yield _PixelStrip(x[inside], y[inside], values[inside], np.isnan(values[inside]), around, ends)


@dataclass(frozen=True)
class _PixelStrip:
    """Pixels, or the middles of blocks of pixels, in steps of the grid.

    Attributes
    ----------
    x, y
        (n,) places in steps of the grid.
    z
        (n,) heights, metres.
    holes
        (n,) whether there is no data.
    around
        How far a block reaches around its middle along x and y; 0 for single pixels.
    ends
        The last node along x and y.
    """

    x: Floats
    y: Floats
    z: Floats
    holes: NDArray[np.bool_]
    around: tuple[float, float]
    ends: tuple[float, float]

    @property
    def cells(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The cell of the grid that each pixel lies in."""
        i, j = (
            np.clip(at.astype(np.int64), 0, int(end) - 1) for at, end in zip((self.x, self.y), self.ends, strict=True)
        )
        return i, j

    def corners(self) -> Iterator[tuple[Floats, Floats]]:
        """Yield the places at which the ground must not be lower: a bilinear surface is least at corners of a block."""
        if self.around == (0.0, 0.0):
            yield self.x, self.y
            return
        sides = []
        for at, around, end in zip((self.x, self.y), self.around, self.ends, strict=True):
            low, high = np.clip(at - around, 0, end), np.clip(at + around, 0, end)
            sides.append((low, np.clip(np.round(at), low, high), high))
        for x in sides[0]:
            for y in sides[1]:
                yield x, y


def _blocks(tile: Tile, column: Floats, row: Floats) -> tuple[Floats, Floats]:
    """Return columns and rows of pixels as those of the tile's blocks."""
    return (column - tile.corner[0]) / tile.block, (row - tile.corner[1]) / tile.block


def _inside(tile: Tile, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return which columns and rows of blocks lie in the tile."""
    rows, columns = tile.heights.shape
    inside = (x >= -_EDGE_PIXELS) & (x <= columns + _EDGE_PIXELS) & (y >= -_EDGE_PIXELS) & (y <= rows + _EDGE_PIXELS)
    return np.asarray(inside)


def _between(tile: Tile, values: Floats, column: Floats, row: Floats) -> Floats:
    """Return heights between pixels' centres, ``nan`` outside and beside holes."""
    rows, columns = values.shape
    x, y = _blocks(tile, column, row)
    inside = _inside(tile, x, y)
    x, y = np.clip(x - 0.5, 0, columns - 1), np.clip(y - 0.5, 0, rows - 1)
    i, j = np.minimum(x.astype(np.int64), columns - 2), np.minimum(y.astype(np.int64), rows - 2)
    u, v = x - i, y - j
    h = values
    found = (1 - u) * ((1 - v) * h[j, i] + v * h[j + 1, i]) + u * ((1 - v) * h[j, i + 1] + v * h[j + 1, i + 1])
    return np.where(inside, found, np.nan)


def _filled(
    files: str, level: Origin, grid: _TerrainGrid, heights: Floats, fill: float | Literal["nearest"] | None
) -> Floats:
    """Return heights whose holes are filled, or refuse holes where `fill` is ``None``."""
    holes = np.isnan(heights)
    if fill is None:
        raise InputError(
            f"{files}: {holes.mean():.1%} of the area has no data, such as {grid.place(level, holes)}",
            give=[Remedy("fill_nodata", None, "above sea level"), Remedy("fill_nodata", "nearest")],
        )
    if fill == "nearest":
        if holes.all():
            raise InputError(f"{files}: there is no data in the area")
        from scipy.ndimage import distance_transform_edt

        i, j = distance_transform_edt(holes, sampling=grid.steps, return_distances=False, return_indices=True)
        return heights[i, j]
    return np.where(holes, float(fill), heights)


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
