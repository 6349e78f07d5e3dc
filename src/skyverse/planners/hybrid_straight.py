"""The hybrid multiverse on paths of straight legs off the lattice."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from skyverse._typing import Floats
from skyverse.model.result import Provenance, Result
from skyverse.numerics.arrays import order_of
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.planners.metaheuristic import Metaheuristic
from skyverse.planners.moves import Workspace, exhausted
from skyverse.planners.multiverse import Multiverse, charge_seeds
from skyverse.planners.polyline_moves import altitude_in_band, clamp_to_bounds, move_beside_threat, small_move
from skyverse.planners.roadmap import Roadmap, explore_roadmap, make_roadmap
from skyverse.planners.selection import rank_wheel, ranked
from skyverse.planners.settings import require_integer, require_number
from skyverse.planners.straight_legs import (
    Polylines,
    StraightRun,
    StraightTask,
    joined_to_ends,
    judge_legs,
    open_straight_run,
)
from skyverse.problem import Problem
from skyverse.search.path_shortening.shorten_by_steps import shorten_by_steps
from skyverse.space.lattice import Grid
from skyverse.space.world import segment_free
from skyverse.stop import Stop

_MAX_MOVE_ATTEMPTS = 20
"""How many moves are tried until one keeps a safe path safe; the test for safety is no evaluation."""

_ROADMAP_SIZE = 40
"""The number of a roadmap's points; like the share below, it was chosen on fields of threats with seeds 100 to 119."""

_ROADMAP_SHARE = 0.5
"""The share of the budget for which the roadmap may be explored."""

_ANOTHER_MOVE = 0.2
"""The probability that a move is followed by another one before the path is priced."""

_DEARER_SHARE = 0.1
"""The share by which a universe other than the best may get dearer at TDR = 1."""


@by_reference
class StraightSettings(NamedTuple):
    """The settings of one iteration; see `HybridMVO`."""

    spent: float
    wep: float
    tdr: float
    tries: int


@dataclass(frozen=True, kw_only=True)
class StraightHybrid(Multiverse, Metaheuristic[StraightRun]):
    """The engine of `HybridMVO` for straight legs.

    Attributes
    ----------
    joints
        The largest number of joints of a universe, unless a seed has more.
    collision
        The price of a metre inside an obstacle.
    """

    joints: int = 12
    collision: float = 100.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_integer(self, "joints", 1)
        require_number(self, "collision", 0, 1e9)

    def longest(self, grid: Grid) -> int:
        """Return how many points a path may have."""
        return self.joints + 2

    def open_run(self, problem: Problem, stop: Stop, rng: Generator, origin: Provenance) -> StraightRun | Result:
        """Return a run that holds the seeds' paths, or the result where nothing is to be searched."""
        results = self.plan_seeds(problem, rng)
        ways = [_as_legs(problem, result) for result in results if result.status.reached]
        run = open_straight_run(
            problem,
            stop,
            rng,
            origin,
            population=max(self.universes, len(ways)),
            joints=max([self.joints, *(len(way) - 2 for way in ways)]),
            collision=self.collision,
        )
        if isinstance(run, Result):
            return run
        for i, way in enumerate(ways):
            run.paths.points[i, : len(way)] = way
            run.paths.length[i] = len(way)
        return charge_seeds(run, results)

    def begin(self, run: StraightRun) -> Roadmap:
        """Make the first population of the seeds' paths and random ones, and a roadmap, which is returned."""
        roadmap = make_roadmap(run.task, run.paths, run.rng, _ROADMAP_SIZE)
        _populate(run.task, run.workspace, run.paths, run.best, run.rng)
        return roadmap

    def step(self, run: StraightRun, spent: float) -> None:
        """Explore the roadmap as long as its share of the budget lasts and paths are worth pricing; else iterate."""
        roadmap = run.memory
        assert isinstance(roadmap, Roadmap)
        if spent < _ROADMAP_SHARE and explore_roadmap(run.task, run.workspace, run.paths, run.best, run.rng, roadmap):
            return
        settings = StraightSettings(float(spent), self.wep(spent), self.tdr(spent), self.tries)
        _iterate(run.task, run.workspace, run.paths, run.best, run.rng, settings)


