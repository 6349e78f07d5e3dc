"""The parts of pieces that are flown while zones are active, and the coefficients on them, against exact arithmetic."""

from fractions import Fraction
from math import comb

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.referee.zones import active_parts, restricted, restriction_error
from temporary_zones import times

numbers = st.floats(-1e3, 1e3)


def value(coefficients, share):
    """A polynomial in Bernstein form at a share of its interval, exactly."""
    degree, share = len(coefficients) - 1, Fraction(share)
    rows = [Fraction(float(one)) for one in coefficients]
    return sum(comb(degree, k) * share**k * (1 - share) ** (degree - k) * one for k, one in enumerate(rows))


@given(
    st.lists(numbers, min_size=1, max_size=9),
    st.floats(0, 1).filter(lambda share: share == 0 or share > 1e-9),
    st.floats(1e-6, 1),
    st.floats(0, 1),
)
@settings(max_examples=100)
def test_coefficients_on_a_part_are_those_of_the_same_polynomial(coefficients, begin, width, share):
    end = min(begin + width, 1.0)
    if not begin < end:
        begin, end = 0.0, 1.0
    whole = np.array(coefficients)[None, :, None]
    part = restricted(whole, np.array([begin]), np.array([end]))[0, :, 0]
    there = Fraction(begin) + Fraction(share) * (Fraction(end) - Fraction(begin))
    assert abs(value(part, share) - value(coefficients, there)) <= Fraction(float(restriction_error(whole)[0]))


@given(st.lists(numbers, min_size=1, max_size=9))
def test_coefficients_on_the_whole_interval_stay_as_they_are(coefficients):
    whole = np.array(coefficients)[None, :, None]
    assert np.array_equal(restricted(whole, np.zeros(1), np.ones(1)), whole)


@given(times(), st.lists(st.floats(0.01, 6), min_size=1, max_size=6), st.floats(-3, 6))
@settings(max_examples=100)
def test_parts_are_where_a_zone_is_active(active, seconds, begin):
    knots = begin + np.concatenate([[0.0], np.cumsum(seconds)])
    zones = [
        sky.Box(min=(0, 0, 0), max=(1, 1, 1), active=active),
        sky.Box(min=(0, 0, 0), max=(1, 1, 1), max_speed=1.0),
    ]
    piece = np.repeat(np.arange(len(seconds)), 2)
    zone = np.tile([0, 1], len(seconds))
    parts = active_parts(knots, piece, zone, zones)
    for pair in range(len(piece)):
        k, own = piece[pair], parts.pair == pair
        if zone[pair] == 1:
            assert (parts.begin[own], parts.end[own]) == (0.0, 1.0)
            continue
        length = knots[k + 1] - knots[k]
        for t in np.linspace(knots[k], knots[k + 1], 41):
            held = any((a is None or a <= t) and (b is None or t <= b) for a, b in active)
            near = any(edge is not None and abs(t - edge) < 1e-9 for span in active for edge in span)
            share = (t - knots[k]) / length
            covered = bool(((parts.begin[own] <= share + 1e-12) & (share - 1e-12 <= parts.end[own])).any())
            assert covered == held or near
