"""Metaheuristics on waypoints: a candidate is a vector of numbers, so that any optimiser of vectors can plan."""

import math
from abc import abstractmethod
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.errors import InputError, require_number, require_whole
from skyverse.extras import require_libraries
from skyverse.model.result import Provenance, Result
from skyverse.model.scenario import Scenario
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.base import numbers_of
from skyverse.planners.metaheuristic import LatticeRun, Metaheuristic, Run, make_workspace
from skyverse.planners.moves import (
    NODES,
    PATHS,
    LatticeTask,
    Paths,
    Workspace,
    begin_at,
    cut_loops,
    draft_contact,
    exhausted,
    judge,
    keep_if_best,
)
from skyverse.planners.objective import ObjectiveRun, PathObjective, PricedPath, in_order
from skyverse.planners.results import refused_result
from skyverse.planners.straight_legs import StraightPath, StraightRun, StraightTask, judge_legs, open_straight_run
from skyverse.problem import Problem
from skyverse.space.lattice import Grid, positions
from skyverse.stop import Stop

Evaluate = Callable[[Floats], Floats]
"""Returns the (m,) fitness of (m, d) vectors, which is to be minimised."""

Iterations = Generator[None, float, None]
"""One iteration for each share of the budget that is sent."""


class _BudgetSpentError(Exception):
    """Interrupts an optimiser in the middle of an iteration, after which the run ends."""


