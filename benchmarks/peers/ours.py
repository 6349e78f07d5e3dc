"""Planners of skyverse that end by themselves: each is called once to load its kernels, and then timed."""

import statistics
import time
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
    results, seconds = [], []
    for _ in range(RUNS):
        began = time.process_time()
        results.append(planner.plan(problem))
        seconds.append(time.process_time() - began)
    path = results[0].path if results[0].any_angle else between_ends(problem, results[0].path)
    better(statistics.median(seconds), length(path))
    return path, {"set_up": set_up, "any_angle": results[0].any_angle}


def _contender(planner: sky.Planner, change: Callable[[sky.Scenario], sky.Scenario] = lambda s: s) -> dict[str, Any]:
    return {"kind": "ours", "run": partial(exact, planner, change)}


CONTENDERS = {
    "Taut": _contender(sky.Taut()),
    "Theta*": _contender(sky.ThetaStar()),
    "A*, 26-connected": _contender(sky.AStar(), partial(on_lattice, connectivity=26)),
    "A*, 6-connected": _contender(sky.AStar(), partial(on_lattice, connectivity=6)),
}
