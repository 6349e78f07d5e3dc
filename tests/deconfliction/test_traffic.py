"""Departures that are said to be free are, and those that are clearly free are found."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from curves import random_flight
from nearness import Timed, moved_to_meet, nearness
from skyverse.deconfliction import TICK, CurveStore, Schedule, TimedCurve, free_departures, in_conflict
from skyverse.deconfliction.traffic import (
    STRIDE,
    Traffic,
    conflicting_flights,
    earliest_departure,
    estimate_detours,
)
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
    schedule = Schedule(np.array([0]), np.array([a.start]), np.array([1.0]))
    traffic = Traffic(schedule, np.array([SEMI_AXIS_XY]), np.array([SEMI_AXIS_Z]), np.array([close_ends]))
    return earliest_departure(store.arrays, traffic, 1, scale, free)


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


class Crowd:
    """Some random flights, and one more that has yet to be placed, and that meets each if it departs at some delay."""

    def __init__(self, seed, count):
        rng = np.random.default_rng(seed)
        self.own, self.number = random_flight(rng), count
        self.others = [Timed(random_flight(rng), rng.uniform(0, 3), rng.choice([1.0, 1.4])) for _ in range(count)]
        self.others = [moved_to_meet(rng, other, Timed(self.own, rng.uniform(0, 2), 1.0)) for other in self.others]
        self.store = CurveStore()
        for flight in [*(other.trajectory for other in self.others), self.own]:
            self.store.add(flight)
        self.axes = rng.uniform(0.2, 0.8, (count, 2))
        schedule = Schedule(
            np.arange(count),
            np.array([o.departure for o in self.others]),
            np.array([o.time_scale for o in self.others]),
        )
        axes = np.ascontiguousarray(self.axes.T)
        self.traffic = Traffic(schedule, axes[0], axes[1], np.zeros(count, bool))
        self.latest = max(other.arrival for other in self.others)

    def least_nearness(self, departure):
        """The least nearness of the flight to each of the others while one of the two flies, by dense sampling."""
        own = Timed(self.own, departure, 1.0)
        least = []
        for other, axes in zip(self.others, self.axes, strict=True):
            times = np.arange(min(departure, other.departure), max(own.arrival, other.arrival), 0.01)
            least.append(nearness(own, other, *axes, times).min())
        return np.array(least)

    def earliest(self):
        return earliest_departure(self.store.arrays, self.traffic, self.number, 1.0, free_departures(self.latest))


@given(st.integers(0, 2**32), st.integers(1, 4))
def test_among_many_the_earliest_departure_is_free_of_all_and_each_earlier_one_meets_somebody(seed, count):
    crowd = Crowd(seed, count)
    found = crowd.earliest()
    if found >= 0:
        assert (crowd.least_nearness(found) > 1 - 1e-9).all()
    for earlier in np.arange(0.0, found if found >= 0 else crowd.latest, TICK)[::5]:
        assert crowd.least_nearness(earlier).min() < 1.5  # boxes are larger than what they enclose


@given(st.integers(0, 2**32), st.integers(1, 5), st.booleans())
def test_conflicting_flights_are_those_that_an_exact_test_of_each_pair_finds(seed, count, at_once):
    crowd = Crowd(seed, count)
    own = TimedCurve(crowd.number, 0.0 if at_once else 1.23, 1.0)
    found = conflicting_flights(crowd.store.arrays, crowd.traffic, own)
    schedule = crowd.traffic.schedule
    for p, (xy, z) in enumerate(crowd.axes):
        other = TimedCurve(p, schedule.departure[p], schedule.time_scale[p])
        assert found[p] == in_conflict(crowd.store.arrays.curves, other, own, xy, z)


@given(st.integers(0, 2**32), st.integers(1, 4), st.floats(0.1, 0.9))
def test_estimates_without_an_offset_are_no_earlier_than_the_earliest_arrival(seed, count, share):
    crowd = Crowd(seed, count)
    offsets, ratios = np.zeros((1, 3)), np.ones(1)
    seconds = crowd.store.seconds[crowd.number]
    latest = crowd.latest + seconds
    (arrival,) = estimate_detours(crowd.store.arrays, crowd.traffic, crowd.number, offsets, ratios, share, 0.0, latest)
    found = crowd.earliest()
    assert arrival == np.inf if found < 0 else arrival >= found + seconds - 1e-9


@given(st.integers(0, 2**32), st.floats(1.0, 3.0), st.floats(0.0, 2.0))
def test_estimates_where_nobody_flies_are_the_detours_flown_at_once(seed, ratio, since):
    crowd = Crowd(seed, 1)
    nobody = Traffic(
        Schedule(*(column[:0] for column in crowd.traffic.schedule)), *(np.zeros(0),) * 2, np.zeros(0, bool)
    )
    seconds = crowd.store.seconds[crowd.number] * ratio
    (arrival,) = estimate_detours(
        crowd.store.arrays, nobody, crowd.number, np.ones((1, 3)), np.array([ratio]), 0.5, since, 100.0
    )
    assert since - 1e-6 <= arrival - seconds <= since + TICK
