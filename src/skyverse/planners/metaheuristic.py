"""The one loop that every metaheuristic runs in, and the state of one run."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar, cast

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.result import Effort, History, Provenance, Result, Status
from skyverse.model.short_lines import counted
from skyverse.numerics.kernel import Stopwatch
from skyverse.planners.base import Planner, Seed, provenance, require_problem, seeded
from skyverse.planners.contact import contact_of
from skyverse.planners.moves import LatticeTask, Paths, Workspace
from skyverse.planners.results import SearchRecord, lattice_result, refused_result
from skyverse.problem import Problem
from skyverse.space.contact import flown_legs
from skyverse.space.lattice import Grid
from skyverse.stop import MaxIterations, OnIteration, Progress, Stop

_IMPROVEMENTS = 1024
"""Of one iteration, so many improvements are noted one by one."""
_UNLIMITED = 2.0**62
"""Stands for an infinite limit of a counter: it fits into an int64."""


class Candidates(Protocol):
    """Candidate paths of any kind, each with its cost."""

    @property
    def cost(self) -> Floats:
        """(n,) the cost of each."""


@dataclass(frozen=True, kw_only=True)
class Run(ABC):
    """The state of one run: what is sought and the population are in subclasses.

    Attributes
    ----------
    workspace
        Working memory, the effort so far and its limits.
    rng
        The source of all random numbers.
    best
        One path: the best so far.
    memory
        What `Metaheuristic.begin` returned: whatever a method remembers from step to step besides paths.
    """

    workspace: Workspace
    rng: np.random.Generator
    best: Candidates
    memory: object = None

    @property
    def lowest_cost(self) -> float:
        """The cost of the best path so far."""
        return float(self.best.cost[0])

    @abstractmethod
    def result(self, problem: Problem, record: SearchRecord) -> Result:
        """Return the result that holds the best path."""


@dataclass(frozen=True, kw_only=True)
class LatticeRun(Run):
    """A run whose candidates are lattice paths.

    Attributes
    ----------
    task
        What is sought.
    paths
        The population.
    given
        (n, 3) metres each: paths with which the first population begins.
    """

    task: LatticeTask
    paths: Paths
    best: Paths
    given: tuple[Floats, ...] = ()

    def result(self, problem: Problem, record: SearchRecord) -> Result:
        """Return the result that holds the best path.

        Its cost is without what contact with movers costs, and so is the last of its history.
        """
        result = lattice_result(problem, self.best.nodes[0, : self.best.length[0]].copy(), record)
        if not len(self.task.contact.shapes.kind):
            return result
        history = replace(result.history, cost=result.history.cost + (result.cost - self.lowest_cost))
        return replace(result, history=history)


def lattice_run(
    problem: Problem, task: LatticeTask, population: int, capacity: int, stop: Stop, rng: np.random.Generator
) -> LatticeRun:
    """Return a run with memory for so many candidates, none of which is there yet, of at most `capacity` nodes each."""
    workspace = make_workspace(stop, len(problem.airspace.grid.exits), capacity)
    paths, best = _no_paths(population, capacity), _no_paths(1, capacity)
    return LatticeRun(workspace=workspace, rng=rng, task=task, paths=paths, best=best)


def make_workspace(stop: Stop, nodes: int = 0, capacity: int = 0) -> Workspace:
    """Return the working memory of a run: for a lattice of so many nodes, and drafts of at most `capacity` nodes."""
    limits = [min(stop.limit(name), _UNLIMITED) for name in ("generated_paths", "generated_nodes", "evaluations")]
    return Workspace(
        mark=np.zeros(nodes, np.uint8),
        stamp=np.zeros(1, np.int64),
        position=np.empty(nodes, np.int32),
        draft=np.empty(capacity, np.int64),
        legs=flown_legs(capacity + 2),
        spent=np.zeros(3, np.int64),
        limit=np.array(limits).astype(np.int64),
        improved=np.empty((_IMPROVEMENTS, 4)),
        improvements=np.zeros(1, np.int64),
    )


def taken_improvements(workspace: Workspace) -> list[tuple[float, int, int, int]]:
    """Return and forget the costs of new best paths, each with the paths, nodes and evaluations when it was found."""
    count = min(int(workspace.improvements[0]), len(workspace.improved))
    workspace.improvements[0] = 0
    return [(price, int(a), int(b), int(c)) for price, a, b, c in workspace.improved[:count].tolist()]


def _no_paths(count: int, capacity: int) -> Paths:
    return Paths(np.empty((count, capacity), np.int64), np.zeros(count, np.int64), np.full(count, math.inf))


R = TypeVar("R", bound=Run)


@dataclass(frozen=True, kw_only=True)
class Metaheuristic(Planner, Generic[R]):
    """A search that improves its candidates iteration by iteration until a stop rule is met.

    This class is the loop: it times, counts, keeps the history, reports progress and stops. A method on lattice paths
    is a subclass of `LatticeSearch`, one on waypoints of `WaypointSearch`. A search that leaves the lattice replaces
    `open_run`.
    """

    @property
    @abstractmethod
    def population(self) -> int:
        """How many candidates are kept."""

    @abstractmethod
    def begin(self, run: R) -> object:
        """Make the first population; the loop hands the returned object to `step` as ``run.memory``."""

    @abstractmethod
    def step(self, run: R, spent: float) -> None:
        """Do one iteration; `spent` is l/L, the share of the budget that is spent when the iteration ends."""

    @abstractmethod
    def longest(self, grid: Grid) -> int:
        """Return how many nodes a path under construction may have."""

    def task(self, problem: Problem) -> LatticeTask:
        """Return what is sought on the lattice."""
        airspace = problem.airspace
        return LatticeTask(airspace.grid, airspace.pricing, contact_of(problem), problem.source, problem.goal)

    def plan(
        self, problem: Problem, *, stop: Stop | None = None, rng: Seed = None, on_iteration: OnIteration | None = None
    ) -> Result:
        """Plan one UAV's path; see `Planner.plan`.

        Without `stop` a run takes 40 iterations, which is the thesis's longer case.

        Raises
        ------
        InputError
            If no counted rule stops the run: schedules follow counted budgets, never a clock.
        """
        return self.search(problem, (), stop, rng, on_iteration)[0]

    def search(
        self,
        problem: Problem,
        given: Sequence[Floats],
        stop: Stop | None,
        rng: Seed,
        on_iteration: OnIteration | None,
    ) -> tuple[Result, R | None]:
        """Run the loop; see `plan`.

        Parameters
        ----------
        given
            (n, 3) metres each: paths with which the first population begins; only a `LatticeSearch` takes any.

        Returns
        -------
        tuple
            The result, and the run as it ended; ``None`` where there was nothing to search.
        """
        require_problem(problem, stop)
        stop = MaxIterations(40) if stop is None else stop
        if stop.spent(Progress()) is None:
            raise InputError(
                f"{stop!r} counts nothing, but {type(self).__name__}'s schedules follow a counted budget; "
                f"combine them, as in MaxIterations(1000) | {stop!r}"
            )
        generator, seed = seeded(rng)
        begun = f", begun with {counted(len(given), 'path')}" if len(given) else ""
        origin = provenance(f"{self!r}{begun}", stop, seed)
        run = self.open_run(problem, stop, generator, origin)
        if isinstance(run, Result):
            return run, None
        if isinstance(run, LatticeRun):
            run = cast("R", replace(run, given=tuple(given)))
        clock = Stopwatch()
        rows = []
        iterations = 0
        run = replace(run, memory=self.begin(run))
        while True:
            paths, nodes, evaluations = run.workspace.spent.tolist()
            rows += [(*row, iterations) for row in taken_improvements(run.workspace)]
            rows.append((run.lowest_cost, paths, nodes, evaluations, iterations))
            progress = Progress(iterations, paths, nodes, evaluations, clock.seconds, run.lowest_cost)
            if on_iteration is not None and iterations:
                on_iteration(progress)
            ended = stop.met(progress)
            if ended is not None:
                break
            iterations += 1
            share = stop.spent(Progress(iterations, paths, nodes, evaluations, progress.seconds, progress.cost))
            self.step(run, share if share is not None else 0.0)
        seconds = clock.seconds
        history = History(*(np.array(column) for column in zip(*rows, strict=True)))
        record = SearchRecord(origin, Effort(paths, nodes, evaluations), seconds, history, ended)
        return run.result(problem, record), run

    def open_run(self, problem: Problem, stop: Stop, rng: np.random.Generator, origin: Provenance) -> R | Result:
        """Return a run without candidates, or the result where there is nothing to search."""
        if problem.refusal is not None:
            return refused_result(problem, problem.refusal, origin)
        if problem.route is None:
            return refused_result(problem, Status.NO_PATH, origin)
        if problem.source == problem.goal:  # such a path generates no nodes, so that MaxNodes would never end the run
            return lattice_result(problem, problem.route.nodes, SearchRecord(origin))
        capacity = self.longest(problem.airspace.grid)
        return cast("R", lattice_run(problem, self.task(problem), self.population, capacity, stop, rng))
