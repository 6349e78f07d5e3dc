"""What rasters have over a region of the local frame: windows of heights, and where their pixels lie in the frame.

Polynomials through Chebyshev points stand in place of projections, which cost microseconds a place. A number that
stands for no data although the file does not declare it fills blocks of pixels with a cliff nearly all around them.

Source: J.-P. Berrut, L. N. Trefethen, "Barycentric Lagrange interpolation", SIAM Review 46 (2004), 501-517.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.maps.georeference.feature import Rectangle
from skyverse.maps.readers.raster import OpenRaster
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_local, to_wgs84

CHEBYSHEV_NODES = 16
"""Chebyshev points along each side of the rectangle."""


class ChebyshevMap:
    """The polynomial in two variables through a function's values at the Chebyshev points of a rectangle.

    Over a map of 100 km it meets projections and the Earth's curvature to a micrometre.

    Parameters
    ----------
    function
        Takes two arrays (n,) and returns (k, n).
    first, second
        The range of each variable.
    """

    def __init__(
        self,
        function: Callable[[Floats, Floats], Floats],
        first: tuple[float, float],
        second: tuple[float, float],
    ) -> None:
        self._ranges = first, second
        a, b = (low + (high - low) * _POINTS for low, high in self._ranges)
        each, other = np.meshgrid(a, b, indexing="ij")
        self._values = function(each.ravel(), other.ravel()).reshape(-1, CHEBYSHEV_NODES, CHEBYSHEV_NODES)

    def grid(self, first: NDArray[Any], second: NDArray[Any]) -> Floats:
        """Return the values (k, n, m) at every pair of one of `first` (n,) and one of `second` (m,)."""
        left, right = (_weights(at, *span) for at, span in zip((first, second), self._ranges, strict=True))
        along = np.einsum("in,knm->kim", left, self._values)
        return np.einsum("kim,mj->kij", along, np.ascontiguousarray(right.T))  # several times as fast as with rows


_ANGLES = (2 * np.arange(CHEBYSHEV_NODES) + 1) * np.pi / (2 * CHEBYSHEV_NODES)
_POINTS = (1 - np.cos(_ANGLES)) / 2
_BARYCENTRIC_WEIGHTS = (-1.0) ** np.arange(CHEBYSHEV_NODES) * np.sin(_ANGLES)


def _weights(at: NDArray[Any], low: float, high: float) -> Floats:
    """Return the weight (n, nodes) of each Chebyshev point's value at each place, by the barycentric formula."""
    apart = ((at - low) / (high - low))[:, None] - _POINTS
    met = apart == 0
    shares = _BARYCENTRIC_WEIGHTS / np.where(met, 1.0, apart)
    shares[met.any(axis=1)] = 0.0
    shares[met] = 1.0
    return shares / shares.sum(axis=1, keepdims=True)


MAX_PIXELS, POOLED_PIXELS = 8e6, 2e6
"""A window of more pixels than the first is read as blocks, about as many as the second where the step allows it."""
GIVE_GEOID = Remedy("geoid", None, "for how far mean sea level lies above it there")
"""What helps where heights are counted from the ellipsoid."""
_PROBES = np.array([0.13, 0.37, 0.61, 0.89])


@dataclass(frozen=True)
class Tile:
    """A window of a raster, and how it lies in the local frame whose origin is at altitude 0.

    Attributes
    ----------
    heights
        (rows, columns) metres above sea level, ``nan`` where there is no data. Where `block` is above 1, each is the
        greatest of `block` by `block` pixels.
    lowest
        (rows, columns) the same, but the least of the pixels of a block that have data.
    corner
        Column and row of the window's first pixel.
    block
        How many pixels wide and high the block is that a height stands for.
    local
        Maps column and row to x and y.
    pixel
        Maps x and y to column and row.
    """

    heights: Floats
    lowest: Floats
    corner: tuple[int, int]
    block: int
    local: ChebyshevMap
    pixel: ChebyshevMap


