"""QGroundControl's ``.plan`` and QGC WPL 110 (``.waypoints``, ``.txt``): read as orders, and written with changes.

A file is changed where its orders are, and nowhere else: all other items, keys and numbers stay as they were. Items
that are added move the numbers of those after them, and with them the targets of jumps.
"""

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

from skyverse.documents.json import load_json
from skyverse.documents.limits import LimitError
from skyverse.errors import InputError, first_line, is_number, shown
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude, GlobalPlace
from skyverse.model.waypoints import Geofence, Order, OrderKind, Ring, Waypoints
from skyverse.waypoints.mavlink_items import (
    FRAMES,
    WAYPOINT,
    StoredItem,
    added_item,
    changed_item,
    numbers_of,
    order_of,
)
from skyverse.waypoints.places import Given

FIRMWARES: dict[object, Literal["px4", "ardupilot"]] = {12: "px4", 3: "ardupilot"}
"""MAV_AUTOPILOT_PX4, MAV_AUTOPILOT_ARDUPILOTMEGA."""
AEROPLANES = (1, 19, 20, 21, 22, 23, 24, 25)
"""MAV_TYPE_FIXED_WING and those of VTOLs."""
QGC_ALTITUDE_MODES: dict[type[Altitude], int] = {AboveHome: 1, AboveSea: 2, AboveGround: 4}
JUMP = 177
NO_MISSION = (*range(5000, 5005), 5100)
"""MAV_CMD_NAV_FENCE_... and MAV_CMD_NAV_RALLY_POINT."""
WPL = "QGC WPL 110"
STORED_IN = ("TransectStyleComplexItem", "Items")
"""Where survey and corridor items have the items that they stand for."""


class _Slot(NamedTuple):
    """An item of a ``.plan``, in the list that holds it."""

    holder: list[Any]
    data: dict[str, Any]
    where: str


def read_plan(content: bytes, name: str, _given: Given) -> Waypoints:
    """Return the orders of a ``.plan``; survey and corridor items are read by the items that they have stored."""
    plan = _plan_data(content, name)
    mission = plan["mission"]
    slots = list(_slots(mission["items"], name))
    firmware, vehicle = FIRMWARES.get(mission.get("firmwareType")), mission.get("vehicleType")
    orders = [
        order_of(_plan_item(slot, firmware), number, number - 1, f"{slot.where} ({number})")
        for number, slot in enumerate(slots, 1)
    ]
    numbers = {_jump_id(slot, number): number for number, slot in enumerate(slots, 1)}
    orders = [_retargeted(order, numbers, f"{name}: item {order.number}") for order in orders]
    aeroplane = vehicle in AEROPLANES
    speed = mission.get("cruiseSpeed" if aeroplane else "hoverSpeed")
    if speed is not None and not (is_number(speed) and 0 < speed < 1e4):
        raise InputError(f"{name}: 'hoverSpeed': expected m/s above 0, found {shown(speed)}")
    return Waypoints(
        name,
        tuple(orders),
        _home(mission.get("plannedHomePosition"), name),
        speed,
        firmware,
        aeroplane,
        fence=_fence(plan.get("geoFence"), name),
        rally=tuple(_rally(plan.get("rallyPoints"), name)),
    )


def plan_content(waypoints: Waypoints, _before: Waypoints) -> bytes:
    """Return the ``.plan`` that was read with the places of orders, and the orders without an item, put in."""
    plan = _plan_data(waypoints.stored, waypoints.name)
    slots = list(_slots(plan["mission"]["items"], waypoints.name))
    firmware = FIRMWARES.get(plan["mission"].get("firmwareType"))
    ids = [_jump_id(slot, number) for number, slot in enumerate(slots, 1)]
    after: list[tuple[int | None, dict[str, Any]]] = []  # the items in their new order, with their former numbers
    holder, at = plan["mission"]["items"], 0
    for order in waypoints.orders:
        if order.item is None:
            holder.insert(at, _new_plan_item(added_item(order)))
            after.append((None, holder[at]))
            at += 1
            continue
        slot = slots[order.item]
        item = _plan_item(slot, firmware)
        moved = changed_item(item, order)
        if moved != item:
            _set_numbers(slot.data, moved)
        begin = at if holder is slot.holder else 0
        holder, at = slot.holder, next(k for k in range(begin, len(slot.holder)) if slot.holder[k] is slot.data) + 1
        after.append((ids[order.item], slot.data))
    if waypoints.home is not None and waypoints.home != _home(
        plan["mission"].get("plannedHomePosition"), waypoints.name
    ):
        plan["mission"]["plannedHomePosition"] = list(waypoints.home)
    if len(after) > len(slots):
        numbers = {old: new for new, (old, _) in enumerate(after, 1) if old is not None}
        for new, (_, data) in enumerate(after, 1):
            data["doJumpId"] = new
            if data.get("command") == JUMP and data["params"][0] in numbers:
                data["params"][0] = numbers[data["params"][0]]
    return (json.dumps(plan, indent=4, ensure_ascii=False) + "\n").encode()


