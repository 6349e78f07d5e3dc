"""Vehicle profiles: the limits of a kind of UAV by name, with where each number comes from; limits of a whole fleet."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from skyverse.errors import InputError, require_choice, require_number, require_row, shown


@dataclass(frozen=True)
class VehicleProfile:
    """The limits of a kind of UAV.

    Attributes
    ----------
    title
        What kind of UAV it is, in words.
    source
        Where the numbers come from.
    limits
        Fields of a `UAV` and their values.
    simulated_as
        The vehicle of `fly` that is this one; ``None`` where there is none. A simulation needs mass, inertia, rotors,
        motors and drag, of which the sources of most profiles say nothing.
    """

    title: str
    source: str
    limits: Mapping[str, Any]
    simulated_as: str | None = None


@dataclass(frozen=True, kw_only=True)
class FleetLimits:
    """Limits of all UAVs; what is left out stays as it is.

    Attributes
    ----------
    vehicle
        The profile of all UAVs, which sets all their limits and their tracking error: indoor, thesis, camera, heavy,
        m100 or mapping.
    max_speed
        The fastest that UAVs fly, m/s.
    max_climb
        The fastest that they climb, m/s.
    max_descent
        The fastest that they descend, m/s.
    separation
        The distance that UAVs at one height keep from each other, metres; above and below, the vehicle's own, or twice
        as much.
    tracking_error
        How far they may stray from their nominal positions: metres seen from above, and metres in altitude.
    battery
        Nominal energy of the battery of each: Wh, or text such as ``"77 Wh"`` or ``"20 min"``, minutes from full to
        empty in which the vehicle hovers, or an aeroplane flies at its speed.
    reserve
        Share of it that must be left at landing.
    """

    vehicle: str | None = None
    max_speed: float | None = None
    max_climb: float | None = None
    max_descent: float | None = None
    separation: float | None = None
    tracking_error: tuple[float, float] | None = None
    battery: float | str | None = None
    reserve: float | None = None

    def __post_init__(self) -> None:
        if self.vehicle is not None:
            require_choice(self.vehicle, VEHICLE_PROFILES, "vehicle")
        for name in ("max_speed", "max_climb", "max_descent", "separation"):
            if getattr(self, name) is not None:
                require_number(getattr(self, name), name, least=0.0 if name == "separation" else 1e-3, most=1e6)
        if self.tracking_error is not None:
            require_row(self.tracking_error, 2, "tracking_error", least=0.0)
        if isinstance(self.battery, str):
            energy_or_minutes(self.battery)
        elif self.battery is not None:
            require_number(self.battery, "battery", least=1e-3, most=1e6)
        if self.reserve is not None:
            require_number(self.reserve, "reserve", least=0.0, most=1.0)


def energy_or_minutes(text: str) -> tuple[float, bool]:
    """Read what one battery gives: a number of Wh, or of minutes, and whether it is minutes."""
    match = re.fullmatch(r"\s*(\d+(?:\.\d*)?)\s*(min|Wh)\s*", text)
    if match is None or not 1e-3 <= float(match[1]) <= 1e6:
        expected = "minutes of hovering or watt-hours, as in '20 min' or '77 Wh'"
        raise InputError(f"expected {expected}, found {shown(text)}", field="battery")
    return float(match[1]), match[2] == "min"


def _profile(title: str, source: str, simulated_as: str | None = None, **limits: Any) -> VehicleProfile:
    return VehicleProfile(title, source, MappingProxyType(limits), simulated_as)


_GNSS = (
    "tracking error: twice the standard deviations of position of a standard GNSS module, 0.8 m and 1.5 m, in PX4's "
    "documentation, Using PX4's Navigation Filter (EKF2), GNSS Performance Requirements"
)
_PX4 = (
    "acceleration and jerk: PX4's defaults for missions, MPC_ACC_HOR and MPC_JERK_AUTO; thrust: half of it hovers, "
    "PX4's MPC_THR_HOVER; separation: the rotors' diagonal several times, for their downwash"
)

VEHICLE_PROFILES: Mapping[str, VehicleProfile] = MappingProxyType(
    {
        "indoor": _profile(
            "small indoor quadrotor (Crazyflie 2.1, 27 g, with motion capture)",
            "speeds and tilt: limits of its firmware's position controller (PID_POS_VEL_X_MAX, PID_POS_VEL_Z_MAX, "
            "PID_VEL_ROLL_MAX), over ground and through the air alike; thrust: rotorpy's parameters of it; "
            "separation: the downwash ellipsoids of Hönig et al., Trajectory Planning for Quadrotor Swarms, IEEE "
            "Transactions on Robotics, 2018; tracking error: five "
            "times the mean of 49 vehicles, below 0.02 m, in Preiss et al., Crazyswarm: A Large Nano-Quadcopter Swarm, "
            "ICRA 2017; mass, battery and power: its maker's data sheet, 250 mAh at 3.7 V in 7 minutes of flight",
            simulated_as="crazyflie",
            max_speed=1.0,
            max_airspeed=1.0,
            max_acceleration=2.0,
            max_jerk=20.0,
            max_tilt=20.0,
            thrust_to_weight=1.9,
            hover_power=7.9,
            mass=0.027,
            battery=0.925,
            max_climb=1.0,
            max_descent=1.0,
            separation=0.24,
            vertical_separation=0.6,
            tracking_error={"horizontal": 0.1, "vertical": 0.1},
        ),
        "thesis": _profile(
            "the thesis's quadrotor (176 g)",
            "tilt and thrust: the thesis, which limits neither climb nor descent, and whose missions know no tracking "
            "error; the rest are the defaults of a UAV",
            simulated_as="thesis",
            max_speed=5.0,
            max_acceleration=3.5,
            max_jerk=50.0,
            max_tilt=40.0,
            thrust_to_weight=2.5,
            separation=0.5,
            vertical_separation=1.0,
            tracking_error={"horizontal": 0.0, "vertical": 0.0},
        ),
        "camera": _profile(
            "camera multirotor (of the class of the DJI Mavic 3 Enterprise, 0.9 kg)",
            "speeds and tilt: the manufacturer's specifications, normal mode; mass, battery and power: the same, 77 Wh "
            f"in 38 minutes of hovering, in 45 at 9 m/s, and in 32 km at 14 m/s; {_PX4}; {_GNSS}",
            simulated_as="camera",
            max_speed=15.0,
            max_airspeed=15.0,
            max_acceleration=3.0,
            max_jerk=4.0,
            max_tilt=30.0,
            thrust_to_weight=2.0,
            hover_power=122.0,
            power=((9.0, 102.7), (14.0, 121.3)),
            mass=0.915,
            battery=77.0,
            max_climb=6.0,
            max_descent=6.0,
            separation=2.0,
            vertical_separation=4.0,
            tracking_error={"horizontal": 1.6, "vertical": 3.0},
        ),
        "heavy": _profile(
            "heavy multirotor (of the class of the DJI Matrice 600 Pro, up to 15.5 kg)",
            "speeds and tilt: the manufacturer's specifications; mass, battery and power: the same, six batteries of "
            f"99.9 Wh in 16 minutes of hovering with 6 kg of payload, which the mass holds; {_PX4}; {_GNSS}",
            max_speed=18.0,
            max_airspeed=18.0,
            max_acceleration=3.0,
            max_jerk=4.0,
            max_tilt=25.0,
            thrust_to_weight=2.0,
            hover_power=2250.0,
            mass=15.5,
            battery=599.4,
            max_climb=5.0,
            max_descent=3.0,
            separation=5.0,
            vertical_separation=10.0,
            tracking_error={"horizontal": 1.6, "vertical": 3.0},
        ),
        "m100": _profile(
            "delivery multirotor (DJI Matrice 100 with the instruments of the CMU data set, 3.68 kg)",
            "power, mass, battery, largest speed and acceleration: 195 flights with a level cruise, of Rodrigues et "
            "al., In-flight positional and energy use data set of a DJI Matrice 100 quadcopter for small package "
            "delivery, Scientific Data 8:155, 2021, means of samples without payload; climb, descent and tilt: the "
            f"manufacturer's specifications; {_PX4}; {_GNSS}",
            max_speed=12.0,
            max_airspeed=12.0,
            max_acceleration=2.1,
            max_jerk=4.0,
            max_tilt=35.0,
            thrust_to_weight=2.0,
            hover_power=472.7,
            power=((6.0, 452.0), (12.0, 480.1)),
            mass=3.68,
            battery=99.9,
            max_climb=5.0,
            max_descent=4.0,
            separation=3.0,
            vertical_separation=6.0,
            tracking_error={"horizontal": 1.6, "vertical": 3.0},
        ),
        "mapping": _profile(
            "mapping aeroplane (cruising at 15 m/s)",
            "speeds, climb and sink rates: PX4's defaults for fixed wings, FW_AIRSPD_TRIM, FW_AIRSPD_MAX, "
            "FW_T_CLMB_R_SP and FW_T_SINK_R_SP; wind: what takes its airspeed from 15 m/s over ground, 1 % off and "
            "climbing, to FW_AIRSPD_MAX, 20 m/s, or, 5 m/s, to FW_AIRSPD_MIN, 10 m/s; climb angle: the "
            "steepest that sinks no faster at that speed; turns: at 30 degrees of bank, radius = speed^2 / (g tan 30 "
            "degrees); separation: its turn radius, and half of it "
            "above and below; tracking error: the radii within which PX4 takes waypoints and altitudes of fixed wings "
            "as reached, NAV_ACC_RAD and NAV_FW_ALT_RAD",
            max_speed=20.0,
            max_acceleration=7.0,
            max_climb=3.0,
            max_descent=2.0,
            separation=40.0,
            vertical_separation=20.0,
            tracking_error={"horizontal": 10.0, "vertical": 10.0},
            fixed_wing={"speed": 15.0, "turn_radius": 40.0, "climb": 7.5, "max_wind": 4.7},
        ),
    }
)
"""The profiles by name."""


_POWERS = ("hover_power", "power", "power_curve")


def with_profile(data: Any) -> Any:
    """Return the data of a UAV, with the fields that its `vehicle` has and that it does not give itself.

    A field that is given as ``None`` is given: the UAV has no such limit of its own. A UAV that gives a power has none
    of the vehicle's, which would be another's points of one curve.

    Raises
    ------
    ValueError
        If there is no such vehicle, or if it is an aeroplane and `fixed_wing` is ``None``.
    """
    if not isinstance(data, dict) or not data.get("vehicle"):
        return data
    profile = VEHICLE_PROFILES.get(data["vehicle"]) if isinstance(data["vehicle"], str) else None
    if profile is None:
        raise ValueError(
            f"vehicle: there is none of the name {data['vehicle']!r:.40}; there are {', '.join(VEHICLE_PROFILES)}"
        )
    merged = {**profile.limits, **data}
    if any(data.get(name) is not None for name in _POWERS):
        merged = {name: value for name, value in merged.items() if name in data or name not in _POWERS}
    if "fixed_wing" in profile.limits and merged["fixed_wing"] is None:
        raise ValueError(f"fixed_wing: must not be null, since the vehicle {data['vehicle']!r} is an aeroplane")
    return merged


def limits_without_value(vehicle: str, limits: Mapping[str, Any]) -> dict[str, None]:
    """Return the limits that a vehicle's profile has and that are missing among a UAV's own, which has none of them."""
    profile = VEHICLE_PROFILES.get(vehicle)
    return {} if profile is None else {name: None for name in profile.limits if name not in limits}
