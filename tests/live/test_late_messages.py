"""Messages that come late, twice or never: what they tell counts for its instant, in whatever order they arrive."""

from functools import cache

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

import skyverse as sky
from replanned import BALL, hall

ERROR, HARDEST, STEP = 0.2, 4.0, 0.01
NAMES = ("a", "b", "c")


@cache
def mission():
    """A mission of two UAVs, one of which stays where nothing is observed."""
    uavs = [
        sky.UAV(
            start=(1, y, 1),
            max_acceleration=HARDEST,
            tracking_error=sky.TrackingError(horizontal=ERROR, vertical=ERROR),
        )
        for y in (5, 8)
    ]
    return sky.plan_mission(hall(uavs=uavs, targets=[sky.Target(position=(19, 5, 1)), sky.Target(position=(1, 8, 2))]))


def around(rng, half, **more):
    at = rng.uniform((2, 1, 1), (18, 9, 3))
    return sky.Box(min=tuple(at - half), max=tuple(at + half), **more)


def message(rng, t):
    """What is observed at an instant: each of several things or nothing of it."""
    seen = {"t": t}
    names = rng.permutation(NAMES)
    if rng.uniform() < 0.6:
        more = {"max_acceleration": 0.5} if rng.uniform() < 0.5 else {}
        places = rng.uniform((8, 1, 1), (18, 9, 3), (2, 3))
        seen["movers"] = [
            sky.Sighting(name=name, shape=BALL, position=tuple(at), top_speed=1.0, error=0.1, **more)
            for name, at in zip(names, places[: rng.integers(1, 3)], strict=False)
        ]
    if rng.uniform() < 0.4:
        seen["gone"] = [names[-1]]
    if rng.uniform() < 0.2:
        seen["obstacles"] = [around(rng, 0.2)]
    if rng.uniform() < 0.2:
        seen["zones"] = [around(rng, 0.3, active=[(t - 1.0, t + 3.0)])]
    if rng.uniform() < 0.3:
        seen["targets"] = {1: tuple(rng.uniform((1, 7, 1), (18, 9, 3)))}
    return seen


def session(messages):
    """A replanner that was told some messages, of which those that it refuses change nothing."""
    flight = sky.Replanner(mission(), candidates=4)
    flight.observe(
        0.0, movers=[sky.Sighting(name=name, shape=BALL, position=(15, 8, 3), top_speed=1.0) for name in NAMES]
    )
    for one in messages:
        flight.observe(**one)
    return flight


def known(flight, until):
    """What is known of movers, zones and targets, whatever came first."""
    movers = {one.name: one for one in flight._tracks.predicted(until)}
    return movers, set(map(repr, flight.scenario.zones)), flight.scenario.targets


@settings(max_examples=20)
@given(st.integers(0, 10_000))
@example(5)
def test_in_whatever_order_messages_come_the_same_is_known_in_the_end(seed):
    rng = np.random.default_rng(seed)
    sent = [message(rng, round(0.1 * k, 1)) for k in range(1, 8)]
    sent = [one for one in sent if rng.uniform() < 0.9]  # some are lost
    twice = [one for one in sent if rng.uniform() < 0.3]
    late = [(sent + twice)[k] for k in rng.permutation(len(sent + twice))]
    one, other = session([*sent, {"t": 0.8}]), session([*late, {"t": 0.8}])
    assert known(one, 3.0) == known(other, 3.0)
    for box in (box for seen in sent for box in seen.get("obstacles", ())):
        assert any(
            np.all(np.less_equal(known.min, box.min)) and np.all(np.greater_equal(known.max, box.max))
            for known in (*other.scenario.obstacles, *other._entered)
        )


def pulled(place, velocity, motion, times):
    """Where a controller takes a UAV along a motion, by no more than its greatest acceleration."""
    aims = motion.at(times)
    for aim, speed, push in zip(*aims, strict=True):
        wanted = push + 100.0 * (aim - place) + 20.0 * (speed - velocity)
        velocity = velocity + STEP * wanted * min(1.0, HARDEST / max(np.linalg.norm(wanted), 1e-9))
        place = place + STEP * velocity
    return place, velocity


@settings(max_examples=20)
@given(st.integers(0, 100_000))
@example(1020)
def test_who_is_proven_is_where_it_is_taken_to_be_however_late_its_states_come(seed):
    """A gust moves a UAV, whose controller then brings it back, while its states come in any order, late or never."""
    rng = np.random.default_rng(seed)
    flight, waiting, newest = sky.Replanner(mission(), candidates=8), [], 0.0
    gust, delay, turn = rng.uniform(0.3, 2.0), rng.choice([0.02, 0.1, 0.3, 1.0]), rng.uniform(0.0, 2.0 * np.pi)
    place, velocity = np.array((1.0, 5.0, 1.0)), np.zeros(3)
    for now in np.round(np.arange(0.1, 3.5, 0.1), 6):
        place, velocity = pulled(place, velocity, flight.flown(0), now - 0.1 + STEP * np.arange(1, 11))
        if now - 0.1 < gust <= now:
            place = place + rng.choice([0.4, 1.5]) * np.array((np.cos(turn), np.sin(turn), 0.0))
        if rng.uniform() < 0.8:
            waiting.append((now + delay * rng.choice([0.0, rng.uniform()]), now, (place, velocity)))
        (answer, _) = flight.observe(now)
        for one in sorted((one for one in waiting if one[0] <= now), key=lambda one: one[:2]):
            waiting = [other for other in waiting if other is not one]
            _, t, state = one
            (answer, _) = flight.observe(t, states={0: state})
            newest = max(newest, t)
        if newest >= gust and answer.proven:
            assert np.linalg.norm(flight.motion(0).at([now]).position[0] - place) <= ERROR + 0.1
