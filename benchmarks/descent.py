"""The default planner beside a plain random descent: ``python benchmarks/descent.py [SECONDS [SCENARIO]]``.

For each UAV of a scenario, jacksboro by default, and the target of the same number, paths descend from the lattice's
cheapest path, shortened, for 60 seconds: a bend is moved, added or left out at random, or two neighbours are moved
alike, and what is free and no dearer is kept. The descent shares prices of legs and free segments with the planners,
and nothing else.
"""

import statistics
import sys
import time

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse import cost
from skyverse._typing import Floats
from skyverse.planners.straight_legs import joined_to_ends
from skyverse.space.world import path_free

LARGEST, SMALLEST = 0.1, 1e-5
"""Sizes of changes, as shares of the straight line's length; their logarithms are uniformly distributed."""


def changed(path: Floats, metres: float, rng: np.random.Generator) -> Floats:
    """Return a path with one random change of its bends, whose size in each direction is about so many metres."""
    last = len(path) - 1
    move = rng.normal(0.0, metres, 3) * (1.0, 1.0, rng.choice((0.1, 1.0)))
    kind = rng.integers(4) if last > 1 else 0
    if kind == 0:
        k = int(rng.integers(1, last + 1))
        place = path[k - 1] + rng.random() * (path[k] - path[k - 1]) + move
        return np.insert(path, k, place, axis=0)
    k = int(rng.integers(1, last))
    if kind == 1:
        return np.delete(path, k, axis=0)
    moved = path.copy()
    moved[k : k + int(kind)][: last - k] += move
    return moved


def descended(problem: sky.Problem, seconds: float, seed: int) -> float:
    """Return the price of the best path after so many seconds of descent."""
    space, rates, rng = problem.airspace.world.space, problem.airspace.rates, np.random.default_rng(seed)
    path = joined_to_ends(problem, sky.AStar().plan(problem).path)
    best = float(cost.legs(rates, path, problem.end).sum())
    size = float(np.linalg.norm(problem.end - problem.start))
    until = time.perf_counter() + seconds
    while time.perf_counter() < until:
        metres = size * LARGEST * (SMALLEST / LARGEST) ** rng.random()
        tried = changed(path, metres, rng)
        price = float(cost.legs(rates, tried, problem.end).sum())
        if price <= best and path_free(space, tried):
            path, best = tried, price
    return best


def main() -> None:
    """Print the table."""
    seconds, name = float((sys.argv[1:] or ["60"])[0]), (sys.argv[2:] or ["jacksboro"])[0]
    print(f"{describe()}\n\n{name}, descents of {seconds:g} s\n")
    scenario = sky.read(name)
    assert isinstance(scenario, sky.Scenario)
    airspace = sky.Airspace(scenario)
    sky.Auto().plan(sky.Problem(airspace, 0, 0))  # compiles
    rows = []
    for uav, spec in enumerate(scenario.uavs[: len(scenario.targets)]):
        problem = sky.Problem(airspace, uav, uav)
        runs = [sky.Auto().plan(problem) for _ in range(5)]
        best, took = runs[0], statistics.median(run.seconds for run in runs)
        assert best.bound is not None
        assert sky.check_result(scenario, uav, uav, best) == []
        lattice, descent = sky.AStar().plan(problem).cost, descended(problem, seconds, uav)
        prices = [f"{price:,.1f}" for price in (best.cost, descent, lattice, best.bound)]
        rows.append([spec.name, *prices, f"{best.cost / descent:.4f}", f"{took:.2f} s"])
    table(["UAV", "default", "descent", "A*", "proven bound", "default / descent", "time"], rows)


if __name__ == "__main__":
    main()
