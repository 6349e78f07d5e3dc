"""Parameter files for PX4 and ArduPilot: the rates that a schedule counts on, and the return altitude."""

import math
from pathlib import Path
from typing import NamedTuple

from skyverse.atomic import write_text
from skyverse.exports.autopilots import Autopilot, Rates
from skyverse.exports.flight_plan import FlightPlan

SUFFIXES = {"px4": ".params", "ardupilot": ".param"}
REAL, WHOLE = 9, 6
"""MAV_PARAM_TYPE_REAL32 and MAV_PARAM_TYPE_INT32, which QGroundControl's files name."""


DESCEND_ALTITUDE = 5.0
"""Metres above where it lands: PX4 waits there before it lands."""


class Parameter(NamedTuple):
    """One parameter: its name, its value, and whether it is a whole number."""

    name: str
    value: float
    whole: bool = False


def parameters(plan: FlightPlan, altitude: float | None) -> list[Parameter]:
    """Return the parameters that make an autopilot fly as predicted, and return at an altitude above home, metres."""
    rates = plan.rates
    return [*_rate_parameters(plan.autopilot, rates), *_return_parameters(plan.autopilot, altitude)]


def _rate_parameters(autopilot: Autopilot, rates: Rates) -> list[Parameter]:
    if not math.isfinite(rates.climb):
        return []  # an aeroplane's rates are its own
    if autopilot.name == "px4":
        return [
            Parameter("MPC_TKO_SPEED", rates.takeoff),
            Parameter("MPC_Z_V_AUTO_UP", rates.climb),
            Parameter("MPC_Z_V_AUTO_DN", rates.descent),
            Parameter("MPC_ACC_HOR", rates.acceleration),
        ]
    # centimetres, as in ArduPilot Copter until 4.6
    return [
        Parameter("WPNAV_SPEED_UP", 100 * rates.climb),
        Parameter("WPNAV_SPEED_DN", 100 * rates.descent),
        Parameter("WPNAV_ACCEL", 100 * rates.acceleration),
    ]


def _return_parameters(autopilot: Autopilot, altitude: float | None) -> list[Parameter]:
    """Return the parameters that make an autopilot return straight, at one altitude, and land."""
    if altitude is None:
        return []
    if autopilot.name == "px4":
        return [
            Parameter("RTL_TYPE", 0, whole=True),
            Parameter("RTL_RETURN_ALT", altitude),
            Parameter("RTL_CONE_ANG", 0, whole=True),
            Parameter("RTL_DESCEND_ALT", min(altitude, DESCEND_ALTITUDE)),
            Parameter("RTL_LAND_DELAY", 0),
        ]
    return [
        Parameter("RTL_ALT", round(100 * altitude), whole=True),
        Parameter("RTL_ALT_FINAL", 0, whole=True),
        Parameter("RTL_ALT_TYPE", 0, whole=True),
        Parameter("RTL_CLIMB_MIN", 0, whole=True),
        Parameter("RTL_CONE_SLOPE", 0),
        Parameter("RALLY_INCL_HOME", 1, whole=True),
        Parameter("RALLY_LIMIT_KM", 0),
    ]


def parameters_text(plan: FlightPlan, name: str, altitude: float | None) -> str:
    """Return a parameter file: for PX4 as QGroundControl reads it, for ArduPilot as Mission Planner does."""
    title = plan.autopilot.title
    if plan.autopilot.name == "px4":
        rows = [
            f"1\t1\t{one.name}\t{int(one.value) if one.whole else f'{one.value:.6f}'}\t{WHOLE if one.whole else REAL}"
            for one in parameters(plan, altitude)
        ]
        head = [f"# Parameters for {name}", "#", f"# Stack: {title}", "# Vehicle-Id\tComponent-Id\tName\tValue\tType"]
    else:
        rows = [f"{one.name},{one.value:.6g}" for one in parameters(plan, altitude)]
        head = [f"# Parameters for {name}, {title} Copter 4.0 to 4.6"]
    return "\n".join([*head, *rows]) + "\n"


def write_parameters(file: Path, suffix: str, plan: FlightPlan, name: str, altitude: float | None) -> Path | None:
    """Write the parameter file beside a mission file; return its path, or ``None`` where there is nothing to write.

    DJI's aircraft take no parameters, and those of an aeroplane are its own.
    """
    if plan.autopilot.name not in SUFFIXES or not parameters(plan, altitude):
        return None
    beside = file.with_name(file.name[: -len(suffix)] + SUFFIXES[plan.autopilot.name])
    write_text(beside, parameters_text(plan, name, altitude))
    return beside
