"""The dragonfly algorithm (Mirjalili 2016)."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.model.arrays import power
from skyverse.planners.optimisers import Evaluate, Iterations

_BETA = 1.5
_SIGMA = (
    math.gamma(1 + _BETA)
    * math.sin(math.pi * _BETA / 2)
    / (math.gamma((1 + _BETA) / 2) * _BETA * 2 ** ((_BETA - 1) / 2))
) ** (1 / _BETA)  # (3.10)


def da(evaluate: Evaluate, first: Floats, rng: np.random.Generator) -> Iterations:
    """Let dragonflies swarm with their neighbours towards the food, the best vector so far, and away from the worst.

    Where the paper is silent (weights, radius, largest step, random flight), this follows the author's code.

    References
    ----------
    S. Mirjalili, "Dragonfly algorithm: a new meta-heuristic optimization technique", Neural Computing and Applications
    27 (2016), 1053-1073.
    """
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
    return 0.01 * r1 * _SIGMA / power(np.abs(r2), 1.0 / _BETA)  # (3.9)
