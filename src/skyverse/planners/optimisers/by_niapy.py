"""Grey wolf optimiser and L-SHADE by the package ``NiaPy`` (Vrbančič and others 2018)."""

import logging
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations


class _Task:
    """What NiaPy's algorithms ask of a task; its count of evaluations is the share of the budget that is spent."""

    class optimization_type:  # noqa: N801
        value = 1.0

    max_evals = 1.0

    def __init__(self, evaluate: Evaluate, dimension: int) -> None:
        self.evaluate = evaluate
        self.dimension = dimension
        self.lower, self.upper = np.zeros(dimension), np.ones(dimension)
        self.evals = 0.0

    def eval(self, x: Floats) -> float:
        return float(self.evaluate(x[None])[0])

    def repair(self, x: Floats, rng: object = None) -> Floats:
        return np.clip(x, 0.0, 1.0)


def gwo(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Hunt as grey wolves (Mirjalili, Mirjalili, Lewis 2014): all close in on the three best so far."""
    _import_quietly()
    from niapy.algorithms.basic.gwo import GreyWolfOptimizer

    def start(task: _Task, **_: object) -> tuple[Floats, Floats]:
        return first.copy(), evaluate(first)

    return _iterate(GreyWolfOptimizer, start, evaluate, first, rng)


def l_shade(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Run L-SHADE (Tanabe, Fukunaga 2014); the population shrinks linearly to 4."""
    _import_quietly()
    from niapy.algorithms.modified.shade import LpsrSuccessHistoryAdaptiveDifferentialEvolution

    def start(task: _Task, individual_type: Any, **_: object) -> tuple[Any, Floats]:
        population = np.empty(len(first), dtype=object)
        population[:] = [individual_type(x=x, e=False) for x in first.copy()]
        fitness = evaluate(first)
        for one, f in zip(population, fitness, strict=True):
            one.f = f
        return population, fitness

    return _iterate(LpsrSuccessHistoryAdaptiveDifferentialEvolution, start, evaluate, first, rng)


def _iterate(kind: Any, start: Any, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    algorithm = kind(population_size=len(first), initialization_function=start, seed=rng)
    task = _Task(evaluate, first.shape[1])
    population, fitness, memory = algorithm.init_population(task)
    x, f = algorithm.get_best(population, fitness)
    while True:
        task.evals = yield
        population, fitness, x, f, memory = algorithm.run_iteration(task, population, fitness, x, f, **memory)


def _import_quietly() -> None:
    """Import NiaPy, and take back the handler for log messages that it gives the whole program."""
    handlers = logging.root.handlers[:]
    import niapy.algorithms  # noqa: F401

    logging.root.handlers[:] = handlers
