"""Smooth and fast: the spline of least time, and of least jerk or snap, through a corridor, within limits.

Time and shape are found together by an interior-point method. Its variables are the control points of a quartic spline
and the durations of the corridor's boxes; its objective T + weight * integral |jerk or snap|^2; its barriers keep
the control points of position inside their boxes, and those of velocity, acceleration and jerk inside balls (thrust: a
ball around another centre; tilt: a cone). A spline lies within the hull of its control points, so every iterate keeps
to corridor and limits at every instant: the answer may be taken whenever time is up.

Each round solves Newton's equations for all variables at once. Points hang on their neighbours only, and durations
border them: a banded Cholesky factorisation, and a small dense Schur complement.
"""

import math

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.kernel import inner, kernel, writable
from skyverse.space.world import World, only_boxes
from skyverse.trajectory.corridor import grow_corridor
from skyverse.trajectory.equations import FIXED, Task, assemble
from skyverse.trajectory.limits import GRAVITY, Limits, limits_of
from skyverse.trajectory.newton import BAND, System, solve
from skyverse.trajectory.pieces import pieces_of
from skyverse.trajectory.room import with_room
from skyverse.trajectory.spline import DEGREE, refine

STANDSTILL = 1e-6
"""Metres of way below which there is nothing to fly."""


WEIGHT = 0.1
"""What jerk or snap may cost: of the time, for a trajectory that uses half of its limit all the time."""
REACH = 10.0
"""Metres that the corridor's boxes may reach beyond their stretches of the path."""
CLOSE = 0.5
"""The same where the path should be kept to; no stretch then turns aside by more."""
NEAR = 0.005
"""The same as a share of the path's length, where that is more and there are other shapes than boxes."""
ROOMS = (2.0, 0.5, 8.0, 25.0, 0.1)
"""Metres by which a path is drawn off such shapes, one after the other, until its corridor has few boxes."""
MANY = 40
"""So many are few ..."""
TOO_MANY = 120
"""... and more than so many take seconds: then it stops at bends instead."""
SPANS = 6
"""Of a box at first."""
FINE = 0.08
"""Seconds that a span lasts in the end, about ..."""
MOST = 300
"""... unless there are more than so many of them."""


def smooth(world: World, waypoints: Floats, uav: UAV, order: int, *, close: bool = False) -> Trajectory | None:
    """Fly along a free path without stopping: as fast as limits and corridor allow, and with little jerk or snap.

    Parameters
    ----------
    world
        Where to fly.
    waypoints
        (n, 3) metres, n >= 2: a path whose straight legs are free.
    uav
        A multirotor: its limits on speed, acceleration, jerk, thrust and tilt are kept.
    order
        3 to keep the integral of squared jerk small, 4 that of snap.
    close
        Whether it keeps to the path, within a metre along each axis, or may cut corners.

    Returns
    -------
    Trajectory or None
        Quartic pieces, three times continuously differentiable, at rest at both ends; ``None`` where the path leads
        through a passage too narrow to turn it into a corridor.
    """
    path = writable(waypoints)
    if len(path) < 2 or float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) < STANDSTILL:
        return None
    boxes = _corridor(world, path, close)
    if not len(boxes):
        return None
    origin = path[0].copy()  # far from zero, derivatives would drown in rounding
    path, boxes = path - origin, boxes - np.tile(origin, 2)
    limits = _binding(uav)
    points, spans, done = _through(boxes, path, limits, order)
    if not done:
        return None
    knots, rows = pieces_of(points, spans)
    rows[:, 0] += origin
    return Trajectory(knots, rows, "smooth")


def _corridor(world: World, path: Floats, close: bool) -> Floats:
    """Return free boxes (m, 6) along a path; along one that is drawn off what it touches, where they would be many."""
    if only_boxes(world.space):
        return grow_corridor(world.space, path, *((CLOSE, CLOSE) if close else (REACH, math.inf)))
    near = max(CLOSE, NEAR * float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()))
    size = (near, near) if close else (REACH, math.inf)
    ways = [path, *(with_room(world, path, room) for room in ROOMS if not close or room <= near)]
    for most in (MANY, TOO_MANY):
        for way in ways:
            boxes = path[:0] if way is None else grow_corridor(world.space, way, *size, most)
            if len(boxes):
                return boxes
    return path[:0]


