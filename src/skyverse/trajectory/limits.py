"""How much of its UAV's limits a trajectory uses, bounded at every instant.

The limits on speed, acceleration, jerk, thrust, tilt, vertical speed and, in a wind, speed through the air each keep a
vector inside a convex set about the zero vector. The factor by which the set must be scaled to reach the vector (its
gauge) is a convex function of the vector, so over a piece of a trajectory it is nowhere larger than at the piece's
Bernstein coefficients. Halving the piece tightens this bound. The limits of an aeroplane's airspeed, turn and climb are
polynomials instead, which must not exceed 1.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.uav import GRAVITY, UAV
from skyverse.model.wind import WindBall, refuse_wind
from skyverse.numerics.arrays import put
from skyverse.numerics.bernstein import product, split
from skyverse.numerics.kernel import by_reference, inner

MIN_LIFT = 0.01
"""The share of its weight that a multirotor's thrust always carries: without thrust its tilt would be undefined."""
MAX_DEPTH = 40
"""How often a piece is halved at most, each time one of the halves again."""
MAX_HALVINGS = 20_000
"""How often a piece and its parts are halved at most, in all."""
AIRSPEED_SHARE = 0.01
"""The share of its airspeed by which an aeroplane's horizontal speed may differ from it."""

SPEED, ACCELERATION, JERK, THRUST, TILT, VERTICAL_SPEED, THROUGH_AIR, AIRSPEED, TURN, CLIMB = range(10)
DERIVATIVE = (1, 2, 3, 2, 2, 1, 1)
"""Which derivative of the position each of the first seven limits bounds."""


