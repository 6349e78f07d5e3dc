"""Headings: continuous, within the limits on the yaw, along the course or at a point."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.uav import with_limits
from skyverse.model.vehicle_profiles import FleetLimits
from skyverse.trajectory import blended, rest_to_rest, with_heading
from speed_zones import world_of

PLACE = st.tuples(st.floats(-90, 90), st.floats(-90, 90), st.floats(1, 60))
PATHS = st.lists(PLACE, min_size=2, max_size=6).map(np.array)
UAVS = st.builds(
    sky.UAV,
    start=st.just((0, 0, 0)),
    max_speed=st.floats(1, 20),
    max_yaw_rate=st.floats(5, 300),
    max_yaw_acceleration=st.floats(5, 1000),
    look_at=st.none() | PLACE,
) | st.builds(sky.UAV, start=st.just((0, 0, 0)), max_speed=st.floats(1, 20), heading=st.floats(0, 360))
WORLD = sky.World(world_of())


def wrapped(angle):
    return np.angle(np.exp(1j * angle))


@settings(max_examples=60)
@given(PATHS, UAVS)
def test_the_yaw_is_continuous_and_its_rate_and_acceleration_keep_their_limits(path, uav):
    if np.linalg.norm(np.diff(path, axis=0), axis=1).min() < 1e-3:
        return
    for flown in (blended(WORLD, path, uav, 2.0), rest_to_rest(path, uav)):
        told = with_heading(flown, uav)
        t = np.linspace(flown.start, flown.end, 20001)
        heading, step = told.heading(t), t[1] - t[0]
        rate, acceleration = np.radians(uav.max_yaw_rate), np.radians(uav.max_yaw_acceleration)
        assert np.abs(heading.yaw_rate).max() <= rate * (1 + 1e-9)
        assert np.abs(np.diff(heading.yaw)).max() <= rate * step * (1 + 1e-6) + 1e-9
        assert np.abs(np.diff(heading.yaw_rate)).max() <= acceleration * step * (1 + 1e-6) + 1e-9
        middles = 0.5 * (heading.yaw_rate[1:] + heading.yaw_rate[:-1])
        np.testing.assert_allclose(np.diff(heading.yaw) / step, middles, atol=acceleration * step + 1e-6)
        slower = told.retimed(3.0, 1.5)
        np.testing.assert_allclose(slower.heading(3.0 + 1.5 * t).yaw, heading.yaw, atol=1e-6)


def test_the_nose_points_along_straight_legs_and_turns_at_the_bend():
    path = np.array([(-80.0, 0, 10), (0, 0, 10), (0, 80, 30)])
    uav = sky.UAV(start=(0, 0, 0), max_speed=5)
    flown = with_heading(blended(WORLD, path, uav, 2.0), uav)
    yaw = np.degrees(flown.heading(np.linspace(0, flown.end, 1001)).yaw)
    np.testing.assert_allclose(yaw[:400], 0.0, atol=1e-9)
    np.testing.assert_allclose(yaw[-400:], 90.0, atol=1e-6)
    assert np.all(np.diff(yaw) >= -1e-9)


def test_a_uav_that_turns_back_does_so_while_it_is_slow():
    path = np.array([(-50.0, 0, 10), (50, 0, 10), (-50, 1e-3, 10)])
    uav = sky.UAV(start=(0, 0, 0), max_speed=10, max_yaw_rate=90, max_yaw_acceleration=360)
    flown = with_heading(rest_to_rest(path, uav), uav)
    t = np.linspace(0, flown.end, 5001)
    turning, speed = np.abs(flown.heading(t).yaw_rate) > 1e-6, np.linalg.norm(flown.at(t).velocity, axis=1)
    assert speed[turning].max() < 0.5 * speed.max()
    stop = t[np.argmin(np.where(abs(t - flown.end / 2) < 5, speed, np.inf))]
    assert np.degrees(abs(flown.heading(stop).yaw[0])) == pytest.approx(90, abs=3)


def test_a_vertical_climb_keeps_the_heading():
    path = np.array([(0.0, 0, 5), (0, 0, 40), (60, 60, 40), (60, 60, 5)])
    uav = sky.UAV(start=(0, 0, 0))
    flown = with_heading(rest_to_rest(path, uav), uav)
    np.testing.assert_allclose(np.degrees(flown.heading(np.linspace(0, flown.end, 500)).yaw), 45, atol=1e-6)


def test_the_nose_and_the_camera_point_at_a_place():
    uav = sky.UAV(start=(0, 0, 0), look_at=(0, 60, 0), max_speed=5)
    flown = with_heading(blended(WORLD, np.array([(-80.0, 0, 30), (80, 0, 30)]), uav, 2.0), uav)
    t = np.linspace(0, flown.end, 500)
    heading, position = flown.heading(t), flown.at(t).position
    bearing = np.arctan2(60 - position[:, 1], -position[:, 0])
    assert np.degrees(np.abs(wrapped(heading.yaw - bearing))).max() < 3
    np.testing.assert_allclose(heading.pitch, -np.arctan2(30, np.hypot(position[:, 0], 60)), atol=1e-12)


@pytest.mark.parametrize(
    ("rate", "place", "told"), [(10, (0, 0.5, 12), True), (10, (0, 5, 0), True), (300, (0, 60, 0), False)]
)
def test_the_note_says_how_far_the_nose_is_off_the_place_to_look_at(rate, place, told):
    uav = sky.UAV(start=(-70, 0, 12), max_speed=14, max_yaw_rate=rate, max_yaw_acceleration=2 * rate, look_at=place)
    flown = with_heading(blended(WORLD, np.array([(-70.0, 0, 12), (70, 0, 12)]), uav, 2.0), uav)
    t = np.linspace(flown.start, flown.end, 20001)
    position = flown.at(t).position
    bearing = np.arctan2(place[1] - position[:, 1], place[0] - position[:, 0])
    off = np.degrees(np.abs(wrapped(flown.heading(t).yaw - bearing))).max()
    assert (off > 5) == told
    note = re.fullmatch(
        r"Its limits on the yaw keep its nose up to (\d+) degrees off the place to look at\.", flown.note
    )
    assert bool(note) == told == bool(flown.note)
    assert note is None or float(note[1]) == pytest.approx(off, abs=5)


def test_missions_have_headings_and_files_keep_them(tmp_path):
    uav, target = sky.UAV(start=(-70, 0, 12), look_at=(0, 30, 0)), sky.Target(position=(70, 0, 12))
    mission = sky.plan_mission(world_of(uavs=(uav,), targets=(target,)), sky.Taut())
    sky.write(mission, tmp_path / "m.json")
    assert sky.read_mission(tmp_path / "m.json").trajectories == mission.trajectories
    assert mission.trajectories[0].pointing.look_at == (0, 30, 0)
    sky.write(mission, tmp_path / "m.csv")
    head, first, *_ = (tmp_path / "m.csv").read_text().splitlines()
    row = dict(zip(head.split(","), first.split(","), strict=True))
    heading = mission.trajectories[0].heading(0.0)
    assert float(row["yaw"]) == pytest.approx(heading.yaw[0], rel=1e-6)
    assert float(row["pitch"]) == pytest.approx(heading.pitch[0], rel=1e-6)


@pytest.mark.parametrize(
    ("heading", "way"), [(0, (0, 1)), (90, (1, 0)), (180, (0, -1)), (225, (-1, -1)), (360, (0, 1))]
)
def test_a_fixed_heading_is_kept_on_every_leg_from_the_first_instant_to_the_last(heading, way):
    path = np.array([(-60.0, 0, 10), (0, 0, 40), (0, 60, 10), (-60, 0, 10)])
    uav = sky.UAV(start=(-60, 0, 10), max_speed=5, heading=heading)
    for flown in (blended(WORLD, path, uav, 2.0), rest_to_rest(path, uav)):
        told = with_heading(flown, uav).heading(np.linspace(flown.start, flown.end, 500))
        nose = np.column_stack([np.cos(told.yaw), np.sin(told.yaw)])
        np.testing.assert_allclose(nose, np.tile(way / np.hypot(*way), (500, 1)), atol=1e-12)
        assert not told.yaw_rate.any()
        assert not told.pitch.any()


@pytest.mark.parametrize("pointed", [{"look_at": (0, 0, 0)}, {"heading": 90}])
def test_an_aeroplane_cannot_look_aside(refuses, pointed):
    wing = sky.FixedWing(speed=10, turn_radius=40, climb=10)
    with refuses(ValueError):
        sky.UAV(start=(0, 0, 0), max_speed=12, fixed_wing=wing, **pointed)


@pytest.mark.parametrize(
    "wrong", [{"heading": 90, "look_at": (0, 0, 0)}, {"heading": -1}, {"heading": 361}, {"heading": "N"}]
)
def test_a_nose_points_one_way(refuses, wrong):
    with refuses(ValueError):
        sky.UAV(start=(0, 0, 0), **wrong)


def test_where_a_nose_points_does_not_depend_on_the_vehicle():
    for pointed in ({"look_at": (0, 0, 0)}, {"heading": 90}):
        uav = with_limits(sky.UAV(start=(0, 0, 0), **pointed), FleetLimits(vehicle="camera"))
        assert (uav.look_at, uav.heading) == (pointed.get("look_at"), pointed.get("heading"))
