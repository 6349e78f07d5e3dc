"""Where a scenario's local frame lies on Earth, which part of it the scenario holds, how high, and in what steps."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.maps.assembly.bad_points import BadPoint
from skyverse.maps.assembly.obstacles import LocalFeatures
from skyverse.maps.assembly.places import flat_points
from skyverse.maps.assembly.terrain import GIVE_GROUND
from skyverse.maps.georeference.feature import MAX_WIDTH, SWAPPED, Rectangle, intersection
from skyverse.maps.readers.raster import OpenRaster
from skyverse.model.altitude import AboveGround, AboveSea, Altitude, GlobalPlace
from skyverse.model.frame import Origin, require_true_lengths
from skyverse.model.geodesy import to_local
from skyverse.model.round_steps import round_steps
from skyverse.model.scenario import AltitudeBand, Bounds
from skyverse.model.shapes import Terrain, Voxels


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


DEFAULT_MARGIN = 250.0
"""Metres that are kept around UAVs and targets by default."""


def middle_of(
    area: Area | None,
    places: Sequence[GlobalPlace],
    rasters: Sequence[OpenRaster],
    corners: Floats,
    geoid: float | None,
) -> Origin:
    """Return the middle of what a scenario is to hold, at sea level.

    Parameters
    ----------
    area, places, rasters
        What says which part of the world is meant; the first that is given counts.
    corners
        (n, 2) longitude and latitude of the corners of all buildings, zones and point clouds; they count last.
    geoid
        How far mean sea level lies above the ellipsoid, metres, where it is known.
    """
    if area is not None:
        latitude, longitude = area.middle
    elif places:
        latitude, longitude = _middle(np.array([place[:2] for place in places], dtype=np.float64))
    elif rasters:
        width, height = rasters[0].data.width, rasters[0].data.height
        lon, lat = rasters[0].places(np.array([width / 2]), np.array([height / 2]))
        latitude, longitude = float(lat[0]), float(lon[0])
        if not math.isfinite(latitude + longitude):
            raise InputError(f"{rasters[0].path}: its middle is not on the globe", give=[Remedy("area")])
    elif len(corners):
        latitude, longitude = _middle(corners[:, ::-1])
    else:
        raise InputError("there is nothing to build of; give a terrain, buildings, zones, UAVs or an area")
    longitude = (longitude + 180) % 360 - 180
    return Origin(latitude=round(latitude, 7), longitude=round(longitude, 7), altitude=0.0, geoid=geoid)


def refuse_far(origin: Origin, middle: Origin) -> None:
    """Raise `InputError` for an origin that is too far from the middle of what is asked for."""

    def away(latitude: float, longitude: float) -> float:
        other = origin.model_copy(update={"latitude": latitude, "longitude": longitude})
        return math.hypot(*to_local(other, [middle.latitude, middle.longitude, other.altitude])[0])

    found = away(origin.latitude, origin.longitude)
    if found <= MAX_WIDTH:
        return
    swapped = abs(origin.longitude) <= 90 and away(origin.longitude, origin.latitude) <= MAX_WIDTH
    hint = SWAPPED if swapped else ""
    raise InputError(
        f"expected one within {MAX_WIDTH / 1000:g} km of latitude {middle.latitude:g}, longitude "
        f"{middle.longitude:g}, found latitude {origin.latitude:g}, longitude {origin.longitude:g}, "
        f"{found / 1000:.0f} km away{hint}",
        field="origin",
    )


def _middle(places: Floats) -> tuple[float, float]:
    """Return the middle of the box around places (n, 2), latitude and longitude, across the antimeridian too."""
    from_first = (places[:, 1] - places[0, 1] + 180) % 360 - 180
    latitude = (places[:, 0].min() + places[:, 0].max()) / 2
    return float(latitude), float(places[0, 1] + (from_first.min() + from_first.max()) / 2)


def region_of(
    area: Area | None,
    margin: float | None,
    places: Sequence[GlobalPlace],
    rasters: Sequence[OpenRaster],
    corners: Floats,
    origin: Origin,
    tell: Callable[[str, str], object],
) -> Rectangle:
    """Return the part of the frame that a scenario holds.

    Parameters
    ----------
    area, places, rasters, corners
        As for `middle_of`.
    margin
        Metres around places and corners; `DEFAULT_MARGIN`, or less where the terrain ends nearer, when left out.
    origin
        The frame's origin.
    tell
        Called with a file and what was done with it.
    """
    if area is not None:
        if margin is not None:
            raise InputError("expected it without an area, found both", field="margin")
        return area.inside(origin)
    wide = DEFAULT_MARGIN if margin is None else margin
    if places:
        region = around(flat_points(places, origin), wide)
        if margin is None and len(rasters) == 1:
            region, whole = intersection(region, covered(rasters[0], origin)), region
            if region != whole and min(region[2] - region[0], region[3] - region[1]) > 0:
                tell(rasters[0].path, f"ends less than {DEFAULT_MARGIN:g} m from a UAV or target; the area ends there")
        return region
    if len(rasters) > 1:
        raise InputError("several terrain files: expected an area or UAVs that say what to take of them, found neither")
    if rasters:
        return covered(rasters[0], origin)
    flat = [(lat, lon, AboveSea(0.0)) for lon, lat in corners]
    return around(flat_points(flat, origin), wide)


DEFAULT_HEADROOM = 30.0
"""Metres from the highest ground, building, UAV or target to the ceiling by default."""
LEAST_DEFAULT_STEP = 1.0
"""Metres between the lattice's nodes at least where its step is not given."""
VERY_LOW_LEVEL = 152.4
"""Metres, 500 feet: how high the airspace is in which UAVs fly; zones that begin higher than this above the highest
ground, building, UAV or target do not raise the ceiling."""


