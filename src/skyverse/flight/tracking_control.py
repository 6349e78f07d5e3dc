"""The flight of a quadrotor that a controller keeps on its trajectory, compiled.

The controller is rotorpy's ``SE3Control`` (Lee, Leok, McClamroch, "Geometric tracking control of a quadrotor UAV on
SE(3)", CDC 2010) with rotorpy's gains. It gets the same commands as in rotorpy: those of `feedforward`, less the
wind's acceleration as `wind_observer` estimates it, within the largest tilt.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.quadrotor import (
    ATTITUDE,
    POSITION,
    RATE,
    ROTORS,
    STATE_SIZE,
    VELOCITY,
    Quadrotor,
    Scratch,
    advance,
    make_scratch,
    set_rotation,
    set_wrench,
)
from skyverse.model.uav import GRAVITY
from skyverse.numerics.kernel import by_reference, inner, kernel

POSITION_GAINS = (6.5, 6.5, 15.0)
"""rotorpy's gains for the error of position on each axis, 1/s^2."""
VELOCITY_GAINS = (4.0, 4.0, 9.0)
"""rotorpy's gains for the error of velocity on each axis, 1/s."""
OBSERVER_BANDWIDTH = 8.0
"""The bandwidth of the observer of the wind, 1/s."""
LOST_DISTANCE = 20.0
"""Metres: a UAV that is farther from its trajectory is lost."""


@by_reference
class DrawnDisturbances(NamedTuple):
    """What disturbs a flight of m samples.

    Attributes
    ----------
    wind
        (m, 3) m/s: the velocity of the air, which holds until the next sample.
    position_error, velocity_error
        (m, 3) metres and m/s: what the controller measures, less what is true.
    delay
        The number of samples by which the measured position and velocity are late.
    """

    wind: Floats
    position_error: Floats
    velocity_error: Floats
    delay: int


@kernel
def track(
    real: Quadrotor,
    known: Quadrotor,
    position: Floats,
    velocity: Floats,
    acceleration: Floats,
    disturbed: DrawnDisturbances,
    period: float,
) -> tuple[int, Floats]:
    """Fly one quadrotor along m commands, each held for `period` seconds, from a hover at the first.

    Parameters
    ----------
    real, known
        The quadrotor that flies, and the one that the controller believes to fly.
    position, velocity, acceleration
        (m, 3) commands; see `commands.reference`.
    disturbed
        Wind, errors of measurement and delay.
    period
        Seconds between two commands.

    Returns
    -------
    count, states
        The number of samples until the last, or until the UAV was lost, and (m, 17) states at the samples.
    """
    count = len(position)
    states = np.empty((count, STATE_SIZE))
    state, commanded, calm = np.zeros(STATE_SIZE), np.empty(4), np.zeros(3)
    scratch = make_scratch()
    told, explained, push = np.empty(6), np.empty(3), np.zeros(3)
    for i in range(3):
        state[POSITION + i] = position[0, i]
        explained[i] = disturbed.velocity_error[0, i]
    state[ATTITUDE + 3] = 1.0
    for k in range(4):
        state[ROTORS + k] = math.sqrt(known.mass * GRAVITY / (4.0 * known.thrust))
    for k in range(count):
        states[k] = state
        late = max(0, k - disturbed.delay)
        for i in range(3):
            told[i] = states[late, POSITION + i] + disturbed.position_error[k, i]
            told[3 + i] = states[late, VELOCITY + i] + disturbed.velocity_error[k, i]
        _observe(known, state, told, calm, period, scratch, explained, push)
        asked = (position[k], velocity[k], acceleration[k])
        _command(known, state, told, push, asked, scratch, commanded)
        advance(real, state, disturbed.wind[k], commanded, period, scratch)
        away = 0.0
        for i in range(3):
            away += (state[POSITION + i] - position[k, i]) ** 2
        if not away < LOST_DISTANCE**2:
            return k + 1, states
    return count, states


@inner
def _observe(
    known: Quadrotor,
    state: Floats,
    told: Floats,
    calm: Floats,
    period: float,
    scratch: Scratch,
    explained: Floats,
    push: Floats,
) -> None:
    """Write the estimate of the wind's acceleration into `push` (3,); see `WindObserver`, which does the same."""
    trial, rotation, wrench = scratch.trial, scratch.rotation, scratch.wrench
    trial[:] = state
    for i in range(3):
        trial[VELOCITY + i] = told[3 + i]
    set_rotation(trial, rotation)
    set_wrench(known, trial, rotation, calm, wrench)
    for i in range(3):
        push[i] = OBSERVER_BANDWIDTH * (told[3 + i] - explained[i])
        force = rotation[i, 0] * wrench[0] + rotation[i, 1] * wrench[1] + rotation[i, 2] * wrench[2]
        explained[i] += (force / known.mass - (GRAVITY if i == 2 else 0.0) + push[i]) * period


