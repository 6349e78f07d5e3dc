"""The quadrotors that can fly a mission: rotorpy's, and with estimated parameters the thesis's and a camera drone."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from skyverse.errors import InputError, require_choice
from skyverse.extras import require_libraries
from skyverse.model.conditions import is_stand_in
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import GRAVITY, UAV

THESIS_ARM, HUMMINGBIRD_ARM, CRAZYFLIE_ARM = 0.086, 0.17, 0.043
HUMMINGBIRD_PROPELLER, CRAZYFLIE_PROPELLER = 0.10, 0.0225
"""Radii of propellers, metres: rotorpy's for the Hummingbird, and an estimate of 45 mm across for the Crazyflie."""
THESIS_PROPELLER = math.sqrt(HUMMINGBIRD_PROPELLER * CRAZYFLIE_PROPELLER)
"""The geometric mean of both radii, metres, as for the thesis's other unknown parameters."""

MOST_TILT = 60.0
"""Degrees: a vehicle without a limit of its own is not taken to hold a speed for which it leans farther."""


@dataclass(frozen=True)
class Vehicle:
    """A quadrotor.

    Attributes
    ----------
    name
        One of `VEHICLES`.
    parameters
        rotorpy's ``quad_params``.
    radius
        How far the vehicle reaches from its centre, metres: to the tips of its propellers.
    max_tilt
        The largest angle between commanded thrust and the vertical, degrees; ``None`` without a limit.
    """

    name: str
    parameters: dict[str, Any]
    radius: float
    max_tilt: float | None = None

    @property
    def attitude_gains(self) -> tuple[float, float]:
        """The gains of rotorpy's controller for the errors of attitude, 1/s^2, and of body rates, 1/s."""
        return float(self.parameters.get("kp_att", 310.0)), float(self.parameters.get("kd_att", 57.0))

    @property
    def mass(self) -> float:
        """The mass, kilograms."""
        return float(self.parameters["mass"])

    @property
    def max_thrust(self) -> float:
        """The largest thrust of all rotors together, newtons."""
        return float(self.parameters["num_rotors"] * self.parameters["k_eta"] * self.parameters["rotor_speed_max"] ** 2)

    @property
    def top_airspeed(self) -> float:
        """The fastest level flight through the air, m/s: its thrust holds weight and drag, within its tilt."""
        made, weight = self.parameters, self.mass * GRAVITY
        hover = math.sqrt(weight / (made["num_rotors"] * made["k_eta"]))
        linear, square = made["num_rotors"] * hover * made["k_d"], made["c_Dx"]
        spare = math.sqrt(max(self.max_thrust**2 - weight**2, 0.0))
        most = min(spare, weight * math.tan(math.radians(self.max_tilt or MOST_TILT)))
        return float(2.0 * most / (linear + math.sqrt(linear**2 + 4.0 * square * most)))

    @property
    def thrust_to_weight(self) -> float:
        """The largest thrust as a multiple of the weight."""
        return self.max_thrust / (self.mass * GRAVITY)


def vehicle_of(name: str) -> Vehicle:
    """Return the vehicle of that name, or raise `InputError`."""
    require_choice(name, VEHICLES, "vehicle")
    return VEHICLES[name]()


def refuse_stand_in(vehicle: str, uavs: tuple[UAV, ...]) -> None:
    """Raise `InputError` if a mission would be made easier for a vehicle that is not the planned one."""
    if is_stand_in(vehicle, uavs):
        raise InputError(
            f"expected the vehicle that the mission was planned for, found {vehicle} in its place: for no flight of "
            "that one is the mission slowed down or planned anew",
            field="vehicle",
        )