@dataclass(frozen=True, kw_only=True)
class WaypointSearch(Metaheuristic[LatticeRun | StraightRun | ObjectiveRun]):
    """A population of waypoint vectors, for optimisers of continuous functions.

    A candidate is a vector in [0, 1]^(3 k). It holds x, y and z of k free waypoints as shares of the lattice's extent.
    Its path leads from the start through the nodes nearest to the waypoints to the goal, on digital straight lines: a
    move changes one axis on a 6-connected lattice, and may be diagonal on a 26-connected one. Obstacles do not bend it.

    With ``legs="straight"`` the path leaves the lattice. Straight legs lead from the UAV's true start through the
    waypoints themselves, which are shares of the bounds, to its true target. The lattice is not used, so that it does
    not matter whether it has a path.

    - The optimiser minimises the *fitness*: the cost of the whole path, and `collision` for every metre of moves that
      the lattice forbids, or inside grown obstacles.
    - The best path that is kept is a candidate's path up to its first forbidden move or leg, on the lattice without
      its loops, and its cost is that of equation 3.4. So a candidate that meets an obstacle is an incomplete path. For
      a path without forbidden moves and without loops, fitness and cost are equal.

    One decoded candidate is one generated path and one evaluation. A method is a subclass with one generator function,
    `optimise`.

    The first population is uniform, but each candidate's waypoints are sorted along the line from start to goal. It
    depends on the seed alone, so that methods with equal settings begin with the same candidates.

    Attributes
    ----------
    waypoints
        k, the number of a path's free waypoints.
    candidates
        The number of candidates in the population.
    collision
        The price of a metre of forbidden moves, or of a metre inside obstacles.
    legs
        ``"lattice"`` or ``"straight"``.
    objective
        An objective of one's own, which takes the place of the fitness above, and whose paths have straight legs.
    """

    waypoints: int = 6
    candidates: int = 25
    collision: float = 100.0
    legs: Literal["lattice", "straight"] = "lattice"
    objective: PathObjective | None = None

    library: ClassVar[str] = ""
    """The package that the method needs in addition to those of skyverse, if any."""

    def __post_init__(self) -> None:
        require_whole(self.waypoints, "waypoints", 1)
        require_whole(self.candidates, "candidates", 6)
        require_number(self.collision, "collision", least=0, most=1e9)
        if self.legs not in ("lattice", "straight"):
            raise InputError(f"{type(self).__name__}'s legs is 'lattice' or 'straight', not {self.legs!r}")
        if not isinstance(self.objective, PathObjective | None):
            raise InputError(f"{type(self).__name__}'s objective is a PathObjective, not {self.objective!r}")
        if self.library:
            require_libraries(type(self).__name__, self.library)

    @abstractmethod
    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Evaluate the first population and yield; then do one iteration for each share of the budget that is sent.

        Parameters
        ----------
        evaluate
            Takes (m, d) candidates, clips them to [0, 1], and returns their (m,) fitness. When the budget is spent it
            raises an exception instead, which ends the run.
        first
            (candidates, d) the first population.
        rng
            The source of all random numbers.
        """

    @property
    def population(self) -> int:
        """How many candidates are kept."""
        return self.candidates

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether paths leave the lattice."""
        return self.legs == "straight" or self.objective is not None

    def longest(self, grid: Grid) -> int:
        """Return how many nodes a path may have: as many as if each leg crossed the whole lattice."""
        return 1 + (self.waypoints + 1) * int((grid.shape - 1).sum())

    def open_run(
        self, problem: Problem, stop: Stop, rng: np.random.Generator, origin: Provenance
    ) -> LatticeRun | StraightRun | ObjectiveRun | Result:
        """Return a run without candidates, or the result where nothing is to be searched."""
        if self.objective is not None:
            if problem.any_angle_refusal is not None:
                return refused_result(problem, problem.any_angle_refusal, origin)
            return ObjectiveRun(
                workspace=make_workspace(stop), rng=rng, problem=problem, objective=self.objective, best=PricedPath()
            )
        if self.legs == "lattice":
            return super().open_run(problem, stop, rng, origin)
        return open_straight_run(problem, stop, rng, origin, self.waypoints, self.collision)

    def begin(self, run: LatticeRun | StraightRun | ObjectiveRun) -> Iterations:
        """Start the optimiser on the first population."""
        field = f"{type(self).__name__}.optimise"
        first = numbers_of(self._first(run), (-1, -1), "a first population of finite numbers", "objective")

        def evaluate(candidates: Floats) -> Floats:
            X = numbers_of(candidates, (-1, first.shape[1]), "candidates of finite numbers", field)
            if not len(X):
                return np.empty(0)
            if isinstance(run, ObjectiveRun):
                fitness = run.evaluate(X)
            elif isinstance(run, LatticeRun):
                fitness = decode(run.task, run.workspace, run.best, X, float(self.collision))
            else:
                fitness = decode_straight(run.task, run.workspace, run.best, X)
            if math.isnan(fitness[-1]):
                raise _BudgetSpentError
            return fitness

        iterations = self.optimise(evaluate, first, run.rng)
        self._advance(iterations, run, None)
        return iterations

    def _first(self, run: LatticeRun | StraightRun | ObjectiveRun) -> Floats:
        if isinstance(run, ObjectiveRun):
            return run.objective.first(run.problem, run.rng, self.candidates, self.waypoints)
        drawn = run.rng.random((self.candidates, self.waypoints, 3))
        if isinstance(run, LatticeRun):
            extent = (run.task.grid.shape - 1) * run.task.grid.step
            start, goal = positions(run.task.grid, [run.task.source, run.task.goal])
        else:
            extent = run.task.space.high - run.task.space.low
            start, goal = run.task.start, run.task.goal
        return in_order(drawn, extent * (goal - start)).reshape(self.candidates, -1)

    def step(self, run: LatticeRun | StraightRun | ObjectiveRun, spent: float) -> None:
        """Let the optimiser do one iteration."""
        self._advance(run.memory, run, spent)

    def _advance(self, iterations: object, run: Run, spent: float | None) -> None:
        """Let the optimiser go on to its next yield; `InputError` where it ends, or has evaluated nothing."""
        before, evaluated = int(run.workspace.spent[PATHS]), False
        try:
            if isinstance(iterations, Generator):
                iterations.send(spent)
                evaluated = run.workspace.spent[PATHS] > before
        except _BudgetSpentError:
            return
        except StopIteration:
            pass
        if not evaluated:
            said = "expected it to evaluate candidates and yield, again and again; it ended, or evaluated none"
            raise InputError(said, field=f"{type(self).__name__}.optimise")


