"""Statistical tests of every two planners, scenario by scenario, and over scenarios where these agree."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, a12, combined, holm, mann_whitney, rank_biserial, wilcoxon

Costs = Mapping[str, Mapping[int, float]]
"""Costs by scenario and seed."""


@dataclass(frozen=True)
class PairwiseTest:
    """How the costs of one planner compare with those of another.

    Attributes
    ----------
    runs
        The number of pairs by seed (Wilcoxon), or of runs of both that were not paired (Mann-Whitney).
    chance
        The probability that a run of the first planner is cheaper than one of the second in the same scenario, where
        ties count half: Vargha and Delaney's A12, averaged over the scenarios.
    correlation
        Matched-pairs rank-biserial, 1 where the first planner is always cheaper; ``None`` where runs were not paired.
    p
        Of the scenario's test, or of the tests of several combined (Stouffer); adjusted by Holm for all pairs that were
        tested together; ``None`` where there are too few runs.
    heterogeneity
        The p of the hypothesis that the same planner is better in all scenarios; ``None`` for a single one.
    """

    runs: int
    chance: float
    correlation: float | None
    p: float | None
    heterogeneity: float | None

    @property
    def paired(self) -> bool:
        """Whether runs were paired by seed."""
        return self.correlation is not None

    @property
    def scenarios_disagree(self) -> bool:
        """Whether one planner is better in some scenarios and the other in others, so that neither is in general."""
        return self.heterogeneity is not None and self.heterogeneity < SIGNIFICANCE_LEVEL


def compare_pairs(planners: Sequence[Costs], *, paired: bool = False) -> dict[tuple[int, int], PairwiseTest]:
    """Compare every two planners in the scenarios that both have run; return the tests by the planners' indices.

    If `paired`, runs with the same seed are pairs, as where a seed makes the same movers for all; else a seed means
    nothing from one planner to another.
    """
    found = {
        (i, j): _compare(planners[i], planners[j], both, paired)
        for i, j in combinations(range(len(planners)), 2)
        if (both := [scenario for scenario, costs in planners[i].items() if costs and planners[j].get(scenario)])
    }
    tested = [(pair, contrast.p) for pair, contrast in found.items() if contrast.p is not None]
    for (pair, _), p in zip(tested, holm([p for _, p in tested]), strict=True):
        found[pair] = replace(found[pair], p=float(p))
    return found


def _compare(first: Costs, second: Costs, scenarios: Sequence[str], paired: bool) -> PairwiseTest:
    alone = [_in_one(first[scenario], second[scenario], paired) for scenario in scenarios]
    runs, chances, correlations, tested, least = zip(*alone, strict=True)
    correlation = None if None in correlations else float(np.mean(correlations))
    p, heterogeneity = combined(tested, np.subtract(chances, 0.5) if correlation is None else correlations)
    enough = combined(least, np.ones(len(least)))[0] <= SIGNIFICANCE_LEVEL
    return PairwiseTest(sum(runs), float(np.mean(chances)), correlation, p if enough else None, heterogeneity)


def _in_one(
    first: Mapping[int, float], second: Mapping[int, float], paired: bool
) -> tuple[int, float, float | None, float, float]:
    """Return runs, chance, correlation and p in one scenario, and the least p that so many runs could have."""
    a, b = (np.array(list(costs.values())) for costs in (first, second))
    chance, pairs = a12(b, a), [(first[seed], second[seed]) for seed in first if seed in second]
    if paired and 2 * len(pairs) >= max(len(a), len(b)):
        one, other = np.array(pairs).T
        return len(pairs), chance, rank_biserial(other, one), wilcoxon(one, other), 2.0 ** (1 - len(pairs))
    least = min(1.0, 2 / math.comb(len(a) + len(b), len(a)))
    return len(a) + len(b), chance, None, mann_whitney(a, b), least
