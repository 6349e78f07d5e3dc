"""What rasters have over a region of the local frame: windows of heights, and where their pixels lie in the frame.

Polynomials through Chebyshev points stand in place of projections, which cost microseconds a place.

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
from skyverse.maps.readers.undeclared_nodata import extremes_of_blocks, refuse_undeclared_nodata
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
        return np.einsum("kin,mn->kim", np.einsum("in,knm->kim", left, self._values), right)


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
