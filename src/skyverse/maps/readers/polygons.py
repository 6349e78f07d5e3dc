"""Sound polygons on the globe that cover geometries as files have them, or a reason why there are none.

Outlines that cross the antimeridian are in one piece, with longitudes that continue beyond 180 degrees.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pyproj
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.maps.georeference.feature import Feature
from skyverse.model.shapes import FENCE

UNAMBIGUOUS_EDGE = 179.0
"""Degrees of longitude; an edge up to this long is read as it stands."""
CROSSING_EDGE = 90.0
"""Degrees; a longer edge crosses the antimeridian if the way across is at most this long, else it could be either."""
SCENARIO_REACH = 10.0
"""Degrees of latitude, and about as far east and west, that no scenario reaches away from its frame's origin."""


def unwrapped(places: Floats, where: str) -> Floats:
    """Return corners (n, 2), longitude and latitude, each of which lies the shorter way from the one before it.

    Raises
    ------
    InputError
        If an edge could run either way around the globe.
    """
    steps = np.diff(places, axis=0)
    turns = -np.round(steps[:, 0] / 360)
    short = steps[:, 0] + 360 * turns
    either = (np.abs(steps[:, 0]) > UNAMBIGUOUS_EDGE) & (np.abs(short) > CROSSING_EDGE)
    parallels = (turns != 0) & (short == 0) & (steps[:, 1] == 0)
    if parallels.any() and np.array_equal(places[0], places[-1]) and Polygon(places).is_valid:
        return places.copy()  # edges from -180 to 180 are whole parallels of an outline that is sound with them
    either |= parallels
    if either.any():
        wide = abs(steps[np.flatnonzero(either)[0], 0])
        raise InputError(
            f"{where}: expected edges that run one way around the globe, found one of {wide:g} degrees of longitude; "
            "give it corners between, or cut it at the antimeridian or pole"
        )
    result = places.copy()
    result[1:, 0] += 360 * np.cumsum(turns)
    return result


def in_one_piece(polygon: Polygon, where: str, beside: float | None = None) -> Polygon:
    """Return a polygon with all its edges unwrapped.

    Parameters
    ----------
    polygon
        Longitude and latitude, degrees.
    where
        The beginning of messages.
    beside
        The longitude that its middle is to be nearest to; its own when left out, counted from its first corner on.

    Raises
    ------
    InputError
        If the polygon goes around a pole, or an edge could run either way.
    """
    rings = [unwrapped(shapely.get_coordinates(ring), where) for ring in (polygon.exterior, *polygon.interiors)]
    if any(ring[0, 0] != ring[-1, 0] for ring in rings):
        raise InputError(f"{where}: its outline goes around a pole, which has no inside on a flat map")
    middle = _middle_of_ring(rings[0]) if beside is None else beside
    for ring in rings:
        ring[:, 0] += 360 * round((middle - _middle_of_ring(ring)) / 360)
    holes, whole = rings[1:], Polygon(rings[0])
    if np.ptp(rings[0][:, 0]) == 360:  # what leaves the globe on one side is in it on the other
        leaving = [Polygon(hole) for hole in holes if np.abs(hole[:, 0] - middle).max() > 180]
        inside = [_turned(hole, turns).intersection(whole) for hole in leaving for turns in (-1, 0, 1)]
        holes = [hole for hole in holes if np.abs(hole[:, 0] - middle).max() <= 180]
        holes += [shapely.get_coordinates(part.exterior) for one in inside for part in pieces(one)]
    return Polygon(rings[0], holes)


def _middle_of_ring(ring: Floats) -> float:
    return float(ring[:, 0].min() + ring[:, 0].max()) / 2


def joined(parts: list[Polygon]) -> list[Polygon]:
    """Return polygons that were cut at the antimeridian in one piece."""
    if len(parts) < 2:
        return parts
    bounds = shapely.bounds(np.array(parts, dtype=object))
    east, west = bounds[:, 2] >= 180 - 1e-9, bounds[:, 0] <= -180 + 1e-9
    if not (east & ~west).any() or not (west & ~east).any():
        return parts
    turned = [_turned(part, int(w and not e)) for part, e, w in zip(parts, east, west, strict=True)]
    return pieces(shapely.union_all(turned))


def _turned(polygon: Polygon, turns: int) -> Polygon:
    """Return a polygon with full turns of 360 degrees added to its longitudes."""
    moved: Polygon = shapely.transform(polygon, lambda places: places + np.array([360.0 * turns, 0.0]))
    return moved if turns else polygon


