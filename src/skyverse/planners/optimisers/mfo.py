"""The moth-flame optimization algorithm (Mirjalili 2015)."""

import numpy as np

from skyverse._typing import Floats
from skyverse.model.arrays import exp
from skyverse.planners.optimisers import Evaluate, Iterations


def mfo(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Let each moth spiral around a flame of its own; the flames are the best vectors so far, and become fewer.

    References
    ----------
    S. Mirjalili, "Moth-flame optimization algorithm: A novel nature-inspired heuristic paradigm", Knowledge-Based
    Systems 89 (2015), 228-249.
    """
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
