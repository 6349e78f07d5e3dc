"""What files of recorded tracks say, tables (CSV) and GPX: where something was, and when, one fix after another."""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, NamedTuple
from xml.etree.ElementTree import Element

from skyverse.documents.xml import read_tree
from skyverse.errors import InputError, did_you_mean, parse_number, shown, unreadable
from skyverse.model.short_lines import counted

Reference = Literal["amsl", "ellipsoid"]
"""What altitudes are counted from: mean sea level, or the WGS84 ellipsoid."""
Unit = Literal["m", "ft"]
"""What altitudes are counted in."""
FIRST_DATE = 1e8
"""Seconds since 1970 from which on numbers are taken for dates, not for seconds into a mission."""
LAST_DATE = 1e10
"""Seconds since 1970, the year 2286: larger numbers are milliseconds."""


class Altitudes(NamedTuple):
    """What a file calls its altitudes, and what they are counted from and in; ``None`` where it does not say."""

    name: str
    reference: Reference | None
    unit: Unit | None


@dataclass(frozen=True)
class Fixes:
    """The fixes of one vehicle, n of them.

    Attributes
    ----------
    lines
        The number of each one's line, or, in GPX, of its point.
    line
        What messages call such a number: ``"line"`` or ``"point"``.
    times
        Seconds, since 1970 where they are `dated`.
    dated
        Whether the times are dates.
    first
        The earliest time in the file, of any vehicle.
    places
        x, y, z in metres; or latitude, longitude in degrees, and altitude in its unit.
    altitudes
        What the file says of them; ``None`` for places in metres.
    errors
        How far off each fix may be, metres; empty where the file does not say.
    """

    lines: list[int]
    line: str
    times: list[float]
    dated: bool
    first: float
    places: list[tuple[float, float, float]]
    altitudes: Altitudes | None
    errors: list[float]


def time(text: str | None, where: str) -> tuple[float, bool]:
    """Return seconds, and whether they are those since 1970; dates as ISO 8601 has them, in UTC if they do not say."""
    said = (text or "").strip()
    if "-" in said[1:] and ":" in said:
        try:
            moment = datetime.fromisoformat(said)
        except ValueError:
            raise InputError(f"{where}: expected seconds or a date, found {shown(said)}") from None
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp(), True
    seconds = parse_number(said, where)
    if seconds > LAST_DATE:
        raise InputError(f"{where}: expected seconds, found {seconds:g}, which may be milliseconds")
    return seconds, seconds >= FIRST_DATE


TIMES = ("t", "time", "timestamp", "seconds")
EAST, NORTH, UP = ("x",), ("y",), ("z",)
LATITUDES, LONGITUDES = ("lat", "latitude"), ("lon", "lng", "longitude")
ALTITUDES: dict[str, Reference | None] = {
    "altitude_amsl": "amsl",
    "altitude_ellipsoid": "ellipsoid",
    "geoaltitude": "ellipsoid",
    "geo_altitude": "ellipsoid",
    "alt_geom": "ellipsoid",
    "altitude": None,
    "alt": None,
    "ele": None,
    "elevation": None,
}
"""The names of altitudes, the best first, and what each is counted from, where its name says so."""
PRESSURE_ALTITUDES = ("baroaltitude", "baro_altitude", "alt_baro", "pressure_altitude")
"""The names of altitudes that are the pressure of the air in a standard atmosphere, wherever that is today."""
OPENSKY = {"time", "icao24", "lat", "lon", "baroaltitude", "geoaltitude"}
"""Names that tables of the OpenSky Network's state vectors have, in which all altitudes are in metres."""
_NAMED_UNIT = re.compile(r"(.+?)[ _]*[ _(\[](m|ft|met(?:er|re)s?|feet|foot)[)\]]?")
"""A name of altitudes with their unit, as in ``altitude_ft``, ``altitude (m)`` or ``alt [ft]``."""
VEHICLES = ("icao24", "hex", "uav", "vehicle", "name")
ERRORS = ("error", "accuracy")


class _Columns(NamedTuple):
    """The columns that a track is read from: time, the three numbers of a place, the vehicle, and the error."""

    time: int
    place: tuple[int, int, int]
    altitudes: Altitudes | None
    vehicle: int | None
    error: int | None