def _binding(uav: UAV) -> Limits:
    """Return a multirotor's limits; thrust and tilt only where the limit on acceleration does not imply them."""
    limits = limits_of(uav, -1e-9)
    a = limits.acceleration
    most_tilt = math.inf if a >= GRAVITY else a / math.sqrt(GRAVITY**2 - a**2)
    return limits._replace(
        thrust=limits.thrust if GRAVITY + a > limits.thrust else math.inf,
        tilt=limits.tilt if most_tilt > limits.tilt else math.inf,
    )


def _through(boxes: Floats, path: Floats, limits: Limits, order: int) -> tuple[Floats, Floats, bool]:
    """Return control points and spans' durations of a good spline, and whether there is one."""
    box_of = np.repeat(np.arange(len(boxes)), SPANS)
    weight = weight_of(limits, order)
    low, high = rooms(boxes, box_of)
    points, spans = first_guess(path, low, high, box_of)
    task = Task(low, high, box_of, limits, weight, order)
    for _ in range(200):
        if value(task, spans, points, 1.0) < np.inf:
            break
        spans *= 1.3
    else:
        return points, spans, False
    improve(task, spans, points, 40, 0.1)
    parts = np.ceil(spans / max(FINE, spans.sum() / MOST)).astype(np.int64)
    points, finer = refine(points, spans, parts)
    box_of = np.repeat(box_of, parts)
    low, high = rooms(boxes, box_of)
    task = Task(low, high, box_of, limits, weight, order)
    improve(task, finer, points, 40, 0.03)
    return points, finer, True


def weight_of(limits: Limits, order: int) -> float:
    """Return the weight of the integral of squared jerk, or snap: per what half the limits make."""
    half = 0.5 * limits.jerk
    if order == 4:
        hardest = min(limits.acceleration, limits.thrust - GRAVITY, limits.tilt * GRAVITY)
        half *= limits.jerk / hardest
    return WEIGHT / half**2


@kernel
def rooms(boxes: Floats, box_of: Ints) -> tuple[Floats, Floats]:
    """Return the corners (N, 3) of where each control point may be: in the boxes of all spans that it rules."""
    n = len(box_of) + DEGREE
    low, high = np.full((n, 3), -np.inf), np.full((n, 3), np.inf)
    for k in range(len(box_of)):
        for i in range(k, k + DEGREE + 1):
            for a in range(3):
                low[i, a] = max(low[i, a], boxes[box_of[k], a])
                high[i, a] = min(high[i, a], boxes[box_of[k], a + 3])
    return low, high


def first_guess(path: Floats, low: Floats, high: Floats, box_of: Ints) -> tuple[Floats, Floats]:
    """Return control points strictly inside their rooms, and durations that are the same for all.

    Where boxes overlap the points stand together, near the path but off the walls; between, they go straight.
    """
    n, s = len(low), len(box_of)
    passes = np.flatnonzero(np.diff(box_of)) + 1  # the first of the control points that stand in two boxes
    there = [_nearest_inside(path, low[k], high[k]) for k in passes]
    stops = np.r_[FIXED - 1, np.ravel(np.column_stack([passes, passes + DEGREE - 1])), s]
    at = np.vstack([path[:1], np.repeat(np.reshape(there, (-1, 3)), 2, axis=0), path[-1:]])
    points = np.column_stack([np.interp(np.arange(n), stops, at[:, a]) for a in range(3)])
    free = slice(FIXED, n - FIXED)
    room = np.minimum(0.45 * (high - low)[free], 0.02)
    points[free] = np.clip(points[free], low[free] + room, high[free] - room)
    return points, np.full(s, 0.1)


def _nearest_inside(path: Floats, low: Floats, high: Floats) -> Floats:
    """Return the point of a box, off its walls, that is nearest to a path, about."""
    shares = np.linspace(0.0, 1.0, 21)[:, None, None]
    on_path = ((1.0 - shares) * path[:-1] + shares * path[1:]).reshape(-1, 3)
    room = np.minimum(0.45 * (high - low), 0.3)
    inside = np.clip(on_path, low + room, high - room)
    nearest: Floats = inside[np.argmin(np.sum((inside - on_path) ** 2, axis=1))]
    return nearest


