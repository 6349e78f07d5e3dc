"""Metaheuristics on lattice paths: what they have in common besides their loop."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from skyverse.numerics.kernel import kernel
from skyverse.planners.base import Metaheuristic, Run, require
from skyverse.planners.moves import Desk, Paths, Task, adopt, begin_at, exhausted, generate
from skyverse.problem import Problem
from skyverse.space.lattice import Grid


@dataclass(frozen=True, kw_only=True)
class LatticeSearch(Metaheuristic):
    """A population of lattice paths.

    A method is a subclass with `population` and `step`, and `begin` if it remembers more than paths from step to
    step, or does not start from generated ones.

    Attributes
    ----------
    generator
        ``"goal-directed"`` (the thesis's Algorithm 2) or ``"uniform"`` (Algorithm 1).
    threshold
        N: a walk gives up after so many non-viable steps; Algorithm 1 after so many nodes.
    repair_threshold
        The same for the walks that change a path.
    retries
        How often a walk to a drawn point is tried again, with another point, when it gives up.
    """

    generator: Literal["goal-directed", "uniform"] = "goal-directed"
    threshold: int = 200
    repair_threshold: int = 100
    retries: int = 100

    def __post_init__(self) -> None:
        if self.generator not in ("goal-directed", "uniform"):
            raise ValueError(f"generator is 'goal-directed' or 'uniform', not {self.generator!r}")
        for name in ("threshold", "repair_threshold", "retries"):
            require(self, name, 1)

    def begin(self, run: Run) -> object:
        """Generate the first population."""
        _populate(run.task, run.desk, run.rng, run.paths, run.best)
        return None

    def longest(self, grid: Grid) -> int:
        """Return how many nodes a path under construction may have: those of four walks."""
        walk = int(grid.shape.sum()) + 2 * max(self.threshold, self.repair_threshold) + 2
        return min(4 * walk, 2 * len(grid.exits) + 2)

    def task(self, problem: Problem) -> Task:
        """Return what is sought, and how paths are generated."""
        return super().task(problem)._replace(directed=self.generator == "goal-directed", threshold=self.threshold)


@kernel
def _populate(task: Task, desk: Desk, rng: np.random.Generator, paths: Paths, best: Paths) -> None:
    for i in range(len(paths.length)):
        if i and exhausted(desk):
            return  # the run ends before anybody looks at the paths that are missing
        length = generate(task, desk, rng, begin_at(desk, task.source), task.goal, task.threshold)
        adopt(task, desk, paths, i, best, length)
