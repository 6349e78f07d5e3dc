"""Which of PROJ's operations brings coordinates to WGS84 where they are used, and how well."""

import math
from typing import Any

import pyproj
from pyproj.aoi import AreaOfInterest

NEAR = 0.1
"""Degrees around a place that an operation is chosen for."""
EXACT = 1.0
"""Metres; what is known worse is told."""


def to_globe(crs: pyproj.CRS, x: float, y: float) -> tuple[pyproj.Transformer, str]:
    """Return what brings coordinates near x, y to longitude and latitude, and a doubt about it, if there is one.

    Parameters
    ----------
    crs
        Of two dimensions.

    Raises
    ------
    pyproj.exceptions.ProjError
        If there is nothing that does.
    """
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
