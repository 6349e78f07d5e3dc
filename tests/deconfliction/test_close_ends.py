"""Delays that are hopeless for close starts or targets are in conflict, and most that are in conflict are found so."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from curves import random_flight
from skyverse.deconfliction.close_ends import forbid_at_rest
from skyverse.deconfliction.curve_store import CurveStore
from skyverse.deconfliction.curves import TimedCurve
from skyverse.deconfliction.forbidden_departures import TICK, free_departures
from skyverse.deconfliction.pair_conflicts import in_conflict

XY, Z = 0.8, 1.2


def shifted(flight, gap):
    moved = flight.coefficients.copy()
    moved[:, 0] += gap
    return type(flight)(flight.knots, moved)


@given(
    st.integers(0, 2**32),
    st.sampled_from(["starts", "targets", "another's way"]),
    st.floats(0.1, 1.2),
    st.sampled_from([1.0, 1.4]),
    st.floats(0, 3),
)
def test_every_delay_that_is_forbidden_is_in_conflict(seed, close, nearness, scale, departure):
    rng = np.random.default_rng(seed)
    a, b = random_flight(rng), random_flight(rng)
    gap = rng.normal(size=3)
    gap *= nearness / np.linalg.norm(gap / (XY, XY, Z))
    ours, theirs = b.at([b.start, b.end]).position, a.at([a.start, a.end]).position
    here, there = {"starts": (0, 0), "targets": (1, 1), "another's way": (0, 1)}[close]
    b = shifted(b, theirs[there] - ours[here] + gap)
    store = CurveStore()
    store.add(a), store.add(b)
    curves = store.arrays.curves
    other = TimedCurve(0, departure, 1.0)
    free = free_departures(departure + a.end - a.start)
    forbid_at_rest(curves, other, 1, scale, XY, Z, free)
    for k in np.flatnonzero(free[:-1] != np.arange(len(free) - 1))[::10]:
        assert in_conflict(curves, other, TimedCurve(1, k * TICK, scale), XY, Z)


def test_a_flight_that_waits_where_the_other_one_passes_must_depart_before():
    rng = np.random.default_rng(5)
    first = random_flight(rng)
    middle = first.at([(first.start + first.end) / 2]).position[0]
    second = random_flight(rng)
    second = shifted(second, middle - second.at([second.start]).position[0])
    store = CurveStore()
    store.add(first), store.add(second)
    curves = store.arrays.curves
    free = free_departures(first.end - first.start)
    forbid_at_rest(curves, TimedCurve(0, 0.0, 1.0), 1, 1.0, XY, Z, free)
    late = int((first.end - first.start) / 2 / TICK) + 1
    assert (free[late:-1] > np.arange(late, len(free) - 1)).all()
