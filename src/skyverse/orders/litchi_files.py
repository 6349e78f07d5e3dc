"""Litchi's missions (CSV): one waypoint a line, with up to fifteen actions, and altitudes from home or the ground."""

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from skyverse.documents.limits import text_of
from skyverse.errors import InputError, Remedy, parse_number, shown
from skyverse.model.altitude import FOOT, REFERENCES, AboveGround, AboveHome, Altitude, GlobalPlace
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.orders.places import Given, parse_place, steps, written

UNITS = {"": 1.0, "m": 1.0, "ft": FOOT, "deg": 1.0, "m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704}
ALTITUDE_MODES: dict[str, type[Altitude]] = {"0": AboveHome, "1": AboveGround, **REFERENCES}
_K = OrderKind
ACTIONS = {
    **{0: (_K.DELAY, "stay for"), 1: (_K.CAMERA, "take photo"), 2: (_K.CAMERA, "start recording")},
    **{3: (_K.CAMERA, "stop recording"), 4: (_K.HEADING, "rotate aircraft"), 5: (_K.GIMBAL, "tilt camera")},
}
"""By Litchi's numbers; -1 is none, and all others may lead anywhere."""
MOST_ACTIONS = 15


class _Table(NamedTuple):
    """The rows of a file, what messages call them, the columns by their names, and what their units are in SI units."""

    rows: list[list[str]]
    where: list[str]
    columns: dict[str, int]
    units: dict[str, float]

    def text(self, row: int, name: str) -> str:
        return self.rows[row][self.columns[name]].strip() if name in self.columns else ""

    def number(self, row: int, name: str, default: float = 0.0) -> float:
        text = self.text(row, name)
        return parse_number(text, f"{self.where[row]}: {name}") * self.units[name] if text else default

    def place(self, row: int, prefix: str, mode: str) -> GlobalPlace:
        if mode not in ALTITUDE_MODES:
            raise InputError(f"{self.where[row]}: {prefix}altitudemode: expected 0 or 1, found {shown(mode)}")
        texts = [self.text(row, prefix + name) for name in ("latitude", "longitude", "altitude")]
        where, unit = f"{self.where[row]}{prefix and ': poi'}", self.units.get(prefix + "altitude", 1.0)
        return parse_place(texts, ALTITUDE_MODES[mode], where, unit)


def _table(content: bytes, name: str) -> _Table:
    try:
        lines = list(csv.reader(io.StringIO(text_of(content, name)), strict=True))
    except csv.Error as error:
        raise InputError(f"{name}: expected a table (CSV): {error}") from None
    if lines and len(lines[0]) == 1 and ";" in lines[0][0]:
        raise InputError(f"{name}: expected cells separated by ',', found ';'")
    columns: dict[str, int] = {}
    units: dict[str, float] = {}
    for at, cell in enumerate(lines[0] if lines else []):
        word, _, unit = cell.strip().lower().rstrip(")").partition("(")
        if unit not in UNITS or (word == "altitude" and not unit):
            raise InputError(f"{name}: column {shown(cell)}: expected its unit, as in altitude(m) or altitude(ft)")
        columns[word], units[word] = at, UNITS[unit]
    rows = {k: row for k, row in enumerate(lines[1:], 2) if any(row)}
    lacking = [f"column {word}" for word in ("latitude", "longitude", "altitude") if word not in columns]
    if lacking or not rows:
        photos = Remedy("survey", None, "and the mission that they are of, for a table of photos")
        said = f"{name}: expected a Litchi mission, found no {(lacking or ['waypoint'])[0]}"
        raise InputError(said, give=[photos])
    short = next((k for k, row in rows.items() if len(row) <= max(columns.values())), None)
    if short is not None:
        raise InputError(f"{name}: line {short}: expected {len(lines[0])} cells, found {len(rows[short])}")
    return _Table(list(rows.values()), [f"{name}: line {k}" for k in rows], columns, units)


def read_litchi(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the orders of a Litchi mission."""
    table = _table(content, name)
    held: dict[str, object] = {"poi": None, "photos": "0.0"}
    orders = [order for row in range(len(table.rows)) for order in _told(table, row, held, given)]
    orders = [replace(order, item=k) for k, order in enumerate(orders)]
    return Waypoints(name, tuple(orders), autopilot="dji", ground_followed=False)


def _told(table: _Table, row: int, held: dict[str, object], given: Given) -> Iterator[Order]:
    """Yield the orders of a row; `held` keeps what holds until another row says otherwise."""
    number, where = row + 1, table.where[row]
    mode = table.text(row, "altitudemode") or given.altitude
    if mode is None:
        said = f"{where}: does not say what its altitude is counted from"
        raise InputError(said, give=[Remedy("altitude", None, "(home or agl)")])
    speed, turn = table.number(row, "speed"), table.number(row, "curvesize")
    if speed < 0 or turn < 0:
        raise InputError(f"{where}: expected a speed and a curvesize from 0 on, found {speed:g} and {turn:g}")
    nose = table.number(row, "heading", math.nan)
    moving = {"radius": turn, "speed": speed or None, "heading": None if math.isnan(nose) else nose}
    yield Order(number, OrderKind.WAYPOINT, "waypoint", place=table.place(row, "", mode), **moving)  # type: ignore[arg-type]
    looks = table.number(row, "poi_latitude") or table.number(row, "poi_longitude")
    at = table.place(row, "poi_", table.text(row, "poi_altitudemode") or mode) if looks else None
    if at != held["poi"]:
        yield Order(number, OrderKind.LOOK_AT, "poi", place=at)
    if table.number(row, "gimbalmode") == 2:
        yield Order(number, OrderKind.GIMBAL, f"gimbal pitch {table.number(row, 'gimbalpitchangle'):g}")
    for k in range(1, MOST_ACTIONS + 1):
        action, value = table.number(row, f"actiontype{k}", -1.0), table.number(row, f"actionparam{k}")
        kind, name = ACTIONS.get(int(action), (OrderKind.OTHER, f"action {action:g}"))
        if kind is OrderKind.DELAY and value < 0:
            raise InputError(f"{where}: actionparam{k}: expected milliseconds from 0 on, found {value:g}")
        seconds = value / 1000 if kind is OrderKind.DELAY else 0.0
        if action != -1:
            yield Order(number, kind, name, seconds=seconds, heading=value if kind is OrderKind.HEADING else None)
    every, apart = table.number(row, "photo_timeinterval", -1.0), table.number(row, "photo_distinterval", -1.0)
    spacing = apart if apart > 0 else every * (speed or math.nan) if every > 0 else 0.0
    if repr(spacing) != held["photos"]:
        yield Order(number, OrderKind.CAMERA, "photo interval", spacing=None if math.isnan(spacing) else spacing)
    held |= {"poi": at, "photos": repr(spacing)}


def litchi_content(waypoints: Waypoints, before: Waypoints) -> bytes:
    """Return the file that was read with the places of orders put in."""
    table = _table(waypoints.stored, waypoints.name)
    text = waypoints.stored.decode("utf-8-sig")
    made = io.StringIO()
    writer = csv.writer(made, lineterminator="\r\n" if "\r\n" in text else "\n")
    writer.writerow(next(csv.reader([text.splitlines()[0]])))
    places = [k for k, order in enumerate(before.orders) if order.kind is OrderKind.WAYPOINT]
    for step in steps(before, waypoints, places):
        cells: dict[str, str] = {}
        if step.moved:
            latitude, longitude, altitude = step.place
            metres = written(altitude.metres / table.units["altitude"], 4)
            cells |= {"latitude": written(latitude), "longitude": written(longitude), "altitude": metres}
        if step.new:
            cells |= {f"actiontype{k}": "-1" for k in range(1, MOST_ACTIONS + 1)}
        if step.stops or step.turns is not None:
            cells["curvesize"] = written((step.turns or 0.0) / table.units.get("curvesize", 1.0), 2)
        row = list(table.rows[step.source])
        for name in cells.keys() & table.columns.keys():
            row[table.columns[name]] = cells[name]
        writer.writerow(row)
    return made.getvalue().encode()
