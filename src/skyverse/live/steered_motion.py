"""Changes of velocity from a motion that is being flown, with continuous acceleration and bounded jerk.

A UAV that accelerates first gives up its acceleration, at the largest jerk, unless the change of velocity that is left
after that has the same direction. In one direction, let the speed change by c and the acceleration from b to none. With
the largest acceleration a and the jerk j, the acceleration rises to

    p = min(a, sqrt(j c + b^2 / 2))    where c >= b |b| / (2 j),

is held for (c - (2 p^2 - b^2) / (2 j)) / p seconds, and falls to 0 again; otherwise it does so the other way round. The
velocity stays between the two of the motion that is flown and the one that is asked for, so that all of a UAV's limits
are kept if both of these keep them.

Motions from the state in which a UAV is to the points of a way, which come to rest in time.

The velocity first changes to one towards the first point. The legs and blends that follow are those of
`trajectory.straight_legs`; they end on the way where the UAV comes to rest within the seconds that are given.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.arrays import put
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import (
    ACCELERATION_LEFT,
    AIM_CONVERGED,
    AIM_OFF,
    MIN_SEGMENT,
    MIN_SPEED_CHANGE,
    SPEED_OFF_RAMP,
)
from skyverse.trajectory.limits import Limits
from skyverse.trajectory.ramp import largest_acceleration, largest_speed
from skyverse.trajectory.straight_legs import add_piece, corner_speeds_from, legs_between, pieces_along

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


AIM_ROUNDS = 40
"""How often the direction towards the first point is corrected for the way that the change of velocity takes."""
FIRST_ROUNDS, SLOW_TO_AIM = 8, 1e-3
"""After so many corrections the direction changes by no more than this, or else it is given up."""
SLOWER_ROUNDS = 8
"""How often a smaller speed towards the first point is tried."""
SLOWER = 0.7
"""The factor by which that speed is made smaller where the point cannot be reached at it."""
LEAST_SPEED = 0.02
"""M/s: slower motions are not sought."""
LEAST_WAY = 0.02
"""Metres: shorter ways are not sought."""
SHORTER_ROUNDS = 12
"""How often a way is made shorter until the UAV comes to rest in time."""
SHORTEST, LONGEST = 0.5, 0.93
"""Between which factors a way is made shorter each time."""

Steered = tuple[Floats, Floats, Floats, float]


@kernel
def steered_motion(
    state: Floats, points: Floats, most: Floats, limits: Limits, share: float, seconds: float, looked_at: float
) -> Steered:
    """Return a motion along a way that comes to rest in time.

    Parameters
    ----------
    state
        (3, 3): position, velocity and acceleration from which it begins, metres and seconds.
    points, most
        (n, 3) and (n,) metres: the way, n >= 1, and how far its blends may be from its points.
    limits
        Those of a multirotor.
    share
        Of the largest speed that is used.
    seconds
        Until it has come to rest.
    looked_at
        Seconds after which the rest of the way is estimated.

    Returns
    -------
    durations, rows
        (m,) seconds and (m, 4, 3) metres, by powers of the time since the piece began; none if there is no such motion.
    passed
        (n,) seconds at which each point is passed; infinite for those that are not reached.
    arrival
        About how many seconds it would take to the end of the way, if the UAV then need not come to rest before.
    """
    whole = length(points[0] - state[0])
    for k in range(1, len(points)):
        whole += length(points[k] - points[k - 1])
    far = length(points[0] - state[0])
    fast = dot(state[1], points[0] - state[0]) / far if far > 0.0 else 0.0
    reach = _way_to_rest(limits, share * limits.speed, fast, seconds)
    if whole <= reach:
        reach = math.inf
    cap = math.inf
    for _ in range(SHORTER_ROUNDS):
        if reach < LEAST_WAY:
            break
        durations, rows, passed, cap = _motion_within(state, points, most, limits, (share, cap), reach)
        if len(durations) == 0:
            break
        total = durations.sum()
        if total <= seconds:
            return durations, rows, passed, _arrival(durations, rows, points, passed, limits, looked_at)
        reach = min(reach, whole) * max(SHORTEST, min(LONGEST, seconds / total))
    return np.empty(0), np.empty((0, 4, 3)), np.full(len(points), math.inf), math.inf


@inner
def _way_to_rest(limits: Limits, top: float, fast: float, seconds: float) -> float:
    """Return about how far a UAV gets straight on, from a speed to rest, in the seconds given."""
    rise = limits.acceleration / limits.jerk
    peak = min(top, 0.5 * (fast + limits.acceleration * (seconds - 2.0 * rise)))
    up, down = abs(peak - fast), max(peak, 0.0)
    slower = 0.5 * (peak - fast) * (up / limits.acceleration + rise)
    return peak * seconds - slower - 0.5 * down * (down / limits.acceleration + rise)


@inner
def _motion_within(
    state: Floats, points: Floats, most: Floats, limits: Limits, speeds: tuple[float, float], reach: float
) -> tuple[Floats, Floats, Floats, float]:
    """Return a motion as `steered_motion` does, that ends `reach` metres after it has turned towards the way.

    `speeds` are the share of the largest speed that is used, and the speed towards the first point that is not
    exceeded. The last that is returned is the latter, lowered to what was possible.
    """
    n = len(points)
    passed = np.full(n, math.inf)
    durations, rows = np.empty(MOST_PIECES), np.zeros((MOST_PIECES, 4, 3))
    share, cap = speeds
    for _ in range(SLOWER_ROUNDS):
        m, position, velocity = _aim(durations, rows, state, points[0], (share, cap), limits)
        speed = length(velocity)
        if speed < LEAST_SPEED:
            break
        if m < 0:
            cap = SLOWER * speed
            continue
        ahead = velocity / speed
        corners, allowed = np.empty((n + 1, 3)), np.zeros(n + 1)
        put(corners, 0, position)
        put(corners, 1, position + dot(points[0] - position, ahead) * ahead)
        last, left, ends_before = 1, reach, False
        while True:  # the way's points, and where it ends
            leg = corners[last] - corners[last - 1]
            size = length(leg)
            if size <= MIN_SEGMENT:  # two points in one place
                return np.empty(0), np.empty((0, 4, 3)), passed, cap
            ends_before = size > left
            if ends_before:
                put(corners, last, corners[last - 1] + (left / size) * leg)
            if ends_before or last == n:
                break
            left -= size
            allowed[last] = most[last - 1]
            put(corners, last + 1, points[last])
            last += 1
        legs = legs_between(corners[: last + 1], limits)
        for k in range(last):
            legs.speeds[k] *= share
        corner_speeds = corner_speeds_from(legs, allowed[: last + 1], speed)
        if corner_speeds[0] < speed:
            cap = corner_speeds[0]
            continue
        more, others, parts = pieces_along(legs, corner_speeds)
        now = durations[:m].sum()
        for k in range(len(more)):
            now += more[k]
            if parts[k] % 2 == 0:
                passed[parts[k] // 2] = now
            else:  # the point is passed in the middle of its blend
                i = parts[k] // 2
                passed[i] = min(passed[i], now - more[k]) + 0.5 * more[k]
        if ends_before:
            passed[last - 1] = math.inf
        together, coefficients = np.empty(m + len(more)), np.empty((m + len(more), 4, 3))
        for k in range(m + len(more)):
            together[k] = durations[k] if k < m else more[k - m]
            for power in range(4):
                for axis in range(3):
                    row = rows[k, power, axis] if k < m else others[k - m, power, axis]
                    coefficients[k, power, axis] = row
        return together, coefficients, passed, cap
    return np.empty(0), np.empty((0, 4, 3)), passed, cap


@inner
def _aim(
    durations: Floats, rows: Floats, state: Floats, aim: Floats, speeds: tuple[float, float], limits: Limits
) -> tuple[int, Floats, Floats]:
    """Write the change of velocity after which a UAV flies towards a point; see `change_velocity`.

    The number of pieces is -1 where the point is passed before, or missed. `speeds` are the share of the largest speed
    that is used, and the speed that is not exceeded.
    """
    m, position, velocity = 0, state[0].copy(), state[1].copy()
    way = aim - position
    far = length(way)
    if far < LEAST_WAY:
        return -1, position, velocity
    way /= far
    for tried in range(AIM_ROUNDS):
        speed = min(speeds[0] * largest_speed(limits, way), speeds[1])
        m, position, velocity = change_velocity(durations, rows, state, speed * way, limits)
        ahead = aim - position
        far = length(ahead)
        if far < LEAST_WAY:
            return -1, position, speed * way
        ahead /= far
        turned = length(ahead - way)
        way = ahead
        if turned <= AIM_CONVERGED or (tried > FIRST_ROUNDS and turned > SLOW_TO_AIM):
            break
    size = max(length(velocity), LEAST_SPEED)
    along = dot(aim - position, velocity) / size
    if along < LEAST_WAY or length(aim - position - (along / size) * velocity) > AIM_OFF:
        return -1, position, velocity
    return m, position, velocity


@inner
def _arrival(
    durations: Floats, rows: Floats, points: Floats, passed: Floats, limits: Limits, looked_at: float
) -> float:
    """Return about how long a motion and the rest of its way take, seconds; see `steered_motion`."""
    total = durations.sum()
    if passed[len(points) - 1] <= max(looked_at, total):
        return total
    begin, k = 0.0, 0
    while k < len(durations) - 1 and begin + durations[k] < looked_at:
        begin += durations[k]
        k += 1
    local = min(looked_at - begin, durations[k])
    place, velocity = np.empty(3), np.empty(3)
    for axis in range(3):
        first, second, third = rows[k, 1, axis], rows[k, 2, axis], rows[k, 3, axis]
        place[axis] = rows[k, 0, axis] + local * (first + local * (second + local * third))
        velocity[axis] = first + local * (2.0 * second + 3.0 * local * third)
    i = 0
    while passed[i] <= looked_at:
        i += 1
    return looked_at + seconds_left(limits, place, velocity, points[i:])


@kernel
def seconds_left(limits: Limits, place: Floats, velocity: Floats, points: Floats) -> float:
    """Return about how many seconds a UAV takes from a place and a velocity, (3,) each, along points to rest there."""
    ahead = points[0] - place
    left = length(ahead)
    fast = dot(velocity, ahead) / left if left > 0.0 else 0.0
    for j in range(1, len(points)):
        left += length(points[j] - points[j - 1])
    return _seconds_to_rest(limits, left, fast)


@inner
def _seconds_to_rest(limits: Limits, left: float, fast: float) -> float:
    """Return about how long a UAV takes for the metres that are left, to rest, at a speed towards them of `fast`."""
    top, rate = limits.speed, limits.acceleration
    return left / top + (top - fast) ** 2 / (2.0 * rate * top) + 0.5 * top / rate + rate / limits.jerk
