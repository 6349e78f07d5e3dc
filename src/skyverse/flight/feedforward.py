"""What the controller is told so that it follows: the acceleration that makes the vehicle fly the reference.

rotorpy's SE3 controller knows neither drag nor that attitude and motors lag. A quadrotor is differentially flat, with
rotor drag too (Faessler, Franchi, Scaramuzza, "Differential flatness of quadrotor dynamics subject to rotor drag",
IEEE RA-L 3, 2018): position in time tells its attitude, its turning and its thrust, and so what to command for them.
"""

from typing import Any, NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.vehicle import Vehicle
from skyverse.model.trajectory import Trajectory
from skyverse.trajectory.limits import GRAVITY

VERTICAL = np.array([0.0, 0.0, 1.0])
_DIFFERENCE_STEP = 0.005
"""Seconds between the instants from which turning is differenced."""


class Reference(NamedTuple):
    """What is commanded at some instants, (m, 3) each.

    `acceleration` is not the trajectory's own, but what must be asked for to get it.
    """

    position: Floats
    velocity: Floats
    acceleration: Floats


def reference(trajectory: Trajectory, vehicle: Vehicle, gains: Any, times: Floats, hold: float) -> Reference:
    """Return what to command at `times`, (m,) seconds, each command held for `hold` seconds.

    The controller turns by -kp * (error of attitude) - kd * (rate), rate and not its error; to turn as the trajectory
    does, attitude must be asked for ahead of it, by (kd * rate + rate's change) / kp. What motors do comes `tau_m` and
    half of `hold` late: thrust and change of rate are asked for so much earlier.
    """
    motion = trajectory.at(times)
    late = times + vehicle.parameters["tau_m"] + hold / 2
    before, _ = _thrust(trajectory, vehicle, times - _DIFFERENCE_STEP)
    now, _ = _thrust(trajectory, vehicle, times)
    after, _ = _thrust(trajectory, vehicle, times + _DIFFERENCE_STEP)
    rate = (after - before) / (2 * _DIFFERENCE_STEP)
    soon, thrust = _thrust(trajectory, vehicle, late)
    bend = (
        _thrust(trajectory, vehicle, late + _DIFFERENCE_STEP)[0]
        + _thrust(trajectory, vehicle, late - _DIFFERENCE_STEP)[0]
        - 2 * soon
    )
    ahead = (gains.kd_att * rate + bend / _DIFFERENCE_STEP**2) / gains.kp_att
    ahead -= np.sum(ahead * now, axis=1, keepdims=True) * now
    reach = np.linalg.norm(ahead, axis=1, keepdims=True)  # the sine of the angle ahead
    ahead *= np.minimum(1.0, _MAX_LEAD_SINE / np.maximum(reach, 1e-12))
    level = np.sqrt(1.0 - np.minimum(reach, _MAX_LEAD_SINE) ** 2)
    wanted = (now * level + ahead) * (thrust[:, None] / level)  # the controller thrusts by its share along `now`
    return Reference(motion.position, motion.velocity, wanted / vehicle.mass - GRAVITY * VERTICAL)


_MAX_LEAD_SINE = 0.5
"""The sine of the largest angle by which attitude is asked for ahead."""


def _thrust(trajectory: Trajectory, vehicle: Vehicle, times: Floats) -> tuple[Floats, Floats]:
    """Return the direction (m, 3) and the newtons (m,) of the rotors' thrust that fly the trajectory in still air."""
    made = vehicle.parameters
    motion = trajectory.at(times)
    force = vehicle.mass * (motion.acceleration + GRAVITY * VERTICAL)
    wanted = force
    for _ in range(4):  # drag depends on attitude, and attitude on drag
        thrust = np.linalg.norm(wanted, axis=1)
        up = wanted / thrust[:, None]
        wanted = force - _air(made, motion.velocity, up, thrust)
    thrust = np.linalg.norm(wanted, axis=1)
    return wanted / thrust[:, None], thrust


def _air(made: dict[str, Any], velocity: Floats, up: Floats, thrust: Floats) -> Floats:
    """Return what still air does to the vehicle as rotorpy has it, (m, 3) newtons, without the thrust; yaw is nil."""
    speeds = np.sqrt(made["num_rotors"] * thrust / made["k_eta"])  # the sum of the rotors'
    left = np.cross(up, [1.0, 0.0, 0.0])
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    axes = np.stack([np.cross(left, up), left, up], axis=1)  # (m, axis, 3)
    wind = np.einsum("mak,mk->ma", axes, velocity)
    rotors = np.array([made["k_d"], made["k_d"], made["k_z"]]) * speeds[:, None]
    body = np.array([made["c_Dx"], made["c_Dy"], made["c_Dz"]]) * np.linalg.norm(velocity, axis=1)[:, None]
    push = -(rotors + body) * wind
    push[:, 2] += made["num_rotors"] * made["k_h"] * (wind[:, 0] ** 2 + wind[:, 1] ** 2)
    force: Floats = np.einsum("mak,ma->mk", axes, push)
    return force
