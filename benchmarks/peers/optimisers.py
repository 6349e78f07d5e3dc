"""Metaheuristics, ours and those of other packages: all in skyverse's loop, on waypoints joined by straight legs."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
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
    """Run one for some seconds; its schedules follow a counted budget, what fits into them at the trial's pace."""
    planner = make()
    problem, set_up = compiled(change(scenario))
    planner.plan(problem, stop=sky.MaxIterations(1), rng=seed)
    trial = planner.plan(problem, stop=sky.MaxPaths(10**9) | sky.MaxSeconds(TRIAL), rng=seed)
    most = max(100, int(trial.effort.generated_paths * seconds / trial.seconds))
    best = [COMPLETE]

    def watch(progress: sky.Progress) -> None:
        if progress.cost < best[0] * (1 - 1e-9):
            best[0] = progress.cost
            better(progress.seconds, progress.cost)

    stop = sky.MaxPaths(most) | sky.MaxSeconds(seconds)
    result = planner.plan(problem, stop=stop, rng=seed, on_iteration=watch)
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
    "HybridMVO": {"kind": "ours", "run": partial(search, _hybrid, _on_26), "maps": 2},
    "CMA-ES (cma)": {
        "kind": "optimiser",
        "run": partial(search, partial(_on_waypoints, "CMAES"), lambda scenario: scenario),
        "needs": "cma",
    },
    "DE (pymoo)": {
        "kind": "optimiser",
        "run": partial(search, partial(_on_waypoints, "DE"), lambda scenario: scenario),
        "needs": "pymoo",
    },
}
if "HybridMVO" not in dir(sky):
    del CONTENDERS["HybridMVO"]
