"""What every planner is, and the one loop that every metaheuristic runs in."""

import dataclasses
import math
import platform
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse._version import __version__
from skyverse.errors import InputError
from skyverse.model.result import Effort, History, Provenance, Result, Status, no_history
from skyverse.model.scenario import Scenario
from skyverse.numerics.kernel import Stopwatch
from skyverse.planners.moves import Desk, Paths, Task
from skyverse.problem import Problem
from skyverse.space.lattice import Grid
from skyverse.stop import MaxIterations, OnIteration, Progress, Stop

Seed = int | np.random.Generator | None


class Planner(ABC):
    """A planner is its parameters, a frozen dataclass, and one verb."""

    def __new__(cls, *args: Any, **settings: Any) -> Self:
        """Refuse a misspelt setting with the list of those that there are."""
        known = [f.name for f in dataclasses.fields(cls)]  # type: ignore[arg-type]
        unknown = [name for name in settings if name not in known]
        if unknown:
            raise TypeError(
                f"{cls.__name__} has no setting {', '.join(map(repr, unknown))}; it has {', '.join(known) or 'none'}"
            )
        return super().__new__(cls)

    @abstractmethod
    def plan(
        self,
        problem: Problem,
        *,
        stop: Stop | None = None,
        rng: Seed = None,
        on_iteration: OnIteration | None = None,
    ) -> Result:
        """Plan one UAV's path.

        Parameters
        ----------
        problem
            What is sought.
        stop
            When to end; an exact planner ends by itself.
        rng
            Seed or generator; ``None`` draws a seed, which the result's provenance tells.
        on_iteration
            Called with a `Progress` after every iteration.
        """

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether paths have straight legs off the scenario's lattice: then they have no nodes to count."""
        del scenario
        return False


def seeded(rng: Seed) -> tuple[np.random.Generator, int | None]:
    """Return a generator and the seed that makes it again, ``None`` if it was made elsewhere."""
    if isinstance(rng, np.random.Generator):
        return rng, None
    if rng is None:
        rng = int(np.random.SeedSequence().generate_state(1)[0])
    if isinstance(rng, bool) or not isinstance(rng, int | np.integer) or rng < 0:
        raise InputError(f"rng takes None, a whole number from 0 on or a numpy Generator, not {rng!r}")
    return np.random.default_rng(int(rng)), int(rng)


def provenance(planner: str, stop: Stop | None, seed: int | None) -> Provenance:
    """Say what made an answer."""
    machine = f"Python {platform.python_version()}, numpy {np.__version__}, {platform.system()} {platform.machine()}"
    return Provenance(__version__, planner, repr(stop), seed, machine)


def unplanned(problem: Problem, status: Status, origin: Provenance) -> Result:
    """Return the result of a problem that has no path to plan."""
    return Result(
        status=status,
        path=np.empty((0, 3)),
        cost=math.inf,
        terms={},
        bound=None,
        start=problem.start,
        goal=problem.end,
        effort=Effort(),
        seconds=0.0,
        history=no_history(),
        stopped_by="refused",
        provenance=origin,
    )


def planned(
    problem: Problem,
    nodes: Ints,
    effort: Effort,
    seconds: float,
    history: History,
    stopped_by: str,
    origin: Provenance,
) -> Result:
    """Return the result of a path, its terms added up and held against the exact optimum."""
    grid, pricing = problem.airspace.grid, problem.airspace.pricing
    terms = cost.terms_of_nodes(problem.scenario, grid, pricing, nodes, problem.goal)
    price = sum(terms.values())
    bound = None if problem.route is None else problem.route.price
    status = Status.COMPLETE if nodes[-1] == problem.goal else Status.INCOMPLETE
    if status is Status.COMPLETE and bound is not None and price <= bound * (1 + 1e-9):
        status = Status.OPTIMAL
    return Result(
        status=status,
        path=problem.places(nodes),
        cost=price,
        terms=terms,
        bound=bound,
        start=problem.places([problem.source])[0],
        goal=problem.places([problem.goal])[0],
        effort=effort,
        seconds=seconds,
        history=history,
        stopped_by=stopped_by,
        provenance=origin,
    )


def planned_any_angle(
    problem: Problem,
    path: Floats,
    bound: float | None,
    effort: Effort,
    seconds: float,
    history: History,
    stopped_by: str,
    origin: Provenance,
) -> Result:
    """Return the result of a path (n, 3) of straight legs from the UAV's start, held against a proven lower bound."""
    terms = cost.terms_of_legs(problem.scenario, problem.airspace.rates, path, problem.end)
    price = sum(terms.values())
    status = Status.COMPLETE if np.array_equal(path[-1], problem.end) else Status.INCOMPLETE
    if status is Status.COMPLETE and bound is not None and price <= bound * (1 + 1e-9):
        status = Status.OPTIMAL
    return Result(
        status=status,
        path=path,
        cost=price,
        terms=terms,
        bound=bound,
        start=problem.start,
        goal=problem.end,
        effort=effort,
        seconds=seconds,
        history=history,
        stopped_by=stopped_by,
        provenance=origin,
        any_angle=True,
    )


@dataclass(frozen=True)
class Run:
    """One run of a metaheuristic: what is sought, the candidates, the best so far, and where numbers come from.

    Attributes
    ----------
    task
        What is sought: a `Task` on the lattice, a `Course` where legs are straight.
    paths
        The population, `Paths` or `Polylines`.
    best
        One path, the archived best.
    memory
        What `Metaheuristic.begin` returned: whatever a method remembers from step to step besides.
    """

    task: Any
    desk: Desk
    paths: Any
    best: Any
    rng: np.random.Generator
    memory: Any = None


