"""The whale optimization algorithm (Mirjalili, Lewis 2016)."""

import numpy as np

from skyverse._typing import Floats
from skyverse.model.arrays import exp
from skyverse.planners.optimisers import Evaluate, Iterations


def woa(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Let whales encircle the best or a random whale, or spiral around the best; A and C are one number for each whale.

    References
    ----------
    S. Mirjalili, A. Lewis, "The Whale Optimization Algorithm", Advances in Engineering Software 95 (2016), 51-67.
    """
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
