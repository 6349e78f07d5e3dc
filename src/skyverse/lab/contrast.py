"""Planners against each other, two at a time: paired by run where runs can be paired."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from skyverse.lab.statistics import LEVEL, a12, holm, mann_whitney, rank_biserial, wilcoxon

Costs = Mapping[str, Mapping[int, float]]
"""Costs by scenario and seed."""


@dataclass(frozen=True)
class Contrast:
    """How one planner's costs compare with another's.

    Attributes
    ----------
    paired, runs
        Whether runs were paired (Wilcoxon) or not (Mann-Whitney), and how many pairs, or runs of both, there were.
    chance
        That a run of the first is cheaper than one of the second in the same scenario, ties counted half: Vargha and
        Delaney's A12, its mean over scenarios.
    correlation
        Matched-pairs rank-biserial, 1 where the first is always cheaper; ``None`` where runs were not paired.
    p
        Adjusted for all contrasts that were made together (Holm); ``None`` where so few runs cannot tell.
    """

    paired: bool
    runs: int
    chance: float
    correlation: float | None
    p: float | None


def contrasts(planners: Sequence[Costs]) -> dict[tuple[int, int], Contrast]:
    """Compare every two of the planners that have runs in a common scenario, there."""
    found = {
        (i, j): _contrast(planners[i], planners[j], both)
        for i, j in combinations(range(len(planners)), 2)
        if (both := [scenario for scenario, costs in planners[i].items() if costs and planners[j].get(scenario)])
    }
    tested = [(pair, contrast.p) for pair, contrast in found.items() if contrast.p is not None]
    for (pair, _), p in zip(tested, holm([p for _, p in tested]), strict=True):
        found[pair] = replace(found[pair], p=float(p))
    return found


def _contrast(first: Costs, second: Costs, scenarios: Sequence[str]) -> Contrast:
    samples = [[list(costs[scenario].values()) for costs in (first, second)] for scenario in scenarios]
    chance = float(np.mean([a12(b, a) for a, b in samples]))
    n, m = (sum(len(sample[side]) for sample in samples) for side in (0, 1))
    pairs = [(first[s][seed], second[s][seed]) for s in scenarios for seed in first[s] if seed in second[s]]
    if 2 * len(pairs) >= max(n, m):
        a, b = np.array(pairs).T
        p = wilcoxon(a, b) if 2.0 ** (1 - len(pairs)) <= LEVEL else None
        return Contrast(True, len(pairs), chance, rank_biserial(b, a), p)
    a, b = (np.concatenate([sample[side] for sample in samples]) for side in (0, 1))
    p = mann_whitney(a, b) if 2 / math.comb(n + m, n) <= LEVEL else None
    return Contrast(False, n + m, chance, None, p)
