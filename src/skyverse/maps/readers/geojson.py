"""GeoJSON, and the zones of ED-269 and ED-318, which are much like it; every part of a document is checked."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pyproj
import shapely
from shapely import GeometryCollection, LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from skyverse._typing import Floats
from skyverse.documents.json import read_json
from skyverse.documents.limits import read_bytes
from skyverse.errors import InputError, shown
from skyverse.maps.georeference.coordinate_systems import WGS84, named_crs
from skyverse.maps.georeference.feature import are_numbers, plain, require_type
from skyverse.maps.georeference.reading import Choices
from skyverse.maps.readers.dimensions import fields_of_standard_circle
from skyverse.maps.readers.record_to_feature import GeometryRecord

_WRAPPERS = ("uaszone", "verticallayer", "layer")
"""Plain names of properties whose own fields are those of a zone and of its limits, as national services write them."""


def load(path: Path) -> Any:
    """Return the data of a JSON file.

    Raises
    ------
    InputError
        If it is not JSON, holds NaN or infinity, is too large or nested too deeply, or an object has a field twice.
    """

    def no_number(text: str) -> NoReturn:
        raise InputError(f"{path}: expected numbers, found {text}")

    return read_json(read_bytes(path), path, constants=no_number)


def layers(path: Path, _: Choices) -> Iterator[tuple[list[GeometryRecord], pyproj.CRS]]:
    """Yield the features of a GeoJSON or ED-269 file as its only layer."""
    yield records(load(path), path)


def records(document: Any, path: Path) -> tuple[list[GeometryRecord], pyproj.CRS]:
    """Return the features of a GeoJSON or ED-269 document, and their coordinate system."""
    document = require_type(dict, document, str(path), "GeoJSON")
    crs = _crs(document.get("crs"), path)
    if document.get("type") in (*_SHAPES, "GeometryCollection"):
        return list(_feature({"geometry": document}, f"{path}: geometry")), crs
    if document.get("type") == "Feature":
        return list(_feature(document, f"{path}: feature")), crs
    listed = document.get("features")
    if not isinstance(listed, list) or document.get("type", "FeatureCollection") != "FeatureCollection":
        raise InputError(f"{path}: expected a GeoJSON FeatureCollection with 'features'")
    return [record for n, one in enumerate(listed, 1) for record in _feature(one, f"{path}: feature {n}")], crs


def _crs(said: Any, path: Path) -> pyproj.CRS:
    if said is None:
        return WGS84
    try:
        name = said["properties"]["name"]
    except (TypeError, KeyError, IndexError):
        name = None
    if not isinstance(name, str):
        raise InputError(f"{path}: 'crs': expected the name of a coordinate system, found {shown(said)}")
    return named_crs(name, f"{path}: 'crs'")


def _feature(feature: Any, where: str) -> Iterator[GeometryRecord]:
    feature = require_type(dict, feature, where, "a feature")
    fields = _unwrapped(require_type(dict, feature.get("properties") or {}, f"{where}: 'properties'", "fields"), where)
    if "geometry" not in feature:
        raise InputError(f"{where}: expected a 'geometry', found none")
    geometry = feature["geometry"]
    if isinstance(geometry, list):  # ED-269: a list of volumes, each with its limits
        own = {name: value for name, value in feature.items() if name != "geometry"}
        for k, volume in enumerate(geometry):
            yield _volume(volume, {**own, **fields}, f"{where}: geometry[{k}]")
        return
    if geometry is None:
        yield GeometryRecord(None, fields, where)
        return
    if "id" in feature and "id" not in fields and isinstance(feature["id"], str):
        fields = {**fields, "id": feature["id"]}
    yield from _layers(geometry, fields, where)


def _unwrapped(fields: dict[str, Any], where: str) -> dict[str, Any]:
    """Return fields with those that stand within one of `_WRAPPERS`, in its place."""
    found = {name: value for name, value in fields.items() if not _wraps(name, value)}
    for name, value in fields.items():
        for inner, held in value.items() if _wraps(name, value) else ():
            if inner in found and found[inner] != held:
                raise InputError(
                    f"{where}: {inner!r}: expected it once, found {shown(found[inner])} and {shown(held)} in {name!r}"
                )
            found[inner] = held
    return found


def _wraps(name: str, value: Any) -> bool:
    return isinstance(value, dict) and plain(name) in _WRAPPERS


def _volume(volume: Any, fields: dict[str, Any], where: str) -> GeometryRecord:
    flat = volume.get("horizontalProjection") if isinstance(volume, dict) else None
    if not isinstance(flat, dict):
        raise InputError(f"{where}: expected a 'horizontalProjection', found {shown(volume)}")
    said = fields | {name: value for name, value in volume.items() if name != "horizontalProjection"}
    if flat.get("type") == "Circle":
        point = Point(_position(flat.get("center"), f"{where}: 'center'"))
        if flat.get("radius") is None:
            raise InputError(f"{where}: expected a 'radius', found none")
        return GeometryRecord(point, said | fields_of_standard_circle(flat, said, "type", "center"), where)
    return GeometryRecord(_geometry(flat, where), said, where)


def _layers(geometry: Any, fields: dict[str, Any], where: str) -> Iterator[GeometryRecord]:
    """Yield a geometry as one record, or, where its parts have limits of their own (ED-318), each part as one."""
    parts = geometry.get("geometries") if isinstance(geometry, dict) else None
    if isinstance(parts, list) and any(
        isinstance(part, dict) and ("layer" in part or "extent" in part) for part in parts
    ):
        for k, part in enumerate(parts):
            yield from _layers(part, fields, f"{where}: geometries[{k}]")
        return
    own: dict[str, Any] = {}
    for name in ("layer", "extent"):
        said = geometry.get(name) if isinstance(geometry, dict) else None
        if said is not None:
            said = require_type(dict, said, f"{where}: {name!r}", "fields")
            own.update(said if name == "layer" else fields_of_standard_circle(said, {**fields, **own}, "subType"))
    yield GeometryRecord(_geometry(geometry, where), {**fields, **own}, where)


def _geometry(geometry: Any, where: str) -> BaseGeometry:
    kind = require_type(dict, geometry, where, "a geometry").get("type")
    if kind == "GeometryCollection":
        parts = _listed(geometry.get("geometries"), f"{where}: 'geometries'")
        return GeometryCollection([_geometry(part, where) for part in parts])
    if not isinstance(kind, str) or kind not in _SHAPES:
        raise InputError(f"{where}: expected a polygon, found a geometry of type {shown(kind)}")
    coordinates = _listed(geometry.get("coordinates"), f"{where}: 'coordinates'")
    if not coordinates:
        return Polygon()
    return _SHAPES[kind](coordinates, where)


def _listed(value: Any, place: str) -> list[Any]:
    return require_type(list, value, place, "a list")


def _position(value: Any, where: str) -> list[float]:
    """Return longitude and latitude, and the altitude where there is one."""
    if not are_numbers(value, range(2, 5), 1e12):
        raise InputError(f"{where}: expected longitude and latitude, found {shown(value)}")
    return [float(v) for v in value[:3]]


def _line(value: Any, where: str) -> Floats:
    places = [_position(one, where) for one in _listed(value, where)]
    size = min((len(place) for place in places), default=2)
    return np.array([place[:size] for place in places]).reshape(-1, size)


def polygon(rings: Any, where: str) -> Polygon:
    """Return the polygon of an outline and holes; they need not be closed."""
    lines = [_line(ring, where) for ring in _listed(rings, where)]
    if not any(len(line) for line in lines):
        return Polygon()
    for line in lines:
        if len(line) < 3:
            raise InputError(f"{where}: expected an outline of three corners or more, found {len(line)}")
    size = min(line.shape[1] for line in lines)
    return Polygon(lines[0][:, :size], [line[:, :size] for line in lines[1:]])


def _string(value: Any, where: str) -> LineString:
    line = _line(value, where)
    if len(line) < 2:
        raise InputError(f"{where}: expected a line of two places or more, found {len(line)}")
    return LineString(line)


_SHAPES: dict[str, Callable[[Any, str], BaseGeometry]] = {
    "Polygon": polygon,
    "MultiPolygon": lambda value, where: MultiPolygon(
        [part for part in (polygon(rings, where) for rings in value) if not part.is_empty]
    ),
    "Point": lambda value, where: Point(_position(value, where)),
    "MultiPoint": lambda value, where: shapely.multipoints([_position(one, where)[:2] for one in value]),
    "LineString": _string,
    "MultiLineString": lambda value, where: shapely.multilinestrings([_string(one, where) for one in value]),
}
