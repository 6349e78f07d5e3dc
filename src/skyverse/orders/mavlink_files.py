"""QGroundControl's ``.plan`` and QGC WPL (``.waypoints``, ``.txt``): read as orders, changed, and made.

A file is changed where its orders are, and nowhere else: all other items, keys and numbers stay as they were. Items
that are added move the numbers of those after them, and with them the targets of jumps.
"""

import json
import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

from skyverse.documents.json import read_json
from skyverse.documents.limits import text_of
from skyverse.errors import InputError, shown
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude
from skyverse.model.waypoints import Geofence, Order, OrderKind, Waypoints
from skyverse.orders.mavlink_items import (
    FRAMES,
    MISSION_FRAME,
    Command,
    StoredItem,
    added_item,
    changed_item,
    frame_of,
    numbers_of,
    order_of,
)
from skyverse.orders.places import Given, parse_place, written
from skyverse.orders.plan_schema import Plan, PlanFence, PlanItem, PlanLanding, PlanRally, checked

FIRMWARES: dict[object, Literal["px4", "ardupilot"]] = {12: "px4", 3: "ardupilot"}
"""MAV_AUTOPILOT_PX4, MAV_AUTOPILOT_ARDUPILOTMEGA."""
AEROPLANES = (1, 19, 20, 21, 22, 23, 24, 25)
"""MAV_TYPE_FIXED_WING and those of VTOLs."""
MULTIROTORS = (None, 0, 2, 3, 4, 13, 14, 15, 29, 35, 43)
"""MAV_TYPE_GENERIC and those of helicopters of any number of rotors; ``None`` where a file does not say it."""
NEITHER = {10: ", a ground rover", 11: ", a boat", 12: ", a submarine"}
"""Names of the MAV_TYPEs of other vehicles that have missions."""
QGC_ALTITUDE_MODES: dict[type[Altitude], int] = {AboveHome: 1, AboveSea: 2, AboveGround: 4}
"""QGroundControl's numbers for what altitudes are counted from."""
NO_MISSION = (*range(5000, 5005), 5100)
"""MAV_CMD_NAV_FENCE_... and MAV_CMD_NAV_RALLY_POINT."""
WPL, WPL_WITHOUT_HOME = "QGC WPL 110", "QGC WPL 120"
"""How files of rows begin; QGroundControl wrote the second until 2016, whose first row is no home but an item
(MissionController.cc, _loadTextMissionFile)."""
STORED_IN = ("TransectStyleComplexItem", "Items")
"""Where survey and corridor items have the items that they stand for."""
_SIDES = (True, False)
LANDINGS = {"fwLandingPattern": Command.LAND, "vtolLandingPattern": Command.VTOL_LAND}


class _Slot(NamedTuple):
    """An item of a file, in the list that holds it; jumps lead to it by its `id`."""

    holder: list[Any]
    data: Any
    where: str
    id: int
    item: StoredItem


def read_plan(content: bytes, name: str, _given: Given) -> Waypoints:
    """Return the orders of a ``.plan``; survey and corridor items are read by the items that they have stored."""
    data = read_json(content, name)
    plan = checked(Plan, data, name)
    mission, fence = plan.mission, plan.geo_fence or PlanFence()
    if fence.polygon or fence.circle:
        raise InputError(
            f"{name}: 'geoFence': expected version 2, found a polygon or circle of version 1, which QGroundControl "
            "ignores; draw it anew there"
        )
    if mission.vehicle_type not in (*MULTIROTORS, *AEROPLANES):
        number = mission.vehicle_type or 0
        said = f"expected a multirotor or an aeroplane, as 2 or 1, found {number:g}{NEITHER.get(int(number), '')}"
        raise InputError(f"{name}: mission.vehicleType: {said}")
    inside, outside = (tuple(tuple(one.polygon) for one in fence.polygons if one.inclusion is side) for side in _SIDES)
    discs = ([one.circle for one in fence.circles if one.inclusion is side] for side in _SIDES)
    circles_inside, circles_outside = (tuple((*disc.center, disc.radius) for disc in some) for some in discs)
    aeroplane = mission.vehicle_type in AEROPLANES
    return Waypoints(
        name,
        tuple(_orders(_plan_slots(data, name))),
        _home(mission.planned_home_position, f"{name}: mission.plannedHomePosition"),
        mission.cruise_speed if aeroplane else mission.hover_speed,
        FIRMWARES.get(mission.firmware_type),
        aeroplane,
        fence=Geofence(inside, outside, circles_inside, circles_outside),
        rally=tuple(
            (latitude, longitude, AboveHome(up))
            for latitude, longitude, up in (plan.rally_points or PlanRally()).points
        ),
    )


