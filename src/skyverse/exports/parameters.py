"""Parameter files for PX4 and ArduPilot: rates that a schedule counts on, noses, returns, and what a lost link does."""

import math
from pathlib import Path
from typing import NamedTuple

from skyverse.exports.autopilots import ACCEPTANCE, PX4_TAKEOFF_RAMP, corner_acceptance
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.way_home import WayHome
from skyverse.model.uav import UAV

SUFFIXES = {"px4": ".params", "ardupilot": ".param"}
REAL, WHOLE = 9, 6
"""MAV_PARAM_TYPE_REAL32 and MAV_PARAM_TYPE_INT32, which QGroundControl's files name."""


DESCEND_ALTITUDE = 5.0
"""Metres above where it lands: PX4 waits there before it lands."""
LEAST_MIN_DIST = 0.5
"""Metres from where it lands: PX4 1.14 may return lower if it is nearer, or within its acceptance radius."""


DISARM_AFTER = 10
"""Seconds: an autopilot that has armed and does not take off disarms so long after its take-off was due."""
MAX_DISARM_DELAY = 127
"""Seconds: ArduPilot takes no longer `DISARM_DELAY`; 0 stands for never."""
PX4_HOLD, PX4_RETURN = 1, 2
"""Values of PX4's `NAV_RCL_ACT` and `NAV_DLL_ACT`."""
PX4_MAX_SPEED = 12.0
"""m/s: PX4's default of `MPC_XY_VEL_MAX`, which is only raised."""
PX4_SPEED_MARGIN = 1.1
"""By which factor PX4 may fly faster than commanded to catch up, as far as it takes that."""
PX4_STRAIGHT, PX4_ALONG_MISSION = 0, 2
"""Values of PX4's `RTL_TYPE`: straight home, and along the mission: to its landing, or else back to its take-off."""
FS_RETURN = 1
"""The value of ArduPilot's `FS_THR_ENABLE` and `FS_GCS_ENABLE`: always return."""
SMART_RETURNS = {"FS_THR_ENABLE": 4, "FS_GCS_ENABLE": 3, "BATT_FS_LOW_ACT": 3, "FENCE_ACTION": 3}
"""With these ArduPilot goes back where it came from, by SmartRTL, if anything makes it return."""
SMART_PATH = {"SRTL_ACCURACY": 2, "SRTL_POINTS": 500}
"""How exactly SmartRTL does that, metres, and how many places it keeps at most."""
FS_MISSION_GOES_ON, FS_PILOT_GOES_ON = 0b11, 0b10000
"""Bits of ArduPilot's `FS_OPTIONS`: a mission goes on without remote control, and without ground station; and without
ground station a pilot with a remote control goes on, which is the default."""


YAW_HELD, YAW_AHEAD = 0, 2
"""Values of ArduPilot's `WP_YAW_BEHAVIOR`: the mission alone turns the nose; by default it points along each leg."""


class Parameter(NamedTuple):
    """One parameter: its name, its value, and whether it is a whole number."""

    name: str
    value: float
    whole: bool = False


def parameters(plan: FlightPlan, vehicle: UAV, back: WayHome | None) -> list[Parameter]:
    """Return the parameters that make an autopilot fly as predicted, and return as proven; ``None`` for aeroplanes."""
    returning = [] if back is None else [*_return_parameters(back), *_link_parameters(back)]
    pointing = []
    if plan.autopilot.name == "ardupilot" and vehicle.fixed_wing is None:
        pointing = [Parameter("WP_YAW_BEHAVIOR", YAW_AHEAD if vehicle.heading is None else YAW_HELD, whole=True)]
    return [*_rate_parameters(plan), *pointing, *returning]


