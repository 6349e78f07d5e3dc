"""The length and energy of a flight lie between the bounds that the referee states, and these are close together."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.integrate import quad

from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.integrals import Enclosure, curve_length, flight_energy

HOVERING_WATTS = 121.6


def narrow(found):
    """Whether bounds are as close together as is promised, and in order but for rounding."""
    rounding = 1e-12 * found.high
    ordered = found.low - rounding <= found.estimate <= found.high + rounding
    return ordered and -rounding <= found.high - found.low <= 1.0001e-5 * found.high


def test_the_energy_of_a_hover_is_power_times_time():
    hover = PolynomialCurve(np.array([3.0, 13.0]), np.array([[[1.0, 2.0, 3.0]]]))
    assert flight_energy(hover, HOVERING_WATTS).estimate == pytest.approx(10 * HOVERING_WATTS, rel=1e-6)
    assert curve_length(hover) == (0, 0, 0)


def test_the_length_of_a_parabola_and_of_a_turn_back_are_known():
    there_and_back = np.zeros((1, 3, 3))
    there_and_back[0, 1:, 0] = 4, -1  # x = 4 t - t^2 turns at t = 2 and is back at t = 4
    assert curve_length(PolynomialCurve(np.array([0.0, 4.0]), there_and_back)).estimate == pytest.approx(8, rel=1e-5)
    parabola = np.zeros((1, 3, 3))
    parabola[0, 1, 0] = parabola[0, 2, 1] = 1
    found = curve_length(PolynomialCurve(np.array([0.0, 1.0]), parabola))
    exact = np.sqrt(5) / 2 + np.arcsinh(2) / 4
    assert found.low < exact < found.high
    assert narrow(found)
    assert found.estimate == pytest.approx(exact, rel=1e-9)


def test_the_energy_of_a_free_fall_that_is_caught_is_known():
    caught = np.zeros((1, 4, 3))
    caught[0, 2:, 2] = -9.81 / 2, 9.81 / 6  # the thrust is 9.81 t
    found = flight_energy(PolynomialCurve(np.array([0.0, 2.0]), caught), HOVERING_WATTS)
    exact = HOVERING_WATTS * 2**2.5 / 2.5
    assert found.estimate == pytest.approx(exact, rel=1e-6)
    assert narrow(found)


@given(arrays.arrays(float, (2, 6, 3), elements=st.floats(-5, 5, width=32)), st.floats(0.1, 5.0))
def test_bounds_hold_what_quadrature_finds(pieces, seconds):
    curve = PolynomialCurve(seconds * np.arange(3.0), pieces)

    def rate(t, piece, derivative):
        f = curve.motion(piece, t)[derivative] + (derivative == 2) * np.array([0, 0, 9.81])
        norm = np.linalg.norm(f)
        return norm if derivative == 1 else HOVERING_WATTS * (norm / 9.81) ** 1.5

    for found, derivative in ((curve_length(curve), 1), (flight_energy(curve, HOVERING_WATTS), 2)):
        exact = sum(quad(rate, 0, seconds, (piece, derivative), limit=200)[0] for piece in range(2))
        assert found.low <= exact * (1 + 2e-6) + 1e-9
        assert found.high >= exact * (1 - 2e-6) - 1e-9
        assert narrow(found)


def test_a_claim_agrees_that_differs_by_no_more_than_what_is_let_pass():
    found = Enclosure(100.0, 100.0, 100.0)
    for claimed, agrees in ((100.001, True), (99.999, True), (100.0011, False), (99.9989, False), (np.nan, False)):
        assert found.agrees(claimed) == agrees
    nothing = Enclosure(0.0, 0.0, 0.0)
    assert nothing.agrees(9e-6)
    assert not nothing.agrees(1.1e-5)
    assert not Enclosure(np.nan, np.nan, np.nan).agrees(1.0)
