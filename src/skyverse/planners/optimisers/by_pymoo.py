"""Particle swarm, genetic algorithm and differential evolution by the package ``pymoo`` (Blank, Deb 2020)."""

import importlib

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations, Optimiser


def _by_pymoo(name: str, **settings: object) -> Optimiser:
    """Return pymoo's single-objective algorithm of this name, with these settings, as an optimiser."""

    def optimise(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        from pymoo.core.evaluator import Evaluator
        from pymoo.core.problem import Problem
        from pymoo.core.termination import NoTermination
        from pymoo.problems.static import StaticProblem

        kind = getattr(importlib.import_module(f"pymoo.algorithms.soo.nonconvex.{name.lower()}"), name)
        algorithm = kind(pop_size=len(first), sampling=first, **settings)
        problem = Problem(n_var=first.shape[1], n_obj=1, xl=0.0, xu=1.0)
        algorithm.setup(problem, termination=NoTermination(), seed=rng)
        while True:
            asked = algorithm.ask()
            fitness = evaluate(asked.get("X"))
            Evaluator().eval(StaticProblem(problem, F=fitness[:, None]), asked)
            algorithm.tell(infills=asked)
            yield

    return optimise


pso = _by_pymoo("PSO")
"""Particle swarm; its weights adapt as pymoo makes them do by default."""

ga = _by_pymoo("GA", eliminate_duplicates=False)
"""Real vectors: tournaments, simulated binary crossover, polynomial mutation.

Duplicates stay, because a population without them can run out of children, and then never spends its budget.
"""


def de(weighting: float, crossover: float) -> Optimiser:
    """Return DE/rand/1/bin with F = `weighting` and CR = `crossover`."""
    return _by_pymoo("DE", variant="DE/rand/1/bin", F=weighting, CR=crossover)
