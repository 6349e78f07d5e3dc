"""What metaheuristics on lattice paths have in common besides their loop."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from numpy.random import Generator
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import InputError, require_whole
from skyverse.model.result import Result
from skyverse.numerics.kernel import query
from skyverse.planners.base import Seed
from skyverse.planners.kept_paths import checked_paths, kept_paths, nodes_ahead, rejoin
from skyverse.planners.metaheuristic import LatticeRun, Metaheuristic
from skyverse.planners.moves import LatticeTask, Paths, Workspace, adopt, begin_at, exhausted, generate
from skyverse.problem import Problem
from skyverse.space.lattice import Grid
from skyverse.stop import OnIteration, Stop


@dataclass(frozen=True, kw_only=True)
class LatticeSearch(Metaheuristic[LatticeRun]):
    """A population of lattice paths.

    A method is a subclass with `population` and `step`. It also has `begin` if it remembers more than paths from step
    to step, or if it does not start from generated paths.

    Attributes
    ----------
    generator
        ``"goal-directed"`` (the thesis's Algorithm 2) or ``"uniform"`` (Algorithm 1).
    threshold
        N: a walk of Algorithm 2 gives up after so many non-viable steps, one of Algorithm 1 after so many nodes.
    repair_threshold
        The same for walks that change a path.
    retries
        How often a walk to a random node that gives up is replaced by a walk to another node.
    """

    generator: Literal["goal-directed", "uniform"] = "goal-directed"
    threshold: int = 200
    repair_threshold: int = 100
    retries: int = 100

    def __post_init__(self) -> None:
        if self.generator not in ("goal-directed", "uniform"):
            raise InputError(f"generator is 'goal-directed' or 'uniform', not {self.generator!r}")
        for name in ("threshold", "repair_threshold", "retries"):
            require_whole(getattr(self, name), name, 1)

    def begin(self, run: LatticeRun) -> object:
        """Take up the paths that were given, as far as they reach the goal, and generate the rest of the population."""
        task, workspace, count = run.task, run.workspace, 0
        for path in run.given[: len(run.paths.length)]:
            if count and exhausted(workspace):
                break
            length = rejoin(task, workspace, run.rng, nodes_ahead(task.grid, task.source, path))
            if workspace.draft[length - 1] == task.goal:
                adopt(task, workspace, run.paths, count, run.best, length)
                count += 1
        _populate(task, workspace, run.rng, run.paths, run.best, count)
        return None

    def evolve(
        self,
        problem: Problem,
        population: Sequence[ArrayLike] = (),
        *,
        stop: Stop | None = None,
        rng: Seed = None,
        on_iteration: OnIteration | None = None,
    ) -> tuple[Result, tuple[Floats, ...]]:
        """Plan one UAV's path beginning with given paths, and return the population too, for the next time.

        Where a UAV is under way, each path is followed from its node that is nearest to where the UAV is now. The
        generator leads there, past obstacles that are new, and on to the target if that has moved. A path that does
        not get there this way is replaced by a generated one.

        Parameters
        ----------
        problem, stop, rng, on_iteration
            As for `plan`. Work on given paths is counted as any other.
        population
            (n, 3) metres each: paths, the best ones first, such as an earlier call returned; more than the planner
            keeps are left out.

        Returns
        -------
        tuple
            The result, and the paths that were kept at the end, the best one first, then the others by their cost,
            (n, 3) metres each, none twice. There are none where there was nothing to search.

        Raises
        ------
        InputError
            If a path is no such array, or no counted rule stops the run.
        """
        result, run = self.search(problem, checked_paths(population), stop, rng, on_iteration)
        return result, () if run is None else kept_paths(run.task.grid, run.paths, run.best)

    def longest(self, grid: Grid) -> int:
        """Return how many nodes a path under construction may have: as many as four walks."""
        walk = int(grid.shape.sum()) + 2 * max(self.threshold, self.repair_threshold) + 2
        return min(4 * walk, 2 * len(grid.exits) + 2)

    def task(self, problem: Problem) -> LatticeTask:
        """Return what is sought, and how paths are generated."""
        task = super().task(problem)._replace(directed=self.generator == "goal-directed", threshold=self.threshold)
        return task._replace(repair_threshold=self.repair_threshold, retries=self.retries)


@query
def _populate(task: LatticeTask, workspace: Workspace, rng: Generator, paths: Paths, best: Paths, first: int) -> None:
    for i in range(first, len(paths.length)):
        if i and exhausted(workspace):
            return  # the run ends before the missing paths are used
        length = generate(task, workspace, rng, begin_at(workspace, task.source), task.goal, task.threshold)
        adopt(task, workspace, paths, i, best, length)
