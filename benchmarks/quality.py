"""How good: ``python benchmarks/quality.py`` prints the means of docs/thesis.md."""

import sys

import numpy as np
from machine import describe, table

import skyverse as sky

# mean and standard deviation of 20 runs in the thesis, by map, universes, iterations
THESIS = {
    ("map1", 20, 25): (280.4, 6.65),
    ("map1", 25, 40): (276.1, 7.32),
    ("map2", 20, 25): (373.6, 27.8),
    ("map2", 25, 40): (344.8, 29.6),
    ("map3", 20, 25): (281.0, 14.27),
    ("map3", 25, 40): (279.0, 10.77),
}


def main(runs: int) -> None:
    print(f"{describe()}\n\n{runs} seeds a cell; mean +- standard error\n")
    published_cells(runs)
    equal_effort(runs)


def published_cells(runs: int) -> None:
    rows = []
    for (name, universes, iterations), (mean, deviation) in THESIS.items():
        problem = sky.Problem(sky.read_scenario(name))
        stop = sky.MaxIterations(iterations)
        as_run = _costs(sky.MVO(universes=universes, as_run=True), problem, stop, runs)
        error = np.hypot(deviation / np.sqrt(20), as_run.std(ddof=1) / np.sqrt(runs))
        described = [sky.MVO(universes=universes).plan(problem, stop=stop, rng=seed) for seed in range(runs)]
        paths = round(np.mean([result.effort.generated_paths for result in described]))
        restart = _costs(sky.RandomRestart(), problem, sky.MaxPaths(paths), runs)
        rows.append(
            [
                f"{name[-1]}, {universes} x {iterations}",
                f"{mean}",
                _mean(as_run),
                f"{(as_run.mean() - mean) / error:+.1f}",
                _mean(np.array([result.cost for result in described])),
                _mean(restart),
                f"{paths}",
                f"{problem.route.price:g}",
            ]
        )
    table(
        [
            "map, universes x iterations",
            "thesis",
            "MVO as run",
            "(as run - thesis) / error",
            "MVO as described",
            "restart, same paths",
            "generated paths",
            "exact",
        ],
        rows,
    )


def equal_effort(runs: int) -> None:
    rows = []
    for name in ("map1", "map2", "map3"):
        problem = sky.Problem(sky.read_scenario(name))
        for paths in (182, 500, 1000):
            planners = (sky.RandomRestart(), sky.MVO(as_run=True), sky.MVO())
            means = [_mean(_costs(planner, problem, sky.MaxPaths(paths), runs)) for planner in planners]
            rows.append([name[-1], str(paths), *means])
    table(["map", "generated paths", "random restart", "MVO as run", "MVO as described"], rows)


def _costs(planner: sky.MVO | sky.RandomRestart, problem: sky.Problem, stop: object, runs: int) -> np.ndarray:
    return np.array([planner.plan(problem, stop=stop, rng=seed).cost for seed in range(runs)])


def _mean(costs: np.ndarray) -> str:
    return f"{costs.mean():.1f} +- {costs.std(ddof=1) / np.sqrt(len(costs)):.1f}"


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
