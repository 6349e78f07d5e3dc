"""Planners of skyverse that end by themselves: each is called once to load its kernels, and then timed."""

import statistics
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from problems import between_ends, length, on_lattice

import skyverse as sky
from skyverse.numerics.kernel import Stopwatch

RUNS = 5


def exact(
    planner: sky.Planner, change: Callable[[sky.Scenario], sky.Scenario], scenario: sky.Scenario, *rest: Any
) -> tuple[np.ndarray, dict[str, Any]]:
    better = rest[-1]
    changed = change(scenario)
    planner.plan(sky.Problem(changed))
    clock = Stopwatch()
    problem = sky.Problem(changed)
    set_up = -planner.plan(problem).seconds + clock.seconds
    results = [planner.plan(problem) for _ in range(RUNS)]
    path = results[0].path if results[0].any_angle else between_ends(problem, results[0].path)
    better(statistics.median(result.seconds for result in results), length(path))
    return path, {"set_up": set_up, "any_angle": results[0].any_angle}


def _contender(planner: sky.Planner, change: Callable[[sky.Scenario], sky.Scenario] = lambda s: s) -> dict[str, Any]:
    return {"kind": "ours", "run": partial(exact, planner, change)}


CONTENDERS = {
    "Taut": _contender(sky.Taut()),
    "Theta*": _contender(sky.ThetaStar()),
    "A*, 26-connected": _contender(sky.AStar(), partial(on_lattice, connectivity=26)),
    "A*, 6-connected": _contender(sky.AStar(), partial(on_lattice, connectivity=6)),
}