@by_reference
class Limits(NamedTuple):
    """A UAV's limits in SI units.

    Attributes
    ----------
    speed, acceleration, jerk
        The largest norms, m/s, m/s^2, m/s^3.
    thrust
        The largest thrust of a multirotor per kilogram, m/s^2.
    tilt
        The tangent of the largest angle between a multirotor's thrust and the vertical.
    fall
        The largest acceleration downwards of a multirotor, m/s^2.
    airspeed
        An aeroplane's horizontal speed, m/s; 0 for a multirotor.
    turn_radius
        An aeroplane's least turn radius seen from above, metres.
    climb
        The tangent of an aeroplane's steepest climb.
    ascent, descent
        The largest speeds upwards and downwards, m/s; infinite where there is no such limit.
    east, north, up
        The velocity of the wind, m/s.
    through_air
        How far a multirotor's velocity may be from that of the wind, m/s, whatever gusts blow; infinite where its speed
        keeps it within that anyway.
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
    ascent: float
    descent: float
    east: float
    north: float
    up: float
    through_air: float


def limits_of(uav: UAV, tolerance: float, winds: WindBall) -> Limits:
    """Return the limits of a UAV in winds, all but an aeroplane's airspeed eased by a relative tolerance.

    Velocities that keep the airspeed in all of these winds are a ball about that in the middle. It holds 0, or the UAV
    could not hold its place, which is refused. So whatever is flown may also be flown more slowly.

    Raises
    ------
    InputError
        If the UAV cannot fly in these winds.
    """
    refuse_wind(uav, winds)
    more = 1.0 + tolerance
    wing = uav.fixed_wing
    implied = wing is not None or winds.strongest + uav.max_speed <= uav.airspeed
    east, north, up = winds.velocity
    return Limits(
        speed=uav.max_speed * more,
        acceleration=uav.max_acceleration * more,
        jerk=uav.max_jerk * more,
        thrust=uav.thrust_to_weight * GRAVITY * more,
        tilt=math.tan(math.radians(uav.max_tilt)) * more,
        fall=(1.0 - MIN_LIFT) * GRAVITY * more,
        airspeed=wing.speed if wing else 0.0,
        turn_radius=wing.turn_radius / more if wing else 0.0,
        climb=math.tan(math.radians(wing.climb)) * more if wing else 0.0,
        ascent=math.inf if uav.max_climb is None else uav.max_climb * more,
        descent=math.inf if uav.max_descent is None else uav.max_descent * more,
        east=east,
        north=north,
        up=up,
        through_air=math.inf if implied else (uav.airspeed - winds.radius) * more,
    )


@inner
def applies(limits: Limits, limit: int) -> bool:
    """Tell whether a limit applies.

    Those on speed and acceleration always do, those on vertical speed and speed through the air where there are such,
    and the others to multirotors or to aeroplanes only.
    """
    if limit == THROUGH_AIR:
        return limits.through_air < math.inf
    if limit == VERTICAL_SPEED:
        return min(limits.ascent, limits.descent) < math.inf
    return limit <= ACCELERATION or (limit >= AIRSPEED) == (limits.airspeed > 0.0)


@inner
def derivative(rows: Floats) -> Floats:
    """Return the power-basis coefficients (max(n, 1), 3) of the derivative of a polynomial with (n + 1, 3)."""
    less = np.zeros((max(len(rows) - 1, 1), rows.shape[1]))
    for i in range(1, len(rows)):
        for column in range(rows.shape[1]):
            less[i - 1, column] = i * rows[i, column]
    return less


@inner
def peak(limits: Limits, limit: int, b: Floats, floor: float, tight: float) -> tuple[float, float, float]:
    """Enclose the largest share of one limit that a piece uses.

    Parameters
    ----------
    b
        Bernstein coefficients of the derivative that is limited, (n + 1, 3), or those from `aeroplane_demand`.
    floor
        Shares below this are not enclosed any closer.
    tight
        How closely to enclose larger shares, relatively.

    Returns
    -------
    tuple
        An upper bound of the largest share (or `floor`, where that is more); a lower bound; and where in the piece, as
        a share of it, the lower bound is reached.
    """
    whole = b.copy().reshape(-1)
    lower, last, hull = _shares(limits, limit, whole)
    where = 0.0
    if last > lower:
        lower, where = last, 1.0
    if hull <= max(floor, lower * (1.0 + tight)):
        return hull, lower, where
    pieces = np.empty((MAX_DEPTH + 1, b.size))  # a stack of parts that are not decided, the earliest on top
    begin, hulls, level = np.zeros(MAX_DEPTH + 1), np.empty(MAX_DEPTH + 1), np.zeros(MAX_DEPTH + 1, np.int64)
    put(pieces, 0, whole)
    hulls[0] = hull
    waiting, halvings, upper = 1, 0, lower
    while waiting:
        top = waiting - 1
        if hulls[top] <= max(floor, lower * (1.0 + tight)) or level[top] == MAX_DEPTH or halvings == MAX_HALVINGS:
            upper = max(upper, hulls[top])
            waiting -= 1
            continue
        halvings += 1
        split(pieces[top], pieces[waiting], 3)
        level[top] += 1
        begin[waiting], level[waiting] = begin[top], level[top]
        begin[top] += 0.5 ** level[top]
        middle, _, hulls[top] = _shares(limits, limit, pieces[top])
        _, _, hulls[waiting] = _shares(limits, limit, pieces[waiting])
        if middle > lower:
            lower, where = middle, begin[top]
        waiting += 1
    return upper, lower, where


@inner
def _shares(limits: Limits, limit: int, b: Floats) -> tuple[float, float, float]:
    """Return how much of a limit is used at both ends of a piece, and the most at any of its coefficients."""
    first = used_share(limits, limit, b[0], b[1], b[2])
    last, most = first, first
    for i in range(3, len(b), 3):
        last = used_share(limits, limit, b[i], b[i + 1], b[i + 2])
        most = max(most, last)
    return first, last, most


@inner
def used_share(limits: Limits, limit: int, x: float, y: float, z: float) -> float:
    """Return which share of a limit a vector uses, a convex function of the vector; 1 is all of the limit.

    For thrust and tilt the vector is the acceleration a. Its share s is such that the acceleration a / s, and gravity
    with it, would take all of the thrust, or all of the tilt.
    """
    if limit >= AIRSPEED:
        return max(x, y, z)
    if limit == TILT:
        return max((math.sqrt(x * x + y * y) / limits.tilt - z) / GRAVITY, -z / limits.fall)
    if limit == VERTICAL_SPEED:
        return max(z / limits.ascent, -z / limits.descent)
    squared = x * x + y * y + z * z
    if limit == THROUGH_AIR:
        return _share_of_ball(limits, x, y, z)
    if limit == THRUST:
        spare = limits.thrust**2 - GRAVITY**2
        return (z * GRAVITY + math.sqrt((z * GRAVITY) ** 2 + squared * spare)) / spare
    if limit == SPEED:
        return math.sqrt(squared) / limits.speed
    if limit == ACCELERATION:
        return math.sqrt(squared) / limits.acceleration
    return math.sqrt(squared) / limits.jerk


@inner
def _share_of_ball(limits: Limits, x: float, y: float, z: float) -> float:
    """Return which share of a ball about the wind, which holds 0, a velocity uses: 0 without a limit.

    It is the larger root s of ``|v / s - w|^2 = A^2``, with the wind w and the radius A.
    """
    if limits.through_air == math.inf:
        return 0.0
    strength = math.sqrt(limits.east**2 + limits.north**2 + limits.up**2)
    spare = (limits.through_air - strength) * (limits.through_air + strength)
    against = -(x * limits.east + y * limits.north + z * limits.up)
    squared = x * x + y * y + z * z
    root = math.sqrt(against**2 + squared * spare)
    if against >= 0.0:
        return (against + root) / spare
    return squared / (root - against)  # the same, without a difference of large numbers


@inner
def aeroplane_demand(limits: Limits, limit: int, velocity: Floats, acceleration: Floats) -> Floats:
    """Return Bernstein coefficients, (m, 3), of polynomials that do not exceed 1 while an aeroplane keeps a limit.

    With the airspeed V, the steepest climb's tangent c and the least turn radius R, an aeroplane keeps its

    - airspeed while ``(0.99 V)^2 <= vx^2 + vy^2 <= (1.01 V)^2``,
    - turn while ``(vx ay - vy ax)^2 R^2 <= (vx^2 + vy^2)^3``,
    - climb while ``vz^2 <= c^2 (vx^2 + vy^2)``.

    Parameters
    ----------
    limits, limit
        `AIRSPEED`, `TURN` or `CLIMB` of an aeroplane's limits.
    velocity, acceleration
        Their Bernstein coefficients over a piece, (n, 3) each.
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
            columns[k, 0] = level[k] / (1.0 + AIRSPEED_SHARE) ** 2
            columns[k, 1] = 2.0 - level[k] / (1.0 - AIRSPEED_SHARE) ** 2
        return columns
    ax, ay = acceleration[:, 0].copy(), acceleration[:, 1].copy()
    turn = limits.turn_radius / limits.airspeed**3
    across = _sum(product(vx, ay), turn, product(vy, ax), -turn)
    cube = product(product(level, level), level)
    bend = product(across, across)
    bend = product(bend, np.ones(len(cube) - len(bend) + 1))  # times 1: raised to the same degree
    return _column(_sum(bend, 1.0, cube, -1.0))


@inner
def _sum(a: Floats, of_a: float, b: Floats, of_b: float) -> Floats:
    """Return ``of_a a + of_b b``."""
    total = np.empty(len(a))
    for k in range(len(a)):
        total[k] = of_a * a[k] + of_b * b[k]
    return total


@inner
def _column(less: Floats) -> Floats:
    """Return 1 and a polynomial in the first of three columns."""
    columns = np.zeros((len(less), 3))
    for k in range(len(less)):
        columns[k, 0] = 1.0 + less[k]
    return columns