def tiles(raster: OpenRaster, origin: Origin, region: Rectangle, step: float) -> list[Tile]:
    """Return what a raster has over a region of the local frame; a raster around the globe may reach it twice.

    Parameters
    ----------
    raster
        The raster.
    origin
        The local frame's origin, at altitude 0.
    region
        The region, local metres.
    step
        How far apart heights are wanted, metres; blocks of pixels are not longer.

    Raises
    ------
    InputError
        If the raster's coordinates are not known over the region, or it has no usable heights there.
    """
    x0, y0, x1, y1 = region
    found = []
    for turns in (0,) if raster.turn is None else (-1, 0, 1):

        def pixel(x: Floats, y: Floats, turns: int = turns) -> Floats:
            latitude, longitude, _ = to_wgs84(origin, np.column_stack([x, y, np.zeros_like(x)])).T
            return np.array(raster.pixels(longitude, latitude, origin.longitude, turns))

        to_pixel = ChebyshevMap(pixel, (x0, x1), (y0, y1))
        reach = to_pixel.grid(np.linspace(x0, x1, 33), np.linspace(y0, y1, 33))
        if not np.isfinite(reach).all():
            raise InputError(f"{raster.path}: its coordinate system, {raster.name}, does not reach the area")
        across, down = reach
        width, height = raster.data.width, raster.data.height
        left, right = max(0, int(across.min()) - 3), min(width, int(across.max()) + 4)
        top, bottom = max(0, int(down.min()) - 3), min(height, int(down.max()) + 4)
        if left >= right or top >= bottom:
            continue

        def local(columns: Floats, rows: Floats) -> Floats:
            longitude, latitude = raster.places(columns, rows)
            if not (np.isfinite(longitude).all() and np.isfinite(latitude).all()):
                raise InputError(f"{raster.path}: its coordinate system, {raster.name}, does not reach its pixels")
            return to_local(origin, np.column_stack([latitude, longitude, np.zeros_like(latitude)]))[:, :2].T

        to_metres = ChebyshevMap(local, (left, right), (top, bottom))
        _refuse_discontinuity(raster, to_pixel, to_metres, region)
        side = _longest_side(to_metres, (left, right), (top, bottom))
        block = _block((right - left) * (bottom - top), side, step)
        window = left, top, right - left, bottom - top
        heights, lowest = extremes_of_blocks(raster, window, block)
        refuse_undeclared_nodata(raster, window, heights, block, side * block)
        if raster.ellipsoidal:
            if origin.geoid is None:
                raise InputError(f"{raster.path}: its heights are counted from the ellipsoid", give=[GIVE_GEOID])
            heights, lowest = heights - origin.geoid, lowest - origin.geoid
        found.append(Tile(heights, lowest, (left, top), block, to_metres, to_pixel))
    return found


def _block(pixels: int, side: float, step: float) -> int:
    """Return how many pixels wide a block is, for a window of so many pixels, the longest side of one in metres."""
    wanted = 1 if pixels <= MAX_PIXELS else int(np.ceil(np.sqrt(pixels / POOLED_PIXELS)))
    return max(1, min(wanted, int(step / (1.5 * side))))


def pixel_size(raster: OpenRaster, origin: Origin) -> float:
    """Return the longest side of a pixel near the origin, metres."""
    at = np.array([origin.longitude]), np.array([origin.latitude])
    column, row = raster.pixels(*at, origin.longitude, 0)
    longitude, latitude = raster.places(column + np.eye(3)[1], row + np.eye(3)[2])
    places = to_local(origin, np.column_stack([latitude, longitude, np.zeros(3)]))
    found = float(np.hypot(*(places[1:] - places[0])[:, :2].T).max())
    if not 0 < found < np.inf:
        raise InputError(f"{raster.path}: its coordinate system, {raster.name}, does not reach the area")
    return found


