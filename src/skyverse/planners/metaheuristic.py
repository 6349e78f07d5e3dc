"""The one loop that every metaheuristic runs in."""

import dataclasses
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar, cast

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.result import Effort, History, Provenance, Result, Status
from skyverse.model.short_lines import counted
from skyverse.numerics.kernel import Stopwatch
from skyverse.planners.base import Planner, Seed, provenance, require_problem, seeded
from skyverse.planners.contact import contact_of
from skyverse.planners.moves import LatticeTask
from skyverse.planners.results import SearchRecord, lattice_result, refused_result
from skyverse.planners.run import LatticeRun, Run, lattice_run, taken_improvements
from skyverse.problem import Problem
from skyverse.space.lattice import Grid
from skyverse.stop import MaxIterations, OnIteration, Progress, Stop

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
            run = cast("R", dataclasses.replace(run, given=tuple(given)))
        clock = Stopwatch()
        rows = []
        iterations = 0
        run = dataclasses.replace(run, memory=self.begin(run))
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
