"""Statistical tests of every two planners, on runs that are paired by scenario and seed where they can be."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, a12, holm, mann_whitney, rank_biserial, wilcoxon

Costs = Mapping[str, Mapping[int, float]]
"""Costs by scenario and seed."""


@dataclass(frozen=True)
class PairwiseTest:
    """How the costs of one planner compare with those of another.

    Attributes
    ----------
    paired, runs
        Whether runs were paired (Wilcoxon) or not (Mann-Whitney), and the number of pairs, or else of runs of both.
    chance
        The probability that a run of the first planner is cheaper than one of the second in the same scenario, where
        ties count half: Vargha and Delaney's A12, averaged over the scenarios.
    correlation
        Matched-pairs rank-biserial, 1 where the first planner is always cheaper; ``None`` where runs were not paired.
    p
        Adjusted by Holm for all pairs that were tested together; ``None`` where there are too few runs.
    """

    paired: bool
    runs: int
    chance: float
    correlation: float | None
    p: float | None


def compare_pairs(planners: Sequence[Costs]) -> dict[tuple[int, int], PairwiseTest]:
    """Compare every two planners in the scenarios that both have run; return the tests by the planners' indices."""
    found = {
        (i, j): _compare(planners[i], planners[j], both)
        for i, j in combinations(range(len(planners)), 2)
        if (both := [scenario for scenario, costs in planners[i].items() if costs and planners[j].get(scenario)])
    }
    tested = [(pair, contrast.p) for pair, contrast in found.items() if contrast.p is not None]
    for (pair, _), p in zip(tested, holm([p for _, p in tested]), strict=True):
        found[pair] = replace(found[pair], p=float(p))
    return found


def _compare(first: Costs, second: Costs, scenarios: Sequence[str]) -> PairwiseTest:
    samples = [[list(costs[scenario].values()) for costs in (first, second)] for scenario in scenarios]
    chance = float(np.mean([a12(b, a) for a, b in samples]))
    n, m = (sum(len(sample[side]) for sample in samples) for side in (0, 1))
    pairs = [(first[s][seed], second[s][seed]) for s in scenarios for seed in first[s] if seed in second[s]]
    if 2 * len(pairs) >= max(n, m):
        a, b = np.array(pairs).T
        p = wilcoxon(a, b) if 2.0 ** (1 - len(pairs)) <= SIGNIFICANCE_LEVEL else None
        return PairwiseTest(True, len(pairs), chance, rank_biserial(b, a), p)
    a, b = (np.concatenate([sample[side] for sample in samples]) for side in (0, 1))
    p = mann_whitney(a, b) if 2 / math.comb(n + m, n) <= SIGNIFICANCE_LEVEL else None
    return PairwiseTest(False, n + m, chance, None, p)
