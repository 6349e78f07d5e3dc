"""Geometries from the coordinate system of their file to longitude and latitude, by PROJ's best operation there."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pyproj
import shapely
from numpy.typing import NDArray
from pyproj.aoi import AreaOfInterest

from skyverse._typing import Floats
from skyverse.errors import InputError, printable

AREA_OF_INTEREST = 0.1
"""Half the side, degrees, of the area around a place for which PROJ chooses its best operation."""
EXACT_ENOUGH = 1.0
"""Metres; an operation that is less exact is told."""


def transformer_to_globe(crs: pyproj.CRS, x: float, y: float, where: str) -> tuple[pyproj.Transformer, str]:
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
        return _transformer(crs, x, y)
    except pyproj.exceptions.ProjError as error:
        said = " ".join(str(error).split())
        raise InputError(f"{where}: coordinates in {crs.name} cannot be brought to WGS84: {said:.200}") from None


def _transformer(crs: pyproj.CRS, x: float, y: float) -> tuple[pyproj.Transformer, str]:
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


def unit_of_heights(crs: pyproj.CRS, where: str) -> tuple[float, bool] | None:
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


WGS84 = pyproj.CRS("OGC:CRS84")
MAX_EDGE = 500.0
"""Metres; longer edges in projected coordinates get corners between, as a straight edge is not one on the globe."""
MAX_ADDED_CORNERS = 1e5
"""Corners at most along the whole width of a file that get between: edges are longer where a file is wider."""
OUTSIDE_AREA_OF_USE = 10.0
"""Degrees that coordinates may lie outside of the area in which their system is used."""


def named_crs(text: str, where: str) -> pyproj.CRS:
    """Return the coordinate system of a name such as ``EPSG:7415`` or ``urn:ogc:def:crs:EPSG::7415``."""
    try:
        return pyproj.CRS.from_user_input(text)
    except (pyproj.exceptions.CRSError, UnicodeError, ValueError):
        found = printable(text)
        raise InputError(f"{where}: expected a coordinate system such as EPSG:4326, found {found!r:.60}") from None


def to_globe(
    geometries: NDArray[Any],
    crs: pyproj.CRS,
    file: str,
    names: Callable[[int], str],
    tell: Callable[[str], object],
) -> NDArray[Any]:
    """Return geometries in WGS84 longitude and latitude, degrees; their z stays as it was.

    Parameters
    ----------
    geometries
        (n,) geometries of shapely.
    crs
        Their coordinate system.
    file
        The file, for messages.
    names
        Returns a geometry's name for messages, by its number.
    tell
        Called with a sentence where the way to WGS84 is doubtful.

    Raises
    ------
    InputError
        If a geometry does not lie on the globe, or far from where its coordinate system is used.
    """
    if len(geometries) == 0:
        return geometries
    flat = crs.to_2d() if len(crs.axis_info) == 3 else crs
    same = flat.is_geographic and flat.equals(WGS84, ignore_axis_order=True)
    if not same and flat.is_geographic:
        same = flat.equals(pyproj.CRS("EPSG:4326"), ignore_axis_order=True)
    if same:
        _require_degrees(geometries, names)
        return geometries
    x0, y0, x1, y1 = shapely.total_bounds(geometries).tolist()
    across = flat.is_geographic and x1 - x0 > 180
    transformer, doubt = transformer_to_globe(flat, x1 if across else (x0 + x1) / 2, (y0 + y1) / 2, file)
    if doubt:
        tell(f"{file}: {doubt}")
    if flat.is_projected:
        unit = flat.axis_info[0].unit_conversion_factor or 1.0
        _require_finite(geometries, names)
        step = max(MAX_EDGE / unit, max(x1 - x0, y1 - y0) / MAX_ADDED_CORNERS)
        geometries = shapely.segmentize(geometries, step)

    def moved(places: Floats) -> Floats:
        x, y = transformer.transform(places[:, 0], places[:, 1])
        return np.column_stack([x, y, *places.T[2:]])

    geometries = shapely.transform(geometries, moved, include_z=bool(np.any(shapely.has_z(geometries))))
    _require_finite(geometries, names, f" in {crs.name}")
    _require_area_of_use(geometries, crs, names)
    return geometries


def _require_area_of_use(geometries: NDArray[Any], crs: pyproj.CRS, names: Callable[[int], str]) -> None:
    """Refuse what lies far from where a coordinate system is used: it is in another system, or its axes are swapped."""
    area = crs.area_of_use
    if area is None or area.west > area.east:
        return
    bounds, more = shapely.bounds(geometries), OUTSIDE_AREA_OF_USE
    low, high = (area.west - more, area.south - more), (area.east + more, area.north + more)
    bad = np.flatnonzero((bounds[:, :2] < low).any(axis=1) | (bounds[:, 2:] > high).any(axis=1))
    if len(bad):
        x, y = bounds[bad[0], :2]
        raise InputError(
            f"{names(int(bad[0]))}: expected coordinates in {crs.name}, used in {area.name:.60}, "
            f"but that would put it at {y:.4f}, {x:.4f}"
        )


def _require_finite(geometries: NDArray[Any], names: Callable[[int], str], system: str = "") -> None:
    places, owner = shapely.get_coordinates(geometries, return_index=True)
    bad = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if len(bad):
        raise InputError(f"{names(int(owner[bad[0]]))}: expected coordinates on the globe{system}, found others")


def _require_degrees(geometries: NDArray[Any], names: Callable[[int], str]) -> None:
    _require_finite(geometries, names)
    places, owner = shapely.get_coordinates(geometries, return_index=True)
    bad = np.flatnonzero((np.abs(places[:, 1]) > 90) | (np.abs(places[:, 0]) > 360))
    if not len(bad):
        return
    x, y = places[bad[0]]
    if abs(x) > 360 or abs(y) > 360:
        hint = "these look like metres: the file needs to say its coordinate system"
    else:
        hint = "longitude stands first: are the two swapped?"
    raise InputError(
        f"{names(int(owner[bad[0]]))}: expected longitude and latitude in degrees, found {x:.10g}, {y:.10g}; {hint}"
    )
