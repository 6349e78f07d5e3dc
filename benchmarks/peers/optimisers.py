"""Metaheuristics, ours and those of other packages: all in skyverse's loop, on waypoints joined by straight legs."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from contenders import MANY
from problems import between_ends, compiled, on_lattice

import skyverse as sky

TRIAL = 0.5
"""Seconds of the preceding run that loads the kernels and measures the number of candidates per second."""

COMPLETE = 1e5
"""Metres: longer than any complete path. A larger cost is that of a path which ends short of the target."""


def search(
    make: Callable[[], sky.Planner],
    change: Callable[[sky.Scenario], sky.Scenario],
    scenario: sky.Scenario,
    seed: int,
    seconds: float,
    better: Callable[..., None],
) -> tuple[np.ndarray | None, dict[str, Any]]:
    """Run one for some processor seconds, the paths that fit into them at the trial's pace; schedules follow these."""
    planner = make()
    problem, set_up = compiled(change(scenario))
    planner.plan(problem, stop=sky.MaxIterations(1), rng=seed)
    began = time.process_time()
    trial = planner.plan(problem, stop=sky.MaxPaths(10**9) | sky.MaxSeconds(TRIAL), rng=seed)
    most = max(100, int(trial.effort.generated_paths * seconds / (time.process_time() - began)))
    best = [COMPLETE]

    def watch(progress: sky.Progress) -> None:
        if progress.cost < best[0] * (1 - 1e-9):
            best[0] = progress.cost
            better(time.process_time() - began, progress.cost)

    began = time.process_time()
    result = planner.plan(problem, stop=sky.MaxPaths(most), rng=seed, on_iteration=watch)
    facts = {"set_up": set_up, "any_angle": result.any_angle, "evaluations": result.effort.evaluations}
    if not result.status.reached:
        return None, facts
    return result.path if result.any_angle else between_ends(problem, result.path), facts


def _hybrid() -> sky.Planner:
    return sky.HybridMVO()


def _on_waypoints(name: str) -> sky.Planner:
    return getattr(sky, name)(legs="straight")


def _on_26(scenario: sky.Scenario) -> sky.Scenario:
    return on_lattice(scenario, 26)


CONTENDERS = {
    "HybridMVO": {"kind": "ours", "run": partial(search, _hybrid, _on_26), "maps": MANY, "cities": MANY},
    "CMA-ES (cma)": {
        "kind": "optimiser",
        "run": partial(search, partial(_on_waypoints, "CMAES"), lambda scenario: scenario),
        "maps": MANY,
        "cities": MANY,
        "needs": "cma",
    },
    "DE (pymoo)": {
        "kind": "optimiser",
        "run": partial(search, partial(_on_waypoints, "DE"), lambda scenario: scenario),
        "maps": MANY,
        "cities": MANY,
        "needs": "pymoo",
    },
}
if "HybridMVO" not in dir(sky):
    del CONTENDERS["HybridMVO"]