def table_fixes(path: Path, vehicle: str | None) -> Fixes:
    """Return the fixes of the only vehicle in a table, or of one that is named.

    Raises
    ------
    InputError
        If the file is no such table, or a number in it is none; or if it has several vehicles and none is named.
    """
    names, rows = named_table(path)
    return fixes_of_rows(path, names, rows, vehicle, "line")


def fixes_of_rows(path: Path, names: list[str], rows: dict[int, list[str]], vehicle: str | None, word: str) -> Fixes:
    """Return the fixes in numbered rows of named columns, see `table_fixes`; `word` is what messages call a row."""
    columns = _columns(path, names)
    own = _of_vehicle(path, rows, columns, names, vehicle)
    times, dated, first = _times(path, rows, own, columns, names, word)
    places, errors = [], []
    for line in own:
        row = rows[line]
        x, y, z = (parse_number(row[k], f"{path}: {word} {line}: {names[k]}") for k in columns.place)
        places.append((x, y, z))
        if columns.error is not None:
            where = f"{path}: {word} {line}: {names[columns.error]}"
            errors.append(parse_number(row[columns.error], where))
            if errors[-1] < 0:
                raise InputError(f"{where}: expected metres from 0 on, found {errors[-1]:g}")
    return Fixes(
        lines=own,
        line=word,
        times=times,
        dated=dated,
        first=first,
        places=places,
        altitudes=columns.altitudes,
        errors=errors,
    )


def named_table(path: Path) -> tuple[list[str], dict[int, list[str]]]:
    """Return the names of columns, in small letters, and the rows by the numbers of their lines."""
    try:
        with unreadable(path, "is no table", csv.Error), path.open(encoding="utf-8-sig", newline="") as stream:
            head = stream.readline()
            stream.seek(0)
            reader = csv.reader(stream, delimiter=max(",;\t", key=head.count))
            rows = dict(_filled(reader))
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: expected a text file in UTF-8, found something else at byte {error.start}") from None
    if len(rows) < 2:
        raise InputError(
            f"{path}: expected a line of names and one of numbers or more, found {counted(len(rows), 'line')}"
        )
    names = [name.strip().lower() for name in rows.pop(min(rows))]
    for line, row in rows.items():
        if len(row) != len(names):
            raise InputError(f"{path}: line {line}: expected {counted(len(names), 'column')}, found {len(row)}")
    return names, rows


