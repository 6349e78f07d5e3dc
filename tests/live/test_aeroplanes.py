"""Aeroplanes that are replanned keep flying, within their limits, and have a proven loiter at every instant."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from replanned import certified, faults, field, fly, plane
from skyverse.model.mover_motions import motion_bounds

BALL = sky.Sphere(centre=(0, 0, 0), radius=10)
HOUSES = [sky.Box(min=(200, 100, 0), max=(260, 220, 120)), sky.Box(min=(380, 180, 0), max=(420, 330, 120))]
CROSSING = sky.Mover(
    name="ball", shape=BALL, motion=sky.WaypointMotion(points=[(300, 20, 46), (300, 380, 46)], times=[0, 36])
)


def replanner(scenario, **settings):
    return sky.Replanner(sky.plan_mission(scenario, assignment="identity"), **settings)


def observe(flight, since, until, rate=5.0, **given):
    """Observe until the UAVs have arrived; what is given is observed first. Return all answers."""
    answers = []
    for k in range(round(rate * since), round(rate * until)):
        answers += flight.observe(k / rate, **(given if not answers else {}))
        arrivals = [flight.arrival(uav) for uav in range(len(flight.scenario.uavs))]
        if None not in arrivals and max(arrivals) <= k / rate:
            break
    return answers


def whole_flight(flight, scenario):
    """What the referee proves of all that was flown in a scenario."""
    mission = replace(flight.mission, scenario=scenario, trajectories=(flight.flown(0),))
    return sky.certify(scenario, mission).trajectories[0]


@pytest.mark.parametrize("scenario", [field(), field(*HOUSES), field(size=(600, 240, 120))])
def test_an_aeroplane_that_meets_nothing_flies_the_mission(scenario):
    flight = replanner(scenario)
    answers = fly(flight, [], rate=5.0, top_speed=1.0)
    assert all(one.proven for (one,) in answers)
    (planned,) = flight.mission.trajectories
    assert flight.arrival(0) == pytest.approx(planned.end)
    t = np.linspace(0.0, planned.end, 500)
    np.testing.assert_allclose(flight.flown(0).at(t).position, planned.at(t).position, atol=1e-6)
    np.testing.assert_allclose(flight.flown(0).at(t).velocity, planned.at(t).velocity, atol=1e-6)


def test_an_aeroplane_flies_through_a_street_in_which_it_cannot_loiter():
    street = field(sky.Box(min=(100, 0, 0), max=(500, 170, 120)), sky.Box(min=(100, 230, 0), max=(500, 400, 120)))
    flight = replanner(street)
    answers = fly(flight, [], rate=5.0, top_speed=1.0)
    assert all(one.proven for (one,) in answers)
    assert flight.arrival(0) == pytest.approx(flight.mission.trajectories[0].end)


@pytest.mark.parametrize("obstacles", [(), HOUSES], ids=["alone", "houses"])
def test_an_aeroplane_lets_a_ball_pass_and_is_proven(obstacles):
    flight = replanner(field(*obstacles))
    answers = fly(flight, [CROSSING], rate=5.0, top_speed=11.0, max_acceleration=0.05)
    assert all(one.proven for (one,) in answers)
    assert certified(flight, [CROSSING]).trajectories[0].verdict is sky.Verdict.PROVEN
    scenario = among(flight.mission.scenario, CROSSING)
    as_planned = sky.certify(scenario, replace(flight.mission, scenario=scenario))
    assert as_planned.trajectories[0].verdict is sky.Verdict.REFUTED


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


@pytest.mark.slow
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


def test_an_aeroplane_flies_round_a_wall_that_it_comes_to_know_in_flight():
    wall = sky.Box(min=(330, 60, 0), max=(340, 300, 120))
    flight = replanner(field())
    observe(flight, 0.0, 5.0)
    answers = observe(flight, 5.0, 90.0, obstacles=[wall])
    assert all(one.proven for one in answers)
    assert flight.arrival(0) is not None
    assert whole_flight(flight, field(wall)).verdict is sky.Verdict.PROVEN


def test_an_aeroplane_that_a_new_wall_closes_off_loiters_before_it():
    wall = sky.Box(min=(330, 0, 0), max=(340, 400, 120))
    flight = replanner(field())
    observe(flight, 0.0, 5.0)
    answers = observe(flight, 5.0, 60.0, rate=2.0, obstacles=[wall])
    assert all(one.proven and "can loiter" in one.sentence for one in answers)
    assert flight.arrival(0) is None
    assert flight.flown(0).at(np.linspace(0, 60, 600)).position[:, 0].max() < 330 - 3


def test_an_aeroplane_goes_round_a_restriction_that_it_comes_to_know_in_flight():
    shut = sky.Box(min=(280, 140, 0), max=(340, 260, 120), active=[(0.0, 300.0)])
    flight = replanner(field())
    observe(flight, 0.0, 2.0)
    answers = observe(flight, 2.0, 90.0, zones=[shut])
    assert all(one.proven for one in answers)
    assert flight.arrival(0) is not None
    assert whole_flight(flight, field(zones=(shut,))).verdict is sky.Verdict.PROVEN


def test_an_aeroplane_flies_to_another_target_also_when_it_has_arrived():
    flight = replanner(field())
    observe(flight, 0.0, 10.0)
    answers = observe(flight, 10.0, 60.0, targets={0: (300, 340, 40)})
    assert all(one.proven for one in answers)
    assert whole_flight(flight, flight.scenario).verdict is sky.Verdict.PROVEN
    first, now = flight.arrival(0), flight.now + 1.0
    assert flight.flown(0).at([first]).position[0] == pytest.approx((300, 340, 40))
    answers = observe(flight, now, 150.0, targets={0: (100, 100, 60)})
    assert all(one.proven for one in answers)
    assert first < flight.arrival(0)
    assert flight.flown(0).at([flight.arrival(0)]).position[0] == pytest.approx((100, 100, 60))


def test_a_target_that_no_path_leads_to_is_refused_and_changes_nothing():
    flight = replanner(field(*HOUSES))
    observe(flight, 0.0, 2.0)
    before = flight.now, flight.motion(0), flight.scenario
    with pytest.raises(sky.InputError, match=r"targets\[0\]: no path leads there from .*, where uav-1 can turn"):
        flight.observe(3.0, targets={0: (230, 150, 60)})
    assert (flight.now, flight.motion(0), flight.scenario) == before


def test_an_aeroplane_that_was_blown_off_its_course_goes_on_from_where_it_is():
    flight = replanner(field())
    observe(flight, 0.0, 8.0)
    place, velocity, _ = (part[0] for part in flight.motion(0).at([8.0]))
    blown, turned = place + np.array([0.0, 12.0, 4.0]), np.array([velocity[1], velocity[0], 0.0])
    (answer,) = flight.observe(8.0, states={0: (blown, turned)})
    assert answer.proven
    at = flight.motion(0).at([8.0])
    assert at.position[0] == pytest.approx(blown)
    assert at.velocity[0] == pytest.approx(turned, abs=1e-8)
    assert faults(flight) == []
    assert all(one.proven for one in observe(flight, 8.2, 90.0))
    assert flight.arrival(0) is not None


def test_an_aeroplane_found_without_a_course_is_refused():
    flight = replanner(field())
    observe(flight, 0.0, 2.0)
    with pytest.raises(sky.InputError, match=r"states\[0\]: expected the velocity of an aeroplane"):
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


def test_an_aeroplane_that_nothing_is_observed_of_circles_on():
    flight = replanner(field(sky.Box(min=(330, 0, 0), max=(340, 400, 3))), horizon=5.0)
    flight.observe(0.0, obstacles=[sky.Box(min=(330, 0, 3), max=(340, 400, 120))])
    with pytest.raises(sky.InputError, match="the clock went ahead"):
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


def test_the_same_observations_give_the_same_motions():
    flights = [replanner(field(*HOUSES)) for _ in range(2)]
    for flight in flights:
        fly(flight, [CROSSING], rate=2.0, top_speed=11.0, max_acceleration=0.05, seconds=15.0)
    assert flights[0].flown(0) == flights[1].flown(0)


def test_a_deadline_of_0_leaves_the_present_motion():
    flight = replanner(field())
    observe(flight, 0.0, 1.0)
    (answer,) = flight.observe(1.0, deadline_ms=0.0)
    assert answer.proven
    assert answer.kept
    assert answer.tried == 0
