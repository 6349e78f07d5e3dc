"""Straight legs, and blends at the corners between them, at the speeds that a multirotor's limits allow.

On a leg the velocity changes along the leg, in a blend from one leg's direction to that of the next at equal speed, and
both changes are ramps (see `ramp`): the acceleration keeps its direction, and the jerk is constant in each part. So all
pieces are cubic polynomials, and each limit, which keeps a vector in a convex set, is kept throughout a ramp if it is
kept at the largest acceleration and at both speeds.

With the speed v, the angle 2 h between the legs' directions and the duration T of the ramp, a blend begins and ends
``v T / 2`` before and after its corner. In the middle it is as far from the corner as the change of velocity has moved
the UAV by then, in the direction between the legs.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.trajectory import Form, Trajectory
from skyverse.model.uav import UAV
from skyverse.model.wind import STILL_AIR, WindBall
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.numerics.tolerances import LIMIT_MARGIN, MIN_CROSS_PRODUCT, MIN_PIECE, MIN_SEGMENT
from skyverse.trajectory.limits import Limits, limits_of
from skyverse.trajectory.ramp import (
    BISECTIONS,
    both_ramps,
    largest_acceleration,
    largest_speed,
    peak_speed,
    ramp_parts,
    ramp_seconds,
    ramp_way,
)

MAX_SWEEPS = 50
"""How often the corners' speeds are lowered, along all legs and back, until every leg is long enough for its ramps."""
PIECES = 10
"""Pieces at most of a leg and of the blend at its end."""


def without_repeats(waypoints: Floats) -> Floats:
    """Return waypoints (n, 3) without those that are no farther than `MIN_SEGMENT` from the one before, (k, 3)."""
    points = np.array(waypoints, dtype=np.float64)
    return points[np.r_[True, np.linalg.norm(np.diff(points, axis=0), axis=1) > MIN_SEGMENT]]


@by_reference
class Legs(NamedTuple):
    """Legs between n points, and what a multirotor's limits are along them.

    Attributes
    ----------
    points
        (n, 3) metres; no two in a row are equal.
    ways
        (n - 1, 3) unit vectors along the legs.
    lengths
        (n - 1,) metres.
    speeds
        (n - 1,) largest speeds, m/s.
    accelerations
        (n - 1, 2) largest accelerations forwards and backwards, m/s^2.
    turns
        (n, 3) unit vectors of the change of velocity at each point; zeros at the ends and where there is none.
    sharpness
        (n,) norms of the difference between the unit vectors of the legs after and before each point.
    turning
        (n,) largest accelerations along `turns`, m/s^2.
    jerk
        The largest jerk, m/s^3.
    """

    points: Floats
    ways: Floats
    lengths: Floats
    speeds: Floats
    accelerations: Floats
    turns: Floats
    sharpness: Floats
    turning: Floats
    jerk: float


@kernel
def legs_between(points: Floats, limits: Limits) -> Legs:
    """Return the legs between points (n, 3), n >= 2, metres, no two of which in a row are equal."""
    n = len(points)
    ways, lengths, speeds = np.empty((n - 1, 3)), np.empty(n - 1), np.empty(n - 1)
    accelerations = np.empty((n - 1, 2))
    for k in range(n - 1):
        way = points[k + 1] - points[k]
        lengths[k] = math.sqrt(way[0] ** 2 + way[1] ** 2 + way[2] ** 2)
        way /= lengths[k]
        speeds[k] = largest_speed(limits, way)
        accelerations[k, 0], accelerations[k, 1] = largest_acceleration(limits, way), largest_acceleration(limits, -way)
        for axis in range(3):
            ways[k, axis] = way[axis]
    turns, sharpness, turning = np.zeros((n, 3)), np.zeros(n), np.ones(n)
    for i in range(1, n - 1):
        turn = ways[i] - ways[i - 1]
        sharp = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
        if sharp > MIN_CROSS_PRODUCT:
            turn /= sharp
            sharpness[i], turning[i] = sharp, largest_acceleration(limits, turn)
            for axis in range(3):
                turns[i, axis] = turn[axis]
    return Legs(points, ways, lengths, speeds, accelerations, turns, sharpness, turning, limits.jerk)


