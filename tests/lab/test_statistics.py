import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from skyverse.lab import (
    a12,
    bootstrap,
    critical_difference,
    groups,
    holm,
    magnitude,
    mann_whitney,
    quantile,
    rank_biserial,
    ranking,
    sample,
    wilcoxon,
    wilson,
)

INF = np.inf
cost = st.one_of(st.integers(200, 220).map(float), st.just(INF))
costs = st.lists(cost, min_size=1, max_size=12)
pairs = st.lists(st.tuples(cost, cost), min_size=1, max_size=30).map(lambda rows: np.array(rows).T)


def test_a_sample_is_what_numpy_and_scipy_say_and_infinite_costs_are_not_averaged_away():
    values = np.random.default_rng(1).normal(300, 20, 37)
    told = sample(values)
    assert (told.mean, told.deviation, told.runs) == pytest.approx((values.mean(), values.std(ddof=1), 37))
    assert told.error == pytest.approx(stats.sem(values))
    for few in ([5.0], [1.0, 2.0, INF]):
        assert np.isnan(sample(few).error)
        assert bootstrap(np.array(few)) is None
    assert sample([1.0, 2.0, INF]).mean == INF


@settings(deadline=None)
@given(costs, st.sampled_from([0.0, 0.25, 0.5, 0.75, 1.0]))
def test_a_quantile_with_infinite_values_is_the_limit_of_large_ones(values, q):
    large = np.where(np.isinf(values), 1e300, values)
    expected = np.quantile(large, q)
    assert quantile(np.array(values), q) == pytest.approx(INF if expected > 1e200 else expected)


def test_the_bootstrap_covers_the_true_mean_about_as_often_as_it_says():
    rng = np.random.default_rng(7)
    found = [bootstrap(rng.exponential(10.0, 40)) for _ in range(150)]
    covered = sum(interval.low <= 10.0 <= interval.high for interval in found)
    assert 130 <= covered <= 149


@pytest.mark.parametrize("values", [[3.0] * 9, [1.0] * 8 + [2.0], [1.0, 1.0, 1.0, 1.0, 1e6]])
def test_the_bootstrap_survives_what_is_almost_constant(values):
    low, high = bootstrap(np.array(values))
    assert min(values) <= low <= high <= max(values)


def test_the_bootstrap_is_the_same_every_time():
    values = np.random.default_rng(3).normal(size=20)
    assert bootstrap(values) == bootstrap(values)


def test_wilsons_interval_equals_statsmodels():
    proportion = pytest.importorskip("statsmodels.stats.proportion", reason="statsmodels is not installed")
    for successes, runs in ((0, 20), (7, 20), (20, 20), (1, 1)):
        expected = proportion.proportion_confint(successes, runs, method="wilson")
        assert wilson(successes, runs) == pytest.approx(expected, abs=1e-12)


def brute_force_signed_rank(a, b):
    """The p of every assignment of signs to the ranks, and the rank-biserial correlation."""
    differences = [x - y for x, y in zip(a, b, strict=True) if x != y]
    ranks = stats.rankdata(np.abs(differences))
    seen = sum(rank for rank, d in zip(ranks, differences, strict=True) if d > 0)
    middle = ranks.sum() / 2
    sums = [np.dot(ranks, signs) for signs in itertools.product((0, 1), repeat=len(ranks))]
    far = sum(abs(total - middle) >= abs(seen - middle) - 1e-9 for total in sums)
    return far / len(sums), (2 * seen - ranks.sum()) / ranks.sum()


@pytest.mark.parametrize("n", [4, 20, 50, 51, 200])
def test_wilcoxon_is_scipys_where_nothing_ties(n):
    a, b = np.random.default_rng(n).normal((10.0, 10.3), 1.0, (n, 2)).T
    assert wilcoxon(a, b) == pytest.approx(stats.wilcoxon(a, b).pvalue, rel=1e-9)


def test_wilcoxon_and_rank_biserial_equal_all_assignments_of_signs():
    rng = np.random.default_rng(5)
    for _ in range(10):
        a, b = rng.integers(10, 15, 9).astype(float), rng.integers(11, 16, 9).astype(float)  # ties
        a[3], b[3] = 10.0, 10.0  # a pair of equals says nothing
        p, correlation = brute_force_signed_rank(a, b)
        assert wilcoxon(a, b) == pytest.approx(p)
        assert rank_biserial(a, b) == pytest.approx(correlation)


@settings(deadline=None)
@given(pairs)
def test_paired_measures_know_no_nan_and_no_side(both):
    a, b = both
    assert 0.0 <= wilcoxon(a, b) <= 1.0
    assert wilcoxon(a, b) == pytest.approx(wilcoxon(b, a))
    assert rank_biserial(a, b) == pytest.approx(-rank_biserial(b, a))
    assert wilcoxon(a, a) == 1.0
    assert rank_biserial(a, a) == 0.0


@settings(deadline=None)
@given(costs, costs)
def test_mann_whitney_is_scipys_and_never_nan(a, b):
    p = mann_whitney(a, b)
    assert 0.0 <= p <= 1.0
    assert p == pytest.approx(mann_whitney(b, a))
    if len(set(a + b)) > 1:
        finite = [np.where(np.isinf(x), 1e9, x) for x in (a, b)]
        assert p == pytest.approx(stats.mannwhitneyu(*finite).pvalue)


@settings(deadline=None)
@given(costs, costs)
def test_a12_equals_counting_all_pairs(a, b):
    counted = np.mean([(x > y) + (x == y) / 2 for x in a for y in b])
    assert a12(a, b) == pytest.approx(counted)
    assert a12(a, b) + a12(b, a) == pytest.approx(1.0)


