"""The quadrotors that can fly a mission, by name: rotorpy's own, and the thesis's, completed."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from skyverse.errors import InputError
from skyverse.model.uav import UAV
from skyverse.trajectory.limits import GRAVITY

THESIS_ARM, HUMMINGBIRD_ARM = 0.086, 0.17


@dataclass(frozen=True)
class Vehicle:
    """A quadrotor.

    Attributes
    ----------
    name
        One of `VEHICLES`.
    parameters
        What rotorpy calls ``quad_params``.
    max_tilt
        Degrees between its commanded thrust and the vertical; ``None`` where nothing limits it.
    """

    name: str
    parameters: dict[str, Any]
    max_tilt: float | None = None

    @property
    def mass(self) -> float:
        """Kilograms."""
        return float(self.parameters["mass"])

    @property
    def max_thrust(self) -> float:
        """Of all rotors together, newtons."""
        return float(self.parameters["num_rotors"] * self.parameters["k_eta"] * self.parameters["rotor_speed_max"] ** 2)

    @property
    def thrust_to_weight(self) -> float:
        """The most thrust, as a multiple of its weight."""
        return self.max_thrust / (self.mass * GRAVITY)


def vehicle_of(name: str) -> Vehicle:
    """Return the vehicle of that name, or raise `InputError`."""
    if name not in VEHICLES:
        raise InputError(f"expected one of {', '.join(VEHICLES)}, found {name!r}", field="vehicle")
    return VEHICLES[name]()


def refuse_weak(vehicle: Vehicle, uavs: tuple[UAV, ...]) -> None:
    """Refuse a vehicle that cannot do what the UAVs' limits allow their trajectories."""
    for uav in uavs:
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


def _of_rotorpy(name: str) -> Vehicle:
    return Vehicle(name, import_module(f"rotorpy.vehicles.{name}_params").quad_params)


def _thesis() -> Vehicle:
    """Complete the thesis's quadrotor.

    Given by the thesis: mass, thrust and tilt. Its simulator is that of the University of Pennsylvania's course on
    aerial robotics (the "nano plus"), which adds inertia, arm and least thrust (a twentieth of the weight). All else
    lies between rotorpy's Crazyflie and Hummingbird, of whose arms (0.043 and 0.17 m) this one is the geometric mean:
    so is whatever both have. Where the Crazyflie's is 0, areas tell: a quarter of the Hummingbird's. The rotors' yaw
    moment per thrust is a length, and scales as the arm; the controller's gains are the Hummingbird's.
    """
    mass = 0.176
    k_eta = math.sqrt(2.3e-8 * 5.57e-6)
    hover = math.sqrt(mass * GRAVITY / (4 * k_eta))
    corner = THESIS_ARM * math.sqrt(0.5)
    parameters = {
        "mass": mass,
        "Ixx": 2.5e-4,
        "Iyy": 2.32e-4,
        "Izz": 3.738e-4,
        "Ixy": 0.0,
        "Iyz": 0.0,
        "Ixz": 2.55e-6,
        "num_rotors": 4,
        "rotor_pos": {
            f"r{k}": corner * np.array([x, y, 0.0]) for k, (x, y) in enumerate([(1, 1), (1, -1), (-1, -1), (-1, 1)], 1)
        },
        "rotor_directions": np.array([1, -1, 1, -1]),
        "rI": np.zeros(3),
        "c_Dx": 0.5e-2 / 4,
        "c_Dy": 0.5e-2 / 4,
        "c_Dz": 1e-2 / 4,
        "k_eta": k_eta,
        "k_m": k_eta * (1.36e-7 / 5.57e-6) * THESIS_ARM / HUMMINGBIRD_ARM,
        "k_d": math.sqrt(10.2506e-7 * 1.19e-4),
        "k_z": math.sqrt(7.553e-7 * 2.32e-4),
        "k_h": 3.39e-3 / 4,
        "k_flap": 0.0,
        "tau_m": math.sqrt(0.072 * 0.005),
        "rotor_speed_min": hover * math.sqrt(0.05),
        "rotor_speed_max": hover * math.sqrt(2.5),
        "motor_noise_std": 0.0,
        "kp_att": 544.0,
        "kd_att": 46.64,
    }
    return Vehicle("thesis", parameters, max_tilt=40.0)


VEHICLES: dict[str, Callable[[], Vehicle]] = {
    "thesis": _thesis,
    "crazyflie": lambda: _of_rotorpy("crazyflie"),
    "hummingbird": lambda: _of_rotorpy("hummingbird"),
}
"""What makes each vehicle; rotorpy's own need rotorpy."""
