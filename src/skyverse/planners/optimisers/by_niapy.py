"""Grey wolf optimiser and L-SHADE by the package ``NiaPy`` (Vrbančič and others 2018)."""

import importlib
import logging
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations, Optimiser


class _NiaPyTask:
    """A task as NiaPy's algorithms use it; its evaluations stand for the share of the budget that is spent."""

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


def _by_niapy(module: str, name: str) -> Optimiser:
    """Return the algorithm of this name in one of NiaPy's modules as an optimiser."""

    def optimise(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        def start(task: _NiaPyTask, individual_type: Any = None, **_: object) -> tuple[Any, Floats]:
            fitness = evaluate(first)
            if individual_type is None:
                return first.copy(), fitness
            population = np.empty(len(first), dtype=object)
            population[:] = [individual_type(x=x, e=False) for x in first.copy()]
            for one, f in zip(population, fitness, strict=True):
                one.f = f
            return population, fitness

        kind = getattr(_import_quietly(f"niapy.algorithms.{module}"), name)
        algorithm = kind(population_size=len(first), initialization_function=start, seed=rng)
        task = _NiaPyTask(evaluate, first.shape[1])
        population, fitness, memory = algorithm.init_population(task)
        x, f = algorithm.get_best(population, fitness)
        while True:
            task.evals = yield
            population, fitness, x, f, memory = algorithm.run_iteration(task, population, fitness, x, f, **memory)

    return optimise


gwo = _by_niapy("basic.gwo", "GreyWolfOptimizer")
"""Grey wolves (Mirjalili, Mirjalili, Lewis 2014): all close in on the three best candidates so far."""

l_shade = _by_niapy("modified.shade", "LpsrSuccessHistoryAdaptiveDifferentialEvolution")
"""L-SHADE (Tanabe, Fukunaga 2014): its population shrinks linearly to 4 candidates."""


def _import_quietly(module: str) -> Any:
    """Import one of NiaPy's modules, and remove the handler for log messages that NiaPy gives to the whole program."""
    handlers = logging.root.handlers[:]
    imported = importlib.import_module(module)
    logging.root.handlers[:] = handlers
    return imported
