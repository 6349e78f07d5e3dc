"""KML and KMZ: placemarks with polygons, and what their altitudes are counted from."""

import io
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Any

import shapely
from shapely import GeometryCollection, LineString, Point
from shapely.geometry.base import BaseGeometry

from skyverse.errors import InputError
from skyverse.maps.georeference.fields import printable
from skyverse.maps.readers.geojson import polygon
from skyverse.maps.readers.record_to_feature import GeometryRecord
from skyverse.maps.readers.xml import parse

MAX_UNPACKED = 200_000_000
"""Bytes that a KMZ may unpack to at most."""
_GEOMETRIES = ("Polygon", "Point", "LineString", "LinearRing")
_REFUSED_GEOMETRIES = ("Track", "MultiTrack", "Model")
_ALTITUDE_MODES = ("clampToGround", "relativeToGround", "absolute")


def records(path: Path) -> list[GeometryRecord]:
    """Return the placemarks of a KML or KMZ file, several records for one whose parts count altitudes differently."""
    parser = _KmlParser(path)
    with _opened(path) as stream:
        parse(stream, path, parser.start, parser.end, parser.text)
    return parser.records


def _opened(path: Path) -> IO[bytes]:
    try:
        if path.suffix.lower() != ".kmz":
            return path.open("rb")
        with zipfile.ZipFile(path) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(".kml")]
            if not names:
                raise InputError(f"{path}: expected a .kml file inside, found none")
            first = "doc.kml" if "doc.kml" in names else names[0]
            with archive.open(first) as packed:
                content = packed.read(MAX_UNPACKED + 1)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        with path.open("rb") as stream:
            begun = stream.read(2) == b"PK"
        found = "it cut off or damaged" if begun else "something else"
        raise InputError(f"{path}: expected a KMZ archive, found {found}: {printable(str(error))}") from None
    if len(content) > MAX_UNPACKED:
        raise InputError(f"{path}: expected less than {MAX_UNPACKED / 1e6:g} MB when unpacked, found more")
    return io.BytesIO(content)


class _PartialGeometry:
    """A polygon, point or line while it is read."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.mode = "clampToGround"
        self.extruded = False
        self.rings: list[list[list[float]]] = []

    def geometry(self, where: str) -> BaseGeometry:
        rings = [ring for ring in self.rings if ring]
        if self.kind == "Polygon":
            return polygon(self.rings, where)
        if not rings:
            return GeometryCollection()
        if self.kind == "Point":
            return Point(rings[0][0])
        if len(rings[0]) < 2:
            raise InputError(f"{where}: expected a line of two places or more, found {len(rings[0])}")
        return LineString([place[: min(len(one) for one in rings[0])] for place in rings[0]])


class _KmlParser:
    """The state of the parser within a KML file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.records: list[GeometryRecord] = []
        self._fields: dict[str, Any] | None = None
        self._shapes: list[_PartialGeometry] = []
        self._inside: list[str] = []
        self._key: str | None = None
        self._text: list[str] = []
        self._count = 0

    @property
    def _where(self) -> str:
        return f"{self._path}: placemark {self._count}"

    def start(self, tag: str, attributes: Mapping[str, str]) -> None:
        self._text.clear()
        self._inside.append(tag)
        if tag == "NetworkLink":
            raise InputError(
                f"{self._path}: expected zones, found a NetworkLink to others; give those files themselves"
            )
        if tag == "Placemark":
            self._count += 1
            self._fields, self._shapes = {}, []
        elif self._fields is None:
            return
        elif tag in _REFUSED_GEOMETRIES:
            raise InputError(f"{self._where}: expected a polygon, found a {tag}")
        elif tag in _GEOMETRIES and not (tag == "LinearRing" and "Polygon" in self._inside[:-1]):
            self._shapes.append(_PartialGeometry(tag))
        elif tag in ("Data", "SimpleData"):
            self._key = attributes.get("name")

    def text(self, text: str) -> None:
        self._text.append(text)

    def end(self, tag: str) -> None:
        text = "".join(self._text).strip()
        self._text.clear()
        self._inside.pop()
        if self._fields is None:
            return
        if tag == "Placemark":
            self.records.extend(self._placemark())
            self._fields = None
        elif tag == "name" and self._inside[-1] == "Placemark":
            self._fields["name"] = text
        elif tag in ("value", "SimpleData") and self._key is not None:
            before = self._fields.get(self._key, text)
            if before != text and self._key != "name":  # a placemark has a name beside that in its data
                raise InputError(
                    f"{self._where}: field {self._key!r:.40}: expected it once, found {before!r:.40} and {text!r:.40}"
                )
            self._fields[self._key] = text
        elif self._shapes:
            self._shaped(tag, text)

    def _shaped(self, tag: str, text: str) -> None:
        shape = self._shapes[-1]
        if tag == "altitudeMode":
            if text not in _ALTITUDE_MODES:
                raise InputError(
                    f"{self._where}: 'altitudeMode': expected {', '.join(_ALTITUDE_MODES)}, found {text!r:.40}"
                )
            shape.mode = text
        elif tag == "extrude":
            shape.extruded = text in ("1", "true")
        elif tag == "coordinates":
            ring = [_place(one, self._where) for one in text.split()]
            if "innerBoundaryIs" in self._inside and not shape.rings:
                raise InputError(f"{self._where}: expected an outline before its holes, found a hole")
            shape.rings.append(ring)

    def _placemark(self) -> Iterator[GeometryRecord]:
        assert self._fields is not None
        groups: dict[tuple[str, bool], list[BaseGeometry]] = {}
        for shape in self._shapes:
            groups.setdefault((shape.mode, shape.extruded), []).append(shape.geometry(self._where))
        if not groups:
            yield GeometryRecord(None, self._fields, self._where)
        for (mode, extruded), parts in groups.items():
            whole: BaseGeometry = parts[0] if len(parts) == 1 else GeometryCollection(parts)
            if mode == "clampToGround":
                whole = shapely.force_2d(whole)
            yield GeometryRecord(
                whole, self._fields, self._where, "amsl" if mode == "absolute" else "agl", not extruded
            )


def _place(text: str, where: str) -> list[float]:
    try:
        numbers = [float(one) for one in text.split(",")]
    except ValueError:
        numbers = []
    if not 2 <= len(numbers) <= 3 or not all(abs(number) < 1e12 for number in numbers):
        raise InputError(f"{where}: 'coordinates': expected longitude,latitude[,altitude], found {text!r:.40}")
    return numbers
