"""Particle swarm, genetic algorithm and differential evolution by the package ``pymoo`` (Blank, Deb 2020)."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations


def pso(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Fly a particle swarm, its weights adapted as pymoo does by default."""
    from pymoo.algorithms.soo.nonconvex.pso import PSO

    return _ask_and_tell(PSO(pop_size=len(first), sampling=first), evaluate, first, rng)


def ga(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Breed real vectors: tournaments, simulated binary crossover, polynomial mutation."""
    from pymoo.algorithms.soo.nonconvex.ga import GA

    # a population without duplicates can run out of children, and then spends nothing for ever
    return _ask_and_tell(GA(pop_size=len(first), sampling=first, eliminate_duplicates=False), evaluate, first, rng)


def de(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Evolve by DE/rand/1/bin with F = 0.5 and CR = 0.9."""
    from pymoo.algorithms.soo.nonconvex.de import DE

    return _ask_and_tell(
        DE(pop_size=len(first), sampling=first, variant="DE/rand/1/bin", F=0.5, CR=0.9), evaluate, first, rng
    )


def _ask_and_tell(algorithm: Any, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.core.termination import NoTermination
    from pymoo.problems.static import StaticProblem

    problem = Problem(n_var=first.shape[1], n_obj=1, xl=0.0, xu=1.0)
    algorithm.setup(problem, termination=NoTermination(), seed=rng)
    while True:
        asked = algorithm.ask()
        fitness = evaluate(asked.get("X"))
        Evaluator().eval(StaticProblem(problem, F=fitness[:, None]), asked)
        algorithm.tell(infills=asked)
        yield
