"""Biogeography-Based Optimization (Simon 2008)."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations


def bbo(
    evaluate: Evaluate,
    first: Floats,
    rng: np.random.Generator,
    mutation: float = 0.01,
    elites: int = 2,
    greedy: bool = False,
) -> Iterations:
    """Let habitats take over numbers from others by migration, the good ones giving and the poor ones taking most.

    A changed habitat replaces the old one, if `greedy` only where it is no worse, and the `elites` survive. The best of
    n habitats counts n species, the worst one. A number is drawn anew with probability m_max (1 - P/P_max), where P is
    how likely so many species are; the paper prints m_max (1 - P)/P_max, which may exceed 1.

    References
    ----------
    D. Simon, "Biogeography-Based Optimization", IEEE Transactions on Evolutionary Computation 12 (2008), 702-713.
    """
    n, d = first.shape
    species = np.arange(n, 0, -1)
    immigration, emigration = 1.0 - species / n, species / n  # of the best habitat first
    chance = np.array([math.comb(n, k) / math.comb(n, n // 2) for k in species.tolist()])  # P/P_max by theorem 1, E = I
    mutate = mutation * (1.0 - chance)
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
        if greedy:
            worse = new > cost
            X[worse], new[worse] = H[worse], cost[worse]
        H, cost = np.concatenate([H[:elites], X]), np.concatenate([cost[:elites], new])
        kept = np.argsort(cost, kind="stable")[:n]
        H, cost = H[kept], cost[kept]
