"""CityJSON 1.0 to 2.0: each object becomes the ground below its surfaces, from its lowest to its highest corner.

Source: https://www.cityjson.org/specs/
"""

import math
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyproj
import shapely
from numpy.typing import NDArray
from shapely import GeometryCollection, LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy, Sentence, printable, shown
from skyverse.maps.georeference.altitude_limits import GIVE_UNIT, METRES_PER_LIMIT_UNIT
from skyverse.maps.georeference.coordinate_systems import named_crs, to_globe, unit_of_heights
from skyverse.maps.georeference.feature import Feature, Fields, are_numbers, require_type
from skyverse.maps.georeference.reading import GIVE_AMSL, GIVE_CRS, Choices
from skyverse.maps.readers.dimensions import building_limits
from skyverse.maps.readers.polygons import filled, polygons
from skyverse.model.altitude import AboveSea, Altitude

_LIST_DEPTH = {"MultiSurface": 0, "CompositeSurface": 0, "Solid": 1, "MultiSolid": 2, "CompositeSolid": 2}
"""How many lists there are around the surfaces of each type of geometry."""
_POINTS_AND_LINES = ("MultiPoint", "MultiLineString")
_TEMPLATE_INSTANCE = "GeometryInstance"
KIND_OF_TYPE = {
    **dict.fromkeys(("Building", "BuildingPart", "BuildingInstallation", "BuildingConstructiveElement"), "building"),
    **dict.fromkeys(("Bridge", "BridgePart", "BridgeInstallation"), "bridge"),
    **dict.fromkeys(("BridgeConstructionElement", "BridgeConstructiveElement"), "bridge"),
    "OtherConstruction": "construction",
    "CityFurniture": "furniture",
    "SolitaryVegetationObject": "tree",
    "PlantCover": "vegetation",
}
"""The kind of each type of object that is an obstacle; others lie on the ground, below it or inside."""
_HALF_WALL = 0.02
"""Half the thickness, metres, of a wall that stands outside of all roofs and floors."""


def buildings(document: dict[str, Any], path: Path, choices: Choices) -> list[Feature]:
    """Return each object of `KIND_OF_TYPE` that has a geometry: the most detailed one, or that of `choices.lod`.

    Raises
    ------
    InputError
        If the document is not valid CityJSON, or does not say its coordinate system.
    """
    if str(document.get("version")) not in ("1.0", "1.1", "2.0"):
        raise InputError(f"{path}: expected CityJSON 1.0, 1.1 or 2.0, found version {shown(document.get('version'))}")
    vertices, templates = _vertices(document, path), _templates(document, path)
    crs, unit = _system(document, path, choices)
    objects = require_type(dict, document.get("CityObjects"), f"{path}: 'CityObjects'", "objects by name")
    bodies: list[_Body] = []
    others: Counter[str] = Counter()
    for name, one in objects.items():
        where = f"{path}: {printable(name)}"
        if _type(require_type(dict, one, where, "an object")) not in KIND_OF_TYPE:
            if one.get("geometry"):
                others[f"{printable(_type(one)):.40}"] += 1
            continue
        solid = _solid(one, vertices, templates, where, choices)
        if solid is None:
            continue
        attributes = require_type(dict, one.get("attributes") or {}, f"{where}: 'attributes'", "fields")
        kind = KIND_OF_TYPE[_type(one)]
        kind = choices.kind or kind if kind == "building" else kind
        bodies.append(_Body(where, printable(name), kind, attributes, *solid))
    if others:
        named = ", ".join(f"{number:,} {kind}" for kind, number in others.most_common())
        choices.tally[Sentence(f"left out, which are no obstacles or of unknown type: {named}")] += others.total()
    if not bodies:
        raise InputError(f"{path}: expected buildings with surfaces, found none")
    outlines = np.array([body.footprint for body in bodies], dtype=object)
    moved = to_globe(outlines, crs, str(path), lambda k: bodies[k].where, choices.tell)
    return [
        feature
        for body, place in zip(bodies, moved, strict=True)
        for feature in _features(body, place, (body.low * unit, body.high * unit), choices)
    ]


