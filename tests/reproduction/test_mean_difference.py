"""Differences of means against scipy and statsmodels, and against what simulated runs find."""

import numpy as np
import pytest
from scipy import stats

from skyverse.lab import Sample, sample
from skyverse.reproduction.claim_verdict import deviations_differ, mean_difference

SIZES = [(20, 200), (50, 50), (2, 7), (200, 20)]


def drawn(n, m, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(280, 7, n), rng.normal(283, 19, m)


@pytest.mark.parametrize(("n", "m"), SIZES)
def test_p_and_interval_are_those_of_welchs_test(n, m):
    a, b = drawn(n, m)
    found, truth = mean_difference(sample(a), sample(b)), stats.ttest_ind(a, b, equal_var=False)
    assert found.p == pytest.approx(truth.pvalue)
    assert found.interval == pytest.approx(tuple(truth.confidence_interval(0.95)))
    assert found.below(0.0) == pytest.approx(stats.ttest_ind(a, b, equal_var=False, alternative="less").pvalue)


def test_published_means_and_deviations_are_samples_as_well():
    a, b = drawn(20, 200)
    assert mean_difference(Sample(a.mean(), a.std(ddof=1), 20), sample(b)) == mean_difference(sample(a), sample(b))


@pytest.mark.parametrize(("n", "m"), SIZES)
def test_equivalence_is_statsmodels(n, m):
    weightstats = pytest.importorskip("statsmodels.stats.weightstats", reason="statsmodels is not installed")
    a, b = drawn(n, m)
    truth = weightstats.ttost_ind(a, b, -8.0, 8.0, usevar="unequal")[0]
    assert mean_difference(sample(a), sample(b)).equivalent(8.0) == pytest.approx(truth)


def test_the_least_detectable_difference_has_the_power_of_statsmodels():
    power = pytest.importorskip("statsmodels.stats.power", reason="statsmodels is not installed")
    found = mean_difference(Sample(270.0, 6.4, 50), Sample(270.0, 6.4, 50)).detectable
    truth = 6.4 * power.TTestIndPower().solve_power(nobs1=50, alpha=0.05, power=0.8)
    assert found == pytest.approx(truth, rel=0.01)


def test_a_detectable_difference_is_found_in_four_of_five_studies():
    rng, truth = np.random.default_rng(1), 6.0
    detectable = mean_difference(Sample(0.0, 5.0, 40), Sample(0.0, truth, 60)).detectable
    p = [
        mean_difference(sample(rng.normal(detectable, 5.0, 40)), sample(rng.normal(0.0, truth, 60))).p
        for _ in range(2000)
    ]
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.8, abs=0.03)


def test_means_without_spread_are_told_apart_for_certain():
    found = mean_difference(Sample(265.0, 0.0, 20), Sample(266.0, 0.0, 20))
    assert (found.p, found.interval, found.equivalent(2.0), found.equivalent(0.5)) == (0.0, (-1.0, -1.0), 0.0, 1.0)
    assert mean_difference(Sample(265.0, 0.0, 20), Sample(265.0, 0.0, 20)).p == 1.0


def test_the_f_test_keeps_its_level_and_sees_what_differs():
    rng = np.random.default_rng(2)
    p = [deviations_differ(sample(rng.normal(0, 3, 20)), sample(rng.normal(0, 3, 80))) for _ in range(2000)]
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.015)
    assert deviations_differ(Sample(0, 18.0, 20), Sample(0, 11.0, 200)) < 0.01
