"""Which of PROJ's operations brings coordinates to WGS84 where they are used, and how well."""

import math
from typing import Any

import pyproj
from pyproj.aoi import AreaOfInterest

from skyverse.errors import InputError

NEAR = 0.1
"""Degrees around a place that an operation is chosen for."""
EXACT = 1.0
"""Metres; what is known worse is told."""


def to_globe(crs: pyproj.CRS, x: float, y: float, where: str) -> tuple[pyproj.Transformer, str]:
    """Return what brings coordinates near x, y to longitude and latitude, and a doubt about it, if there is one.

    Parameters
    ----------
    crs
        Of two dimensions.

    Raises
    ------
    InputError
        If there is nothing that does; the message begins with `where`.
    """
    try:
        return _to_globe(crs, x, y)
    except pyproj.exceptions.ProjError as error:
        said = " ".join(str(error).split())
        raise InputError(f"{where}: coordinates in {crs.name} cannot be brought to WGS84: {said:.200}") from None


def _to_globe(crs: pyproj.CRS, x: float, y: float) -> tuple[pyproj.Transformer, str]:
    transformer = pyproj.Transformer.from_crs(crs, "OGC:CRS84", always_xy=True)
    longitude, latitude = transformer.transform(x, y)
    if not (math.isfinite(longitude) and abs(latitude) <= 90):
        return transformer, ""
    longitude = (longitude + 180) % 360 - 180
    south, north = max(-90.0, latitude - NEAR), min(90.0, latitude + NEAR)
    if abs(longitude) + NEAR <= 180:
        area: Any = AreaOfInterest(longitude - NEAR, south, longitude + NEAR, north)
        transformer = pyproj.Transformer.from_crs(crs, "OGC:CRS84", always_xy=True, area_of_interest=area)
        transformer.transform(x, y)
    try:
        used = transformer.get_last_used_operation()
    except pyproj.exceptions.ProjError:  # nothing had to be done
        return transformer, ""
    if "ballpark" in used.description.lower():
        return transformer, f"coordinates in {crs.name} are taken as if their datum were WGS84's, as none else is known"
    if used.accuracy > EXACT:
        return transformer, f"coordinates in {crs.name} are known to {used.accuracy:g} m on the globe"
    return transformer, ""


def vertical(crs: pyproj.CRS, where: str) -> tuple[float, bool] | None:
    """Return the metres to each unit of a system's heights, and whether they are above the ellipsoid.

    ``None`` where it says nothing of heights.

    Raises
    ------
    InputError
        If it counts downwards.
    """
    axis = next((axis for axis in crs.axis_info if axis.direction in ("up", "down")), None)
    if axis is None:
        return None
    if axis.direction == "down":
        raise InputError(f"{where}: expected heights, but {crs.name!r} counts downwards")
    parts = crs.sub_crs_list if crs.is_compound else [crs]
    above = len(parts[0].axis_info) == 3 or "ellipsoid" in parts[-1].name.lower()
    return axis.unit_conversion_factor or 1.0, above
