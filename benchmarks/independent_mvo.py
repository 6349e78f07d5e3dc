"""`WaypointMVO` against an independent one: ``python benchmarks/independent_mvo.py PACKAGES [--runs 30]``.

PACKAGES is a folder with ``mealpy`` 3.0.3, as ``pip install --no-deps --target PACKAGES mealpy==3.0.3`` makes it, which
asks for an older numpy than skyverse does, but runs with this one. Both minimise the same four objectives from the same
first populations, with as many evaluations. mealpy discards universes that get worse, so `WaypointMVO` runs with
``greedy=True`` as well. It also differs in the wheel of white holes, which always takes the best, and in the
normalisation of inflation rates. The table gives for each objective the mean costs, the 90 % interval of their ratio
(within 0.97 and 1.03 they are equivalent within 3 %), and p of the Mann-Whitney test.
"""

import argparse
import sys
import warnings
from dataclasses import dataclass

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.lab import mann_whitney

OBJECTIVES = {
    "map1": ("map1", {}),
    "map2": ("map2", {}),
    "map3": ("map3", {}),
    "map1, straight legs": ("map1", {"legs": "straight"}),
}


@dataclass(frozen=True, kw_only=True)
class Theirs(sky.WaypointSearch):
    """mealpy's MVO, which runs from beginning to end by itself until the budget is spent."""

    iterations: int

    def optimise(self, evaluate, first, rng):
        """Hand the first population over."""
        from mealpy import MVO, FloatVar

        n, d = first.shape
        model = MVO.OriginalMVO(epoch=self.iterations, pop_size=n)
        problem = {
            "obj_func": lambda x: float(evaluate(np.asarray(x)[None])[0]),
            "bounds": FloatVar(lb=[0.0] * d, ub=[1.0] * d),
            "minmax": "min",
            "log_to": None,
        }
        model.solve(problem, starting_solutions=first.tolist(), seed=int(rng.integers(2**31)))
        while True:
            yield


def main() -> None:
    """Run both, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("packages")
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--paths", type=int, default=1000)
    asked = parser.parse_args()
    sys.path.append(asked.packages)
    warnings.simplefilter("ignore")
    print(describe(), end="\n\n")
    lines = []
    for name, (scenario, how) in OBJECTIVES.items():
        problem, costs = sky.Problem(sky.read(scenario)), []
        theirs = Theirs(iterations=asked.paths // 25 - 1, **how)
        for planner in (sky.WaypointMVO(**how), sky.WaypointMVO(greedy=True, **how), theirs):
            found = [planner.plan(problem, stop=sky.MaxPaths(asked.paths), rng=k) for k in range(asked.runs)]
            costs.append(np.array([result.cost for result in found]))
        _, greedy, other = costs
        rng = np.random.default_rng(0)
        drawn = rng.integers(asked.runs, size=(2, 10_000, asked.runs))
        low, high = np.quantile(greedy[drawn[0]].mean(axis=1) / other[drawn[1]].mean(axis=1), (0.05, 0.95))
        means = [f"{each.mean():,.1f}" for each in costs]
        lines.append((name, *means, f"{low:.3f} to {high:.3f}", f"{mann_whitney(greedy, other):.2g}"))
    table(("", "WaypointMVO", "greedy", "mealpy", "greedy / mealpy, 90 %", "p"), lines)


if __name__ == "__main__":
    main()
