"""Where a scenario's frame lies on Earth, and how much of the world it holds."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.maps.assembly.places import Place, flat_points
from skyverse.maps.assembly.region import LARGEST, Area, around, common, covered
from skyverse.maps.readers.raster import Opened, Rectangle
from skyverse.model.altitude import AboveSea
from skyverse.model.geodesy import to_local
from skyverse.model.scenario import Origin

MARGIN = 250.0
"""Metres around UAVs and targets that are kept when nothing is said."""


def middle(
    area: Area | None, places: Sequence[Place], files: Sequence[Opened], corners: Floats, geoid: float | None
) -> Origin:
    """Return the middle of what is asked for, at sea level.

    Parameters
    ----------
    corners
        (n, 2) longitude and latitude of all that stands in the way.
    """
    if area is not None:
        latitude, longitude = area.middle
    elif places:
        latitude, longitude = _middle(np.array([place[:2] for place in places], dtype=np.float64))
    elif files:
        width, height = files[0].data.width, files[0].data.height
        lon, lat = files[0].places(np.array([width / 2]), np.array([height / 2]))
        latitude, longitude = float(lat[0]), float(lon[0])
        if not math.isfinite(latitude + longitude):
            raise InputError(f"{files[0].path}: its middle is not on the globe; give --area")
    elif len(corners):
        latitude, longitude = _middle(corners[:, ::-1])
    else:
        raise InputError("there is nothing to build of; give a terrain, buildings, zones, UAVs or an area")
    longitude = (longitude + 180) % 360 - 180
    return Origin(latitude=round(latitude, 7), longitude=round(longitude, 7), altitude=0.0, geoid=geoid)


def refuse_far(origin: Origin, there: Origin) -> None:
    """Refuse an origin that is too far from what is asked for."""

    def away(latitude: float, longitude: float) -> float:
        other = origin.model_copy(update={"latitude": latitude, "longitude": longitude})
        return float(np.linalg.norm(to_local(other, [there.latitude, there.longitude, other.altitude])))

    found = away(origin.latitude, origin.longitude)
    if found <= LARGEST:
        return
    turned = abs(origin.longitude) <= 90 and away(origin.longitude, origin.latitude) <= LARGEST
    hint = "; are latitude and longitude swapped?" if turned else ""
    raise InputError(
        f"--origin: expected one within {LARGEST / 1000:g} km of latitude {there.latitude:g}, longitude "
        f"{there.longitude:g}, found latitude {origin.latitude:g}, longitude {origin.longitude:g}, "
        f"{found / 1000:.0f} km away{hint}"
    )


def _middle(places: Any) -> tuple[float, float]:
    turned = (places[:, 1] - places[0, 1] + 180) % 360 - 180
    latitude = (places[:, 0].min() + places[:, 0].max()) / 2
    return float(latitude), float(places[0, 1] + (turned.min() + turned.max()) / 2)


def kept(
    area: Area | None,
    margin: float | None,
    places: Sequence[Place],
    files: Sequence[Opened],
    corners: Floats,
    level: Origin,
    tell: Callable[[str, str], object],
) -> Rectangle:
    """Return the part of the frame that the scenario holds; `tell` gets a file, and what was done with it."""
    if area is not None:
        if margin is not None:
            raise InputError("--margin: expected it without --area, found both")
        return area.inside(level)
    wide = MARGIN if margin is None else margin
    if places:
        region = around(flat_points(places, level), wide)
        if margin is None and len(files) == 1:
            region, whole = common(region, covered(files[0], level)), region
            if region != whole and min(region[2] - region[0], region[3] - region[1]) > 0:
                tell(files[0].path, f"ends less than {MARGIN:g} m from a UAV or target; the area ends there")
        return region
    if len(files) > 1:
        raise InputError("several terrain files: expected an area or UAVs that say what to take of them, found neither")
    if files:
        return covered(files[0], level)
    flat = [(lat, lon, AboveSea(0.0)) for lon, lat in corners]
    return around(flat_points(flat, level), wide)