def test_magnitudes_are_vargha_and_delaneys():
    chances = (0.5, 0.559, 0.56, 0.44, 0.639, 0.64, 0.36, 0.709, 0.71, 0.29, 1.0, 0.0)
    words = ["negligible"] * 2 + ["small"] * 3 + ["medium"] * 3 + ["large"] * 4
    assert [magnitude(chance) for chance in chances] == words


@settings(deadline=None)
@given(st.lists(st.floats(0, 1), min_size=1, max_size=20))
def test_holms_p_is_never_less_than_the_raw_and_keeps_the_order(p):
    adjusted = holm(p)
    assert np.all(adjusted >= np.array(p))
    assert np.all(adjusted <= 1.0)
    assert np.all(np.diff(adjusted[np.argsort(p, kind="stable")]) >= 0)


def test_holm_equals_statsmodels():
    multitest = pytest.importorskip("statsmodels.stats.multitest", reason="statsmodels is not installed")
    p = np.random.default_rng(2).uniform(0, 0.2, 30)
    np.testing.assert_allclose(holm(p), multitest.multipletests(p, method="holm")[1])


def table(k, n, seed=4):
    return np.random.default_rng(seed).normal(size=(n, k)).round(1) + 0.4 * np.arange(k)


def test_the_ranking_is_friedmans():
    costs = table(5, 12)
    found = ranking(costs)
    expected = stats.friedmanchisquare(*costs.T)
    assert (found.chi2, found.p) == pytest.approx((expected.statistic, expected.pvalue))
    assert found.ranks == pytest.approx(np.mean([stats.rankdata(row) for row in costs], axis=0))


def test_demsars_example_comes_out():
    """Demsar 2006, section 3.2.2: 14 data sets, 4 algorithms, ranks 3.143, 2.000, 2.893, 1.964."""
    table = np.array(
        [
            [0.763, 0.768, 0.771, 0.798],
            [0.599, 0.591, 0.590, 0.569],
            [0.954, 0.971, 0.968, 0.967],
            [0.628, 0.661, 0.654, 0.657],
            [0.882, 0.888, 0.886, 0.898],
            [0.936, 0.931, 0.916, 0.931],
            [0.661, 0.668, 0.609, 0.685],
            [0.583, 0.583, 0.563, 0.625],
            [0.775, 0.838, 0.866, 0.875],
            [1.000, 1.000, 1.000, 1.000],
            [0.940, 0.962, 0.965, 0.962],
            [0.619, 0.666, 0.614, 0.669],
            [0.972, 0.981, 0.9751, 0.975],
            [0.957, 0.978, 0.946, 0.970],
        ]
    )
    found = ranking(-table)
    assert found.ranks == pytest.approx([3.143, 2.000, 2.893, 1.964], abs=0.0005)
    assert found.critical_difference == pytest.approx(1.25, abs=0.005)
    chi2 = found.chi2 * (1 - (60 + 3 * 6) / (14 * 60))  # he corrects neither for the row of four nor the three pairs
    assert chi2 == pytest.approx(9.28, abs=0.005)
    assert found.f == pytest.approx(13 * found.chi2 / (14 * 3 - found.chi2))
    assert 13 * chi2 / (14 * 3 - chi2) == pytest.approx(3.69, abs=0.005)
    assert found.p_f < 0.05


def test_nemenyis_groups_equal_scikit_posthocs():
    posthocs = pytest.importorskip("scikit_posthocs", reason="scikit-posthocs is not installed")
    for k, n in ((4, 20), (7, 30)):
        costs = table(k, n)
        found = ranking(costs)
        together = posthocs.posthoc_nemenyi_friedman(costs).to_numpy() >= 0.05
        expected = {pair for pair in itertools.combinations(range(k), 2) if together[pair]}
        inside = {tuple(sorted(pair)) for group in found.groups for pair in itertools.combinations(group, 2)}
        assert inside == expected
        assert 0 < len(expected) < k * (k - 1) / 2


def test_the_critical_difference_is_demsars_table():
    for planners, q in ((2, 1.960), (5, 2.728), (10, 3.164)):
        assert critical_difference(planners, 30) == pytest.approx(
            q * np.sqrt(planners * (planners + 1) / 180), abs=0.001
        )


@settings(deadline=None)
@given(st.lists(st.floats(1, 14), min_size=2, max_size=14), st.floats(0.01, 5))
def test_groups_hold_exactly_the_pairs_that_do_not_differ(ranks, difference):
    found = groups(ranks, difference)
    inside = {frozenset(pair) for group in found for pair in itertools.combinations(group, 2)}
    close = {
        frozenset((i, j))
        for i, j in itertools.combinations(range(len(ranks)), 2)
        if abs(ranks[i] - ranks[j]) <= difference
    }
    assert inside == close
    assert not any(set(a) <= set(b) for a, b in itertools.permutations(found, 2))


def test_planners_that_never_differ_share_their_rank():
    found = ranking(np.full((5, 4), 265.0))
    assert found.p == 1.0
    assert found.p_f == 1.0
    assert found.ranks == pytest.approx([2.5] * 4)
    assert found.groups == ((0, 1, 2, 3),)


def test_planners_that_always_differ_have_an_infinite_f():
    found = ranking(np.tile([1.0, 2.0, INF], (8, 1)))
    assert found.f == INF
    assert found.p_f == 0.0


@pytest.mark.parametrize("shape", [(1, 4), (9, 2)])
def test_too_few_blocks_or_planners_cannot_be_ranked(shape):
    with pytest.raises(ValueError, match="at least"):
        ranking(np.ones(shape))