@kernel
def decode(task: LatticeTask, workspace: Workspace, best: Paths, X: Floats, collision: float) -> Floats:
    """Decode (m, 3 k) candidates, keep the best path, and return their (m,) fitness: NaN without budget."""
    grid, pricing = task.grid, task.pricing
    fitness = np.full(len(X), math.nan)
    for i in range(len(X)):
        if exhausted(workspace):
            break
        length, free, metres = draft_through(task, workspace, X[i])
        workspace.spent[PATHS] += 1
        workspace.spent[NODES] += length - 1
        nodes = workspace.draft[:length]
        fitness[i] = cost.fuel(grid, pricing, nodes) + cost.divergence(grid, pricing, nodes) + collision * metres
        if len(task.contact.shapes.kind):
            fitness[i] += draft_contact(task, workspace, length)
        length = cut_loops(workspace, 0, free)
        keep_if_best(workspace, best, length, judge(task, workspace, length))
    return fitness


@kernel
def decode_straight(task: StraightTask, workspace: Workspace, best: StraightPath, X: Floats) -> Floats:
    """Decode (m, 3 k) candidates to paths of straight legs; see `decode`."""
    low, high = task.space.low, task.space.high
    fitness = np.full(len(X), math.nan)
    path = np.empty((X.shape[1] // 3 + 2, 3))
    path[0], path[-1] = task.start, task.goal
    for i in range(len(X)):
        if exhausted(workspace):
            break
        for w in range(X.shape[1] // 3):
            for axis in range(3):
                share = min(max(X[i, 3 * w + axis], 0.0), 1.0)
                path[w + 1, axis] = low[axis] + share * (high[axis] - low[axis])
        fitness[i] = judge_legs(task, workspace, best, path)
    return fitness


@kernel
def draft_through(task: LatticeTask, workspace: Workspace, x: Floats) -> tuple[int, int, float]:
    """Draft the path on digital straight lines through the waypoints `x`, (3 k,).

    Returns
    -------
    length
        How many nodes the draft has.
    free
        How many of them come before the first move that the lattice forbids.
    metres
        The total length of the forbidden moves.
    """
    grid = task.grid
    length = begin_at(workspace, task.source)
    free, metres = length, 0.0
    for w in range(0, len(x), 3):
        node = 0
        for axis in range(3):
            last = grid.shape[axis] - 1
            node = node * grid.shape[axis] + int(min(max(x[w + axis], 0.0), 1.0) * last + 0.5)
        length, free, metres = _digital_line(grid, workspace.draft, length, free, metres, node)
    return _digital_line(grid, workspace.draft, length, free, metres, task.goal)


@inner
def _digital_line(grid: Grid, draft: Ints, length: int, free: int, metres: float, goal: int) -> tuple[int, int, float]:
    """Continue the draft to a node on a digital straight line; see `draft_through` for the values returned."""
    ny, nz = grid.shape[1], grid.shape[2]
    node = int(draft[length - 1])
    offset = np.array(
        [goal // (ny * nz) - node // (ny * nz), (goal // nz) % ny - (node // nz) % ny, goal % nz - node % nz]
    )
    size = np.abs(offset)
    one_axis = len(grid.offsets) == 6
    count = size.sum() if one_axis else size.max()
    done = np.zeros(3, np.int64)
    move = np.zeros(3, np.int64)
    for t in range(1, count + 1):
        if one_axis:  # the axis whose next unit has the nearest middle
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
        allowed, far = _allowed(grid, node, move * np.sign(offset))
        node += (move[0] * np.sign(offset[0]) * ny + move[1] * np.sign(offset[1])) * nz + move[2] * np.sign(offset[2])
        draft[length] = node
        length += 1
        if not allowed:
            metres += far
        elif metres == 0.0:
            free = length
    return length, free, metres


@inner
def _allowed(grid: Grid, node: int, move: Ints) -> tuple[bool, float]:
    """Return whether the lattice allows a move (3,) from a node, and the move's length in metres."""
    m = 0
    while grid.moves[m, 0] != move[0] or grid.moves[m, 1] != move[1] or grid.moves[m, 2] != move[2]:
        m += 1
    far = math.sqrt((move[0] * grid.step[0]) ** 2 + (move[1] * grid.step[1]) ** 2 + (move[2] * grid.step[2]) ** 2)
    return (grid.exits[node] >> m) & 1 == 1, far
