"""Replanned motions say where the nose points: smoothly, within the UAV's limits, and never otherwise later."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, field, fly, hall
from skyverse.model.trajectory import wrapped
from skyverse.referee.limits import judge_heading

SLOW = {"max_yaw_rate": 20.0, "max_yaw_acceleration": 30.0}
BENT = (sky.Box(min=(7, 0, 0), max=(8, 7, 4)), sky.Box(min=(13, 3, 0), max=(14, 10, 4)))


def flight(*obstacles, **uav):
    return sky.Replanner(sky.plan_mission(hall(*obstacles, uavs=[sky.UAV(start=(1, 5, 1), **uav)])))


def crowd(seed):
    """Eight balls that cross the hall to and fro."""
    rng = np.random.default_rng(seed)
    lanes = zip(rng.uniform(4, 17, 8), rng.uniform(4, 9, 8), strict=True)
    return [
        sky.Mover(name=f"ball-{k}", shape=BALL, motion=to_and_fro(x, -2.0 * k, seconds))
        for k, (x, seconds) in enumerate(lanes)
    ]


def to_and_fro(x, begin, seconds):
    return sky.WaypointMotion(points=[(x, 0.5, 1), (x, 9.5, 1)], times=[begin, begin + seconds], then="returns")


def bearings(flown, t, uav):
    """Where the nose is to point, and at which instants that is anywhere."""
    position, velocity, _ = flown.at(t)
    way = velocity if uav.look_at is None else np.array(uav.look_at) - position
    return np.arctan2(way[:, 1], way[:, 0]), np.hypot(way[:, 0], way[:, 1]) > (0.1 if uav.look_at is None else 0.5)


@pytest.mark.parametrize(
    ("limits", "seed"), [({}, 0), (SLOW, 1), ({"look_at": (10.0, 12.0, 0.0)}, 2), ({"max_yaw_rate": 300.0}, 3)]
)
def test_noses_turn_smoothly_within_their_limits_and_their_past_stays(limits, seed):
    flying, told = flight(**limits), []

    def keep(_):
        told.append((flying.now + flying.lead, flying.flown(0), flying.motion(0)))

    answers = fly(flying, crowd(seed), seconds=8.0, top_speed=3.0, reach=6.0, after=keep)
    assert sum(not answer.kept for (answer,) in answers) > 10  # much was flown anew
    whole, uav = flying.flown(0), flying.scenario.uavs[0]
    for join, before, motion in told[::4]:
        past = np.linspace(0.0, join, 100)
        assert np.array_equal(whole.heading(past).yaw, before.heading(past).yaw)
        assert np.array_equal(whole.heading(past).yaw_rate, before.heading(past).yaw_rate)
        ahead = np.linspace(motion.start, motion.end, 50)
        np.testing.assert_allclose(motion.heading(ahead).yaw, before.heading(ahead).yaw, rtol=0, atol=1e-9)
    t = np.linspace(0.0, whole.end + 2.0, 30_001)
    yaw, rate, _ = np.degrees(whole.heading(t))
    step = t[1]
    assert np.abs(rate).max() <= uav.max_yaw_rate * (1 + 1e-9)
    assert np.abs(np.diff(rate)).max() <= uav.max_yaw_acceleration * step * (1 + 1e-6) + 1e-6
    assert np.abs(np.diff(yaw) - 0.5 * (rate[1:] + rate[:-1]) * step).max() < 1e-3
    assert np.abs(rate).max() > 0.1 * min(uav.max_yaw_rate, 90.0)  # it has turned at all
    assert list(judge_heading(uav, 0, whole.pointing)) == []


@pytest.mark.parametrize("look_at", [None, (10.0, 14.0, 0.0)])
def test_a_nose_that_may_turn_fast_points_where_it_is_to(look_at):
    off = []
    for seed in range(3):
        flying = flight(max_yaw_rate=300.0, max_yaw_acceleration=2000.0, look_at=look_at)
        fly(flying, crowd(seed), seconds=8.0, top_speed=3.0, reach=6.0)
        whole, uav = flying.flown(0), flying.scenario.uavs[0]
        t = np.linspace(0.0, whole.end, 3001)
        wanted, _ = bearings(whole, t, uav)
        off.append(np.degrees(np.abs(wrapped(whole.heading(t).yaw - wanted))))
        if look_at is None:  # the course of a UAV that turns back may leap
            off[-1] = off[-1][np.hypot(*whole.at(t).velocity[:, :2].T) > 2.0]
        else:
            sight = np.array(look_at) - whole.at(t).position
            pitch = np.arctan2(-whole.at(t).position[:, 2], np.hypot(*sight[:, :2].T))
            np.testing.assert_allclose(whole.heading(t).pitch, pitch, atol=1e-9)
    off = np.concatenate(off)
    assert np.percentile(off, 90) < 3.0
    assert off.max() < 20.0


@pytest.mark.parametrize("limits", [{}, SLOW, {"look_at": (10.0, 12.0, 0.0)}])
def test_a_nose_that_meets_nothing_points_as_the_mission_says(limits):
    flying = flight(*BENT, **limits)
    fly(flying, [], top_speed=1.0)
    (planned,) = flying.mission.trajectories
    t = np.linspace(planned.start + 2.0, planned.end, 2001)
    said, flown = planned.heading(t).yaw, flying.flown(0).heading(t).yaw
    assert np.degrees(np.ptp(said)) > 20.0
    assert np.degrees(np.abs(flown - said)).max() < 1.0


def test_a_nose_that_rests_settles_where_it_is_to_point():
    flying = flight(look_at=(10.0, 12.0, 0.0), **SLOW)
    flying.observe(0.1, targets={0: (1.0, 9.0, 1.0)})
    for k in range(2, 150):
        flying.observe(k / 10)
    wanted, _ = bearings(flying.flown(0), np.array([15.0]), flying.scenario.uavs[0])
    yaw, rate, _ = flying.flown(0).heading(np.array([15.0, 1e4]))
    assert np.degrees(np.abs(wrapped(yaw - wanted))).max() < 0.1
    assert np.abs(rate).max() == 0.0


def test_a_nose_goes_on_where_the_uav_is_found_elsewhere_and_without_a_mission_to_fly():
    flying = flight()
    for k in range(1, 20):
        flying.observe(k / 10)
    before = flying.flown(0)
    flying.observe(2.0, states={0: ((3.0, 6.0, 1.0), (0.0, 1.0, 0.0))})
    t = np.linspace(0.0, 2.0, 101)
    assert np.array_equal(flying.flown(0).heading(t).yaw, before.heading(t).yaw)
    stranded = flying.mission.scenario.model_copy(update={"uavs": (sky.UAV(start=(1, 5, 1), look_at=(1, 9, 0)),)})
    none = replace(flying.mission, scenario=stranded, assignment=(None,), results=(None,), trajectories=(None,))
    assert sky.Replanner(none).motion(0).heading([0.0, 5.0]).yaw == pytest.approx(np.pi / 2)


def test_a_nose_of_a_fixed_heading_turns_for_nothing():
    flying = flight(heading=200.0)
    answers = fly(flying, crowd(1), seconds=8.0, top_speed=3.0, reach=6.0)
    assert sum(not answer.kept for (answer,) in answers) > 10
    whole = flying.flown(0)
    yaw, rate, _ = whole.heading(np.linspace(0.0, whole.end + 2.0, 3001))
    np.testing.assert_allclose(wrapped(yaw - np.radians(90.0 - 200.0)), 0.0, atol=1e-9)
    assert not rate.any()


def test_policies_turn_noses_too():
    mission = sky.plan_mission(hall(targets=[sky.Target(position=(9, 9, 1))]))
    settings = {"policy": "velocity-obstacles", "rng": 0}
    flying = sky.Replanner(mission, **settings)
    turned = replace(mission.trajectories[0], pointing=None)  # as in files of older versions
    for start in (flying, sky.Replanner(replace(mission, trajectories=(turned,)), **settings)):
        assert sky.fly_closed_loop(start, mission.scenario, sky.Sensor(range=6.0), longest=20.0)
        whole = start.flown(0)
        t = np.linspace(0.5, whole.end, 100)
        wanted, _ = bearings(whole, t, mission.scenario.uavs[0])
        off = np.degrees(np.abs(wrapped(whole.heading(t).yaw - wanted)))
        assert off[t < 1.7].max() < 3.0  # then it flies past its target, and back
        assert np.degrees(np.ptp(wanted[t < 2.5])) > 10.0


def test_an_aeroplane_flies_where_its_nose_points():
    flying = sky.Replanner(sky.plan_mission(field(), assignment="identity"))
    wall = sky.Box(min=(280, 150, 0), max=(300, 260, 120))
    for k in range(1, 150):
        flying.observe(k / 5, obstacles=[wall] if k == 5 else [])
    for flown in (flying.flown(0), flying.motion(0)):
        t = np.linspace(flown.start, flown.end, 3001)
        wanted, known = bearings(flown, t, flying.scenario.uavs[0])
        assert np.degrees(np.abs(wrapped(flown.heading(t).yaw - wanted)))[known].max() < 3.0


def test_an_answer_costs_no_more_after_an_hour_of_turns():
    flying, kept = flight(), []
    for k in range(1, 300):
        flying.observe(k / 10, targets={0: (1.0 + k // 10 % 2 * 8.0, 5.0 + k // 10 % 3, 1.0)} if k % 10 == 0 else {})
        kept.append(len(flying._pilots[0].pointing.turns))
    whole = flying.flown(0).pointing
    assert len(whole.turns) > 400
    assert max(kept[150:]) <= max(kept[:150])
    assert (np.diff(whole.instants) > 0).all()
    t = np.linspace(0.0, 30.0, 1001)
    (ahead,) = np.nonzero(t >= flying.motion(0).start)
    np.testing.assert_allclose(flying.motion(0).heading(t).yaw[ahead], flying.flown(0).heading(t).yaw[ahead], atol=1e-9)


def test_headings_of_what_was_flown_are_exported(tmp_path):
    flying = flight()
    fly(flying, crowd(1), seconds=4.0, top_speed=3.0, reach=6.0)
    whole = flying.flown(0)
    sky.write(replace(flying.mission, trajectories=(whole,)), tmp_path / "flown.json")
    sky.write(replace(flying.mission, trajectories=(whole,)), tmp_path / "flown.csv")
    assert sky.read_mission(tmp_path / "flown.json").trajectories[0] == whole
    rows = (tmp_path / "flown.csv").read_text().splitlines()
    at = rows[0].split(",").index("yaw")
    yaws = np.array([float(row.split(",")[at]) for row in rows[1:]])
    assert np.ptp(yaws) > 0.5