class _Body(NamedTuple):
    """What an object takes up: the ground below it, in the document's coordinates, and its least and greatest z."""

    where: str
    name: str
    kind: str
    attributes: dict[str, Any]
    footprint: BaseGeometry
    low: float
    high: float


def _features(body: _Body, place: BaseGeometry, span: tuple[float, float], choices: Choices) -> Iterator[Feature]:
    """Yield the features of a body whose footprint on the globe and whose altitudes, metres, are given."""
    low: Altitude | None = AboveSea(span[0])
    high: Altitude = AboveSea(span[1])
    if not span[0] < span[1]:  # a flat footprint, level of detail 0
        try:
            low, high = building_limits(Fields(body.attributes), body.where, choices)
        except InputError:
            if body.kind in (KIND_OF_TYPE["Building"], choices.kind):
                raise
            choices.count(f"of kind {body.kind!r} left out, flat and without a height")
            return
    for part in polygons(place, body.where, choices.tell, buffer=choices.buffer, lenient=True):
        holes = tuple(np.array(ring.coords)[:-1] for ring in part.interiors)
        outline = np.array(part.exterior.coords)[:-1]
        yield Feature(outline, holes, low, high, body.kind, True, body.name, body.where, choices.risk)


def _vertices(document: dict[str, Any], path: Path) -> Floats:
    vertices = _threes(document.get("vertices"), f"{path}: 'vertices'")
    transform = document.get("transform")
    if transform is None:
        return vertices
    factors = [_three(transform, name, path) for name in ("scale", "translate")]
    return vertices * factors[0] + factors[1]


def _threes(listed: Any, where: str) -> Floats:
    if not isinstance(listed, list) or not all(are_numbers(row, (3,), 1e15) for row in listed):
        raise InputError(f"{where}: expected rows of three numbers")
    return np.array(listed, dtype=np.float64).reshape(-1, 3)


def _three(transform: Any, name: str, path: Path) -> Floats:
    three = transform.get(name) if isinstance(transform, dict) else None
    if not are_numbers(three, (3,), 1e12):
        raise InputError(f"{path}: 'transform.{name}': expected three numbers, found {shown(three)}")
    return np.array(three, dtype=np.float64)


def _system(document: dict[str, Any], path: Path, choices: Choices) -> tuple[pyproj.CRS, float]:
    """Return a document's coordinate system, and how many metres a unit of z has."""
    metadata = require_type(dict, document.get("metadata") or {}, f"{path}: 'metadata'", "fields")
    said = metadata.get("referenceSystem") or metadata.get("crs") or document.get("crs")
    if isinstance(said, dict):  # CityJSON before 1.0: {"epsg": 7415}
        said = f"EPSG:{said.get('epsg')}"
    where = f"{path}: 'metadata.referenceSystem'"
    if said is None:
        if choices.crs is None:
            raise InputError(f"{where}: expected a coordinate system, found none", give=[GIVE_CRS])
        said, where = choices.crs, str(path)
    said = require_type(str, said, where, "a coordinate system")
    crs = named_crs(said.replace("https://", "http://", 1) if "/def/crs/" in said else said, where)
    vertical = unit_of_heights(crs, where)
    if vertical is not None and not vertical[1]:
        return crs, vertical[0]
    if vertical is not None:
        raise InputError(
            f"{where}: expected altitudes above mean sea level, but those of {crs.name} are ellipsoidal; "
            "convert them to a system above the sea, such as EPSG:4326+3855"
        )
    if choices.altitudes != "amsl":
        raise InputError(f"{where}: {crs.name} says nothing of altitudes", give=[GIVE_AMSL])
    if choices.unit is None and crs.is_projected and crs.axis_info[0].unit_conversion_factor != 1:
        raise InputError(f"{where}: {crs.name} is not in metres, and altitudes have no unit", give=GIVE_UNIT)
    return crs, METRES_PER_LIMIT_UNIT[choices.unit or "m"]


