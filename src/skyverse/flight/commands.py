"""The feedforward of the controller: the commanded acceleration with which the vehicle follows its trajectory.

rotorpy's SE3 controller accounts neither for drag nor for the lag of attitude and motors. A quadrotor is differentially
flat, with rotor drag as well (Faessler, Franchi, Scaramuzza, "Differential flatness of quadrotor dynamics subject to
rotor drag", IEEE RA-L 3, 2018): its position over time determines attitude, body rates and thrust, and so the command.

What the controller of one UAV is told at every sample of a flight.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.flight.vehicle import Vehicle
from skyverse.model.mission import Mission
from skyverse.model.pad import ground_height
from skyverse.model.scenario import Scenario
from skyverse.model.timed_shapes import is_closed_at_times
from skyverse.model.trajectory import Motion, Trajectory
from skyverse.model.uav import GRAVITY

VERTICAL = np.array([0.0, 0.0, 1.0])
_DIFFERENCE_STEP = 0.005
"""Seconds between the attitudes of which differences give the body rates."""


def reference(trajectory: Trajectory, vehicle: Vehicle, times: Floats, hold: float) -> Motion:
    """Return the commands at `times`, (m,) seconds, each of which is held for `hold` seconds.

    The acceleration is not that of the trajectory, but the command that produces it.

    The controller's angular acceleration is -kp * (attitude error) - kd * (rate), with the rate itself instead of its
    error. To turn with the trajectory, the commanded attitude must lead it by (kd * rate + angular acceleration) / kp.
    Motors respond `tau_m` + `hold` / 2 late, so thrust and angular acceleration are commanded that much earlier.
    """
    kp, kd = vehicle.attitude_gains
    motion = trajectory.at(times)
    late = times + vehicle.parameters["tau_m"] + hold / 2
    before, _ = thrust_along(trajectory, vehicle, times - _DIFFERENCE_STEP)
    now, _ = thrust_along(trajectory, vehicle, times)
    after, _ = thrust_along(trajectory, vehicle, times + _DIFFERENCE_STEP)
    rate = (after - before) / (2 * _DIFFERENCE_STEP)
    soon, thrust = thrust_along(trajectory, vehicle, late)
    bend = (
        thrust_along(trajectory, vehicle, late + _DIFFERENCE_STEP)[0]
        + thrust_along(trajectory, vehicle, late - _DIFFERENCE_STEP)[0]
        - 2 * soon
    )
    ahead = (kd * rate + bend / _DIFFERENCE_STEP**2) / kp
    ahead -= np.sum(ahead * now, axis=1, keepdims=True) * now
    reach = np.linalg.norm(ahead, axis=1, keepdims=True)  # the sine of the lead angle
    ahead *= np.minimum(1.0, _MAX_LEAD_SINE / np.maximum(reach, 1e-12))
    level = np.sqrt(1.0 - np.minimum(reach, _MAX_LEAD_SINE) ** 2)
    wanted = (now * level + ahead) * (thrust[:, None] / level)  # the controller projects the thrust on `now`
    return Motion(motion.position, motion.velocity, wanted / vehicle.mass - GRAVITY * VERTICAL)


_MAX_LEAD_SINE = 0.5
"""The sine of the largest angle by which the commanded attitude leads."""


def thrust_along(trajectory: Trajectory, vehicle: Vehicle, times: Floats) -> tuple[Floats, Floats]:
    """Return direction, (m, 3), and newtons, (m,), of the rotors' thrust on the trajectory in still air."""
    made = vehicle.parameters
    motion = trajectory.at(times)
    force = vehicle.mass * (motion.acceleration + GRAVITY * VERTICAL)
    wanted = force
    for _ in range(4):  # a fixed-point iteration, since drag and attitude depend on each other
        thrust = np.linalg.norm(wanted, axis=1)
        up = wanted / thrust[:, None]
        wanted = force - _air(made, motion.velocity, up, thrust)
    thrust = np.linalg.norm(wanted, axis=1)
    return wanted / thrust[:, None], thrust


def _air(made: dict[str, Any], velocity: Floats, up: Floats, thrust: Floats) -> Floats:
    """Return rotorpy's aerodynamic force without the thrust, (m, 3) newtons, in still air and with a yaw of 0."""
    speeds = np.sqrt(made["num_rotors"] * thrust / made["k_eta"])  # the sum of the rotors' speeds
    left = np.cross(up, [1.0, 0.0, 0.0])
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    axes = np.stack([np.cross(left, up), left, up], axis=1)  # (m, axis, 3)
    wind = np.einsum("mak,mk->ma", axes, velocity)
    rotors = np.array([made["k_d"], made["k_d"], made["k_z"]]) * speeds[:, None]
    body = np.array([made["c_Dx"], made["c_Dy"], made["c_Dz"]]) * np.linalg.norm(velocity, axis=1)[:, None]
    push = -(rotors + body) * wind
    push[:, 2] += made["num_rotors"] * made["k_h"] * (wind[:, 0] ** 2 + wind[:, 1] ** 2)
    return np.einsum("mak,ma->mk", axes, push)


COMMAND_RATE = 100.0
"""Commands, and samples, per second."""
HOVER_SECONDS = 3.0
"""Seconds for which a UAV hovers at its start, in the wind, before it departs."""
SETTLING_SECONDS = 1.0
"""Seconds for which a UAV is still simulated after its trajectory has ended."""


@dataclass(frozen=True, eq=False)
class Commands:
    """The commands to one UAV.

    Attributes
    ----------
    times
        (m,) seconds into the mission, a hundredth apart; the first `hover` of them lie before the departure.
    reference
        What is commanded at those times.
    height
        (m,) metres above the terrain, or above the floor of the bounds where there is none.
    hover
        How many samples precede the departure.
    """

    times: Floats
    reference: Motion
    height: Floats
    hover: int


def commands_to(mission: Mission, uav: int, vehicle: Vehicle) -> Commands:
    """Return the commands to a UAV from a hover before its departure until it has settled after its arrival.

    Raises
    ------
    InputError
        If the scenario has movers, or zones that are closed at times, which no simulated flight is judged against.
    """
    trajectory, scenario = mission.trajectories[uav], mission.scenario
    if scenario.movers:
        said = "flights among movers cannot be simulated unless they are replanned in flight; this scenario has movers"
        raise InputError(f"{scenario.name}: {said}")
    if any(map(is_closed_at_times, scenario.zones)):
        raise InputError(
            f"{scenario.name}: flights among zones that are closed at times cannot be simulated; this scenario has such"
        )
    assert trajectory is not None
    return commanded(scenario, trajectory, vehicle, trajectory.end + SETTLING_SECONDS)


def commanded(scenario: Scenario, trajectory: Trajectory, vehicle: Vehicle, until: float) -> Commands:
    """Return the commands to a UAV that flies a trajectory, from a hover before its start until an instant, seconds."""
    hover = round(HOVER_SECONDS * COMMAND_RATE)
    first = np.floor(trajectory.start * COMMAND_RATE) - hover
    last = np.ceil(until * COMMAND_RATE)
    times = np.arange(first, last + 1) / COMMAND_RATE
    told = reference(trajectory, vehicle, times, 1.0 / COMMAND_RATE)
    above = np.asarray(told.position[:, 2] - ground_height(scenario, told.position[:, :2]))
    return Commands(times, told, above, hover)
