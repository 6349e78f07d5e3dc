"""Paths of straight legs: price, judge, keep. What searches over waypoints in continuous space share."""

import math
from typing import NamedTuple

import numpy as np

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.cost import Rates
from skyverse.model.result import Effort, History, Provenance, Result, no_history
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.base import Run, make_desk, planned_any_angle, unplanned
from skyverse.planners.moves import EVALUATIONS, NODES, PATHS, Desk
from skyverse.problem import Problem
from skyverse.space import ground, solids
from skyverse.space.world import Space, point_free, segment_free, without_seams
from skyverse.stop import Stop

_SAMPLES = 32
"""Places of a leg at which it is asked whether it is inside something other than a box."""


class Course(NamedTuple):
    """What is sought: a way from start to goal, (3,) metres each, through a space, at these rates.

    Attributes
    ----------
    collision
        The price of a metre inside an obstacle.
    """

    space: Space
    rates: Rates
    start: Floats
    goal: Floats
    collision: float


class Polylines(NamedTuple):
    """Candidate paths: ``points[i, :length[i]]``, metres, costs ``cost[i]``."""

    points: Floats
    length: Ints
    cost: Floats


def polylines(count: int, capacity: int) -> Polylines:
    """Return room for so many polylines, none of which is there yet."""
    return Polylines(np.empty((count, capacity, 3)), np.zeros(count, np.int64), np.full(count, math.inf))


def open_run(
    problem: Problem,
    stop: Stop,
    rng: np.random.Generator,
    origin: Provenance,
    room: int,
    joints: int,
    collision: float,
) -> Run | Result:
    """Return a run with room for so many polylines and joints, or the result where there is nothing to search."""
    if problem.any_angle_refusal is not None:
        return unplanned(problem, problem.any_angle_refusal, origin)
    if np.array_equal(problem.start, problem.end):
        path = problem.start[None]
        return planned_any_angle(problem, path, 0.0, Effort(), 0.0, no_history(), "finished", origin)
    space = problem.airspace.world.space
    closed = without_seams(space)  # unless an end touches an obstacle, from which no leg could lead away then
    if point_free(closed, problem.start) and point_free(closed, problem.end):
        space = closed
    course = Course(space, problem.airspace.rates, problem.start, problem.end, float(collision))
    return Run(course, make_desk(stop), polylines(room, joints + 2), polylines(1, joints + 2), rng)


def close_run(
    problem: Problem, run: Run, effort: Effort, seconds: float, history: History, stopped_by: str, origin: Provenance
) -> Result:
    """Return the result of the archived best."""
    path = run.best.points[0, : run.best.length[0]].copy()
    return planned_any_angle(problem, path, least_price(problem), effort, seconds, history, stopped_by, origin)


def least_price(problem: Problem) -> float:
    """Return what every path costs at least: the straight line, and one turn where that is not safe."""
    rates = problem.airspace.rates
    straight = segment_free(problem.airspace.world.space, problem.start, problem.end)
    return rates.metre * math.dist(problem.start, problem.end) + rates.turn * (not straight)


@kernel
def judge_legs(course: Course, desk: Desk, best: Polylines, path: Floats) -> float:
    """Return the fitness of a path (n, 3) to the goal: its price, and that of the metres inside obstacles.

    What is archived, if it is cheaper than the best, is the path up to the first leg that is not safe.
    """
    desk.spent[PATHS] += 1
    desk.spent[NODES] += len(path) - 1
    desk.spent[EVALUATIONS] += 1
    free = len(path)
    metres = 0.0
    for i in range(1, len(path)):
        if not segment_free(course.space, path[i - 1], path[i]):
            free = min(free, i)
            metres += _metres_inside(course.space, path[i - 1], path[i])
    price = cost.legs(course.rates, path, course.goal).sum()
    fitness = price + course.collision * metres
    if free < len(path):
        price = cost.legs(course.rates, path[:free], course.goal).sum()
    if price < best.cost[0]:
        for i in range(free):
            best.points[0, i] = path[i]
        best.length[0] = free
        best.cost[0] = price
    return fitness


@inner
def _metres_inside(space: Space, a: Floats, b: Floats) -> float:
    """Return the metres of a segment inside each grown box, added up; and, about, those inside anything else."""
    total = _share_in_shapes(space, a, b)
    for i in range(len(space.boxes)):
        enter, leave = 0.0, 1.0
        for axis in range(3):
            low, high = space.boxes[i, axis] - space.clearance, space.boxes[i, axis + 3] + space.clearance
            step = b[axis] - a[axis]
            if step == 0.0:
                if not low < a[axis] < high:
                    leave = -1.0
            else:
                one, other = (low - a[axis]) / step, (high - a[axis]) / step
                enter, leave = max(enter, min(one, other)), min(leave, max(one, other))
        total += max(0.0, leave - enter)
    return total * math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)


@inner
def _share_in_shapes(space: Space, a: Floats, b: Floats) -> float:
    """Return the share of a segment, about, that lies inside obstacles other than boxes; not 0 if any does."""
    if len(space.solids.kind) == 0 and space.ground.heights.size == 0:
        return 0.0
    inside = 0
    p = np.empty(3)
    for k in range(_SAMPLES):
        for axis in range(3):
            p[axis] = a[axis] + (k + 0.5) / _SAMPLES * (b[axis] - a[axis])
        floor = ground.height(space.ground, p[0], p[1]) + space.clearance + space.ground.extra
        inside += p[2] < floor or solids.containing(space.solids, space.clearance, p[0], p[1], p[2]) >= 0
    return max(inside, 0.5) / _SAMPLES