def _longest_side(to_metres: ChebyshevMap, columns: tuple[int, int], rows: tuple[int, int]) -> float:
    """Return the longest side of a pixel in a window, metres."""
    at = [np.linspace(low, high, 5) for low, high in (columns, rows)]
    places = to_metres.grid(*at)
    sides = [np.hypot(*np.diff(places, axis=1 + axis)).max() / (at[axis][1] - at[axis][0]) for axis in range(2)]
    return float(max(sides))


def _refuse_discontinuity(
    raster: OpenRaster, to_pixel: ChebyshevMap, to_metres: ChebyshevMap, region: Rectangle
) -> None:
    """Refuse a raster whose maps from metres to pixels and back do not agree, as where a pole lies in the region."""
    x0, y0, x1, y1 = region
    x, y = x0 + (x1 - x0) * _PROBES, y0 + (y1 - y0) * _PROBES
    column, row = to_pixel.grid(x, y).reshape(2, -1)
    each, other = (at.ravel() for at in np.meshgrid(x, y, indexing="ij"))
    inside = (column > 0) & (column < raster.data.width) & (row > 0) & (row < raster.data.height)
    for k in np.flatnonzero(inside):
        back = to_metres.grid(column[k : k + 1], row[k : k + 1])[:, 0, 0]
        if not np.hypot(back[0] - each[k], back[1] - other[k]) < 0.01:
            raise InputError(f"{raster.path}: its coordinate system, {raster.name}, is not smooth over the area")


Window = tuple[int, int, int, int]
"""The first column and row, and how many columns and rows."""

CLIFF_DOWN, CLIFF_UP = 100.0, 1000.0
"""Metres from one pixel to the next: no shore falls by more, and no roof or rock rises by more, nearly all around."""
CLIFF_SLOPE = 2.0
"""Metres of height a metre of width that a cliff has at least, as pixels may be wide."""
CLIFF_SHARE = 0.75
"""The share of a block's border that a cliff exceeds where the block holds no data."""
MIN_BORDER = 0.5
"""The least border of a block, in sides of a square of its area: the plain around a tower is not cut off by it."""
SURROUNDINGS = 300
"""Pixels around a doubtful window that are looked at as well."""