def refuse_weak(vehicle: Vehicle, uavs: tuple[UAV, ...], wind: Sequence[float]) -> None:
    """Raise `InputError` if the vehicle cannot fly what the UAVs' limits allow, or stands in and not even in the wind.

    `wind` is the velocity of the air, m/s. A vehicle that was planned for may fail in it: that is an answer.
    """
    for uav in uavs:
        blows = math.hypot(*wind)
        if is_stand_in(vehicle.name, (uav,)) and uav.max_speed + blows > vehicle.top_airspeed:
            raise InputError(
                f"{vehicle.name} cannot hold {uav.max_speed:g} m/s in a wind of {blows:.3g} m/s, and stands in for "
                f"{uav.vehicle}, of which no model is known: what it does says nothing of {uav.name}",
                field="vehicle",
            )
        pull = uav.max_acceleration / GRAVITY
        thrust = min(uav.thrust_to_weight, 1.0 + pull)
        if thrust > vehicle.thrust_to_weight * (1 + 1e-9):
            raise InputError(
                f"{vehicle.name} has thrust for {vehicle.thrust_to_weight:.3g} times its weight, but "
                f"{uav.name}'s limits need {thrust:.3g}; lower its max_acceleration or thrust_to_weight and plan again",
                field="vehicle",
            )
        tilt = min(uav.max_tilt, math.degrees(math.asin(min(1.0, pull))))
        if vehicle.max_tilt is not None and tilt > vehicle.max_tilt * (1 + 1e-9):
            raise InputError(
                f"{vehicle.name} tilts by {vehicle.max_tilt:g} degrees at most, but {uav.name}'s limits need "
                f"{tilt:.3g}; lower its max_acceleration or max_tilt and plan again",
                field="vehicle",
            )


def told_airspeeds(vehicle: Vehicle, trajectory: Trajectory, wind: Sequence[float]) -> str:
    """Say as the end of a sentence that a trajectory is faster in a wind, m/s, than a vehicle flies, if it is."""
    velocity = trajectory.at(np.linspace(trajectory.start, trajectory.end, 1001)).velocity
    asked, blows = np.linalg.norm(velocity - np.array(wind), axis=1).max(), math.hypot(*wind)
    if asked <= vehicle.top_airspeed:
        return ""
    wanted = f"it is to fly at up to {asked:.3g} m/s through the air"
    return f"; in a wind of {blows:.3g} m/s {wanted}, of which {vehicle.name} holds {vehicle.top_airspeed:.3g} m/s"


def _of_rotorpy(name: str, radius: float) -> Vehicle:
    require_libraries(f"the {name}", "rotorpy")
    parameters = import_module(f"rotorpy.vehicles.{name}_params").quad_params
    return Vehicle(name, parameters, radius)


def _thesis() -> Vehicle:
    """Return the thesis's quadrotor, with estimates for what the thesis does not state.

    The thesis states mass, thrust and tilt. Its simulator is that of the University of Pennsylvania's course on aerial
    robotics (the "nano plus"), which adds inertia, arm and least thrust (1/20 of the weight). The arm is the geometric
    mean of those of rotorpy's Crazyflie and Hummingbird (0.043 and 0.17 m), and so is every other parameter that both
    have. Where the Crazyflie's is 0, it is a quarter of the Hummingbird's, as areas scale. The rotors' yaw moment per
    thrust is a length and scales with the arm; the controller's gains are the Hummingbird's.
    """
    k_eta = math.sqrt(2.3e-8 * 5.57e-6)
    parameters = _parameters(
        mass=0.176,
        inertia=(2.5e-4, 2.32e-4, 3.738e-4, 2.55e-6),
        arm=THESIS_ARM,
        thrust_to_weight=2.5,
        k_eta=k_eta,
        k_m=k_eta * (1.36e-7 / 5.57e-6) * THESIS_ARM / HUMMINGBIRD_ARM,
        c_Dx=0.5e-2 / 4,
        k_d=math.sqrt(10.2506e-7 * 1.19e-4),
        k_z=math.sqrt(7.553e-7 * 2.32e-4),
        k_h=3.39e-3 / 4,
        tau_m=math.sqrt(0.072 * 0.005),
    )
    return Vehicle("thesis", parameters, THESIS_ARM + THESIS_PROPELLER, max_tilt=40.0)


