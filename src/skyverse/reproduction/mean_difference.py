"""How far one mean lies above another, with what the runs tell of it and what they could have told (Welch)."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from skyverse._typing import Floats
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, Interval

POWER = 0.8
"""The power with which the least detectable difference is seen."""
SAME_WITHIN = 0.03
"""Means that are shown to differ by less than this share are the same."""


class Sample(NamedTuple):
    """The mean, the standard deviation and the number of runs."""

    mean: float
    deviation: float
    runs: int


def sample(values: Floats) -> Sample:
    """Return the sample of two or more values, (n,)."""
    return Sample(float(values.mean()), float(values.std(ddof=1)), len(values))


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
