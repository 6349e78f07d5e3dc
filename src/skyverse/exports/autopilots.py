"""What is known of the autopilots that fly exported waypoints: PX4, ArduPilot Copter and DJI's.

The rates of PX4 and ArduPilot are the defaults of the named parameters, and their limits are the largest values that
these parameters may have by their documentation; an export writes the rates into a parameter file, so that they hold.
DJI documents none for waylines, and its file cannot set any: there they are assumptions.
"""

import math
from typing import Literal, NamedTuple

import numpy as np

from skyverse.errors import InputError, require_number
from skyverse.exports.global_positions import AltitudeReference
from skyverse.model.uav import UAV

AutopilotName = Literal["px4", "ardupilot", "dji"]
DJI_SUFFIXES = (".wpml.kmz", ".litchi.csv")
"""The files that aircraft of DJI fly: by its own app, and by Litchi."""
End = Literal["loiter", "land", "rtl"]
"""What a UAV does at its last waypoint."""


class AutopilotRates(NamedTuple):
    """How fast an autopilot flies where the mission does not say.

    Attributes
    ----------
    takeoff, climb, descent
        m/s: of the first climb, and up and down on legs.
    acceleration
        m/s^2: horizontally, to start and to stop.
    takeoff_height
        Metres above home from which the first climb goes on at the rate of `climb`.
    vertical_acceleration
        m/s^2: up and down on legs, and above `takeoff_height`.
    takeoff_acceleration
        m/s^2: of the first climb up to `takeoff_height`.
    startup
        Seconds from the command to take off until the UAV rises.
    jerk
        m/s^3: how fast the acceleration changes on legs.
    """

    takeoff: float
    climb: float
    descent: float
    acceleration: float
    takeoff_height: float = math.inf
    vertical_acceleration: float = math.inf
    takeoff_acceleration: float = math.inf
    startup: float = 0.0
    jerk: float = math.inf


class Acceptance(NamedTuple):
    """When an autopilot goes on from a place: how far it may be beside it, and above or below it, metres."""

    radius: float
    altitude: float


ACCEPTANCE = {"px4": Acceptance(1.0, 0.5), "ardupilot": Acceptance(0.0, 0.0), "dji": Acceptance(0.0, 0.0)}
"""On a return: `NAV_ACC_RAD` and at most `NAV_MC_ALT_RAD` of PX4's parameter file; the others come to a stop first."""
RETURN_ALTITUDES = {"px4": (2 * ACCEPTANCE["px4"].radius, math.inf), "ardupilot": (0.3, 3000.0), "dji": (2.0, 1500.0)}
"""Metres above home: the least and the greatest return altitude that an autopilot keeps to: PX4 1.14 climbs at least to
twice its acceptance radius; the others are what files can name, `RTL_ALT` and `globalRTHHeight`."""
MIN_ACCEPTANCE_RADIUS = 0.1
"""Metres: PX4 takes no smaller one for the level distance and the altitude together."""
PX4_TAKEOFF_RAMP = 3.0
"""Seconds in which PX4 accelerates a take-off to its climb rate: `MPC_TKO_RAMP_T`."""
PX4_GROUND_SPEED = 0.7
"""m/s down: the speed from which PX4 accelerates on the ground, so that it does not rise before that is made up for."""
PX4_SPOOL_UP = 2.0
"""Seconds that PX4 waits at least before a take-off: `COM_SPOOLUP_TIME` after arming, 1 s, ends meanwhile."""
SECONDS_TO_STOP = 0.9
"""How far away PX4 may begin to count a stop, as seconds at its speed: less than half of those that it stops."""
PX4_ALTITUDE_RADII = (0.05, 0.5)
"""Metres: the least `NAV_MC_ALT_RAD` that PX4 takes, and the greatest that is written, which its returns count on."""


