"""The hybrid multiverse on paths of straight legs."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.result import Effort, History, Provenance, Result
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners import straight
from skyverse.planners.base import Metaheuristic, Run, require, require_between
from skyverse.planners.joints import beside, hold, in_band, small_move
from skyverse.planners.moves import Desk, exhausted, rank_wheel, ranked
from skyverse.planners.multiverse import Multiverse, charge
from skyverse.planners.straight import Course, Polylines, judge_legs
from skyverse.planners.survey import explore, open_survey
from skyverse.problem import Problem
from skyverse.search.path_shortening.shorten_by_steps import shorten_by_steps
from skyverse.space.lattice import Grid
from skyverse.space.world import segment_free, without_seams
from skyverse.stop import Stop

_ATTEMPTS = 20
"""How many moves are tried until one keeps a safe path safe: looking costs no evaluation."""
_PLACES = 40
"""How many places the survey has: like the share below, chosen on fields of threats with seeds 100 to 119."""
_SURVEYED = 0.5
"""The share of the budget that surveying may take."""
_AGAIN = 0.2
"""How often a move is followed by another before the path is priced."""


class Rules(NamedTuple):
    """The settings of one iteration; see `HybridMVO`."""

    spent: float
    wep: float
    tdr: float
    tries: int


@dataclass(frozen=True, kw_only=True)
class StraightHybrid(Multiverse, Metaheuristic):
    """The engine of `HybridMVO` for straight legs.

    Attributes
    ----------
    joints
        The most joints of a universe; more only where a seed has more.
    collision
        The price of a metre inside an obstacle.
    """

    joints: int = 12
    collision: float = 100.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "joints", 1)
        require_between(self, "collision", 0, 1e9)

    def longest(self, grid: Grid) -> int:
        """Return how many points a path may have."""
        return self.joints + 2

    def open_run(self, problem: Problem, stop: Stop, rng: np.random.Generator, origin: Provenance) -> Run | Result:
        """Lay out what a run needs, and let the seeds plan."""
        results = self.plan_seeds(problem, rng)
        ways = [_as_legs(problem, result) for result in results if result.status.reached]
        joints = max([self.joints, *(len(way) - 2 for way in ways)])
        room = max(self.universes, len(ways))
        run = straight.open_run(problem, stop, rng, origin, room, joints, self.collision)
        if isinstance(run, Result):
            return run
        for i, way in enumerate(ways):
            run.paths.points[i, : len(way)] = way
            run.paths.length[i] = len(way)
        return charge(run, results)

    def close_run(
        self,
        problem: Problem,
        run: Run,
        effort: Effort,
        seconds: float,
        history: History,
        stopped_by: str,
        origin: Provenance,
    ) -> Result:
        """Return the result of the archived best; its seconds are also those of the seeds."""
        return straight.close_run(problem, run, effort, seconds + run.memory[0], history, stopped_by, origin)

    def begin(self, run: Run) -> object:
        """Make the first population: the seeds' paths, then random ones; lay out the survey."""
        survey = open_survey(run.task, run.paths, run.rng, _PLACES)
        _populate(run.task, run.desk, run.paths, run.best, run.rng)
        return run.memory, survey

    def step(self, run: Run, spent: float) -> None:
        """Survey while that share of the budget lasts and finds ways worth pricing, else do one iteration."""
        if spent < _SURVEYED and explore(run.task, run.desk, run.paths, run.best, run.rng, run.memory[1]):
            return
        rules = Rules(float(spent), self.wep(spent), self.tdr(spent), self.tries)
        _iterate(run.task, run.desk, run.paths, run.best, run.rng, rules)


def _as_legs(problem: Problem, result: Result) -> Floats:
    """Return the path of a seed as straight legs from the UAV's start to its target, pulled tight off the lattice."""
    if result.any_angle:
        return result.path
    path = np.vstack([problem.start, result.path, problem.end])
    path = path[np.r_[True, np.any(np.diff(path, axis=0) != 0.0, axis=1)]]
    return shorten_by_steps(without_seams(problem.airspace.world.space), float(problem.airspace.grid.step.max()), path)


@kernel
def _populate(course: Course, desk: Desk, U: Polylines, best: Polylines, rng: np.random.Generator) -> None:
    for i in range(len(U.length)):
        if i and exhausted(desk):
            return
        if U.length[i] == 0:
            U.length[i] = _draw(course, rng, U.points[i])
        U.cost[i] = judge_legs(course, desk, best, U.points[i, : U.length[i]])


@inner
def _draw(course: Course, rng: np.random.Generator, path: Floats) -> int:
    """Draw a path of up to four joints: anywhere or beside a threat, in order along the line from start to goal."""
    space, rates = course.space, course.rates
    n = 2 + int(rng.random() * min(5, len(path) - 1))
    path[0], path[n - 1] = course.start, course.goal
    for j in range(1, n - 1):
        for axis in range(3):
            path[j, axis] = space.low[axis] + rng.random() * (space.high[axis] - space.low[axis])
        if rng.random() < 0.5:
            beside(course, rng, path[j])
        if rates.altitude > 0.0 and rng.random() < 0.7:
            path[j, 2] = in_band(rates, rng.random(), path[j])
        hold(course, path[j])
    order = np.argsort((path[1 : n - 1] - course.start) @ (course.goal - course.start))
    path[1 : n - 1] = path[1 : n - 1][order]
    return n


