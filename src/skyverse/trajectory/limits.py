"""How much of its UAV's limits a trajectory uses, bounded at every instant.

Speed, acceleration, jerk, thrust and tilt each keep a vector inside a convex set around 0. The factor by which the set
must be scaled to reach the vector (its gauge) is a convex function, so over a piece it is nowhere larger than at the
piece's Bernstein coefficients. Halving the piece tightens this. What an aeroplane must keep is a polynomial instead.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.arrays import put
from skyverse.numerics.bernstein import product, split, to_bernstein
from skyverse.numerics.kernel import inner, kernel

GRAVITY = 9.81
LIFT = 0.01
"""The share of its weight that a multirotor's thrust carries at least: without thrust there is no tilt to speak of."""
DEPTH = 40
"""How often a piece is cut in two at most, one half within the other."""
MOST = 20_000
"""How often a piece is cut in two at most, in all."""
_TIGHT = 1e-5
"""A peak is enclosed this closely, relatively."""
_ROOM = 1e-9

SPEED, ACCELERATION, JERK, THRUST, TILT, AIRSPEED, TURN, CLIMB = range(8)
ORDER = (1, 2, 3, 2, 2)
"""Which derivative of the position each of the first five limits."""


class Limits(NamedTuple):
    """A UAV's limits in SI units: `thrust` per mass, `tilt` and `climb` as tangents; `airspeed` 0 for a multirotor.

    `fall` is what it may accelerate downwards.
    """

    speed: float
    acceleration: float
    jerk: float
    thrust: float
    tilt: float
    fall: float
    airspeed: float
    turn_radius: float
    climb: float


def limits_of(uav: UAV, tolerance: float = 0.0) -> Limits:
    """Return what a UAV must keep, all limits but the airspeed eased by a relative tolerance."""
    more = 1.0 + tolerance
    wing = uav.fixed_wing
    return Limits(
        speed=uav.max_speed * more,
        acceleration=uav.max_acceleration * more,
        jerk=uav.max_jerk * more,
        thrust=uav.thrust_to_weight * GRAVITY * more,
        tilt=math.tan(math.radians(uav.max_tilt)) * more,
        fall=(1.0 - LIFT) * GRAVITY * more,
        airspeed=wing.speed if wing else 0.0,
        turn_radius=wing.turn_radius / more if wing else 0.0,
        climb=math.tan(math.radians(wing.climb)) * more if wing else 0.0,
    )


def stretch(uav: UAV, trajectory: Trajectory) -> float:
    """Return the factor on all durations at which the trajectory just keeps the UAV's limits.

    The least such factor is at most 1e-5, relatively, smaller. Below 1 it could go faster; 0 says that it does not
    move. Of an aeroplane only speed and acceleration are looked at, as its airspeed is given.
    """
    return float(peaks(limits_of(uav), trajectory.knots.copy(), trajectory.coefficients.copy()).max()) * (1.0 + _ROOM)


@kernel
def peaks(limits: Limits, knots: Floats, coefficients: Floats) -> Floats:
    """Return how much longer a trajectory must take for each of the five limits, (5,) factors; 0 where none applies.

    Upper bounds, tight to 1e-5: of speed the peak's share of the limit, of acceleration, thrust and tilt its square
    root, of jerk its cube root.
    """
    greatest = np.zeros(5)
    for k in range(len(coefficients)):
        duration = knots[k + 1] - knots[k]
        rows = coefficients[k]
        for order in range(1, 4):
            rows = rate(rows)
            b = to_bernstein(rows, duration)
            for limit in range(5):
                if ORDER[limit] == order and applies(limits, limit):
                    upper, _, _, _ = peak(limits, limit, b, greatest[limit], _TIGHT)
                    greatest[limit] = max(greatest[limit], upper)
    for limit in range(5):
        greatest[limit] = greatest[limit] ** (1.0 / ORDER[limit])
    return greatest


@inner
def applies(limits: Limits, limit: int) -> bool:
    """Tell whether a UAV has this limit: speed and acceleration, then a multirotor's or an aeroplane's."""
    return limit <= ACCELERATION or (limit >= AIRSPEED) == (limits.airspeed > 0.0)


@inner
def rate(rows: Floats) -> Floats:
    """Return the power-basis coefficients (max(n, 1), 3) of the rate of change of (n + 1, 3)."""
    less = np.zeros((max(len(rows) - 1, 1), rows.shape[1]))
    for i in range(1, len(rows)):
        for column in range(rows.shape[1]):
            less[i - 1, column] = i * rows[i, column]
    return less


