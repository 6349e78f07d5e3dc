"""Statistical tests, effect sizes and ranks of costs, where less is better; every two planners compared.

A cost may be infinite, where a run found no path at all; it is worse than any other cost, and equal to itself.
"""

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats

SIGNIFICANCE_LEVEL = 0.05
"""The significance level of all tests; confidence intervals hold with 1 - SIGNIFICANCE_LEVEL."""
MIN_RESAMPLED_RUNS = 5
"""A bootstrap interval needs at least this many runs."""


class Interval(NamedTuple):
    """A confidence interval."""

    low: float
    high: float


class Sample(NamedTuple):
    """The mean of some values, their standard deviation, which is nan below two or with an infinite one, and number."""

    mean: float
    deviation: float
    runs: int

    @property
    def error(self) -> float:
        """The standard error of the mean."""
        return self.deviation / math.sqrt(self.runs)

    def __str__(self) -> str:
        return f"{self.mean:.1f} ± {self.error:.1f}"


def sample(values: ArrayLike) -> Sample:
    """Return the sample of `values`, (n,)."""
    numbers = np.asarray(values, dtype=np.float64)
    known = len(numbers) > 1 and np.isfinite(numbers).all()
    return Sample(float(np.mean(numbers)), float(np.std(numbers, ddof=1)) if known else math.nan, len(numbers))


def quantile(values: Floats, q: float) -> Floats:
    """Return the `q`-quantile over the first axis, interpolated linearly; some values may be infinite."""
    ordered = np.sort(values, axis=0)
    place = q * (len(values) - 1)
    low, high = ordered[math.floor(place)], ordered[math.ceil(place)]
    with np.errstate(invalid="ignore"):
        between = low + (high - low) * (place - math.floor(place))
    return np.where(low == high, low, between)


def bootstrap(values: Floats, *, seed: int = 0) -> Interval | None:
    """Return the BCa bootstrap interval of the mean from 2,000 resamples drawn with `seed`.

    It is ``None`` for fewer values than `MIN_RESAMPLED_RUNS`, or where one is infinite.

    Where BCa is not defined, because the mean is an end of its resampled values, the percentiles are taken.
    """
    from scipy.stats import DegenerateDataWarning
    from scipy.stats import bootstrap as resample

    if len(values) < MIN_RESAMPLED_RUNS or not np.isfinite(values).all():
        return None
    if np.ptp(values) == 0:
        return Interval(float(values[0]), float(values[0]))
    for method in ("BCa", "percentile"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DegenerateDataWarning)
            found = resample(
                (values,),
                np.mean,
                n_resamples=2000,
                batch=max(1, 1_000_000 // len(values)),
                confidence_level=1 - SIGNIFICANCE_LEVEL,
                method=method,
                rng=np.random.default_rng(seed),
            ).confidence_interval
        if np.isfinite(found).all():
            break
    return Interval(float(found.low), float(found.high))


def wilson(successes: int, runs: int) -> Interval:
    """Return Wilson's interval of a success rate; `runs` is at least 1."""
    from scipy.stats import binomtest

    found = binomtest(successes, runs).proportion_ci(1 - SIGNIFICANCE_LEVEL, method="wilson")
    return Interval(float(found.low), float(found.high))


def wilcoxon(a: ArrayLike, b: ArrayLike) -> float:
    """Return the two-sided p of Wilcoxon's signed-rank test of the pairs (`a`, `b`), (n,) each.

    Pairs of equal values are left out; where all pairs are equal, p is 1. Exact up to 50 unequal pairs, also with ties.
    """
    from scipy import stats

    differences = _differences(a, b)
    n = len(differences)
    if n == 0:
        return 1.0
    if n > 50:
        return float(stats.wilcoxon(differences).pvalue)
    doubled = np.rint(2 * stats.rankdata(np.abs(differences))).astype(np.int64)  # tied ranks are halves
    chance = np.zeros(doubled.sum() + 1)
    chance[0] = 0.5**n
    for rank in doubled:
        chance[rank:] += chance[:-rank].copy()
    less = min(doubled[differences > 0].sum(), doubled[differences < 0].sum())
    return min(1.0, 2 * float(chance[: less + 1].sum()))


def mann_whitney(a: ArrayLike, b: ArrayLike) -> float:
    """Return the two-sided p of the Mann-Whitney test of two samples, (n,) and (m,); 1 where all values are equal."""
    from scipy import stats

    first, second = np.asarray(a, np.float64), np.asarray(b, np.float64)
    if np.all(first == first[0]) and np.all(second == first[0]):
        return 1.0
    return min(1.0, float(stats.mannwhitneyu(first, second).pvalue))


def combined(p: ArrayLike, effect: ArrayLike) -> tuple[float, float | None]:
    """Combine two-sided p-values of independent tests of one hypothesis, (k,), whose effects have a sign, (k,).

    Returns
    -------
    p, heterogeneity
        By Stouffer's sum of z over the square root of k; and of the hypothesis that all effects have the same sign
        (Gail, Simon 1985), by the sum of squared z of those whose sign is rarer; ``None`` if k = 1.
    """
    from scipy.stats import binom, chi2, norm

    z = norm.isf(np.maximum(np.asarray(p, np.float64), 1e-300) / 2) * np.sign(effect)
    whole = float(2 * norm.sf(abs(z.sum()) / math.sqrt(len(z))))
    if len(z) == 1:
        return whole, None
    against, other = min(np.square(z[z < 0]).sum(), np.square(z[z > 0]).sum()), np.arange(1, len(z))
    return whole, float(np.sum(binom.pmf(other, len(z) - 1, 0.5) * chi2.sf(against, other))) if against else 1.0


def holm(p: ArrayLike) -> Floats:
    """Return `p`, (m,), adjusted for m tests (Holm 1979)."""
    raw = np.asarray(p, dtype=np.float64)
    order = np.argsort(raw, kind="stable")
    adjusted = np.empty_like(raw)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(raw[order] * np.arange(len(raw), 0, -1)))
    return adjusted


