"""Where the local frame of a scenario lies on Earth, and which part of it the scenario holds."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.maps.assembly.options import GlobalPlace
from skyverse.maps.assembly.places import flat_points
from skyverse.maps.assembly.region import MAX_WIDTH, Area, around, covered
from skyverse.maps.georeference.latitude_longitude import SWAPPED
from skyverse.maps.georeference.rectangle import Rectangle, intersection
from skyverse.maps.readers.raster import OpenRaster
from skyverse.model.altitude import AboveSea
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_local

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
