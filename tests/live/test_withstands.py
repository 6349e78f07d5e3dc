"""Whatever is observed: nothing worse than a refusal, and motions that join, keep limits and end at rest."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from replanned import faults, hall
from skyverse.live import LiveSession

BALL = {"shape": "sphere", "centre": [0, 0, 0], "radius": 0.4}
JOINS = 1e-6
"""Metres, m/s and m/s^2 by which motions may be off where they join."""


def finite(least, greatest):
    return st.floats(least, greatest, allow_nan=False)


EXTREME = st.sampled_from([float("nan"), float("inf"), 1e300, 1e12, -1e12, 1e9, 0.0, -1.0, None, "1", True, 5e-324])
STEPS = st.sampled_from([0.1] * 8 + [0.0, 0.0, 1e-9, 0.01, 0.5, 3.0, 30.0, 3600.0, -0.05, -0.3, -1.5, -60.0])
PLACE = st.tuples(finite(-2, 22), finite(-2, 12), finite(-1, 5))
SIZES = st.sampled_from([0.0, 0.05, 0.5, 2.0, 1e3])
MOVER = st.fixed_dictionaries(
    {"name": st.sampled_from(["a", "b", "c"]), "shape": st.just(BALL), "position": PLACE,
     "top_speed": st.sampled_from([0.001, 0.5, 2.0, 30.0, 1e6])},
    optional={"error": SIZES, "velocity": st.tuples(*[finite(-3, 3)] * 3), "velocity_error": SIZES,
              "max_acceleration": SIZES},
)  # fmt: skip
WALL = st.builds(
    lambda low, size: {"min": low, "max": [a + b for a, b in zip(low, size, strict=True)]},
    PLACE,
    st.tuples(*[finite(0.05, 3)] * 3),
)
ZONE = st.builds(
    lambda box, kind: {**box, **kind},
    WALL,
    st.sampled_from([{}, {"active": [[3, 9]]}, {"max_speed": 0.5}, {"active": [[None, 9]], "max_speed": 0.5}]),
)
STATE = st.fixed_dictionaries({"position": PLACE, "velocity": st.tuples(*[finite(-3, 3)] * 3)})


@st.composite
def garbled(draw, whole):
    """A mapping of which one value, or one number in it, may be what it must not be."""
    data = dict(draw(whole))
    if draw(st.integers(0, 9)) == 0:
        key = draw(st.sampled_from(sorted(data)))
        if isinstance(data[key], tuple | list) and draw(st.booleans()):
            data[key] = [draw(EXTREME), *data[key][1:]]
        else:
            data[key] = draw(EXTREME)
    return data


def rarely(strategy, one_in):
    return st.integers(0, one_in - 1).flatmap(lambda k: strategy if k == 0 else st.none())


@st.composite
def observation(draw):
    """The step of the clock, and what else is observed; `aboard` puts a mover on top of the UAV."""
    seen = {
        "movers": draw(st.lists(garbled(MOVER), max_size=3)),
        "obstacles": draw(rarely(st.lists(garbled(WALL), min_size=1, max_size=2), 6)),
        "states": draw(rarely(st.dictionaries(st.sampled_from(["uav-1", "0"]), garbled(STATE), max_size=1), 5)),
        "zones": draw(rarely(st.lists(garbled(ZONE), min_size=1, max_size=1), 8)),
        "targets": draw(rarely(st.dictionaries(st.sampled_from(["uav-1", "0"]), PLACE, max_size=1), 8)),
        "deadline_ms": draw(rarely(st.sampled_from([0, 0.0, 1e9, -1]), 4)),
    }
    return draw(STEPS), draw(rarely(st.just(True), 8)), {key: one for key, one in seen.items() if one is not None}


SEQUENCES = st.lists(observation(), min_size=1, max_size=12)


def started(**settings):
    return LiveSession(sky.Replanner(sky.plan_mission(hall()), **settings))


def steered(live, sequence):
    """Yield the answer to each observation, the motion and the flight before it, and whether it holds a state."""
    clock = 0.0
    for number, (step, aboard, seen) in enumerate(sequence, 1):
        clock = max(clock + step, 0.0)
        if aboard:
            at = live.replanner.motion(0).at([clock]).position[0].tolist()
            seen = {**seen, "movers": [{"name": "aboard", "shape": BALL, "position": at, "top_speed": 1.0}]}
        before = live.replanner.motion(0), live.replanner.flown(0)
        answer = live.answer(json.dumps({"t": clock, **seen}).encode(), number)
        assert answer is not None
        yield answer, before, "states" in seen
        clock = max(clock, live.replanner.now - 5.0)


def derived(rows):
    """The coefficients of the derivatives of polynomials, (m, k, 3)."""
    return rows[:, 1:] * np.arange(1, rows.shape[1])[None, :, None]


def require_sound(motion, uav):
    """A motion has no jumps, keeps a UAV's limits, and ends at rest."""
    assert np.isfinite(motion.knots).all()
    assert np.isfinite(motion.coefficients).all()
    lapse, rows = np.diff(motion.knots), motion.coefficients
    assert (lapse > 0).all()
    ends = []
    for _ in range(3):  # position, velocity, acceleration
        ends.append(sum(rows[:, j] * lapse[:, None] ** j for j in range(rows.shape[1])))
        assert np.abs(ends[-1][:-1] - rows[1:, 0]).max(initial=0.0) < JOINS
        rows = derived(rows)
    assert np.linalg.norm(ends[1][-1]) < JOINS
    for share in np.linspace(0.0, 1.0, 9):
        jerk = sum(rows[:, j] * (share * lapse[:, None]) ** j for j in range(rows.shape[1]))
        assert np.linalg.norm(jerk, axis=1).max() <= uav.max_jerk * (1 + 1e-6)
    assert np.linalg.norm(ends[2], axis=1).max() <= uav.max_acceleration * (1 + 1e-6)


