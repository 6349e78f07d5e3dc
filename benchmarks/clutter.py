"""Taut among crossing walls and downtown: ``python benchmarks/clutter.py [WORLDS [CITIES]]`` prints two tables.

Both compare with lower bounds and with Theta*. Downtown, where most buildings reach the ceiling, a bound of our own is
added: the length of the exact shortest path in the plane among these buildings. Seconds are those of the processor.
"""

import math
import sys
import time

import numpy as np
from machine import describe, table

import skyverse as sky


def clutter(seed: int) -> sky.Scenario:
    """Return a room with 20 to 60 crossing walls, some of them slabs and floors, to be crossed from side to side."""
    rng = np.random.default_rng(seed)
    size = rng.uniform((9.0, 7.0, 4.0), (15.0, 12.0, 5.5))
    clearance = float(rng.choice([0.0, 0.1]))
    walls, floors = int(rng.integers(20, 61)), rng.random() < 0.5
    start, target = (np.array([rng.uniform(0.3, s - 0.3) for s in size]) for _ in range(2))
    start[1], target[1] = rng.uniform(0.5, 0.9), size[1] - rng.uniform(0.5, 0.9)
    boxes = []
    while len(boxes) < walls:
        thin = int(rng.integers(3 if floors else 2))
        extent = rng.uniform(0.2, 0.85, 3) * size
        extent[thin] = rng.uniform(0.02, 0.2) if floors else 0.2
        if thin == 2:
            extent[:2] *= 0.6
        middle = rng.uniform(0.0, 1.0, 3) * size
        low, high = middle - extent / 2, middle + extent / 2
        reach = clearance + 0.05
        if any(np.all((low - reach < p) & (p < high + reach)) for p in (start, target)):
            continue
        boxes.append(sky.Box(min=tuple(low.tolist()), max=tuple(high.tolist())))
    return sky.Scenario(
        name=f"clutter-{seed}",
        bounds=sky.Bounds(min=(0, 0, 0), max=tuple(size.tolist())),
        obstacles=tuple(boxes),
        clearance=clearance,
        lattice=sky.Lattice(step=tuple((size / 20).tolist()), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=(sky.UAV(start=tuple(start.tolist())),),
        targets=(sky.Target(position=tuple(target.tolist())),),
    )


def plane_bound(scenario: sky.Scenario, most: float) -> float:
    """Return a length that no path beats: that of the shortest path in the plane among what reaches the ceiling.

    It is exact, by A* over the visibility graph of the corners that a path of at most `most` metres can touch.
    """
    ceiling, grown = scenario.bounds.max[2], scenario.clearance
    tall = tuple(box for box in scenario.obstacles if isinstance(box, sky.Box) and box.max[2] + grown >= ceiling)
    world = sky.World(scenario.model_copy(update={"obstacles": tall}))
    low, high = np.array([box.min[:2] for box in tall]), np.array([box.max[:2] for box in tall])
    corners = [
        np.column_stack([x, y])
        for x in (low[:, 0] - grown, high[:, 0] + grown)
        for y in (low[:, 1] - grown, high[:, 1] + grown)
    ]
    start, goal = np.array(scenario.uavs[0].start), np.array(scenario.targets[0].position)
    at = np.vstack([start[:2], goal[:2], *corners])
    at = np.column_stack([at, np.full(len(at), ceiling / 2)])
    left = np.linalg.norm(at - at[1], axis=1)
    useful = world.free(at) & (np.linalg.norm(at - at[0], axis=1) + left <= most)
    at, left = at[useful], left[useful]
    price, done = np.full(len(at), np.inf), np.zeros(len(at), bool)
    price[0] = 0.0
    while not done[1]:
        v = int(np.argmin(np.where(done, np.inf, price + left)))
        if price[v] == np.inf:
            return math.inf
        done[v] = True
        further = price[v] + np.linalg.norm(at - at[v], axis=1)
        better = np.flatnonzero(~done & (further < price) & (further + left <= most))
        seen = better[world.segments_free(np.repeat(at[v : v + 1], len(better), axis=0), at[better])]
        price[seen] = further[seen]
    return math.hypot(float(price[1]), goal[2] - start[2])


def measured(scenario: sky.Scenario) -> tuple[sky.Problem, sky.Result, float]:
    """Return a problem, Taut's answer, which the referee has judged, and the seconds that it took."""
    problem = sky.Problem(scenario)
    _ = problem.airspace.cells, problem.airspace.edges
    began = time.process_time()
    result = sky.Taut().plan(problem)
    seconds = time.process_time() - began
    assert sky.check_result(scenario, 0, 0, result) == []
    return problem, result, seconds


def spread(values: list[float], unit: str, factor: float) -> str:
    """Return the median, the 95th percentile and the greatest of some numbers."""
    return " / ".join(f"{factor * value:.3g}" for value in np.percentile(values, [50, 95, 100])) + f" {unit}"


def row(name: str, scenarios: list[sky.Scenario]) -> list[str]:
    """Return a row of the table: gaps, how much Theta* is longer or shorter, and times."""
    gaps, theirs, times, planar = [], [], [], []
    for scenario in scenarios:
        problem, result, seconds = measured(scenario)
        if not result.status.reached or result.bound is None:
            continue
        times.append(seconds)
        gaps.append(result.cost / result.bound - 1.0)
        other = sky.ThetaStar().plan(problem)
        if other.status.reached:
            theirs.append(result.cost / other.cost - 1.0)
        if name == "downtown":
            planar.append(result.cost / plane_bound(scenario, result.cost + 1e-6) - 1.0)
    above = spread(planar, "%", 100) if planar else ""
    longer = sum(excess > 1e-4 for excess in theirs)
    return [name, f"{len(gaps)}", spread(gaps, "%", 100), above, f"{longer}", spread(times, "ms", 1e3)]


def main() -> None:
    """Print the table."""
    print(f"{describe()}\n")
    worlds, cities = (int(word) for word in (sys.argv[1:] + ["200", "20"][len(sys.argv) - 1 :]))
    measured(clutter(0))  # compiles
    rows = [row("crossing walls", [clutter(seed) for seed in range(worlds)])]
    rows.append(row("downtown", [sky.random_downtown(seed=seed) for seed in range(cities)]))
    table(["world", "paths", "proven gap", "above the plane's bound", "longer than Theta*'s", "time"], rows)
    print("\nGaps and times: median / 95th percentile / greatest.")


if __name__ == "__main__":
    main()
