"""Departures that are said to be free are, and those that are not too close by far are found."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from curves import random_flight
from skyverse.apart.curves import Placed, restarted
from skyverse.apart.shelf import Shelf
from skyverse.apart.tubes import TICK, all_free, earliest

WIDE, TALL = 0.5, 1.0


def least(a, b, at, scale):
    """The least nearness of b, departing at an instant, to a, by dense sampling."""
    flown = restarted(b, at, scale)
    times = np.arange(0.0, max(a.end, flown.end) + 0.01, 0.004)
    gap = (a.at(times).position - flown.at(times).position) / (WIDE, WIDE, TALL)
    return np.sqrt(np.sum(gap**2, axis=1)).min()


@given(st.integers(0, 2**32), st.sampled_from([1.0, 1.4]))
@settings(max_examples=30)
def test_the_earliest_free_departure_is_free_and_no_earlier_one_is_clearly_so(seed, scale):
    rng = np.random.default_rng(seed)
    a, b = random_flight(rng), random_flight(rng)
    shelf = Shelf()
    shelf.add(a), shelf.add(b)
    curves, tubes = shelf.laid
    placed = Placed(np.array([0]), np.array([a.start]), np.array([1.0]))
    sizes = np.array([WIDE]), np.array([TALL])
    found = earliest(curves, tubes, placed, *sizes, np.zeros(1, bool), 1, scale, all_free(a.end, 0.0))
    refused = np.arange(0.0, found if found >= 0 else a.end, 5 * TICK)
    # boxes have some metres a second times hundredths of a second to spare
    assert all(least(a, b, at, scale) < 1.5 for at in refused)
    if found >= 0:
        assert least(a, b, found, scale) > 1 - 1e-9


@given(st.integers(0, 2**32))
@settings(max_examples=15)
def test_who_starts_or_ends_just_far_enough_is_asked_delay_by_delay(seed):
    rng = np.random.default_rng(seed)
    a = random_flight(rng)
    moved = a.coefficients.copy()
    moved[:, 0, 0] += WIDE * 1.0001
    b = type(a)(a.knots, moved)
    shelf = Shelf()
    shelf.add(a), shelf.add(b)
    curves, tubes = shelf.laid
    placed = Placed(np.array([0]), np.array([a.start]), np.array([1.0]))
    sizes = np.array([WIDE]), np.array([TALL])
    free = all_free(a.end, a.start)
    found = earliest(curves, tubes, placed, *sizes, np.ones(1, bool), 1, 1.0, free)
    if found >= 0:
        assert least(a, b, found, 1.0) > 1 - 1e-6
