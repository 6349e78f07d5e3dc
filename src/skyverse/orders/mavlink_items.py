"""MAVLink's mission items as orders: which numbers of each command mean what, and which are kept word for word."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from types import MappingProxyType
from typing import Any, TypeGuard

from skyverse.errors import InputError, is_number, shown
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude
from skyverse.model.waypoints import Order, OrderKind

FRAMES: dict[int, type[Altitude]] = {
    **{0: AboveSea, 3: AboveHome, 10: AboveGround},  # MAV_FRAME_GLOBAL, _RELATIVE_ALT, _TERRAIN_ALT
    **{5: AboveSea, 6: AboveHome, 11: AboveGround},  # the same with whole numbers: MAV_FRAME_GLOBAL_INT ...
}
MISSION_FRAME = 2
"""MAV_FRAME_MISSION: of commands without a place."""
FOR_EVER = -1


class Command(IntEnum):
    """Numbers of MAV_CMD that are written, or read by rules of their own."""

    WAYPOINT = 16
    LOITER = 17
    RETURN = 20
    LAND = 21
    TAKEOFF = 22
    LOITER_TO_ALTITUDE = 31
    VTOL_LAND = 85
    DELAY = 93
    YAW = 115
    JUMP = 177
    SPEED = 178
    LAND_START = 189
    LOOK_AT = 195
    REGION_OF_INTEREST = 201
    PHOTO = 203
    GIMBAL = 205
    PHOTO_DISTANCE = 206
    CAMERA_MODE = 530
    TAG = 600
    START_PHOTOS = 2000
    STOP_PHOTOS = 2001
    STOP_VIDEO = 2501


@dataclass(frozen=True)
class _Meaning:
    """What a command is: its kind, name, whether it is of a place, and its numbers by the fields of an order."""

    kind: OrderKind
    name: str
    of_place: bool = False
    numbers: dict[str, int] = field(default_factory=dict)


_K = OrderKind
_MOVE_NOTHING = {
    181: "DO_SET_RELAY", 182: "DO_REPEAT_RELAY", 183: "DO_SET_SERVO", 184: "DO_REPEAT_SERVO", 187: "DO_SET_ACTUATOR",
    188: "DO_RETURN_PATH_START", 189: "DO_LAND_START", 196: "DO_SET_ROI_WPNEXT_OFFSET", 198: "DO_SET_ROI_SYSID",
    200: "DO_CONTROL_VIDEO", 202: "DO_DIGICAM_CONFIGURE", 204: "DO_MOUNT_CONFIGURE", 207: "DO_FENCE_ENABLE",
    211: "DO_GRIPPER", 215: "DO_SET_RESUME_REPEAT_DIST", 216: "DO_SPRAYER", 220: "DO_MOUNT_CONTROL_QUAT",
    405: "ILLUMINATOR_ON_OFF", 406: "DO_ILLUMINATOR_CONFIGURE", 531: "SET_CAMERA_ZOOM", 532: "SET_CAMERA_FOCUS",
    534: "SET_CAMERA_SOURCE", 600: "JUMP_TAG", 1001: "DO_GIMBAL_MANAGER_CONFIGURE", 2003: "DO_TRIGGER_CONTROL",
    42600: "DO_WINCH",
}  # fmt: skip
_NOT_FOLLOWED = {
    30: "NAV_CONTINUE_AND_CHANGE_ALT", 34: "DO_ORBIT", 83: "NAV_ALTITUDE_WAIT", 92: "NAV_GUIDED_ENABLE",
    94: "NAV_PAYLOAD_PLACE", 113: "CONDITION_CHANGE_ALT", 176: "DO_SET_MODE", 179: "DO_SET_HOME",
    185: "DO_FLIGHTTERMINATION", 186: "DO_CHANGE_ALTITUDE", 192: "DO_REPOSITION", 194: "DO_SET_REVERSE",
    208: "DO_PARACHUTE", 212: "DO_AUTOTUNE_ENABLE", 218: "DO_AUX_FUNCTION", 222: "DO_GUIDED_LIMITS",
    223: "DO_ENGINE_CONTROL", 3000: "DO_VTOL_TRANSITION", 42702: "NAV_SCRIPT_TIME",
}  # fmt: skip
MEANINGS = MappingProxyType(
    {
        16: _Meaning(_K.WAYPOINT, "NAV_WAYPOINT", True, {"seconds": 0, "radius": 1, "heading": 3}),
        17: _Meaning(_K.LOITER, "NAV_LOITER_UNLIM", True, {"radius": 2}),
        18: _Meaning(_K.LOITER, "NAV_LOITER_TURNS", True, {"turns": 0, "radius": 2}),
        19: _Meaning(_K.LOITER, "NAV_LOITER_TIME", True, {"seconds": 0, "radius": 2}),
        20: _Meaning(_K.RETURN, "NAV_RETURN_TO_LAUNCH"),
        21: _Meaning(_K.LAND, "NAV_LAND", True, {"heading": 3}),
        22: _Meaning(_K.TAKEOFF, "NAV_TAKEOFF", True, {"heading": 3}),
        31: _Meaning(_K.LOITER, "NAV_LOITER_TO_ALT", True, {"radius": 1}),
        82: _Meaning(_K.WAYPOINT, "NAV_SPLINE_WAYPOINT", True, {"seconds": 0}),
        84: _Meaning(_K.TAKEOFF, "NAV_VTOL_TAKEOFF", True, {"heading": 3}),
        85: _Meaning(_K.LAND, "NAV_VTOL_LAND", True, {"heading": 3}),
        93: _Meaning(_K.DELAY, "NAV_DELAY", False, {"seconds": 0}),
        112: _Meaning(_K.GATE, "CONDITION_DELAY", False, {"seconds": 0}),
        114: _Meaning(_K.GATE, "CONDITION_DISTANCE"),
        115: _Meaning(_K.HEADING, "CONDITION_YAW", False, {"heading": 0}),
        177: _Meaning(_K.JUMP, "DO_JUMP", False, {"to": 0, "times": 1}),
        178: _Meaning(_K.SPEED, "DO_CHANGE_SPEED", False, {"speed": 1}),
        195: _Meaning(_K.LOOK_AT, "DO_SET_ROI_LOCATION", True),
        197: _Meaning(_K.LOOK_AT, "DO_SET_ROI_NONE"),
        201: _Meaning(_K.LOOK_AT, "DO_SET_ROI", True),
        203: _Meaning(_K.CAMERA, "DO_DIGICAM_CONTROL", False, {"times": 4}),
        205: _Meaning(_K.GIMBAL, "DO_MOUNT_CONTROL"),
        206: _Meaning(_K.CAMERA, "DO_SET_CAM_TRIGG_DIST", False, {"spacing": 0}),
        214: _Meaning(_K.CAMERA, "DO_SET_CAM_TRIGG_INTERVAL"),
        530: _Meaning(_K.CAMERA, "SET_CAMERA_MODE"),
        601: _Meaning(_K.JUMP, "DO_JUMP_TAG", False, {"to": 0, "times": 1}),
        1000: _Meaning(_K.GIMBAL, "DO_GIMBAL_MANAGER_PITCHYAW"),
        2000: _Meaning(_K.CAMERA, "IMAGE_START_CAPTURE", False, {"times": 2}),
        2001: _Meaning(_K.CAMERA, "IMAGE_STOP_CAPTURE"),
        2500: _Meaning(_K.CAMERA, "VIDEO_START_CAPTURE"),
        2501: _Meaning(_K.CAMERA, "VIDEO_STOP_CAPTURE"),
        4501: _Meaning(_K.GATE, "CONDITION_GATE", True),
        **{number: _Meaning(_K.PASSED_ON, name) for number, name in _MOVE_NOTHING.items()},
        **{number: _Meaning(_K.OTHER, name) for number, name in _NOT_FOLLOWED.items()},
    }
)
"""By the number of the MAV_CMD; all others may lead anywhere."""
MOST_PHOTOS = 100_000
"""Photos of one item that are counted."""
_USUAL_IF_ZERO = ("radius",)
"""Fields that 0 leaves to the autopilot's own setting."""


