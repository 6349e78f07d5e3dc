"""Which part of the world a scenario holds: a rectangle of the local frame."""

from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.maps.georeference.rectangle import Rectangle
from skyverse.maps.readers.raster import OpenRaster
from skyverse.model.frame import MAX_FAR, Origin, require_true_lengths
from skyverse.model.geodesy import to_local

MAX_WIDTH = 2 * MAX_FAR
"""Metres that a scenario may be wide."""


@dataclass(frozen=True)
class Area:
    """An area between meridians and parallels, degrees; where `west` exceeds `east`, it crosses the antimeridian."""

    west: float
    south: float
    east: float
    north: float

    def __post_init__(self) -> None:
        found = f"{self.west:g},{self.south:g},{self.east:g},{self.north:g}"
        for name, most in (("south", 90), ("north", 90), ("west", 180), ("east", 180)):
            value = getattr(self, name)
            if not abs(value) <= most:
                hint = "; the order is west,south,east,north" if abs(value) <= 180 else ""
                said = f"{found}: expected {name} from -{most} to {most} degrees, found {value:g}{hint}"
                raise InputError(said, field="area")
        if not self.south < self.north or self.west == self.east:
            raise InputError(
                f"{found}: expected west,south,east,north, found {self.south:g} for south, {self.north:g} for north, "
                f"{self.west:g} for west, {self.east:g} for east",
                field="area",
            )
        if self._width > 180:
            said = f"{found}: expected west,south,east,north, found {self._width:g} degrees from west to east"
            raise InputError(said, field="area")

    @property
    def _width(self) -> float:
        return (self.east - self.west) % 360

    @property
    def middle(self) -> tuple[float, float]:
        """Latitude and longitude of the middle, degrees."""
        return (self.south + self.north) / 2, (self.west + self._width / 2 + 180) % 360 - 180

    def inside(self, origin: Origin) -> Rectangle:
        """Return the largest rectangle of whole metres of the local frame that lies in the area."""
        along = np.linspace(0, 1, 65)
        longitude = self.west + self._width * along
        latitude = self.south + (self.north - self.south) * along
        edges = [(latitude, np.full_like(along, side)) for side in (self.west, self.east)]
        edges += [(np.full_like(along, side), longitude) for side in (self.south, self.north)]
        return _between_edges(origin, edges, "the area")


def covered(raster: OpenRaster, origin: Origin) -> Rectangle:
    """Return the largest rectangle of whole metres of the local frame that a raster covers."""
    width, height = raster.data.width, raster.data.height
    across, down = np.linspace(0, width, 65), np.linspace(0, height, 65)
    pixels = [(np.full_like(down, side), down) for side in (0, width)]
    pixels += [(across, np.full_like(across, side)) for side in (0, height)]
    places = [raster.places(columns, rows) for columns, rows in pixels]
    return _between_edges(origin, [(latitude, longitude) for longitude, latitude in places], raster.path)


def _between_edges(origin: Origin, edges: list[tuple[Floats, Floats]], what: str) -> Rectangle:
    """Return the rectangle between four edges of latitudes and longitudes."""
    places = [to_local(origin, np.column_stack([lat, lon, np.zeros_like(lat)]))[:, :2] for lat, lon in edges]
    middle = np.mean(np.concatenate(places), axis=0)
    limits = [-np.inf, -np.inf, np.inf, np.inf]
    for edge in places:
        away = edge.mean(axis=0) - middle
        axis = int(abs(away[1]) > abs(away[0]))
        if away[axis] < 0:
            limits[axis] = max(limits[axis], edge[:, axis].max())
        else:
            limits[axis + 2] = min(limits[axis + 2], edge[:, axis].min())
    if not np.isfinite(limits).all():
        raise InputError(
            f"{what}: expected four sides towards west, south, east and north",
            give=[Remedy("area", None, "that is smaller")],
        )
    (x0, y0), (x1, y1) = np.ceil(limits[:2]).tolist(), np.floor(limits[2:]).tolist()
    return require_size((x0, y0, x1, y1), what)


def require_size(region: Rectangle, what: str) -> Rectangle:
    """Return a region, or raise `InputError` if it is too small or too large to fly in."""
    x0, y0, x1, y1 = region
    if min(x1 - x0, y1 - y0) < 1:
        raise InputError(f"{what}: expected an area of some metres, found {x1 - x0:g} m by {y1 - y0:g} m")
    if max(x1 - x0, y1 - y0) > MAX_WIDTH:
        raise InputError(
            f"{what}: expected an area of at most {MAX_WIDTH / 1000:g} km, found {(x1 - x0) / 1000:.0f} km by "
            f"{(y1 - y0) / 1000:.0f} km"
        )
    require_true_lengths((x0, y0), (x1, y1), what)
    return region


def around(points: Floats, margin: float) -> Rectangle:
    """Return the rectangle of whole metres that keeps a margin, metres, around local points (n, 2 or 3)."""
    low, high = np.floor(points[:, :2].min(axis=0) - margin), np.ceil(points[:, :2].max(axis=0) + margin)
    return require_size((float(low[0]), float(low[1]), float(high[0]), float(high[1])), "the UAVs and targets")
