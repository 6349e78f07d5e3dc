"""Error bounds of polynomials hold: rational arithmetic is the judge."""

from fractions import Fraction
from math import comb

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from skyverse.referee.polynomial import Polynomials, bernstein, halve, squared

number = st.floats(-1e3, 1e3).map(lambda value: value if abs(value) > 1e-6 else 0.0)
duration = st.floats(1e-3, 1e2)


def rows(degree):
    return arrays(np.float64, (1, degree + 1, 3), elements=number)


def exactly(power):
    """Bernstein coefficients of a polynomial in the share of its interval, from its power basis; fractions."""
    n = len(power) - 1
    return [sum(Fraction(comb(i, j), comb(n, j)) * power[j] for j in range(i + 1)) for i in range(n + 1)]


def scaled(column, seconds):
    return [Fraction(float(value)) * Fraction(float(seconds)) ** j for j, value in enumerate(column)]


def times(p, q):
    product = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            product[i + j] += a * b
    return product


def plus(p, q):
    n = max(len(p), len(q))
    return [
        (p[k] if k < len(p) else Fraction(0)) + (q[k] if k < len(q) else Fraction(0)) for k in range(n)
    ]  # fmt: skip


def off(polynomial, power):
    """By how much a batch of one differs from the truth, and by how much it says that it may."""
    true = exactly(power + [Fraction(0)] * (polynomial.degree + 1 - len(power)))
    worst = max(abs(Fraction(float(b)) - t) for b, t in zip(polynomial.b[0], true, strict=True))
    return worst, Fraction(float(polynomial.error[0]))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 7).flatmap(rows), st.integers(0, 7).flatmap(rows), duration, number)
def test_what_rounding_does_is_within_the_errors_that_are_kept(first, second, seconds, factor):
    x, y, z = bernstein(first, np.array([seconds]))
    u = bernstein(second, np.array([seconds]))[0]
    px, py, pz = (scaled(first[0, :, axis], seconds) for axis in range(3))
    pu = scaled(second[0, :, 0], seconds)
    f = Fraction(factor)
    sx, sy, sz, su = (sum(abs(c) for c in column) for column in (px, py, pz, pu))
    cases = {
        "itself": (x, px, sx),
        "sum": (x + u, plus(px, pu), sx + su),
        "difference": (x - u, plus(px, [-c for c in pu]), sx + su),
        "product": (x * u, times(px, pu), sx * su),
        "cube": (x * u * x, times(times(px, pu), px), sx * su * sx),
        "norm": (squared([x, y, z]), plus(plus(times(px, px), times(py, py)), times(pz, pz)), sx**2 + sy**2 + sz**2),
        "shifted": (x + factor, plus(px, [f]), sx + abs(f)),
        "stretched": (x * factor, [c * f for c in px], sx * abs(f)),
        "raised": (x.raised(x.degree + 5), px, sx),
    }
    for name, (computed, true, scale) in cases.items():
        worst, allowed = off(computed, true)
        assert worst <= allowed, name
        assert allowed <= Fraction(1, 10**12) * scale, name


def test_halves_are_the_same_polynomial():
    rng = np.random.default_rng(1)
    power = rng.normal(size=(4, 6, 3))
    x = bernstein(power, np.full(4, 2.0))[0]
    left, right = (bernstein(part, np.full(4, 1.0))[0] for part in (power, _shifted(power, 1.0)))
    for half, true in zip(halve(x.b), (left, right), strict=True):
        np.testing.assert_allclose(half, true.b, atol=1e-12)


def _shifted(power, t):
    n = power.shape[1]
    return np.stack([sum(comb(j, i) * t ** (j - i) * power[:, j] for j in range(i, n)) for i in range(n)], axis=1)


def test_the_size_of_a_polynomial_counts_what_its_coefficients_may_be_off():
    some = Polynomials(np.array([[1.0, -3.0], [2.0, 0.0]]), np.array([0.5, 0.25]))
    assert some.size.tolist() == [3.5, 2.25]
    assert (some * some).error.tolist() == pytest.approx([2 * 3.5 * 0.5, 2 * 2.25 * 0.25])