def _as_legs(problem: Problem, result: Result) -> Floats:
    """Return the path of a seed as straight legs from the problem's start to its end; shorten a lattice path."""
    if result.any_angle:
        return problem.without_lifts(result.path)
    path = joined_to_ends(problem, result.path)
    space = problem.airspace.world.space
    return shorten_by_steps(space, float(problem.airspace.grid.step.max()), path)


@kernel
def _populate(task: StraightTask, workspace: Workspace, U: Polylines, best: Polylines, rng: Generator) -> None:
    for i in range(len(U.length)):
        if i and exhausted(workspace):
            return
        if U.length[i] == 0:
            U.length[i] = _random_path(task, rng, U.points[i])
        U.cost[i] = judge_legs(task, workspace, best, U.points[i, : U.length[i]])


@inner
def _random_path(task: StraightTask, rng: Generator, path: Floats) -> int:
    """Make a path of up to four joints, anywhere or beside a threat, in order along the line from start to goal.

    Returns
    -------
    int
        How many points it has.
    """
    space, rates = task.space, task.rates
    n = 2 + int(rng.random() * min(5, len(path) - 1))
    path[0], path[n - 1] = task.start, task.goal
    for j in range(1, n - 1):
        for axis in range(3):
            path[j, axis] = space.low[axis] + rng.random() * (space.high[axis] - space.low[axis])
        if rng.random() < 0.5:
            move_beside_threat(task, rng, path[j])
        if rates.altitude > 0.0 and rng.random() < 0.7:
            path[j, 2] = altitude_in_band(rates, rng.random(), path[j])
        clamp_to_bounds(task, path[j])
    along = np.zeros(n - 2)
    for j in range(n - 2):
        for axis in range(3):
            along[j] += (path[j + 1, axis] - task.start[axis]) * (task.goal[axis] - task.start[axis])
    path[1 : n - 1] = path[1 : n - 1][order_of(along)]
    return n


@kernel
def _iterate(
    task: StraightTask, workspace: Workspace, U: Polylines, best: Polylines, rng: Generator, settings: StraightSettings
) -> None:
    n = len(U.length)
    draft = np.empty((U.points.shape[1], 3))
    order = ranked(U.cost)
    norm = math.sqrt((U.cost**2).sum())
    alive = max(min(n, 4), round(n * (1.0 - settings.spent)))
    for rank in range(alive):
        i = order[rank]
        if exhausted(workspace):
            return
        if rank and rng.random() * norm < U.cost[i]:  # r1 < NI(U_i), (3.6)
            length = _splice(U, i, order[rank_wheel(n, rng)], rng, draft)
            _accept_draft(task, workspace, U, i, best, draft, length, 0.0)
        if exhausted(workspace):
            return
        if rank and rng.random() < settings.wep:  # r2 < WEP, (3.7)
            approach = rng.random() < 0.5
            if approach:
                length = _approach_best(task, U, i, order[0], rng, draft, settings.tdr)
            else:
                length = _splice(U, i, order[0], rng, draft)
            _accept_draft(task, workspace, U, i, best, draft, length, 0.0)
        slack = _DEARER_SHARE * settings.tdr if rank else 0.0
        safe = _is_safe(task, U.points[i], U.length[i])
        for _ in range(round(2.0 * settings.tries * (1.0 - rank / alive))):
            if exhausted(workspace):
                return
            length = _travel(task, U, i, rng, draft, safe)
            _accept_draft(task, workspace, U, i, best, draft, length, slack * rng.random())