class Autopilot(NamedTuple):
    """One kind of autopilot.

    Attributes
    ----------
    name, title
        What options and sentences call it.
    rates
        Its rates where the UAV states none.
    limits
        The highest rates that it can be told to fly at.
    stops
        Whether it stops at every waypoint, and so cuts no corner.
    waits_above
        Whether a UAV that departs later waits at its first waypoint, because the file cannot tell it to wait below.
    max_speed
        The highest speed that may be commanded, m/s.
    max_waypoints
        The largest number of waypoints that one file may have.
    plane_radius
        Metres: the least acceptance radius of a waypoint that it keeps to with an aeroplane.
    least_delay
        Seconds that a multirotor waits at least before it takes off, for its motors to spool up.
    rises
        The least and the greatest height above the place of take-off, metres, to which its file can tell it to rise
        before it flies to the first waypoint; ``None`` where the mission has a take-off of any height.
    """

    name: AutopilotName
    title: str
    rates: AutopilotRates
    limits: AutopilotRates
    stops: bool
    waits_above: bool
    max_speed: float
    max_waypoints: int
    plane_radius: float
    least_delay: float = 0.0
    rises: tuple[float, float] | None = None


AUTOPILOTS: dict[AutopilotName, Autopilot] = {
    # rates: MPC_TKO_SPEED, MPC_Z_V_AUTO_UP, MPC_Z_V_AUTO_DN, MPC_ACC_HOR; below MPC_LAND_ALT1 for takeoff;
    # MPC_ACC_DOWN_MAX, MPC_JERK_AUTO; `takeoff_ramp` for the acceleration at take-off
    # the highest speed: MPC_XY_VEL_MAX and MPC_XY_CRUISE
    "px4": Autopilot(
        "px4",
        "PX4",
        rates=AutopilotRates(1.5, 3.0, 1.5, 3.0, takeoff_height=10.0, vertical_acceleration=3.0, jerk=4.0),
        limits=AutopilotRates(5.0, 8.0, 4.0, 15.0),
        stops=False,
        waits_above=False,
        max_speed=20.0,
        max_waypoints=700,
        plane_radius=math.inf,  # only a multirotor turns at the radius of its waypoints: `MissionBlock`
        least_delay=PX4_SPOOL_UP,
    ),
    # rates: WPNAV_SPEED_UP for takeoff and climb, WPNAV_SPEED_DN, WPNAV_ACCEL; the highest speed: WPNAV_SPEED;
    # WPNAV_ACCEL_Z, WPNAV_JERK; until it rises MOT_SPOOL_TIME, 0.5 s, and TKOFF_SLEW_TIME, 2 s, up to a hover at 35 %
    "ardupilot": Autopilot(
        "ardupilot",
        "ArduPilot",
        rates=AutopilotRates(2.5, 2.5, 1.5, 2.5, vertical_acceleration=1.0, startup=1.2, jerk=1.0),
        limits=AutopilotRates(10.0, 10.0, 5.0, 5.0),
        stops=False,
        waits_above=False,
        max_speed=20.0,
        max_waypoints=700,
        plane_radius=1.0,  # it keeps whole metres, and turns where it will if that is 0: `Plane::verify_nav_wp`
    ),
    "dji": Autopilot(
        "dji",
        "DJI",
        rates=AutopilotRates(3.0, 3.0, 2.0, 2.5, vertical_acceleration=2.5, startup=2.0),
        limits=AutopilotRates(math.inf, math.inf, math.inf, math.inf),
        stops=True,
        waits_above=True,
        max_speed=15.0,
        max_waypoints=99,
        plane_radius=math.inf,
        rises=(1.2, 1500.0),
    ),
}


def autopilot_for(suffix: str, altitude: AltitudeReference, asked: AutopilotName | None) -> Autopilot:
    """Return the autopilot that a file is for; raise `InputError` if the format is not for the one that is asked for.

    Without a wish ``.plan`` is for PX4, but with altitudes above ground, which PX4 rejects, it is for ArduPilot.
    """
    if suffix in DJI_SUFFIXES:
        allowed: tuple[AutopilotName, ...] = ("dji",)
    elif altitude == "agl":
        allowed = ("ardupilot",)
    else:
        allowed = ("px4", "ardupilot") if suffix == ".plan" else ("ardupilot", "px4")
    name = asked or allowed[0]
    if name not in allowed:
        above = " with altitudes above ground" if altitude == "agl" and suffix not in DJI_SUFFIXES else ""
        raise InputError(f"{suffix}{above}: expected an autopilot from {', '.join(allowed)}, found {name!r}")
    return AUTOPILOTS[name]


