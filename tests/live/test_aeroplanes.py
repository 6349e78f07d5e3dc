"""Aeroplanes that are replanned keep flying, within their limits, and have a proven loiter at every instant."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from replanned import certified, faults, field, fly, observe, plane, whole_flight
from skyverse.model.mover_motions import motion_bounds

BALL = sky.Sphere(centre=(0, 0, 0), radius=10)
HOUSES = [sky.Box(min=(200, 100, 0), max=(260, 220, 120)), sky.Box(min=(380, 180, 0), max=(420, 330, 120))]


def replanner(scenario, **settings):
    return sky.Replanner(sky.plan_mission(scenario, assignment="identity"), **settings)


def test_an_aeroplane_flies_through_a_street_in_which_it_cannot_loiter():
    street = field(sky.Box(min=(100, 0, 0), max=(500, 170, 120)), sky.Box(min=(100, 230, 0), max=(500, 400, 120)))
    flight = replanner(street)
    answers = fly(flight, [], rate=5.0, top_speed=1.0)
    assert all(one.proven for (one,) in answers)
    assert flight.arrival(0) == pytest.approx(flight.mission.trajectories[0].end)


def among(scenario, *movers):
    return sky.Scenario(**{**dict(scenario), "movers": movers})


def random_field(seed):
    """A field with up to four houses whose mission has a trajectory, and movers in it."""
    rng = np.random.default_rng(seed)
    houses = []
    for _ in range(rng.integers(0, 5)):
        x, y = rng.uniform((120, 40), (440, 320))
        wide, long = rng.uniform(10, 50, 2)
        houses.append(sky.Box(min=(x, y, 0), max=(x + wide, y + long, float(rng.uniform(20, 120)))))
    scenario = field(*houses)
    mission = sky.plan_mission(scenario)
    scenario = scenario if not mission.violations else field()
    kind = ("spinners", "patrols", "knots", "traffic")[seed % 4]
    speed = float(rng.uniform(1, 6))
    return scenario, sky.random_movers(scenario, 4, kind=kind, speed=speed, radius=8, seed=seed).movers


@given(st.integers(0, 10_000))
def test_every_motion_that_is_said_to_be_proven_is_proven_by_the_referee(seed):
    scenario, truth = random_field(seed)
    bounds = [motion_bounds(one.motion) for one in truth]
    hardest = [one[1] for one in bounds]
    flight = replanner(scenario)

    def judged(answers):
        arrival = flight.arrival(0)
        if answers[0].proven and (arrival is None or flight.now < arrival):
            assert faults(flight) == []

    answers = fly(
        flight,
        truth,
        rate=1.0,
        seconds=50.0,
        top_speed=1.01 * max(one[0] for one in bounds),
        max_acceleration=None if None in hardest else 1.01 * max(hardest),
        reach=300.0,
        after=judged,
    )
    flown = flight.flown(0)
    if all(one.proven for (one,) in answers) and flight.arrival(0) is not None:
        whole = certified(flight, truth).trajectories[0]
        assert whole.verdict is sky.Verdict.PROVEN or "until" in whole.sentence, whole.sentence
    still = among(scenario)
    judged_alone = sky.certify(still, replace(flight.mission, scenario=still, trajectories=(flown,))).trajectories[0]
    assert judged_alone.verdict is sky.Verdict.PROVEN or "ends at" in judged_alone.sentence, judged_alone.sentence


def test_an_aeroplane_found_without_a_course_is_refused(refuses):
    flight = replanner(field())
    observe(flight, 0.0, 2.0)
    with refuses():
        flight.observe(2.0, states={0: ((100, 200, 40), (0, 0, 3))})


def test_aeroplanes_and_multirotors_keep_apart():
    multirotors = [sky.UAV(start=(300, 60, 40), separation=10), sky.UAV(start=(320, 330, 50), separation=10)]
    uavs = [plane(), plane(start=(560, 230, 40)), *multirotors]
    targets = [(560, 200, 40), (40, 230, 40), (300, 350, 40), (320, 80, 50)]
    scenario = field(uavs=uavs, targets=[sky.Target(position=one) for one in targets])
    flight = replanner(scenario)
    answers = fly(flight, [], rate=2.0, seconds=120.0, top_speed=1.0)
    assert None not in [flight.arrival(uav) for uav in range(4)]
    assert all(one.proven for answer in answers for one in answer)
    proof = certified(flight, [])
    assert {one.verdict for one in (*proof.trajectories, proof.apart)} == {sky.Verdict.PROVEN}


def test_aeroplanes_head_on_at_one_height_keep_apart():
    uavs = [plane(), plane(start=(560, 200, 30))]
    targets = [sky.Target(position=one) for one in ((560, 200, 30), (40, 200, 30))]
    mission = sky.plan_mission(field(uavs=uavs, targets=targets), assignment="identity")
    lone = [
        sky.plan_mission(field(uavs=[uav], targets=[target])).trajectories[0]
        for uav, target in zip(uavs, targets, strict=True)
    ]
    flight = sky.Replanner(replace(mission, trajectories=tuple(lone)))
    answers = fly(flight, [], rate=2.0, seconds=120.0, top_speed=1.0)
    assert all(one.proven for answer in answers[1:] for one in answer)
    assert None not in [flight.arrival(uav) for uav in range(2)]
    proof = certified(flight, [])
    assert {one.verdict for one in (*proof.trajectories, proof.apart)} == {sky.Verdict.PROVEN}


def test_multirotors_of_a_mixed_fleet_look_no_farther_ahead_at_movers_than_without_aeroplanes():
    multirotor = sky.UAV(start=(300, 60, 40))
    alone = replanner(field(uavs=[multirotor], targets=[sky.Target(position=(300, 350, 40))]))
    targets = [sky.Target(position=(560, 200, 40)), sky.Target(position=(300, 350, 40))]
    mixed = replanner(field(uavs=[plane(), multirotor], targets=targets))
    answers = [flight.observe(0.0)[-1] for flight in (alone, mixed)]
    assert answers[0].clear_until == answers[1].clear_until == alone.horizon < mixed.horizon


def test_an_aeroplane_that_nothing_is_observed_of_circles_on(refuses):
    flight = replanner(field(sky.Box(min=(330, 0, 0), max=(340, 400, 3))), horizon=5.0)
    flight.observe(0.0, obstacles=[sky.Box(min=(330, 0, 3), max=(340, 400, 120))])
    with refuses():
        flight.observe(199.9)
    (answer,) = flight.observe(200.0)
    assert answer.proven
    now = flight.motion(0).at([200.0])
    assert np.linalg.norm(now.velocity[0, :2]) == pytest.approx(15.0)
    assert faults(flight) == []
    flown = whole_flight(flight, flight.scenario)
    assert "ends at" in flown.sentence  # all else is right: it loiters where it is


def test_an_aeroplane_that_has_not_departed_waits_for_a_mover():
    mission = sky.plan_mission(field())
    (planned,) = mission.trajectories
    flight = sky.Replanner(replace(mission, trajectories=(planned.retimed(3.0),)))
    near = sky.Mover(
        name="ball", shape=BALL, motion=sky.WaypointMotion(points=[(90, 200, 30), (90, 380, 30)], times=[0, 60])
    )
    answers = fly(flight, [near], rate=2.0, top_speed=3.0, max_acceleration=0.0)
    assert all(one.proven for (one,) in answers[1:])
    assert certified(flight, [near]).trajectories[0].verdict is sky.Verdict.PROVEN


def test_where_nothing_is_proven_it_says_so_and_flies_on():
    flight = replanner(field())
    cloud = sky.Sighting(name="cloud", shape=BALL, position=(300, 200, 60), top_speed=200.0)
    answers = [flight.observe(k / 2, movers=[cloud])[0] for k in range(10)]
    assert not any(one.proven for one in answers)
    assert (
        "uav-1 has no way out that was found among 128 motions: mover 'cloud' may come too near at t = "
        in answers[0].sentence
    )
    flown = whole_flight(flight, flight.scenario)
    assert flown.verdict is sky.Verdict.PROVEN or "ends at" in flown.sentence
