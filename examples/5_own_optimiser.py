"""
An optimiser of your own
========================

Any optimiser of vectors plans, too: on waypoints. It is one generator function.
"""

# [optimiser]
from dataclasses import dataclass

import numpy as np

import skyverse as sky
from skyverse import WaypointSearch
from skyverse.planners.waypoints import Evaluate, Iterations


@dataclass(frozen=True)
class Shake(WaypointSearch):
    """Shake every candidate, less and less; keep what is not worse."""

    def optimise(self, evaluate: Evaluate, first: np.ndarray, rng: np.random.Generator) -> Iterations:
        """Evaluate the first population; then do an iteration for each share of the budget."""
        X, fitness = first, evaluate(first)
        while True:
            spent = yield
            steps = 0.2 * (1 - spent) * rng.standard_normal(X.shape)
            shaken = np.clip(X + steps * (rng.random(X.shape) < 0.2), 0, 1)
            value = evaluate(shaken)
            better = value <= fitness
            X, fitness = np.where(better[:, None], shaken, X), np.where(better, value, fitness)


# [end]

# %%
# Against two optimisers of the library, which begin with the same candidates. A path that does not arrive costs 100 for
# every metre that is left:

for name in ("map1", "map3"):
    problem = sky.Problem(sky.read(name))
    for planner in (Shake(), sky.WOA(), sky.MFO()):
        results = [planner.plan(problem, stop=sky.MaxPaths(1000), rng=seed) for seed in range(20)]
        arrived = sum(result.status.reached for result in results)
        mean = sum(result.cost for result in results) / len(results)
        print(f"{name} {type(planner).__name__:5} {arrived:2} of 20 arrive, mean {mean:.1f}")