@dataclass(frozen=True)
class StoredItem:
    """One item: its command, its frame and seven numbers, of which the last three may be a place; NaN is left open."""

    command: int
    frame: int
    numbers: tuple[float, ...]


def order_of(item: StoredItem, number: int, index: int, where: str) -> Order:
    """Return what an item tells, or raise `InputError` if its numbers cannot be; `where` names it in messages."""
    meaning, told = _meaning(item), dict[str, Any]()
    for name, at in meaning.numbers.items():
        value = item.numbers[at]
        if math.isnan(value) or (name in _USUAL_IF_ZERO and value == 0):
            continue
        if meaning.kind is OrderKind.CAMERA and name == "times" and value not in range(MOST_PHOTOS):
            continue  # photos without an end, or something else
        least = {"times": FOR_EVER, "heading": -math.inf, "radius": -math.inf, "speed": -math.inf}.get(name, 0.0)
        if not least <= value < math.inf or (name in ("to", "times") and value != int(value)):
            what = f"a number of at least {least:g}" if least > -math.inf else "a number"
            raise InputError(f"{where}: {meaning.name}, parameter {at + 1}: expected {what}, found {value:g}")
        told[name] = int(value) if name in ("to", "times") else value
    if told.get("radius", 0.0) < 0:  # the circle's direction, or that a vehicle passes on that side
        told["radius"] = -told["radius"]
    if told.get("speed", 0.0) < 0 or (meaning.kind is OrderKind.SPEED and item.numbers[0] > 1):
        told.pop("speed", None)  # it stays as it is, or another speed is meant: that of climbs or descents
    if meaning.kind is OrderKind.HEADING and item.numbers[3] == 1:  # so far from the heading that it has
        told.pop("heading", None)
    if meaning.kind is OrderKind.LOITER and "turns" not in told and "seconds" not in told:
        told["seconds"] = 0.0 if item.command == Command.LOITER_TO_ALTITUDE else math.inf
    curved = meaning.name == "NAV_SPLINE_WAYPOINT"
    place = _place(item, f"{where}: {meaning.name}") if meaning.of_place else None
    return Order(number, meaning.kind, meaning.name, index, place, curved=curved, **told)


