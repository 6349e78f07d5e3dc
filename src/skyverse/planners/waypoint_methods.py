"""The optimisers of vectors as planners: each is a `WaypointSearch` that says which."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations, by_niapy, by_pymoo, cma_es, da, mfo, woa
from skyverse.planners.waypoints import WaypointSearch


@dataclass(frozen=True, kw_only=True)
class CMAES(WaypointSearch):
    """The covariance matrix adaptation evolution strategy, by the package ``cma``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    N. Hansen, A. Ostermeier, "Completely Derandomized Self-Adaptation in Evolution Strategies", Evolutionary
    Computation 9 (2001), 159-195.
    """

    library: ClassVar[str] = "cma"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `cma_es`."""
        return cma_es.cma_es(evaluate, first, rng)


@dataclass(frozen=True, kw_only=True)
class PSO(WaypointSearch):
    """Particle swarm optimisation with adaptive weights, by the package ``pymoo``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    J. Kennedy, R. Eberhart, "Particle Swarm Optimization", Proc. ICNN (1995), 1942-1948.
    """

    library: ClassVar[str] = "pymoo"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `pso`."""
        return by_pymoo.pso(evaluate, first, rng)


@dataclass(frozen=True, kw_only=True)
class GA(WaypointSearch):
    """A real-coded genetic algorithm (simulated binary crossover, polynomial mutation), by the package ``pymoo``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    K. Deb, R. B. Agrawal, "Simulated Binary Crossover for Continuous Search Space", Complex Systems 9 (1995), 115-148.
    """

    library: ClassVar[str] = "pymoo"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `ga`."""
        return by_pymoo.ga(evaluate, first, rng)


@dataclass(frozen=True, kw_only=True)
class DE(WaypointSearch):
    """Differential evolution, DE/rand/1/bin with F = 0.5 and CR = 0.9, by the package ``pymoo``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    R. Storn, K. Price, "Differential Evolution", Journal of Global Optimization 11 (1997), 341-359.
    """

    library: ClassVar[str] = "pymoo"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `de`."""
        return by_pymoo.de(evaluate, first, rng)


@dataclass(frozen=True, kw_only=True)
class LSHADE(WaypointSearch):
    """Success-history based adaptive differential evolution, its population shrinking to 4, by the package ``NiaPy``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    R. Tanabe, A. S. Fukunaga, "Improving the Search Performance of SHADE Using Linear Population Size Reduction",
    Proc. IEEE CEC (2014), 1658-1665.
    """

    library: ClassVar[str] = "niapy"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `l_shade`."""
        return by_niapy.l_shade(evaluate, first, rng)


@dataclass(frozen=True, kw_only=True)
class WOA(WaypointSearch):
    """The whale optimization algorithm.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, A. Lewis, "The Whale Optimization Algorithm", Advances in Engineering Software 95 (2016), 51-67.
    """

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `woa`."""
        return woa.woa(evaluate, first, rng)


@dataclass(frozen=True, kw_only=True)
class MFO(WaypointSearch):
    """The moth-flame optimization algorithm.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, "Moth-flame optimization algorithm", Knowledge-Based Systems 89 (2015), 228-249.
    """

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `mfo`."""
        return mfo.mfo(evaluate, first, rng)


@dataclass(frozen=True, kw_only=True)
class GWO(WaypointSearch):
    """The grey wolf optimiser, by the package ``NiaPy``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, S. M. Mirjalili, A. Lewis, "Grey Wolf Optimizer", Advances in Engineering Software 69 (2014), 46-61.
    """

    library: ClassVar[str] = "niapy"

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `gwo`."""
        return by_niapy.gwo(evaluate, first, rng)


@dataclass(frozen=True, kw_only=True)
class DA(WaypointSearch):
    """The dragonfly algorithm.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, "Dragonfly algorithm", Neural Computing and Applications 27 (2016), 1053-1073.
    """

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
        """Run `da`."""
        return da.da(evaluate, first, rng)
