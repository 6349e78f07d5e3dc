"""Files of points alone, GPX and tables (CSV), as records like those of other files."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import pyproj
from shapely import Point

from skyverse.documents.xml import read_tree
from skyverse.errors import parse_number, unreadable
from skyverse.maps.georeference.coordinate_systems import WGS84
from skyverse.maps.georeference.feature import Fields
from skyverse.maps.georeference.reading import Choices
from skyverse.maps.readers.record_to_feature import GeometryRecord
from skyverse.maps.readers.track_files import LATITUDES, LONGITUDES, named_table


def layers(path: Path, _: Choices) -> Iterator[tuple[list[GeometryRecord], pyproj.CRS]]:
    """Yield the points of a GPX file or of a table, which are in degrees, as its only layer."""
    yield (_waypoints if path.suffix.lower() == ".gpx" else _rows)(path), WGS84


def _waypoints(path: Path) -> list[GeometryRecord]:
    """Return the waypoints of a GPX file, or the points of its routes if it has none."""
    with unreadable(path), path.open("rb") as stream:
        root = read_tree(stream, path)
    places = [*root.iter("wpt")] or [*root.iter("rtept")]
    said = [one.attrib | {part.tag: part.text or "" for part in one} for one in places]
    return [_record(fields, f"{path}: point {number}", "ele") for number, fields in enumerate(said, 1)]


def _rows(path: Path) -> list[GeometryRecord]:
    """Return the rows of a CSV file, which are places in degrees."""
    names, rows = named_table(path)
    return [_record(dict(zip(names, row, strict=True)), f"{path}: line {line}") for line, row in rows.items()]


def _record(fields: Mapping[str, str], where: str, *up: str) -> GeometryRecord:
    """Return a point whose longitude, latitude and, if it has one, altitude of the name `up` are among its fields."""
    known = Fields(fields)
    axes = (LONGITUDES, LATITUDES, *([up] if known.text(*up) else []))
    numbers = [parse_number(known.text(*names), f"{where}: {names[-1]}") for names in axes]
    return GeometryRecord(Point(numbers), dict(fields), where)