@inner
def peak(limits: Limits, limit: int, b: Floats, floor: float, tight: float) -> tuple[float, float, float, int]:
    """Enclose the largest share of one limit that a piece uses.

    Parameters
    ----------
    b
        Bernstein coefficients of the derivative that is limited, (n + 1, 3), or of an aeroplane's `demand`.
    floor
        Smaller shares are of no interest.
    tight
        How closely to enclose larger ones, relatively.

    Returns
    -------
    tuple
        The largest share is at most the first (or `floor`), at least the second, reached at the third, a share of the
        piece; and how often it was cut in two.
    """
    whole = b.copy().reshape(-1)
    lower, last, hull = _shares(limits, limit, whole)
    where = 0.0
    if last > lower:
        lower, where = last, 1.0
    if hull <= max(floor, lower * (1.0 + tight)):
        return hull, lower, where, 0
    pieces = np.empty((DEPTH + 1, b.size))  # waiting to be looked at, the earliest on top
    begin, hulls, level = np.zeros(DEPTH + 1), np.empty(DEPTH + 1), np.zeros(DEPTH + 1, np.int64)
    put(pieces, 0, whole)
    hulls[0] = hull
    waiting, cuts, upper = 1, 0, lower
    while waiting:
        top = waiting - 1
        if hulls[top] <= max(floor, lower * (1.0 + tight)) or level[top] == DEPTH or cuts == MOST:
            upper = max(upper, hulls[top])
            waiting -= 1
            continue
        cuts += 1
        split(pieces[top], pieces[waiting], 3)
        level[top] += 1
        begin[waiting], level[waiting] = begin[top], level[top]
        begin[top] += 0.5 ** level[top]
        middle, _, hulls[top] = _shares(limits, limit, pieces[top])
        _, _, hulls[waiting] = _shares(limits, limit, pieces[waiting])
        if middle > lower:
            lower, where = middle, begin[top]
        waiting += 1
    return upper, lower, where, cuts


@inner
def _shares(limits: Limits, limit: int, b: Floats) -> tuple[float, float, float]:
    """Return the shares at both ends of a piece, and the largest at its coefficients."""
    first = share(limits, limit, b[0], b[1], b[2])
    last, most = first, first
    for i in range(3, len(b), 3):
        last = share(limits, limit, b[i], b[i + 1], b[i + 2])
        most = max(most, last)
    return first, last, most


@inner
def share(limits: Limits, limit: int, x: float, y: float, z: float) -> float:
    """Return how much of a limit a vector uses; 1 is all. It is a convex function of the vector.

    Thrust and tilt are told of the acceleration: it may grow by one over its share until gravity and it together take
    all the thrust, or all the tilt.
    """
    if limit >= AIRSPEED:
        return max(x, y, z)
    if limit == TILT:
        return max((math.sqrt(x * x + y * y) / limits.tilt - z) / GRAVITY, -z / limits.fall)
    squared = x * x + y * y + z * z
    if limit == THRUST:
        room = limits.thrust**2 - GRAVITY**2
        return (z * GRAVITY + math.sqrt((z * GRAVITY) ** 2 + squared * room)) / room
    if limit == SPEED:
        return math.sqrt(squared) / limits.speed
    if limit == ACCELERATION:
        return math.sqrt(squared) / limits.acceleration
    return math.sqrt(squared) / limits.jerk


@inner
def demand(limits: Limits, limit: int, velocity: Floats, acceleration: Floats) -> Floats:
    """Return Bernstein coefficients, (m, 3), none of which is above 1 while an aeroplane keeps a limit.

    They are made of those of velocity and acceleration, (n, 3). The turn is kept while
    ``(vx ay - vy ax)^2 R^2 <= (vx^2 + vy^2)^3``.
    """
    vx, vy, vz = velocity[:, 0].copy(), velocity[:, 1].copy(), velocity[:, 2].copy()
    level = _sum(product(vx, vx), 1.0, product(vy, vy), 1.0)
    for k in range(len(level)):
        level[k] /= limits.airspeed**2
    if limit == CLIMB:
        steep = product(vz, vz)
        return _column(_sum(steep, 1.0 / (limits.climb * limits.airspeed) ** 2, level, -1.0))
    if limit == AIRSPEED:
        columns = np.zeros((len(level), 3))
        for k in range(len(level)):
            columns[k, 0], columns[k, 1] = level[k] / 1.01**2, 2.0 - level[k] / 0.99**2
        return columns
    ax, ay = acceleration[:, 0].copy(), acceleration[:, 1].copy()
    turn = limits.turn_radius / limits.airspeed**3
    across = _sum(product(vx, ay), turn, product(vy, ax), -turn)
    pace = product(product(level, level), level)
    bend = product(across, across)
    bend = product(bend, np.ones(len(pace) - len(bend) + 1))  # times one: of the same degree
    return _column(_sum(bend, 1.0, pace, -1.0))


@inner
def _sum(a: Floats, of_a: float, b: Floats, of_b: float) -> Floats:
    total = np.empty(len(a))
    for k in range(len(a)):
        total[k] = of_a * a[k] + of_b * b[k]
    return total


@inner
def _column(less: Floats) -> Floats:
    columns = np.zeros((len(less), 3))
    for k in range(len(less)):
        columns[k, 0] = 1.0 + less[k]
    return columns
