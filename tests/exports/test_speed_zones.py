"""Exported waypoints keep the speed limits of zones, however far an autopilot has braked when it reaches a leg."""

import numpy as np
import pytest
import replayed_autopilot as autopilot
from exported_fleets import ORIGIN

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
    sky.export(mission, path, altitude="amsl")
    if path.name.endswith(".plan"):
        return autopilot.read_plan(path.read_text(), ORIGIN)
    if path.name.endswith(".waypoints"):
        return autopilot.read_waypoints(path.read_text(), ORIGIN)
    return autopilot.read_wpml(path, ORIGIN, (0, 0, 0), -ORIGIN.geoid)


@pytest.mark.parametrize("name", ["m.plan", "m.waypoints"])
@pytest.mark.parametrize("zones", [(BOX,), (SPHERE,), (BOX, SPHERE)])
@pytest.mark.parametrize("error", [0.0, 3.0])
def test_no_replay_is_faster_than_the_limit_of_a_zone_inside_it(tmp_path, name, zones, error):
    planned = mission(*zones, tracking_error={"horizontal": error})
    orders = orders_of(planned, tmp_path / name)
    for braking in (1.5, 3.0):
        for early in (0.0, 1.9):
            track, speeds = flown(orders, braking, early)
            for turn in np.linspace(0, 2 * np.pi, 8):
                strayed = track + np.array([error * np.cos(turn), error * np.sin(turn), 0])
                for zone in zones:
                    assert speeds[holds(zone, strayed)].max(initial=0) <= zone.max_speed * (1 + 1e-3)


def test_waypoints_are_slow_only_where_a_zone_is_near(tmp_path):
    orders = orders_of(mission(BOX), tmp_path / "m.plan")
    track, speeds = flown(orders, 3.0, 0.0)
    assert speeds[holds(BOX, track)].max() > 0.8 * BOX.max_speed
    assert np.mean(speeds > 8) > 0.4
    assert max(orders.speeds) > 10


def test_a_take_off_in_a_zone_that_is_too_fast_for_it_is_refused_in_one_sentence(tmp_path):
    around_the_start = sky.Cylinder(centre=(-80, -30), radius=9, low=0, high=40, max_speed=0.5)
    with pytest.raises(sky.InputError, match=r"^uav-1: its take-off leads through zone 0, whose speed limit of 0\.5"):
        sky.export(mission(around_the_start), tmp_path / "m.plan")


def test_exports_tell_that_speed_limits_are_kept_and_of_which_returns_that_is_not_proven(tmp_path):
    notes = []
    sky.export(mission(BOX), tmp_path / "m.plan", on_note=notes.append)
    assert any(note.startswith("The commanded speeds keep the speed limits of zones") for note in notes)
    assert any(note.startswith("WARNING: the speed limits of zones are not proven of the returns") for note in notes)
    notes.clear()
    sky.export(mission(), tmp_path / "n.plan", on_note=notes.append)
    assert not any("speed limit" in note for note in notes)