def pieces(geometry: BaseGeometry) -> list[Polygon]:
    """Return the polygons of a geometry that have an area."""
    if hasattr(geometry, "geoms"):
        return [piece for part in geometry.geoms for piece in pieces(part)]
    return [geometry] if isinstance(geometry, Polygon) and geometry.area > 0 else []


def features_around(features: Sequence[Feature], longitude: float, latitude: float) -> list[Feature]:
    """Return the parts of features within `SCENARIO_REACH` of a place; in a plane, others would fall on what is near.

    Parameters
    ----------
    features
        Features whose longitudes may continue beyond 180 degrees.
    longitude, latitude
        The place, degrees.
    """
    if not features:
        return []
    sizes = np.array([len(feature.outline) for feature in features])
    corners, starts = np.concatenate([feature.outline for feature in features]), np.cumsum(sizes) - sizes
    low, high = np.minimum.reduceat(corners, starts), np.maximum.reduceat(corners, starts)
    farthest = abs(latitude) + SCENARIO_REACH
    wide = 180.0 if farthest >= 85 else SCENARIO_REACH / math.cos(math.radians(farthest))
    frame = shapely.box(longitude - wide, latitude - SCENARIO_REACH, longitude + wide, latitude + SCENARIO_REACH)
    west, south, east, north = frame.bounds
    level = (low[:, 1] <= north) & (high[:, 1] >= south)
    inside = (low[:, 1] >= south) & (high[:, 1] <= north)
    turns = 360 * np.round((longitude - (low[:, 0] + high[:, 0]) / 2) / 360)
    inside &= (low[:, 0] + turns >= west) & (high[:, 0] + turns <= east)
    found = []
    for k in np.flatnonzero(level).tolist():
        found += [features[k]] if inside[k] else _cut(features[k], frame)
    return found


def _cut(feature: Feature, frame: Polygon) -> list[Feature]:
    """Return the parts of a feature in a frame of longitudes and latitudes, at every full turn that reaches it."""
    west, _, east, _ = frame.bounds
    low, high = feature.outline[:, 0].min(), feature.outline[:, 0].max()
    polygon = Polygon(feature.outline, feature.holes)
    turns = range(math.ceil((west - high) / 360), math.floor((east - low) / 360) + 1)
    parts = [part for turn in turns for part in pieces(_turned(polygon, turn).intersection(frame))]
    cut = []
    for part in shapely.segmentize(parts, 1.0):
        outline, holes = outline_and_holes(part)
        cut.append(replace(feature, outline=outline, holes=holes))
    return cut


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


def area_features(
    geometry: BaseGeometry,
    where: str,
    *,
    tell: Tell = lambda sentence: None,
    radius: float | None = None,
    buffer: float | None = None,
    outside: bool = False,
) -> list[Feature]:
    """Return areas that UAVs must stay in, of which none reaches beyond a geometry, or out of, which cover it.

    The parameters are as for `polygons`, and which of these they are.

    Raises
    ------
    InputError
        If an outline meets itself or a hole, or encloses nothing, or if a point or line has no width.
    """
    if not outside and not shapely.is_valid(shapely.get_parts([geometry])).all():
        raise InputError(f"{where}: expected an area to stay in, found an outline that meets itself or a hole")
    radius, buffer = (reach if outside or reach is None else _held(reach, where) for reach in (radius, buffer))
    found = polygons(geometry, where, tell, radius=radius, buffer=buffer)
    return [
        Feature(*outline_and_holes(part), None, None, FENCE, False, None, where)
        for part in shapely.segmentize(found, MAX_EDGE_DEGREES)
    ]


def _held(metres: float, where: str) -> float:
    """Return the width for which `band` reaches no farther than some metres."""
    held = metres * math.cos(math.pi / BUFFER_SIDES) * (1 - 5e-4) - BAND_SLACK
    if held <= 0:
        raise InputError(f"{where}: expected an area to stay in, found one that reaches {metres:g} m")
    return held


def outline_and_holes(polygon: Polygon) -> tuple[Floats, tuple[Floats, ...]]:
    """Return the corners (n, 2) of a polygon's outline and of each hole, the first not repeated."""
    outline, *holes = (shapely.get_coordinates(ring)[:-1] for ring in (polygon.exterior, *polygon.interiors))
    return outline, tuple(holes)


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