@kernel
def _iterate(course: Course, desk: Desk, U: Polylines, best: Polylines, rng: np.random.Generator, rules: Rules) -> None:
    n = len(U.length)
    draft = np.empty((U.points.shape[1], 3))
    order = ranked(U.cost)
    norm = math.sqrt((U.cost**2).sum())
    alive = max(min(n, 4), round(n * (1.0 - rules.spent)))
    for rank in range(alive):
        i = order[rank]
        if exhausted(desk):
            return
        if rank and rng.random() * norm < U.cost[i]:  # r1 < NI(U_i), (3.6)
            length = _splice(U, i, order[rank_wheel(n, rng)], rng, draft)
            _offer(course, desk, U, i, best, draft, length, 0.0)
        if exhausted(desk):
            return
        if rank and rng.random() < rules.wep:  # r2 < WEP, (3.7)
            near = rng.random() < 0.5
            length = (
                _pull(course, U, i, order[0], rng, draft, rules.tdr) if near else _splice(U, i, order[0], rng, draft)
            )
            _offer(course, desk, U, i, best, draft, length, 0.0)
        slack = 0.1 * rules.tdr if rank else 0.0
        safe = _safe(course, U.points[i], U.length[i])
        for _ in range(round(2.0 * rules.tries * (1.0 - rank / alive))):
            if exhausted(desk):
                return
            length = _travel(course, U, i, rng, draft, safe)
            _offer(course, desk, U, i, best, draft, length, slack * rng.random())


@inner
def _travel(course: Course, U: Polylines, i: int, rng: np.random.Generator, draft: Floats, safe: bool) -> int:
    """Draw up universe i after a small move or more; what was safe should stay so, or other moves are tried."""
    length = 0
    for _ in range(_ATTEMPTS):
        reach = 0.5 * math.exp(-4.5 * rng.random())
        length = small_move(course, rng, draft, _copy(U, i, draft), reach)
        while rng.random() < _AGAIN:
            length = small_move(course, rng, draft, length, reach)
        if not safe or _safe(course, draft, length):
            break
    return length


@inner
def _safe(course: Course, path: Floats, n: int) -> bool:
    j = 1
    while j < n and segment_free(course.space, path[j - 1], path[j]):
        j += 1
    return j >= n


@inner
def _copy(U: Polylines, i: int, draft: Floats) -> int:
    n = U.length[i]
    for j in range(n):
        for axis in range(3):
            draft[j, axis] = U.points[i, j, axis]
    return n


@inner
def _offer(
    course: Course, desk: Desk, U: Polylines, i: int, best: Polylines, draft: Floats, n: int, slack: float
) -> None:
    """Let the draft be universe i unless it costs more, by more than a share."""
    price = judge_legs(course, desk, best, draft[:n])
    if price <= U.cost[i] * (1.0 + slack):
        for j in range(n):
            for axis in range(3):
                U.points[i, j, axis] = draft[j, axis]
        U.length[i] = n
        U.cost[i] = price


@inner
def _splice(U: Polylines, i: int, k: int, rng: np.random.Generator, draft: Floats) -> int:
    """Draw up universe i with a stretch of universe k between the points of i that are nearest to its ends."""
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
    """Add a point to the draft unless it is full, or ends there."""
    if n and draft[n - 1, 0] == point[0] and draft[n - 1, 1] == point[1] and draft[n - 1, 2] == point[2]:
        return n
    if n < len(draft):
        for axis in range(3):
            draft[n, axis] = point[axis]
        return n + 1
    return n


@inner
def _nearest(U: Polylines, i: int, place: Floats) -> int:
    """Return which point of universe i is nearest to a place."""
    nearest, least = 0, math.inf
    for j in range(U.length[i]):
        squared = ((U.points[i, j] - place) ** 2).sum()
        if squared < least:
            nearest, least = j, squared
    return nearest


@inner
def _pull(course: Course, U: Polylines, i: int, top: int, rng: np.random.Generator, draft: Floats, tdr: float) -> int:
    """Draw up universe i with each joint, or one, drawn towards the nearest point of the best, within TDR of it."""
    n = _copy(U, i, draft)
    if n == 2:
        return n
    one = 1 + int(rng.random() * (n - 2)) if rng.random() < 0.5 else -1
    for j in range(1, n - 1):
        if one in (-1, j):
            aim = U.points[top, _nearest(U, top, draft[j])]
            pull = rng.random()
            for axis in range(3):
                low, high = course.space.low[axis], course.space.high[axis]
                place = aim[axis] + tdr * 0.1 * (high - low) * (2.0 * rng.random() - 1.0)
                draft[j, axis] = min(max(draft[j, axis] + pull * (place - draft[j, axis]), low), high)
    return n
