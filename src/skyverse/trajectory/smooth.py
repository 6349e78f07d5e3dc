"""Smooth trajectories of multirotors through a corridor: splines of little time and little jerk or snap, within limits.

The path is wrapped into a corridor of free boxes, and a quartic spline is laid through it (see `interior_point`): first
with few spans in each box, then, once these have their durations, with spans of about `SPAN_SECONDS`.
"""

import math

import numpy as np
from scipy.interpolate import BSpline

from skyverse._typing import Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import GRAVITY, UAV
from skyverse.model.wind import STILL_AIR, WindBall
from skyverse.numerics.kernel import kernel, writable
from skyverse.numerics.tolerances import JERK_JUMP, LIMIT_MARGIN, MIN_PATH
from skyverse.space.obstacles import only_boxes
from skyverse.space.world import World
from skyverse.trajectory.corridor import grow_corridor, inset_path
from skyverse.trajectory.interior_point import improve, objective
from skyverse.trajectory.limits import Limits, limits_of
from skyverse.trajectory.newton_equations import FIXED, SplineProblem
from skyverse.trajectory.spline import DEGREE, refine, time_of

ENERGY_SHARE = 0.1
"""Jerk or snap counts as much as this share of the time, for a trajectory that always uses half of its jerk limit."""
REACH = 10.0
"""Metres that the corridor's boxes may extend beyond their stretches of the path."""
CLOSE_REACH = 0.5
"""The same where the trajectory keeps close to the path; no stretch then turns aside by more."""
CLOSE_SHARE = 0.005
"""The same as a share of the path's length, where that is more and there are other shapes than boxes."""
INSETS = (2.0, 0.5, 8.0, 25.0, 0.1)
"""Metres by which a path is moved away from such shapes, tried in turn until its corridor has few boxes."""
FEW_BOXES = 40
"""Boxes of a corridor that is taken at once."""
MANY_BOXES = 120
"""Boxes at most: a spline through more would take seconds, and the UAV stops at bends instead."""
SPANS_OF_BOX = 6
"""Spans of each box at first: so many that no span's row of coefficients depends on three boxes."""
SPAN_SECONDS = 0.08
"""Seconds that a span lasts in the end, about, unless there would be more than `MAX_SPANS` of them."""
MAX_SPANS = 300
STRETCH = 1.3
"""The factor by which all durations grow until the first guess keeps the limits."""
MAX_STRETCHES = 200
MAX_ROUNDS = 40
"""Newton steps at most, with few spans and with many."""
COARSE_GAP, FINE_GAP = 0.1, 0.03
"""The share of the time that the barriers may still cost in the end, with few spans and with many."""


def smooth(world: World, waypoints: Floats, uav: UAV, order: int, *, close: bool = False) -> Trajectory | None:
    """Fly along a free path without stopping, as fast as limits and corridor allow, with little jerk or snap.

    Parameters
    ----------
    world
        With the obstacles.
    waypoints
        (n, 3) metres, n >= 2: a path of straight legs that are free.
    uav
        A multirotor: its limits on speed, acceleration, jerk, thrust and tilt are kept.
    order
        3 to keep the integral of squared jerk small, 4 that of snap.
    close
        Whether the trajectory keeps to the path, within a metre along each axis, or may cut corners.

    Returns
    -------
    Trajectory or None
        Quartic pieces, three times continuously differentiable, at rest at both ends; ``None`` where the path leads
        through a passage that is too narrow for a corridor.
    """
    path = writable(waypoints)
    if len(path) < 2 or float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) < MIN_PATH:
        return None
    boxes = _corridor(world, path, close)
    if not len(boxes):
        return None
    origin = path[0].copy()  # far from 0, derivatives would be lost in rounding
    path, boxes = path - origin, boxes - np.tile(origin, 2)
    limits = binding_limits(uav, world.scenario.winds)
    points, spans, done = _spline_through(boxes, path, limits, order)
    if not done:
        return None
    knots, rows = polynomial_pieces(points, spans)
    rows[:, 0] += origin
    return Trajectory(knots, rows, "smooth")


def _corridor(world: World, path: Floats, close: bool) -> Floats:
    """Return free boxes (m, 6) along a path, or along one that is moved away from obstacles where that takes fewer."""
    if only_boxes(world.space):
        return grow_corridor(world.space, path, *((CLOSE_REACH, CLOSE_REACH) if close else (REACH, math.inf)))
    near = max(CLOSE_REACH, CLOSE_SHARE * float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()))
    size = (near, near) if close else (REACH, math.inf)
    paths = [path, *(inset_path(world, path, inset) for inset in INSETS if not close or inset <= near)]
    for most in (FEW_BOXES, MANY_BOXES):
        for tried in paths:
            boxes = path[:0] if tried is None else grow_corridor(world.space, tried, *size, most)
            if len(boxes):
                return boxes
    return path[:0]


def binding_limits(uav: UAV, winds: WindBall = STILL_AIR) -> Limits:
    """Return a multirotor's limits; thrust and tilt are infinite where the limit on acceleration implies them."""
    limits = limits_of(uav, -LIMIT_MARGIN, winds)
    a = limits.acceleration
    most_tilt = math.inf if a >= GRAVITY else a / math.sqrt(GRAVITY**2 - a**2)
    return limits._replace(
        thrust=limits.thrust if GRAVITY + a > limits.thrust else math.inf,
        tilt=limits.tilt if most_tilt > limits.tilt else math.inf,
    )


