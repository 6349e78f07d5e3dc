"""Metaheuristics on waypoints: candidates are vectors of numbers, and any optimiser of such vectors plans."""

import contextlib
import importlib.util
import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.errors import InputError
from skyverse.model.result import Effort, History, Provenance, Result
from skyverse.model.scenario import Scenario
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners import straight
from skyverse.planners.base import Metaheuristic, Run, require, require_between
from skyverse.planners.moves import NODES, PATHS, Desk, Paths, Task, begin_at, cut_loops, exhausted, judge, put
from skyverse.planners.optimisers import Evaluate, Iterations
from skyverse.planners.straight import Course, Polylines, judge_legs
from skyverse.problem import Problem
from skyverse.space.lattice import Grid, positions
from skyverse.stop import Stop


class _BudgetSpentError(Exception):
    """Ends an optimiser in the middle of an iteration; the run ends right after."""


@dataclass(frozen=True, kw_only=True)
class WaypointSearch(Metaheuristic):
    """A population of waypoint vectors, for optimisers of continuous functions.

    A candidate is a vector in [0, 1]^(3 k): k free waypoints, x, y, z each, as shares of the lattice's extent. Its
    path goes from the start through the nodes nearest to them to the goal, on digital straight lines: one axis per
    move on a 6-connected lattice, diagonals allowed on a 26-connected one. Obstacles do not bend it.

    With ``legs="straight"`` the path leaves the lattice: straight legs from the UAV's true start through the waypoints
    as they are, shares of the bounds, to its true target. The lattice is not asked for, not even whether it has a path.

    - What the optimiser minimises, the *fitness*, is the cost of the whole path, with `collision` added for every metre
      of moves that the lattice forbids, or inside grown obstacles.
    - What is archived as the best is the path up to its first forbidden move or leg, its loops cut out on the lattice,
      at its cost (equation 3.4): a candidate that meets an obstacle is an incomplete path. Of a path without forbidden
      move and loop, fitness and cost are equal.

    One decoded candidate is one generated path and one evaluation. A method is a subclass with one generator function,
    `optimise`.

    The first population is uniform, each candidate's waypoints then put in order along the line from start to goal. It
    depends on the seed alone, so methods with equal settings begin with the same candidates.

    Attributes
    ----------
    waypoints
        k, the free waypoints of a path.
    candidates
        The population.
    collision
        The price of a metre of forbidden moves, or inside obstacles.
    legs
        ``"lattice"`` or ``"straight"``.
    """

    waypoints: int = 6
    candidates: int = 25
    collision: float = 100.0
    legs: Literal["lattice", "straight"] = "lattice"

    library: ClassVar[str] = ""
    """The package that the method needs and skyverse itself does not, if any."""

    def __post_init__(self) -> None:
        require(self, "waypoints", 1)
        require(self, "candidates", 6)
        require_between(self, "collision", 0, 1e9)
        if self.legs not in ("lattice", "straight"):
            raise ValueError(f"{type(self).__name__}'s legs is 'lattice' or 'straight', not {self.legs!r}")
        if self.library and importlib.util.find_spec(self.library) is None:
            raise InputError(
                f"{type(self).__name__} needs the package {self.library}, which is not installed; "
                'pip install "skyverse[optimisers]"'
            )

    @abstractmethod
    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Evaluate the first population, yield, and do an iteration each time that the share spent is sent.

        Parameters
        ----------
        evaluate
            Takes (m, d) candidates, clipped to [0, 1], and returns their (m,) fitness. It does not return when the
            budget is spent: the run is over then.
        first
            (candidates, d) the first population.
        rng
            Where all random numbers come from.
        """

    @property
    def population(self) -> int:
        """How many candidates are kept."""
        return self.candidates

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether paths leave the lattice."""
        return self.legs == "straight"

    def longest(self, grid: Grid) -> int:
        """Return how many nodes a path may have: those of all legs, each across the whole lattice."""
        return 1 + (self.waypoints + 1) * int((grid.shape - 1).sum())

    def open_run(self, problem: Problem, stop: Stop, rng: np.random.Generator, origin: Provenance) -> Run | Result:
        """Lay out what a run needs, or return the result where there is nothing to search."""
        if self.legs == "lattice":
            return super().open_run(problem, stop, rng, origin)
        return straight.open_run(problem, stop, rng, origin, 0, self.waypoints, self.collision)

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
        """Return the result of the archived best."""
        close = super().close_run if self.legs == "lattice" else straight.close_run
        return close(problem, run, effort, seconds, history, stopped_by, origin)

    def begin(self, run: Run) -> object:
        """Start the optimiser on the first population."""
        drawn = run.rng.random((self.candidates, self.waypoints, 3))
        if self.legs == "lattice":
            extent = (run.task.grid.shape - 1) * run.task.grid.step
            start, goal = positions(run.task.grid, [run.task.source, run.task.goal])
        else:
            extent = run.task.space.high - run.task.space.low
            start, goal = run.task.start, run.task.goal
        first = _in_order(drawn, extent * (goal - start))

        def evaluate(candidates: Floats) -> Floats:
            X = np.ascontiguousarray(candidates, dtype=np.float64)
            if self.legs == "lattice":
                fitness = decode(run.task, run.desk, run.best, X, float(self.collision))
            else:
                fitness = decode_straight(run.task, run.desk, run.best, X)
            if len(fitness) and fitness[-1] == math.inf:
                raise _BudgetSpentError
            return fitness

        iterations = self.optimise(evaluate, first.reshape(self.candidates, -1), run.rng)
        with contextlib.suppress(_BudgetSpentError):
            next(iterations)
        return iterations

    def step(self, run: Run, spent: float) -> None:
        """Let the optimiser do one iteration."""
        with contextlib.suppress(_BudgetSpentError):
            run.memory.send(spent)