def _plan_data(content: bytes, name: str) -> dict[str, Any]:
    try:
        plan = load_json(content.decode("utf-8-sig"))
    except LimitError as error:
        raise InputError(f"{name}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{name}: expected a QGroundControl plan, which is JSON: {first_line(error)}") from None
    if not isinstance(plan, dict) or plan.get("fileType") != "Plan":
        found = plan.get("fileType") if isinstance(plan, dict) else plan
        raise InputError(f"{name}: 'fileType': expected 'Plan', found {shown(found)}")
    mission = plan.get("mission")
    for where, data, version in (("", plan, 1), ("mission.", mission, 2)):
        found = data.get("version") if isinstance(data, dict) else None
        if found != version:
            raise InputError(f"{name}: '{where}version': expected {version}, found {shown(found)}")
    if not isinstance(mission, dict) or not isinstance(mission.get("items"), list):
        raise InputError(f"{name}: 'mission.items': expected a list of items")
    return plan


def _slots(items: list[Any], name: str) -> Iterator[_Slot]:
    """Yield the simple items in the order in which they are flown, also those that complex items have stored."""
    for number, data in enumerate(items, 1):
        where = f"{name}: item {number}"
        if not isinstance(data, dict):
            raise InputError(f"{where}: expected an object, found {shown(data)}")
        if data.get("type") == "SimpleItem":
            yield _Slot(items, data, where)
            continue
        kind = data.get("complexItemType")
        if data.get("type") != "ComplexItem" or not isinstance(kind, str):
            raise InputError(
                f"{where}: 'type': expected 'SimpleItem' or 'ComplexItem', found {shown(data.get('type'))}"
            )
        holder: Any = data.get(STORED_IN[0])
        stored = holder.get(STORED_IN[1]) if isinstance(holder, dict) else None
        if not isinstance(stored, list):
            raise InputError(
                f"{where}: a {kind!r:.40} item has not stored the items that it stands for; send the plan to a vehicle "
                "or a simulated one with QGroundControl, read it back, and save that"
            )
        for one, inner in enumerate(stored, 1):
            if not isinstance(inner, dict) or inner.get("type") != "SimpleItem":
                raise InputError(f"{where} ({kind}), stored item {one}: expected a SimpleItem, found {shown(inner)}")
            yield _Slot(stored, inner, f"{where} ({kind}), stored item {one}")


def _plan_item(slot: _Slot, firmware: str | None) -> StoredItem:
    data, where = slot.data, slot.where
    whole = {key: data.get(key) for key in ("command", "frame")}
    for key, value in whole.items():
        if not isinstance(value, int) or isinstance(value, bool):
            raise InputError(f"{where}: {key!r}: expected a whole number, found {shown(value)}")
    params, place = data.get("params"), data.get("coordinate", [])  # which QGroundControl wrote apart until 2017
    if not isinstance(params, list) or not isinstance(place, list):
        raise InputError(f"{where}: 'params': expected seven numbers, found {shown(params)}")
    numbers = numbers_of([*params, *place], f"{where}: 'params'", zero_is_here=firmware != "px4")
    return StoredItem(whole["command"], whole["frame"], numbers)  # type: ignore[arg-type]


def _jump_id(slot: _Slot, number: int) -> int:
    """Return by what number a jump leads to an item."""
    given = slot.data.get("doJumpId", number)
    return given if isinstance(given, int) else number


def _retargeted(order: Order, numbers: dict[int, int], where: str) -> Order:
    """Return a jump to the number that its target has; the file names targets by their ``doJumpId``."""
    if order.kind is not OrderKind.JUMP:
        return order
    if order.to not in numbers:
        raise InputError(f"{where}: {order.name}: expected a jump to an item of the mission, found {order.to}")
    return replace(order, to=numbers[order.to])


def _set_numbers(data: dict[str, Any], item: StoredItem) -> None:
    """Put the numbers of an item into a ``.plan``, with the copies of its altitude that QGroundControl shows."""
    apart = "coordinate" in data
    former = [*data["params"][:4], *data["coordinate"]] if apart else data["params"]
    numbers = [old if math.isnan(new) or old == new else new for old, new in zip(former, item.numbers, strict=True)]
    data["frame"] = item.frame
    if apart:
        data["params"][:4], data["coordinate"] = numbers[:4], numbers[4:]
    else:
        data["params"] = numbers
    if "Altitude" in data:
        data["Altitude"] = item.numbers[6]
    if "AltitudeMode" in data and item.frame in FRAMES:
        data["AltitudeMode"] = QGC_ALTITUDE_MODES[FRAMES[item.frame]]
    if "AMSLAltAboveTerrain" in data:
        data["AMSLAltAboveTerrain"] = None