def plan_content(waypoints: Waypoints, before: Waypoints) -> bytes:
    """Return the ``.plan`` that was read with what orders have changed, and the orders without an item, put in."""
    plan = read_json(waypoints.stored, waypoints.name)
    mission = plan["mission"]
    _put_orders(waypoints, _plan_slots(plan, waypoints.name), mission["items"], _put_into_plan, plan_item)
    if waypoints.home not in (None, before.home):
        mission["plannedHomePosition"] = waypoints.home
    return (json.dumps(plan, indent=4, ensure_ascii=False) + "\n").encode()


def _orders(slots: Sequence[_Slot]) -> Iterator[Order]:
    """Yield the orders of a file's items; jumps lead to numbers, also those to tags, of which the first counts."""
    numbers: dict[float, int] = {slot.id: number for number, slot in enumerate(slots, 1)}
    tags = {s.item.numbers[0]: k for k, s in [*enumerate(slots, 1)][::-1] if s.item.command == Command.TAG}
    for number, slot in enumerate(slots, 1):
        order = order_of(slot.item, number, number - 1, f"{slot.where} ({number})")
        if order.kind is OrderKind.JUMP:
            targets = numbers if slot.item.command == Command.JUMP else tags
            if order.to is None or order.to not in targets:
                said = f"expected a jump to an item of the mission, found {order.to}"
                raise InputError(f"{slot.where} ({number}): {order.name}: {said}")
            order = replace(order, to=targets[order.to])
        yield order


def _put_orders(
    waypoints: Waypoints,
    slots: Sequence[_Slot],
    top: list[Any],
    put: Callable[[Any, StoredItem | None, int | None], None],
    made: Callable[[StoredItem, int], Any],
    first: int = 1,
) -> None:
    """Put orders into the items of a file.

    Parameters
    ----------
    waypoints, slots
        The orders, and the items.
    top
        The list that holds an item that is added before all others.
    put
        Puts an item and its number, where they are not to stay, into what the file has.
    made
        Makes what a file has for an item and its number.
    first
        The number of the first item.
    """
    numbered = list(enumerate(waypoints.orders, first))
    numbers = {slots[order.item].id: new for new, order in numbered if order.item is not None}
    longer, last = len(waypoints.orders) > len(slots), None
    added: dict[int, list[Any]] = defaultdict(list)
    for number, order in numbered:
        if order.item is None:
            added[id(last)].append(made(added_item(order), number))
            continue
        slot = slots[order.item]
        item, last = changed_item(slot.item, order), slot.data
        if longer and item.command == Command.JUMP:
            item = replace(item, numbers=(numbers[int(item.numbers[0])], *item.numbers[1:]))
        put(slot.data, item if item != slot.item else None, number if longer else None)
    for holder in {id(slot.holder): slot.holder for slot in slots}.values():
        holder[:] = [one for data in holder for one in (data, *added[id(data)])]
    top[:0] = added[id(None)]


def _plan_slots(plan: dict[str, Any], name: str) -> list[_Slot]:
    """Return the simple items in the order in which they are flown, also those that complex items have stored.

    Landing patterns become the items that they stand for, from which QGroundControl makes them again.
    """
    items, found = plan["mission"]["items"], list[tuple[list[Any], dict[str, Any], str]]()
    items[:] = [one for k, data in enumerate(items, 1) for one in _without_landing(data, f"{name}: item {k}")]
    for number, data in enumerate(items, 1):
        where, kind = f"{name}: item {number}", data.get("complexItemType")
        if data.get("type") == "SimpleItem":
            found.append((items, data, where))
            continue
        if data.get("type") != "ComplexItem" or not isinstance(kind, str):
            said = f"expected 'SimpleItem' or 'ComplexItem', found {shown(data.get('type'))}"
            raise InputError(f"{where}: 'type': {said}")
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
            found.append((stored, inner, f"{where} ({kind}), stored item {one}"))
    zero_is_here = FIRMWARES.get(plan["mission"].get("firmwareType")) != "px4"
    return [_plan_slot(*one, number, zero_is_here) for number, one in enumerate(found, 1)]


