"""Random ground, buildings and zones as files, and how near a flown line comes to them, without a line of skyverse.

Heights are bilinear between the pixels of the raster in its own projection; places are metres east and north of a home
on an azimuthal map, and metres above the sea. All is sampled densely.
"""

import itertools
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyproj
import rasterio
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

Floats = NDArray[np.float64]
KINDS = ("ground", "ceiling", "building", "zone", "fence")
HARMED = {"ground": 2.0, "ceiling": -8.0, "building": 0.5, "zone": 0.5, "fence": -1.0}
"""Metres to what is met, below which a line is wrong by metres: above ground, below the ceiling, or beside."""
CLEAN = {"ground": 10.0, "ceiling": 9.0, "building": 9.0, "zone": 9.0, "fence": 9.0}
"""Metres from which it is right by metres; required are some 5 to 8."""
STEP = 1.0
"""Metres between two samples of a flown line."""


class Solid(NamedTuple):
    """An outline, local metres, and from where to where above the sea it is shut: surely, and at most."""

    kind: str
    outline: Polygon
    surely: tuple[float, float]
    most: tuple[float, float]
    fields: dict[str, Any]


@dataclass
class PlantedWorld:
    """Ground of square pixels, row 0 in the north, and what stands on it; `low` and `high` are the rules of flight."""

    latitude: float
    longitude: float
    cell: float
    heights: Floats
    max_height: float
    solids: list[Solid] = field(default_factory=list)
    fence: Polygon | None = None

    def __post_init__(self) -> None:
        zone = int((self.longitude + 180) // 6) % 60 + 1
        self.crs = f"EPSG:{(32600 if self.latitude >= 0 else 32700) + zone}"
        local = f"+proj=aeqd +lat_0={self.latitude:.9f} +lon_0={self.longitude:.9f} +datum=WGS84"
        self.to_globe = pyproj.Transformer.from_crs(local, "EPSG:4326", always_xy=True)
        self.to_raster = pyproj.Transformer.from_crs(local, self.crs, always_xy=True)
        middle = np.array(self.to_raster.transform(0.0, 0.0))
        n = self.heights.shape[0]
        self.corner = np.round(middle + np.array([-n, n]) * self.cell / 2, 3)  # west and north

    def ground(self, x: Any, y: Any) -> Floats:
        """Return metres above the sea at places east and north of home."""
        east, north = self.to_raster.transform(np.asarray(x, float), np.asarray(y, float))
        column = (np.asarray(east) - self.corner[0]) / self.cell - 0.5
        row = (self.corner[1] - np.asarray(north)) / self.cell - 0.5
        i, j = (np.clip(np.floor(one), 0, len(self.heights) - 2).astype(int) for one in (row, column))
        u, v, h = row - i, column - j, self.heights
        return np.asarray(
            (1 - u) * ((1 - v) * h[i, j] + v * h[i, j + 1]) + u * ((1 - v) * h[i + 1, j] + v * h[i + 1, j + 1])
        )

    def slope(self, x: float, y: float) -> float:
        """Return the steepest slope of the ground within some metres, degrees."""
        aside = np.array([-8.0, -4.0, 0.0, 4.0, 8.0])
        heights = self.ground(x + aside[:, None], y + aside[None])
        return float(np.degrees(np.arctan(np.hypot(*np.gradient(heights, 4.0)).max())))

    def raise_around(self, x: float, y: float, metres: float, along: tuple[float, float], sizes: Any) -> None:
        """Add a ridge or, with metres below 0, a valley: a bell as long and wide as `sizes`, along a direction."""
        east, north = self.to_raster.transform(x, y)
        n = np.arange(len(self.heights)) + 0.5
        dx, dy = self.corner[0] + n[None] * self.cell - east, self.corner[1] - n[:, None] * self.cell - north
        a, b = dx * along[0] + dy * along[1], dy * along[0] - dx * along[1]
        self.heights = self.heights + metres * np.exp(-((a / sizes[0]) ** 2) - (b / sizes[1]) ** 2)

    def globe(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Return latitudes and longitudes."""
        longitude, latitude = self.to_globe.transform(x, y)
        return latitude, longitude

    def solid(self, kind: str, outline: Polygon, height: float | None, *, sea: bool = False) -> Solid:
        """Return what stands on the ground, `height` metres tall, or shut up to an altitude, or without an end."""
        under = self._under(outline.buffer(self.cell))
        if height is None:
            return Solid(kind, outline, (-1e4, 1e5), (-1e4, 1e5), {"name": kind})
        if sea:
            fields = {"name": kind, "lower": "GND", "upper": height, "upperUnit": "m", "upperReference": "AMSL"}
            # one that ends below all ground there is shut from the ground up
            surely, most = (1e5 if (ground >= height).all() else height for ground in (under, self._under(outline)))
            return Solid(kind, outline, (-1e4, surely), (-1e4, most), fields)
        top = (float(under.min()) + height, float(under.max()) + height + 1.0)
        return Solid(kind, outline, (-1e4, top[0]), (-1e4, top[1]), {"name": kind, "height": f"{height} m"})

    def _under(self, outline: Polygon) -> Floats:
        """Return heights of the ground below an outline, and within it."""
        x, y = shapely.get_coordinates(outline.segmentize(self.cell / 2)).T
        x0, y0 = outline.centroid.x, outline.centroid.y
        return np.concatenate([self.ground(x * s + x0 * (1 - s), y * s + y0 * (1 - s)) for s in np.linspace(0, 1, 8)])

    def write(self, folder: Path) -> dict[str, list[Path]]:
        """Write the files, and return them by the options that name them."""
        tif, n = folder / "dem.tif", len(self.heights)
        transform = rasterio.Affine(self.cell, 0, self.corner[0], 0, -self.cell, self.corner[1])
        profile = {"driver": "GTiff", "height": n, "width": n, "count": 1, "dtype": "float64", "crs": self.crs}
        with rasterio.open(tif, "w", transform=transform, **profile) as file:
            file.write(self.heights, 1)
            file.units = ("metre",)
        made: dict[str, list[Path]] = {"terrain": [tif]}
        for kind in ("building", "zone"):
            path = folder / f"{kind}s.geojson"
            some = [one for one in self.solids if one.kind == kind]
            path.write_text(json.dumps({"type": "FeatureCollection", "features": [self._feature(s) for s in some]}))
            if some:
                made[f"{kind}s"] = [path]
        return made

    def _feature(self, solid: Solid) -> dict[str, Any]:
        latitude, longitude = self.globe(*shapely.get_coordinates(solid.outline).T)
        ring = np.column_stack([longitude, latitude]).round(9).tolist()
        geometry = {"type": "Polygon", "coordinates": [ring]}
        return {"type": "Feature", "properties": solid.fields, "geometry": geometry}

    def gaps(self, points: Floats, *, surely: bool) -> dict[str, float]:
        """Return the least metres between a line's samples, (n, 3), and what it must keep clear of, by kind."""
        above = points[:, 2] - self.ground(points[:, 0], points[:, 1])
        found = {"ground": float(above.min()), "ceiling": float((self.max_height - above).min())}
        places = shapely.points(points[:, :2])
        for solid in self.solids:
            low, high = solid.surely if surely else solid.most
            beside = shapely.distance(solid.outline, places)
            upright = np.maximum(np.maximum(low - points[:, 2], points[:, 2] - high), 0.0)
            found[solid.kind] = min(found.get(solid.kind, np.inf), float(np.hypot(beside, upright).min()))
        if self.fence is not None:
            edge = shapely.distance(self.fence.exterior, places)
            inside = shapely.contains(self.fence, places)
            found["fence"] = min(found.get("fence", np.inf), float(np.where(inside, edge, -edge).min()))
        return found

    def harm(self, points: Floats) -> set[str]:
        """Return what a line surely meets."""
        return {kind for kind, gap in self.gaps(points, surely=True).items() if gap < HARMED[kind]}

    def doubt(self, points: Floats) -> set[str]:
        """Return what a line may come too near to."""
        return {kind for kind, gap in self.gaps(points, surely=False).items() if gap < CLEAN[kind]}


def sampled(points: Any, step: float = STEP) -> Floats:
    """Return samples of a polyline, (n, 3)."""
    points = np.asarray(points, float)
    parts = [points[:1]]
    for a, b in itertools.pairwise(points):
        share = np.linspace(0, 1, max(int(np.ceil(np.linalg.norm(b - a) / step)), 1) + 1)[1:, None]
        parts.append(a + share * (b - a))
    return np.concatenate(parts)


def random_world(rng: np.random.Generator, radius: float, max_height: float) -> PlantedWorld:
    """Return ground with slopes of up to 45 degrees around a level place, of a relief below half of `max_height`."""
    cell = float(rng.uniform(5, 30))
    n = int(np.ceil(2 * (radius + 250) / cell))
    power, longest = rng.uniform(1.5, 3.0), rng.uniform(300, 1500)
    f = np.hypot(np.fft.fftfreq(n, cell)[:, None], np.fft.fftfreq(n, cell)[None])
    spectrum = np.where(f > 0, 1.0, 0.0) / np.maximum(f, 1 / longest) ** power * np.exp(-((f * 2.5 * cell) ** 2))
    heights = np.real(np.fft.ifft2(np.fft.fft2(rng.normal(size=(n, n))) * spectrum))
    steep = np.hypot(*np.gradient(heights, cell)).max()
    relief = float(np.ptp(heights))
    heights *= min(np.tan(np.radians(rng.uniform(5, 45))) / steep, 0.45 * max_height / relief)
    i = (np.arange(n) - n / 2 + 0.5) * cell
    away = np.hypot(i[:, None], i[None])
    level = heights[n // 2, n // 2]
    share = np.clip((away - 1.5 * cell - 12) / (3 * cell + 20), 0, 1)
    heights = level + (heights - level) * share**2 * (3 - 2 * share)
    base = rng.uniform(150, 2500)
    latitude, longitude = rng.uniform(-62, 65), rng.uniform(-179, 179)
    return PlantedWorld(latitude, longitude, cell, heights - heights.min() + base, max_height)