@kernel
def improve(task: Task, spans: Floats, points: Floats, rounds: int, least: float) -> int:
    """Improve in place a spline that keeps to everything; return the rounds that it took.

    Parameters
    ----------
    task
        What to keep to.
    spans
        (S,) durations in seconds, equal within a box.
    points
        (N, 3) control points, N = S + 4, metres.
    rounds
        At most.
    least
        Done when the barriers can cost no more than about this share of the time.
    """
    boxes = task.box_of[-1] + 1
    free = 3 * (len(points) - 2 * FIXED)
    system = System(
        np.empty((free, BAND)), np.empty(free), np.empty((boxes, free)), np.empty((boxes, boxes)), np.empty(boxes)
    )
    work, jets, other = np.empty((2, 5, 5, 6)), np.empty((6, 6)), np.empty((6, 6))
    barriers = 9.0 * len(points)
    mu = 0.3 * spans.sum() / barriers
    here = value(task, spans, points, mu)
    for done in range(rounds):
        assemble(task, spans, points, mu, system, work, jets, other)
        promise = solve(system)
        share = 1.0
        for b in range(boxes):
            share = min(share, 0.5 / max(abs(system.slope[b]), 1e-12))
        moved = False
        while share > 1e-5:
            longer, further = spans.copy(), points.copy()
            for k in range(len(spans)):
                longer[k] *= np.exp(share * system.slope[task.box_of[k]])
            for j in range(free):
                further[FIXED + j // 3, j % 3] += share * system.rise[j]
            there = value(task, longer, further, mu)
            if there < here - 0.01 * share * promise:
                _copy(longer, further, spans, points)
                moved = True
                break
            share *= 0.6
        if not moved or promise < 2.0 * mu * np.sqrt(barriers):
            if mu * barriers < least * spans.sum():
                return done + 1
            mu *= 0.25
        here = value(task, spans, points, mu)
    return rounds


@kernel
def value(task: Task, spans: Floats, points: Floats, mu: float) -> float:
    """Return objective and barriers; infinite outside."""
    n = len(points)
    total = 0.0
    product = 1.0
    for i in range(FIXED, n - FIXED):
        for a in range(3):
            below, above = points[i, a] - task.low[i, a], task.high[i, a] - points[i, a]
            if not (below > 0.0 and above > 0.0):
                return np.inf
            product *= below * above
        if not 1e-100 < product < 1e100:
            total -= np.log(product)
            product = 1.0
    energy = 0.0
    control = points
    for order in range(1, task.order + 1):
        control = _derivative(control, spans, order)
        if order < 4:
            for i in range(len(control)):
                slack = _slack(task.limits, order, control[i, 0], control[i, 1], control[i, 2])
                if not slack > 0.0:
                    return np.inf
                product *= slack
                if not 1e-100 < product < 1e100:
                    total -= np.log(product)
                    product = 1.0
    for k in range(len(spans)):
        for a in range(3):
            if task.order == 4:
                energy += spans[k] * control[k, a] ** 2
            else:
                x, y = control[k, a], control[k + 1, a]
                energy += spans[k] / 3.0 * (x * x + x * y + y * y)
    return spans.sum() + task.weight * energy + mu * (total - np.log(product))


@inner
def _copy(spans: Floats, points: Floats, to_spans: Floats, to_points: Floats) -> None:
    for k in range(len(spans)):
        to_spans[k] = spans[k]
    for i in range(len(points)):
        for a in range(3):
            to_points[i, a] = points[i, a]


@inner
def _derivative(control: Floats, spans: Floats, order: int) -> Floats:
    """Return the control points of the derivative `order` from those of the one above."""
    m = len(control) - 1
    lower = np.empty((m, 3))
    back = 4 - order
    for i in range(m):
        time = 0.0
        for k in range(max(i - back, 0), min(i, len(spans) - 1) + 1):
            time += spans[k]
        per = (5 - order) / time
        for a in range(3):
            lower[i, a] = per * (control[i + 1, a] - control[i, a])
    return lower


@inner
def _slack(limits: Limits, order: int, x: float, y: float, z: float) -> float:
    """Return the product of how far below its limits a control point of a derivative is; not positive outside."""
    level = x * x + y * y
    if order == 1:
        return 1.0 - (level + z * z) / limits.speed**2
    if order == 3:
        return 1.0 - (level + z * z) / limits.jerk**2
    slack = 1.0 - (level + z * z) / limits.acceleration**2
    up = z + GRAVITY
    if limits.thrust < np.inf:
        room = 1.0 - (level + up * up) / limits.thrust**2
        if not (room > 0.0 and slack > 0.0):
            return -1.0
        slack *= room
    if limits.tilt < np.inf:
        up = z + limits.fall  # a hair less than it is: thrust never points down
        room = (limits.tilt * up) ** 2 - level
        if not (room > 0.0 and up > 0.0 and slack > 0.0):
            return -1.0
        slack *= room
    return slack
