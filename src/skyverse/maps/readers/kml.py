"""KML and KMZ: placemarks with polygons, and what their altitudes are counted from."""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any
from xml.etree.ElementTree import Element

import pyproj
import shapely
from shapely import GeometryCollection, LineString, Point
from shapely.geometry.base import BaseGeometry

from skyverse.documents.kmz import unpacked
from skyverse.documents.xml import read_tree
from skyverse.errors import InputError, unreadable
from skyverse.maps.georeference.coordinate_systems import WGS84
from skyverse.maps.georeference.reading import Choices
from skyverse.maps.readers.geojson import polygon
from skyverse.maps.readers.record_to_feature import GeometryRecord

_GEOMETRIES = ("Polygon", "Point", "LineString", "LinearRing")
_REFUSED_GEOMETRIES = ("Track", "MultiTrack", "Model")
_ALTITUDE_MODES = ("clampToGround", "relativeToGround", "absolute")


def layers(path: Path, _: Choices) -> Iterator[tuple[list[GeometryRecord], pyproj.CRS]]:
    """Yield the placemarks of a KML or KMZ file as its only layer."""
    yield records(path), WGS84


def records(path: Path) -> list[GeometryRecord]:
    """Return the placemarks of a KML or KMZ file, several records for one whose parts count altitudes differently."""
    with unreadable(path), _opened(path) as stream:
        root = read_tree(stream, path)
    if next(root.iter("NetworkLink"), None) is not None:
        raise InputError(f"{path}: expected zones, found a NetworkLink to others; give those files themselves")
    timed: dict[Element, list[dict[str, str]]] = {}
    for holder in root.iter():
        for mark in holder.iter("Placemark") if (times := _times(holder)) else ():
            timed.setdefault(mark, []).extend(times)
    marks = [(mark, f"{path}: placemark {number}") for number, mark in enumerate(root.iter("Placemark"), 1)]
    return [record for mark, where in marks for record in _placemark(mark, where, timed.get(mark, []))]


def _times(holder: Element) -> list[dict[str, str]]:
    """Return the times of an element, which hold of all that is in it, by the names of what they are."""
    spans = [*holder.findall("TimeSpan"), *holder.findall("TimeStamp")]
    return [{part.tag: (part.text or "").strip() for part in span} for span in spans]


def _opened(path: Path) -> IO[bytes]:
    stream = path.open("rb")
    if path.suffix.lower() != ".kmz":
        return stream

    def choose(names: list[str]) -> list[str]:
        found = [name for name in names if name.lower().endswith(".kml")]
        if not found:
            raise InputError(f"{path}: expected a .kml file inside, found none")
        return ["doc.kml" if "doc.kml" in found else found[0]]

    with stream:
        (content,) = unpacked(stream, path, choose).values()
    return io.BytesIO(content)


def _placemark(mark: Element, where: str, times: list[dict[str, str]]) -> Iterator[GeometryRecord]:
    fields: dict[str, Any] = {"TimeSpan": times, **_fields(mark, where)}
    groups: dict[tuple[str, bool], list[BaseGeometry]] = {}
    for shape in _shapes(mark, where):
        mode = _text(shape, "altitudeMode") or "clampToGround"
        if mode not in _ALTITUDE_MODES:
            raise InputError(f"{where}: 'altitudeMode': expected {', '.join(_ALTITUDE_MODES)}, found {mode!r:.40}")
        extruded = _text(shape, "extrude") in ("1", "true")
        groups.setdefault((mode, extruded), []).append(_geometry(shape, where))
    if not groups:
        yield GeometryRecord(None, fields, where)
    for (mode, extruded), parts in groups.items():
        whole: BaseGeometry = parts[0] if len(parts) == 1 else GeometryCollection(parts)
        if mode == "clampToGround":
            whole = shapely.force_2d(whole)
        yield GeometryRecord(whole, fields, where, "amsl" if mode == "absolute" else "agl", not extruded)


def _fields(mark: Element, where: str) -> dict[str, str]:
    """Return the name of a placemark and its data."""
    name = mark.find("name")
    fields = {} if name is None else {"name": (name.text or "").strip()}
    for one in mark.iter():
        key = one.get("name") if one.tag in ("Data", "SimpleData") else None
        if key is None:
            continue
        text = _text(one, "value") if one.tag == "Data" else (one.text or "").strip()
        before = fields.get(key, text)
        if before != text and key != "name":  # a placemark has a name beside that in its data
            raise InputError(f"{where}: field {key!r:.40}: expected it once, found {before!r:.40} and {text!r:.40}")
        fields[key] = text
    return fields


def _text(element: Element, tag: str) -> str:
    """Return the text of the last element of that name inside another, ``""`` where there is none."""
    return next((one.text or "" for one in reversed(list(element.iter(tag)))), "").strip()


def _shapes(parent: Element, where: str) -> Iterator[Element]:
    """Yield the elements of polygons, points and lines, also of those that stand in a MultiGeometry."""
    for child in parent:
        if child.tag in _REFUSED_GEOMETRIES:
            raise InputError(f"{where}: expected a polygon, found a {child.tag}")
        if child.tag in _GEOMETRIES:
            yield child
        else:
            yield from _shapes(child, where)


def _geometry(shape: Element, where: str) -> BaseGeometry:
    side = next((one.tag for one in shape.iter() if one.tag in ("outerBoundaryIs", "innerBoundaryIs")), None)
    if side == "innerBoundaryIs":
        raise InputError(f"{where}: expected an outline before its holes, found a hole")
    rings = [[_place(one, where) for one in (ring.text or "").split()] for ring in shape.iter("coordinates")]
    if shape.tag == "Polygon":
        return polygon(rings, where)
    line = next((ring for ring in rings if ring), [])
    if not line:
        return GeometryCollection()
    if shape.tag == "Point":
        return Point(line[0])
    if len(line) < 2:
        raise InputError(f"{where}: expected a line of two places or more, found {len(line)}")
    return LineString([place[: min(len(one) for one in line)] for place in line])


def _place(text: str, where: str) -> list[float]:
    try:
        numbers = [float(one) for one in text.split(",")]
    except ValueError:
        numbers = []
    if not 2 <= len(numbers) <= 3 or not all(abs(number) < 1e12 for number in numbers):
        raise InputError(f"{where}: 'coordinates': expected longitude,latitude[,altitude], found {text!r:.40}")
    return numbers
