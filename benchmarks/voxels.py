"""All 10,000 problems of a MovingAI 3-D benchmark against their published optima: ``python benchmarks/voxels.py DIR``.

DIR contains Simple.3dmap and Simple.3dmap.3dscen. The optima are 26-connected, without cutting corners. First the exact
search, then Theta*, whose any-angle paths should be no longer than the optima.
"""

import math
import statistics
import sys
import time
from pathlib import Path

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.search.lattice_astar import shortest_route
from skyverse.space.lattice import Grid

ROUNDED = 1e-7
"""The published optima have eight decimals; relative."""


def airspace(path: Path) -> sky.Airspace:
    """Compile a .3dmap: each of its blocked voxels is a box around a lattice node."""
    head, *lines = path.read_text().splitlines()
    size = [int(word) for word in head.split()[1:]]
    blocked = [[int(word) for word in line.split()] for line in lines]
    return sky.Airspace(
        sky.Scenario(
            name=path.stem,
            bounds=sky.Bounds(min=(0, 0, 0), max=tuple(n - 1 for n in size)),
            obstacles=tuple(sky.Box(min=[v - 0.5 for v in b], max=[v + 0.5 for v in b]) for b in blocked),
            clearance=0,
            lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
            objective=sky.Objective(unit="metres"),
        )
    )


def node(grid: Grid, voxel: list[str]) -> int:
    """Return the node number of a voxel."""
    return int(np.ravel_multi_index([int(v) for v in voxel], tuple(grid.shape)))


def exact(space: sky.Airspace, problems: list[list[str]]) -> None:
    times, worst = [], 0.0
    for words in problems:
        source, goal = node(space.grid, words[:3]), node(space.grid, words[3:6])
        began = time.perf_counter()
        route = shortest_route(space.grid, space.pricing, source, goal)
        times.append(time.perf_counter() - began)
        worst = max(worst, abs(route.price / float(words[6]) - 1))
    head = ["problems", "largest deviation from the published optimum", "mean", "median", "slowest"]
    table(head, [[f"{len(problems):,}", f"{worst:.1e} (relative)", *_milliseconds(times)]])


def any_angle(space: sky.Airspace, problems: list[list[str]]) -> None:
    times, ratios, stretches = [], [], []
    starts, ends = ([tuple(float(word) for word in words[i : i + 3]) for words in problems] for i in (0, 3))
    uavs, targets = tuple(sky.UAV(start=p) for p in starts), tuple(sky.Target(position=p) for p in ends)
    many = sky.Airspace(space.scenario.model_copy(update={"uavs": uavs, "targets": targets}))
    for i, words in enumerate(problems):
        result = sky.ThetaStar().plan(sky.Problem(many, i, i))
        times.append(result.seconds)
        ratios.append(result.cost / float(words[6]))
        stretches.append(result.cost / math.dist(starts[i], ends[i]))
    longer = sum(ratio > 1 + ROUNDED for ratio in ratios)
    head = ["problems", "longer than the published optimum", "length: by it, mean", "by the straight line, mean"]
    head += ["mean", "median", "slowest"]
    shares = [f"{statistics.mean(ratios):.4f}", f"{statistics.mean(stretches):.4f}"]
    print("Theta* (Lazy Theta*, pulled tight; the exact search of the lattice is part of it)")
    table(head, [[f"{len(problems):,}", f"{longer}", *shares, *_milliseconds(times)]])


def _milliseconds(times: list[float]) -> list[str]:
    """Return mean, median and the longest of all times but the first, in which kernels are loaded."""
    figures = statistics.mean(times[1:]), statistics.median(times[1:]), max(times[1:])
    return [f"{seconds * 1e3:.2f} ms" for seconds in figures]


def main(folder: Path) -> None:
    space = airspace(folder / "Simple.3dmap")
    problems = [line.split() for line in (folder / "Simple.3dmap.3dscen").read_text().splitlines()[2:]]
    print(f"{describe()}\n")
    exact(space, problems)
    any_angle(space, problems)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
