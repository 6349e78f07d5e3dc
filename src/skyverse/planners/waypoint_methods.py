"""The optimisers of vectors as planners: each class names its optimiser, its settings and the package that it needs."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.planners.optimisers import Evaluate, Iterations, bbo, by_niapy, by_pymoo, cma_es, da, gso, mfo, mvo, woa
from skyverse.planners.settings import require_boolean, require_integer, require_number
from skyverse.planners.waypoints import WaypointSearch


@dataclass(frozen=True, kw_only=True)
class WaypointMVO(WaypointSearch):
    """The Multi-Verse Optimizer of vectors, as section 3.2 of the thesis has it.

    Its settings are those of `WaypointSearch`, and these.

    Attributes
    ----------
    wep_min, wep_max
        The wormhole existence probability at the start and at the end (equation 3.8).
    p
        The exploitation accuracy in TDR = 1 - (l/L)^(1/p) (equation 3.9).
    greedy
        Whether a changed universe that is worse is discarded, which neither thesis nor paper does.

    References
    ----------
    S. Mirjalili, S. M. Mirjalili, A. Hatamlou, "Multi-Verse Optimizer", Neural Computing and Applications 27 (2016),
    495-513.
    """

    wep_min: float = 0.2
    wep_max: float = 1.0
    p: float = 6.0
    greedy: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        require_number(self, "wep_min", 0, 1)
        require_number(self, "wep_max", self.wep_min, 1)
        require_number(self, "p", 1e-3, 1e3)
        require_boolean(self, "greedy")

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        return mvo.mvo(evaluate, first, rng, (self.wep_min, self.wep_max), self.p, self.greedy)


@dataclass(frozen=True, kw_only=True)
class WaypointGSO(WaypointSearch):
    """Glowworm Swarm Optimization of vectors.

    It is made to find many optima side by side: the brightest glowworm never moves, and others only towards brighter
    ones. Its settings are those of `WaypointSearch`, and these; lengths are shares of the diagonal of [0, 1]^d, and
    their defaults those of the paper in the square [-3, 3] x [-3, 3].

    Attributes
    ----------
    luciferin, decay, gain
        l at the start, rho and gamma of l = (1 - rho) l + gamma J (equation 1); J is the negated fitness.
    length
        s, how far a glowworm moves in one iteration (equation 3).
    reach
        r_s, the decision range at the start, and the largest.
    neighbours
        n_t: how many brighter glowworms a decision range should contain (equation 4).
    beta
        How much the range changes for each neighbour too few or too many (equation 4).

    References
    ----------
    K. N. Krishnanand, D. Ghose, "Glowworm swarm optimization for simultaneous capture of multiple local optima of
    multimodal functions", Swarm Intelligence 3 (2009), 87-124.
    """

    luciferin: float = 5.0
    decay: float = 0.4
    gain: float = 0.6
    length: float = 0.0035
    reach: float = 0.35
    neighbours: int = 5
    beta: float = 0.0094

    def __post_init__(self) -> None:
        super().__post_init__()
        require_number(self, "luciferin", -1e9, 1e9)
        require_number(self, "gain", 1e-9, 1e9)
        require_integer(self, "neighbours", 1)
        for name in ("decay", "length", "reach", "beta"):
            require_number(self, name, 0, 1)

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        glow = (self.luciferin, self.decay, self.gain)
        return gso.gso(evaluate, first, rng, glow, self.length, self.reach, self.neighbours, self.beta)


@dataclass(frozen=True, kw_only=True)
class WaypointBBO(WaypointSearch):
    """Biogeography-Based Optimization of vectors.

    Its settings are those of `WaypointSearch`, and these.

    Attributes
    ----------
    mutation
        m_max, the largest probability that a number is drawn anew.
    elites
        How many habitats survive unchanged.
    greedy
        Whether a changed habitat that is worse is discarded, which the paper does not do.

    References
    ----------
    D. Simon, "Biogeography-Based Optimization", IEEE Transactions on Evolutionary Computation 12 (2008), 702-713.
    """

    mutation: float = 0.01
    elites: int = 2
    greedy: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        require_number(self, "mutation", 0, 1)
        require_integer(self, "elites", 0)
        require_boolean(self, "greedy")
        if self.elites >= self.candidates:
            raise InputError(
                f"WaypointBBO's elites is a number below the {self.candidates} candidates, not {self.elites!r}"
            )

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        return bbo.bbo(evaluate, first, rng, self.mutation, self.elites, self.greedy)


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
        require_number(self, "sigma", 1e-9, 1e9)

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        return cma_es.cma_es(evaluate, first, rng, self.sigma)


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
        require_number(self, "weighting", 0, 2)
        require_number(self, "crossover", 0, 1)

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        return by_pymoo.de(self.weighting, self.crossover)(evaluate, first, rng)


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
