"""Departures that are said to be free are, and those that are clearly free are found."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from curves import random_flight
from skyverse.deconfliction.curve_store import CurveStore
from skyverse.deconfliction.curves import Schedule
from skyverse.deconfliction.forbidden_departures import TICK, free_departures
from skyverse.deconfliction.traffic import STRIDE, Traffic, earliest_departure
from skyverse.trajectory import rest_to_rest

SEMI_AXIS_XY, SEMI_AXIS_Z = 0.5, 1.0


def least_nearness(a, b, departure, scale):
    """The least nearness of b, which departs at an instant, to a, by dense sampling."""
    flown = b.retimed(departure, scale)
    times = np.arange(0.0, max(a.end, flown.end) + 0.01, 0.004)
    gap = (a.at(times).position - flown.at(times).position) / (SEMI_AXIS_XY, SEMI_AXIS_XY, SEMI_AXIS_Z)
    return np.sqrt(np.sum(gap**2, axis=1)).min()


def first_departure(a, b, scale, free, *, close_ends):
    """When b departs at the earliest without a conflict with a."""
    store = CurveStore()
    store.add(a), store.add(b)
    curves, trees = store.arrays
    schedule = Schedule(np.array([0]), np.array([a.start]), np.array([1.0]))
    traffic = Traffic(schedule, np.array([SEMI_AXIS_XY]), np.array([SEMI_AXIS_Z]), np.array([close_ends]))
    return earliest_departure(curves, trees, traffic, 1, scale, free)


@given(st.integers(0, 2**32), st.sampled_from([1.0, 1.4]))
@settings(max_examples=30)
def test_the_earliest_free_departure_is_free_and_no_earlier_one_is_clearly_so(seed, scale):
    rng = np.random.default_rng(seed)
    a, b = random_flight(rng), random_flight(rng)
    found = first_departure(a, b, scale, free_departures(a.end, 0.0), close_ends=False)
    refused = np.arange(0.0, found if found >= 0 else a.end, 5 * TICK)
    # boxes are larger than the curve in them, by its speed of some metres a second times hundredths of a second
    assert all(least_nearness(a, b, at, scale) < 1.5 for at in refused)
    if found >= 0:
        assert least_nearness(a, b, found, scale) > 1 - 1e-9


def test_a_flight_that_starts_or_ends_just_far_enough_is_tested_every_few_delays():
    known = 0
    for seed in range(15):
        a = random_flight(np.random.default_rng(seed))
        moved = a.coefficients.copy()
        moved[:, 0, 0] += SEMI_AXIS_XY * 1.0001
        b = type(a)(a.knots, moved)
        found, delays = departure_with_close_ends(a, b)
        if found >= 0:
            assert least_nearness(a, b, found, 1.0) > 1 - 1e-6
        free = np.array([least_nearness(a, b, at, 1.0) > 1.00005 for at in delays])
        runs = np.flatnonzero(np.convolve(free, np.ones(STRIDE), "valid") == STRIDE)
        if len(runs):
            known += 1
            assert a.start - 1e-9 <= found <= delays[runs[0] + STRIDE - 1] + 1e-9
    assert known >= 3


def test_a_flight_that_starts_too_close_departs_once_the_other_is_out_of_the_way():
    first = rest_to_rest(np.array([(0.2, 0, 0), (9, 0, 0)]), sky.UAV(start=(0.2, 0, 0)))
    second = rest_to_rest(np.array([(0, 0, 0), (0, 9, 0)]), sky.UAV(start=(0, 0, 0)))
    assert departure_with_close_ends(first, second)[0] == 0.0
    faster = rest_to_rest(np.array([(0, 0, 0), (8, 0, 0)]), sky.UAV(start=(0, 0, 0)))
    slower = first.retimed(0.0, 2.0)
    assert 0.0 < departure_with_close_ends(slower, faster)[0] < slower.end


def departure_with_close_ends(a, b):
    """When b departs at the earliest where its start or target is near to that of a; and the delays considered."""
    free = free_departures(a.end, a.start)
    delays = np.arange(math.ceil(a.start / TICK - 1e-9), len(free) - 1) * TICK
    return first_departure(a, b, 1.0, free, close_ends=True), delays
