"""Conflicts of fleets against dense sampling, and in cases whose answer is obvious."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import skyverse as sky
from curves import random_flight
from handmade import hall
from nearness import Timed, moved_to_meet, nearness
from skyverse.deconfliction import TimedCurve, conflict_spans, in_conflict, make_curves
from skyverse.deconfliction.find_conflicts import is_given, nearness_at_ends
from skyverse.numerics.tolerances import MIN_CONFLICT
from skyverse.trajectory import rest_to_rest


def fleet(starts, **limits):
    uavs = [sky.UAV(start=tuple(start), **limits) for start in starts]
    return hall(None, uavs, bounds={"min": (-50, -50, -50), "max": (50, 50, 50)})


def flight(scenario, uav, *points, start=0.0):
    return rest_to_rest(np.array([scenario.uavs[uav].start, *points]), scenario.uavs[uav], start=start)


def nearness_of(scenario, trajectories, i, j, times):
    a, b = (trajectories[k].at(times).position for k in (i, j))
    one, other = (scenario.uavs[k].ellipsoid for k in (i, j))
    semi_axis_xy, semi_axis_z = max(one[0], other[0]), max(one[1], other[1])
    gap = (a - b) / (semi_axis_xy, semi_axis_xy, semi_axis_z)
    return np.sqrt(np.sum(gap**2, axis=1))


@given(st.integers(0, 2**32))
@settings(max_examples=25)
def test_conflicts_are_those_that_dense_sampling_finds(seed):
    rng = np.random.default_rng(seed)
    flights = [random_flight(rng) for _ in range(5)]
    uavs = [
        sky.UAV(start=tuple(f.at(f.start).position[0]), separation=s, vertical_separation=2 * s)
        for f, s in zip(flights, rng.uniform(0.2, 0.8, 5), strict=True)
    ]
    scenario = fleet([(0, 0, 0)]).model_copy(update={"uavs": tuple(uavs)})
    found = sky.find_conflicts(scenario, flights)
    times = np.arange(0.0, max(f.end for f in flights), 0.002)
    for i in range(5):
        for j in range(i + 1, 5):
            near = nearness_of(scenario, flights, i, j, times)
            spans = [(c.begin, c.end) for c in found if c.uavs == (i, j)]
            inside = np.zeros(len(times), bool)
            for begin, end in spans:
                inside |= (times >= begin - 1e-5) & (times <= end + 1e-5)
            assert inside[near < 1 - 1e-5].all()
            outside = np.ones(len(times), bool)
            for begin, end in spans:
                outside &= (times < begin + 1e-5) | (times > end - 1e-5)
            assert outside[near > 1 + 1e-5].all()
            for conflict in (c for c in found if c.uavs == (i, j)):
                within = near[(times >= conflict.begin) & (times <= conflict.end)]
                assert conflict.begin <= conflict.time <= conflict.end
                assert not len(within) or conflict.nearness <= within.min() + 1e-3


def test_a_uav_that_waits_at_its_start_or_stays_at_its_target_counts():
    scenario = fleet([(0, 0, 0), (-5, 0.2, 0), (-5, 0.2, 9)])
    first = flight(scenario, 0, (0, 9, 0), start=30.0)
    second = flight(scenario, 1, (5, 0.2, 0))
    conflict, *others = sky.find_conflicts(scenario, [first, second, None])
    assert not others
    assert conflict.uavs == (0, 1)
    assert not conflict.given
    assert conflict.nearness == pytest.approx(0.4, abs=1e-3)
    assert 0 < conflict.begin < conflict.time < conflict.end < second.end


def test_more_distance_is_kept_below_and_above_than_beside():
    scenario = fleet([(0, 0, 0), (-5, 0, 0.9), (0, -5, 0), (-5, 0.6, 0)])
    flights = [None, flight(scenario, 1, (5, 0, 0.9)), None, flight(scenario, 3, (5, 0.6, 0))]
    assert {c.uavs for c in sky.find_conflicts(scenario, flights)} == {(0, 1)}


def test_starts_and_targets_that_are_too_close_are_given():
    scenario = fleet([(0, 0, 0), (0, 0.3, 0)])
    flights = [flight(scenario, 0, (9, 0, 0), start=1.0), flight(scenario, 1, (9, 9, 0), (9, 0.4, 0))]
    first, last = sky.find_conflicts(scenario, flights)
    assert first.given
    assert first.begin == 0.0
    assert first.nearness == pytest.approx(0.6, abs=1e-6)
    assert last.given
    assert last.end == flights[1].end


def test_a_pair_that_comes_closer_than_its_given_starts_is_in_a_conflict_like_any_other():
    scenario = fleet([(0, 0, 0), (0.4, 0, 0)])
    flights = [flight(scenario, 0, (9, 0, 0)), flight(scenario, 1, (0.4, 9, 0), start=5.0)]
    (through,) = sky.find_conflicts(scenario, flights)
    assert not through.given
    assert through.begin == 0.0
    assert through.nearness == pytest.approx(0.0, abs=1e-6)
    flights = [flight(scenario, 0, (9, 0, 0), start=5.0), flight(scenario, 1, (0.4, 9, 0))]
    (given,) = sky.find_conflicts(scenario, flights)
    assert given.given
    assert given.nearness == pytest.approx(0.8, abs=1e-6)


def test_half_a_metre_is_far_enough():
    scenario = fleet([(0, 0, 0), (0, 0.5, 0), (0, 0, 1)])
    assert sky.find_conflicts(scenario, [None, None, None]) == ()


def test_uavs_that_keep_no_separation_are_never_too_close():
    scenario = fleet([(0, 0, 0), (0, 0, 0)], separation=0)
    assert sky.find_conflicts(scenario, [None, None]) == ()


def test_there_must_be_as_many_trajectories_as_uavs(refuses):
    with refuses():
        sky.find_conflicts(fleet([(0, 0, 0), (1, 0, 0)]), [None])


SEEDS = st.integers(0, 2**32)


class Pair:
    """Two random flights that meet; they depart at random instants and are slowed down at random."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        one, other = (Timed(random_flight(rng), rng.uniform(0, 2), rng.uniform(1, 2)) for _ in range(2))
        self.flown = [one, moved_to_meet(rng, other, one)]
        self.curves = make_curves([flight.trajectory for flight in self.flown])
        self.timed = [TimedCurve(c, f.departure, f.time_scale) for c, f in enumerate(self.flown)]
        self.axes = tuple(rng.uniform(0.2, 1.0, 2).tolist())
        self.end = max(flight.arrival for flight in self.flown)

    def spans(self, *, first_only=False, swapped=False):
        one, other = reversed(self.timed) if swapped else self.timed
        return conflict_spans(self.curves, one, other, *self.axes, self.end, first_only)

    def nearness(self, times):
        return nearness(*self.flown, *self.axes, times)


