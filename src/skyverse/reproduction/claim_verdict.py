"""The verdict on a claim of the thesis, and how far means differ behind it (Welch), with what runs could have told."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from skyverse._typing import Floats
from skyverse.lab.report import Block, Cell, Table, Text
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, Interval, Sample, holm, sample

POWER = 0.8
"""The power with which the least detectable difference is seen."""
SAME_WITHIN = 0.03
"""Means that are shown to differ by less than this share are the same."""


@dataclass(frozen=True)
class MeanDifference:
    """The difference of two means with its standard error and Welch's degrees of freedom."""

    value: float
    error: float
    freedom: float

    def above(self, bound: float) -> float:
        """Return the one-sided p of the test that the difference is above `bound`."""
        from scipy.stats import t

        if self.error == 0:
            return float(self.value <= bound)
        return float(t.sf((self.value - bound) / self.error, self.freedom))

    def below(self, bound: float) -> float:
        """Return the one-sided p of the test that the difference is below `bound`."""
        return MeanDifference(-self.value, self.error, self.freedom).above(-bound)

    @property
    def p(self) -> float:
        """The two-sided p of Welch's test."""
        return min(1.0, 2 * min(self.above(0.0), self.below(0.0)))

    def equivalent(self, margin: float) -> float:
        """Return the p of two one-sided tests (TOST) that the difference lies within ± `margin`."""
        return max(self.above(-margin), self.below(margin))

    @property
    def interval(self) -> Interval:
        """The confidence interval."""
        reach = self._quantile(1 - SIGNIFICANCE_LEVEL / 2) * self.error
        return Interval(self.value - reach, self.value + reach)

    @property
    def detectable(self) -> float:
        """The least difference that a two-sided test would have found with probability `POWER`."""
        return (self._quantile(1 - SIGNIFICANCE_LEVEL / 2) + self._quantile(POWER)) * self.error

    def _quantile(self, probability: float) -> float:
        from scipy.stats import t

        return float(t.ppf(probability, self.freedom))


def mean_difference(first: Sample, second: Sample) -> MeanDifference:
    """Return how far the mean of `first` lies above that of `second`."""
    parts = [one.deviation**2 / one.runs for one in (first, second)]
    spread = sum(part**2 / (one.runs - 1) for part, one in zip(parts, (first, second), strict=True))
    freedom = sum(parts) ** 2 / spread if spread else math.inf
    return MeanDifference(first.mean - second.mean, math.sqrt(sum(parts)), freedom)


def deviations_differ(first: Sample, second: Sample) -> float:
    """Return the two-sided p of the F test that two standard deviations differ, of normal samples."""
    from scipy.stats import f

    ratio, freedom = (first.deviation / second.deviation) ** 2, (first.runs - 1, second.runs - 1)
    return 2 * float(min(f.sf(ratio, *freedom), f.cdf(ratio, *freedom)))


LOWER = (-math.inf, 0.0)


class ClaimVerdict(Enum):
    """Whether a claim holds."""

    HOLDS = "holds"
    AS_PUBLISHED = "holds as published"
    UNEQUAL = "holds only at unequal effort"
    NOT_SHOWN = "not shown at equal effort"
    FAILS = "does not hold"
    OPEN = "cannot be told"


@dataclass(frozen=True)
class Evidence:
    """The p of the test that would show what a claim asks of one comparison, and of the test that would refute it."""

    shown: float
    refuted: float


@dataclass(frozen=True)
class Comparison:
    """Two samples, of which the mean of the first, as a share of the second's, is asked to lie in a range.

    Attributes
    ----------
    asked
        The range of the difference over the second mean; `LOWER` asks for a lower mean.
    """

    where: str
    names: tuple[str, str]
    first: Floats
    second: Floats
    asked: tuple[float, float] = LOWER

    @property
    def difference(self) -> MeanDifference:
        """How far the first mean lies above the second, as a share of the second."""
        found, base = mean_difference(sample(self.first), sample(self.second)), float(self.second.mean())
        return MeanDifference(found.value / base, found.error / base, found.freedom)

    def evidence(self, *, same_refutes: bool = False) -> Evidence:
        """Test both ways, two-sided; with `same_refutes`, so do means within `SAME_WITHIN` (TOST)."""
        found, (low, high) = self.difference, self.asked
        shown, refuted = max(found.above(low), found.below(high)), min(found.below(low), found.above(high))
        same = found.equivalent(SAME_WITHIN) if same_refutes else 1.0
        return Evidence(min(1.0, 2 * shown), min(1.0, 2 * refuted, same))

    def record(self) -> dict[str, Cell]:
        """Return the row of a table."""
        found, (a, b) = self.difference, self.names
        means = [float(values.mean()) for values in (self.first, self.second)]
        low, high = (f"{end:+.1%}" for end in found.interval)
        return {
            "where": self.where,
            "means": f"{a} {counted(means[0])}, {b} {counted(means[1])}",
            "difference": f"{found.value:+.1%}",
            "95 % interval": f"{low} to {high}",
            "p": "< 0.001" if found.p < 0.001 else f"{found.p:.2g}",
            "could be seen": f"{found.detectable:.1%} ({counted(found.detectable * means[1])})",
        }


@dataclass(frozen=True)
class Finding:
    """The verdict on a claim for one form of the methods, the numbers behind it, and the rows of their table."""

    verdict: ClaimVerdict
    evidence: str
    comparisons: Sequence[Comparison] = ()

    def blocks(self, form: str) -> list[Block]:
        """Return the verdict for a form of the methods in words, and the table of what was compared."""
        told: list[Block] = [Text(f"*{form.capitalize()}*: **{self.verdict.value}**. {self.evidence}".strip())]
        return [*told, Table.from_records([one.record() for one in self.comparisons])] if self.comparisons else told


def verdict(published: Sequence[Evidence], equal: Sequence[Evidence] = ()) -> ClaimVerdict:
    """Return the verdict on a claim that needs all of its comparisons, at the published iterations and at equal effort.

    All have to be shown, each at the significance level (an intersection-union test needs no adjustment); any refutes
    the claim, adjusted by Holm's method. Where nothing is compared at equal effort, a claim holds as published at most.
    """
    if _refuted(published):
        return ClaimVerdict.FAILS
    if not _shown(published):
        return ClaimVerdict.OPEN
    if not equal:
        return ClaimVerdict.AS_PUBLISHED
    if _shown(equal):
        return ClaimVerdict.HOLDS
    return ClaimVerdict.UNEQUAL if _refuted(equal) else ClaimVerdict.NOT_SHOWN


def judged(
    published: Sequence[Comparison], equal: Sequence[Comparison] = (), text: str = "", *, same_refutes: bool = False
) -> Finding:
    """Judge a claim by its comparisons; `text` is said beside them."""
    at_equal = [one.evidence(same_refutes=same_refutes) for one in equal]
    return Finding(verdict([one.evidence() for one in published], at_equal), text, (*published, *equal))


def counted(value: float) -> str:
    """Return a cost with a decimal, a larger number of nodes without."""
    return f"{value:,.0f}" if abs(value) >= 5000 else f"{value:.1f}"


def _shown(found: Sequence[Evidence]) -> bool:
    return all(one.shown < SIGNIFICANCE_LEVEL for one in found)


def _refuted(found: Sequence[Evidence]) -> bool:
    """Whether any comparison that does not show the claim refutes it."""
    against = holm([one.refuted if one.shown >= SIGNIFICANCE_LEVEL else 1.0 for one in found])
    return bool((against < SIGNIFICANCE_LEVEL).any())