@inner
def _command(
    known: Quadrotor,
    state: Floats,
    told: Floats,
    push: Floats,
    asked: tuple[Floats, Floats, Floats],
    scratch: Scratch,
    commanded: Floats,
) -> None:
    """Write the commanded rotor speeds, rad/s, into (4,), for a position, a velocity and an acceleration (3,) each.

    With the wanted force f, of which the tilt is limited, and the attitude's columns b_1, b_2, b_3 as they are and
    c_1, c_2, c_3 as wanted (c_3 along f, no yaw), the error of attitude is e = (c_3.b_2 - c_2.b_3, c_1.b_3 - c_3.b_1,
    c_2.b_1 - c_1.b_2) / 2, the total thrust f.b_3, and the moments J (-k_p e - k_d w) + w x J w.
    """
    rotation, inertia = scratch.rotation, known.inertia
    position, velocity, acceleration = asked
    ax, ay, az = acceleration[0] - push[0], acceleration[1] - push[1], acceleration[2] - push[2]
    ax -= POSITION_GAINS[0] * (told[0] - position[0]) + VELOCITY_GAINS[0] * (told[3] - velocity[0])
    ay -= POSITION_GAINS[1] * (told[1] - position[1]) + VELOCITY_GAINS[1] * (told[4] - velocity[1])
    az -= POSITION_GAINS[2] * (told[2] - position[2]) + VELOCITY_GAINS[2] * (told[5] - velocity[2])
    if known.max_tilt < math.inf:
        most = max(az + GRAVITY, 0.0) * math.tan(math.radians(known.max_tilt))
        share = min(1.0, most / max(math.hypot(ax, ay), 1e-12))
        ax *= share
        ay *= share
    fx, fy, fz = known.mass * ax, known.mass * ay, known.mass * (az + GRAVITY)
    set_rotation(state, rotation)
    total = fx * rotation[0, 2] + fy * rotation[1, 2] + fz * rotation[2, 2]
    force = max(math.sqrt(fx * fx + fy * fy + fz * fz), 1e-12)
    c3x, c3y, c3z = fx / force, fy / force, fz / force
    level = max(math.sqrt(c3z * c3z + c3y * c3y), 1e-12)
    c2y, c2z = c3z / level, -c3y / level  # c_3 x (1, 0, 0), normalised
    c1x, c1y, c1z = c2y * c3z - c2z * c3y, c2z * c3x, -c2y * c3x
    ex = 0.5 * (
        (c3x * rotation[0, 1] + c3y * rotation[1, 1] + c3z * rotation[2, 1])
        - (c2y * rotation[1, 2] + c2z * rotation[2, 2])
    )
    ey = 0.5 * (
        (c1x * rotation[0, 2] + c1y * rotation[1, 2] + c1z * rotation[2, 2])
        - (c3x * rotation[0, 0] + c3y * rotation[1, 0] + c3z * rotation[2, 0])
    )
    ez = 0.5 * (
        (c2y * rotation[1, 0] + c2z * rotation[2, 0])
        - (c1x * rotation[0, 1] + c1y * rotation[1, 1] + c1z * rotation[2, 1])
    )
    p, q, r = state[RATE], state[RATE + 1], state[RATE + 2]
    tx, ty, tz = (
        -known.gains[0] * ex - known.gains[1] * p,
        -known.gains[0] * ey - known.gains[1] * q,
        -known.gains[0] * ez - known.gains[1] * r,
    )
    spin_x = inertia[0, 0] * p + inertia[0, 1] * q + inertia[0, 2] * r
    spin_y = inertia[1, 0] * p + inertia[1, 1] * q + inertia[1, 2] * r
    spin_z = inertia[2, 0] * p + inertia[2, 1] * q + inertia[2, 2] * r
    mx = inertia[0, 0] * tx + inertia[0, 1] * ty + inertia[0, 2] * tz + q * spin_z - r * spin_y
    my = inertia[1, 0] * tx + inertia[1, 1] * ty + inertia[1, 2] * tz + r * spin_x - p * spin_z
    mz = inertia[2, 0] * tx + inertia[2, 1] * ty + inertia[2, 2] * tz + p * spin_y - q * spin_x
    for k in range(4):
        row = known.allocation[k]
        thrust = row[0] * total + row[1] * mx + row[2] * my + row[3] * mz
        speed = math.copysign(math.sqrt(abs(thrust) / known.thrust), thrust)
        commanded[k] = min(max(speed, known.slowest), known.fastest)
