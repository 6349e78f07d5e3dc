"""OpenStreetMap: buildings and their parts, which are ways and multipolygon relations; their tags give the heights.

https://wiki.openstreetmap.org/wiki/Simple_3D_Buildings
"""

import json
import tempfile
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from skyverse._typing import Floats
from skyverse.documents.xml import parse
from skyverse.errors import InputError, printable, unreadable
from skyverse.maps.georeference.coordinate_systems import WGS84
from skyverse.maps.georeference.feature import Feature
from skyverse.maps.georeference.reading import Choices
from skyverse.maps.readers.polygons import filled
from skyverse.maps.readers.record_to_feature import GeometryRecord, features_of

_GDAL_RULES = """closed_ways_are_polygons=building,building:part
[points]
osm_id=no
[lines]
osm_id=no
[multilinestrings]
osm_id=no
[other_relations]
osm_id=no
[multipolygons]
osm_id=yes
all_tags=yes
tags_format=json
"""
"""Which objects GDAL reads as polygons from the binary format, with all their tags."""
_LEADING_BLANKS = b"\xef\xbb\xbf \t\r\n"


def buildings(path: Path, choices: Choices) -> list[Feature]:
    """Return the buildings of an extract; whether it is XML or binary, its content tells, not its suffix.

    A building whose corners are missing, as the extract's edge cuts it, is left out and told.

    Raises
    ------
    InputError
        If it is not OpenStreetMap, or a building has no height and `choices` have none for such buildings.
    """
    with unreadable(path), path.open("rb") as stream:
        head = stream.read(64)
    if path.suffix.lower() == ".pbf" and b"OSMHeader" not in head and not head.lstrip(_LEADING_BLANKS).startswith(b"<"):
        raise InputError(f"{path}: expected OpenStreetMap's binary format, found something else")
    choices = replace(choices, unit="m")  # here heights without a unit are metres, by definition
    records = list(_binary(path, choices) if b"OSMHeader" in head else _xml(path, choices))
    if not records:
        raise InputError(f"{path}: expected buildings, found none")
    return features_of(records, WGS84, str(path), choices)


def _is_building(tags: Mapping[str, Any]) -> bool:
    return any(tags.get(key, "no") != "no" for key in ("building", "building:part"))


@dataclass
class _Element:
    """A way or relation while it is read."""

    kind: str
    number: int
    tags: dict[str, str] = field(default_factory=dict)
    nodes: "array[int]" = field(default_factory=lambda: array("q"))
    ways: list[tuple[int, str]] = field(default_factory=list)


class _OsmParser:
    """What an extract holds, as far as buildings may need it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._element: _Element | None = None
        self._root = False
        self.numbers, self.longitudes, self.latitudes = array("q"), array("d"), array("d")
        self.ways: dict[int, _Element] = {}
        self.relations: list[_Element] = []

    def start(self, tag: str, said: Mapping[str, str]) -> None:
        if not self._root:
            if tag not in ("osm", "osmChange"):
                raise InputError(f"{self._path}: expected OpenStreetMap XML, found <{printable(tag)}>")
            self._root = True
        if tag == "node":
            if said.get("visible") == "false" or said.get("action") == "delete":
                return
            self.numbers.append(self._whole(said, "id", tag))
            self.longitudes.append(self._number(said, "lon", tag))
            self.latitudes.append(self._number(said, "lat", tag))
        elif tag in ("way", "relation"):
            self._element = _Element(tag, self._whole(said, "id", tag))
        elif self._element is None:
            return
        elif tag == "nd":
            self._element.nodes.append(self._whole(said, "ref", tag))
        elif tag == "member" and said.get("type") == "way":
            self._element.ways.append((self._whole(said, "ref", tag), said.get("role", "")))
        elif tag == "tag":
            self._element.tags[said.get("k", "")] = said.get("v", "")

    def end(self, tag: str) -> None:
        element = self._element
        if element is None or tag != element.kind:
            return
        self._element = None
        if tag == "way":
            self.ways[element.number] = element
        elif element.tags.get("type") == "multipolygon" and _is_building(element.tags):
            self.relations.append(element)

    def _number(self, said: Mapping[str, str], name: str, tag: str) -> float:
        try:
            number = float(said[name])
        except (KeyError, ValueError):
            number = float("nan")
        if not abs(number) <= 180:
            raise InputError(f"{self._path}: <{tag}>: {name!r}: expected degrees, found {said.get(name)!r:.40}")
        return number

    def _whole(self, said: Mapping[str, str], name: str, tag: str) -> int:
        text = said.get(name, "")
        if len(text) > 18 or not text.removeprefix("-").isdecimal():
            raise InputError(f"{self._path}: <{tag}>: {name!r}: expected a whole number, found {text!r:.40}")
        return int(text)


def _xml(path: Path, choices: Choices) -> Iterator[GeometryRecord]:
    parser = _OsmParser(path)
    with unreadable(path), path.open("rb") as stream:
        parse(stream, path, parser)
    order = np.argsort(np.array(parser.numbers), kind="stable")
    numbers = np.array(parser.numbers)[order]
    places = np.column_stack([np.array(parser.longitudes), np.array(parser.latitudes)])[order]

    def corners(way: _Element) -> Floats | None:
        """Return where a way's nodes are, or ``None`` if any is missing."""
        at = np.searchsorted(numbers, way.nodes)
        if not len(way.nodes) or not len(numbers) or (numbers[np.minimum(at, len(numbers) - 1)] != way.nodes).any():
            return None
        return places[at]

    for element in [*(way for way in parser.ways.values() if _is_building(way.tags)), *parser.relations]:
        where = f"{path}: {element.kind} {element.number}"
        if element.kind == "way":
            shape = _way(element, corners(element), where, choices)
        else:
            shape = _relation(element, parser.ways, corners)
        if isinstance(shape, str):
            choices.tell(f"{where}: left out, {shape}")
        else:
            yield GeometryRecord(shape, element.tags, where)