def _spline_through(boxes: Floats, path: Floats, limits: Limits, order: int) -> tuple[Floats, Floats, bool]:
    """Return the control points and durations of a spline through a corridor, and whether one was found."""
    box_of = np.repeat(np.arange(len(boxes)), SPANS_OF_BOX)
    weight = energy_weight(limits, order)
    low, high = control_point_bounds(boxes, box_of)
    points, spans = first_guess(path, low, high, box_of)
    problem = SplineProblem(low, high, box_of, limits, weight, order)
    for _ in range(MAX_STRETCHES):
        if objective(problem, spans, points, 1.0) < np.inf:
            break
        spans *= STRETCH
    else:
        return points, spans, False
    improve(problem, spans, points, MAX_ROUNDS, COARSE_GAP)
    parts = np.ceil(spans / max(SPAN_SECONDS, spans.sum() / MAX_SPANS)).astype(np.int64)
    points, finer = refine(points, spans, parts)
    box_of = np.repeat(box_of, parts)
    low, high = control_point_bounds(boxes, box_of)
    problem = SplineProblem(low, high, box_of, limits, weight, order)
    improve(problem, finer, points, MAX_ROUNDS, FINE_GAP)
    return points, finer, True


def energy_weight(limits: Limits, order: int) -> float:
    """Return the weight of the integral of squared jerk (order 3) or snap (order 4); see `ENERGY_SHARE`."""
    half = 0.5 * limits.jerk
    if order == 4:
        hardest = min(limits.acceleration, limits.thrust - GRAVITY, limits.tilt * GRAVITY)
        half *= limits.jerk / hardest
    return ENERGY_SHARE / half**2


def polynomial_pieces(points: Floats, spans: Floats) -> tuple[Floats, Floats]:
    """Return the knots (S + 1,) of a spline, seconds, and the coefficients (S, 5, 3) of its pieces.

    A piece is a polynomial of the time since its first knot.

    Parameters
    ----------
    points
        (S + 4, 3) control points.
    spans
        (S,) seconds.
    """
    knots = np.r_[0.0, np.cumsum(spans)]
    lasting = np.diff(knots)[:, None]
    spline = BSpline(np.r_[[0.0] * DEGREE, knots, [knots[-1]] * DEGREE], points, DEGREE)
    rows = np.stack([spline(knots[:-1], nu=j) / math.factorial(j) for j in range(DEGREE + 1)], axis=1)
    jumps = 6.0 * (rows[:-1, 3] + 4.0 * lasting[:-1] * rows[:-1, 4] - rows[1:, 3])
    if np.any(np.abs(jumps) > JERK_JUMP):  # far from 0, in short spans: share one jerk at each knot
        jerk = points
        for k in range(1, DEGREE):
            times = np.array([time_of(spans, i - DEGREE + k, i) for i in range(len(jerk) - 1)])
            jerk = (DEGREE + 1 - k) * np.diff(jerk, axis=0) / times[:, None]
        rows[:, 3], rows[:, 4] = jerk[:-1] / 6.0, np.diff(jerk, axis=0) / lasting / 24.0
    return knots, rows


FACE_SHARE = 0.45
"""The share of a box's width that a point keeps from either face at most."""
FACE_MARGIN = 0.02
"""Metres that a point keeps from either face otherwise."""
OVERLAP_MARGIN = 0.3
"""The same where two boxes overlap."""
LEG_SAMPLES = 21
"""Points of each leg of the path that are compared."""
FIRST_DURATION = 0.1
"""Seconds of each span."""


@kernel
def control_point_bounds(boxes: Floats, box_of: Ints) -> tuple[Floats, Floats]:
    """Return low and high bounds (N, 3) of each control point: it lies in the boxes of all spans that it influences."""
    n = len(box_of) + DEGREE
    low, high = np.full((n, 3), -np.inf), np.full((n, 3), np.inf)
    for k in range(len(box_of)):
        for i in range(k, k + DEGREE + 1):
            for a in range(3):
                low[i, a] = max(low[i, a], boxes[box_of[k], a])
                high[i, a] = min(high[i, a], boxes[box_of[k], a + 3])
    return low, high


def first_guess(path: Floats, low: Floats, high: Floats, box_of: Ints) -> tuple[Floats, Floats]:
    """Return control points strictly within their bounds, (N, 3) metres, and equal durations (S,) of the spans.

    Where two boxes overlap the points coincide, near the path but away from the faces; in between they are spaced
    evenly on a straight line.
    """
    n, s = len(low), len(box_of)
    passes = np.flatnonzero(np.diff(box_of)) + 1  # the first of the control points that lie in two boxes
    within = [_nearest_inside(path, low[k], high[k]) for k in passes]
    stops = np.r_[FIXED - 1, np.ravel(np.column_stack([passes, passes + DEGREE - 1])), s]
    at = np.vstack([path[:1], np.repeat(np.reshape(within, (-1, 3)), 2, axis=0), path[-1:]])
    points = np.column_stack([np.interp(np.arange(n), stops, at[:, a]) for a in range(3)])
    free = slice(FIXED, n - FIXED)
    margin = np.minimum(FACE_SHARE * (high - low)[free], FACE_MARGIN)
    points[free] = np.clip(points[free], low[free] + margin, high[free] - margin)
    return points, np.full(s, FIRST_DURATION)


def _nearest_inside(path: Floats, low: Floats, high: Floats) -> Floats:
    """Return a point of a box, away from its faces, that is about the nearest to a path."""
    shares = np.linspace(0.0, 1.0, LEG_SAMPLES)[:, None, None]
    on_path = ((1.0 - shares) * path[:-1] + shares * path[1:]).reshape(-1, 3)
    margin = np.minimum(FACE_SHARE * (high - low), OVERLAP_MARGIN)
    inside = np.clip(on_path, low + margin, high - margin)
    return inside[np.argmin(np.sum((inside - on_path) ** 2, axis=1))]