@dataclass(frozen=True, kw_only=True)
class Metaheuristic(Planner):
    """A search that improves iteration by iteration until a stop rule is met.

    The loop is here: it times, counts, remembers the best, keeps the history, reports progress and stops. A method
    on lattice paths is a `LatticeSearch`, one on waypoints a `WaypointSearch`. As it stands it searches the lattice;
    `open_run` and `close_run` are what a search elsewhere replaces.
    """

    @property
    @abstractmethod
    def population(self) -> int:
        """How many candidates are kept."""

    @abstractmethod
    def begin(self, run: Run) -> object:
        """Make the first population; what is returned is found again as ``run.memory``."""

    @abstractmethod
    def step(self, run: Run, spent: float) -> None:
        """Do one iteration; `spent` is the share of the budget that is spent when it ends, l/L."""

    @abstractmethod
    def longest(self, grid: Grid) -> int:
        """Return how many nodes a path under construction may have."""

    def task(self, problem: Problem) -> Task:
        """Return what is sought."""
        return Task(problem.airspace.grid, problem.airspace.pricing, problem.source, problem.goal)

    def plan(
        self,
        problem: Problem,
        *,
        stop: Stop | None = None,
        rng: Seed = None,
        on_iteration: OnIteration | None = None,
    ) -> Result:
        """Plan one UAV's path; see `Planner.plan`.

        Without `stop` a run takes 40 iterations, the thesis's longer case.

        Raises
        ------
        InputError
            If no counted rule stops the run: schedules follow counted budgets, never a clock.
        """
        stop = MaxIterations(40) if stop is None else stop
        if stop.spent(Progress()) is None:
            raise InputError(
                f"{stop!r} counts nothing, but {type(self).__name__}'s schedules follow a counted budget; "
                f"combine them, as in MaxIterations(1000) | {stop!r}"
            )
        generator, seed = seeded(rng)
        origin = provenance(repr(self), stop, seed)
        run = self.open_run(problem, stop, generator, origin)
        if isinstance(run, Result):
            return run
        clock = Stopwatch()
        rows = []
        iterations = 0
        run = dataclasses.replace(run, memory=self.begin(run))
        while True:
            found = float(run.best.cost[0])
            paths, nodes, evaluations = run.desk.spent.tolist()
            rows.append((found, paths, nodes, evaluations))
            progress = Progress(iterations, paths, nodes, evaluations, clock.seconds, found)
            if on_iteration is not None and iterations:
                on_iteration(progress)
            ended = stop.met(progress)
            if ended is not None:
                break
            iterations += 1
            share = stop.spent(Progress(iterations, paths, nodes, evaluations, progress.seconds, found))
            self.step(run, share if share is not None else 0.0)
        seconds = clock.seconds
        effort = Effort(*(int(n) for n in run.desk.spent))
        return self.close_run(problem, run, effort, seconds, _history(rows), ended, origin)

    def open_run(self, problem: Problem, stop: Stop, rng: np.random.Generator, origin: Provenance) -> Run | Result:
        """Lay out what a run needs, or return the result where there is nothing to search."""
        if problem.refusal is not None:
            return unplanned(problem, problem.refusal, origin)
        if problem.route is None:
            return unplanned(problem, Status.NO_PATH, origin)
        if problem.source == problem.goal:  # a budget of nodes would never be spent
            return planned(problem, problem.route.nodes, Effort(), 0.0, no_history(), "finished", origin)
        return self._open(problem, stop, rng)

    def _open(self, problem: Problem, stop: Stop, rng: np.random.Generator) -> Run:
        grid = problem.airspace.grid
        capacity = self.longest(grid)
        desk = make_desk(stop, len(grid.exits), capacity)
        return Run(self.task(problem), desk, _no_paths(self.population, capacity), _no_paths(1, capacity), rng)

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
        path = run.best.nodes[0, : run.best.length[0]].copy()
        return planned(problem, path, effort, seconds, history, stopped_by, origin)


def make_desk(stop: Stop, nodes: int = 0, capacity: int = 0) -> Desk:
    """Return the working memory of a run: for a lattice of so many nodes, and drafts of so many."""
    limits = [min(stop.limit(name), 2.0**62) for name in ("generated_paths", "generated_nodes", "evaluations")]
    return Desk(
        mark=np.zeros(nodes, np.uint8),
        stamp=np.zeros(1, np.int64),
        place=np.zeros(nodes, np.int32),
        draft=np.empty(capacity, np.int64),
        spent=np.zeros(3, np.int64),
        limit=np.array(limits).astype(np.int64),
    )


def require(settings: object, name: str, least: float) -> None:
    """Refuse a setting that is no whole number, or below the least."""
    value = getattr(settings, name)
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ValueError(f"{type(settings).__name__}'s {name} is a whole number from {least:g} on, not {value!r}")


def require_between(settings: object, name: str, least: float, most: float) -> None:
    """Refuse a setting that is no number, or not within these limits."""
    value = getattr(settings, name)
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not number or not least <= value <= most:
        raise ValueError(f"{type(settings).__name__}'s {name} is a number from {least:g} to {most:g}, not {value!r}")


def _no_paths(count: int, capacity: int) -> Paths:
    return Paths(np.empty((count, capacity), np.int64), np.zeros(count, np.int64), np.full(count, math.inf))


def _history(rows: Sequence[tuple[float, ...]]) -> History:
    cost_, paths, nodes, evaluations = (np.array(column) for column in zip(*rows, strict=True))
    return History(cost_, paths, nodes, evaluations)