def _new_plan_item(item: StoredItem) -> dict[str, Any]:
    params = [None if math.isnan(value) else value for value in item.numbers]
    made = {"autoContinue": True, "command": item.command, "frame": item.frame, "params": params}
    told: dict[str, Any] = {"doJumpId": 0, "type": "SimpleItem"}
    if item.frame in FRAMES:
        mode = QGC_ALTITUDE_MODES[FRAMES[item.frame]]
        told |= {"Altitude": item.numbers[6], "AltitudeMode": mode, "AMSLAltAboveTerrain": None}
    return made | told


def _home(given: object, name: str) -> tuple[float, float, float | None] | None:
    """Return the planned place of take-off, ``None`` where it is not set: there, or at latitude and longitude 0."""
    if given is None:
        return None
    row = [math.nan if one is None else one for one in given] if isinstance(given, list) else []
    if len(row) not in (2, 3) or not all(isinstance(one, int | float) for one in row):
        raise InputError(f"{name}: 'plannedHomePosition': expected latitude, longitude, altitude, found {shown(given)}")
    if row[:2] == [0, 0] or any(math.isnan(one) for one in row[:2]):
        return None
    latitude, longitude = _degrees(row[:2], f"{name}: 'plannedHomePosition'")
    return latitude, longitude, float(row[2]) if len(row) == 3 and math.isfinite(row[2]) else None


def _degrees(row: Sequence[Any], where: str) -> tuple[float, float]:
    if len(row) < 2 or not all(is_number(one) for one in row[:2]) or abs(row[0]) > 90 or abs(row[1]) > 180:
        raise InputError(f"{where}: expected latitude and longitude, degrees, found {shown(list(row))}")
    return float(row[0]), float(row[1])


def _fence(given: Any, name: str) -> Geofence:
    """Return the geofence of a ``.plan``, or raise `InputError` where one of its shapes cannot be read."""
    if given is None:
        return Geofence()
    if isinstance(given, dict) and (given.get("polygon") or given.get("circle")):
        raise InputError(
            f"{name}: 'geoFence': expected version 2, found a polygon or circle of version 1, which QGroundControl "
            "ignores; draw it anew there"
        )
    areas: dict[tuple[str, bool], list[Any]] = {
        (kind, side): [] for kind in ("polygon", "circle") for side in (True, False)
    }
    for key in ("polygons", "circles"):
        shapes = given.get(key, []) if isinstance(given, dict) else None
        if not isinstance(shapes, list):
            raise InputError(f"{name}: 'geoFence.{key}': expected a list, found {shown(shapes)}")
        for number, shape in enumerate(shapes, 1):
            where = f"{name}: geoFence, {key[:-1]} {number}"
            inclusion = shape.get("inclusion") if isinstance(shape, dict) else None
            if not isinstance(inclusion, bool):
                raise InputError(f"{where}: 'inclusion': expected true or false, found {shown(inclusion)}")
            areas[key[:-1], inclusion].append((_ring if key == "polygons" else _circle)(shape, where))
    return Geofence(
        tuple(areas["polygon", True]),
        tuple(areas["polygon", False]),
        tuple(areas["circle", True]),
        tuple(areas["circle", False]),
    )


def _ring(shape: dict[str, Any], where: str) -> Ring:
    corners = shape.get("polygon")
    if not isinstance(corners, list) or len(corners) < 3:
        raise InputError(f"{where}: 'polygon': expected three corners or more, found {shown(corners)}")
    return tuple(_degrees(one if isinstance(one, list) else [one], f"{where}: 'polygon'") for one in corners)


def _circle(shape: dict[str, Any], where: str) -> tuple[float, float, float]:
    circle = shape.get("circle")
    centre, radius = (circle.get("center"), circle.get("radius")) if isinstance(circle, dict) else (None, None)
    if not (is_number(radius) and 0 < radius < 1e7):
        raise InputError(f"{where}: 'radius': expected metres above 0, found {shown(radius)}")
    return *_degrees(centre if isinstance(centre, list) else [centre], f"{where}: 'center'"), float(radius)


def _rally(given: Any, name: str) -> Iterator[GlobalPlace]:
    points = given.get("points", []) if isinstance(given, dict) else []
    for number, point in enumerate(points if isinstance(points, list) else [points], 1):
        where = f"{name}: rally point {number}"
        row = point if isinstance(point, list) else [point]
        latitude, longitude = _degrees(row, where)
        if len(row) != 3 or not is_number(row[2]):
            raise InputError(f"{where}: expected latitude, longitude and altitude, found {shown(point)}")
        yield latitude, longitude, AboveHome(float(row[2]))


