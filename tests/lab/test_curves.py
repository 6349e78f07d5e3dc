import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.lab import band, best_so_far, expected_run_length, grid, profile, ratios, run_lengths, spread

INF = np.inf
number = st.one_of(st.floats(1, 10).map(lambda x: round(x, 1)), st.just(INF))
steps = st.lists(st.tuples(st.integers(0, 30), st.one_of(st.just(INF), st.integers(200, 400))), min_size=0, max_size=10)


def history(rows):
    rows = sorted(rows, key=lambda row: row[0])
    effort = np.array([row[0] for row in rows], np.int64)
    return sky.History(np.array([row[1] for row in rows], np.float64), effort, 7 * effort, 2 * effort)


@settings(deadline=None)
@given(st.lists(number, min_size=1, max_size=30))
def test_a_profile_counts_the_runs_within_a_ratio_and_rises(found):
    ratio, share = profile(found)
    assert share == pytest.approx([np.mean(np.array(found) <= r) for r in ratio])
    assert np.all(np.diff(ratio) > 0)
    assert np.all(np.diff(share) > 0)
    assert share[-1:] == pytest.approx([np.mean(np.isfinite(found))] * min(1, len(share)))


def test_failures_never_enter_a_profile():
    found = ratios([265.0, 530.0, 300.0], [True, True, False], 265.0)
    np.testing.assert_array_equal(found, [1.0, 2.0, INF])
    share = profile(found)[1]
    assert share[-1] == pytest.approx(2 / 3)
    assert profile([INF, INF])[0].size == 0
    np.testing.assert_array_equal(ratios([0.0, 1.0], [True, True], 0.0), [1.0, INF])


@settings(deadline=None)
@given(steps)
def test_the_best_so_far_equals_looking_at_every_step(rows):
    h = history(rows)
    spent = h.evaluations
    at = np.arange(0, 40, 3)
    expected = [min((c for c, e in zip(h.cost, spent, strict=True) if e <= x), default=INF) for x in at]
    np.testing.assert_array_equal(best_so_far(h, at), expected)


def test_a_band_is_the_quartiles_of_the_runs_and_infinite_where_there_are_no_paths():
    runs = [history([(1, c), (10, c - 50)]) for c in (300, 310, 320, 330)] + [history([(5, 400)])]
    at = np.array([2.0, 10.0, 20.0, 99.0])
    quartiles = [[310, 310, 260, 260], [320, 320, 270, 270], [330, 330, 280, 280]]
    np.testing.assert_array_equal(band(iter(runs), at), [at, *quartiles])
    assert np.isinf(band([], np.array([1.0]))[1:]).all()


@settings(deadline=None)
@given(steps, st.lists(st.integers(200, 400), min_size=1, max_size=3))
def test_a_run_length_is_that_of_the_first_row_that_reaches_the_target(rows, targets):
    h = history(rows)
    expected = [min((e for c, e in zip(h.cost, h.evaluations, strict=True) if c <= t), default=INF) for t in targets]
    np.testing.assert_array_equal(run_lengths([h], targets), [expected])


def test_the_expected_run_length_counts_what_failures_spent():
    assert expected_run_length([100.0, INF, 300.0], [1000, 1000, 1000]) == 1400 / 2
    assert expected_run_length([INF, INF], [10, 10]) == INF
    rng = np.random.default_rng(0)  # restarts until one of 30 % succeeds, after 50 evaluations, others spend 200
    won = rng.random(200_000) < 0.3
    ends = np.flatnonzero(won)
    taken = np.where(won, 50.0, 200.0)[: ends[-1] + 1].sum() / len(ends)
    lengths = np.where(won[: ends[-1] + 1], 50.0, INF)
    assert expected_run_length(lengths, np.full(len(lengths), 200.0)) == pytest.approx(taken)


@pytest.mark.parametrize("most", [0, 1, 7, 1388, 10**6])
def test_a_grid_goes_from_one_to_the_most_in_whole_numbers(most):
    found = grid(most)
    assert found[0] == 1
    assert found[-1] == max(1, most)
    assert 1 <= len(found) <= 200
    np.testing.assert_array_equal(found, np.round(found))
    if most <= 100:
        assert len(found) == max(1, most)


def test_the_spread_of_efforts_is_the_largest_over_the_least():
    assert spread([500.0, 510.0, 1000.0]) == 2.0
    assert spread([0.0, 0.0]) == 1.0
    assert spread([0.0, 3.0]) == INF
