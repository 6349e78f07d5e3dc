"""CMA-ES (Hansen, Ostermeier 2001) by the package ``cma``, with restarts."""

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations


def cma_es(evaluate: Evaluate, first: Floats, rng: np.random.Generator, sigma: float = 0.2) -> Iterations:
    """Run CMA-ES from the mean of the first population, with a standard deviation of `sigma` on every axis.

    When the package says that the search is over, it begins anew from a random vector with twice the candidates, as
    IPOP-CMA-ES does (Auger, Hansen 2005).
    """
    import cma

    evaluate(first)
    mean, candidates = first.mean(axis=0), len(first)
    while True:
        settings = {
            "bounds": [0.0, 1.0],
            "popsize": candidates,
            "randn": lambda *shape: rng.standard_normal(shape),
            "seed": np.nan,  # any other value would seed numpy's global generator
            "verbose": -9,
        }
        strategy = cma.CMAEvolutionStrategy(mean, sigma, settings)
        while not strategy.stop():
            yield
            asked = strategy.ask()
            strategy.tell(asked, evaluate(np.array(asked)))
        mean, candidates = rng.random(len(mean)), 2 * candidates
