"""Spans of conflict between two flights, against dense sampling and root finding."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import brentq

from curves import random_flight
from nearness import Timed, moved_to_meet, nearness
from skyverse.deconfliction.curves import TimedCurve, make_curves
from skyverse.deconfliction.pair_conflicts import conflict_spans, in_conflict, is_given, nearness_at_ends
from skyverse.numerics.tolerances import MIN_CONFLICT

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
def test_spans_hold_every_sample_that_is_too_close_and_none_that_is_not(seed):
    pair = Pair(seed)
    times = np.linspace(0.0, pair.end, 4000)
    near = pair.nearness(times)
    inside = np.zeros(len(times), bool)
    for begin, end in pair.spans()[:, :2]:
        inside |= (times >= begin) & (times <= end)
    assert inside[near < 1 - 1e-9].all()
    assert (near[inside] < 1 + 1e-4).all()


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
