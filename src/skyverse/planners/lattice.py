"""What metaheuristics on lattice paths have in common besides their loop."""

from dataclasses import dataclass
from typing import Literal

from numpy.random import Generator

from skyverse.numerics.kernel import query
from skyverse.planners.metaheuristic import Metaheuristic
from skyverse.planners.moves import LatticeTask, Paths, Workspace, adopt, begin_at, exhausted, generate
from skyverse.planners.run import LatticeRun
from skyverse.planners.settings import require_integer
from skyverse.problem import Problem
from skyverse.space.lattice import Grid


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
            raise ValueError(f"generator is 'goal-directed' or 'uniform', not {self.generator!r}")
        for name in ("threshold", "repair_threshold", "retries"):
            require_integer(self, name, 1)

    def begin(self, run: LatticeRun) -> object:
        """Generate the first population."""
        _populate(run.task, run.workspace, run.rng, run.paths, run.best)
        return None

    def longest(self, grid: Grid) -> int:
        """Return how many nodes a path under construction may have: as many as four walks."""
        walk = int(grid.shape.sum()) + 2 * max(self.threshold, self.repair_threshold) + 2
        return min(4 * walk, 2 * len(grid.exits) + 2)

    def task(self, problem: Problem) -> LatticeTask:
        """Return what is sought, and how paths are generated."""
        task = super().task(problem)._replace(directed=self.generator == "goal-directed", threshold=self.threshold)
        return task._replace(repair_threshold=self.repair_threshold, retries=self.retries)


@query
def _populate(task: LatticeTask, workspace: Workspace, rng: Generator, paths: Paths, best: Paths) -> None:
    for i in range(len(paths.length)):
        if i and exhausted(workspace):
            return  # the run ends before the missing paths are used
        length = generate(task, workspace, rng, begin_at(workspace, task.source), task.goal, task.threshold)
        adopt(task, workspace, paths, i, best, length)
