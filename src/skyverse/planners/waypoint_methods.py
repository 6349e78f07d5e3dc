"""The nine optimisers of vectors as planners: each class names its optimiser and the package that it needs, if any."""

from skyverse.planners.optimisers import by_niapy, by_pymoo, cma_es, da, mfo, woa
from skyverse.planners.waypoints import WaypointSearch


class CMAES(WaypointSearch):
    """The covariance matrix adaptation evolution strategy, by the package ``cma``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    N. Hansen, A. Ostermeier, "Completely Derandomized Self-Adaptation in Evolution Strategies", Evolutionary
    Computation 9 (2001), 159-195.
    """

    library = "cma"
    optimise = staticmethod(cma_es.cma_es)


class PSO(WaypointSearch):
    """Particle swarm optimisation with adaptive weights, by the package ``pymoo``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    J. Kennedy, R. Eberhart, "Particle Swarm Optimization", Proc. ICNN (1995), 1942-1948.
    """

    library = "pymoo"
    optimise = staticmethod(by_pymoo.pso)


class GA(WaypointSearch):
    """A real-coded genetic algorithm (simulated binary crossover, polynomial mutation), by the package ``pymoo``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    K. Deb, R. B. Agrawal, "Simulated Binary Crossover for Continuous Search Space", Complex Systems 9 (1995), 115-148.
    """

    library = "pymoo"
    optimise = staticmethod(by_pymoo.ga)


class DE(WaypointSearch):
    """Differential evolution, DE/rand/1/bin with F = 0.5 and CR = 0.9, by the package ``pymoo``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    R. Storn, K. Price, "Differential Evolution", Journal of Global Optimization 11 (1997), 341-359.
    """

    library = "pymoo"
    optimise = staticmethod(by_pymoo.de)


class LSHADE(WaypointSearch):
    """Success-history based adaptive differential evolution, its population shrinking to 4, by the package ``NiaPy``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    R. Tanabe, A. S. Fukunaga, "Improving the Search Performance of SHADE Using Linear Population Size Reduction",
    Proc. IEEE CEC (2014), 1658-1665.
    """

    library = "niapy"
    optimise = staticmethod(by_niapy.l_shade)


class WOA(WaypointSearch):
    """The whale optimization algorithm.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, A. Lewis, "The Whale Optimization Algorithm", Advances in Engineering Software 95 (2016), 51-67.
    """

    optimise = staticmethod(woa.woa)


class MFO(WaypointSearch):
    """The moth-flame optimization algorithm.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, "Moth-flame optimization algorithm", Knowledge-Based Systems 89 (2015), 228-249.
    """

    optimise = staticmethod(mfo.mfo)


class GWO(WaypointSearch):
    """The grey wolf optimiser, by the package ``NiaPy``.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, S. M. Mirjalili, A. Lewis, "Grey Wolf Optimizer", Advances in Engineering Software 69 (2014), 46-61.
    """

    library = "niapy"
    optimise = staticmethod(by_niapy.gwo)


class DA(WaypointSearch):
    """The dragonfly algorithm.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, "Dragonfly algorithm", Neural Computing and Applications 27 (2016), 1053-1073.
    """

    optimise = staticmethod(da.da)