@given(SEQUENCES)
def test_whatever_is_observed_motions_join_keep_limits_and_end_at_rest(sequence):
    live = started()
    uav = live.replanner.scenario.uavs[0]
    for answer, before, moved in steered(live, sequence):
        refused = hasattr(answer, "error")
        motion, now = live.replanner.motion(0), live.replanner.now
        require_sound(motion, uav)
        if refused:
            assert (motion, live.replanner.flown(0)) == before
        else:
            if not moved:
                for one, other in zip(motion.at([now]), before[0].at([now]), strict=True):
                    assert one == pytest.approx(other, abs=JOINS)
            (told,) = answer.uavs
            assert told.motion.knots == tuple(motion.knots)
            if told.proven:
                assert faults(live.replanner) == []


WALL_BESIDE = sky.Box(min=(8, 0, 0), max=(9, 4.5, 4))


def gap(place):
    """How far a place is from the wall, and how far inside of the hall; metres, of which the less counts."""
    off = np.linalg.norm(np.maximum(np.maximum(WALL_BESIDE.min - place, place - WALL_BESIDE.max), 0.0))
    return min(off, (place - 0.0).min(), (np.array([20, 10, 4]) - place).min())


@pytest.mark.parametrize(
    ("place", "due"), [((7.9, 3, 1), 0.2), ((8.5, 4.6, 1), 0.2), ((5, -0.05, 1), 0.0), ((12, 5, 4.1), 0.0)]
)
def test_a_uav_that_was_blown_to_where_it_may_not_be_leaves_and_arrives(place, due):
    flight = sky.Replanner(sky.plan_mission(hall(WALL_BESIDE)))
    flight.observe(1.5)
    (replan,) = flight.observe(1.5, states={0: (place, (0, 0, 0))})
    assert not replan.proven
    seen = [flight.observe(1.5 + k / 10)[0].proven for k in range(100)]
    assert seen[-1]
    assert seen == sorted(seen)  # once it has a way out, it keeps one
    assert flight.arrival(0) is not None
    gaps = [gap(one) for one in flight.flown(0).at(np.linspace(1.51, 11, 500)).position]
    assert min(gaps) > gap(np.array(place)) - 0.011
    assert min(gaps[-300:]) >= due - 1e-6


def test_a_uav_that_cannot_leave_but_through_a_wall_stays():
    room = [sky.Box(min=(8, 0, 0), max=(8.4, 10, 4)), sky.Box(min=(8.7, 0, 0), max=(9, 10, 4))]
    flight = sky.Replanner(sky.plan_mission(hall()))
    flight.observe(1.5, obstacles=room)
    flight.observe(1.5, states={0: ((8.55, 5, 1), (0, 0, 0))})
    for k in range(30):
        (replan,) = flight.observe(1.5 + k / 10)
        assert not replan.proven
    assert flight.motion(0).at([4.5]).position[0] == pytest.approx([8.55, 5, 1], abs=0.011)


def test_a_uav_that_is_found_too_fast_is_proven_only_if_it_can_brake_before_a_mover():
    ball = sky.Sighting(name="ball", shape=sky.Sphere(**BALL), position=(8, 5, 1), top_speed=0.001)
    outcomes = set()
    for speed in np.linspace(1, 12, 12):
        flight = started().replanner
        flight.observe(0.0, movers=[ball])
        (replan,) = flight.observe(0.1, movers=[ball], states={0: ((5, 5, 1), (speed, 0, 0))}, deadline_ms=0)
        outcomes.add(replan.proven)
        if replan.proven:
            assert {one.fault for one in faults(flight)} <= {sky.Fault.SPEED}
    assert outcomes == {True, False}


@given(SEQUENCES)
def test_the_same_observations_give_the_same_answers(sequence):
    def untimed(live):
        for answer, _, _ in steered(live, sequence):
            data = json.loads(answer.model_dump_json())
            for uav in data.get("uavs", []):
                del uav["milliseconds"]
            yield data

    assert list(untimed(started())) == list(untimed(started()))