def _meaning(item: StoredItem) -> _Meaning:
    meaning = MEANINGS.get(item.command, _Meaning(OrderKind.OTHER, f"MAV_CMD {item.command}"))
    until = item.command == Command.DELAY and item.numbers[0] == -1  # a time of the day
    return _Meaning(OrderKind.OTHER, meaning.name) if until else meaning


def _place(item: StoredItem, where: str) -> tuple[float, float, Altitude] | None:
    """Return an item's place; latitude and longitude are NaN where they are left to the autopilot."""
    latitude, longitude, metres = item.numbers[4:7]
    frame = FRAMES.get(item.frame)
    if frame is None:
        if item.command not in (Command.RETURN, Command.REGION_OF_INTEREST, Command.TAKEOFF):
            raise InputError(f"{where}: expected a frame from {', '.join(map(str, FRAMES))}, found {item.frame}")
        return None
    for name, value, most in (("latitude", latitude, 90.0), ("longitude", longitude, 180.0)):
        if abs(value) > most:
            raise InputError(f"{where}: expected a {name} of at most {most:g} degrees, found {value:g}")
    if not math.isfinite(metres):
        if item.command == Command.LAND and math.isnan(metres):  # a landing goes down, wherever that ends
            return latitude, longitude, frame(0.0)
        raise InputError(f"{where}: expected an altitude, metres, found {metres:g}")
    return latitude, longitude, frame(metres)


def changed_item(item: StoredItem, order: Order) -> StoredItem:
    """Return an item with the place and the numbers of an order, and with all else as it is."""
    meaning = _meaning(item)
    was, numbers = order_of(item, order.number, 0, ""), list(item.numbers)
    for name, at in meaning.numbers.items():
        now = getattr(order, name)
        if name not in ("to", "times") and now is not None and now != getattr(was, name):
            numbers[at] = now
    frame = item.frame
    if order.place is not None and order.place != was.place:
        *numbers[4:6], altitude = order.place
        numbers[6] = altitude.metres
        frame = frame if FRAMES.get(frame) is type(altitude) else frame_of(type(altitude))
    lands = order.kind is OrderKind.LAND and was.kind is OrderKind.RETURN
    return StoredItem(Command.LAND if lands else item.command, frame, tuple(numbers))


def added_item(order: Order) -> StoredItem:
    """Return an item for an order that no file has yet: a wait, or a waypoint that is passed without a stop."""
    if order.place is None:
        return StoredItem(Command.DELAY, MISSION_FRAME, (order.seconds, -1.0, -1.0, -1.0, 0.0, 0.0, 0.0))
    *where, altitude = order.place
    numbers = (order.seconds, order.radius or 0.0, 0.0, math.nan, *where, altitude.metres)
    return StoredItem(Command.WAYPOINT, frame_of(type(altitude)), numbers)


def frame_of(kind: type[Altitude]) -> int:
    """Return the frame of places whose altitudes are of a kind."""
    return next(number for number, altitude in FRAMES.items() if altitude is kind)


def numbers_of(values: Sequence[object], where: str, *, zero_is_here: bool) -> tuple[float, ...]:
    """Return an item's seven numbers, of which ``None`` is NaN, or raise `InputError`.

    Parameters
    ----------
    values
        What the file has.
    where
        What messages name.
    zero_is_here
        Whether latitude and longitude 0 leave the place to the autopilot, as for ArduPilot.
    """
    if len(values) != 7 or any(one is not None and one == one and not _is_sound(one) for one in values):
        raise InputError(f"{where}: expected seven numbers, found {shown(list(values))}")
    # always the same NaN, so that rows of numbers that are alike are equal
    numbers = [float(one) if _is_sound(one) else math.nan for one in values]
    if zero_is_here and numbers[4] == numbers[5] == 0:
        numbers[4] = numbers[5] = math.nan
    return tuple(numbers)


def _is_sound(value: object) -> TypeGuard[float]:
    return is_number(value) and abs(value) < 1e30
