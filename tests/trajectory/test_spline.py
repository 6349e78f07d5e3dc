"""Splines against scipy's, and their rows' derivatives against differences."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from skyverse.trajectory.smooth import polynomial_pieces
from skyverse.trajectory.spline import DEGREE, make_rows, refine, row_jet

SPANS = st.lists(st.floats(0.05, 2.0), min_size=1, max_size=12).map(np.array)


def spline(points, spans):
    knots = np.r_[0.0, np.cumsum(spans)]
    return BSpline(np.r_[[0.0] * DEGREE, knots, [knots[-1]] * DEGREE], points, DEGREE)


@given(SPANS, st.integers(0, 2**32))
def test_rows_give_the_control_points_of_derivatives(spans, seed):
    points = np.random.default_rng(seed).normal(size=(len(spans) + DEGREE, 3))
    whole = spline(points, spans)
    instants = np.linspace(0, spans.sum(), 41)[:-1]
    for order in (1, 2, 3, 4):
        rows = make_rows(spans, order)
        control = np.array([row @ points[i : i + order + 1] for i, row in enumerate(rows)])
        lower = BSpline(whole.t[order : len(whole.t) - order], control, DEGREE - order)
        scale = np.abs(control).max() + 1.0
        assert np.allclose(lower(instants) / scale, whole(instants, nu=order) / scale, atol=1e-9)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_jets_are_the_derivatives_of_rows_by_the_logarithms_of_two_durations(order):
    rng = np.random.default_rng(order)
    spans = rng.uniform(0.1, 1, 14)
    box_of = np.repeat([0, 1], 7)
    work, jets = np.zeros((2, 5, 5, 6)), np.zeros((6, 6))

    def row(i, a, b):
        return make_rows(spans * np.exp(np.where(box_of == 0, a, b)), order)[i]

    h = 1e-4
    for i in range(len(spans) + DEGREE - order):
        row_jet(spans, box_of, 0, i, order, work, jets)
        by_first = (row(i, h, 0) - row(i, -h, 0)) / (2 * h)
        by_second = (row(i, 0, h) - row(i, 0, -h)) / (2 * h)
        twice = (row(i, h, 0) - 2 * row(i, 0, 0) + row(i, -h, 0)) / h**2
        both = (row(i, h, h) - row(i, h, -h) - row(i, -h, h) + row(i, -h, -h)) / (4 * h**2)
        other = (row(i, 0, h) - 2 * row(i, 0, 0) + row(i, 0, -h)) / h**2
        expected = np.array([row(i, 0, 0), by_first, by_second, twice, both, other]).T
        assert np.allclose(jets[: order + 1], expected, rtol=1e-4, atol=1e-4 * np.abs(expected).max())


@given(SPANS, st.integers(0, 2**32))
def test_refining_changes_nothing_but_brings_the_points_nearer(spans, seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(len(spans) + DEGREE, 3))
    parts = rng.integers(1, 5, len(spans))
    finer_points, finer = refine(points, spans, parts)
    assert len(finer) == parts.sum()
    assert np.isclose(finer.sum(), spans.sum())
    instants = np.linspace(0, spans.sum(), 97)[:-1]
    assert np.allclose(spline(points, spans)(instants), spline(finer_points, finer)(instants), atol=1e-9)
    assert (finer_points.max(axis=0) <= points.max(axis=0) + 1e-9).all()
    assert (finer_points.min(axis=0) >= points.min(axis=0) - 1e-9).all()


def curve(spans, far):
    """Control points of a wavy flight that begins far from zero."""
    instants = np.cumsum(spans)
    knots = np.r_[[0.0] * (DEGREE + 1), instants, [instants[-1]] * DEGREE]
    at = np.array([knots[i + 1 : i + DEGREE + 1].mean() for i in range(len(spans) + DEGREE)])
    return np.column_stack([far + 5 * at, far * np.sin(at / far), np.cos(at)]), knots


@given(
    st.lists(st.sampled_from([0.004, 0.02, 0.1, 0.7]), min_size=1, max_size=30),
    st.sampled_from([1.0, 100.0, 5000.0]),
)
def test_pieces_are_the_spline_and_no_derivative_jumps_up_to_the_third(lasting, far):
    spans = np.repeat(lasting, 6)
    points, whole = curve(spans, far)
    knots, rows = polynomial_pieces(points, spans)
    spline = BSpline(whole, points, DEGREE)
    duration = np.diff(knots)[:, None]
    for order in range(DEGREE):
        end = sum(math.perm(j, order) * rows[:, j] * duration ** (j - order) for j in range(order, DEGREE + 1))
        begin = math.factorial(order) * rows[:, order]
        limit = 1e-6 if order else 1e-6 + 1e-12 * far
        assert np.abs(end[:-1] - begin[1:]).max(initial=0.0) <= limit
        rounding = 1e-12 * far / min(lasting) ** order
        assert np.allclose(begin, spline(knots[:-1], nu=order), rtol=1e-6, atol=1e-6 + rounding)
