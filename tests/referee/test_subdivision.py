"""Questions about polynomials are decided as sampling decides them, and the rest stays undecided."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from skyverse.referee.polynomial import Polynomials, bernstein, stack
from skyverse.referee.subdivision import MAX_DEPTH, Peaks, find_peaks


def peaks_above(polynomials, level, **questions):
    excess = polynomials + -level
    return find_peaks(excess.b, excess.error, **questions)


@settings(max_examples=100, deadline=None)
@given(
    power=st.integers(0, 9).flatmap(lambda n: arrays(np.float64, (3, n + 1), elements=st.floats(-5, 5))),
    level=st.floats(-10, 10),
)
def test_the_greatest_value_is_found_as_sampling_finds_it(power, level):
    rows = np.repeat(power[:, :, None], 3, axis=2)
    peaks = peaks_above(bernstein(rows, np.ones(3))[0], level)
    t = np.linspace(0, 1, 20_001)
    values = np.array([np.polyval(row[::-1], t) for row in power])
    if peaks.proven[0]:
        assert values.max() <= level + 1e-12
    elif peaks.refuted[0]:
        assert peaks.value[0] + level >= values.max() - 2e-9
        there = np.polyval(power[peaks.piece[0]][::-1], peaks.share[0])
        assert abs(there - level - peaks.value[0]) <= 1e-10
        assert there > level
    else:  # at the level, except for rounding
        assert abs(values.max() - level) <= 1e-7


def test_the_place_of_a_question_is_its_peak_if_that_is_above_zero_and_else_where_it_is_undecided():
    value, nowhere = np.array([1.0, -1.0]), np.array([-1, -1])
    peaks = Peaks(value, np.array([3, 4]), np.array([0.5, 0.75]), np.array([5, 6]), np.array([0.0, 0.25]), nowhere)
    assert [peaks.place(k) for k in (0, 1)] == [(3, 0.5), (6, 0.25)]
    assert peaks._replace(stuck=nowhere).place() == (3, 0.5)


def test_questions_are_answered_one_by_one():
    rng = np.random.default_rng(2)
    x = bernstein(rng.normal(size=(12, 6, 3)), np.ones(12))[0] + -1.0
    question = np.repeat(np.arange(4), 3)
    together = find_peaks(x.b, x.error, question=question, questions=4)
    for k in range(4):
        alone = find_peaks(x.b[question == k], x.error[question == k])
        assert together.value[k] == alone.value[0]
        assert together.piece[k] == alone.piece[0] + 3 * k
        assert together.halvings[k] == alone.halvings[0]


def test_a_curve_that_touches_a_level_is_undecided_and_one_on_either_side_is_decided():
    bump = np.zeros((1, 3, 3))
    bump[0, :, 0] = -0.25, 1, -1  # -(t - 1/2)^2, 0 at its peak
    x = bernstein(bump, np.ones(1))[0]
    assert peaks_above(x, 1e-9).proven
    assert peaks_above(x, -1e-9).refuted
    touching = find_peaks(x.b, x.error)
    assert not touching.refuted
    assert not touching.proven
    assert touching.stuck_share[0] == 0.5


def test_what_is_no_number_is_undecided_at_once():
    for wild in (np.nan, np.inf, 1e308):
        with np.errstate(all="ignore"):  # as `judge` does
            x = bernstein(np.full((2, 6, 3), wild), np.ones(2))[0]
            peaks = peaks_above(x * x, 1.0)
        assert not peaks.proven.any()
        assert not peaks.refuted.any()
        assert peaks.halvings[0] == 0


def test_a_plateau_at_the_level_ends_after_the_greatest_depth():
    flat = Polynomials(np.ones((50, 9)), np.full(50, 1e-15))
    peaks = peaks_above(flat, 1.0)
    assert not peaks.proven.any()
    assert peaks.halvings[0] <= 50 * MAX_DEPTH
    assert peaks_above(stack([flat, flat * 1.5]), 1.0).value[0] > 0.49