def _rate_parameters(plan: FlightPlan) -> list[Parameter]:
    """Return the parameters of rates and speeds, in an order in which none is clipped while they are set one by one."""
    rates, speed = plan.rates, plan.top_speed
    if not math.isfinite(rates.climb):
        return []  # an aeroplane's rates are its own
    disarm = math.ceil(plan.delay) + DISARM_AFTER  # by default both disarm 10 s after arming
    if plan.autopilot.name == "px4":
        fastest = max(speed, float(plan.speeds.max()))
        most = min(max(PX4_SPEED_MARGIN * fastest, PX4_MAX_SPEED), plan.autopilot.max_speed)
        return [
            # where these are not negative, they set all those below anew
            Parameter("SYS_VEHICLE_RESP", -0.4),
            Parameter("MPC_XY_VEL_ALL", -10.0),
            Parameter("MPC_Z_VEL_ALL", -3.0),
            # the maxima, by which PX4 clips those below and keeps them clipped
            Parameter("MPC_XY_VEL_MAX", most),
            Parameter("MPC_Z_VEL_MAX_UP", rates.climb),
            Parameter("MPC_Z_VEL_MAX_DN", rates.descent),
            Parameter("MPC_XY_CRUISE", speed),
            Parameter("MPC_TKO_SPEED", rates.takeoff),
            Parameter("MPC_TKO_RAMP_T", PX4_TAKEOFF_RAMP),
            Parameter("MPC_LAND_ALT1", rates.takeoff_height),
            Parameter("MPC_Z_V_AUTO_UP", rates.climb),
            Parameter("MPC_Z_V_AUTO_DN", rates.descent),
            Parameter("MPC_ACC_HOR", rates.acceleration),
            Parameter("MPC_ACC_UP_MAX", rates.vertical_acceleration),
            Parameter("MPC_ACC_DOWN_MAX", rates.vertical_acceleration),
            Parameter("MPC_JERK_AUTO", rates.jerk),
            Parameter("COM_DISARM_PRFLT", disarm),
        ]
    return [
        *_both_names("WPNAV_SPEED", "WP_SPD", speed),
        *_both_names("RTL_SPEED", "RTL_SPEED_MS", speed, whole=True),
        *_both_names("WPNAV_SPEED_UP", "WP_SPD_UP", rates.climb),
        *_both_names("WPNAV_SPEED_DN", "WP_SPD_DN", rates.descent),
        *_both_names("WPNAV_ACCEL", "WP_ACC", rates.acceleration),
        *_both_names("WPNAV_ACCEL_Z", "WP_ACC_Z", rates.vertical_acceleration),
        Parameter("WPNAV_JERK", rates.jerk),  # in m/s^3 by both names
        Parameter("WP_JERK", rates.jerk),
        # Copter cuts corners within this radius, and passes over the one that a waypoint names
        *_both_names("WPNAV_RADIUS", "WP_RADIUS_M", plan.route.radius),
        Parameter("DISARM_DELAY", disarm if disarm <= MAX_DISARM_DELAY else 0, whole=True),
    ]


def _both_names(until: str, since: str, metres: float, *, whole: bool = False) -> list[Parameter]:
    """Return a parameter of ArduPilot by its name until Copter 4.6, in centimetres, and since 4.7, in metres."""
    centimetres = round(100 * metres) if whole else 100 * metres
    return [Parameter(until, centimetres, whole), Parameter(since, metres)]