def extremes_of_blocks(raster: OpenRaster, window: Window, block: int) -> tuple[Floats, Floats]:
    """Read a window strip by strip, and return the greatest and the least height of each block, metres.

    Where a pixel has no data, the greatest height of its block is ``nan``; the least is that of the other pixels, and
    ``nan`` if there are none.

    Parameters
    ----------
    raster, window
        What to read.
    block
        How many pixels wide and high a block is.
    """
    left, top, width, height = window
    if block == 1:
        heights = raster.heights(left, top, width, height)
        return heights, heights
    columns, rows = -(-width // block), -(-height // block)
    highest, lowest = np.empty((2, rows, columns))
    strip = max(1, int(2e6 / (width * block)))
    for first in range(0, rows, strip):
        last = min(rows, first + strip)
        tall = min(height, last * block) - first * block
        part = raster.heights(left, top + first * block, width, tall)
        part = np.pad(part, ((0, (last - first) * block - tall), (0, columns * block - width)), mode="edge")
        part = part.reshape(last - first, block, columns, block)
        highest[first:last], lowest[first:last] = part.max(axis=(1, 3)), np.fmin.reduce(part, axis=(1, 3))
    return highest, lowest


def refuse_undeclared_nodata(raster: OpenRaster, window: Window, heights: Floats, block: int, width: float) -> None:
    """Raise `InputError` where a number in a window stands for no data, with the number, its share, and a place.

    A window of one height, and one that seems to hold such a number, is judged together with its surroundings.

    Parameters
    ----------
    raster, window
        The window.
    heights
        (rows, columns) the heights of its blocks, metres.
    block
        How many pixels wide and high a block is.
    width
        How wide a block is, metres.
    """
    if raster.all_heights or np.isnan(heights).all():
        return
    rows, columns = heights.shape
    level = np.nanmin(heights) == np.nanmax(heights)
    if not level and undeclared_gap(heights, width, (slice(0, rows), slice(0, columns)), 0.0) is None:
        return
    left, top, across, down = window
    before, above = min(SURROUNDINGS, left // block), min(SURROUNDINGS, top // block)
    first = left - before * block, top - above * block
    last = left + across + SURROUNDINGS * block, top + down + SURROUNDINGS * block
    size = raster.data.width, raster.data.height
    wide = (*first, *(min(end, most) - begin for end, most, begin in zip(last, size, first, strict=True)))
    core = slice(above, above + rows), slice(before, before + columns)
    found = undeclared_gap(extremes_of_blocks(raster, wide, block)[0], width, core, MIN_BORDER)
    if found is not None:
        height, (row, column), share = found
        pixel = first[0] + (column + 0.5) * block, first[1] + (row + 0.5) * block
        raster.refuse_height(height, share, pixel, "with a cliff all round it")


def undeclared_gap(
    heights: Floats, width: float, core: tuple[slice, slice], min_border: float
) -> tuple[float, tuple[int, int], float] | None:
    """Return the largest block of one height that cliffs cut off and that reaches into the core, or ``None``.

    It is returned as its height, metres, the row and column of one of its cells, and the share of the core's cells that
    have this height.

    Parameters
    ----------
    heights
        (rows, columns) metres, ``nan`` where there is no data.
    width
        How wide a cell is, metres.
    core
        The rows and columns that are judged; the others are their surroundings.
    min_border
        The least border of a block, in sides of a square of its area.
    """
    fall, rise = max(CLIFF_DOWN, CLIFF_SLOPE * width), max(CLIFF_UP, CLIFF_SLOPE * width)
    pairs = [(heights[:, :-1], heights[:, 1:]), (heights[:-1], heights[1:])]
    suspects = []
    for one, other in pairs:
        step = np.abs(other - one)
        cliff = step > fall
        if cliff.any():
            ends = one[cliff], other[cliff]
            suspects += [np.minimum(*ends), np.maximum(*ends)[step[cliff] > rise]]
    if not suspects:
        return None
    inner = heights[core]
    values = np.unique(inner[np.isin(inner, np.unique(np.concatenate(suspects)))])
    if not len(values):
        return None
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    doubtful = np.isin(heights, values)
    count = int(doubtful.sum())
    number = np.full(heights.shape, -1, dtype=np.int32)
    number[doubtful] = np.arange(count, dtype=np.int32)
    numbers = [(number[:, :-1], number[:, 1:]), (number[:-1], number[1:])]
    alike = [(h == k) & (a >= 0) for (a, _), (h, k) in zip(numbers, pairs, strict=True)]
    edges = tuple(np.concatenate([sides[k][same] for sides, same in zip(numbers, alike, strict=True)]) for k in (0, 1))
    many, block = connected_components(coo_array((np.ones(len(edges[0]), bool), edges), (count, count)), directed=False)
    border, falls, rises = np.zeros((3, many))
    span = np.sqrt(np.bincount(block, minlength=many))
    for (a, b), (h, k) in zip(numbers, pairs, strict=True):
        for mine, own, next_to in ((a, h, k), (b, k, h)):
            edge = (mine >= 0) & (own != next_to) & np.isfinite(next_to)
            owner = block[mine[edge]]
            step = next_to[edge] - own[edge]
            border += np.bincount(owner, minlength=many)
            falls += np.bincount(owner, step > fall, minlength=many)
            rises += np.bincount(owner, step < -rise, minlength=many)
    cut_off = (border > min_border * span) & (np.maximum(falls, rises) > CLIFF_SHARE * border)
    inside = number[core]
    here = block[inside[inside >= 0]]
    size = np.bincount(here, minlength=many) * cut_off
    if not size.any():
        return None
    size[size > inner.size / 2] = 1  # where a plain meets a block high above it, the plain is not the gap
    chosen = np.argmax(size)
    row, column = np.argwhere(inside >= 0)[np.flatnonzero(here == chosen)[0]]
    height = float(inner[row, column])
    cell = int(row) + core[0].start, int(column) + core[1].start
    return height, cell, float((inner == height).mean())
