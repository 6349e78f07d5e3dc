"""Sound polygons on the globe that cover geometries as files have them, or a reason why there are none."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pyproj
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.maps.georeference.longitudes import in_one_piece, joined, pieces, unwrapped

Tell = Callable[[str], object]
MAX_EDGE_DEGREES = 0.005
"""Degrees; longer edges get corners between, as a straight edge in a file is not quite straight on the ground."""
BUFFER_SIDES = 64
"""Sides of the polygon that is drawn around a circle."""
PLANE_LENGTH = 0.5
"""Degrees of a line that are drawn in one plane."""
BAND_STEP = 500.0
"""Metres between the corners of a band around a line near the equator; less towards the poles."""
BAND_SLACK = 0.02
"""Metres; a straight edge of a plane strays less than this on the globe from one corner to the next."""


def polygons(
    geometry: BaseGeometry,
    where: str,
    tell: Tell,
    *,
    radius: float | None = None,
    buffer: float | None = None,
    lenient: bool = False,
) -> list[Polygon]:
    """Return the polygons that cover a geometry in longitude and latitude.

    Parameters
    ----------
    geometry
        Polygons, or points and lines, which need a width.
    where
        The beginning of messages.
    tell
        Called with a sentence where the geometry was repaired or taken to cross the antimeridian.
    radius
        The radius of a point, metres.
    buffer
        The width around lines, and around points without a radius, metres.
    lenient
        Whether outlines without an area are left out and told; they are refused otherwise.

    Raises
    ------
    InputError
        If a part of the geometry is no polygon and has no width, or encloses nothing.
    """
    geometry = shapely.force_2d(geometry)
    if geometry.is_empty:
        return []
    if geometry.geom_type in ("MultiPolygon", "GeometryCollection", "MultiPoint", "MultiLineString"):
        options: dict[str, Any] = {"radius": radius, "buffer": buffer, "lenient": lenient}
        return joined([part for one in geometry.geoms for part in polygons(one, where, tell, **options)])
    if isinstance(geometry, Polygon):
        whole = in_one_piece(geometry, where)
        if not np.array_equal(shapely.get_coordinates(whole.exterior), shapely.get_coordinates(geometry.exterior)):
            tell(f"{where}: taken to cross the antimeridian, as its outline jumps by more than 180 degrees")
        return repaired(whole, where, tell, lenient=lenient)
    width = Remedy("Reading.buffer", None, "to give it a width")
    if isinstance(geometry, Point):
        reach = radius if radius is not None else buffer
        if reach is None:
            raise InputError(f"{where}: expected a polygon, found a point without a radius", give=[width])
        return band(geometry, reach, where)
    if isinstance(geometry, LineString):
        if buffer is None:
            raise InputError(f"{where}: expected a polygon, found a line", give=[width])
        return band(geometry, buffer, where)
    raise InputError(f"{where}: expected a polygon, found a {geometry.geom_type}")


def band(line: LineString | Point, metres: float, where: str) -> list[Polygon]:
    """Return polygons that cover all within some metres of a point, or of a line with edges straight in degrees.

    They are drawn in planes that touch the Earth, in which no two places are farther apart than on the ground.
    """
    places = shapely.get_coordinates(line)
    if len(places) > 1:
        places = shapely.get_coordinates(shapely.segmentize(LineString(unwrapped(places, where)), MAX_EDGE_DEGREES))
    lengths = np.hypot(*np.diff(places, axis=0).T)
    piece = np.floor((np.cumsum(lengths) - lengths) / PLANE_LENGTH)
    ends = np.flatnonzero(np.diff(piece)) + 1
    first, last = [0, *ends.tolist()], [*ends.tolist(), len(places) - 1]
    bands = [_band(places[a : b + 1], metres, where) for a, b in zip(first, last, strict=True)]
    return pieces(shapely.union_all(bands)) if len(bands) > 1 else bands


def _band(places: Floats, metres: float, where: str) -> Polygon:
    """Return the band around the corners (n, 2) of a line that is short enough for one plane."""
    x, y = ((places.min(axis=0) + places.max(axis=0)) / 2).tolist()
    plane = pyproj.Proj(f"+proj=ortho +lat_0={y!r} +lon_0={x!r} +ellps=WGS84")
    flat = np.column_stack(plane(places[:, 0], places[:, 1]))
    reach = metres + float(np.ptp(flat, axis=0).max())
    slack = min(BAND_SLACK, 3e-4 * reach)
    width = (metres + slack) / math.cos(math.pi / BUFFER_SIDES)
    # edge by edge, as GEOS loses most of the band around a line that goes back on itself
    edges = np.stack([flat[:-1], flat[1:]], axis=1) if len(flat) > 1 else np.stack([flat, flat], axis=1)
    wide = shapely.union_all(shapely.buffer(shapely.linestrings(edges), width, quad_segs=BUFFER_SIDES // 4))
    steepest = math.tan(math.radians(min(abs(y) + reach / 1.1e5, 89.99)))
    outline = shapely.transform(
        shapely.segmentize(wide, BAND_STEP / math.sqrt(max(1.0, steepest))),
        lambda a, b: plane(a, b, inverse=True),
        interleaved=False,
    )
    return in_one_piece(outline, where, beside=x)


def repaired(polygon: Polygon, where: str, tell: Tell, *, lenient: bool = False) -> list[Polygon]:
    """Return a valid polygon as it is, and an invalid one as polygons that cover all that it winds around.

    Parameters
    ----------
    polygon
        Longitude and latitude, degrees.
    where, tell, lenient
        As for `polygons`.
    """
    if polygon.is_valid and polygon.area > 0:
        return [shapely.remove_repeated_points(polygon)]
    outer = filled(np.array(polygon.exterior.coords)[:, :2])
    if outer.is_empty:
        corners = len(np.unique(shapely.get_coordinates(polygon.exterior), axis=0))
        found = f"an outline of {corners} corners without an area"
        if not lenient:
            raise InputError(f"{where}: expected a polygon, found {found}")
        tell(f"{where}: left out, {found}")
        return []
    kept: list[Polygon] = []
    for ring in polygon.interiors:
        hole = Polygon(ring)
        if hole.is_valid and hole.area > 0 and outer.covers(hole) and not any(hole.intersects(k) for k in kept):
            kept.append(hole)
    tell(f"{where}: its outline meets itself or a hole; repaired so that nothing that it may enclose is lost")
    return pieces(outer.difference(shapely.union_all(kept)) if kept else outer)


def filled(ring: Floats) -> MultiPolygon | Polygon:
    """Return all that a closed ring (n, 2) encloses by either fill rule, however it crosses itself."""
    loop = ring[np.concatenate([[True], np.any(np.diff(ring, axis=0) != 0, axis=1)])]
    if len(loop) < 4:
        return Polygon()
    if not np.array_equal(loop[0], loop[-1]):
        loop = np.vstack([loop, loop[:1]])
    edges = shapely.union_all(shapely.linestrings(np.stack([loop[:-1], loop[1:]], axis=1)))
    faces = pieces(shapely.polygonize(shapely.get_parts(edges)))
    inside = [face for face in faces if _winds_around(loop, np.array(face.representative_point().coords[0]))]
    enclosed = pieces(shapely.union_all([*inside, *pieces(shapely.make_valid(Polygon(loop)))]))
    return MultiPolygon(enclosed) if enclosed else Polygon()


def _winds_around(loop: Floats, place: Floats) -> bool:
    """Tell whether a closed ring (n, 2) winds around a place (2,)."""
    a, b = loop[:-1] - place, loop[1:] - place
    side = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    up = (a[:, 1] <= 0) & (b[:, 1] > 0) & (side > 0)
    down = (a[:, 1] > 0) & (b[:, 1] <= 0) & (side < 0)
    return bool(np.count_nonzero(up) != np.count_nonzero(down))