def _in_order(X: Floats, line: Floats) -> Floats:
    """Sort each candidate's waypoints, (m, k, 3), along a line, (3,)."""
    along = X @ line
    return np.take_along_axis(X, np.argsort(along, axis=1)[:, :, None], axis=1)


@kernel
def decode(task: Task, desk: Desk, best: Paths, X: Floats, collision: float) -> Floats:
    """Decode (m, 3 k) candidates, archive the best, return their (m,) fitness: infinite where no budget was left."""
    grid, pricing = task.grid, task.pricing
    fitness = np.full(len(X), math.inf)
    for i in range(len(X)):
        if exhausted(desk):
            break
        length, free, metres = draw_up(task, desk, X[i])
        desk.spent[PATHS] += 1
        desk.spent[NODES] += length - 1
        nodes = desk.draft[:length]
        fitness[i] = cost.fuel(grid, pricing, nodes) + cost.divergence(grid, pricing, nodes) + collision * metres
        length = cut_loops(desk, 0, free)
        price = judge(task, desk, length)
        if price < best.cost[0]:
            put(best, 0, desk, length, price)
    return fitness


@kernel
def decode_straight(course: Course, desk: Desk, best: Polylines, X: Floats) -> Floats:
    """Price (m, 3 k) candidates with straight legs; see `decode`."""
    low, high = course.space.low, course.space.high
    fitness = np.full(len(X), math.inf)
    path = np.empty((X.shape[1] // 3 + 2, 3))
    path[0], path[-1] = course.start, course.goal
    for i in range(len(X)):
        if exhausted(desk):
            break
        for w in range(X.shape[1] // 3):
            for axis in range(3):
                share = min(max(X[i, 3 * w + axis], 0.0), 1.0)
                path[w + 1, axis] = low[axis] + share * (high[axis] - low[axis])
        fitness[i] = judge_legs(course, desk, best, path)
    return fitness


@kernel
def draw_up(task: Task, desk: Desk, x: Floats) -> tuple[int, int, float]:
    """Draw up the path through the waypoints `x`, (3 k,).

    Returns
    -------
    length
        How many nodes the draft has.
    free
        How many of them come before the first move that the lattice forbids.
    metres
        The length of all forbidden moves.
    """
    grid = task.grid
    length = begin_at(desk, task.source)
    free, metres = length, 0.0
    for w in range(0, len(x), 3):
        node = 0
        for axis in range(3):
            last = grid.shape[axis] - 1
            node = node * grid.shape[axis] + int(min(max(x[w + axis], 0.0), 1.0) * last + 0.5)
        length, free, metres = _straight(grid, desk.draft, length, free, metres, node)
    return _straight(grid, desk.draft, length, free, metres, task.goal)


@inner
def _straight(grid: Grid, draft: Ints, length: int, free: int, metres: float, goal: int) -> tuple[int, int, float]:
    """Continue the draft to a node on a digital straight line; see `draw_up` for what is returned."""
    ny, nz = grid.shape[1], grid.shape[2]
    node = int(draft[length - 1])
    way = np.array(
        [goal // (ny * nz) - node // (ny * nz), (goal // nz) % ny - (node // nz) % ny, goal % nz - node % nz]
    )
    size = np.abs(way)
    one_axis = len(grid.offsets) == 6
    count = size.sum() if one_axis else size.max()
    done = np.zeros(3, np.int64)
    move = np.zeros(3, np.int64)
    for t in range(1, count + 1):
        if one_axis:  # the axis whose next unit has its middle nearest
            axis = -1
            for a in range(3):
                if done[a] < size[a] and (axis < 0 or (2 * done[a] + 1) * size[axis] < (2 * done[axis] + 1) * size[a]):
                    axis = a
            move[:] = 0
            move[axis] = 1
        else:
            for a in range(3):
                move[a] = (2 * size[a] * t + count) // (2 * count) - done[a]
        done += move
        allowed, far = _allowed(grid, node, move * np.sign(way))
        node += (move[0] * np.sign(way[0]) * ny + move[1] * np.sign(way[1])) * nz + move[2] * np.sign(way[2])
        draft[length] = node
        length += 1
        if not allowed:
            metres += far
        elif metres == 0.0:
            free = length
    return length, free, metres


@inner
def _allowed(grid: Grid, node: int, move: Ints) -> tuple[bool, float]:
    """Return whether the lattice allows a move, (3,), from a node, and the move's length, metres."""
    m = 0
    while grid.moves[m, 0] != move[0] or grid.moves[m, 1] != move[1] or grid.moves[m, 2] != move[2]:
        m += 1
    far = math.sqrt((move[0] * grid.step[0]) ** 2 + (move[1] * grid.step[1]) ** 2 + (move[2] * grid.step[2]) ** 2)
    return (grid.exits[node] >> m) & 1 == 1, far
