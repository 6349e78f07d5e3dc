"""Interior-point method for a spline through a corridor: least time, and little jerk or snap, within limits.

Variables are the control points of a quartic spline and the durations of the corridor's boxes. The objective is the
time plus ``weight * integral of |jerk or snap|^2``. Barriers keep the control points of the position inside their
boxes, those of velocity, acceleration and jerk inside balls, thrust inside a ball around another centre, tilt inside a
cone, and vertical speed between its limits; in a wind, velocity also inside a ball around that of the air. A spline
lies within the hull of its control points, so every iterate keeps to corridor and limits at every instant.

Each round solves Newton's equations for all variables at once; see `newton_equations` and `newton_step`.
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.model.uav import GRAVITY
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import MIN_NORM, MIN_STEP_SHARE
from skyverse.trajectory.limits import Limits
from skyverse.trajectory.newton_equations import FIXED, SplineProblem, assemble
from skyverse.trajectory.newton_step import BAND, NewtonSystem, solve_newton_system
from skyverse.trajectory.spline import time_of

BARRIERS_OF_POINT = 9.0
"""Barriers for each control point, about: six faces of its bounds and three limits."""
FIRST_BARRIER_SHARE = 0.3
"""What all barriers may cost at first, as a share of the time."""
BARRIER_FACTOR = 0.25
"""The factor by which the weight of the barriers falls when a minimum is nearly reached."""
NEARLY_CENTRED = 2.0
"""That is when the decrement falls below this, in units of the barriers' weight times the root of their number."""
MAX_LOG_STEP = 0.5
"""The largest change of the logarithm of a duration in one step."""
ARMIJO = 0.01
"""The share of the promised decrease that a step must achieve."""
BACKTRACKING = 0.6
"""The factor by which a step that does not is shortened."""
LARGE_PRODUCT = 1e100
"""A product of slacks outside 1 / this and this is replaced by its logarithm before it overflows."""


@kernel
def improve(problem: SplineProblem, spans: Floats, points: Floats, rounds: int, gap: float) -> int:
    """Improve in place a spline that keeps all constraints, and return the number of rounds.

    Parameters
    ----------
    problem
        Constraints and objective.
    spans
        (S,) durations in seconds, equal within a box.
    points
        (N, 3) control points, N = S + 4, metres.
    rounds
        At most.
    gap
        The method ends when the barriers cost no more than about this share of the time.
    """
    boxes = problem.box_of[-1] + 1
    free = 3 * (len(points) - 2 * FIXED)
    system = NewtonSystem(
        np.empty((free, BAND)), np.empty(free), np.empty((boxes, free)), np.empty((boxes, boxes)), np.empty(boxes)
    )
    work, jets, other = np.empty((2, 5, 5, 6)), np.empty((6, 6)), np.empty((6, 6))
    barriers = BARRIERS_OF_POINT * len(points)
    mu = FIRST_BARRIER_SHARE * spans.sum() / barriers
    here = objective(problem, spans, points, mu)
    for done in range(rounds):
        assemble(problem, spans, points, mu, system, work, jets, other)
        decrement = solve_newton_system(system)
        share = 1.0
        for b in range(boxes):
            share = min(share, MAX_LOG_STEP / max(abs(system.by_durations[b]), MIN_NORM))
        moved = False
        while share > MIN_STEP_SHARE:
            longer, further = spans.copy(), points.copy()
            for k in range(len(spans)):
                longer[k] *= np.exp(share * system.by_durations[problem.box_of[k]])
            for j in range(free):
                further[FIXED + j // 3, j % 3] += share * system.by_points[j]
            there = objective(problem, longer, further, mu)
            if there < here - ARMIJO * share * decrement:
                spans[:], points[:] = longer, further
                moved = True
                break
            share *= BACKTRACKING
        if not moved or decrement < NEARLY_CENTRED * mu * np.sqrt(barriers):
            if mu * barriers < gap * spans.sum():
                return done + 1
            mu *= BARRIER_FACTOR
        here = objective(problem, spans, points, mu)
    return rounds


@kernel
def objective(problem: SplineProblem, spans: Floats, points: Floats, mu: float) -> float:
    """Return the objective with its barriers; infinite where a constraint is broken."""
    n = len(points)
    total = 0.0
    product = 1.0
    for i in range(FIXED, n - FIXED):
        for a in range(3):
            below, above = points[i, a] - problem.low[i, a], problem.high[i, a] - points[i, a]
            if not (below > 0.0 and above > 0.0):
                return np.inf
            product *= below * above
        if not 1.0 / LARGE_PRODUCT < product < LARGE_PRODUCT:
            total -= np.log(product)
            product = 1.0
    energy = 0.0
    control = points
    for order in range(1, problem.order + 1):
        control = _derivative(control, spans, order)
        if order < 4:
            for i in range(len(control)):
                slack = _slack(problem.limits, order, control[i, 0], control[i, 1], control[i, 2])
                if not slack > 0.0:
                    return np.inf
                product *= slack
                if not 1.0 / LARGE_PRODUCT < product < LARGE_PRODUCT:
                    total -= np.log(product)
                    product = 1.0
    for k in range(len(spans)):
        for a in range(3):
            if problem.order == 4:
                energy += spans[k] * control[k, a] ** 2
            else:
                x, y = control[k, a], control[k + 1, a]
                energy += spans[k] / 3.0 * (x * x + x * y + y * y)
    return spans.sum() + problem.weight * energy + mu * (total - np.log(product))


@inner
def _derivative(control: Floats, spans: Floats, order: int) -> Floats:
    """Return the control points of the derivative of an order from those of the derivative before it; see `spline`."""
    m = len(control) - 1
    lower = np.empty((m, 3))
    for i in range(m):
        per = (5 - order) / time_of(spans, i - 4 + order, i)
        for a in range(3):
            lower[i, a] = per * (control[i + 1, a] - control[i, a])
    return lower


@inner
def _slack(limits: Limits, order: int, x: float, y: float, z: float) -> float:
    """Return the product of a control point's slacks towards its limits; not positive where one is exceeded."""
    level = x * x + y * y
    if order == 1:
        slack = 1.0 - (level + z * z) / limits.speed**2
        for used in (z / limits.ascent, -z / limits.descent):
            if not used < 1.0:
                return -1.0
            slack *= 1.0 - used
        if limits.through_air < np.inf:
            off = (x - limits.east) ** 2 + (y - limits.north) ** 2 + (z - limits.up) ** 2
            more = 1.0 - off / limits.through_air**2
            if not (more > 0.0 and slack > 0.0):
                return -1.0
            slack *= more
        return slack
    if order == 3:
        return 1.0 - (level + z * z) / limits.jerk**2
    slack = 1.0 - (level + z * z) / limits.acceleration**2
    up = z + GRAVITY
    if limits.thrust < np.inf:
        more = 1.0 - (level + up * up) / limits.thrust**2
        if not (more > 0.0 and slack > 0.0):
            return -1.0
        slack *= more
    if limits.tilt < np.inf:
        up = z + limits.fall  # less than gravity, so that thrust never points down
        more = (limits.tilt * up) ** 2 - level
        if not (more > 0.0 and up > 0.0 and slack > 0.0):
            return -1.0
        slack *= more
    return slack
