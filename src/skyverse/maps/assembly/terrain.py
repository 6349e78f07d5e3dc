"""Rasters to the ground of a scenario: heights on a grid of the local frame, nowhere below what the rasters say."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.maps.readers.raster import LEVELS, Opened, Raster, Rectangle, Tile, opened, pitch, tiles
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Origin
from skyverse.model.shapes import Terrain

MOST_NODES = 5_000_000
STRIP = 500_000
"""Pixels looked at together."""
HAIR = 1e-6
"""Metres above what is to be met, against rounding."""


@dataclass(frozen=True)
class Raised:
    """How a terrain differs from what a plain interpolation of its rasters gives.

    Attributes
    ----------
    most, mean
        Metres that nodes were raised by, so that no height of the rasters stands out.
    share
        Of all nodes, those that were raised.
    filled
        Share of nodes that had no data and were filled.
    step
        Between nodes, metres.
    """

    most: float
    mean: float
    share: float
    filled: float
    step: float


def read_terrain(
    rasters: Sequence[Raster],
    origin: Origin,
    region: Rectangle,
    *,
    step: float | None = None,
    fill: float | Literal["nearest"] | None = None,
    clearance: float | None = None,
) -> tuple[Terrain, Raised]:
    """Read the ground over a region of the local frame.

    Where rasters overlap, the higher one counts. The bilinear surface of the result is nowhere below any height that
    a raster has at a pixel's centre in the region.

    Parameters
    ----------
    rasters
        The files.
    origin
        Of the local frame.
    region
        The least x and y, the greatest x and y, metres.
    step
        Between heights, metres at most; that of the finest raster when left out, but no more than four million nodes.
    fill
        What stands for the ground where there is no data: metres above mean sea level, or the nearest height. Holes
        are refused when left out.
    clearance
        Of the terrain.

    Raises
    ------
    InputError
        If a file cannot be used, or does not cover the region, or has holes.
    """
    level = origin.model_copy(update={"altitude": 0.0})
    x0, y0, x1, y1 = region
    with ExitStack() as stack:
        files = [stack.enter_context(opened(raster)) for raster in rasters]
        if step is None:
            step = max(min(pitch(file, level) for file in files), np.sqrt((x1 - x0) * (y1 - y0) / (0.8 * MOST_NODES)))
        nx, ny = (max(1, int(np.ceil((high - low) / step - 1e-9))) + 1 for low, high in ((x0, x1), (y0, y1)))
        if nx * ny > MOST_NODES:
            raise InputError(
                f"the terrain's step of {step:g} m makes {nx * ny:,} heights, above the {MOST_NODES:,} that are kept; "
                "take a longer step or a smaller area"
            )
        x, y = np.linspace(x0, x1, nx), np.linspace(y0, y1, ny)
        found = [tile for file in files for tile in tiles(file, level, region, step)]
    grid = _Grid(x, y)
    heights = np.full((nx, ny), np.nan)
    covered = np.zeros((nx, ny), dtype=bool)
    for tile in found:
        z, reached = grid.sample(tile)
        heights = np.fmax(heights, z)
        covered |= reached
    _refuse_uncovered(files, level, grid, covered)
    holes = np.isnan(heights)
    if holes.any():
        heights = _filled(files, level, grid, heights, fill)
    lift = np.zeros_like(heights)
    for tile in found:
        grid.raise_to(tile, heights, lift)
    terrain = Terrain(
        origin=(x0, y0),
        step=(float(x[1] - x[0]), float(y[1] - y[0])),
        heights=heights + lift - origin.altitude,
        clearance=clearance,
    )
    raised = lift > 0
    return terrain, Raised(
        most=float(lift.max()),
        mean=float(lift.mean()),
        share=float(raised.mean()),
        filled=float(holes.mean()),
        step=float(max(terrain.step)),
    )


class _Grid:
    """The nodes of a terrain; z here is counted from an origin at altitude 0."""

    def __init__(self, x: Floats, y: Floats) -> None:
        self.x, self.y = x, y
        self.steps = float(x[1] - x[0]), float(y[1] - y[0])

    def sample(self, tile: Tile) -> tuple[Floats, NDArray[np.bool_]]:
        """Return z at the nodes, interpolated between pixels' centres, and which nodes the tile's pixels cover."""
        shape = len(self.x), len(self.y)
        heights, covered = np.empty(shape), np.empty(shape, dtype=bool)
        many = max(1, STRIP // shape[1])
        for first in range(0, shape[0], many):
            part = slice(first, first + many)
            column, row, altitude, column_up, row_up, altitude_up = tile.pixel.grid(self.x[part], self.y)
            rise = LEVELS[1] - LEVELS[0]
            z = np.full_like(column, np.nanmean(tile.heights) if np.isfinite(tile.heights).any() else 0.0)
            for _ in range(2):  # the line up from a node leans towards other pixels, the more the farther it is away
                share = (z - LEVELS[0]) / rise
                found, inside = _between(tile, column + share * (column_up - column), row + share * (row_up - row))
                there = LEVELS[0] + (found - altitude) / (altitude_up - altitude) * rise
                z = np.where(np.isnan(there), z, there)
            heights[part], covered[part] = there, inside
        for strip in self._pixels(tile):
            i, j = strip.cells
            for k, m in ((0, 0), (1, 0), (0, 1), (1, 1)):  # round a pixel without data
                heights[i[strip.holes] + k, j[strip.holes] + m] = np.nan
        return heights, covered

    def raise_to(self, tile: Tile, heights: Floats, lift: Floats) -> None:
        """Raise `lift` until no pixel stands above the bilinear surface of `heights` and `lift`."""
        for strip in self._pixels(tile):
            for x, y in strip.corners():
                i = np.clip(x.astype(np.int64), 0, len(self.x) - 2)
                j = np.clip(y.astype(np.int64), 0, len(self.y) - 2)
                u, v = x - i, y - j
                shares = (1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v
                nodes = (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)
                short = strip.z + HAIR - sum(share * heights[node] for share, node in zip(shares, nodes, strict=True))
                low = (short > 0) & ~strip.holes
                if not low.any():
                    continue
                weight = short[low] / sum(share[low] ** 2 for share in shares)
                for share, (a, b) in zip(shares, nodes, strict=True):
                    np.maximum.at(lift, (a[low], b[low]), weight * share[low])

    def _pixels(self, tile: Tile) -> Iterator["_Strip"]:
        """Yield the tile's pixels that lie over the grid, some at a time."""
        rows, columns = tile.heights.shape
        across = tile.corner[0] + (np.arange(columns) + 0.5) * tile.block
        half = (tile.block - 1) / 2
        relief = np.nanmax(tile.heights, initial=0.0) - np.nanmin(tile.heights, initial=0.0)
        many = max(1, STRIP // columns)
        for first in range(0, rows, many):
            values = tile.heights[first : first + many].T
            down = tile.corner[1] + (np.arange(first, first + values.shape[1]) + 0.5) * tile.block
            base, lean = np.split(tile.local.grid(across, down), 2)
            reach = np.zeros(3)
            if half:  # how far a block's pixels lie from its middle
                ahead = tile.local.grid(across + half, down)[:3] - base, tile.local.grid(across, down + half)[:3] - base
                reach = sum(np.abs(part).max(axis=(1, 2)) for part in ahead)
                reach[:2] += np.abs(lean[:2]).max(axis=(1, 2)) * relief
            height = np.where(np.isnan(values), 0.0, values)
            x, y, z = base + height * lean
            x, y = (x - self.x[0]) / self.steps[0], (y - self.y[0]) / self.steps[1]
            around = reach[0] / self.steps[0], reach[1] / self.steps[1]
            inside = (x >= -around[0]) & (x <= len(self.x) - 1 + around[0])
            inside &= (y >= -around[1]) & (y <= len(self.y) - 1 + around[1])
            ends = len(self.x) - 1.0, len(self.y) - 1.0
            yield _Strip(x[inside], y[inside], z[inside] + reach[2], np.isnan(values[inside]), around, ends)


@dataclass(frozen=True)
class _Strip:
    """Pixels in steps of the grid, or the middles of blocks that reach `around` them."""

    x: Floats
    y: Floats
    z: Floats
    holes: NDArray[np.bool_]
    around: tuple[float, float]
    ends: tuple[float, float]

    @property
    def cells(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        i, j = (
            np.clip(at.astype(np.int64), 0, int(end) - 1) for at, end in zip((self.x, self.y), self.ends, strict=True)
        )
        return i, j

    def corners(self) -> Iterator[tuple[Floats, Floats]]:
        """Yield where the ground must not be lower: a bilinear surface is least at corners of what a cell cuts off."""
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


def _between(tile: Tile, column: Floats, row: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return heights between pixels' centres, ``nan`` outside and beside holes, and which places are inside."""
    rows, columns = tile.heights.shape
    x = (column - tile.corner[0]) / tile.block
    y = (row - tile.corner[1]) / tile.block
    inside = (x >= -_NEAR) & (x <= columns + _NEAR) & (y >= -_NEAR) & (y <= rows + _NEAR)
    x, y = np.clip(x - 0.5, 0, columns - 1), np.clip(y - 0.5, 0, rows - 1)
    i, j = np.minimum(x.astype(np.int64), columns - 2), np.minimum(y.astype(np.int64), rows - 2)
    u, v = x - i, y - j
    h = tile.heights
    found = (1 - u) * ((1 - v) * h[j, i] + v * h[j + 1, i]) + u * ((1 - v) * h[j, i + 1] + v * h[j + 1, i + 1])
    return np.where(inside, found, np.nan), inside


_NEAR = 1e-3
"""Pixels that a place may lie outside of a raster and still be at its edge."""


def _refuse_uncovered(files: list[Opened], level: Origin, grid: _Grid, covered: NDArray[np.bool_]) -> None:
    if covered.all():
        return
    i, j = np.argwhere(~covered)[0]
    latitude, longitude, _ = to_wgs84(level, [grid.x[i], grid.y[j], 0.0])[0]
    names = ", ".join(file.path for file in files)
    raise InputError(
        f"{names}: expected terrain over all of the area, but {1 - covered.mean():.1%} of it lies outside, "
        f"such as latitude {latitude:.6f}, longitude {longitude:.6f}"
    )


def _filled(
    files: list[Opened], level: Origin, grid: _Grid, heights: Floats, fill: float | Literal["nearest"] | None
) -> Floats:
    """Return heights without holes."""
    holes = np.isnan(heights)
    if fill is None:
        i, j = np.argwhere(holes)[0]
        latitude, longitude, _ = to_wgs84(level, [grid.x[i], grid.y[j], 0.0])[0]
        raise InputError(
            f"{', '.join(file.path for file in files)}: {holes.mean():.1%} of the area has no data, such as latitude "
            f"{latitude:.6f}, longitude {longitude:.6f}; fill it with --fill-nodata METRES or nearest"
        )
    if fill == "nearest":
        if holes.all():
            raise InputError(f"{', '.join(file.path for file in files)}: there is no data in the area")
        from scipy.ndimage import distance_transform_edt

        i, j = distance_transform_edt(holes, sampling=grid.steps, return_distances=False, return_indices=True)
        filled: Floats = heights[i, j]
        return filled
    each, other = (at[holes] for at in np.meshgrid(grid.x, grid.y, indexing="ij"))
    heights = heights.copy()
    heights[holes] = height_of(level, each, other, np.full(len(each), float(fill)))
    return heights


def height_of(origin: Origin, x: Floats, y: Floats, altitude: Floats) -> Floats:
    """Return z in the local frame (n,) of altitudes above mean sea level, over x, y."""
    z = altitude - origin.altitude
    for _ in range(4):  # each step gains three digits or more
        z = z + altitude - to_wgs84(origin, np.column_stack([x, y, z]))[:, 2]
    return z


def flat_ground(origin: Origin, region: Rectangle, altitude: float, clearance: float | None = None) -> Terrain:
    """Return ground that is everywhere at an altitude above mean sea level, or a hair above it."""
    x0, y0, x1, y1 = region
    nx, ny = (max(1, int(np.ceil((high - low) / FLAT_STEP))) + 1 for low, high in ((x0, x1), (y0, y1)))
    x, y = np.linspace(x0, x1, nx), np.linspace(y0, y1, ny)
    each, other = (at.ravel() for at in np.meshgrid(x, y, indexing="ij"))
    sag = (FLAT_STEP**2 / 4) / (2 * 6.33e6)  # between nodes the level bulges above the straight line
    z = height_of(origin, each, other, np.full(len(each), altitude)) + sag
    return Terrain(
        origin=(x0, y0),
        step=(float(x[1] - x[0]), float(y[1] - y[0])),
        heights=z.reshape(nx, ny),
        clearance=clearance,
    )


FLAT_STEP = 200.0


def ground_between(terrain: Terrain, outlines: NDArray[Any]) -> tuple[Floats, Floats]:
    """Return the lowest and the highest ground (n,) under polygons of shapely, or less and more by a cell's slope.

    Of a polygon that leaves the terrain, what is under the rest counts, or under the nearest edge.
    """
    import shapely

    (x0, y0), (dx, dy), h = terrain.origin, terrain.step, terrain.heights
    corners = h[:-1, :-1], h[1:, :-1], h[:-1, 1:], h[1:, 1:]  # a bilinear cell is nowhere beyond them
    least, most = np.minimum.reduce(corners), np.maximum.reduce(corners)
    boxes = (shapely.bounds(outlines).reshape(-1, 4) - [x0, y0, x0, y0]) / [dx, dy, dx, dy]
    i, j, m, n = np.clip(np.floor(boxes), 0, np.array(least.shape * 2) - 1).astype(np.int64).T
    wide, deep = m - i + 1, n - j + 1
    low, high = np.empty(len(outlines)), np.empty(len(outlines))
    few = wide * deep <= FEW_CELLS
    for k in np.flatnonzero(~few):
        touched = _touched(outlines[k], terrain, (int(i[k]), int(j[k])), (int(wide[k]), int(deep[k])))
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


def _touched(outline: Any, terrain: Terrain, first: tuple[int, int], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Return which cells of a part of the terrain a polygon touches; all, if none."""
    from rasterio.features import rasterize
    from rasterio.transform import Affine

    (x0, y0), (dx, dy) = terrain.origin, terrain.step
    to_place = Affine(0, dx, x0 + first[0] * dx, dy, 0, y0 + first[1] * dy)  # its rows go along x
    touched = rasterize([outline], shape, transform=to_place, all_touched=True, dtype="uint8").astype(bool)
    found: NDArray[np.bool_] = touched if touched.any() else np.ones(shape, dtype=bool)
    return found


FEW_CELLS = 400
"""Up to so many, cells are intersected one by one; of more, drawing the polygon is faster."""