def _solid(
    one: dict[str, Any], vertices: Floats, templates: list[tuple[dict[str, Any], Floats]], where: str, choices: Choices
) -> tuple[BaseGeometry, float, float] | None:
    """Return what lies under all surfaces, or, where there are none, points and lines; and the least and greatest z."""
    geometries = one.get("geometry") or []
    if not isinstance(geometries, list) or not all(isinstance(geometry, dict) for geometry in geometries):
        raise InputError(f"{where}: 'geometry': expected a list of geometries, found {shown(geometries)}")
    placed = [
        _placed(geometry, vertices, templates, where) if _type(geometry) == _TEMPLATE_INSTANCE else (geometry, vertices)
        for geometry in geometries
    ]
    if choices.lod is not None:
        known, asked = (*_LIST_DEPTH, *_POINTS_AND_LINES), float(choices.lod)
        placed = [pair for pair in placed if _type(pair[0]) in known and _lod(pair[0], where) == asked]
    level = f" of level {choices.lod}" if choices.lod is not None else ""
    usable = [pair for pair in placed if _type(pair[0]) in _LIST_DEPTH]
    if not usable:
        thin = [pair for pair in placed if _type(pair[0]) in _POINTS_AND_LINES]
        if thin and choices.buffer is not None:
            return _points_and_lines(thin, choices.buffer, where)
        if thin:
            choices.count(
                f"of type {_type(one)!r} left out, points or lines{level}",
                Remedy("Reading.buffer", None, "to give them a width"),
            )
        elif geometries or not one.get("children"):
            if _type(one).startswith("Building"):
                choices.tell(f"{where}: left out, it has no surfaces{level}")
            else:
                choices.count(f"of type {_type(one)!r} left out, without surfaces{level}")
        return None
    best = max(_lod(geometry, where) for geometry, _ in usable)
    surfaces = [
        [places[ring] for ring in rings]
        for geometry, places in usable
        if _lod(geometry, where) == best
        for rings in _rings(geometry.get("boundaries"), _LIST_DEPTH[_type(geometry)], len(places), where)
    ]
    if not surfaces:
        choices.tell(f"{where}: left out, it has no surfaces")
        return None
    z = np.concatenate([ring[:, 2] for rings in surfaces for ring in rings])
    return _ground_below([[ring[:, :2] for ring in rings] for rings in surfaces]), float(z.min()), float(z.max())


def _points_and_lines(
    usable: list[tuple[dict[str, Any], Floats]], buffer: float, where: str
) -> tuple[BaseGeometry, float, float] | None:
    """Return points and lines, and the z that their buffer, metres, reaches down and up to."""
    parts: list[BaseGeometry] = []
    z: list[float] = []
    for geometry, places in usable:
        lines = geometry.get("boundaries")
        for line in [lines] if _type(geometry) == "MultiPoint" else lines if isinstance(lines, list) else [None]:
            corners = places[_ring(line, 1, len(places), where)]
            z += corners[:, 2].tolist()
            if _type(geometry) == "MultiPoint" or len(corners) == 1:
                parts += [Point(corner) for corner in corners[:, :2]]
            else:
                parts.append(LineString(corners[:, :2]))
    return (GeometryCollection(parts), min(z) - buffer, max(z) + buffer) if z else None


def _templates(document: dict[str, Any], path: Path) -> list[tuple[dict[str, Any], Floats]]:
    """Return the geometries that objects may share, each with its vertices around zero."""
    held = document.get("geometry-templates")
    if held is None:
        return []
    where = f"{path}: 'geometry-templates'"
    listed = held.get("templates") if isinstance(held, dict) else None
    if not isinstance(listed, list) or not all(isinstance(geometry, dict) for geometry in listed):
        raise InputError(f"{where}: expected 'templates', found {shown(held)}")
    places = _threes(held.get("vertices-templates"), f"{where}: 'vertices-templates'")
    return [(geometry, places) for geometry in listed]


