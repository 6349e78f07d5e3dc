"""
A planner of your own
=====================

A new metaheuristic is a frozen dataclass with one ``step``; counting, stopping, history and the gap come with it.
"""

# [planner]
from dataclasses import dataclass

import numpy as np

import skyverse as sky
from skyverse import LatticeSearch
from skyverse.numerics.kernel import kernel
from skyverse.planners.metaheuristic import LatticeRun
from skyverse.planners.moves import (
    LatticeTask,
    Paths,
    Workspace,
    copy_in,
    cut_loops,
    detour,
    exhausted,
    generate,
    judge,
    put,
)


@dataclass(frozen=True)
class HillClimb(LatticeSearch):
    """Keep one path; redraw its rest from a random node on, through a random point; take what is cheaper."""

    tries: int = 25

    @property
    def population(self) -> int:
        """One path."""
        return 1

    def step(self, run: LatticeRun, spent: float) -> None:
        """Do one iteration."""
        climb(run.task, run.workspace, run.best, run.rng, self.tries, self.repair_threshold, self.retries)


@kernel
def climb(
    task: LatticeTask,
    workspace: Workspace,
    best: Paths,
    rng: np.random.Generator,
    tries: int,
    threshold: int,
    retries: int,
) -> None:
    """Try to better the best path."""
    for _ in range(tries):
        if exhausted(workspace):
            return
        length = copy_in(workspace, 0, best, 0, 0, 1 + int(rng.random() * best.length[0]))
        length = detour(task, workspace, rng, length, threshold, retries)
        length = cut_loops(workspace, 0, generate(task, workspace, rng, length, task.goal, threshold))
        price = judge(task, workspace, length)
        if price < best.cost[0]:
            put(best, 0, workspace, length, price)


# [end]

# %%
# It is used like any other planner. Does memory help? Against the memoryless baseline, at equal effort:

for name in ("map1", "map2", "map3"):
    problem = sky.Problem(sky.read(name))
    for planner in (HillClimb(), sky.RandomRestart()):
        costs = [planner.plan(problem, stop=sky.MaxPaths(1000), rng=seed).cost for seed in range(20)]
        print(f"{name} {type(planner).__name__:13} mean {sum(costs) / len(costs):.1f}")

# %%
# Not by itself: a single path that takes only what is cheaper gets stuck.
