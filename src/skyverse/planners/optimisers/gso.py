"""Glowworm Swarm Optimization (Krishnanand, Ghose 2009)."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations


def gso(
    evaluate: Evaluate,
    first: Floats,
    rng: np.random.Generator,
    glow: tuple[float, float, float],
    length: float,
    reach: float,
    neighbours: int,
    beta: float,
) -> Iterations:
    """Let each glowworm move towards a brighter one in its decision range; brightness J is the negated fitness.

    Of `glow` are luciferin at the start, its decay rho and gain gamma. Lengths are shares of the diagonal of [0, 1]^d.

    References
    ----------
    K. N. Krishnanand, D. Ghose, "Glowworm swarm optimization for simultaneous capture of multiple local optima of
    multimodal functions", Swarm Intelligence 3 (2009), 87-124.
    """
    luciferin, decay, gain = glow
    n, d = first.shape
    length, reach, beta = (share * math.sqrt(d) for share in (length, reach, beta))
    X, J = first, -evaluate(first)
    l, r = np.full(n, luciferin), np.full(n, reach)  # noqa: E741
    while True:
        yield
        l = (1.0 - decay) * l + gain * J  # (1)  # noqa: E741
        apart = np.sqrt(np.square(X[:, None] - X).sum(axis=2))
        brighter = l - l[:, None]  # row i: how much brighter each j is
        seen = (brighter > 0.0) & (apart < r[:, None])
        wheel = np.cumsum(np.where(seen, brighter, 0.0), axis=1)  # (2): p_ij is as l_j - l_i
        j = (wheel <= rng.random((n, 1)) * wheel[:, -1:]).sum(axis=1).clip(max=n - 1)
        moves = seen[np.arange(n), j]
        away = apart[np.arange(n), j]
        X = X.copy()
        X[moves] += length * ((X[j] - X) / np.where(away > 0.0, away, 1.0)[:, None])[moves]  # (3)
        r = np.clip(r + beta * (neighbours - seen.sum(axis=1)), 0.0, reach)  # (4)
        J = -evaluate(X)