@inner
def _travel(task: StraightTask, U: Polylines, i: int, rng: Generator, draft: Floats, safe: bool) -> int:
    """Draft universe i after one small move or several; return the draft's number of points.

    Where the universe is safe, moves that would make it unsafe are replaced by other ones.
    """
    length = 0
    for _ in range(_MAX_MOVE_ATTEMPTS):
        reach = 0.5 * math.exp(-4.5 * rng.random())
        length = small_move(task, rng, draft, _copy_universe(U, i, draft), reach)
        while rng.random() < _ANOTHER_MOVE:
            length = small_move(task, rng, draft, length, reach)
        if not safe or _is_safe(task, draft, length):
            break
    return length


@inner
def _is_safe(task: StraightTask, path: Floats, n: int) -> bool:
    """Tell whether all legs of a path of n points are collision-free."""
    j = 1
    while j < n and segment_free(task.space, path[j - 1], path[j]):
        j += 1
    return j >= n


@inner
def _copy_universe(U: Polylines, i: int, draft: Floats) -> int:
    """Let the draft be universe i; return its number of points."""
    n = U.length[i]
    for j in range(n):
        for axis in range(3):
            draft[j, axis] = U.points[i, j, axis]
    return n


@inner
def _accept_draft(
    task: StraightTask, workspace: Workspace, U: Polylines, i: int, best: Polylines, draft: Floats, n: int, slack: float
) -> None:
    """Price the draft of n points, and replace universe i by it unless it is dearer by more than the share `slack`."""
    price = judge_legs(task, workspace, best, draft[:n])
    if price <= U.cost[i] * (1.0 + slack):
        for j in range(n):
            for axis in range(3):
                U.points[i, j, axis] = draft[j, axis]
        U.length[i] = n
        U.cost[i] = price


@inner
def _splice(U: Polylines, i: int, k: int, rng: Generator, draft: Floats) -> int:
    """Draft universe i with a stretch of universe k between the points of i that are nearest to the stretch's ends."""
    p = int(rng.random() * U.length[k])
    q = p + int(rng.random() * (U.length[k] - p))
    a, b = _nearest(U, i, U.points[k, p]), _nearest(U, i, U.points[k, q])
    n = 0
    for j in range(min(a, b) + 1 if p else 0):
        n = _append(draft, n, U.points[i, j])
    for j in range(p, q + 1):
        n = _append(draft, n, U.points[k, j])
    for j in range(max(a, b), U.length[i]):
        n = _append(draft, n, U.points[i, j])
    draft[n - 1] = U.points[i, U.length[i] - 1]
    return n


@inner
def _append(draft: Floats, n: int, point: Floats) -> int:
    """Append a point to the draft unless it is full or ends there; return the draft's number of points."""
    if n and draft[n - 1, 0] == point[0] and draft[n - 1, 1] == point[1] and draft[n - 1, 2] == point[2]:
        return n
    if n < len(draft):
        for axis in range(3):
            draft[n, axis] = point[axis]
        return n + 1
    return n


@inner
def _nearest(U: Polylines, i: int, point: Floats) -> int:
    """Return the index of the joint or end of universe i that is nearest to a point."""
    nearest, least = 0, math.inf
    for j in range(U.length[i]):
        squared = ((U.points[i, j] - point) ** 2).sum()
        if squared < least:
            nearest, least = j, squared
    return nearest


@inner
def _approach_best(
    task: StraightTask, U: Polylines, i: int, top: int, rng: Generator, draft: Floats, tdr: float
) -> int:
    """Draft universe i with one joint, or all, moved towards the nearest points of the best, within TDR of them."""
    n = _copy_universe(U, i, draft)
    if n == 2:
        return n
    one = 1 + int(rng.random() * (n - 2)) if rng.random() < 0.5 else -1
    for j in range(1, n - 1):
        if one in (-1, j):
            aim = U.points[top, _nearest(U, top, draft[j])]
            share = rng.random()
            for axis in range(3):
                low, high = task.space.low[axis], task.space.high[axis]
                target = aim[axis] + tdr * 0.1 * (high - low) * (2.0 * rng.random() - 1.0)
                draft[j, axis] = min(max(draft[j, axis] + share * (target - draft[j, axis]), low), high)
    return n
