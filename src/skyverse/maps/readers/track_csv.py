"""Recorded tracks as tables (CSV) in metres or degrees, with a line of names; also state vectors of many aircraft."""

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from skyverse.errors import InputError, did_you_mean, shown, unreadable
from skyverse.maps.readers.track_fixes import Fixes, Reference, Unit, number, time
from skyverse.model.short_lines import counted

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
    in_degrees: bool
    reference: Reference | None
    unit: Unit | None
    heights: str
    vehicle: int | None
    error: int | None


def fixes(path: Path, vehicle: str | None) -> Fixes:
    """Return the fixes of the only vehicle in a table, or of one that is named.

    Raises
    ------
    InputError
        If the file is no such table, or a number in it is none; or if it has several vehicles and none is named.
    """
    names, rows = _table(path)
    columns = _columns(path, names)
    own = _of_vehicle(path, rows, columns, names, vehicle)
    times, dated, first = _times(path, rows, own, columns, names)
    places, errors = [], []
    for line in own:
        row = rows[line]
        x, y, z = (number(row[k], f"{path}: line {line}: {names[k]}") for k in columns.place)
        places.append((x, y, z))
        if columns.error is not None:
            where = f"{path}: line {line}: {names[columns.error]}"
            errors.append(number(row[columns.error], where))
            if errors[-1] < 0:
                raise InputError(f"{where}: expected metres from 0 on, found {errors[-1]:g}")
    return Fixes(
        lines=own,
        line="line",
        times=times,
        dated=dated,
        first=first,
        places=places,
        in_degrees=columns.in_degrees,
        reference=columns.reference,
        unit=columns.unit,
        heights=columns.heights,
        errors=errors,
    )


def _table(path: Path) -> tuple[list[str], dict[int, list[str]]]:
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
    in_degrees = None not in globe
    places = globe if in_degrees else local
    if at is None or None in places:
        raise InputError(
            f"{path}: expected columns for the time (t) and the place (x, y, z; or latitude, longitude, altitude), "
            f"found {shown(', '.join(names), 100)}"
        )
    one, two, three = (place for place in places if place is not None)
    if not in_degrees or heights is None:
        return _Columns(at, (one, two, three), False, None, "m", names[three], find(VEHICLES), find(ERRORS))
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
    reference = ALTITUDES[without_units[heights]]
    return _Columns(at, (one, two, three), True, reference, unit, names[heights], find(VEHICLES), find(ERRORS))


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
    path: Path, rows: dict[int, list[str]], own: list[int], columns: _Columns, names: list[str]
) -> tuple[list[float], bool, float]:
    """Return the times of a vehicle's lines, whether they are dates, and the earliest one of all lines."""
    read = {line: time(row[columns.time], f"{path}: line {line}: {names[columns.time]}") for line, row in rows.items()}
    dated = read[own[0]][1]
    for line in own:
        if read[line][1] != dated:
            found = "a date" if read[line][1] else "seconds"
            raise InputError(f"{path}: line {line}: {names[columns.time]}: found {found}, other than in line {own[0]}")
    return [read[line][0] for line in own], dated, min(seconds for seconds, _ in read.values())