def rates_of(vehicle: UAV, autopilot: Autopilot) -> AutopilotRates:
    """Return the rates of a UAV under an autopilot: no faster than the UAV itself and its autopilot climb and descend.

    An aeroplane does not stop, and its climb is limited by its angle: for it, all rates are infinite.
    """
    if vehicle.fixed_wing is not None:
        return AutopilotRates(math.inf, math.inf, math.inf, math.inf)
    usual, most = autopilot.rates, autopilot.limits
    climb = usual.climb if vehicle.max_climb is None else min(vehicle.max_climb, most.climb)
    descent = usual.descent if vehicle.max_descent is None else min(vehicle.max_descent, most.descent)
    takeoff = climb if usual.takeoff == usual.climb else min(usual.takeoff, climb)
    acceleration = min(usual.acceleration, vehicle.max_acceleration)
    vertical = min(usual.vertical_acceleration, vehicle.max_acceleration)
    made = usual._replace(takeoff=takeoff, climb=climb, descent=descent, acceleration=acceleration)
    made = made._replace(vertical_acceleration=vertical, takeoff_acceleration=vertical)
    return takeoff_ramp(made) if autopilot.name == "px4" else made


def takeoff_ramp(rates: AutopilotRates) -> AutopilotRates:
    """Return rates with how PX4 takes off: slowly up to its climb rate, after it has made up for a speed downwards.

    So do `FlightTaskAuto::_updateTrajConstraints` and `FlightTaskAuto::reActivate` of PX4 1.14 to 1.16.
    """
    acceleration = min(rates.takeoff / PX4_TAKEOFF_RAMP, rates.vertical_acceleration)
    return rates._replace(takeoff_acceleration=acceleration, startup=PX4_GROUND_SPEED / acceleration)


def corner_acceptance(autopilot: Autopilot, radius: float) -> Acceptance:
    """Return what an autopilot is told so that it turns within a radius of a waypoint, metres.

    PX4 asks for the level distance and for the altitude, each by itself: on a steep leg it may turn before it is within
    the level distance along that leg. So both together are within the radius.
    """
    if autopilot.name != "px4":
        return Acceptance(radius, radius)
    altitude = float(np.clip(radius / 2, *PX4_ALTITUDE_RADII))
    return Acceptance(math.sqrt(max(radius**2 - altitude**2, 0.0)), altitude)


def takeoff_cut(name: AutopilotName, radius: float) -> float:
    """Return how far below its first waypoint a multirotor may turn to the next, metres: PX4 ends a take-off there."""
    return corner_acceptance(AUTOPILOTS[name], radius).altitude if name == "px4" else 0.0


LOOKS: dict[AutopilotName, float] = {"px4": 0.05, "ardupilot": 0.02, "dji": 0.0}
"""Seconds between two looks of an autopilot at the distance: `CameraTrigger::Run`, `AP_Camera_Backend::update`."""


def trigger_lead(name: AutopilotName, radius: float, slope: float) -> float:
    """Return how many metres behind a photo a waypoint lies at which an autopilot switches a camera on in flight.

    PX4 does what comes after a waypoint when it is near: within its level radius, and on a leg that rises or falls by
    `slope` near in altitude, too. ArduPilot does it between its radius and the waypoint, DJI's at the waypoint.
    """
    if name == "dji":
        return 0.0
    near = corner_acceptance(AUTOPILOTS[name], radius)
    return min(near.radius, near.altitude / slope if slope else math.inf) if name == "px4" else radius / 2


def stop_acceptance(autopilot: Autopilot, rates: AutopilotRates, radius: float, speed: float) -> float:
    """Return the level acceptance radius, metres, of a waypoint at which a UAV stops after a leg with a speed, m/s.

    PX4 counts the seconds of a stop from when it is within that radius. A UAV that is slow, or that brakes softly, must
    be nearer by then, so that it is at the waypoint when the stop ends: within a second at its speed and `rates`.
    """
    usual = corner_acceptance(autopilot, radius).radius
    if autopilot.name != "px4":
        return usual
    return min(usual, max(min(speed, rates.acceleration) * SECONDS_TO_STOP, MIN_ACCEPTANCE_RADIUS))


def require_return_altitude(autopilot: Autopilot, altitude: float) -> None:
    """Raise `InputError` for a return altitude, metres above home, that an autopilot does not keep to."""
    least, most = RETURN_ALTITUDES[autopilot.name]
    require_number(altitude, "return_altitude", f"metres above home, for {autopilot.title},", least, most)