def _return_parameters(back: WayHome) -> list[Parameter]:
    """Return the parameters that make an autopilot return straight, at one altitude, or as it came, and land."""
    altitude, plan = back.altitude, back.plan
    if plan.autopilot.name == "px4":
        return [
            Parameter("RTL_TYPE", PX4_ALONG_MISSION if back.retraces else PX4_STRAIGHT, whole=True),
            Parameter("RTL_RETURN_ALT", altitude),
            Parameter("RTL_CONE_ANG", 0, whole=True),
            Parameter("RTL_DESCEND_ALT", min(altitude, DESCEND_ALTITUDE)),
            Parameter("RTL_LAND_DELAY", 0),
            Parameter("RTL_MIN_DIST", LEAST_MIN_DIST),
            Parameter("NAV_ACC_RAD", ACCEPTANCE["px4"].radius),
            Parameter("NAV_MC_ALT_RAD", corner_acceptance(plan.autopilot, plan.route.radius).altitude),
        ]
    return [
        *_both_names("RTL_ALT", "RTL_ALT_M", altitude, whole=True),
        *_both_names("RTL_ALT_FINAL", "RTL_ALT_FINAL_M", 0.0, whole=True),
        *_both_names("RTL_CLIMB_MIN", "RTL_CLIMB_MIN_M", 0.0, whole=True),
        Parameter("RTL_ALT_TYPE", 0, whole=True),
        Parameter("RTL_CONE_SLOPE", 0),
        Parameter("RALLY_INCL_HOME", 1, whole=True),
        Parameter("RALLY_LIMIT_KM", 0),
        *(Parameter(name, value, whole=True) for name, value in SMART_PATH.items() if back.retraces),
    ]


def _link_parameters(back: WayHome) -> list[Parameter]:
    """Return what an autopilot does in a mission when it loses its remote control or its ground station.

    It returns if that is proven from every instant of the flight. If not, PX4 holds its position, and ArduPilot, which
    cannot do that, goes on with the mission: the flight itself is proven.
    """
    if back.plan.autopilot.name == "px4":
        action = PX4_RETURN if back.everywhere else PX4_HOLD
        return [
            Parameter("NAV_RCL_ACT", action, whole=True),
            Parameter("NAV_DLL_ACT", action, whole=True),
            Parameter("COM_RCL_EXCEPT", 0, whole=True),
        ]
    options = FS_PILOT_GOES_ON if back.everywhere else FS_PILOT_GOES_ON | FS_MISSION_GOES_ON
    actions = SMART_RETURNS if back.retraces else dict.fromkeys(("FS_THR_ENABLE", "FS_GCS_ENABLE"), FS_RETURN)
    return [
        *(Parameter(name, value, whole=True) for name, value in actions.items()),
        Parameter("FS_OPTIONS", options, whole=True),
    ]


def parameters_text(plan: FlightPlan, vehicle: UAV, back: WayHome | None) -> str:
    """Return a parameter file: for PX4 as QGroundControl reads it, for ArduPilot as Mission Planner does."""
    title = plan.autopilot.title
    if plan.autopilot.name == "px4":
        rows = [
            f"1\t1\t{one.name}\t{int(one.value) if one.whole else f'{one.value:.6f}'}\t{WHOLE if one.whole else REAL}"
            for one in parameters(plan, vehicle, back)
        ]
        head = [
            f"# Parameters for {vehicle.name}",
            "#",
            f"# Stack: {title}",
            "# Versions: 1.14 to 1.16; metres, m/s, m/s^2, seconds and degrees",
            "# Vehicle-Id\tComponent-Id\tName\tValue\tType",
        ]
    else:
        rows = [f"{one.name},{one.value:.6g}" for one in parameters(plan, vehicle, back)]
        head = [
            f"# Parameters for {vehicle.name}, {title} Copter 4.0 to 4.7",
            "# Until 4.6: WPNAV_..., RTL_ALT, RTL_ALT_FINAL and RTL_CLIMB_MIN, in centimetres.",
            "# Since 4.7: WP_... and RTL_..._M in their place, in metres.",
            "# A ground station says that it does not know those of the other versions.",
        ]
    return "\n".join([*head, *rows]) + "\n"


def parameter_file(file: Path, suffix: str, plan: FlightPlan) -> Path | None:
    """Return the path of the parameter file beside a mission file, or ``None`` where there is nothing to write.

    DJI's aircraft take no parameters, and those of an aeroplane are its own.
    """
    if plan.autopilot.name not in SUFFIXES or not _rate_parameters(plan):
        return None
    return file.with_name(file.name[: -len(suffix)] + SUFFIXES[plan.autopilot.name])
