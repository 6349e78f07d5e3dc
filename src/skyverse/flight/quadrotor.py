"""The mechanics of a quadrotor, compiled: a rigid body, four rotors that lag, and drag.

The equations are those of rotorpy's ``Multirotor`` (Folk, Paulos, Kumar, "RotorPy: a Python-based multirotor simulator
with aerodynamics for education and research", 2023), without the flapping of blades, which is 0 in all vehicles here.
With the rotation R from body to world, the air's velocity relative to the body in the body's frame, a, and at rotor k
with position r_k, direction d_k and speed s_k the relative velocity a_k = a + w x r_k, they are

    m v'  =  R F - m g e_z,       F  =  sum_k f_k  -  |a| C a
    J w'  =  M - w x J w,         M  =  sum_k (r_k x f_k + d_k k_m s_k^2 e_z)
    f_k   =  (k_eta s_k^2 + k_h (a_kx^2 + a_ky^2)) e_z  -  s_k K a_k
    s_k'  =  (commanded s_k - s_k) / tau,      q'  =  q (w, 0) / 2

where C and K are the diagonal matrices of body drag and rotor drag.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.vehicle import Vehicle
from skyverse.model.uav import GRAVITY
from skyverse.numerics.kernel import by_reference, inner

POSITION, VELOCITY, ATTITUDE, RATE, ROTORS, STATE_SIZE = 0, 3, 6, 10, 13, 17
"""Where a state (17,) holds position (m), velocity (m/s), the quaternion x, y, z, w, and, in rad/s, the rates of the
body and the speeds of the rotors."""


@by_reference
class Quadrotor(NamedTuple):
    """What kernels know of a quadrotor, in SI units.

    Attributes
    ----------
    mass, thrust, lift, lag
        The mass; thrust per squared rotor speed (k_eta); translational lift (k_h); time constant of the rotors.
    slowest, fastest
        The least and the greatest speed of a rotor, rad/s.
    inertia, inverse
        (3, 3) the tensor of inertia and its inverse.
    body_drag, rotor_drag
        (3,) the diagonals of C and K.
    yaw_moment
        (4,) d_k k_m, the yaw moment per squared speed of each rotor.
    rotors
        (4, 3) the rotors' positions.
    allocation
        (4, 4) thrusts of the rotors from total thrust and three moments.
    gains
        (2,) the attitude controller's gains for the error of attitude (1/s^2) and of rate (1/s).
    max_tilt
        Degrees from the vertical to which the commanded thrust is limited; infinite without a limit.
    """

    mass: float
    thrust: float
    lift: float
    lag: float
    slowest: float
    fastest: float
    inertia: Floats
    inverse: Floats
    body_drag: Floats
    rotor_drag: Floats
    yaw_moment: Floats
    rotors: Floats
    allocation: Floats
    gains: Floats
    max_tilt: float


@by_reference
class Scratch(NamedTuple):
    """Memory for intermediate results, made once for a flight.

    Attributes
    ----------
    rotation
        (3, 3) a rotation matrix.
    wrench
        (6,) a force and a moment.
    slopes, trial
        (4, 17) and (17,) what a step of Runge-Kutta needs.
    """

    rotation: Floats
    wrench: Floats
    slopes: Floats
    trial: Floats


@inner
def make_scratch() -> Scratch:
    """Return new memory for intermediate results."""
    return Scratch(np.empty((3, 3)), np.empty(6), np.empty((4, STATE_SIZE)), np.empty(STATE_SIZE))


def quadrotor_of(vehicle: Vehicle) -> Quadrotor:
    """Return a vehicle as kernels take it."""
    made = vehicle.parameters
    xx, yy, zz, xy, yz, xz = (float(made[name]) for name in ("Ixx", "Iyy", "Izz", "Ixy", "Iyz", "Ixz"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    rotors = np.array([made["rotor_pos"][key] for key in made["rotor_pos"]], dtype=np.float64)
    directions = np.array(made["rotor_directions"], dtype=np.float64)
    moments = np.cross(rotors, [0.0, 0.0, 1.0])[:, :2].T
    mixing = np.vstack([np.ones(4), moments, directions * made["k_m"] / made["k_eta"]])
    return Quadrotor(
        mass=vehicle.mass,
        thrust=float(made["k_eta"]),
        lift=float(made["k_h"]),
        lag=float(made["tau_m"]),
        slowest=float(made["rotor_speed_min"]),
        fastest=float(made["rotor_speed_max"]),
        inertia=inertia,
        inverse=np.linalg.inv(inertia),
        body_drag=np.array([made["c_Dx"], made["c_Dy"], made["c_Dz"]], dtype=np.float64),
        rotor_drag=np.array([made["k_d"], made["k_d"], made["k_z"]], dtype=np.float64),
        yaw_moment=directions * float(made["k_m"]),
        rotors=rotors,
        allocation=np.linalg.inv(mixing),
        gains=np.array(vehicle.attitude_gains),
        max_tilt=math.inf if vehicle.max_tilt is None else float(vehicle.max_tilt),
    )


@inner
def set_rotation(state: Floats, rotation: Floats) -> None:
    """Write the rotation matrix (3, 3), from body to world, of the quaternion in a state."""
    x, y, z, w = state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3]
    two = 2.0 / (x * x + y * y + z * z + w * w)
    rotation[0, 0] = 1.0 - two * (y * y + z * z)
    rotation[0, 1] = two * (x * y - z * w)
    rotation[0, 2] = two * (x * z + y * w)
    rotation[1, 0] = two * (x * y + z * w)
    rotation[1, 1] = 1.0 - two * (x * x + z * z)
    rotation[1, 2] = two * (y * z - x * w)
    rotation[2, 0] = two * (x * z - y * w)
    rotation[2, 1] = two * (y * z + x * w)
    rotation[2, 2] = 1.0 - two * (x * x + y * y)


@inner
def set_wrench(quad: Quadrotor, state: Floats, rotation: Floats, wind: Floats, wrench: Floats) -> None:
    """Write the aerodynamic force (newtons) and moment (newton metres), both in the body's frame, into (6,)."""
    east, north, up = (
        state[VELOCITY] - wind[0],
        state[VELOCITY + 1] - wind[1],
        state[VELOCITY + 2] - wind[2],
    )
    ax = rotation[0, 0] * east + rotation[1, 0] * north + rotation[2, 0] * up
    ay = rotation[0, 1] * east + rotation[1, 1] * north + rotation[2, 1] * up
    az = rotation[0, 2] * east + rotation[1, 2] * north + rotation[2, 2] * up
    speed = math.sqrt(ax * ax + ay * ay + az * az)
    wrench[0] = -speed * quad.body_drag[0] * ax
    wrench[1] = -speed * quad.body_drag[1] * ay
    wrench[2] = -speed * quad.body_drag[2] * az
    wrench[3] = wrench[4] = wrench[5] = 0.0
    p, q, r = state[RATE], state[RATE + 1], state[RATE + 2]
    for k in range(4):
        rx, ry, rz = quad.rotors[k, 0], quad.rotors[k, 1], quad.rotors[k, 2]
        s = state[ROTORS + k]
        bx, by, bz = ax + q * rz - r * ry, ay + r * rx - p * rz, az + p * ry - q * rx
        fx, fy = -s * quad.rotor_drag[0] * bx, -s * quad.rotor_drag[1] * by
        fz = quad.thrust * s * s + quad.lift * (bx * bx + by * by) - s * quad.rotor_drag[2] * bz
        wrench[0] += fx
        wrench[1] += fy
        wrench[2] += fz
        wrench[3] += ry * fz - rz * fy
        wrench[4] += rz * fx - rx * fz
        wrench[5] += rx * fy - ry * fx + quad.yaw_moment[k] * s * s