@inner
def _reach(legs: Legs, i: int, speed: float) -> float:
    """Return how many metres before corner i its blend begins, at a speed."""
    return 0.5 * speed * ramp_seconds(speed * legs.sharpness[i], legs.turning[i], legs.jerk)


@inner
def _depth(legs: Legs, i: int, speed: float) -> float:
    """Return how many metres from corner i its blend is in the middle, at a speed."""
    change = speed * legs.sharpness[i]
    rise, hold = ramp_parts(change, legs.turning[i], legs.jerk)
    if rise == 0.0:
        return 0.0
    peak = change / (rise + hold)
    return peak * (rise * rise / 6.0 + rise * hold / 4.0 + hold * hold / 8.0)


@kernel
def blend_depths(legs: Legs, speeds: Floats) -> Floats:
    """Return the distances of all blends from their corners, (n,) metres, at speeds (n,), m/s."""
    depths = np.zeros(len(speeds))
    for i in range(1, len(speeds) - 1):
        depths[i] = _depth(legs, i, speeds[i])
    return depths


@inner
def _needed(legs: Legs, k: int, first: float, last: float) -> float:
    """Return the metres that leg k must have at least, at the speeds at its ends."""
    at_ends = _reach(legs, k, first) + _reach(legs, k + 1, last)
    rate = legs.accelerations[k, 0 if last > first else 1]
    return at_ends + ramp_way(first, last, rate, legs.jerk)


@kernel
def corner_speeds(legs: Legs, most: Floats) -> Floats:
    """Return the largest speeds at the points, (n,) m/s, that legs and corners allow; 0 at both ends.

    Parameters
    ----------
    legs
        The legs.
    most
        (n,) the largest distance of each blend from its corner, metres; 0 to stop there.
    """
    return corner_speeds_from(legs, most, 0.0)


@inner
def corner_speeds_from(legs: Legs, most: Floats, begin: float) -> Floats:
    """Return the largest speeds at the points as `corner_speeds` does, but `begin`, or less, at the first of them."""
    n = len(legs.points)
    speeds = np.zeros(n)
    speeds[0] = begin
    for i in range(1, n - 1):
        if most[i] <= 0.0:
            continue
        low, high = 0.0, min(legs.speeds[i - 1], legs.speeds[i])
        if _depth(legs, i, high) <= most[i]:
            speeds[i] = high
            continue
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            if _depth(legs, i, middle) <= most[i]:
                low = middle
            else:
                high = middle
        speeds[i] = low
    for _ in range(MAX_SWEEPS):
        changed = False
        for turn in range(2 * (n - 1)):
            k = turn if turn < n - 1 else 2 * (n - 1) - 1 - turn
            if _needed(legs, k, speeds[k], speeds[k + 1]) > legs.lengths[k]:
                _slow_down(legs, k, speeds)
                changed = True
        if not changed:
            return speeds
    speeds[:] = 0.0
    return speeds


@inner
def _slow_down(legs: Legs, k: int, speeds: Floats) -> None:
    """Lower the larger of the speeds at both ends of leg k, or both, until the leg is long enough."""
    slower = min(speeds[k], speeds[k + 1])
    both = _needed(legs, k, slower, slower) > legs.lengths[k]
    low, high = (0.0, slower) if both else (slower, max(speeds[k], speeds[k + 1]))
    first, last = both or speeds[k] > speeds[k + 1], both or speeds[k + 1] > speeds[k]
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if _needed(legs, k, middle if first else slower, middle if last else slower) <= legs.lengths[k]:
            low = middle
        else:
            high = middle
    speeds[k], speeds[k + 1] = low if first else slower, low if last else slower