def _plan_slot(holder: list[Any], data: dict[str, Any], where: str, number: int, zero_is_here: bool) -> _Slot:
    one = checked(PlanItem, data, where)
    params, place = data.get("params"), data.get("coordinate", [])  # which QGroundControl wrote apart until 2017
    if not isinstance(params, list) or not isinstance(place, list):
        raise InputError(f"{where}: 'params': expected seven numbers, found {shown(params)}")
    numbers = numbers_of([*params, *place], f"{where}: 'params'", zero_is_here=zero_is_here)
    item = StoredItem(one.command, one.frame, numbers)
    given = data.get("doJumpId", number)
    if given == 0:  # of an item that stands for a landing pattern
        data["doJumpId"] = given = number
    return _Slot(holder, data, where, given if isinstance(given, int) else number, item)


def _without_landing(data: dict[str, Any], where: str) -> list[dict[str, Any]]:
    """Return an item as it is, or for a landing pattern those of QGroundControl's LandingComplexItem.cc."""
    land = LANDINGS.get(str(data.get("complexItemType")))
    if land is None:
        return [data]
    one = checked(PlanLanding, data, where)
    around = one.loiter_radius if one.loiter_clockwise else -one.loiter_radius
    frame, rest = frame_of(AboveHome if one.altitudes_are_relative else AboveSea), [math.nan] * 6
    made: list[tuple[bool, int, int, Sequence[float]]] = [
        (True, Command.LAND_START, MISSION_FRAME, [0.0] * 7),
        (one.use_do_change_speed, Command.SPEED, MISSION_FRAME, (0.0, one.final_approach_speed, -1.0, *[0.0] * 4)),
        (one.stop_taking_photos, Command.PHOTO_DISTANCE, MISSION_FRAME, [0.0] * 7),
        (one.stop_taking_photos, Command.STOP_PHOTOS, MISSION_FRAME, (0.0, *rest)),
        (one.stop_video_photos, Command.STOP_VIDEO, MISSION_FRAME, (0.0, *rest)),
        (one.use_loiter_to_alt, Command.LOITER_TO_ALTITUDE, frame, (1.0, around, 0.0, 1.0, *one.approach)),
        (not one.use_loiter_to_alt, Command.WAYPOINT, frame, (0.0, 0.0, 0.0, math.nan, *one.approach)),
        (True, land, frame, (0.0, 0.0, 0.0, 0.0 if land is Command.LAND else math.nan, *one.land_coordinate)),
    ]
    return [plan_item(StoredItem(command, frame, tuple(numbers))) for told, command, frame, numbers in made if told]


def plan_item(item: StoredItem, number: int = 0) -> dict[str, Any]:
    """Return an item as a ``.plan`` has it."""
    made = {"autoContinue": True, "command": 0, "doJumpId": number, "frame": 0, "params": [None] * 7}
    made["type"] = "SimpleItem"
    if item.frame in FRAMES:
        made |= {"Altitude": None, "AltitudeMode": None, "AMSLAltAboveTerrain": None}
    _put_into_plan(made, item, number)
    return made


def _put_into_plan(data: dict[str, Any], item: StoredItem | None, number: int | None) -> None:
    """Put an item into a ``.plan``, with the copies of its altitude that QGroundControl shows."""
    if number is not None:
        data["doJumpId"] = number
    if item is None:
        return
    apart = "coordinate" in data
    former = [*data["params"][:4], *data["coordinate"]] if apart else data["params"]
    numbers = [old if math.isnan(new) or old == new else new for old, new in zip(former, item.numbers, strict=True)]
    data |= {"command": int(item.command), "frame": item.frame}
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


def _home(row: Sequence[float | None] | None, where: str) -> tuple[float, float, float | None] | None:
    """Return the planned place of take-off, ``None`` where it is not set: there, or at latitude and longitude 0."""
    latitude, longitude, metres = (math.nan if one is None else one for one in [*(row or ()), None, None, None][:3])
    if math.isnan(latitude + longitude) or latitude == longitude == 0:
        return None
    latitude, longitude, _ = parse_place((latitude, longitude, 0.0), AboveSea, where)
    return latitude, longitude, metres if math.isfinite(metres) else None


