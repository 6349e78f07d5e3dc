"""Litchi's missions (CSV): one waypoint a line, with up to fifteen actions, and altitudes from home or the ground."""

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from skyverse.errors import InputError, Remedy, shown
from skyverse.model.altitude import FOOT, AboveGround, AboveHome, Altitude
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.waypoints.places import REFERENCES, Given, parse_number, parse_place, steps, written

UNITS = {"m": 1.0, "ft": FOOT, "deg": 1.0, "m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704}
ALTITUDE_MODES: dict[str, type[Altitude]] = {"0": AboveHome, "1": AboveGround, **REFERENCES}
_K = OrderKind
ACTIONS = {
    0: (_K.DELAY, "stay for"),
    1: (_K.CAMERA, "take photo"),
    2: (_K.CAMERA, "start recording"),
    3: (_K.CAMERA, "stop recording"),
    4: (_K.HEADING, "rotate aircraft"),
    5: (_K.GIMBAL, "tilt camera"),
}
"""By Litchi's numbers; -1 is none, and all others are passed on."""
MOST_ACTIONS = 15


class _Column(NamedTuple):
    """Where a column stands, and how many metres, m/s or degrees its unit is."""

    at: int
    unit: float


class _Table(NamedTuple):
    """The lines of a file, its columns by their names without units, and the numbers of the lines with waypoints."""

    lines: list[str]
    columns: dict[str, _Column]
    rows: list[int]


class _Row(NamedTuple):
    """One waypoint's line, and what messages call it."""

    cells: list[str]
    columns: dict[str, _Column]
    where: str

    def text(self, name: str) -> str:
        return self.cells[self.columns[name].at].strip() if name in self.columns else ""

    def number(self, name: str, default: float = 0.0) -> float:
        """Return a number in metres, m/s or degrees; the default where there is none."""
        text = self.text(name)
        return parse_number(text, f"{self.where}: {name}") * self.columns[name].unit if text else default


def read_litchi(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the orders of a Litchi mission."""
    table = _table(content, name)
    orders: list[Order] = []
    held: dict[str, object] = {}
    for number, line in enumerate(table.rows, 1):
        orders += _told(_row(table, line, name), number, held, given)
    return Waypoints(
        name,
        tuple(replace(order, item=k) for k, order in enumerate(orders)),
        autopilot="dji",
        altitude=given.altitude,
        geoid=given.geoid,
        stored=content,
    )


def _table(content: bytes, name: str) -> _Table:
    try:
        lines = content.decode("utf-8-sig").splitlines(keepends=True)
    except UnicodeDecodeError as error:
        raise InputError(f"{name}: expected a text file in UTF-8, found something else at byte {error.start}") from None
    columns: dict[str, _Column] = {}
    for at, cell in enumerate(next(csv.reader(lines[:1]), [])):
        word, _, unit = cell.strip().lower().rstrip(")").partition("(")
        if (unit and unit not in UNITS) or (word == "altitude" and not unit):
            raise InputError(f"{name}: column {shown(cell)}: expected its unit, as in altitude(m) or altitude(ft)")
        columns[word] = _Column(at, UNITS.get(unit, 1.0))
    missing = [word for word in ("latitude", "longitude", "altitude") if word not in columns]
    rows = [k for k, line in enumerate(lines) if k and line.strip()]
    if missing or not rows:
        raise InputError(
            f"{name}: expected a Litchi mission, found no {f'column {missing[0]}' if missing else 'waypoint'}"
        )
    return _Table(lines, columns, rows)


def _row(table: _Table, line: int, name: str) -> _Row:
    cells = next(csv.reader([table.lines[line]]))
    if len(cells) <= max(column.at for column in table.columns.values()):
        raise InputError(f"{name}: line {line + 1}: expected {len(table.columns)} cells, found {len(cells)}")
    return _Row(cells, table.columns, f"{name}: line {line + 1}")


def _told(row: _Row, number: int, held: dict[str, object], given: Given) -> Iterator[Order]:
    """Yield the orders of a line; `held` keeps what holds until another line says otherwise."""

    def place(prefix: str, mode: str) -> tuple[float, float, Altitude]:
        kind = ALTITUDE_MODES.get(mode)
        if kind is None:
            raise InputError(f"{row.where}: {prefix}altitudemode: expected 0 or 1, found {shown(mode)}")
        texts = [row.text(f"{prefix}{name}") for name in ("latitude", "longitude", "altitude")]
        return parse_place(
            texts, kind, f"{row.where}{': poi' if prefix else ''}", row.columns[f"{prefix}altitude"].unit
        )

    mode = row.text("altitudemode") or given.altitude
    if mode is None:
        said = f"{row.where}: does not say what its altitude is counted from"
        raise InputError(said, give=[Remedy("altitude", None, "(home or agl)")])
    speed, turn = row.number("speed"), row.number("curvesize")
    if speed < 0 or turn < 0:
        raise InputError(f"{row.where}: expected a speed and a curvesize from 0 on, found {speed:g} and {turn:g}")
    yield Order(
        number,
        OrderKind.WAYPOINT,
        "waypoint",
        place=place("", mode),
        radius=turn,
        speed=speed or None,
        heading=row.number("heading") if row.text("heading") else None,
    )
    looks = "poi_altitude" in row.columns and (row.number("poi_latitude") or row.number("poi_longitude"))
    at = place("poi_", row.text("poi_altitudemode") or mode) if looks else None
    if at != held.get("poi"):
        yield Order(number, OrderKind.LOOK_AT, "poi", place=at)
    pitch = row.number("gimbalpitchangle") if row.number("gimbalmode") == 2 else None
    if pitch is not None:
        yield Order(number, OrderKind.GIMBAL, f"gimbal pitch {pitch:g}")
    for k in range(1, MOST_ACTIONS + 1):
        action, value = row.number(f"actiontype{k}", -1.0), row.number(f"actionparam{k}")
        if action == -1:
            continue
        kind, name = ACTIONS.get(int(action), (OrderKind.OTHER, f"action {action:g}"))
        if kind is OrderKind.DELAY and value < 0:
            raise InputError(f"{row.where}: actionparam{k}: expected milliseconds from 0 on, found {value:g}")
        seconds = value / 1000 if kind is OrderKind.DELAY else 0.0
        yield Order(number, kind, name, seconds=seconds, heading=value if kind is OrderKind.HEADING else None)
    every, apart = row.number("photo_timeinterval", -1.0), row.number("photo_distinterval", -1.0)
    spacing = apart if apart > 0 else every * (speed or math.nan) if every > 0 else 0.0
    if repr(spacing) != repr(held.get("photos", 0.0)):
        yield Order(number, OrderKind.CAMERA, "photo interval", spacing=spacing if spacing == spacing else None)
    held |= {"poi": at, "photos": spacing}


def litchi_content(waypoints: Waypoints) -> bytes:
    """Return the file that was read with the places of orders put in."""
    table = _table(waypoints.stored, waypoints.name)
    before = read_litchi(waypoints.stored, waypoints.name, Given(waypoints.altitude, waypoints.geoid))
    places = [k for k, order in enumerate(before.orders) if order.kind is OrderKind.WAYPOINT]
    lines: dict[int, list[str]] = {}
    for step in steps(before, waypoints, places):
        at = table.rows[step.source]
        row = _row(table, at, waypoints.name)
        text = table.lines[at]
        if step.new or step.moved:
            latitude, longitude, altitude = step.place
            metres = written(altitude.metres / table.columns["altitude"].unit, 4)
            texts = {"latitude": written(latitude), "longitude": written(longitude), "altitude": metres}
            quiet = {f"actiontype{k}": "-1" for k in range(1, MOST_ACTIONS + 1)} if step.new else {}
            for name, cell in (texts | quiet).items():
                if name in table.columns:
                    row.cells[table.columns[name].at] = cell
            made = io.StringIO()
            csv.writer(made, lineterminator=text[len(text.rstrip("\r\n")) :] or "\n").writerow(row.cells)
            text = made.getvalue()
        lines.setdefault(at, []).append(text)
    return "".join("".join(lines.get(k, [line])) for k, line in enumerate(table.lines)).encode()
