"""Exported waypoints keep the speed limits of zones, however far an autopilot has braked when it reaches a leg."""

from functools import cache

import numpy as np
import pytest
import replayed_autopilot as autopilot
from exported_fleets import ORIGIN
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skyverse as sky
from speed_zones import BOX, SPHERE, holds, world_of


def mission(*zones, **limits):
    uav = sky.UAV(start=(-80, -30, 12), home=0, max_speed=14, **limits)
    wall = sky.Box(min=(20, -70, 0), max=(25, 15, 80))
    return sky.plan_mission(
        world_of(
            *zones,
            obstacles=(wall,),
            uavs=(uav,),
            targets=(sky.Target(position=(80, 0, 25)),),
            frame=sky.Frame(origin=ORIGIN),
        ),
        sky.Taut(),
    )


def flown(orders, braking, early):
    """Places and speeds: each leg a tenth too fast, braked for only on it, and begun `early` metres before its end."""
    places = [np.array(place) for place in orders.places]
    pace, at = 0.0, places[0]
    track, speeds = [], []
    for k in range(1, len(places)):
        to, most = places[k], 1.1 * orders.speeds[k]
        if orders.stops or orders.stays[k - 1] > 0:
            pace = 0.0
        way = to - at
        length = np.linalg.norm(way)
        left = length - (early if k < len(places) - 1 and not orders.stops else 0.0)
        for done in np.arange(0.0, max(left, 0.0), 0.05):
            track.append(at + done / length * way)
            slower = np.sqrt(max(pace**2 - 2 * braking * 0.05, 0.0))
            pace = max(slower, most) if pace > most else np.sqrt(min(pace**2 + 2 * 5.0 * 0.05, most**2))
            speeds.append(pace)
        at = at + max(left, 0.0) / length * way
    return np.array(track), np.array(speeds)


def orders_of(mission, path):
    sky.export(mission, path, sky.ExportOptions(altitude="amsl"))
    if path.name.endswith(".plan"):
        return autopilot.read_plan(path.read_text(), ORIGIN)
    if path.name.endswith(".waypoints"):
        return autopilot.read_waypoints(path.read_text(), ORIGIN)
    return autopilot.read_wpml(path, ORIGIN, (0, 0, 0), -ORIGIN.geoid)


def assert_slow_in(zones, orders, strays=((0.0, 0.0, 0.0),)):
    for braking in (1.5, 3.0):
        for early in (0.0, 1.9):
            track, speeds = flown(orders, braking, early)
            for stray in strays:
                for zone in zones:
                    assert speeds[holds(zone, track + stray)].max(initial=0) <= zone.max_speed * (1 + 1e-3)


@pytest.mark.parametrize("name", ["m.plan", "m.waypoints", "m.wpml.kmz"])
@pytest.mark.parametrize("zones", [(BOX,), (SPHERE,), (BOX, SPHERE)])
@pytest.mark.parametrize("error", [0.0, 3.0])
def test_no_replay_is_faster_than_the_limit_of_a_zone_inside_it(tmp_path, name, zones, error):
    turns = np.linspace(0, 2 * np.pi, 8 if error else 1)
    orders = orders_of(past_a_wall(zones, error), tmp_path / name)
    assert_slow_in(zones, orders, [(error * np.cos(turn), error * np.sin(turn), 0) for turn in turns])


@cache
def past_a_wall(zones, error):
    """The mission through these zones, planned once for all formats."""
    return mission(*zones, tracking_error={"horizontal": error})


@pytest.mark.parametrize("name", ["m.plan", "m.waypoints", "m.wpml.kmz"])
@pytest.mark.parametrize("before", [10, 20, 30, 40, 50])
def test_no_replay_is_too_fast_in_a_zone_behind_a_bend(tmp_path, name, before):
    planned = behind_a_bend(before)
    assert_slow_in(planned.scenario.zones, orders_of(planned, tmp_path / name))


@cache
def behind_a_bend(before):
    """A mission around the end of a wall, into a slow zone so many metres behind it."""
    zone = sky.Box(min=(20, -60, 0), max=(60, 60, 60), max_speed=2.0)
    wall = sky.Box(min=(17 - before, -90, 0), max=(20 - before, 1, 80))
    uav, target = sky.UAV(start=(-95, -60, 12), home=0, max_speed=14), sky.Target(position=(90, 0, 12))
    world = world_of(zone, obstacles=(wall,), uavs=(uav,), targets=(target,), frame=sky.Frame(origin=ORIGIN))
    return sky.plan_mission(world, sky.Taut())


@st.composite
def boxes(draw, low, high, max_speed=None):
    x, y = draw(st.floats(-50, 50)), draw(st.floats(-50, 50))
    a, b = draw(st.floats(2, 20)), draw(st.floats(2, 20))
    return sky.Box(min=(x - a, y - b, 0), max=(x + a, y + b, draw(st.floats(low, high))), max_speed=max_speed)


zones_anywhere = st.sampled_from([1.0, 2.0, 5.0]).flatmap(lambda limit: boxes(20, 80, limit))


@settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    zones=st.lists(zones_anywhere, min_size=1, max_size=3),
    walls=st.lists(boxes(20, 80), min_size=1, max_size=4),
    north=st.tuples(st.floats(-80, 80), st.floats(-80, 80)),
    height=st.tuples(st.floats(5, 30), st.floats(5, 40)),
    name=st.sampled_from(["m.plan", "m.waypoints", "m.wpml.kmz"]),
)
def test_no_replay_is_too_fast_in_zones_of_random_worlds(tmp_path, zones, walls, north, height, name):
    uav = sky.UAV(start=(-80, north[0], height[0]), home=0, max_speed=14, max_climb=0.8, max_descent=0.8)
    target = sky.Target(position=(80, north[1], height[1]))
    world = world_of(*zones, obstacles=tuple(walls), uavs=(uav,), targets=(target,), frame=sky.Frame(origin=ORIGIN))
    orders = orders_of(sky.plan_mission(world, sky.Taut()), tmp_path / name)
    assert_slow_in(zones, orders)


def test_waypoints_are_slow_only_where_a_zone_is_near(tmp_path):
    orders = orders_of(mission(BOX), tmp_path / "m.plan")
    track, speeds = flown(orders, 3.0, 0.0)
    assert speeds[holds(BOX, track)].max() > 0.8 * BOX.max_speed
    assert np.mean(speeds > 8) > 0.4
    assert max(orders.speeds) > 10


def test_a_take_off_in_a_zone_that_is_too_fast_for_it_is_refused_in_one_sentence(tmp_path, refuses):
    around_the_start = sky.Cylinder(centre=(-80, -30), radius=9, low=0, high=40, max_speed=0.5)
    with refuses():
        sky.export(mission(around_the_start), tmp_path / "m.plan")


@pytest.mark.parametrize(("climb", "kept"), [(1.8, True), (1.9, False)])
@pytest.mark.parametrize("name", ["m.plan", "m.waypoints", "m.wpml.kmz"])
def test_a_refusal_tells_what_is_kept_in_hand_of_a_speed_limit(tmp_path, climb, kept, name, refuses):
    around_the_start = sky.Cylinder(centre=(-80, -30), radius=9, low=0, high=40, max_speed=2.0)
    planned = mission(around_the_start, max_climb=climb, max_descent=climb)
    if kept:
        sky.export(planned, tmp_path / name, sky.ExportOptions(altitude="amsl"))
        return
    with refuses():
        sky.export(planned, tmp_path / name, sky.ExportOptions(altitude="amsl"))


def test_where_the_limit_itself_is_too_low_the_climb_is_not_blamed(tmp_path, refuses):
    round_the_target = sky.Cylinder(centre=(80, 0), radius=9, low=0, high=80, max_speed=0.21)
    with refuses():
        sky.export(mission(round_the_target), tmp_path / "m.plan", sky.ExportOptions(altitude="amsl"))


def test_exports_tell_that_speed_limits_are_kept_and_of_which_returns_that_is_not_proven(tmp_path):
    notes = []
    sky.export(mission(BOX), tmp_path / "m.plan", on_note=notes.append)
    assert any(note.startswith("The commanded speeds keep the speed limits of zones") for note in notes)
    assert any(note.startswith("WARNING: the speed limits of zones are not proven of the returns") for note in notes)
    notes.clear()
    sky.export(mission(), tmp_path / "n.plan", on_note=notes.append)
    assert not any("speed limit" in note for note in notes)


def test_returns_that_a_slow_zone_far_away_makes_slow_are_told_with_their_seconds(tmp_path):
    far = sky.Cylinder(centre=(90, 70), radius=2, low=0, high=10, max_speed=2)
    notes = []
    sky.export(mission(far), tmp_path / "m.plan", sky.ExportOptions(altitude="amsl"), on_note=notes.append)
    (said,) = (note for note in notes if "returns are as slow" in note)
    assert said.startswith("WARNING: ")
    assert "uav-1 at 1.82 m/s from 163 m away, 90 s." in said
    notes.clear()
    sky.export(mission(), tmp_path / "m.plan", sky.ExportOptions(altitude="amsl"), on_note=notes.append)
    assert not any("returns are as slow" in note for note in notes)


@pytest.mark.parametrize("name", ["m.plan", "m.waypoints"])
def test_a_uav_brakes_for_a_zone_in_steps_and_crawls_no_longer_than_it_must(tmp_path, name):
    zone = sky.Box(min=(-20, -60, 0), max=(20, 60, 80), max_speed=2)
    uav = sky.UAV(start=(-90, 0, 30), home=0, max_speed=12)
    target = sky.Target(position=(90, 0, 30))
    world = world_of(zone, uavs=(uav,), targets=(target,), frame=sky.Frame(origin=ORIGIN))
    planned = sky.plan_mission(world, sky.Taut())
    orders = orders_of(planned, tmp_path / name)
    assert_slow_in((zone,), orders)
    places = np.array(orders.places)
    level = np.hypot(*np.diff(places[:, :2], axis=0).T)
    seconds = (level / np.array(orders.speeds[1:]))[level > 1.0].sum()
    assert seconds < 1.35 * (planned.trajectories[0].end - planned.trajectories[0].start)
