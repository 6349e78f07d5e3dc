"""The optimisers of vectors that are our own, as planners; none of them asks what the vectors stand for."""

import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, require_flag, require_number, require_whole
from skyverse.model.arrays import exp, power
from skyverse.planners.base import require_schedules, wep_and_tdr
from skyverse.planners.waypoints import Evaluate, Iterations, WaypointSearch


@dataclass(frozen=True, kw_only=True)
class WaypointMVO(WaypointSearch):
    """The Multi-Verse Optimizer of vectors, as section 3.2 of the thesis has it.

    Universes, whose objects are numbers, exchange them through white holes, and wormholes lead to the best. They are
    sorted anew in every iteration, and the best of them is left alone. A changed universe replaces the old one. Three
    oddities of the printed equations:

    - **roulette wheel** of (3.6): over negated costs, as in the author's code, it nearly always picks the best, and
      over costs it prefers the worst; here it is over ranks;
    - **reach** in (3.7): TDR ((ub - lb) r4 + lb) depends on where the origin lies; in [0, 1] it is TDR r4;
    - **TDR** (3.9) falls, where the text says that it is increased.

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
        require_schedules(self)
        require_flag(self.greedy, "greedy")

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        n, d = first.shape
        wheel = np.cumsum(np.arange(n, 0, -1))
        U, cost = first, evaluate(first)  # (3.5)
        while True:
            order = np.argsort(cost, kind="stable")
            U, cost = U[order], cost[order]
            spent = yield
            wep, tdr = wep_and_tdr(self, spent)
            r1, r2, r3, r4, spin = rng.random((5, n - 1, d))
            norm = math.sqrt(np.square(cost).sum())
            k = np.searchsorted(wheel, spin * wheel[-1], side="right")
            X = np.where(r1 * norm < cost[1:, None], U[k, np.arange(d)], U[1:])  # (3.6), NI = cost / norm
            X = np.where(r2 < wep, U[0] + np.where(r3 < 0.5, tdr, -tdr) * r4, X)  # (3.7)
            X = np.clip(X, 0.0, 1.0)
            new = evaluate(X)
            if self.greedy:
                worse = new > cost[1:]
                X[worse], new[worse] = U[1:][worse], cost[1:][worse]
            U, cost = np.concatenate([U[:1], X]), np.concatenate([cost[:1], new])


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
        require_number(self.luciferin, "luciferin", least=-1e9, most=1e9)
        require_number(self.gain, "gain", least=1e-9, most=1e9)
        require_whole(self.neighbours, "neighbours", 1)
        for name in ("decay", "length", "reach", "beta"):
            require_number(getattr(self, name), name, least=0, most=1)

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        n, d = first.shape
        length, reach, beta = (share * math.sqrt(d) for share in (self.length, self.reach, self.beta))
        X, J = first, -evaluate(first)
        l, r = np.full(n, self.luciferin), np.full(n, reach)  # noqa: E741
        while True:
            yield
            l = (1.0 - self.decay) * l + self.gain * J  # (1)  # noqa: E741
            apart = np.sqrt(np.square(X[:, None] - X).sum(axis=2))
            brighter = l - l[:, None]  # row i: how much brighter each j is
            seen = (brighter > 0.0) & (apart < r[:, None])
            wheel = np.cumsum(np.where(seen, brighter, 0.0), axis=1)  # (2): p_ij is as l_j - l_i
            j = (wheel <= rng.random((n, 1)) * wheel[:, -1:]).sum(axis=1).clip(max=n - 1)
            moves = seen[np.arange(n), j]
            away = apart[np.arange(n), j]
            X = X.copy()
            X[moves] += length * ((X[j] - X) / np.where(away > 0.0, away, 1.0)[:, None])[moves]  # (3)
            r = np.clip(r + beta * (self.neighbours - seen.sum(axis=1)), 0.0, reach)  # (4)
            J = -evaluate(X)


@dataclass(frozen=True, kw_only=True)
class WaypointBBO(WaypointSearch):
    """Biogeography-Based Optimization of vectors.

    Habitats take over numbers from others by migration, the good ones giving and the poor ones taking most. A changed
    habitat replaces the old one, and the `elites` survive. The best of n habitats counts n species, the worst one. A
    number is drawn anew with probability m_max (1 - P/P_max), where P is how likely so many species are; the paper
    prints m_max (1 - P)/P_max, which may exceed 1.

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
        require_number(self.mutation, "mutation", least=0, most=1)
        require_whole(self.elites, "elites", 0)
        require_flag(self.greedy, "greedy")
        if self.elites >= self.candidates:
            raise InputError(
                f"WaypointBBO's elites is a number below the {self.candidates} candidates, not {self.elites!r}"
            )

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        n, d = first.shape
        species = np.arange(n, 0, -1)
        immigration, emigration = 1.0 - species / n, species / n  # of the best habitat first
        # P/P_max by theorem 1, E = I
        chance = np.array([math.comb(n, k) / math.comb(n, n // 2) for k in species.tolist()])
        mutate = self.mutation * (1.0 - chance)
        wheel = np.cumsum(emigration)
        H, cost = first, evaluate(first)
        while True:
            order = np.argsort(cost, kind="stable")
            H, cost = H[order], cost[order]
            yield
            k = np.searchsorted(wheel, rng.random((n, d)) * wheel[-1], side="right")
            X = np.where(rng.random((n, d)) < immigration[:, None], H[k, np.arange(d)], H)
            X = np.where(rng.random((n, d)) < mutate[:, None], rng.random((n, d)), X)
            new = evaluate(X)
            if self.greedy:
                worse = new > cost
                X[worse], new[worse] = H[worse], cost[worse]
            H, cost = np.concatenate([H[: self.elites], X]), np.concatenate([cost[: self.elites], new])
            kept = np.argsort(cost, kind="stable")[:n]
            H, cost = H[kept], cost[kept]


class WOA(WaypointSearch):
    """The whale optimization algorithm: whales encircle the best or a random whale, or spiral around the best.

    A and C are one number for each whale.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, A. Lewis, "The Whale Optimization Algorithm", Advances in Engineering Software 95 (2016), 51-67.
    """

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        n = len(first)
        X = first
        best, lowest = first[0], np.inf
        while True:
            fitness = evaluate(X)
            if fitness.min() < lowest:
                best, lowest = X[fitness.argmin()], fitness.min()
            spent = yield
            a = 2.0 * (1.0 - spent)
            A = 2.0 * a * rng.random((n, 1)) - a  # (2.3)
            C = 2.0 * rng.random((n, 1))  # (2.4)
            leader = np.where(np.abs(A) < 1.0, best, X[rng.integers(n, size=n)])
            encircling = leader - A * np.abs(C * leader - X)  # (2.1), (2.2); (2.7), (2.8) where |A| >= 1
            l = rng.uniform(-1.0, 1.0, (n, 1))  # noqa: E741
            spiral = np.abs(best - X) * exp(l) * np.cos(2.0 * np.pi * l) + best  # (2.5), b = 1
            X = np.clip(np.where(rng.random((n, 1)) < 0.5, encircling, spiral), 0.0, 1.0)  # (2.6)


class MFO(WaypointSearch):
    """The moth-flame optimization algorithm: each moth spirals around a flame of its own.

    The flames are the best vectors so far, and become fewer.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, "Moth-flame optimization algorithm", Knowledge-Based Systems 89 (2015), 228-249.
    """

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        n = len(first)
        M = first
        fitness = evaluate(M)
        F, lowest = M, fitness
        while True:
            order = np.argsort(lowest, kind="stable")[:n]
            F, lowest = F[order], lowest[order]
            spent = yield
            flames = round(n - spent * (n - 1))  # (3.14)
            flame = F[np.minimum(np.arange(n), flames - 1)]
            t = 1.0 - (2.0 + spent) * rng.random(M.shape)  # from r = -1 - spent to 1
            M = np.abs(flame - M) * exp(t) * np.cos(2.0 * np.pi * t) + flame  # (3.12), (3.13), b = 1
            M = np.clip(M, 0.0, 1.0)
            F, lowest = np.concatenate([F, M]), np.concatenate([lowest, evaluate(M)])


_LEVY_BETA = 1.5
_LEVY_SIGMA = (
    math.gamma(1 + _LEVY_BETA)
    * math.sin(math.pi * _LEVY_BETA / 2)
    / (math.gamma((1 + _LEVY_BETA) / 2) * _LEVY_BETA * 2 ** ((_LEVY_BETA - 1) / 2))
) ** (1 / _LEVY_BETA)  # (3.10)


class DA(WaypointSearch):
    """The dragonfly algorithm: a swarm drawn to the best vector so far, the food, and away from the worst.

    Where the paper is silent (weights, radius, largest step, random flight), this follows the author's code.

    Its settings are those of `WaypointSearch`.

    References
    ----------
    S. Mirjalili, "Dragonfly algorithm", Neural Computing and Applications 27 (2016), 1053-1073.
    """

    def optimise(self, evaluate: Evaluate, first: Floats, rng: np.random.Generator, /) -> Iterations:
        """Run the optimiser; see `WaypointSearch.optimise`."""
        n, d = first.shape
        X, step = first.copy(), rng.random((n, d))
        food, least, enemy, most = X[0], math.inf, X[0], -math.inf
        while True:
            fitness = evaluate(X)
            if fitness.min() < least:
                food, least = X[fitness.argmin()].copy(), fitness.min()
            inside = np.where(np.all((X > 0.0) & (X < 1.0), axis=1), fitness, -math.inf)
            if inside.max() > most:
                enemy, most = X[inside.argmax()].copy(), inside.max()
            spent = yield
            radius = 0.25 + 2.0 * spent
            w = 0.9 - 0.5 * spent
            e = max(0.0, 0.1 - 0.2 * spent)
            s, a, c = 2.0 * e * rng.random(3)
            f = 2.0 * rng.random()
            for i in range(n):
                apart = np.abs(X - X[i])
                near = np.all(apart <= radius, axis=1) & np.any(apart > 0.0, axis=1)
                S = -(X[near] - X[i]).sum(axis=0)  # (3.1) as in the author's code: away from them
                A = step[near].mean(axis=0) if near.any() else step[i]  # (3.2)
                C = X[near].mean(axis=0) - X[i] if near.any() else np.zeros(d)  # (3.3)
                F = food - X[i]  # (3.4)
                E = enemy + X[i] if np.all(np.abs(enemy - X[i]) <= radius) else np.zeros(d)  # (3.5)
                if np.all(np.abs(F) <= radius):
                    step[i] = s * S + a * A + c * C + f * F + e * E + w * step[i]  # (3.6)
                elif near.sum() > 1:
                    step[i] = w * step[i] + rng.random(d) * A + rng.random(d) * C + rng.random(d) * S
                else:
                    step[i] = 0.0
                    X[i] += _levy(rng, d) * X[i]  # (3.8)
                step[i] = np.clip(step[i], -0.1, 0.1)
                X[i] = np.clip(X[i] + step[i], 0.0, 1.0)  # (3.7)


def _levy(rng: np.random.Generator, d: int) -> Floats:
    r1, r2 = rng.standard_normal((2, d))
    return 0.01 * r1 * _LEVY_SIGMA / power(np.abs(r2), 1.0 / _LEVY_BETA)  # (3.9)