def heights(
    relief: Terrain | None,
    these: Sequence[LocalFeatures],
    solids: Sequence[Voxels],
    points: Sequence[tuple[float, float, float]],
) -> tuple[float, float]:
    """Return the lowest and the highest z of ground, buildings, voxels and points, and of where zones begin."""
    z = [point[2] for point in points]
    for one in these:
        standing = np.array([feature.kind == "building" for feature in one.features], dtype=bool)
        ends = np.concatenate([one.low[standing], one.high[standing]])
        z += ends[np.isfinite(ends)].tolist()
    for solid in solids:
        z += [solid.origin[2], solid.origin[2] + solid.step[2] * solid.occupied.shape[2]]
    if relief is not None:
        highest = max([float(relief.heights.max()), *z])
        return float(np.floor(relief.heights.min())), max([highest, *_beginnings(these, highest)])
    if not z:
        z = [end for one in these for end in [*one.low, *one.high] if math.isfinite(end)] or [0.0]
    return math.floor(min(z)), max([*z, *_beginnings(these, max(z))])


def _beginnings(these: Sequence[LocalFeatures], highest: float) -> list[float]:
    """Return the z at which zones begin that UAVs could reach from below, so that the bounds do not end before them."""
    lows = np.concatenate([np.empty(0), *(one.low for one in these)])
    return lows[np.isfinite(lows) & (lows <= highest + VERY_LOW_LEVEL)].tolist()


def ceiling(
    asked: Altitude | None,
    band: tuple[float, float] | None,
    frame: Origin,
    relief: Terrain | None,
    floor: float,
    highest: float,
) -> float:
    """Return z of the bounds' upper end.

    Parameters
    ----------
    asked
        What the user asks for, if anything.
    band
        The heights above ground that paths keep to, metres.
    frame, relief
        The local frame's origin, and the ground, if it is known.
    floor, highest
        z of the bounds' lower end, and of the highest thing in the scenario.
    """
    ground = None if relief is None else float(relief.heights.max())
    if asked is None:
        if band is not None and ground is not None:
            highest = max(highest, ground + band[1])
        return float(math.ceil(highest + DEFAULT_HEADROOM))
    if isinstance(asked, AboveGround):
        if ground is None:
            raise InputError("metres above ground need the ground", field="max_height", give=GIVE_GROUND)
        top = ground + asked.metres
    else:
        top = asked.metres - frame.altitude
    if top <= floor + 1:
        raise InputError(
            f"expected an altitude above the lowest ground, {frame.altitude + floor:.0f} m amsl, found "
            f"{frame.altitude + top:.0f} m amsl",
            field="ceiling",
        )
    return top


def high_points(points: Iterable[tuple[str, tuple[float, float, float]]], top: float) -> list[BadPoint]:
    """Return those points, given with their names, that are above the ceiling."""
    return [
        BadPoint(
            name,
            point,
            f"expected a point below the ceiling, found it {point[2] - top:.1f} m above",
            give=(Remedy("ceiling", None, "to raise it"),),
        )
        for name, point in points
        if point[2] > top
    ]


def lattice_step(bounds: Bounds, step: float | None, upright: float = math.inf) -> tuple[float, float, float]:
    """Return the lattice's step along each axis, metres: the one asked for, or the shortest of few enough nodes.

    One that is not asked for is no longer along z than `upright`, metres.
    """
    sizes = [high - low for low, high in zip(bounds.min, bounds.max, strict=True)]
    if step is None:
        return round_steps(sizes, LEAST_DEFAULT_STEP, upright)
    x, y, z = (min(step, size) for size in sizes)
    return x, y, z


def altitude_band(band: tuple[float, float] | None, weight: float, relief: Terrain | None) -> AltitudeBand | None:
    """Return the heights above ground that paths keep to, and the price of leaving them."""
    if band is None:
        return None
    if relief is None:
        raise InputError("metres above ground need the ground", field="band", give=GIVE_GROUND)
    if not 0 <= band[0] <= band[1]:
        raise InputError(f"expected low,high metres above ground, low not above high, found {band}", field="band")
    return AltitudeBand(low=band[0], high=band[1], weight=weight, above="ground")