@given(SEEDS)
def test_the_first_conflict_begins_where_a_root_finder_says(seed):
    pair = Pair(seed)
    times = np.linspace(0.0, pair.end, 4000)
    near = pair.nearness(times)
    assume(near[0] > 1 and near.min() < 0.98)
    k = int(np.argmax(near < 1))
    crossing = brentq(lambda t: pair.nearness([t])[0] - 1, times[k - 1], times[k], xtol=1e-12)
    begin = pair.spans()[0, 0]
    assert begin <= crossing + 1e-9
    earlier = np.linspace(begin, crossing, 50)
    # until then it is undecided at most: it touches the ellipsoid, or is within one interval that is not halved again
    assert crossing - begin <= MIN_CONFLICT or (pair.nearness(earlier) < 1 + 1e-4).any()


@given(SEEDS)
def test_spans_are_in_order_and_say_when_the_pair_is_nearest(seed):
    pair = Pair(seed)
    spans = pair.spans()
    assert (spans[:, 0] <= spans[:, 1]).all()
    assert (spans[1:, 0] > spans[:-1, 1]).all()
    for begin, end, when, square in spans:
        assert begin <= when <= end
        assert np.isclose(pair.nearness([when])[0] ** 2, square, atol=1e-9)
        assert square <= pair.nearness(np.linspace(begin, end, 500)).min() ** 2 + 1e-3


@given(SEEDS)
def test_both_flights_may_be_exchanged_and_the_first_part_of_a_span_is_within_it(seed):
    pair = Pair(seed)
    spans, swapped, first = pair.spans(), pair.spans(swapped=True), pair.spans(first_only=True)
    np.testing.assert_allclose(spans, swapped, atol=1e-6)
    assert len(first) == min(len(spans), 1)
    if len(first):
        assert first[0, 0] == spans[0, 0]
        assert first[0, 1] <= spans[0, 1]


@given(SEEDS)
def test_a_conflict_is_a_span_that_starts_or_targets_do_not_give(seed):
    pair = Pair(seed)
    begins, ends = nearness_at_ends(pair.curves, 0, 1, *pair.axes)
    np.testing.assert_allclose([begins, ends], pair.nearness([0.0, pair.end]), atol=1e-9)
    end = pair.end + 1.0
    spans = conflict_spans(pair.curves, *pair.timed, *pair.axes, end, False)
    resolvable = [span for span in spans if not is_given(span, begins, ends, end)]
    assert in_conflict(pair.curves, *pair.timed, *pair.axes) == bool(resolvable)
    for begin, until, _, square in resolvable:
        nearer = min(n for n in (begins, ends, 1.0) if n < 1 or n == 1.0)
        at_an_end = (begin <= 0.0 and begins < 1) or (until >= end and ends < 1)
        assert not at_an_end or np.sqrt(square) < max(begins, ends, nearer)


@given(SEEDS, st.floats(0.0, 6.3), st.floats(0.3, 0.95))
def test_a_pair_that_departs_from_starts_that_are_too_close_and_parts_is_given(seed, angle, gap):
    rng = np.random.default_rng(seed)
    flight = random_flight(rng)
    moved = flight.coefficients.copy()
    way = np.array([np.cos(angle), np.sin(angle), 0.0])
    moved[:, 0] += gap * way
    moved[:, 1] += 0.5 * way  # it flies on in the direction in which it starts
    for k in range(1, len(moved)):
        moved[k, 0] += 0.5 * way * (flight.knots[k] - flight.knots[0])
    other = type(flight)(flight.knots, moved)
    curves = make_curves([flight, other])
    one, two = TimedCurve(0, 0.0, 1.0), TimedCurve(1, 0.0, 1.0)
    (span, *others) = conflict_spans(curves, one, two, 1.0, 1.0, 60.0, False)
    assert not others
    begins, ends = nearness_at_ends(curves, 0, 1, 1.0, 1.0)
    assert np.isclose(begins, gap)
    assert is_given(span, begins, ends, 60.0)
    assert not in_conflict(curves, one, two, 1.0, 1.0)
