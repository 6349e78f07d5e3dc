"""Forbidden departures, against every delay and every pair of leaves."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from curves import random_flight
from nearness import Timed, moved_to_meet, nearness
from skyverse.deconfliction import TICK, CurveStore, TimedCurve, free_departures, in_conflict
from skyverse.deconfliction.forbidden_departures import forbid_at_rest, forbid_departures, next_free, sweep_of

TINY = 1e-9


def parts_of(boxes, begin, end, *, waits):
    """The boxes and the spans of time of a flight's parts: before it, of each leaf, and after it."""
    leaves = (len(boxes) - 1) // 2
    knots = np.linspace(begin, end, leaves + 1)
    spans = [(waits, begin), *itertools.pairwise(knots), (end, np.inf)]
    return np.vstack([boxes[:1], boxes[leaves : 2 * leaves], boxes[2 * leaves :]]), np.array(spans)


def exhaustively_forbidden(a, b, seconds, count, axes):
    """Which of some delays a pair of parts forbids, however that pair is found."""
    (boxes_a, begin, end), boxes_b = a, b
    theirs, their_spans = parts_of(boxes_a, begin, end, waits=0.0)
    own, own_spans = parts_of(boxes_b, 0.0, seconds, waits=-np.inf)
    gap = np.zeros((len(theirs), len(own)))
    for axis in range(3):
        ahead = own[None, :, axis] - theirs[:, None, 3 + axis]
        behind = theirs[:, None, axis] - own[None, :, 3 + axis]
        gap += (np.maximum(np.maximum(ahead, behind), 0.0) / axes[axis]) ** 2
    close = gap < 1.0
    if begin <= 0.0:
        close[0] = False
    close[0, 0] = close[-1, -1] = False  # both wait, or both have arrived: no delay changes that
    forbidden = np.zeros(count, bool)
    for i, j in zip(*np.nonzero(close), strict=True):
        least, most = (their_spans[i, 0] - own_spans[j, 1]) / TICK, (their_spans[i, 1] - own_spans[j, 0]) / TICK
        first = 0 if least <= 0.0 else int(np.ceil(least - TINY))
        final = count - 1 if most >= count - 1 else int(np.floor(most + TINY))
        forbidden[first : max(final + 1, 0)] = True
    return forbidden


@given(st.integers(0, 2**32), st.sampled_from([1.0, 1.4]))
def test_forbidden_are_those_delays_that_some_pair_of_leaves_forbids(seed, scale):
    rng = np.random.default_rng(seed)
    departure, axes = float(rng.choice([0.0, rng.uniform(0.0, 2.0)])), rng.uniform(0.2, 0.8, 2).tolist()
    a, flown = random_flight(rng), Timed(random_flight(rng), rng.uniform(0.0, 3.0), scale)
    b = moved_to_meet(rng, flown, Timed(a, departure, 1.0)).trajectory
    store = CurveStore()
    store.add(a), store.add(b)
    swept = store.arrays
    seconds = scale * store.seconds[1]
    other = TimedCurve(0, departure, 1.0)
    free = free_departures(departure + store.seconds[0] + 1.0)
    forbid_departures(sweep_of(swept, other, 1), sweep_of(swept, TimedCurve(1, 0.0, scale), 1), tuple(axes), free)
    forbidden = free[:-1] != np.arange(len(free) - 1)
    rows = [swept.boxes[swept.base[c] : swept.base[c] + 2 * swept.leaves[c] + 1] for c in range(2)]
    flown = rows[0], departure, departure + store.seconds[0]
    expected = exhaustively_forbidden(flown, rows[1], seconds, len(forbidden), (axes[0], *axes))
    np.testing.assert_array_equal(forbidden, expected)
    end = departure + store.seconds[0]
    for k in np.flatnonzero(~forbidden)[::5]:  # a free delay is free of conflict while one of the two flies
        own = Timed(b, k * TICK, scale)
        times = np.arange(min(departure, k * TICK), max(end, own.arrival), 0.005)
        assert nearness(Timed(a, departure, 1.0), own, *axes, times).min() > 1 - 1e-9


@given(st.floats(0.0, 5.0), st.floats(-1.0, 5.0))
def test_free_are_the_ticks_between_the_earliest_and_the_latest(latest, since):
    free = free_departures(latest, since)
    ticks = np.arange(len(free) - 1) * TICK
    assert len(ticks) == 0 or abs(ticks[-1] - latest) <= TICK * (1 + 1e-6)
    for k, at in enumerate(ticks):
        if abs(at - since) > 1e-6:
            assert (free[k] == k) == (at >= since)
    assert free[-1] == len(free) - 1


@given(st.lists(st.booleans(), min_size=1, max_size=60), st.data())
def test_the_next_free_delay_is_the_first_that_is_not_forbidden(forbidden, data):
    free = np.arange(len(forbidden) + 1)
    for k in data.draw(st.permutations([k for k, is_forbidden in enumerate(forbidden) if is_forbidden])):
        free[k] = k + 1
        next_free(free, data.draw(st.integers(0, len(forbidden))))  # shortens the ways of later ones
    for i in range(len(forbidden) + 1):
        expected = next((k for k in range(i, len(forbidden)) if not forbidden[k]), len(forbidden))
        assert next_free(free, i) == expected


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
