"""Taut on the maps and in cities of growing size, and many queries at once: ``python benchmarks/any_angle.py``."""

import math
import statistics
import time

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.numerics.cores import cores

REFERENCES = {
    ("map1", 0.25): 22.4106,
    ("map2", 0.25): 26.5205,
    ("map3", 0.25): 22.6379,
    ("map1", 0.0): 22.0181,
    ("map2", 0.0): 23.8601,
    ("map3", 0.0): 22.0762,
}
"""Near-exact lengths found elsewhere, metres."""


def maps() -> None:
    """Print length, reference, proven gap and time on the maps."""
    rows = []
    for (name, clearance), reference in REFERENCES.items():
        problem = sky.Problem(sky.read(name).model_copy(update={"clearance": clearance}))
        results = [sky.Taut().plan(problem) for _ in range(52)][1:]
        times = [result.seconds * 1e3 for result in results]
        length, gap = results[0].cost, results[0].gap
        more = sky.Taut(proof=20_000).plan(problem)
        rows.append(
            [
                name,
                f"{clearance:g} m",
                f"{length:.4f} m",
                f"{reference:.4f} m",
                f"{length / reference - 1:+.1e}",
                f"{statistics.median(times):.1f} ms",
                f"{gap:.2%}",
                f"{more.gap:.2%} ({more.seconds:.2f} s)",
            ]
        )
    head = ["map", "clearance", "length", "reference", "difference", "median", "proven gap", "with proof=20000"]
    table(head, rows)


def cities() -> None:
    """Print length, time, and what the index costs, in cities of growing size."""
    rows = []
    for buildings in (500, 2000, 8000, 20_000):
        times, gaps, built, ends = [], [], [], []
        for seed in range(5):
            city = sky.random_city(buildings, seed=seed)
            began = time.perf_counter()
            airspace = sky.Airspace(city)
            problem = sky.Problem(airspace)
            sky.Taut().plan(sky.Problem(sky.random_city(20, seed=1)))  # compiled before, so that the clock sees none
            _ = airspace.cells, airspace.edges
            built.append(time.perf_counter() - began)
            results = [sky.Taut().plan(problem) for _ in range(3)]
            times.append(statistics.median(result.seconds for result in results))
            gaps.append(results[0].cost / math.dist(problem.start, problem.end) - 1)
            ends.append(len(sky.check_result(city, 0, 0, results[0])))
        per = statistics.median(times) / (buildings * math.log(buildings))
        rows.append(
            [
                f"{buildings:,}",
                f"{statistics.median(gaps):.2%} ({max(gaps):.2%})",
                f"{statistics.median(times) * 1e3:.0f} ms",
                f"{max(times) * 1e3:.0f} ms",
                f"{per * 1e6:.2f} us",
                f"{statistics.median(built):.2f} s",
                f"{sum(ends)}",
            ]
        )
    head = ["buildings", "above the straight line (most)", "median query", "slowest", "per n ln n", "built once"]
    table([*head, "faults"], rows)


def many() -> None:
    """Print how long a thousand queries take in the city of 2,000 buildings.

    The processor's time tells whether threads hinder each other: it is the same for any number of them unless they do.
    """
    city = sky.random_city(2000, seed=0, uavs=1000)
    rng = np.random.default_rng(0)
    pairs = list(zip(range(1000), rng.permutation(1000).tolist(), strict=True))
    rows = []
    for workers in sorted({1, cores()}):
        airspace = sky.Airspace(city)
        began, worked = time.perf_counter(), time.process_time()
        results = sky.plan_many(airspace, sky.Taut(), pairs, workers=workers)
        seconds, work = time.perf_counter() - began, time.process_time() - worked
        reached = sum(result.status.reached for result in results)
        faults = sum(len(sky.check_result(city, u, t, r)) for (u, t), r in zip(pairs[:100], results[:100], strict=True))
        rows.append(
            [f"{workers}", "1,000", f"{reached:,}", f"{seconds:.1f} s", f"{work:.1f} s", f"{faults} (of 100 paths)"]
        )
    table(["threads", "queries", "paths", "all", "processor", "faults"], rows)


def ridges() -> None:
    """Print prices under the whole objective over the ridges of Jacksboro, each UAV to its own target, and the time."""
    scenario = sky.jacksboro()
    rows = []
    for uav in range(len(scenario.uavs)):
        problem = sky.Problem(scenario, uav, uav)
        results = [planner.plan(problem) for planner in (sky.AStar(), sky.Taut(proof=0), sky.Cheapest())]
        assert not any(sky.check_result(scenario, uav, uav, result) for result in results)
        times = [sky.Cheapest().plan(problem).seconds for _ in range(5)]
        prices = [f"{result.cost:,.0f}" for result in results]
        rows.append([str(uav + 1), *prices, f"{results[-1].bound:,.0f}", f"{statistics.median(times):.2f} s"])
    table(["UAV", "A* on the lattice", "Taut", "Cheapest", "straight line, a bound", "median of Cheapest"], rows)


if __name__ == "__main__":
    print(f"{describe('scipy')}\n")
    maps()
    ridges()
    cities()
    many()
