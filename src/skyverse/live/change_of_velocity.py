"""Changes of velocity from a motion that is being flown, with continuous acceleration and bounded jerk.

A UAV that accelerates first gives up its acceleration, at the largest jerk, unless the change of velocity that is left
after that has the same direction. In one direction, let the speed change by c and the acceleration from b to none. With
the largest acceleration a and the jerk j, the acceleration rises to

    p = min(a, sqrt(j c + b^2 / 2))    where c >= b |b| / (2 j),

is held for (c - (2 p^2 - b^2) / (2 j)) / p seconds, and falls to 0 again; otherwise it does so the other way round. The
velocity stays between the two of the motion that is flown and the one that is asked for, so that all of a UAV's limits
are kept if both of these keep them.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import ACCELERATION_LEFT, MIN_SPEED_CHANGE, SPEED_OFF_RAMP
from skyverse.trajectory.limits import Limits
from skyverse.trajectory.ramp import largest_acceleration
from skyverse.trajectory.straight_legs import add_piece

MOST_PIECES = 4
"""Pieces of a change of velocity at most."""


@inner
def dot(a: Floats, b: Floats) -> float:
    """Return the scalar product of two vectors (3,)."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@inner
def length(a: Floats) -> float:
    """Return the norm of a vector (3,)."""
    return math.sqrt(dot(a, a))


@inner
def change_velocity(
    durations: Floats, rows: Floats, state: Floats, asked: Floats, limits: Limits
) -> tuple[int, Floats, Floats]:
    """Write the pieces of a change of velocity.

    Parameters
    ----------
    durations, rows
        (n,) seconds and (n, 4, 3) metres, by powers of the time since the piece began; `MOST_PIECES` are written.
    state
        (3, 3): position, velocity and acceleration, metres and seconds.
    asked
        (3,) the velocity after the change, m/s.
    limits
        Those of a multirotor.

    Returns
    -------
    tuple
        How many pieces there are, and the position and the velocity, (3,) each, at their end.
    """
    position, velocity, acceleration = state[0].copy(), state[1].copy(), state[2].copy()
    m = 0
    size = length(acceleration)
    if size > ACCELERATION_LEFT:
        way = acceleration / size
        released = velocity + (0.5 * size * size / limits.jerk) * way
        left = asked - released
        along = dot(left, way)
        if length(left - along * way) <= SPEED_OFF_RAMP:
            speed_up = along + 0.5 * size * size / limits.jerk
            return _ramp(durations, rows, (position, velocity, way), (size, speed_up), limits)
        seconds = size / limits.jerk
        m = add_piece(durations, rows, m, seconds, (position, velocity, acceleration, -limits.jerk * way))
        position = position + seconds * velocity + (size * seconds * seconds / 3.0) * way
        velocity = released
    change = asked - velocity
    size = length(change)
    if size <= MIN_SPEED_CHANGE:
        return m, position, velocity
    k, position, velocity = _ramp(durations[m:], rows[m:], (position, velocity, change / size), (0.0, size), limits)
    return m + k, position, velocity


@inner
def _ramp(
    durations: Floats,
    rows: Floats,
    motion: tuple[Floats, Floats, Floats],
    change: tuple[float, float],
    limits: Limits,
) -> tuple[int, Floats, Floats]:
    """Write the pieces of a change of speed in one direction; see `change_velocity`.

    `motion` is a position, a velocity and the direction; `change` the acceleration along it that is there already, and
    the change of speed.
    """
    position, velocity, way = motion
    now, speed_up = change
    jerk = limits.jerk
    if speed_up < 0.5 * now * abs(now) / jerk:
        way, now, speed_up = -way, -now, -speed_up
    peak = min(largest_acceleration(limits, way), math.sqrt(max(jerk * speed_up + 0.5 * now * now, 0.0)))
    peak = max(peak, now, 0.0)
    held = max((speed_up - (peak * peak - 0.5 * now * now) / jerk) / peak, 0.0) if peak > 0.0 else 0.0
    m = 0
    for part in range(3):
        seconds = held
        rate = 0.0
        if part == 0:
            seconds, rate = (peak - now) / jerk, jerk
        elif part == 2:
            seconds, rate = peak / jerk, -jerk
        begin = now if part == 0 else peak
        m = add_piece(durations, rows, m, seconds, (position, velocity, begin * way, rate * way))
        position = position + seconds * velocity + (seconds * seconds * (0.5 * begin + rate * seconds / 6.0)) * way
        velocity = velocity + (seconds * (begin + 0.5 * rate * seconds)) * way
    return m, position, velocity


@kernel
def braking_motion(state: Floats, limits: Limits) -> tuple[Floats, Floats]:
    """Return the fastest stop from a state (3, 3): pieces of (m,) seconds, and their coefficients (m, 4, 3), metres."""
    durations, rows = np.empty(MOST_PIECES), np.zeros((MOST_PIECES, 4, 3))
    m, _, _ = change_velocity(durations, rows, state, np.zeros(3), limits)
    return durations[:m].copy(), rows[:m].copy()
