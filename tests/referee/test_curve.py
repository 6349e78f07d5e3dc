"""Curves are evaluated as their polynomials say, and what is no curve is told in words."""

from types import SimpleNamespace

import numpy as np
import pytest

from skyverse.referee.curve import MAX_DEGREE, MAX_END, PolynomialCurve, curve_of, derivative


def made(knots, pieces):
    return curve_of(SimpleNamespace(knots=np.array(knots), coefficients=pieces))


def test_motion_is_the_polynomial_with_its_derivatives():
    rows = np.random.default_rng(0).integers(-5, 5, (2, 6, 3)).astype(float)
    curve = made([1.0, 3.0, 6.0], rows)
    assert curve.durations.tolist() == [2, 3]
    for axis in range(3):
        polynomial = np.polynomial.Polynomial(rows[1, :, axis])
        expected = [polynomial.deriv(order)(2.0) for order in range(4)]
        assert curve.motion(1, 2.0)[:, axis].tolist() == expected


def test_a_constant_may_be_flown_and_its_derivative_is_zero():
    place = np.arange(3.0).reshape(1, 1, 3)
    curve = made([0.0, 1.0], place)
    assert isinstance(curve, PolynomialCurve)
    assert curve.motion(0, 0.5).tolist() == [[0, 1, 2], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
    assert derivative(place).tolist() == [[[0, 0, 0]]]


def test_the_longest_and_the_wildest_that_are_judged():
    assert isinstance(made([0.0, MAX_END], np.zeros((1, MAX_DEGREE + 1, 3))), PolynomialCurve)
    assert "is too long or too wild" in made([0.0, np.nextafter(MAX_END, np.inf)], np.zeros((1, 6, 3)))
    assert "its degree is 31 (of 30)" in made([0.0, 1.0], np.zeros((1, MAX_DEGREE + 2, 3)))


@pytest.mark.parametrize(
    ("knots", "shape", "words"),
    [
        ([0.0], (0, 6, 3), "must have two knots or more, but they have shape (1,)"),
        ([[0.0, 1.0], [2.0, 3.0]], (1, 6, 3), "must have two knots or more, but they have shape (2, 2)"),
        ([0.0, 1.0], (2, 6, 3), "must have coefficients of shape (1, degree + 1, 3), but has (2, 6, 3)"),
        ([0.0, 1.0], (1, 0, 3), "but has (1, 0, 3)"),
        ([0.0, 1.0], (1, 6, 2), "but has (1, 6, 2)"),
        ([0.0, 1.0], (1, 6), "but has (1, 6)"),
        ([0.0, np.inf], (1, 6, 3), "not finite"),
        ([0.0, 2.0, 1.0, 3.0], (3, 6, 3), "has knots that do not rise: 2 s, then 1 s"),
        ([0.0, 2.0, 2.0], (2, 6, 3), "has knots that do not rise: 2 s, then 2 s"),
        ([-1.0, 2.0], (1, 6, 3), "starts at t = -1 s, before the mission does"),
    ],
)
def test_what_is_no_curve_is_told_in_words(knots, shape, words):
    assert words in made(knots, np.zeros(shape))


def test_coefficients_must_be_finite():
    assert "not finite" in made([0.0, 1.0], np.full((1, 6, 3), np.nan))
