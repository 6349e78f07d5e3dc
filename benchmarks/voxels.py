"""All 10,000 problems of a MovingAI 3-D benchmark against their published optima: ``python benchmarks/voxels.py DIR``.

DIR holds Simple.3dmap and Simple.3dmap.3dscen. The optima are 26-connected, without cutting corners.
"""

import statistics
import sys
import time
from pathlib import Path

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.exact import shortest_route
from skyverse.space.lattice import Grid


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


def main(folder: Path) -> None:
    space = airspace(folder / "Simple.3dmap")
    lines = (folder / "Simple.3dmap.3dscen").read_text().splitlines()[2:]
    times, worst = [], 0.0
    for line in lines:
        words = line.split()
        source, goal = node(space.grid, words[:3]), node(space.grid, words[3:6])
        began = time.perf_counter()
        route = shortest_route(space.grid, space.pricing, source, goal)
        times.append(time.perf_counter() - began)
        worst = max(worst, abs(route.price / float(words[6]) - 1))
    times = times[1:]
    print(f"{describe()}\n")
    table(
        ["problems", "largest deviation from the published optimum", "mean", "median", "slowest"],
        [
            [
                f"{len(lines):,}",
                f"{worst:.1e} (relative)",
                f"{statistics.mean(times) * 1e3:.2f} ms",
                f"{statistics.median(times) * 1e3:.2f} ms",
                f"{max(times) * 1e3:.1f} ms",
            ]
        ],
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
