"""Missions are judged where they are flown, also across the antimeridian, and refused where that cannot be."""

import json

import pytest

import skyverse as sky
from skyverse.model.waypoints import Order, OrderKind
from written_missions import NAN, item, plan

LEVEL = sky.BuildOptions("field", ground=sky.AboveSea(400.0), clearance=2.0, ground_clearance=2.0)


def mission(tmp_path, places, home=(47.0, 8.0)):
    made = json.loads(
        plan([item(22, 0, 0, 0, NAN, NAN, NAN, 30), *(item(16, 0, 0, 0, NAN, *one, 30) for one in places)])
    )
    made["mission"]["plannedHomePosition"] = [*home, 400.0]
    path = tmp_path / "m.plan"
    path.write_text(json.dumps(made), encoding="utf-8")
    return sky.read_waypoints(path)


FIELD = sky.Scenario(
    name="field",
    bounds={"min": (-300, -300, 0), "max": (300, 300, 100)},
    clearance=2.0,
    frame={"origin": {"latitude": 47.0, "longitude": 8.0, "altitude": 400.0}},
    uavs=[{"name": "u", "start": (0, 0, 1), "home": 0.0}],
)


@pytest.mark.parametrize("where", [LEVEL, FIELD], ids=["maps", "a scenario"])
@pytest.mark.parametrize(
    "places", [[(8.001, 47.001)], [(47.001, 8.001), (8.0, 8.0)], []], ids=["swapped", "far away", "take-off alone"]
)
def test_a_mission_that_leads_nowhere_near_is_refused(tmp_path, refuses, places, where):
    with refuses():
        sky.check_waypoints([mission(tmp_path, places)], where)


@pytest.mark.parametrize("where", [LEVEL, FIELD], ids=["maps", "a scenario"])
def test_a_circle_that_leads_nowhere_near_is_refused(tmp_path, refuses, where):
    path = tmp_path / "m.plan"
    around = [item(22, 0, 0, 0, NAN, NAN, NAN, 30), item(18, 2, 0, 1e7, NAN, 47.001, 8.0, 30)]
    path.write_text(plan(around), encoding="utf-8")
    with refuses():
        sky.check_waypoints([sky.read_waypoints(path)], where, sky.FlightSettings(home=(47.0, 8.0)))


def test_home_may_be_given_where_the_file_has_another(tmp_path, refuses):
    elsewhere = mission(tmp_path, [(60.001, 20.0), (60.002, 20.0)])
    with refuses():
        sky.check_waypoints([elsewhere], LEVEL)
    (found,) = sky.check_waypoints([elsewhere], LEVEL, sky.FlightSettings(home=(60.0, 20.0))).missions
    assert found.is_proven, found.findings
    origin = found.scenario.frame.origin
    assert sky.to_wgs84(origin, found.flown.plan.home[None])[0] == pytest.approx([60.0, 20.0, 400.0], abs=1e-6)


def test_a_mission_across_the_antimeridian_is_as_one_elsewhere(tmp_path):
    def lengths(longitude):
        places = [(-17.0, longitude), (-17.001, (longitude + 0.002 + 180) % 360 - 180), (-17.0, longitude)]
        (found,) = sky.check_waypoints([mission(tmp_path, places[1:], home=places[0])], LEVEL).missions
        assert found.is_proven, found.findings
        return found.summary.length

    assert lengths(179.999) == pytest.approx(lengths(100.0), rel=1e-6)


@pytest.mark.parametrize(
    ("mode", "up", "heights"),
    [
        ("safely", 50, [50, 50]),
        ("safely", 10, [30, 30, 10]),
        ("pointToPoint", 50, [30, 50]),
        ("pointToPoint", 10, [30, 10]),
    ],
)
def test_drones_of_dji_fly_to_their_first_waypoint_on_one_level_if_they_are_told_so(mode, up, heights):
    takeoff = Order(0, OrderKind.TAKEOFF, mode, place=(float("nan"), float("nan"), sky.AboveHome(30.0)))
    first = Order(1, OrderKind.WAYPOINT, "waypoint", place=(47.001, 8.0, sky.AboveHome(float(up))))
    given = sky.Waypoints("m.kmz", (takeoff, first), (47.0, 8.0, 400.0), 5.0, "dji")
    (found,) = sky.check_waypoints([given], LEVEL).missions
    assert [visit.at[2] for visit in found.flown.visits] == pytest.approx(heights, abs=1e-6)
