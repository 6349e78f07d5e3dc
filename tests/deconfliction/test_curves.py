"""Curves as kernels see them, against the trajectories that they were made from."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from curves import random_flight
from skyverse.deconfliction.curves import curve_duration, make_curves, piece_at, piece_between, position_at


def some_flights(seed, count=3):
    rng = np.random.default_rng(seed)
    return [random_flight(rng) for _ in range(count)], rng


@given(st.integers(0, 2**32))
def test_positions_are_those_of_the_trajectories_before_during_and_after_their_flight(seed):
    flights, rng = some_flights(seed)
    curves = make_curves(flights)
    for c, flight in enumerate(flights):
        whole = flight.end - flight.start
        assert np.isclose(curve_duration(curves, c), whole, rtol=1e-12)
        for local in [-1.0, 0.0, *rng.uniform(0.0, whole, 8), whole, whole + 1.0]:
            expected = flight.at(flight.start + min(max(local, 0.0), whole)).position[0]
            np.testing.assert_allclose(position_at(curves, c, local), expected, atol=1e-9)


@given(st.integers(0, 2**32))
def test_the_piece_at_a_local_time_is_the_last_that_begins_before_it(seed):
    flights, rng = some_flights(seed)
    curves = make_curves(flights)
    for c, flight in enumerate(flights):
        begins = flight.knots[:-1] - flight.knots[0]
        for local in [-1.0, 0.0, *begins, *rng.uniform(0.0, begins[-1] + 2.0, 5)]:
            expected = max(int(np.sum(begins < local)) - 1, 0)
            assert piece_at(curves, c, local) - curves.first[c] == expected


@given(st.integers(0, 2**32))
def test_a_part_of_a_piece_has_the_positions_of_the_trajectory_and_encloses_them(seed):
    (flight,), rng = some_flights(seed, 1)
    curves = make_curves([flight])
    for k in range(len(curves.begin)):
        since, until = np.sort(curves.begin[k] + rng.uniform(0.0, 1.0, 2) * curves.duration[k])
        rows = piece_between(curves, k, since, until)
        within = flight.at(flight.start + np.linspace(since, until, 20)).position
        np.testing.assert_allclose(rows[0], within[0], atol=1e-9)
        np.testing.assert_allclose(rows[-1], within[-1], atol=1e-9)
        assert (within >= rows.min(axis=0) - 1e-9).all()
        assert (within <= rows.max(axis=0) + 1e-9).all()
