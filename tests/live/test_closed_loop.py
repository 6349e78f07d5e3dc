"""Sensors see what is within their range, late and inexactly as they are; flights among that are proven."""

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, certified, hall
from skyverse.live import FleetSensors, out_of_reach, seen_movers

CROSSING = sky.Mover(
    name="cart", shape=BALL, motion=sky.WaypointMotion(points=[(10, 0, 1), (10, 10, 1)], times=[0, 20], then="returns")
)
WALL = sky.Box(min=(10, 2, 0), max=(10.5, 8, 4))


def among(scenario, **more):
    return sky.Scenario(**{**dict(scenario), **more})


def test_movers_are_seen_within_range_only():
    places = np.array([(10.0, 3.0 + BALL.radius, 1.0)])
    rng = np.random.default_rng(0)
    assert [one.name for one in seen_movers(sky.Sensor(range=3.01), [CROSSING], 0.0, places, rng)] == ["cart"]
    assert seen_movers(sky.Sensor(range=2.99), [CROSSING], 0.0, places, rng) == []


def test_a_mover_is_seen_by_its_surface():
    train = sky.Mover(
        shape=sky.Box(min=(0, -1, -1), max=(50, 1, 1)), motion=sky.WaypointMotion(points=[(0, 0, 0)], times=[0])
    )
    rng, beside = np.random.default_rng(0), np.array([(45.0, 4.0, 0.0)])
    assert seen_movers(sky.Sensor(range=3.01), [train], 0.0, beside, rng)
    assert not seen_movers(sky.Sensor(range=2.99), [train], 0.0, beside, rng)
    ball = sky.Mover(shape=sky.Sphere(centre=(5, 0, 0), radius=1), motion=train.motion)
    assert seen_movers(sky.Sensor(range=3.01), [ball], 0.0, np.array([(5.0, 4.0, 0.0)]), rng)
    assert not seen_movers(sky.Sensor(range=2.99), [ball], 0.0, np.array([(5.0, 4.0, 0.0)]), rng)


def test_errors_fill_a_ball_and_never_leave_it():
    sensor, rng, places = sky.Sensor(error=0.2), np.random.default_rng(1), np.zeros((1, 3))
    off = [np.array(seen_movers(sensor, [CROSSING], 0.0, places, rng)[0].position) - (10, 0, 1) for _ in range(500)]
    sizes = np.linalg.norm(off, axis=1)
    assert 0.19 < sizes.max() <= 0.2
    assert np.abs(np.mean(off, axis=0)).max() < 0.02


@pytest.mark.parametrize("range", [3.0, 6.0, 9.0])
def test_a_mover_out_of_reach_cannot_meet_a_uav_and_a_nearer_one_could(range):
    scenario, seconds, sensor = hall(), 1.5, sky.Sensor(range=range)
    speed, rng = scenario.uavs[0].max_speed, np.random.default_rng(0)
    stands = sky.WaypointMotion(points=[(10, 0, 1)], times=[0])
    for top_speed in rng.uniform(0.1, 5.0, 200):
        doubts = {"turns at once": sky.Doubt(growth=top_speed), "turns": sky.Doubt(acceleration=1, top_speed=top_speed)}
        held = [sky.Mover(name=name, shape=BALL, motion=stands, doubt=doubt) for name, doubt in doubts.items()]
        gap = range - seconds * (speed + top_speed)  # of a UAV and a mover that fly towards each other
        expected = [] if gap < scenario.clearance else [*doubts]
        assert out_of_reach(sensor, scenario, held, [], seconds) == expected or abs(gap - scenario.clearance) < 1e-4
        seen = seen_movers(sky.Sensor(), held[:1], 0.0, np.zeros((1, 3)), rng)
        assert out_of_reach(sky.Sensor(), scenario, held, seen, seconds) == ["turns"]


def test_a_mover_that_has_left_the_range_is_in_no_ones_way():
    mission, answers = sky.plan_mission(hall(uavs=[sky.UAV(start=(1, 5, 1), max_speed=1.0)])), []
    leaves = sky.WaypointMotion(points=[(4, 9, 1), (60, 9, 1)], times=[0, 28])
    truth = among(mission.scenario, movers=[sky.Mover(name="fast", shape=BALL, motion=leaves)])
    replanner = sky.Replanner(mission)
    assert sky.fly_closed_loop(replanner, truth, sky.Sensor(range=6.0), longest=40.0, on_answers=answers.extend)
    assert all(answer.proven for answer in answers)
    assert not any(answer.forgotten for answer in answers)
    assert replanner.predicted() == ()
    assert replanner.now < mission.makespan + 0.2


def test_a_hidden_obstacle_is_seen_once():
    flight, rng = sky.Replanner(sky.plan_mission(hall())), np.random.default_rng(0)
    sensors = FleetSensors(flight, among(hall(), obstacles=[WALL]), sky.Sensor(range=2.0, delay=0.05), rng)
    for t, x in ((0.0, 7.9), (0.1, 8.1), (0.2, 8.1)):
        sensors.look(t, np.array([(x, 5.0, 1.0)]), {})
    assert sensors.next_arrival == 0.05
    assert [one.obstacles for one in sensors.arrived(0.2)] == [(), (WALL,)]
    assert [one.obstacles for one in sensors.arrived(0.25)] == [()]


@pytest.mark.parametrize("delay", [0.0, 0.05])
def test_a_flight_past_an_unknown_wall_and_a_mover_is_proven(delay):
    mission = sky.plan_mission(hall())
    replanner, answers = sky.Replanner(mission), []
    truth = among(mission.scenario, movers=[CROSSING], obstacles=[WALL])
    sensor = sky.Sensor(range=6.0, delay=delay, error=0.02)
    assert sky.fly_closed_loop(replanner, truth, sensor, longest=60.0, rng=3, on_answers=answers.append)
    assert replanner.scenario.obstacles == (WALL,)
    proven = certified(replanner, [CROSSING], obstacles=[WALL])
    assert [one.verdict for one in proven.trajectories] == [sky.Verdict.PROVEN]
    assert all(answer.proven for (answer,) in answers)


@pytest.mark.parametrize(
    "given",
    [
        {"sensor": sky.Sensor(delay=0.2)},
        {"sensor": None},
        {"truth": None},
        *({"longest": seconds} for seconds in (0, -1.0, float("inf"), float("nan"), "x")),
    ],
)
def test_what_cannot_be_is_refused(given, refuses):
    flight = sky.Replanner(sky.plan_mission(hall()))
    with refuses():
        sky.fly_closed_loop(flight, **{"truth": hall(), "sensor": sky.Sensor(), "longest": 1.0, **given})