def a12(a: ArrayLike, b: ArrayLike) -> float:
    """Return the probability that a value of `a` exceeds one of `b`; ties count half (Vargha & Delaney 2000)."""
    from scipy.stats import rankdata

    first, second = np.asarray(a, np.float64), np.asarray(b, np.float64)
    n, m = len(first), len(second)
    wins = rankdata(np.concatenate([first, second]))[:n].sum() - n * (n + 1) / 2
    return float(wins / (n * m))


def magnitude(chance: float) -> str:
    """Return Vargha and Delaney's word for an A12."""
    far = max(chance, 1.0 - chance) + 1e-12
    return "large" if far >= 0.71 else "medium" if far >= 0.64 else "small" if far >= 0.56 else "negligible"


def rank_biserial(a: ArrayLike, b: ArrayLike) -> float:
    """Return the matched-pairs rank-biserial correlation, from -1 (`a` always less) to 1; 0 where all are equal.

    It is the positive differences' share of the sum of ranks less the share of the negative ones (Kerby 2014).
    """
    from scipy.stats import rankdata

    differences = _differences(a, b)
    if len(differences) == 0:
        return 0.0
    ranks = rankdata(np.abs(differences))
    return float(np.sum(ranks * np.sign(differences)) / ranks.sum())


def _differences(a: ArrayLike, b: ArrayLike) -> Floats:
    first, second = np.asarray(a, np.float64), np.asarray(b, np.float64)
    unequal = first != second  # two infinite costs, whose difference is undefined, are equal
    return first[unequal] - second[unequal]


@dataclass(frozen=True)
class Ranking:
    """Friedman's test and Nemenyi's test of k planners over n blocks.

    Attributes
    ----------
    ranks
        (k,) mean ranks; 1 is best, ties share.
    blocks
        The number of blocks, n.
    chi2, p
        Friedman's statistic and p-value, corrected for ties.
    f, p_f
        Iman and Davenport's corrected statistic and p-value, which are less conservative.
    critical_difference
        Mean ranks that differ by more differ significantly (Nemenyi).
    groups
        The largest sets of two or more planners that do not differ significantly, as indices from best to worst.
    """

    ranks: Floats
    blocks: int
    chi2: float
    p: float
    f: float
    p_f: float
    critical_difference: float
    groups: tuple[tuple[int, ...], ...]


def ranking(costs: ArrayLike) -> Ranking:
    """Rank planners by `costs`, (n blocks, k planners), n >= 2 and k >= 3 (Friedman; Demsar 2006).

    Raises
    ------
    ValueError
        If there are fewer blocks or planners.
    """
    from scipy import stats

    table = np.asarray(costs, dtype=np.float64)
    n, k = table.shape
    if n < 2 or k < 3:
        raise ValueError(f"expected at least 2 blocks and 3 planners, found {n} and {k}")
    ranks: Floats = np.array([stats.rankdata(row) for row in table]).mean(axis=0)
    tied = bool(np.all(table == table[:, :1]))
    chi2, p = (0.0, 1.0) if tied else map(float, stats.friedmanchisquare(*table.T))
    rest = n * (k - 1) - chi2
    f = (n - 1) * chi2 / rest if rest > 1e-9 else math.inf
    p_f = float(stats.f.sf(f, k - 1, (k - 1) * (n - 1)))
    difference = critical_difference(k, n)
    return Ranking(ranks, n, chi2, p, f, p_f, difference, groups(ranks, difference))


def critical_difference(planners: int, blocks: int) -> float:
    """Return Nemenyi's critical difference of mean ranks (Demsar 2006)."""
    from scipy.stats import studentized_range

    q = float(studentized_range.ppf(1 - SIGNIFICANCE_LEVEL, planners, np.inf)) / math.sqrt(2)
    return q * math.sqrt(planners * (planners + 1) / (6 * blocks))


def groups(ranks: Sequence[float] | Floats, difference: float) -> tuple[tuple[int, ...], ...]:
    """Return the largest sets of two or more whose `ranks` differ by at most `difference`; see `Ranking.groups`."""
    order = [int(index) for index in np.argsort(ranks, kind="stable")]
    found: list[tuple[int, ...]] = []
    reached = 0
    for first in range(len(order)):
        last = first
        while last + 1 < len(order) and ranks[order[last + 1]] - ranks[order[first]] <= difference:
            last += 1
        if last > first and last > reached:
            found.append(tuple(order[first : last + 1]))
            reached = last
    return tuple(found)


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
