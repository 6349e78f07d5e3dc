"""Splines as polynomials: against scipy's, and joined without a jump however far from zero."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from skyverse.trajectory.smooth import polynomial_pieces
from skyverse.trajectory.spline import DEGREE


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
