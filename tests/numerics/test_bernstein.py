"""Bernstein coefficients against numpy's polynomials in powers."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial import polynomial

from skyverse.numerics.bernstein import binomials, halve, part, product, to_bernstein

DURATIONS = st.floats(0.01, 50)
SHARES = st.floats(0, 1)


def polynomials(columns=3, most=9):
    """Powers of the share of the interval, (n + 1, columns)."""
    return st.integers(1, most).flatmap(lambda n: arrays(float, (n, columns), elements=st.floats(-100, 100)))


def in_time(rows, duration):
    return rows / duration ** np.arange(len(rows))[:, None]


def values(b, share):
    """The polynomial as its definition has it, (shares, columns)."""
    n = len(b) - 1
    s = np.atleast_1d(share)[:, None]
    return sum(binomials(n)[i] * s**i * (1 - s) ** (n - i) * b[i] for i in range(n + 1))


GRID = np.linspace(0, 1, 33)


@given(polynomials(), DURATIONS)
def test_the_coefficients_stand_for_the_same_polynomial_and_enclose_it(rows, duration):
    b = to_bernstein(in_time(rows, duration), duration)
    true = polynomial.polyval(GRID, rows).T
    np.testing.assert_allclose(values(b, GRID), true, rtol=1e-9, atol=1e-9)
    assert np.all(b.min(axis=0) - 1e-9 <= true.min(axis=0))
    assert np.all(true.max(axis=0) <= b.max(axis=0) + 1e-9)


@given(polynomials(), SHARES, SHARES)
def test_a_part_is_the_same_polynomial_on_less(rows, one, other):
    u, v = sorted((one, other))
    if v - u < 1e-6:
        u, v = 0.25, 0.5
    b = to_bernstein(rows, 1.0)
    true = polynomial.polyval(u + GRID * (v - u), rows).T
    np.testing.assert_allclose(values(part(b, u, v), GRID), true, rtol=1e-9, atol=1e-8)


@given(polynomials())
def test_halves_are_the_two_parts(rows):
    b = to_bernstein(rows, 1.0)
    left, right = halve(b)
    np.testing.assert_allclose(left, part(b, 0.0, 0.5), atol=1e-9)
    np.testing.assert_allclose(right, part(b, 0.5, 1.0), atol=1e-9)
    assert np.array_equal(left[-1], right[0])


@given(polynomials(1), polynomials(1))
def test_a_product_is_the_product(one, other):
    a, b = to_bernstein(one, 1.0)[:, 0], to_bernstein(other, 1.0)[:, 0]
    true = polynomial.polyval(GRID, polynomial.polymul(one[:, 0], other[:, 0]))
    np.testing.assert_allclose(values(product(a, b)[:, None], GRID)[:, 0], true, rtol=1e-9, atol=1e-8)


def test_binomials_are_pascals_rows():
    assert binomials(0).tolist() == [1]
    assert binomials(6).tolist() == [1, 6, 15, 20, 15, 6, 1]
