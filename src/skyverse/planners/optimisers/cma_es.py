"""CMA-ES by the package ``cma`` (Hansen, Ostermeier 2001)."""

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations


def cma_es(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Run CMA-ES from the mean of the first population, with a standard deviation of 0.2 on every axis."""
    import cma

    candidates = len(first)
    evaluate(first)
    settings = {
        "bounds": [0.0, 1.0],
        "popsize": candidates,
        "randn": lambda *shape: rng.standard_normal(shape),
        "seed": np.nan,  # any other value would seed numpy's global generator
        "verbose": -9,
    }
    strategy = cma.CMAEvolutionStrategy(first.mean(axis=0), 0.2, settings)
    while True:
        yield
        asked = strategy.ask()
        strategy.tell(asked, evaluate(np.array(asked)))