def read_wpl(content: bytes, name: str, _given: Given) -> Waypoints:
    """Return the orders of a QGC WPL file; item 0 of version 110 is home."""
    home, rest = _wpl_slots(content, name)
    known = rest or [slot for slot in (home,) if slot is not None]
    if known and all(slot.item.command in NO_MISSION for slot in known):
        raise InputError(f"{name}: expected a mission, found a geofence or rally points alone")
    if home is None:
        return Waypoints(name, tuple(_orders(rest)))
    if home.data[0] != "0" or home.item.command not in (0, Command.WAYPOINT):  # later numbers are counted
        raise InputError(
            f"{home.where}: expected item 0, a waypoint, which is home, found item {home.data[0]:.10} "
            f"with command {home.item.command}; ground stations take the first item for home"
        )
    kind, (latitude, longitude, metres) = FRAMES.get(home.item.frame), home.item.numbers[4:]
    placed = home.item.command == Command.WAYPOINT and kind in (AboveSea, AboveHome)
    above = metres if kind is AboveSea else None  # one above itself says nothing
    place = _home((latitude, longitude, above), home.where) if placed else None
    return Waypoints(name, tuple(_orders(rest)), place)


def wpl_content(waypoints: Waypoints, before: Waypoints) -> bytes:
    """Return the file that was read with what orders have changed, and the orders without an item, put in."""
    text = waypoints.stored.decode("utf-8-sig")
    home, rest = _wpl_slots(waypoints.stored, waypoints.name)
    rows = (home or rest[0]).holder
    _put_orders(waypoints, rest, rows, _put_into_row, wpl_row, first=int(home is not None))
    if home is not None and waypoints.home is not None and waypoints.home != before.home:
        latitude, longitude, metres = waypoints.home
        above = home.item.numbers[6] if metres is None else metres
        numbers = (*home.item.numbers[:4], latitude, longitude, above)
        _put_into_row(home.data, replace(home.item, numbers=numbers), None)
    end = "\r\n" if "\r\n" in text else "\n"
    whole = rows if home is None else [home.data, *rows]
    return (end.join([text.splitlines()[0], *map("\t".join, whole)]) + end).encode()


def _wpl_slots(content: bytes, name: str) -> tuple[_Slot | None, list[_Slot]]:
    """Return home, which is in no list, if a file has it, and its items; or raise `InputError`."""
    lines = text_of(content, name).splitlines()
    head = " ".join(lines[0].split()) if lines else ""
    if head not in (WPL, WPL_WITHOUT_HOME):
        raise InputError(f"{name}: expected a first line {WPL!r}, found {shown(lines[0] if lines else '')}")
    rows, slots = list[list[str]](), list[_Slot]()
    for number, line in enumerate(lines[1:], 2):
        if not line.split("#")[0].strip():
            continue
        row, where = line.split(), f"{name}: line {number}"
        if len(row) != 12:
            raise InputError(f"{where}: expected 12 numbers, found {len(row)}")
        try:
            frame, command, *numbers = int(row[2]), int(row[3]), *map(float, row[4:11])
        except ValueError:
            raise InputError(f"{where}: expected numbers, found {shown(' '.join(row))}") from None
        item = StoredItem(command, frame, numbers_of(numbers, where, zero_is_here=True))
        slots.append(_Slot(rows, row, where, len(slots), item))
    home = slots.pop(0) if slots and head == WPL else None
    rows += [slot.data for slot in slots]
    return home, slots


def wpl_row(item: StoredItem, number: int) -> list[str]:
    """Return an item as a row of a QGC WPL file."""
    row = ["", str(int(number == 0)), *[""] * 9, "1"]
    _put_into_row(row, item, number)
    return row


def _put_into_row(row: list[str], item: StoredItem | None, number: int | None) -> None:
    """Put an item into a row; numbers that are the same stay as they are written."""
    if number is not None:
        row[0] = str(number)
    if item is None:
        return
    row[2:4] = str(item.frame), str(int(item.command))
    for at, value in enumerate(item.numbers, 4):
        if not row[at] or not (math.isnan(value) or float(row[at]) == value):
            row[at] = "NaN" if math.isnan(value) else written(value)  # Mission Planner reads no other spelling
