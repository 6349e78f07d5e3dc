"""Memoryless random restart: the baseline that a metaheuristic has to beat at equal effort."""

from dataclasses import dataclass

from numpy.random import Generator

from skyverse.errors import require_whole
from skyverse.numerics.kernel import kernel
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.metaheuristic import LatticeRun
from skyverse.planners.moves import (
    LatticeTask,
    Paths,
    Workspace,
    begin_at,
    cut_loops,
    detour,
    exhausted,
    generate,
    judge,
    keep_if_best,
)


@dataclass(frozen=True, kw_only=True)
class RandomRestart(LatticeSearch):
    """Walk from the start through one random free node to the goal, again and again, and keep the best path.

    Attributes
    ----------
    samples
        How many paths an iteration generates, so that iterations compare with those of a population.
    """

    samples: int = 25

    def __post_init__(self) -> None:
        super().__post_init__()
        require_whole(self.samples, "samples", 1)

    @property
    def population(self) -> int:
        """One path is kept."""
        return 1

    def step(self, run: LatticeRun, spent: float) -> None:
        """Generate `samples` paths."""
        _sample(run.task, run.workspace, run.best, run.rng, self.samples)


@kernel
def _sample(task: LatticeTask, workspace: Workspace, best: Paths, rng: Generator, samples: int) -> None:
    for _ in range(samples):
        if exhausted(workspace):
            return
        length = detour(task, workspace, rng, begin_at(workspace, task.source), task.repair_threshold, task.retries)
        length = cut_loops(workspace, 0, generate(task, workspace, rng, length, task.goal, task.repair_threshold))
        keep_if_best(workspace, best, length, judge(task, workspace, length))
