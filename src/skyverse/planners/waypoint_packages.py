"""The optimisers of vectors that the packages ``cma``, ``pymoo`` and ``NiaPy`` make, as planners."""

import importlib
import logging
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import require_number
from skyverse.planners.waypoints import Evaluate, Iterations, WaypointSearch


@dataclass(frozen=True, kw_only=True)
class CMAES(WaypointSearch):
    """The covariance matrix adaptation evolution strategy, by the package ``cma``, with restarts.

    Its settings are those of `WaypointSearch`, and `sigma`, the standard deviation at the start. When the package says
    that a search is over, it begins anew from a random vector with twice the candidates (IPOP; Auger, Hansen 2005).

    References
    ----------
    N. Hansen, A. Ostermeier, "Completely Derandomized Self-Adaptation in Evolution Strategies", Evolutionary
    Computation 9 (2001), 159-195.
    """

    sigma: float = 0.2
    library: ClassVar[str] = "cma"

    def __post_init__(self) -> None:
        super().__post_init__()
        require_number(self.sigma, "sigma", least=1e-9, most=1e9)

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
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
            strategy = cma.CMAEvolutionStrategy(mean, self.sigma, settings)
            while not strategy.stop():
                yield
                asked = strategy.ask()
                strategy.tell(asked, evaluate(np.array(asked)))
            mean, candidates = rng.random(len(mean)), 2 * candidates


class PSO(WaypointSearch):
    """Particle swarm optimisation with adaptive weights, by the package ``pymoo``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    J. Kennedy, R. Eberhart, "Particle Swarm Optimization", Proc. ICNN (1995), 1942-1948.
    """

    library = "pymoo"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        return _by_pymoo("PSO", evaluate, first, rng)


class GA(WaypointSearch):
    """A real-coded genetic algorithm (simulated binary crossover, polynomial mutation), by the package ``pymoo``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    K. Deb, R. B. Agrawal, "Simulated Binary Crossover for Continuous Search Space", Complex Systems 9 (1995), 115-148.
    """

    library = "pymoo"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        # duplicates stay: a population without them can run out of children, and then never spends its budget
        return _by_pymoo("GA", evaluate, first, rng, eliminate_duplicates=False)


@dataclass(frozen=True, kw_only=True)
class DE(WaypointSearch):
    """Differential evolution, DE/rand/1/bin, by the package ``pymoo``.

    Its settings are those of `WaypointSearch`, `weighting`, the factor F, and `crossover`, the constant CR.

    References
    ----------
    R. Storn, K. Price, "Differential Evolution", Journal of Global Optimization 11 (1997), 341-359.
    """

    weighting: float = 0.5
    crossover: float = 0.9
    library: ClassVar[str] = "pymoo"

    def __post_init__(self) -> None:
        super().__post_init__()
        require_number(self.weighting, "weighting", least=0, most=2)
        require_number(self.crossover, "crossover", least=0, most=1)

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        settings = {"variant": "DE/rand/1/bin", "F": self.weighting, "CR": self.crossover}
        return _by_pymoo("DE", evaluate, first, rng, **settings)


class LSHADE(WaypointSearch):
    """Success-history based adaptive differential evolution, its population shrinking to 4, by the package ``NiaPy``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    R. Tanabe, A. S. Fukunaga, "Improving the Search Performance of SHADE Using Linear Population Size Reduction",
    Proc. IEEE CEC (2014), 1658-1665.
    """

    library = "niapy"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        kind = "LpsrSuccessHistoryAdaptiveDifferentialEvolution"
        return _by_niapy("modified.shade", kind, evaluate, first, rng)


class GWO(WaypointSearch):
    """The grey wolf optimiser, by the package ``NiaPy``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, S. M. Mirjalili, A. Lewis, "Grey Wolf Optimizer", Advances in Engineering Software 69 (2014), 46-61.
    """

    library = "niapy"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        return _by_niapy("basic.gwo", "GreyWolfOptimizer", evaluate, first, rng)


def _by_pymoo(name: str, evaluate: Evaluate, first: Floats, rng: np.random.Generator, **settings: object) -> Iterations:
    """Run pymoo's single-objective algorithm of this name (Blank, Deb 2020), with these settings."""
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


def _by_niapy(module: str, name: str, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Run the algorithm of this name in one of NiaPy's modules (Vrbančič and others 2018)."""

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


def _import_quietly(module: str) -> Any:
    """Import one of NiaPy's modules, and remove the handler for log messages that NiaPy gives to the whole program."""
    handlers = logging.root.handlers[:]
    imported = importlib.import_module(module)
    logging.root.handlers[:] = handlers
    return imported
