"""What surveys see, from files: areas and lines on the globe, and as regions and points of a local frame."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy, path_of, require_file, require_kind
from skyverse.maps.georeference.coordinate_systems import to_globe
from skyverse.maps.georeference.feature import SWAPPED
from skyverse.maps.georeference.reading import Choices
from skyverse.maps.readers import AREA_SUFFIXES, read_layers
from skyverse.maps.readers.polygons import Tell, in_one_piece, pieces, unwrapped
from skyverse.maps.readers.record_to_feature import GeometryRecord
from skyverse.model.frame import MAX_FAR, Origin
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.shapes import Region
from skyverse.model.short_lines import listed

HAIRLINE = 0.1
"""Metres: an outline that is nowhere wider is a mistake, not an area."""
SHRUNK = 0.01
"""Metres by which a hole that touches an outline is smaller all around, so that all of the ground beside it is seen."""
SAME_PLACE = 1e-3
"""Metres: corners that are nearer to each other are one."""
MOST_NAMED = 5
"""Things that are left out of a file and named."""
LONGEST_EDGE = 0.02
"""Degrees; longer edges get corners between, as a straight edge in a file is not quite straight on the map."""


def read_area(
    path: str | Path, origin: Origin, *, crs: str | None = None, tell: Tell = lambda said: None
) -> tuple[Region, ...]:
    """Read the area of a survey: all polygons of a file, with their holes; those that overlap become one part.

    Parameters
    ----------
    path
        KML, KMZ, GeoJSON, Shapefile, GeoPackage or FlatGeobuf. Points and lines in it do not count.
    origin
        Where the zero of the scenario's frame lies.
    crs
        The coordinate system of a file that does not say it, such as ``"EPSG:2056"``.
    tell
        Called with a sentence that names what of the file does not count, if anything.

    Returns
    -------
    tuple of Region
        For the `area` of a `Survey`, metres.

    Raises
    ------
    InputError
        If the file holds no polygon; if an outline crosses or touches itself, encloses nothing, is a hairline, goes
        around a pole or could run either way around the globe; or if a corner is farther than 90 km from the origin.
    """
    require_kind(origin, Origin, "origin")
    parts = []
    for polygon, where in read_shapes(path, crs, Polygon, tell=tell):
        whole = in_one_piece(polygon, where, beside=origin.longitude)
        rings = [
            local_places(_with_short_edges(ring, where), origin, where) for ring in (whole.exterior, *whole.interiors)
        ]
        parts += _without_holes(rings, origin, where)
    return _regions(parts)


def joined(parts: Iterable[Region]) -> tuple[Region, ...]:
    """Return the parts of an area, those that overlap as one, which several files may hold."""
    return _regions([Polygon(part.vertices, part.holes) for part in parts])


def read_lines(
    path: str | Path, origin: Origin, *, crs: str | None = None, tell: Tell = lambda said: None
) -> tuple[tuple[tuple[float, float], ...], ...]:
    """Read the lines of a file, each for the `line` of a `Survey`: x, y of its points, metres; see `read_area`."""
    require_kind(origin, Origin, "origin")
    found = []
    for line, where in read_shapes(path, crs, LineString, tell=tell):
        whole = shapely.segmentize(LineString(unwrapped(shapely.get_coordinates(line), where)), LONGEST_EDGE)
        local = LineString(local_places(shapely.get_coordinates(whole), origin, where))
        places = shapely.get_coordinates(shapely.remove_repeated_points(local, SAME_PLACE))
        if local.length <= HAIRLINE:
            raise InputError(f"{where}: expected a line, found one of {local.length:.2g} m")
        found.append(tuple((x, y) for x, y in places.tolist()))
    return tuple(found)


def read_shapes(
    path: str | Path, crs: str | None, *kinds: type[BaseGeometry], tell: Tell = lambda said: None
) -> list[tuple[Any, str]]:
    """Return the geometries of a file of some kinds, longitude and latitude in degrees, each with its name."""
    return [(shapely.force_2d(shape), record.where) for shape, record in read_records(path, crs, *kinds, tell=tell)]


def read_records(
    path: str | Path, crs: str | None, *kinds: type[BaseGeometry], tell: Tell = lambda said: None
) -> list[tuple[Any, GeometryRecord]]:
    """Return the geometries of `read_shapes`, with the z that the file has, each with the record that it stands in."""
    path = path_of(path)
    suffix = path.suffix.lower()
    if suffix not in AREA_SUFFIXES:
        known = f"({', '.join(AREA_SUFFIXES)})"
        raise InputError(f"{path}: expected a file of areas, lines or points {known}, found {suffix or 'no ending'!r}")
    require_file(path)
    found: list[tuple[Any, GeometryRecord]] = []
    others: list[tuple[Any, GeometryRecord]] = []
    try:
        for records, system in read_layers(path, Choices(crs=crs)):
            present = [one for one in records if one.geometry is not None and not one.geometry.is_empty]
            shapes, names = np.array([one.geometry for one in present], dtype=object), [one.where for one in present]
            moved = to_globe(shapes, system, str(path), names.__getitem__, lambda doubt: None)
            for record, geometry in zip(present, moved, strict=True):
                for part in _simple(geometry):
                    (found if isinstance(part, kinds) else others).append((part, record))
    except (shapely.errors.ShapelyError, RecursionError, MemoryError) as error:
        raise InputError(f"{path}: its geometries cannot be used: {error}") from None
    expected = " or ".join(_NOUNS[kind.__name__] for kind in kinds)
    if found and others:
        left = [f"{one.where.rpartition(': ')[2]} (a {_NOUNS[part.geom_type]})" for part, one in others]
        more = [f"{len(left) - MOST_NAMED} more"] if len(left) > MOST_NAMED else []
        tell(f"{path}: left out, no {expected}: {listed([*left[:MOST_NAMED], *more])}")
    if found:
        return found
    if not others:
        raise InputError(f"{path}: expected a {expected}, found nothing")
    part, where = others[0][0], others[0][1].where
    give = [Remedy("pattern", "corridor", "to follow it")] if isinstance(part, LineString) else []
    closed = ", which is closed: an area is drawn as a polygon" if getattr(part, "is_ring", False) else ""
    raise InputError(f"{where}: expected a {expected}, found a {_NOUNS[part.geom_type]}{closed}", give=give)


_NOUNS = {"Polygon": "polygon", "LineString": "line", "LinearRing": "line", "Point": "point"}


def _simple(geometry: BaseGeometry) -> Iterator[BaseGeometry]:
    """Yield the polygons, lines and points of a geometry, however deep they stand."""
    if hasattr(geometry, "geoms"):
        for part in geometry.geoms:
            yield from _simple(part)
    elif not geometry.is_empty:
        yield geometry


def local_places(places: Floats, origin: Origin, where: str) -> Floats:
    """Return longitudes and latitudes (n, 2) as x, y, and refuse what is too far away for a scenario."""

    def on_map(latitude: Floats, longitude: Floats) -> Floats:
        return to_local(origin, np.column_stack([latitude, longitude, np.full(len(places), origin.altitude)]))[:, :2]

    local = on_map(places[:, 1], places[:, 0])
    if np.abs(local).max() <= MAX_FAR:
        return local
    near = np.abs(places[:, 0]).max() <= 90 and np.abs(on_map(places[:, 0], places[:, 1])).max() <= MAX_FAR
    farthest = int(np.abs(local).max(axis=1).argmax())
    raise InputError(
        f"{where}: expected places within {MAX_FAR / 1000:g} km of the scenario's origin, found one at latitude "
        f"{places[farthest, 1]:.5f}, longitude {places[farthest, 0]:.5f}{SWAPPED if near else ''}"
    )


def _with_short_edges(ring: Any, where: str) -> Floats:
    """Return the corners of a ring, and some between; of a polygon, shapely would mend what is wrong with it."""
    places = shapely.get_coordinates(ring)
    if len(np.unique(places, axis=0)) < 3:
        raise InputError(f"{where}: expected an area, found an outline of fewer than three corners")
    return shapely.get_coordinates(shapely.segmentize(LineString(places), LONGEST_EDGE))


def _without_holes(rings: list[Floats], origin: Origin, where: str) -> list[Polygon]:
    """Return what lies in an outline and in none of its holes, whose rings are (n, 2) metres."""
    outline, *holes = (_sound(ring, origin, where) for ring in rings)
    for hole in holes:
        if not hole.intersects(outline):
            raise InputError(f"{where}: expected holes inside of its outline, found one outside")
    return pieces(outline.difference(shapely.union_all(holes)) if holes else outline)


def _sound(ring: Floats, origin: Origin, where: str) -> Polygon:
    """Return what a ring encloses, or raise `InputError` if it is no outline of an area, with the place."""
    polygon: Polygon = shapely.remove_repeated_points(Polygon(ring), SAME_PLACE)
    corners = len(np.unique(shapely.get_coordinates(polygon), axis=0))
    if corners < 3 or shapely.make_valid(polygon).area == 0:
        raise InputError(f"{where}: expected an area, found an outline of {corners} corners that encloses nothing")
    if not polygon.is_valid:
        x, y = map(float, shapely.is_valid_reason(polygon).rpartition("[")[2].rstrip("]").split())
        latitude, longitude, _ = to_wgs84(origin, [(x, y, 0.0)])[0].tolist()
        raise InputError(
            f"{where}: expected an outline that does not cross or touch itself, found that it does near latitude "
            f"{latitude:.6f}, longitude {longitude:.6f}"
        )
    if polygon.buffer(-HAIRLINE / 2).is_empty:
        raise InputError(f"{where}: expected an area, found a hairline that is nowhere wider than {HAIRLINE:g} m")
    return polygon


def _regions(parts: list[Polygon]) -> tuple[Region, ...]:
    return tuple(_region(part) for part in pieces(shapely.union_all(parts)))


def _region(part: Polygon) -> Region:
    """Return a region of a polygon, whose holes shrink where they touch its outline or one another."""
    outline, holes = Polygon(part.exterior), [Polygon(ring) for ring in part.interiors]
    rings = [outline.exterior, *(hole.exterior for hole in holes)]
    if any(one.intersects(other) for k, one in enumerate(rings) for other in rings[:k]):
        part = outline.difference(shapely.union_all([hole.buffer(-SHRUNK, join_style="mitre") for hole in holes]))
    corners, *inner = (tuple(map(tuple, ring.coords[:-1])) for ring in (part.exterior, *part.interiors))
    return Region(vertices=corners, holes=tuple(inner))


def corners_of(path: str | Path, crs: str | None = None) -> Floats:
    """Return the outermost corners of the areas and lines of a file, (n, 2) longitude and latitude, degrees."""
    places = shapely.get_coordinates([shape for shape, _ in read_shapes(path, crs, Polygon, LineString)])
    places[:, 0] = places[0, 0] + (places[:, 0] - places[0, 0] + 180) % 360 - 180  # also across the antimeridian
    outer = shapely.get_coordinates(shapely.MultiPoint(places).convex_hull)
    return np.column_stack([(outer[:, 0] + 180) % 360 - 180, outer[:, 1]])
