"""Memoryless random restart: the baseline that every metaheuristic has to beat at equal effort."""

from dataclasses import dataclass

import numpy as np

from skyverse.numerics.kernel import kernel
from skyverse.planners.base import Run, require
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.moves import Desk, Paths, Task, begin_at, cut_loops, detour, exhausted, generate, judge, put


@dataclass(frozen=True, kw_only=True)
class RandomRestart(LatticeSearch):
    """Walk from the start through one random free point to the goal, again and again; keep the best.

    Attributes
    ----------
    samples
        Paths drawn in an iteration, so that iterations compare with those of a population.
    """

    samples: int = 25

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "samples", 1)

    @property
    def population(self) -> int:
        """One path is kept at a time."""
        return 1

    def step(self, run: Run, spent: float) -> None:
        """Draw `samples` paths."""
        _sample(run.task, run.desk, run.best, run.rng, self.samples, self.repair_threshold, self.retries)


@kernel
def _sample(
    task: Task, desk: Desk, best: Paths, rng: np.random.Generator, samples: int, threshold: int, retries: int
) -> None:
    for _ in range(samples):
        if exhausted(desk):
            return
        length = detour(task, desk, rng, begin_at(desk, task.source), threshold, retries)
        length = cut_loops(desk, 0, generate(task, desk, rng, length, task.goal, threshold))
        price = judge(task, desk, length)
        if price < best.cost[0]:
            put(best, 0, desk, length, price)
