"""Paths of straight legs off the lattice: their task, their run, their price."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.cost import Rates
from skyverse.model.result import Provenance, Result
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.planners.metaheuristic import Run, make_workspace
from skyverse.planners.moves import EVALUATIONS, NODES, PATHS, Workspace, note_best
from skyverse.planners.results import SearchRecord, any_angle_result, refused_result
from skyverse.problem import Problem
from skyverse.search.path_shortening.shortcut import drop_repeated
from skyverse.space.obstacles import Space, shapes_hold
from skyverse.space.world import segment_free
from skyverse.stop import Stop

_SAMPLES_PER_LEG = 32
"""How many points of a leg are tested for being inside an obstacle that is no box."""


@by_reference
class StraightTask(NamedTuple):
    """What is sought: a path from start to goal, (3,) metres each, through a space, at these rates.

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


@by_reference
class StraightPath(NamedTuple):
    """A path: ``points[:length[0]]``, metres, which costs ``cost[0]``."""

    points: Floats
    length: Ints
    cost: Floats


def no_straight_path(capacity: int) -> StraightPath:
    """Return memory for a path of at most `capacity` points, which is not there yet."""
    return StraightPath(np.empty((capacity, 3)), np.zeros(1, np.int64), np.full(1, math.inf))


@dataclass(frozen=True, kw_only=True)
class StraightRun(Run):
    """A run whose candidates are paths of straight legs.

    Attributes
    ----------
    task
        What is sought.
    best
        Collision-free.
    """

    task: StraightTask
    best: StraightPath

    def result(self, problem: Problem, record: SearchRecord) -> Result:
        """Return the result that holds the best path."""
        path = self.best.points[: self.best.length[0]].copy()
        return any_angle_result(problem, path, straight_bound(problem), record)


def open_straight_run(
    problem: Problem, stop: Stop, rng: np.random.Generator, origin: Provenance, joints: int, collision: float
) -> StraightRun | Result:
    """Return a run for paths of so many joints, or the result where nothing is to be searched."""
    if problem.any_angle_refusal is not None:
        return refused_result(problem, problem.any_angle_refusal, origin)
    if np.array_equal(problem.start, problem.end):
        return any_angle_result(problem, problem.start[None], 0.0, SearchRecord(origin))
    airspace = problem.airspace
    task = StraightTask(airspace.world.space, airspace.rates, problem.start, problem.end, float(collision))
    return StraightRun(workspace=make_workspace(stop), rng=rng, task=task, best=no_straight_path(joints + 2))


def joined_to_ends(problem: Problem, path: Floats) -> Floats:
    """Return a path (n, 3) with the UAV's start before it and its target after it, no point twice in a row."""
    if np.array_equal(problem.start, problem.end):
        return problem.start[None]
    return drop_repeated(np.vstack([problem.start, path, problem.end]))


def straight_bound(problem: Problem) -> float:
    """Return what every path costs at least: the straight line's length, and one turn where that line is not safe."""
    rates = problem.airspace.rates
    straight = segment_free(problem.airspace.world.space, problem.start, problem.end)
    return rates.metre * math.dist(problem.start, problem.end) + rates.turn * (not straight)


@kernel
def judge_legs(task: StraightTask, workspace: Workspace, best: StraightPath, path: Floats) -> float:
    """Return the fitness of a path (n, 3) to the goal: its price, and a penalty for its metres inside obstacles.

    The path up to its first leg that is not safe replaces the best path if it is cheaper.
    """
    workspace.spent[PATHS] += 1
    workspace.spent[NODES] += len(path) - 1
    workspace.spent[EVALUATIONS] += 1
    free = len(path)
    metres = 0.0
    for i in range(1, len(path)):
        if not segment_free(task.space, path[i - 1], path[i]):
            free = min(free, i)
            metres += _metres_inside(task.space, path[i - 1], path[i])
    price = cost.legs(task.rates, path, task.goal).sum()
    fitness = price + task.collision * metres
    if free < len(path):
        price = cost.legs(task.rates, path[:free], task.goal).sum()
    if price < best.cost[0]:
        for i in range(free):
            best.points[i] = path[i]
        best.length[0] = free
        best.cost[0] = price
        note_best(workspace, price)
    return fitness


@inner
def _metres_inside(space: Space, a: Floats, b: Floats) -> float:
    """Return the metres of a segment inside grown boxes, and an estimate of those in other obstacles alone."""
    spans = np.empty((len(space.boxes), 2))
    count = 0
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
        if enter < leave:
            spans[count, 0], spans[count, 1] = enter, leave
            count += 1
    spans = spans[:count]
    inside, end = _share_in_shapes(space, a, b, spans), 0.0
    for k in np.argsort(spans[:, 0]):  # the union of the boxes: no metre counts twice
        inside += max(0.0, spans[k, 1] - max(spans[k, 0], end))
        end = max(end, spans[k, 1])
    return inside * math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)


@inner
def _share_in_shapes(space: Space, a: Floats, b: Floats, boxes: Floats) -> float:
    """Return an estimate of the share of a segment that lies in obstacles other than boxes, or in the ground.

    What lies between the ends (n, 2) of its shares in boxes does not count. The estimate is never 0 where there are
    such obstacles, so that every leg that is not safe has a penalty.
    """
    if len(space.solids.kind) == 0 and space.ground.heights.size == 0:
        return 0.0
    inside = 0
    p = np.empty(3)
    for k in range(_SAMPLES_PER_LEG):
        share = (k + 0.5) / _SAMPLES_PER_LEG
        boxed = False
        for i in range(len(boxes)):
            boxed |= boxes[i, 0] < share < boxes[i, 1]
        if boxed:
            continue
        for axis in range(3):
            p[axis] = a[axis] + share * (b[axis] - a[axis])
        inside += shapes_hold(space, 0.0, p)
    return max(inside, 0.5) / _SAMPLES_PER_LEG