def _placed(
    instance: dict[str, Any], vertices: Floats, templates: list[tuple[dict[str, Any], Floats]], where: str
) -> tuple[dict[str, Any], Floats]:
    """Return the geometry of a template, and its vertices turned, scaled and moved to where the object stands."""
    number, at = instance.get("template"), instance.get("boundaries")
    if type(number) is not int or not 0 <= number < len(templates):
        raise InputError(f"{where}: 'template': expected one of {len(templates)} templates, found {shown(number)}")
    if not isinstance(at, list) or len(at) != 1 or type(at[0]) is not int or not 0 <= at[0] < len(vertices):
        raise InputError(f"{where}: 'boundaries': expected the vertex of a template, found {shown(at)}")
    matrix: Any = instance.get("transformationMatrix")
    if not are_numbers(matrix, (16,), 1e12) or matrix[12:] != [0, 0, 0, 1]:
        what = f"{where}: 'transformationMatrix'"
        raise InputError(f"{what}: expected 16 numbers, 0, 0, 0, 1 last, found {shown(matrix)}")
    geometry, places = templates[number]
    turned = np.array(matrix, dtype=np.float64).reshape(4, 4)[:3]
    return geometry, np.einsum("ij,kj->ik", places, turned[:, :3]) + turned[:, 3] + vertices[at[0]]


def _type(holder: dict[str, Any]) -> str:
    return str(holder.get("type"))


def _lod(geometry: dict[str, Any], where: str) -> float:
    said = geometry.get("lod")
    with suppress(ValueError, OverflowError):
        if isinstance(said, str | int | float) and math.isfinite(float(said)):
            return float(said)
    raise InputError(f"{where}: 'lod': expected a level of detail such as 2.2, found {shown(said)}")


def _rings(boundaries: Any, depth: int, count: int, where: str) -> Iterator[list[NDArray[np.int64]]]:
    """Yield each surface as its rings, which are numbers of vertices."""
    for inner in require_type(list, boundaries, f"{where}: 'boundaries'", "lists of vertices"):
        if depth:
            yield from _rings(inner, depth - 1, count, where)
        else:
            yield [_ring(ring, 3, count, where) for ring in (isinstance(inner, list) and inner) or [None]]


def _ring(ring: Any, least: int, count: int, where: str) -> NDArray[np.int64]:
    good = isinstance(ring, list) and len(ring) >= least and all(type(n) is int and 0 <= n < count for n in ring)
    if not good:
        raise InputError(f"{where}: 'boundaries': expected lists of vertices, found {shown(ring)}")
    return np.array(ring, dtype=np.int64)


def _ground_below(surfaces: list[list[Floats]]) -> BaseGeometry:
    """Return the ground that lies below surfaces, each an outline and its holes (n, 2)."""
    flat = np.array([Polygon(rings[0], rings[1:]) for rings in surfaces], dtype=object)
    upright = shapely.area(shapely.convex_hull(flat)) < 1e-6
    level = shapely.is_valid(flat) & ~upright
    folded = [filled(np.array(polygon.exterior.coords)) for polygon in flat[~level & ~upright]]
    whole = shapely.union_all([*flat[level], *folded])
    walls = shapely.get_exterior_ring(flat[upright])
    near = whole.buffer(1e-3)
    shapely.prepare(near)
    beside = [LineString(wall.coords).difference(near) for wall in walls[~shapely.covers(near, walls)]]
    if beside:
        thick = shapely.buffer(beside, _HALF_WALL, cap_style="square", join_style="mitre")
        whole = shapely.union_all([whole, *thick])
    return whole