def _camera() -> Vehicle:
    """Return a camera multirotor of 1 kg: an AscTec Pelican that is as fast as the class of the Mavic 3 Enterprise.

    Mass, inertia, arm, propellers, motors and drag of the rotors are those of the Pelican in RotorS (Furrer, Burri,
    Achtelik, Siegwart, "RotorS - A Modular Gazebo MAV Simulator Framework", 2016), whose motors speed up in 12.5 ms and
    slow down in 25 ms; the lag is the geometric mean. RotorS has no drag of the body: it is what allows 21 m/s at a
    tilt of 35 degrees, the most that the manufacturer of the Mavic 3 Enterprise specifies. Inflow is in the
    Hummingbird's proportion to the drag of the rotors. There is no translational lift, which RotorS has not either. The
    controller's gains are the Hummingbird's.
    """
    mass, arm, k_eta, k_d, tilt, speed = 1.0, 0.21, 9.9865e-6, 8.06428e-5, 35.0, 21.0
    rotors = 4 * k_d * math.sqrt(mass * GRAVITY / (4 * k_eta))
    parameters = _parameters(
        mass=mass,
        inertia=(0.01, 0.01, 0.02, 0.0),
        arm=arm,
        thrust_to_weight=4 * k_eta * 838.0**2 / (mass * GRAVITY),
        k_eta=k_eta,
        k_m=0.016 * k_eta,
        c_Dx=(mass * GRAVITY * math.tan(math.radians(tilt)) / speed - rotors) / speed,
        k_d=k_d,
        k_z=k_d * 2.32 / 1.19,
        k_h=0.0,
        tau_m=math.sqrt(0.0125 * 0.025),
    )
    return Vehicle("camera", parameters, arm + 0.128, max_tilt=tilt)


def _parameters(
    mass: float,
    inertia: tuple[float, float, float, float],
    arm: float,
    thrust_to_weight: float,
    **measured: float,
) -> dict[str, Any]:
    """Return rotorpy's parameters of four rotors on the diagonals; `inertia` holds Ixx, Iyy, Izz and Ixz.

    The body has twice the drag upright, and the least thrust is a twentieth of the weight.
    """
    hover, corner = math.sqrt(mass * GRAVITY / (4 * measured["k_eta"])), arm * math.sqrt(0.5)
    return {
        "mass": mass,
        **dict(zip(("Ixx", "Iyy", "Izz", "Ixz"), inertia, strict=True)),
        "Ixy": 0.0,
        "Iyz": 0.0,
        "num_rotors": 4,
        "rotor_pos": {
            f"r{k}": corner * np.array([x, y, 0.0]) for k, (x, y) in enumerate([(1, 1), (1, -1), (-1, -1), (-1, 1)], 1)
        },
        "rotor_directions": np.array([1, -1, 1, -1]),
        "rI": np.zeros(3),
        **measured,
        "c_Dy": measured["c_Dx"],
        "c_Dz": 2 * measured["c_Dx"],
        "k_flap": 0.0,
        "rotor_speed_min": hover * math.sqrt(0.05),
        "rotor_speed_max": hover * math.sqrt(thrust_to_weight),
        "motor_noise_std": 0.0,
        "kp_att": 544.0,
        "kd_att": 46.64,
    }


VEHICLES: dict[str, Callable[[], Vehicle]] = {
    "thesis": _thesis,
    "camera": _camera,
    "crazyflie": lambda: _of_rotorpy("crazyflie", CRAZYFLIE_ARM + CRAZYFLIE_PROPELLER),
    "hummingbird": lambda: _of_rotorpy("hummingbird", HUMMINGBIRD_ARM + HUMMINGBIRD_PROPELLER),
}
"""The function that makes each vehicle; the Crazyflie and the Hummingbird need rotorpy."""