def _filled(reader: Any) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows that hold anything, with the numbers of their lines."""
    for row in reader:
        if any(cell.strip() for cell in row):
            yield reader.line_num, row


def _columns(path: Path, names: list[str]) -> _Columns:
    def find(known: tuple[str, ...], among: Sequence[str] = names) -> int | None:
        return next((among.index(name) for name in known if name in among), None)

    at = find(TIMES)
    named = [_NAMED_UNIT.fullmatch(name) for name in names]
    without_units = [name if found is None else found[1] for name, found in zip(names, named, strict=True)]
    heights = find((*ALTITUDES, *PRESSURE_ALTITUDES), without_units)
    globe = find(LATITUDES), find(LONGITUDES), heights
    local = find(EAST), find(NORTH), find(UP)
    places = local if None in globe else globe
    if at is None or None in places:
        raise InputError(
            f"{path}: expected columns for the time (t) and the place (x, y, z; or latitude, longitude, altitude), "
            f"found {shown(', '.join(names), 100)}"
        )
    one, two, three = (place for place in places if place is not None)
    if heights is None or places is local:
        return _Columns(at, (one, two, three), None, find(VEHICLES), find(ERRORS))
    written = named[heights]
    if without_units[heights] in PRESSURE_ALTITUDES:
        raise InputError(
            f"{path}: {names[heights]}: follows the pressure of the air, and is off by hundreds of metres with the "
            "weather; expected a column of geometric altitudes, such as geoaltitude"
        )
    unit: Unit | None = None
    if written is not None:
        unit = "m" if written[2].startswith("m") else "ft"
    elif names[heights] == "geoaltitude" and set(names) >= OPENSKY:
        unit = "m"
    altitudes = Altitudes(names[heights], ALTITUDES[without_units[heights]], unit)
    return _Columns(at, (one, two, three), altitudes, find(VEHICLES), find(ERRORS))


def _of_vehicle(
    path: Path, rows: dict[int, list[str]], columns: _Columns, names: list[str], vehicle: str | None
) -> list[int]:
    """Return the numbers of the lines of a vehicle."""
    if columns.vehicle is None:
        if vehicle is not None:
            raise InputError(f"{path}: vehicle: the file has no column that names one, such as {VEHICLES[0]}")
        return list(rows)
    name, column = names[columns.vehicle], columns.vehicle
    known = dict.fromkeys(row[column].strip() for row in rows.values())
    if vehicle is None:
        if len(known) > 1:
            some = ", ".join(list(known)[:4]) + (", ..." if len(known) > 4 else "")
            raise InputError(
                f"{path}: {name}: expected one vehicle, found {len(known)} ({shown(some, 80)}); give vehicle"
            )
        return list(rows)
    wanted = vehicle.strip().lower()
    own = [line for line, row in rows.items() if row[column].strip().lower() == wanted]
    if not own:
        raise InputError(f"{path}: {name}: there is no {shown(vehicle)}{did_you_mean(vehicle, known)}")
    return own


def _times(
    path: Path, rows: dict[int, list[str]], own: list[int], columns: _Columns, names: list[str], word: str
) -> tuple[list[float], bool, float]:
    """Return the times of a vehicle's lines, whether they are dates, and the earliest one of all lines."""
    at, name = columns.time, names[columns.time]
    read = {line: time(row[at], f"{path}: {word} {line}: {name}") for line, row in rows.items()}
    dated = read[own[0]][1]
    for line in own:
        if read[line][1] != dated:
            found = "a date" if read[line][1] else "seconds"
            raise InputError(f"{path}: {word} {line}: {name}: found {found}, other than in {word} {own[0]}")
    return [read[line][0] for line in own], dated, min(seconds for seconds, _ in read.values())


def gpx_fixes(path: Path, vehicle: str | None) -> Fixes:
    """Return the fixes of the only track in a file, or of one that is named; its segments follow one another.

    Elevations are in metres, by the format; it does not say what they are counted from.

    Raises
    ------
    InputError
        If the file is no GPX, a point has no elevation or time, or there are several tracks and none is named.
    """
    with unreadable(path), path.open("rb") as stream:
        root = read_tree(stream, path)
    if root.tag != "gpx":
        raise InputError(f"{path}: expected a GPX file, whose first element is gpx, found {shown(root.tag)}")
    tracks = root.findall("trk")
    if vehicle is not None:
        names = [_text(track, "name") or "" for track in tracks]
        tracks = [track for track, name in zip(tracks, names, strict=True) if name == vehicle.strip()]
        if not tracks:
            raise InputError(f"{path}: name: there is no track {shown(vehicle)}{did_you_mean(vehicle, names)}")
    if len(tracks) != 1:
        raise InputError(
            f"{path}: expected one track, found {len(tracks)}" + ("; give vehicle, the name of one" if tracks else "")
        )
    points = list(tracks[0].iter("trkpt"))
    if not points:
        raise InputError(f"{path}: expected a track with points, found none")
    times, places = [], []
    for k, point in enumerate(points, 1):
        where = f"{path}: point {k}"
        latitude, longitude = (parse_number(point.get(name), f"{where}: {name}") for name in ("lat", "lon"))
        places.append((latitude, longitude, parse_number(_given(point, "ele", where), f"{where}: ele")))
        times.append(time(_given(point, "time", where), f"{where}: time")[0])
    first = min(time(each.text, f"{path}: time")[0] for each in root.iterfind("trk/trkseg/trkpt/time"))
    return Fixes(
        lines=list(range(1, len(points) + 1)),
        line="point",
        times=times,
        dated=True,
        first=first,
        places=places,
        altitudes=Altitudes("ele", None, "m"),
        errors=[],
    )


def _text(element: Element, name: str) -> str | None:
    found = element.find(name)
    return None if found is None else (found.text or "").strip()


def _given(point: Element, name: str, where: str) -> str:
    found = _text(point, name)
    if found is None:
        raise InputError(f"{where}: {name}: is missing")
    return found
