"""What the autopilot of one vehicle is told, in order, whoever wrote it: places to fly to, and what to do there."""

from dataclasses import dataclass
from enum import Enum
from typing import Literal

from skyverse.model.altitude import GlobalPlace

Ring = tuple[tuple[float, float], ...]
"""Latitude and longitude of the corners of a polygon, degrees."""


class OrderKind(Enum):
    """What kind of thing an autopilot is told."""

    WAYPOINT = "waypoint"
    TAKEOFF = "take-off"
    LAND = "landing"
    RETURN = "return"
    LOITER = "loiter"
    SPEED = "speed"
    HEADING = "heading"
    GIMBAL = "gimbal"
    LOOK_AT = "region of interest"
    CAMERA = "camera"
    JUMP = "jump"
    DELAY = "delay"
    GATE = "gate"
    PASSED_ON = "passed on, moves nothing"
    OTHER = "not followed, may lead elsewhere"


@dataclass(frozen=True)
class Order:
    """One thing that an autopilot is told.

    Attributes
    ----------
    number
        What ground stations call it: home is 0 in files of MAVLink items, and the first waypoint is 1 elsewhere.
    kind, name
        What it is, and what the file calls it.
    item
        Which of the file's items it is, counted from 0; ``None`` for one that its file does not have yet.
    place
        Latitude, longitude and altitude; ``None`` where the file names no place. Latitude and longitude are NaN where
        the vehicle stays above where it is.
    radius
        Metres: of a waypoint that within which the vehicle may turn to the next, of a loiter that of its circle;
        ``None`` where the autopilot's own setting counts.
    seconds
        How long the vehicle stays there, or waits; infinite for a loiter without an end.
    turns
        How often it circles.
    speed
        m/s over ground, from here on; of a waypoint, on the leg after it.
    heading
        Degrees clockwise from north.
    spacing
        Metres between two photos, from here on; 0 ends it.
    to, times
        The number of the order to which it jumps, and how often; -1 is for ever. Of a camera, how many photos it takes.
    curved
        Whether the legs at it are flown in curves that nobody publishes.
    """

    number: int
    kind: OrderKind
    name: str
    item: int | None = None
    place: GlobalPlace | None = None
    radius: float | None = None
    seconds: float = 0.0
    turns: float = 0.0
    speed: float | None = None
    heading: float | None = None
    spacing: float | None = None
    to: int | None = None
    times: int = 0
    curved: bool = False


@dataclass(frozen=True)
class Geofence:
    """The areas to stay in and to stay out of, as the file of a mission has them.

    Attributes
    ----------
    inside, outside
        Polygons to stay in, and to stay out of.
    circles_inside, circles_outside
        Latitude, longitude and radius, metres, of circles to stay in, and to stay out of.
    """

    inside: tuple[Ring, ...] = ()
    outside: tuple[Ring, ...] = ()
    circles_inside: tuple[tuple[float, float, float], ...] = ()
    circles_outside: tuple[tuple[float, float, float], ...] = ()

    def __bool__(self) -> bool:
        return bool(self.inside or self.outside or self.circles_inside or self.circles_outside)


@dataclass(frozen=True)
class Waypoints:
    """What one vehicle's autopilot is told, in order.

    Attributes
    ----------
    name
        The name of the file.
    orders
        In the order in which the file has them.
    home
        Latitude and longitude of the planned place of take-off, and its metres above mean sea level, where it says so.
    speed
        m/s over ground until an order changes it; ``None`` where the autopilot's own setting counts.
    autopilot
        ``"px4"``, ``"ardupilot"`` or ``"dji"``; ``None`` where the file does not say it.
    aeroplane
        Whether the file is for one.
    return_altitude
        Metres above home at which the vehicle returns; ``None`` where the file does not say it.
    ground_followed
        Whether legs between heights above ground follow it. If not, as Litchi's, they are straight, and such a height
        is one above home, more by how much higher the ground is there than below the first waypoint.
    retraces
        Whether it returns along its mission in place of straight home: PX4 with ``RTL_TYPE`` 2, Copter by SmartRTL.
    fence, rally
        The geofence, and places to return to in place of home.
    told
        What the reader was told because the file does not say it: what altitudes are counted from, and how many metres
        mean sea level lies above the ellipsoid.
    stored
        The file's content: what a writer changes and otherwise keeps as it is.
    """

    name: str
    orders: tuple[Order, ...]
    home: tuple[float, float, float | None] | None = None
    speed: float | None = None
    autopilot: Literal["px4", "ardupilot", "dji"] | None = None
    aeroplane: bool = False
    return_altitude: float | None = None
    ground_followed: bool = True
    retraces: bool = False
    fence: Geofence = Geofence()
    rally: tuple[GlobalPlace, ...] = ()
    told: tuple[str | None, float | None] = (None, None)
    stored: bytes = b""

    @property
    def passed_on(self) -> dict[str, list[int]]:
        """The numbers of the orders that move nothing and are passed on, by what the file calls them."""
        found: dict[str, list[int]] = {}
        for order in self.orders:
            if order.kind is OrderKind.PASSED_ON:
                found.setdefault(order.name, []).append(order.number)
        return found
