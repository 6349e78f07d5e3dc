"""Departures that are said to be free are, and those that are not too close by far are found."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from curves import random_flight
from skyverse.deconfliction.curve_store import Shelf
from skyverse.deconfliction.curves import Placed
from skyverse.deconfliction.swept_volume_tree import STRIDE, TICK, all_free, earliest
from skyverse.trajectory import rest_to_rest

WIDE, TALL = 0.5, 1.0


def least(a, b, at, scale):
    """The least nearness of b, departing at an instant, to a, by dense sampling."""
    flown = b.retimed(at, scale)
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


def test_who_starts_or_ends_just_far_enough_is_asked_every_few_delays():
    known = 0
    for seed in range(15):
        a = random_flight(np.random.default_rng(seed))
        moved = a.coefficients.copy()
        moved[:, 0, 0] += WIDE * 1.0001
        b = type(a)(a.knots, moved)
        found, delays = departures(a, b)
        if found >= 0:
            assert least(a, b, found, 1.0) > 1 - 1e-6
        free = np.array([least(a, b, at, 1.0) > 1.00005 for at in delays])
        runs = np.flatnonzero(np.convolve(free, np.ones(STRIDE), "valid") == STRIDE)
        if len(runs):
            known += 1
            assert a.start - 1e-9 <= found <= delays[runs[0] + STRIDE - 1] + 1e-9
    assert known >= 3


def test_who_starts_too_close_departs_once_the_other_is_out_of_the_way():
    first = rest_to_rest(np.array([(0.2, 0, 0), (9, 0, 0)]), sky.UAV(start=(0.2, 0, 0)))
    second = rest_to_rest(np.array([(0, 0, 0), (0, 9, 0)]), sky.UAV(start=(0, 0, 0)))
    assert departures(first, second)[0] == 0.0
    faster = rest_to_rest(np.array([(0, 0, 0), (8, 0, 0)]), sky.UAV(start=(0, 0, 0)))
    slower = first.retimed(0.0, 2.0)
    assert 0.0 < departures(slower, faster)[0] < slower.end


def departures(a, b):
    """When b departs at the earliest, to be apart from a, whose starts or targets are near; and what was asked."""
    shelf = Shelf()
    shelf.add(a), shelf.add(b)
    curves, tubes = shelf.laid
    placed = Placed(np.array([0]), np.array([a.start]), np.array([1.0]))
    free = all_free(a.end, a.start)
    delays = np.arange(math.ceil(a.start / TICK - 1e-9), len(free) - 1) * TICK
    sizes = np.array([WIDE]), np.array([TALL])
    return earliest(curves, tubes, placed, *sizes, np.ones(1, bool), 1, 1.0, free), delays
