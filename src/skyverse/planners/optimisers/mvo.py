"""The Multi-Verse Optimizer (Mirjalili, Mirjalili, Hatamlou 2016), as section 3.2 of the thesis has it."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.planners.optimisers import Evaluate, Iterations


def mvo(
    evaluate: Evaluate,
    first: Floats,
    rng: np.random.Generator,
    wep: tuple[float, float] = (0.2, 1.0),
    p: float = 6.0,
    greedy: bool = False,
) -> Iterations:
    """Let universes, whose objects are numbers, exchange them through white holes, and wormholes lead to the best.

    `wep` is the wormhole existence probability at the start and at the end. The universes are sorted anew in every
    iteration, and the best of them is left alone. A changed universe replaces the old one, if `greedy` only where it is
    no worse. Three oddities of the printed equations:

    - **roulette wheel** of (3.6): over negated costs, as in the author's code, it nearly always picks the best, and
      over costs it prefers the worst; here it is over ranks;
    - **reach** in (3.7): TDR ((ub - lb) r4 + lb) depends on where the origin lies; in [0, 1] it is TDR r4;
    - **TDR** (3.9) falls, where the text says that it is increased.

    References
    ----------
    S. Mirjalili, S. M. Mirjalili, A. Hatamlou, "Multi-Verse Optimizer", Neural Computing and Applications 27 (2016),
    495-513.
    """
    n, d = first.shape
    wheel = np.cumsum(np.arange(n, 0, -1))
    U, cost = first, evaluate(first)  # (3.5)
    while True:
        order = np.argsort(cost, kind="stable")
        U, cost = U[order], cost[order]
        spent = yield
        exists = wep[0] + spent * (wep[1] - wep[0])  # (3.8)
        tdr = 1.0 - spent ** (1.0 / p)  # (3.9)
        r1, r2, r3, r4, spin = rng.random((5, n - 1, d))
        norm = math.sqrt(np.square(cost).sum())
        k = np.searchsorted(wheel, spin * wheel[-1], side="right")
        X = np.where(r1 * norm < cost[1:, None], U[k, np.arange(d)], U[1:])  # (3.6), NI = cost / norm
        X = np.where(r2 < exists, U[0] + np.where(r3 < 0.5, tdr, -tdr) * r4, X)  # (3.7)
        X = np.clip(X, 0.0, 1.0)
        new = evaluate(X)
        if greedy:
            worse = new > cost[1:]
            X[worse], new[worse] = U[1:][worse], cost[1:][worse]
        U, cost = np.concatenate([U[:1], X]), np.concatenate([cost[:1], new])
