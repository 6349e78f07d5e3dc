"""From geometries as a file has them to sound outlines on the globe, never smaller; or a reason why not."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pyproj
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from skyverse.errors import InputError
from skyverse.maps.georeference import datum
from skyverse.maps.georeference.limits import printable
from skyverse.maps.georeference.longitudes import in_one_piece, joined, pieces, unwrapped

Tell = Callable[[str], object]
WGS84 = pyproj.CRS("OGC:CRS84")
EDGE = 0.005
"""Degrees; longer edges get corners between, as what is straight in a file is not quite so on the ground."""
MARGIN = 10.0
"""Degrees that coordinates may lie outside of where their system is used."""
SIDES = 64
"""Of what stands for a circle, around it."""
PIECE = 0.5
"""Degrees of a line that are drawn in one plane."""
STEP = 500.0
"""Metres between the corners of what is drawn around a line, where the meridians do not run together."""
SLACK = 0.02
"""Metres; more than what is straight in a plane strays on the globe from one corner to the next."""


def named_crs(text: str, where: str) -> pyproj.CRS:
    """Return the coordinate system of a name such as ``EPSG:7415`` or ``urn:ogc:def:crs:EPSG::7415``."""
    try:
        return pyproj.CRS.from_user_input(text)
    except (pyproj.exceptions.CRSError, UnicodeError, ValueError):
        found = printable(text)
        raise InputError(f"{where}: expected a coordinate system such as EPSG:4326, found {found!r:.60}") from None


def to_globe(
    geometries: NDArray[Any], crs: pyproj.CRS, file: str, names: Callable[[int], str], tell: Tell
) -> NDArray[Any]:
    """Return geometries in WGS84 longitude, latitude, with z as it was; refuse what is not on the globe.

    Parameters
    ----------
    names
        Gives the name of a geometry for messages, by its number.
    """
    if len(geometries) == 0:
        return geometries
    flat = crs.to_2d() if len(crs.axis_info) == 3 else crs
    same = flat.is_geographic and flat.equals(WGS84, ignore_axis_order=True)
    if not same and flat.is_geographic:
        same = flat.equals(pyproj.CRS("EPSG:4326"), ignore_axis_order=True)
    if same:
        _in_range(geometries, names)
        return geometries
    x0, y0, x1, y1 = shapely.total_bounds(geometries).tolist()
    across = flat.is_geographic and x1 - x0 > 180
    transformer, doubt = datum.to_globe(flat, x1 if across else (x0 + x1) / 2, (y0 + y1) / 2, file)
    if doubt:
        tell(f"{file}: {doubt}")
    if flat.is_projected:
        unit = flat.axis_info[0].unit_conversion_factor or 1.0
        _finite(geometries, names)
        step = _sensible(geometries, 500.0 / unit)
        geometries = np.array([*(densified(geometry, step) for geometry in geometries), None], dtype=object)[:-1]

    def moved(places: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y = transformer.transform(places[:, 0], places[:, 1])
        return np.column_stack([x, y, *places.T[2:]])

    geometries = (
        shapely.transform(geometries, moved, include_z=True)
        if _any_z(geometries)
        else shapely.transform(geometries, moved)
    )
    _finite(geometries, names, f" in {crs.name}")
    _where_used(geometries, crs, names)
    return geometries


def _where_used(geometries: NDArray[Any], crs: pyproj.CRS, names: Callable[[int], str]) -> None:
    """Refuse what lies far from where a coordinate system is used: its numbers are others, or swapped."""
    area = crs.area_of_use
    if area is None or area.west > area.east:
        return
    bounds = shapely.bounds(geometries)
    low, high = (area.west - MARGIN, area.south - MARGIN), (area.east + MARGIN, area.north + MARGIN)
    bad = np.flatnonzero((bounds[:, :2] < low).any(axis=1) | (bounds[:, 2:] > high).any(axis=1))
    if len(bad):
        x, y = bounds[bad[0], :2]
        raise InputError(
            f"{names(int(bad[0]))}: expected coordinates in {crs.name}, used in {area.name:.60}, "
            f"but that would put it at {y:.4f}, {x:.4f}"
        )


def densified(geometry: Any, step: float) -> Any:
    """Return a geometry with corners added to edges longer than a step; nothing else about it changes."""
    x0, y0, x1, y1 = geometry.bounds
    if geometry.is_empty or max(x1 - x0, y1 - y0) <= step or isinstance(geometry, Point):
        return geometry
    if isinstance(geometry, Polygon):
        return Polygon(_stepped(geometry.exterior, step), [_stepped(ring, step) for ring in geometry.interiors])
    if isinstance(geometry, LineString):
        return LineString(_stepped(geometry, step))
    return type(geometry)([densified(part, step) for part in geometry.geoms])


def _stepped(line: LineString, step: float) -> NDArray[np.float64]:
    places = shapely.get_coordinates(line, include_z=line.has_z)
    counts = np.maximum(1, np.ceil(np.hypot(*np.diff(places[:, :2], axis=0).T) / step)).astype(np.int64)
    edge = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[edge]
    between = places[edge] + share[:, None] * (places[edge + 1] - places[edge])
    return np.vstack([between, places[-1:]])


def _any_z(geometries: NDArray[Any]) -> bool:
    return bool(np.any(shapely.has_z(geometries)))


def _sensible(geometries: NDArray[Any], step: float) -> float:
    """Return a step that does not end in millions of corners."""
    bounds = shapely.total_bounds(geometries)
    across = float(np.max(bounds[2:] - bounds[:2])) if np.all(np.isfinite(bounds)) else 0.0
    return max(step, across / 1e5)


def _finite(geometries: NDArray[Any], names: Callable[[int], str], system: str = "") -> None:
    places, owner = shapely.get_coordinates(geometries, return_index=True)
    bad = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if len(bad):
        raise InputError(f"{names(int(owner[bad[0]]))}: expected coordinates on the globe{system}, found others")


def _in_range(geometries: NDArray[Any], names: Callable[[int], str]) -> None:
    _finite(geometries, names)
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


def polygons(
    geometry: BaseGeometry,
    where: str,
    tell: Tell,
    *,
    radius: float | None = None,
    buffer: float | None = None,
    lenient: bool = False,
) -> list[Polygon]:
    """Return the polygons that cover a geometry in longitude and latitude; lines and points need a width.

    Parameters
    ----------
    radius
        Of a point, metres.
    buffer
        Around lines and points, metres.
    lenient
        Leave out, and tell, outlines without an area; without it they are refused.
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
        return sound(whole, where, tell, lenient=lenient)
    if isinstance(geometry, Point):
        width = radius if radius is not None else buffer
        if width is None:
            raise InputError(f"{where}: expected a polygon, found a point without a radius; --buffer gives it one")
        return around(geometry, width, where)
    if isinstance(geometry, LineString):
        if buffer is None:
            raise InputError(f"{where}: expected a polygon, found a line; --buffer gives it a width")
        return around(geometry, buffer, where)
    raise InputError(f"{where}: expected a polygon, found a {geometry.geom_type}")


