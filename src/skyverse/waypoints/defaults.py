"""What autopilots do by default, taken where neither the file of a mission nor its pilot says it, and said."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from skyverse.errors import InputError
from skyverse.exports.autopilots import AUTOPILOTS, Autopilot, AutopilotName
from skyverse.model.flight_settings import FlightSettings
from skyverse.model.geodesy import told_globe
from skyverse.model.waypoints import Waypoints

MAX_VISITS = 20_000
"""Places that the orders of a mission may lead to, jumps unrolled."""
MAX_STEPS = 1_000_000
"""Orders that may be followed to get there."""
USUAL_CIRCLE = 10.0
"""Metres: CIRCLE_RADIUS of Copter."""


class Defaults(NamedTuple):
    """Defaults of an autopilot.

    Attributes
    ----------
    speed
        m/s: MPC_XY_CRUISE, WPNAV_SPEED; DJI's app asks for one.
    return_altitude
        Metres above home: RTL_RETURN_ALT of PX4's multirotors, RTL_ALT; DJI's usual setting.
    altitude_radius
        Metres above or below a waypoint from which PX4 goes on: NAV_MC_ALT_RAD.
    longest_leg
        Metres between two waypoints that it takes: MIS_DIST_WPS of PX4 until 1.15; DJI's SDK.
    most_items
        Items that usual boards take.
    cone
        The parameter with which returns near home are lower than the return altitude; parameter files set it to 0.
    """

    speed: float
    return_altitude: float
    altitude_radius: float
    longest_leg: float
    most_items: int
    cone: str = ""


DEFAULTS: dict[AutopilotName, Defaults] = {
    "px4": Defaults(5.0, 30.0, 0.8, 900.0, 2000, "RTL_CONE_ANG"),
    "ardupilot": Defaults(10.0, 15.0, 0.0, math.inf, 724, "RTL_CONE_SLOPE"),
    "dji": Defaults(5.0, 100.0, 0.0, 2000.0, 65_535),
}


@dataclass(frozen=True)
class Settled:
    """How a mission is flown where its orders do not say it.

    Attributes
    ----------
    autopilot, speed, radius, altitude_radius, return_altitude
        As of `FlightSettings`, all known.
    assumed
        What was taken from defaults, in words.
    """

    autopilot: Autopilot
    speed: float
    radius: float
    altitude_radius: float
    return_altitude: float
    assumed: tuple[str, ...]


def settled(waypoints: Waypoints, settings: FlightSettings, max_speed: float) -> Settled:
    """Return how a mission is flown by a vehicle of a greatest speed, m/s: as told, as in the file, or as usual."""
    usual: AutopilotName = "ardupilot" if waypoints.name.lower().endswith((".waypoints", ".txt")) else "px4"
    name = settings.autopilot or waypoints.autopilot
    autopilot = AUTOPILOTS[name or usual]._replace(stops=False, max_waypoints=MAX_VISITS + 1)  # no file is too long
    defaults, assumed = DEFAULTS[autopilot.name], [] if name else [f"it is flown by {autopilot.title}"]
    if settings.home is None and waypoints.home is None:
        north, east = home_of(waypoints, settings)
        assumed.append(f"home is taken to be at its first place, {told_globe(north, east)}")
    if defaults.cone:
        assumed.append(f"it returns on one level, without a cone ({defaults.cone} 0)")
    speeds = (settings.speed, waypoints.speed, min(defaults.speed, max_speed))
    speed = next(one for one in speeds if one is not None)
    if settings.speed is None:
        planned = "" if waypoints.speed is None else ", as its file plans; set the vehicle so"
        assumed.append(f"it flies {speed:g} m/s where it says no speed{planned}")
    fence = waypoints.fence
    if autopilot.name == "px4" and len(fence.inside) + len(fence.circles_inside) > 1:
        assumed.append("it stays in any area of its fence; from 2026 on, PX4 asks that it stays in all")
    heights = (settings.return_altitude, waypoints.return_altitude, defaults.return_altitude)
    level = next(one for one in heights if one is not None)
    if settings.return_altitude is None and waypoints.return_altitude is None:
        assumed.append(f"it returns at {level:g} m above home, as {autopilot.title} does by default")
    upright = settings.altitude_radius if autopilot.name == "px4" else None
    upright = defaults.altitude_radius if upright is None else upright
    return Settled(autopilot, speed, settings.radius, upright, level, tuple(assumed))


def home_of(waypoints: Waypoints, settings: FlightSettings) -> tuple[float, float]:
    """Return latitude and longitude of the place of take-off: as told, as in the file, or the first place."""
    if settings.home is not None:
        return settings.home
    if waypoints.home is not None:
        return waypoints.home[:2]
    for order in waypoints.orders:
        if order.place is not None and any(order.place[:2]) and math.isfinite(order.place[0]):
            return order.place[:2]
    raise InputError(f"{waypoints.name}: expected a place to fly to, found none")
