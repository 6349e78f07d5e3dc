"""All 10,000 problems of a MovingAI 3-D benchmark against their published optima: ``python benchmarks/voxels.py DIR``.

DIR contains Simple.3dmap and Simple.3dmap.3dscen. The optima are 26-connected, without cutting corners. First the exact
search, then Theta*, whose any-angle paths should be no longer than the optima. At last Theta* in two maps of 60 million
voxels: copies of the same map side by side, and a city.
"""

import itertools
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
LARGE = 100
"""Problems in each of the large maps."""


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
            clearance=0.001,
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
    print("Theta* (Lazy Theta*, then shortened; where the lattice's path may be shorter, that is searched, too)")
    table(head, [[f"{len(problems):,}", f"{longer}", *shares, *_milliseconds(times)]])


def large(path: Path) -> None:
    """Run Theta* between random free voxels of two large maps; its times are those of the processor."""
    size, *blocked = (np.array(line.split()[-3:], int) for line in path.read_text().splitlines())
    tile = np.zeros(size, bool)
    tile[tuple(np.transpose(blocked))] = True
    rng = np.random.default_rng(1)
    city = np.zeros((500, 500, 240), bool)
    for corner in itertools.product(range(0, 500, 25), repeat=2):
        x, y = corner + rng.integers(0, 5, 2)
        wide, deep = rng.integers(10, 20, 2)
        city[x : x + wide, y : y + deep, : rng.integers(60, 230)] = True
    rows = []
    for label, occupied in (("Simple, 4 x 3 x 4 times", np.tile(tile, (4, 3, 4))[:390, :390, :395]), ("city", city)):
        ends = rng.choice(np.flatnonzero(~occupied), (LARGE + 1, 2))
        places = np.stack(np.unravel_index(ends, occupied.shape), axis=-1).astype(float)
        space = sky.Airspace(
            sky.Scenario(
                name=label,
                bounds=sky.Bounds(min=(0, 0, 0), max=tuple(n - 1 for n in occupied.shape)),
                obstacles=[sky.Voxels(origin=(-0.5,) * 3, step=(1, 1, 1), occupied=occupied)],
                clearance=0.001,
                lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
                objective=sky.Objective(unit="metres"),
                uavs=[sky.UAV(start=tuple(place)) for place in places[:, 0]],
                targets=[sky.Target(position=tuple(place)) for place in places[:, 1]],
            )
        )
        times, shares = [], []
        for i in range(len(ends)):
            problem = sky.Problem(space, i, i)
            began = time.process_time()
            result = sky.ThetaStar().plan(problem)
            times.append(time.process_time() - began)
            if result.status.reached:
                shares.append(result.cost / result.bound)
        stretch = f"{statistics.mean(shares):.4f}"
        rows.append([label, f"{occupied.size:,}", f"{len(shares)} of {len(ends)}", stretch, *_milliseconds(times)])
    head = ["map", "voxels", "paths", "length by the straight line, mean", "mean", "median", "slowest"]
    print("Theta* in large maps, processor time")
    table(head, rows)


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
    large(folder / "Simple.3dmap")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