@kernel
def pieces_along(legs: Legs, speeds: Floats) -> tuple[Floats, Floats, Ints]:
    """Return the pieces of the motion along legs, with blends at the corners at given speeds (n,), m/s.

    Returns
    -------
    durations
        (m,) seconds.
    coefficients
        (m, 4, 3) metres, by powers of the time since the piece began.
    parts
        (m,) what each piece is part of: 2 k for leg k, and 2 i - 1 for the blend at point i.
    """
    count = len(legs.lengths)
    durations, rows = np.empty(count * PIECES), np.zeros((count * PIECES, 4, 3))
    parts = np.empty(count * PIECES, np.int64)
    m = 0
    for k in range(count):
        way, length = legs.ways[k], legs.lengths[k]
        first, last = speeds[k], speeds[k + 1]
        begin, end = _reach(legs, k, first), length - _reach(legs, k + 1, last)
        rates = (legs.accelerations[k, 0], legs.accelerations[k, 1], legs.jerk)
        peak = peak_speed(end - begin, (first, last), legs.speeds[k], rates)
        up, down = ramp_way(first, peak, rates[0], rates[2]), ramp_way(peak, last, rates[1], rates[2])
        begun = m
        point = legs.points[k] + begin * way
        m = add_ramp(durations, rows, m, (point, first * way, way), peak - first, (rates[0], rates[2]))
        cruise = max(end - begin - both_ramps((first, last), peak, rates), 0.0) / max(peak, MIN_CROSS_PRODUCT)
        point = legs.points[k] + (begin + up) * way
        m = add_piece(durations, rows, m, cruise, (point, peak * way, 0.0 * way, 0.0 * way))
        point = legs.points[k + 1] - (length - end + down) * way
        m = add_ramp(durations, rows, m, (point, peak * way, -way), peak - last, (rates[1], rates[2]))
        parts[begun:m] = 2 * k
        if last > 0.0:
            begun = m
            point = legs.points[k + 1] - (length - end) * way
            motion = (point, last * way, legs.turns[k + 1])
            rates_of_turn = (legs.turning[k + 1], legs.jerk)
            m = add_ramp(durations, rows, m, motion, last * legs.sharpness[k + 1], rates_of_turn)
            parts[begun:m] = 2 * k + 1
    return durations[:m].copy(), rows[:m].copy(), parts[:m].copy()


@inner
def add_ramp(
    durations: Floats,
    rows: Floats,
    m: int,
    motion: tuple[Floats, Floats, Floats],
    change: float,
    rates: tuple[float, float],
) -> int:
    """Add the parts of a ramp from a position and a velocity on, in a direction; return how many pieces there are."""
    rise, hold = ramp_parts(change, rates[0], rates[1])
    if rise == 0.0:
        return m
    point, velocity, way = motion
    peak = change / (rise + hold)
    jerk = peak / rise
    m = add_piece(durations, rows, m, rise, (point, velocity, 0.0 * way, jerk * way))
    point = point + rise * velocity + (jerk * rise**3 / 6.0) * way
    velocity = velocity + (0.5 * peak * rise) * way
    m = add_piece(durations, rows, m, hold, (point, velocity, peak * way, 0.0 * way))
    point = point + hold * velocity + (0.5 * peak * hold * hold) * way
    velocity = velocity + (peak * hold) * way
    return add_piece(durations, rows, m, rise, (point, velocity, peak * way, -jerk * way))


@inner
def add_piece(
    durations: Floats, rows: Floats, m: int, seconds: float, motion: tuple[Floats, Floats, Floats, Floats]
) -> int:
    """Add a piece by its first position, velocity, acceleration, and its jerk, unless it is too short."""
    if seconds <= MIN_PIECE:
        return m
    durations[m] = seconds
    for axis in range(3):
        rows[m, 0, axis], rows[m, 1, axis] = motion[0][axis], motion[1][axis]
        rows[m, 2, axis], rows[m, 3, axis] = 0.5 * motion[2][axis], motion[3][axis] / 6.0
    return m + 1


def least_seconds(waypoints: Floats, uav: UAV, winds: WindBall = STILL_AIR) -> float:
    """Return the seconds that straight legs between waypoints (n, 3) would take if no bend slowed the UAV down."""
    points = without_repeats(waypoints)
    legs = legs_between(points, limits_of(uav, -LIMIT_MARGIN, winds))
    legs = legs._replace(sharpness=np.zeros(len(points)))
    return float(pieces_along(legs, corner_speeds(legs, np.ones(len(points))))[0].sum())


def trajectory_along(legs: Legs, speeds: Floats, form: Form) -> Trajectory:
    """Return the trajectory along legs, from 0 s on, with blends at the corners at given speeds (n,), m/s."""
    durations, rows, _ = pieces_along(legs, speeds)
    return Trajectory(np.r_[0.0, np.cumsum(durations)], rows, form)
