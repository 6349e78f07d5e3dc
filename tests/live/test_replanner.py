"""Flights that are replanned keep clear of what moves, and have a proven way out at every instant."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from replanned import BALL, certified, faults, fly, hall, observe, whole_flight
from skyverse.model.mover_motions import motion_bounds


def replanner(scenario, **settings):
    return sky.Replanner(sky.plan_mission(scenario), **settings)


PILLARS = [sky.Cylinder(centre=(x, 5 + 0.3 * (-1) ** x), radius=0.5, low=0, high=4) for x in (5, 8, 11, 14)]


@settings(max_examples=20)
@given(st.integers(0, 10_000), st.sampled_from(["spinners", "patrols", "knots", "traffic"]), st.floats(0.3, 1.0))
def test_motions_and_whole_flights_are_clear_of_movers_that_keep_within_the_doubt(seed, kind, speed):
    scenario = hall()
    truth = sky.random_movers(scenario, 4, kind=kind, speed=speed, seed=seed).movers
    fastest, hardest = zip(*(motion_bounds(one.motion) for one in truth), strict=True)
    hardest = None if None in hardest else 1.01 * max(hardest)  # some turn back in an instant
    flight = replanner(scenario)

    def judged(answers):
        assert not answers[0].proven or flight.now > 3.0 or faults(flight) == []

    answers = fly(
        flight, truth, top_speed=1.01 * max(fastest), max_acceleration=hardest, reach=8.0, seconds=30.0, after=judged
    )
    if all(one.proven for (one,) in answers):
        whole = certified(flight, truth).trajectories[0]
        assert whole.verdict is sky.Verdict.PROVEN or flight.arrival(0) is None, whole.sentence


def test_uavs_keep_their_separation_from_each_other():
    scenario = sky.circle_swap(4, radius=6.0)
    flight = sky.Replanner(sky.plan_mission(scenario, assignment="identity"))
    answers = fly(flight, [], top_speed=1.0)
    assert all(one.proven for answer in answers for one in answer)
    proof = certified(flight, [])
    assert {one.verdict for one in (*proof.trajectories, proof.apart)} == {sky.Verdict.PROVEN}


def test_uavs_that_wait_for_each_other_try_another_way_after_a_while():
    trunks = [
        sky.Cylinder(centre=(5.104, 5.9486), radius=0.2157, low=0, high=3),
        sky.Cylinder(centre=(3.6246, 4.5221), radius=0.2866, low=0, high=3),
    ]
    starts, ends = [(4.5125, 5.38979, 1.47671), (4.91141, 5.46292, 1.49952)], [(9.5, 5, 1.5), (0.5, 2.75, 1.5)]
    scenario = hall(
        *trunks,
        clearance=0.1,
        size=(10, 10, 3),
        uavs=[sky.UAV(start=place, max_speed=1.0, separation=0.4) for place in starts],
        targets=[sky.Target(position=place) for place in ends],
    )
    flight = sky.Replanner(
        sky.plan_mission(scenario, assignment="identity", options=sky.MissionOptions(keep_apart=False))
    )
    answers = fly(flight, [], top_speed=1.0)
    assert all(one.proven for answer in answers for one in answer)
    assert None not in [flight.arrival(0), flight.arrival(1)]
    proof = certified(flight, [])
    assert {one.verdict for one in (*proof.trajectories, proof.apart)} == {sky.Verdict.PROVEN}


def test_what_is_proven_stays_true_where_another_uav_flies_what_is_not():
    apart = (10, 5, 2.0), (11.6, 5, 2.0)
    scenario = hall(
        size=(20, 10, 6),
        uavs=[sky.UAV(start=place, priority=1 - k, separation=1.0) for k, place in enumerate(apart)],
        targets=[sky.Target(position=place) for place in apart],
    )
    mission = sky.plan_mission(scenario, assignment="identity")
    mixed = 0
    for near, speed in ((0.9, 1.0), (1.2, 2.0), (1.6, 2.0), (2.0, 4.0), (2.5, 4.0)):
        flight = sky.Replanner(mission)
        flight.observe(0.0)
        shape = sky.Sphere(centre=(0, 0, 0), radius=0.6)
        ball = seen(11.6 + near, shape=shape, velocity=(-speed, 0, 0), top_speed=speed, max_acceleration=0.2)
        answers = flight.observe(0.1, movers=[ball.model_copy(update={"position": (11.6 + near, 5, 2)})])
        mixed += {one.proven for one in answers} == {True, False}
        t = np.linspace(0.1, 0.1 + flight.horizon, 2000)
        first, second = (flight.motion(uav).at(t).position for uav in (0, 1))
        off = first - second
        assert (np.hypot(off[:, 0], off[:, 1]) ** 2 + (off[:, 2] / 2.0) ** 2).min() >= 1.0 - 1e-6 or not any(
            one.proven for one in answers
        )
    assert mixed


def test_a_uav_that_was_found_far_too_fast_is_not_stepped_over():
    places = (10, 5, 2.0), (2, 5, 2.0)
    scenario = hall(
        size=(200, 10, 6),
        uavs=[sky.UAV(start=place, separation=0.3, max_speed=1.0, max_acceleration=2.0) for place in places],
        targets=[sky.Target(position=place) for place in places],
    )
    mission = sky.plan_mission(scenario, assignment="identity")
    for speed in (6.0, 12.0, 30.0):
        flight = sky.Replanner(mission, horizon=5.0)
        flight.observe(0.1)
        answers = flight.observe(0.2, states={1: ((6.0, 5, 2), (speed, 0, 0))})
        t = np.linspace(0.2, 5.2, 20_001)
        first, second = (flight.motion(uav).at(t).position for uav in (0, 1))
        assert np.linalg.norm(first - second, axis=1).min() >= 0.3 - 1e-6 or not answers[0].proven


def test_a_motion_that_ends_where_the_next_one_begins_but_for_rounding_is_whole():
    flight = replanner(hall(size=(40, 10, 4), targets=[sky.Target(position=(39, 5, 1))]))
    flight.observe(0.0)
    end = flight.motion(0).end
    flight.observe(end - flight.lead + 5e-12)
    motion = flight.motion(0)
    assert len(motion.knots) == len(motion.coefficients) + 1
    t = np.linspace(motion.start, motion.end, 20_001)
    assert np.linalg.norm(np.diff(motion.at(t).position, axis=0), axis=1).max() <= 5.0 * (t[1] - t[0]) + 1e-9


def test_a_uav_inside_a_new_slow_zone_brakes_to_its_limit():
    flight = replanner(hall(size=(80, 10, 4), targets=[sky.Target(position=(79, 5, 1))]))
    slow = sky.Box(min=(0, 0, 0), max=(60, 10, 4), max_speed=1.0)
    for k in range(80):
        (answer,) = flight.observe(k / 10, zones=[slow] if k == 40 else [])
        if k == 40:
            assert not answer.proven
            assert "slow enough in zones" in answer.sentence
    assert answer.proven
    assert np.linalg.norm(flight.motion(0).at([7.9]).velocity[0]) <= 1.0 + 1e-6


def test_what_is_seen_again_is_not_added_again():
    flight = replanner(hall(*PILLARS))
    wall = sky.Box(min=(12, 2, 0), max=(12.5, 4, 4))
    zone = sky.Box(min=(15, 0, 0), max=(16, 10, 4), max_speed=1.0)
    for k in range(5):
        flight.observe(k / 10, obstacles=[wall, PILLARS[0]], zones=[zone])
    assert flight.scenario.obstacles == (*PILLARS, wall)
    assert flight.scenario.zones == (zone,)


@pytest.mark.parametrize(
    ("observed", "now"),
    [
        *(([0.1, wrong, *(k / 10 for k in range(2, 30))], 2.9) for wrong in (5.2, 30.0, 590.0, 1e5)),
        *(([1.0, 1.0 + gap, 1.0 + 2 * gap], 1.0 + 2 * gap) for gap in (6.0, 40.0)),
    ],
)
def test_one_wrong_clock_costs_one_observation_and_a_long_silence_no_more(observed, now, refuses):
    flight = replanner(hall())
    first, leapt, *rest = observed
    flight.observe(first)
    with refuses():
        flight.observe(leapt)
    for t in rest:
        flight.observe(t)
    assert flight.now == now


@settings(max_examples=30)
@given(st.lists(st.tuples(st.integers(1, 4), st.floats(5.2, 1e5)), min_size=2, max_size=6))
def test_wrong_clocks_cost_one_observation_each_however_they_agree_if_right_ones_lie_between(turns):
    flight, t = replanner(hall()), 0.0
    for right, ahead in turns:
        for _ in range(right):
            t += 0.1
            flight.observe(t)
        with pytest.raises(sky.InputError, match="went ahead"):
            flight.observe(t + ahead)
    assert flight.now == t


def test_a_uav_rests_near_a_target_that_a_mover_keeps_it_from():
    there = sky.Mover(
        name="guard",
        shape=BALL,
        motion=sky.WaypointMotion(points=[(18.5, 3.2, 1), (18.5, 3.8, 1)], times=[0, 1], then="returns"),
    )
    flight = replanner(hall())
    answers = fly(flight, [there], top_speed=0.6, seconds=30.0)
    assert all(one.proven for (one,) in answers)
    velocities = flight.flown(0).at(np.linspace(15.0, 29.0, 1000)).velocity
    assert np.linalg.norm(velocities, axis=1).mean() < 0.05
    assert np.linalg.norm(flight.motion(0).at([29.0]).position[0] - (19, 5, 1)) < 3.0


def seen(x, y=5.0, **more):
    return sky.Sighting(**{"name": "ball", "shape": BALL, "position": (x, y, 1), "top_speed": 2.0, **more})


def told_state(flight):
    """All that an observation could change."""
    return flight.now, flight.predicted(), flight.motion(0), flight.scenario


SPHERE = {"shape": "sphere", "centre": (0, 0, 0)}
REFUSED = [
    *({"t": t} for t in (float("nan"), -1.0, True, 0.0)),
    {"movers": [{"name": "ball", "position": [1, 2, float("nan")]}]},
    *(
        {"movers": [{**dict(seen(8)), **more}]}
        for more in (
            {"position": [1, 2, float("nan")]},
            {"position": (1, 2, 1e7)},
            {"velocity": (0, 0, -1e7)},
            {"velocity": [3.0, 0, 0]},
            {"error": 1e300},
            {"max_acceleration": 1e300},
            {"shape": {**SPHERE, "radius": 1e12}},
            {"shape": {**SPHERE, "radius": 1e-300}},
            {"speed": 2.0},
        )
    ),
    {"movers": [seen(8), seen(9)]},
    *({"states": {0: state}} for state in (((1e7, 0, 0), (0, 0, 0)), ((0, 0, 0), (0, 1e4, 0)), (0, 0))),
    {"states": {0: ((0, 0, float("nan")), (0, 0, 0))}},
    {"states": {3: ((0, 0, 0), (0, 0, 0))}},
    {"states": {0.0: ((1, 1, 1), (0, 0, 0))}},
    {"states": 5},
    {"targets": [(1, 1, 1)]},
    *({"targets": {0: place}} for place in ((12, 1, float("nan")), (12, 1), (30, 5, 1))),
    {"targets": {1: (12, 1, 1)}},
    {"targets": {0: (5, 4.7, 1)}, "obstacles": [PILLARS[0]]},
    {"obstacles": [{"min": (0, 0, 0), "max": (1, 1, -1)}]},
    *({"deadline_ms": value} for value in (-1.0, "soon")),
]


@pytest.mark.parametrize("given", REFUSED)
def test_what_cannot_be_is_refused_in_one_sentence_and_changes_nothing(given, refuses):
    flight = replanner(hall())
    flight.observe(5.0, movers=[seen(8)])
    before = told_state(flight)
    with refuses():
        flight.observe(**{"t": 6.0, **given})
    assert told_state(flight) == before


@pytest.mark.parametrize(
    "given",
    [
        *(
            {field: value}
            for field in ("horizon", "lead", "memory", "candidates")
            for value in (float("nan"), True, "a")
        ),
        {"horizon": 601.0},
        *({"mission": one} for one in ("mission.json", None, sky.read("map1"))),
    ],
)
def test_settings_that_cannot_be_are_refused(given, refuses):
    with refuses():
        sky.Replanner(**{"mission": sky.plan_mission(hall()), **given})


def test_sightings_that_come_late_or_twice_are_taken_in():
    one, other = replanner(hall()), replanner(hall())
    for t, x in ((0.0, 8.0), (0.1, 7.9), (0.2, 7.8)):
        one.observe(t, movers=[seen(x, max_acceleration=0.1)])
    other.observe(0.0)
    other.observe(0.2, movers=[seen(7.8, max_acceleration=0.1)])
    for _ in range(2):
        other.observe(0.1, movers=[seen(7.9, max_acceleration=0.1)])
        other.observe(0.0, movers=[seen(8.0, max_acceleration=0.1)])
    assert other.now == 0.2
    assert other.predicted() == one.predicted()


def test_a_uav_that_sees_nothing_for_seconds_waits_where_it_has_a_way_out():
    flight = replanner(hall(), memory=10.0)
    flight.observe(0.0, movers=[seen(12.0)])
    flight.observe(0.1, movers=[seen(12.0)])
    (answer,) = flight.observe(4.0)  # the ball may be anywhere within 8 m of where it was
    end = flight.motion(0).at([flight.motion(0).end])
    assert np.linalg.norm(end.velocity) < 1e-9
    assert answer.proven == (not faults(flight))


def test_a_mover_on_top_of_a_uav_is_told_and_left_behind():
    flight = replanner(hall())
    (answer,) = flight.observe(0.0, movers=[seen(1.2, top_speed=0.1, max_acceleration=0.0, velocity=(0, 0, 0))])
    assert not answer.proven
    assert answer.clear_until == 0.0
    assert "mover 'ball' may come too near at t = 0 s" in answer.sentence
    for k in range(1, 40):
        (answer,) = flight.observe(k / 10, movers=[seen(1.2, max_acceleration=0.0, velocity=(0, 0, 0))])
    assert answer.proven
    assert np.linalg.norm(flight.motion(0).at([3.9]).position[0] - [1.2, 5, 1]) > 0.6


def test_a_mover_that_jumps_is_taken_as_another_one():
    flight = replanner(hall())
    for k in range(5):
        flight.observe(k / 10, movers=[seen(15.0 - 0.1 * k, max_acceleration=0.1)])
    flight.observe(0.5, movers=[seen(5.0, max_acceleration=0.1)])
    (ball,) = flight.predicted()
    assert ball.doubt.growth == 2.0
    assert ball.at([0.5])[0].tolist() == [5, 5, 1]


def test_a_uav_without_a_target_gets_one():
    uavs = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(1, 8, 1))]
    flight = sky.Replanner(sky.plan_mission(hall(uavs=uavs)))
    idle = flight.mission.assignment.index(None)
    for k in range(150):
        flight.observe(k / 10, targets={idle: (19, 2, 2)} if k == 5 else None)
    assert flight.motion(idle).at([15.0]).position[0] == pytest.approx((19, 2, 2))


@pytest.mark.parametrize("bearing", np.linspace(-0.4, 0.4, 5))
def test_a_uav_at_rest_is_not_flown_into_a_ball_that_appears_too_near_before_it(bearing):
    flight = replanner(
        hall(uavs=[sky.UAV(start=(1, 5, 2), max_speed=2.0)], targets=[sky.Target(position=(1.001, 5, 2))])
    )
    flight.observe(5.0)
    flight.observe(5.1, targets={0: (18, 5, 2)})
    place = flight.motion(0).at([5.1]).position[0]
    at = place + 0.41 * np.array([np.cos(bearing), np.sin(bearing), 0.0])
    ball = sky.Sphere(centre=(0, 0, 0), radius=0.3)
    still = {"velocity": (0.0, 0.0, 0.0), "top_speed": 0.1, "max_acceleration": 0.1}
    for k in range(20):
        t = 5.1 + 0.1 * k
        flight.observe(t, movers=[sky.Sighting(name="b", shape=ball, position=tuple(at), **still)])
        flown = flight.motion(0).at(np.linspace(t, t + 0.1, 21)).position
        assert np.linalg.norm(flown - at, axis=1).min() > 0.38


@pytest.mark.parametrize("uav", [1, -1, 0.0, None, "0"])
def test_a_uav_that_is_not_there_is_refused(uav, refuses):
    flight = replanner(hall())
    for asked in (flight.motion, flight.flown, flight.arrival):
        with refuses():
            asked(uav)


@pytest.mark.parametrize("field", ["movers", "obstacles", "zones", "gone"])
@pytest.mark.parametrize("given", [None, 5, "ball", {"name": "ball"}, [None], [5], [["ball"]], ["bal"], iter([])])
def test_what_was_seen_comes_in_lists(field, given):
    flight = replanner(hall())
    ball = sky.Sighting(name="ball", shape=BALL, position=(9, 9, 1), top_speed=1.0)
    flight.observe(0.1, movers=[ball])
    before = told_state(flight)
    with pytest.raises(sky.InputError) as refused:
        flight.observe(0.2, **{field: given})
    assert refused.value.sentence.field.partition("[")[0] == field
    assert told_state(flight) == before
    assert [one.name for one in flight.predicted()] == ["ball"]


@pytest.mark.parametrize(
    ("since", "slow", "target", "least"),
    [
        (0.0, (9, 11, 1.0), None, 6.5),  # 2 m at 1 m/s, and 16 m at 5 m/s
        (0.5, (9, 11, 1.0), None, 6.5),
        (0.1, (2, 4, 0.5), (5, 8, 2), 4.0),
    ],
)
def test_a_uav_keeps_a_zones_speed_limit(since, slow, target, least):
    low, high, limit = slow
    zone = sky.Box(min=(low, 0, 0), max=(high, 10, 4), max_speed=limit)
    flight = replanner(sky.Scenario(**{**dict(hall()), "zones": () if since else (zone,)}))
    answers = observe(flight, 0.0, since)
    answers += observe(flight, since, zones=[zone], targets={} if target is None else {0: target})
    assert all(one.proven for one in answers)
    assert whole_flight(flight, flight.scenario).verdict is sky.Verdict.PROVEN
    assert least < flight.arrival(0) < 10.0


def test_a_uav_inside_a_new_obstacle_leaves_it():
    crate = sky.Box(min=(0, 4, 0), max=(2.5, 6, 4))
    flight = replanner(hall())
    (answer,) = flight.observe(0.0, obstacles=[crate])
    assert not answer.proven
    assert "a new obstacle may come too near at t = 0 s" in answer.sentence
    assert flight.scenario.obstacles == ()
    answers = observe(flight, 0.1)
    assert answers[-1].proven
    assert flight.arrival(0) is not None
    assert flight.scenario.obstacles == (crate,)