def around(line: LineString | Point, metres: float, where: str) -> list[Polygon]:
    """Return what lies within metres of a point or line, which is straight in longitude and latitude; a little wider.

    It is drawn in planes that touch the Earth, where no two places are farther apart than on the ground.
    """
    places = shapely.get_coordinates(line)
    if len(places) > 1:
        places = _stepped(LineString(unwrapped(places, where)), EDGE)
    lengths = np.hypot(*np.diff(places, axis=0).T)
    piece = np.floor((np.cumsum(lengths) - lengths) / PIECE)
    ends = np.flatnonzero(np.diff(piece)) + 1
    first, last = [0, *ends.tolist()], [*ends.tolist(), len(places) - 1]
    bands = [_band(places[a : b + 1], metres, where) for a, b in zip(first, last, strict=True)]
    return pieces(shapely.union_all(bands)) if len(bands) > 1 else bands


def _band(places: NDArray[np.float64], metres: float, where: str) -> Polygon:
    x, y = ((places.min(axis=0) + places.max(axis=0)) / 2).tolist()
    plane = pyproj.Proj(f"+proj=ortho +lat_0={y!r} +lon_0={x!r} +ellps=WGS84")
    flat = np.column_stack(plane(places[:, 0], places[:, 1]))
    reach = metres + float(np.ptp(flat, axis=0).max())
    slack = min(SLACK, 3e-4 * reach)
    width = (metres + slack) / math.cos(math.pi / SIDES)
    # edge by edge, as GEOS loses most of what lies along a line that goes back on itself
    edges = np.stack([flat[:-1], flat[1:]], axis=1) if len(flat) > 1 else np.stack([flat, flat], axis=1)
    wide = shapely.union_all(shapely.buffer(shapely.linestrings(edges), width, quad_segs=SIDES // 4))
    steepest = math.tan(math.radians(min(abs(y) + reach / 1.1e5, 89.99)))
    band = shapely.transform(
        shapely.segmentize(wide, STEP / math.sqrt(max(1.0, steepest))),
        lambda a, b: plane(a, b, inverse=True),
        interleaved=False,
    )
    return in_one_piece(band, where, beside=x)


def sound(polygon: Polygon, where: str, tell: Tell, *, lenient: bool = False) -> list[Polygon]:
    """Return a polygon as it is if it is valid; else polygons that cover all that it winds around."""
    if polygon.is_valid and polygon.area > 0:
        return [shapely.remove_repeated_points(polygon)]
    outer = filled(np.array(polygon.exterior.coords)[:, :2])
    if outer.is_empty:
        found = f"an outline of {_corners(polygon)} corners without an area"
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


def _corners(polygon: Polygon) -> int:
    return len({(x, y) for x, y, *_ in polygon.exterior.coords})


def filled(ring: NDArray[np.float64]) -> MultiPolygon | Polygon:
    """Return all that a closed ring (n, 2) encloses, by whichever rule, however it crosses itself."""
    loop = ring[np.concatenate([[True], np.any(np.diff(ring, axis=0) != 0, axis=1)])]
    if len(loop) < 4:
        return Polygon()
    if not np.array_equal(loop[0], loop[-1]):
        loop = np.vstack([loop, loop[:1]])
    edges = shapely.union_all(shapely.linestrings(np.stack([loop[:-1], loop[1:]], axis=1)))
    faces = pieces(shapely.polygonize(shapely.get_parts(edges)))
    inside = [face for face in faces if _winds(loop, np.array(face.representative_point().coords[0]))]
    return _flat(shapely.union_all([*inside, *pieces(shapely.make_valid(Polygon(loop)))]))


def _flat(geometry: BaseGeometry) -> MultiPolygon | Polygon:
    return MultiPolygon(pieces(geometry)) if pieces(geometry) else Polygon()


def _winds(loop: NDArray[np.float64], place: NDArray[np.float64]) -> bool:
    """Tell whether a closed ring (n, 2) winds around a place."""
    a, b = loop[:-1] - place, loop[1:] - place
    side = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    up = (a[:, 1] <= 0) & (b[:, 1] > 0) & (side > 0)
    down = (a[:, 1] > 0) & (b[:, 1] <= 0) & (side < 0)
    return bool(np.count_nonzero(up) != np.count_nonzero(down))