def read_wpl(content: bytes, name: str, _given: Given) -> Waypoints:
    """Return the orders of a QGC WPL 110 file; its item 0 is home."""
    rows = _rows(content, name)
    items = [_wpl_item(row, f"{name}: line {line}") for line, row in rows]
    if items and all(item.command in NO_MISSION for item in items[1:] or items):
        raise InputError(f"{name}: expected a mission, found a geofence or rally points alone")
    if items and (rows[0][1][0] != "0" or items[0].command not in (0, WAYPOINT)):  # later numbers are counted
        raise InputError(
            f"{name}: line {rows[0][0]}: expected item 0, a waypoint, which is home, found item {rows[0][1][0]:.10} "
            f"with command {items[0].command}; ground stations take the first item for home"
        )
    home = None
    if items:
        *_, latitude, longitude, metres = items[0].numbers
        if items[0].command == WAYPOINT and items[0].frame in (0, 3, 5, 6):
            altitude = metres if FRAMES[items[0].frame] is AboveSea else math.nan  # one above itself says nothing
            home = _home([latitude, longitude, altitude], f"{name}: line {rows[0][0]}")
    orders = [
        order_of(item, number, number, f"{name}: line {rows[number][0]}") for number, item in enumerate(items) if number
    ]
    for order in orders:
        if order.kind is OrderKind.JUMP and not 1 <= (order.to or 0) < len(items):
            raise InputError(f"{name}: item {order.number}: expected a jump to an item, found {order.to}")
    return Waypoints(name, tuple(orders), home)


def wpl_content(waypoints: Waypoints, _before: Waypoints) -> bytes:
    """Return the file that was read with the places of orders, and the orders without an item, put in."""
    text = waypoints.stored.decode("utf-8-sig")
    rows = _rows(waypoints.stored, waypoints.name)
    head, made = text.splitlines()[0], [rows[0][1]]
    numbers = {order.item: number for number, order in enumerate(waypoints.orders, 1)}
    for number, order in enumerate(waypoints.orders, 1):
        if order.item is None:
            made.append(_wpl_row(added_item(order), [str(number), "0", *[""] * 9, "1"]))
            continue
        row = list(rows[order.item][1])
        item = _wpl_item(row, waypoints.name)
        moved = changed_item(item, order)
        if moved != item:
            row = _wpl_row(moved, row)
        row[0] = str(number)
        if item.command == JUMP:
            row[4] = str(numbers[int(item.numbers[0])])
        made.append(row)
    if waypoints.home is not None and waypoints.home[2] is not None and float(made[0][10]) != waypoints.home[2]:
        made[0] = [*made[0][:10], _number(waypoints.home[2]), made[0][11]]
    end = "\r\n" if "\r\n" in text else "\n"
    return (end.join([head, *("\t".join(row) for row in made)]) + end).encode()


def _rows(content: bytes, name: str) -> list[tuple[int, list[str]]]:
    """Return the items of a file as texts, each with the number of its line, or raise `InputError`."""
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(f"{name}: expected a text file in UTF-8, found something else at byte {error.start}") from None
    if not lines or lines[0].split() != WPL.split():
        raise InputError(f"{name}: expected a first line {WPL!r}, found {shown(lines[0] if lines else '')}")
    rows = [(number, line.split()) for number, line in enumerate(lines[1:], 2) if line.split("#")[0].strip()]
    for number, row in rows:
        if len(row) != 12:
            raise InputError(f"{name}: line {number}: expected 12 numbers, found {len(row)}")
    return rows


def _wpl_item(row: list[str], where: str) -> StoredItem:
    try:
        frame, command, *numbers = int(row[2]), int(row[3]), *map(float, row[4:11])
    except ValueError:
        raise InputError(f"{where}: expected numbers, found {shown(' '.join(row))}") from None
    return StoredItem(command, frame, numbers_of(numbers, where, zero_is_here=True))


def _wpl_row(item: StoredItem, row: list[str]) -> list[str]:
    """Return a row with the numbers of an item in it; those that are the same stay as they are written."""
    numbers = [
        text if text and (math.isnan(value) or float(text) == value) else _number(value)
        for text, value in zip(row[4:11], item.numbers, strict=True)
    ]
    return [*row[:2], str(item.frame), str(item.command), *numbers, row[11]]


def _number(value: float) -> str:
    return "NaN" if math.isnan(value) else f"{value:.10f}".rstrip("0").rstrip(".") or "0"
