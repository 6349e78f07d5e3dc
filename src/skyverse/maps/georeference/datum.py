"""Which of PROJ's operations brings coordinates to WGS84 near the place where they are used, and how exact it is."""

import math
from typing import Any

import pyproj
from pyproj.aoi import AreaOfInterest

from skyverse.errors import InputError

AREA_OF_INTEREST = 0.1
"""Half the side, degrees, of the area around a place for which PROJ chooses its best operation."""
EXACT_ENOUGH = 1.0
"""Metres; an operation that is less exact is told."""


def to_globe(crs: pyproj.CRS, x: float, y: float, where: str) -> tuple[pyproj.Transformer, str]:
    """Return the transformer of coordinates near x, y to longitude and latitude, and a doubt about it or ``""``.

    Parameters
    ----------
    crs
        A coordinate system of two dimensions.
    x, y
        A place in that system.
    where
        The beginning of messages.

    Raises
    ------
    InputError
        If PROJ has no such operation.
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
    south, north = max(-90.0, latitude - AREA_OF_INTEREST), min(90.0, latitude + AREA_OF_INTEREST)
    if abs(longitude) + AREA_OF_INTEREST <= 180:
        area: Any = AreaOfInterest(longitude - AREA_OF_INTEREST, south, longitude + AREA_OF_INTEREST, north)
        transformer = pyproj.Transformer.from_crs(crs, "OGC:CRS84", always_xy=True, area_of_interest=area)
        transformer.transform(x, y)
    try:
        used = transformer.get_last_used_operation()
    except pyproj.exceptions.ProjError:  # no operation was needed
        return transformer, ""
    if "ballpark" in used.description.lower():
        return transformer, f"coordinates in {crs.name} are read as if their datum were WGS84's, as no other is known"
    if used.accuracy > EXACT_ENOUGH:
        return transformer, f"coordinates in {crs.name} are known to {used.accuracy:g} m on the globe"
    return transformer, ""


def vertical(crs: pyproj.CRS, where: str) -> tuple[float, bool] | None:
    """Return how many metres a unit of a system's heights has, and whether heights are above the ellipsoid.

    ``None`` where the system says nothing of heights.

    Raises
    ------
    InputError
        If the system counts depths downwards.
    """
    axis = next((axis for axis in crs.axis_info if axis.direction in ("up", "down")), None)
    if axis is None:
        return None
    if axis.direction == "down":
        raise InputError(f"{where}: expected heights, but {crs.name!r} counts downwards")
    parts = crs.sub_crs_list if crs.is_compound else [crs]
    above = len(parts[0].axis_info) == 3 or "ellipsoid" in parts[-1].name.lower()
    return axis.unit_conversion_factor or 1.0, above
