"""The planners' own proof of a trajectory before they hand it out: it is clear and within limits at every instant.

A piece lies inside the box around its Bernstein coefficients, and no farther from its chord than they do. Where that
box exceeds the bounds or touches an obstacle that is a box, or where an obstacle of another shape comes that near to
the chord, the piece is halved, until all parts are clear or an instant is found at which the trajectory is not. Half of
what the referee tolerates is tolerated here, three quarters where it is the clearance, which leaves the rest for
rounding.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Verdict
from skyverse.numerics.arrays import put
from skyverse.numerics.bernstein import split, to_bernstein
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import LIMIT_EASE, LIMIT_MARGIN, PROOF_EASE, PROOF_TIGHTNESS
from skyverse.space import box
from skyverse.space.obstacles import Space, boxes_near, shapes_crossed, shapes_hold, shapes_reach
from skyverse.space.speed_zones import first_too_fast
from skyverse.space.world import World
from skyverse.trajectory.limits import (
    AIRSPEED,
    CLIMB,
    DERIVATIVE,
    MAX_DEPTH,
    MAX_HALVINGS,
    Limits,
    aeroplane_demand,
    applies,
    derivative,
    limits_of,
    peak,
)

_USABLE = 1.0 - LIMIT_MARGIN
"""The share of the eased limits that may be used."""

DEMANDS = (
    "speed",
    "acceleration",
    "jerk",
    "thrust",
    "tilt",
    "vertical speed",
    "speed through the air",
    "airspeed",
    "turn",
    "climb",
    "bounds",
    "clearance",
    "speed in a zone",
)
_BOUNDS, _CLEARANCE, _ZONE_SPEED = 10, 11, 12
_VERDICTS = (Verdict.PROVEN, Verdict.REFUTED, Verdict.UNDECIDED)
_PROVEN, _REFUTED, _UNDECIDED = range(3)


class Proof(NamedTuple):
    """Whether a trajectory meets all demands at every instant.

    Attributes
    ----------
    verdict
        Proven, refuted or undecided.
    what
        The demand that is not met or not decided, one of `DEMANDS`; empty when all are proven.
    instant
        When it is not met or not decided, seconds.
    """

    verdict: Verdict
    what: str
    instant: float | None


def prove(world: World, uav: UAV, trajectory: Trajectory) -> Proof:
    """Prove that a trajectory is clear, in bounds and within its UAV's limits at every instant, or say what is not.

    Whether it is continuous, and at rest at its ends, is not examined.
    """
    code, what, instant = _prove(
        world.space,
        limits_of(uav, LIMIT_EASE, world.scenario.winds),
        trajectory.knots.copy(),
        trajectory.coefficients.copy(),
    )
    verdict = _VERDICTS[code]
    if verdict is not Verdict.PROVEN:
        return Proof(verdict, DEMANDS[what], instant)
    too_fast = first_too_fast(world.speed_zones, trajectory)
    return Proof(verdict, "", None) if too_fast is None else Proof(Verdict.UNDECIDED, DEMANDS[_ZONE_SPEED], too_fast)


@kernel
def _prove(space: Space, limits: Limits, knots: Floats, coefficients: Floats) -> tuple[int, int, float]:
    """Judge a trajectory: verdict, demand and instant as in `Proof`."""
    doubt = (_PROVEN, 0, 0.0)
    for k in range(len(coefficients)):
        duration = knots[k + 1] - knots[k]
        rows = coefficients[k]
        code, what, where = _clear(space, to_bernstein(rows, duration))
        if code == _REFUTED:
            return code, what, knots[k] + where * duration
        if code == _UNDECIDED:
            doubt = (code, what, knots[k] + where * duration)
        velocity = derivative(rows)
        acceleration, jerk = derivative(velocity), derivative(derivative(velocity))
        rates = (to_bernstein(velocity, duration), to_bernstein(acceleration, duration), to_bernstein(jerk, duration))
        for limit in range(CLIMB + 1):
            if not applies(limits, limit):
                continue
            b = (
                aeroplane_demand(limits, limit, rates[0], rates[1])
                if limit >= AIRSPEED
                else rates[DERIVATIVE[limit] - 1]
            )
            upper, lower, where = peak(limits, limit, b, _USABLE, PROOF_TIGHTNESS)
            if lower > _USABLE:
                return _REFUTED, limit, knots[k] + where * duration
            if not upper <= _USABLE:
                doubt = (_UNDECIDED, limit, knots[k] + where * duration)
    return doubt


@kernel
def clear_pieces(space: Space, durations: Floats, coefficients: Floats) -> Bools:
    """Tell which pieces (m, degree + 1, 3) of a curve, of (m,) seconds each, are proven clear and in bounds, (m,)."""
    clear = np.empty(len(durations), np.bool_)
    for k in range(len(durations)):
        clear[k] = _clear(space, to_bernstein(coefficients[k], durations[k]))[0] == _PROVEN
    return clear


@inner
def _clear(space: Space, b: Floats) -> tuple[int, int, float]:
    """Judge whether a piece is clear: verdict, demand, and the share of the piece where it fails."""
    pieces = np.empty((MAX_DEPTH + 1, b.size))  # a stack of parts that are not decided, the earliest on top
    put(pieces, 0, b.copy().reshape(-1))
    low, high = np.empty(3), np.empty(3)
    _enclose(pieces[0], low, high)
    near = boxes_near(space, -PROOF_EASE, low, high)
    for share in range(2):
        what = _fault(space, near, b[share * (len(b) - 1)])
        if what:
            return _REFUTED, what, float(share)
    begin, level = np.zeros(MAX_DEPTH + 1), np.zeros(MAX_DEPTH + 1, np.int64)
    count = np.full(MAX_DEPTH + 1, len(near))  # so many boxes, the first ones, are near what it is half of
    waiting, cuts = 1, 0
    while waiting:
        top = waiting - 1
        _enclose(pieces[top], low, high)
        inside = True
        for axis in range(3):
            inside &= space.low[axis] - LIMIT_EASE <= low[axis] and high[axis] <= space.high[axis] + LIMIT_EASE
        count[top] = _keep(space, near, count[top], low, high)
        if inside and count[top] == 0 and _clear_of_shapes(space, pieces[top], low, high):
            waiting -= 1
            continue
        if level[top] == MAX_DEPTH or cuts == MAX_HALVINGS:
            return _UNDECIDED, _BOUNDS if not inside else _CLEARANCE, begin[top]
        cuts += 1
        split(pieces[top], pieces[waiting], 3)
        level[top] += 1
        begin[waiting], level[waiting], count[waiting] = begin[top], level[top], count[top]
        begin[top] += 0.5 ** level[top]
        what = _fault(space, near[: count[top]], pieces[top])
        if what:
            return _REFUTED, what, begin[top]
        waiting += 1
    return _PROVEN, 0, 0.0


@inner
def _enclose(b: Floats, low: Floats, high: Floats) -> None:
    """Write the corners of the box around coefficients, rows of 3 laid end to end."""
    for axis in range(3):
        low[axis] = high[axis] = b[axis]
        for i in range(axis + 3, len(b), 3):
            low[axis] = min(low[axis], b[i])
            high[axis] = max(high[axis], b[i])


@inner
def _clear_of_shapes(space: Space, b: Floats, low: Floats, high: Floats) -> bool:
    """Tell whether a piece is clear of the ground and of all shapes but boxes.

    Its coefficients are laid end to end, and lie in the box between two corners.
    """
    return not shapes_reach(space, -PROOF_EASE, low, high) or not shapes_crossed(
        space, -PROOF_EASE, _off_chord(b), b[:3], b[len(b) - 3 :]
    )


@inner
def _off_chord(b: Floats) -> float:
    """Return the greatest distance of coefficients, laid end to end, from the segment between the first and last."""
    n = len(b) - 3
    squared = 0.0
    for axis in range(3):
        squared += (b[n + axis] - b[axis]) ** 2
    most = 0.0
    for i in range(3, n, 3):
        along = 0.0
        for axis in range(3):
            along += (b[i + axis] - b[axis]) * (b[n + axis] - b[axis])
        share = min(max(along / squared, 0.0), 1.0) if squared > 0.0 else 0.0
        off = 0.0
        for axis in range(3):
            off += (b[i + axis] - b[axis] - share * (b[n + axis] - b[axis])) ** 2
        most = max(most, off)
    return math.sqrt(most)


@inner
def _keep(space: Space, near: Ints, count: int, low: Floats, high: Floats) -> int:
    """Move those of the first `count` boxes to the front that are near the box between two corners; return how many."""
    kept = 0
    for i in range(count):
        if box.touches(space.boxes, near[i], space.clearance - PROOF_EASE, low, high):
            near[i], near[kept] = near[kept], near[i]
            kept += 1
    return kept


@inner
def _fault(space: Space, near: Ints, p: Floats) -> int:
    """Return which demand a position does not meet, given the boxes near it, or 0 where it meets all."""
    for axis in range(3):
        if not space.low[axis] - LIMIT_EASE <= p[axis] <= space.high[axis] + LIMIT_EASE:
            return _BOUNDS
    for i in near:
        if box.holds(space.boxes, i, space.clearance - PROOF_EASE, p[0], p[1], p[2]):
            return _CLEARANCE
    return _CLEARANCE if shapes_hold(space, -PROOF_EASE, p) else 0