def _way(way: _Element, corners: Floats | None, where: str, choices: Choices) -> BaseGeometry | str:
    """Return the polygon of a way, or why there is none."""
    if corners is None:
        return "nodes of it are missing"
    if len(corners) < 4 and (len(corners) < 3 or way.nodes[0] == way.nodes[-1]):
        return "it has fewer than three corners"
    if way.nodes[0] != way.nodes[-1]:
        choices.tell(f"{where}: its outline is open; closed from its end to its beginning")
    return Polygon(corners)


def _relation(relation: _Element, ways: dict[int, _Element], corners: Any) -> BaseGeometry | str:
    """Return the area between the outer and the inner ways, or why there is none."""
    lines: dict[bool, list[LineString]] = {True: [], False: []}
    first: float | None = None
    for number, role in relation.ways:
        if role not in ("outer", "inner", ""):
            continue
        places = corners(ways[number]) if number in ways else None
        if places is None or len(places) < 2:
            if role == "inner":
                continue  # without the inner way its hole is filled
            return "ways or nodes of it are missing"
        first = places[0, 0] if first is None else first
        places = places + 360 * np.round((first - places) / 360) * (1, 0)  # ways meet on the antimeridian too
        lines[role == "inner"].append(LineString(places))
    if not lines[False]:
        return "it has no outer way"
    faces = [_closed(lines[inner]) for inner in (False, True)]
    if faces[0] is None:
        return "its outer ways do not close"
    return faces[0] if faces[1] is None else faces[0].difference(faces[1])


def _closed(lines: list[LineString]) -> BaseGeometry | None:
    """Return what lines enclose that meet at their ends; ``None`` if one does not."""
    if not lines:
        return None
    merged = shapely.line_merge(shapely.multilinestrings(lines))
    rings = shapely.get_parts(merged)
    if not all(ring.is_closed and len(ring.coords) >= 4 for ring in rings):
        return None
    return shapely.union_all([filled(np.array(ring.coords)) for ring in rings])


def _binary(path: Path, choices: Choices) -> Iterator[GeometryRecord]:
    from skyverse.maps.readers.vector_tables import table

    with tempfile.TemporaryDirectory() as folder:
        rules = Path(folder) / "osm.ini"
        rules.write_text(_GDAL_RULES)
        _, rows = table(path, "multipolygons", choices, CONFIG_FILE=str(rules))
    for shape, said in rows:
        tags = json.loads(said.get("all_tags") or "{}")
        if _is_building(tags):
            kind, number = ("way", said["osm_way_id"]) if said.get("osm_way_id") else ("relation", said.get("osm_id"))
            yield GeometryRecord(shape, tags, f"{path}: {kind} {number}")