@inner
def set_change(
    quad: Quadrotor, state: Floats, wind: Floats, commanded: Floats, scratch: Scratch, change: Floats
) -> None:
    """Write the derivative of a state over time into (17,)."""
    rotation, wrench, inertia, inverse = scratch.rotation, scratch.wrench, quad.inertia, quad.inverse
    set_rotation(state, rotation)
    set_wrench(quad, state, rotation, wind, wrench)
    for i in range(3):
        change[POSITION + i] = state[VELOCITY + i]
        force = rotation[i, 0] * wrench[0] + rotation[i, 1] * wrench[1] + rotation[i, 2] * wrench[2]
        change[VELOCITY + i] = force / quad.mass
    change[VELOCITY + 2] -= GRAVITY
    x, y, z, w = state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3]
    p, q, r = state[RATE], state[RATE + 1], state[RATE + 2]
    change[ATTITUDE] = 0.5 * (w * p - z * q + y * r)
    change[ATTITUDE + 1] = 0.5 * (z * p + w * q - x * r)
    change[ATTITUDE + 2] = 0.5 * (-y * p + x * q + w * r)
    change[ATTITUDE + 3] = 0.5 * (-x * p - y * q - z * r)
    spin_x = inertia[0, 0] * p + inertia[0, 1] * q + inertia[0, 2] * r
    spin_y = inertia[1, 0] * p + inertia[1, 1] * q + inertia[1, 2] * r
    spin_z = inertia[2, 0] * p + inertia[2, 1] * q + inertia[2, 2] * r
    mx = wrench[3] - (q * spin_z - r * spin_y)
    my = wrench[4] - (r * spin_x - p * spin_z)
    mz = wrench[5] - (p * spin_y - q * spin_x)
    for i in range(3):
        change[RATE + i] = inverse[i, 0] * mx + inverse[i, 1] * my + inverse[i, 2] * mz
    for k in range(4):
        change[ROTORS + k] = (commanded[k] - state[ROTORS + k]) / quad.lag


@inner
def advance(quad: Quadrotor, state: Floats, wind: Floats, commanded: Floats, period: float, scratch: Scratch) -> None:
    """Advance a state by `period` seconds with the classical Runge-Kutta method in steps no longer than the lag.

    The commanded rotor speeds (4,) and the wind (3,) hold for the whole period.
    """
    steps = max(1, math.ceil(period / quad.lag - 1e-9))
    h = period / steps
    slopes, trial = scratch.slopes, scratch.trial
    for _ in range(steps):
        set_change(quad, state, wind, commanded, scratch, slopes[0])
        for stage in range(1, 4):
            ahead = h if stage == 3 else 0.5 * h
            for i in range(STATE_SIZE):
                trial[i] = state[i] + ahead * slopes[stage - 1, i]
            set_change(quad, trial, wind, commanded, scratch, slopes[stage])
        for i in range(STATE_SIZE):
            state[i] += h / 6.0 * (slopes[0, i] + 2.0 * slopes[1, i] + 2.0 * slopes[2, i] + slopes[3, i])
    length = 0.0
    for i in range(ATTITUDE, RATE):
        length += state[i] * state[i]
    length = math.sqrt(length)
    for i in range(ATTITUDE, RATE):
        state[i] /= length
    for k in range(ROTORS, STATE_SIZE):
        state[k] = min(max(state[k], quad.slowest), quad.fastest)
