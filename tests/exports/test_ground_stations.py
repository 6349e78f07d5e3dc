"""Missions for ground stations, read back by MAVSDK and pymavlink."""

import json

import handmade_exports as handmade
import jsonschema
import numpy as np
import pytest

import skyverse as sky
from patience import wait_until
from proj_map import proj_local
from skyverse import Origin
from skyverse.exports.mavlink_formats import geofence

pytestmark = pytest.mark.usefixtures("unjudged")

pytest.importorskip("pyproj", reason="an independent geodesy")

FRAMES = {"amsl": 0, "home": 3, "agl": 10}
WAYPOINT, LOITER, RETURN, LAND, TAKEOFF, DELAY, SPEED = 16, 17, 20, 21, 22, 93, 178


def random_case(seed):
    above = ("amsl", "home", "agl")[seed % 3]
    mission = handmade.random_mission(seed, terrain=above == "agl" or seed % 2 == 1, towers=above != "agl")
    return mission, above


def end_over(mission):
    """Land multirotors where there are no slopes: those of random ground are too steep."""
    planes = any(uav.fixed_wing is not None for uav in mission.scenario.uavs)
    return "land" if mission.scenario.terrain is None and not planes else "loiter"


def sea_level(scenario, uav, above, latitude, longitude, altitude):
    """Altitudes above the sea, of altitudes above something, by other people's means."""
    origin = scenario.frame.origin
    if above == "amsl":
        return altitude
    if above == "home":
        from skyverse import to_wgs84

        start = np.array(scenario.uavs[uav].start)
        if scenario.terrain is not None:
            start[2] = handmade.under(scenario, start[None])[0]
        return altitude + to_wgs84(origin, start)[0, 2]
    flat = handmade.local(origin, latitude, longitude, np.full(len(latitude), origin.altitude))
    ground = flat[:, 2] * 0 + handmade.under(scenario, flat)
    return altitude + origin.altitude + ground - flat[:, 2]


def same_places(mission, route, above, items, tolerance=0.012):
    """Whether a read mission's waypoints are the route's: latitude, longitude and altitude of each."""
    latitude, longitude, altitude = np.array(items, dtype=float).T
    sea = sea_level(mission.scenario, route.uav, above, latitude, longitude, altitude)
    back = handmade.local(mission.scenario.frame.origin, latitude, longitude, sea)
    first = 1 if route.takeoff else 0
    assert back.shape == route.points[first:].shape
    assert np.linalg.norm(back - route.points[first:], axis=1).max() < tolerance


def flown_items(items):
    return [item for item in items if item.command in (TAKEOFF, WAYPOINT)]


@pytest.mark.parametrize("seeds", [range(8), range(8, 40)], ids=["few", "many"])
def test_plans_read_by_mavsdk_have_the_same_places_in_the_same_frame(stations, tmp_path, seeds):
    for seed in seeds:
        mission, above = random_case(seed)
        routes = sky.routes(mission, altitude=above)
        files = sky.export(mission, tmp_path / f"m{seed}.plan", sky.ExportOptions(altitude=above, allow_close=True))
        assert len(files) == len(routes) == len({file.name.lower() for file in files})
        begins = []
        for route, file in zip(routes, files, strict=True):
            read = stations.mission.import_qgroundcontrol_mission(str(file))
            flown = flown_items(read.mission_items)
            assert {item.frame for item in flown} == {FRAMES[above]}
            same_places(mission, route, above, [(i.x / 1e7, i.y / 1e7, i.z) for i in flown])
            wing = mission.scenario.uavs[route.uav].fixed_wing is not None
            upright = 0.0 if wing or above == "agl" else min(max(route.radius / 2, 0.05), 0.5)  # PX4's NAV_MC_ALT_RAD
            radii = [np.hypot(i.param2, upright) for i in flown if i.command == WAYPOINT]
            np.testing.assert_allclose(radii, route.radius, rtol=1e-6)
            waits = [i.param1 for i in read.mission_items if i.command == DELAY]
            name = "ardupilot" if above == "agl" else "px4"
            seconds = handmade.takeoff_seconds(handmade.climb(mission.scenario, route), name)
            begins.append(sum(waits) + seconds - route.times[0])
            assert [i.command for i in read.mission_items][-1] == LOITER
            assert len(read.rally_items) <= 5
            assert len(read.geofence_items) == 4
        assert np.ptp(begins) < 2e-3
        assert begins[0] > -1e-3


@pytest.mark.parametrize("seeds", [range(8), range(8, 40)], ids=["few", "many"])
def test_waypoints_read_by_pymavlink_have_the_same_places_in_the_same_frame(tmp_path, seeds):
    mavwp = pytest.importorskip("pymavlink.mavwp", reason="reads .waypoints")
    for seed in seeds:
        mission, above = random_case(seed)
        routes, end = sky.routes(mission, altitude=above), end_over(mission)
        for route, file in zip(
            routes,
            sky.export(
                mission, tmp_path / f"m{seed}.waypoints", sky.ExportOptions(altitude=above, end=end, allow_close=True)
            ),
            strict=True,
        ):
            loader = mavwp.MAVWPLoader()
            loader.load(str(file))
            read = [loader.wp(k) for k in range(loader.count())]
            assert [item.seq for item in read] == list(range(len(read)))
            home = handmade.local(mission.scenario.frame.origin, [read[0].x], [read[0].y], [read[0].z])
            start = np.array(mission.scenario.uavs[route.uav].start)
            if mission.scenario.terrain is not None:
                start[2] = handmade.under(mission.scenario, start[None])[0]
            assert np.linalg.norm(home - start) < 1e-3
            flown = flown_items(read[1:])
            assert {item.frame for item in flown} == {FRAMES[above]}
            same_places(
                mission, route, above, [(i.x, i.y, i.z) for i in flown], tolerance=5e-3 if above == "agl" else 1e-3
            )
            assert read[-1].command == (LAND if end == "land" else LOITER)
            assert all(np.isnan(item.param4) for item in flown)  # the autopilot's own heading, not north


def test_waypoints_read_by_mavsdk_are_those_of_the_plan(stations, tmp_path):
    for seed in range(6):
        mission, above = random_case(seed)
        how = {"altitude": above, "allow_close": True, "autopilot": "ardupilot"}
        plans = sky.export(mission, tmp_path / f"m{seed}.plan", sky.ExportOptions(**how))
        texts = sky.export(
            mission, tmp_path / f"m{seed}.waypoints", sky.ExportOptions(altitude=above, allow_close=True)
        )
        for plan, text in zip(plans, texts, strict=True):
            one = stations.mission.import_qgroundcontrol_mission(str(plan)).mission_items
            other = stations.mission.import_mission_planner_mission(str(text)).mission_items[1:]
            fields = ("command", "frame", "param1", "param2", "x", "y", "z")
            assert [[getattr(i, f) for f in fields] for i in one] == [[getattr(i, f) for f in fields] for i in other]


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 9, 14])
def test_a_simulated_autopilot_accepts_what_is_uploaded(stations, tmp_path, seed):
    mission, above = random_case(seed)
    (file, *_) = sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(altitude=above, allow_close=True))
    items = stations.mission.import_qgroundcontrol_mission(str(file)).mission_items
    stations.received.clear()
    stations.mission.upload_mission(items)
    arrived = wait_until(lambda: stations.received)[-1]
    fields = ("seq", "frame", "command", "param2", "x", "y", "z")
    assert [[getattr(i, f) for f in fields] for i in arrived] == [[getattr(i, f) for f in fields] for i in items]


NUMBER = {"type": "number"}
PLACE = {
    "type": "array",
    "prefixItems": [{**NUMBER, "minimum": -90, "maximum": 90}, {**NUMBER, "minimum": -180, "maximum": 180}],
    "minItems": 2,
    "maxItems": 2,
    "items": False,
}


def strict(properties, optional=()):
    return {
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


ITEM = strict(
    {
        "type": {"const": "SimpleItem"},
        "autoContinue": {"const": True},
        "command": {"enum": [WAYPOINT, LOITER, RETURN, LAND, TAKEOFF, DELAY, SPEED]},
        "doJumpId": {"type": "integer", "minimum": 1},
        "frame": {"enum": [0, 2, 3, 10]},
        "params": {"type": "array", "minItems": 7, "maxItems": 7, "items": {"type": ["number", "null"]}},
        "Altitude": NUMBER,
        "AltitudeMode": {"enum": [1, 2, 4]},
        "AMSLAltAboveTerrain": {"type": "null"},
    },
    optional=("Altitude", "AltitudeMode", "AMSLAltAboveTerrain"),
)
PLAN = strict(
    {
        "fileType": {"const": "Plan"},
        "version": {"const": 1},
        "groundStation": {"type": "string"},
        "mission": strict(
            {
                "version": {"const": 2},
                "firmwareType": {"enum": [3, 12]},
                "vehicleType": {"enum": [1, 2]},
                "globalPlanAltitudeMode": {"enum": [1, 2, 4]},
                "cruiseSpeed": {**NUMBER, "exclusiveMinimum": 0},
                "hoverSpeed": {**NUMBER, "exclusiveMinimum": 0},
                "plannedHomePosition": {"type": "array", "minItems": 3, "maxItems": 3, "items": NUMBER},
                "items": {"type": "array", "minItems": 2, "items": ITEM},
            }
        ),
        "geoFence": strict(
            {
                "version": {"const": 2},
                "polygons": {
                    "type": "array",
                    "items": strict(
                        {
                            "version": {"const": 1},
                            "inclusion": {"type": "boolean"},
                            "polygon": {"type": "array", "minItems": 3, "items": PLACE},
                        }
                    ),
                },
                "circles": {
                    "type": "array",
                    "items": strict(
                        {
                            "version": {"const": 1},
                            "inclusion": {"type": "boolean"},
                            "circle": strict({"center": PLACE, "radius": {**NUMBER, "exclusiveMinimum": 0}}),
                        }
                    ),
                },
            }
        ),
        "rallyPoints": strict(
            {
                "version": {"const": 2},
                "points": {"type": "array", "items": {"type": "array", "minItems": 3, "maxItems": 3, "items": NUMBER}},
            }
        ),
    }
)


@pytest.mark.parametrize("seeds", [range(8), range(8, 30)], ids=["few", "many"])
def test_plans_have_every_field_that_qgroundcontrol_wants_and_no_other(tmp_path, seeds):
    validator = jsonschema.Draft202012Validator(PLAN)
    for seed in seeds:
        mission, above = random_case(seed)
        end = ("loiter", end_over(mission))[seed // 2 % 2]
        for file in sky.export(
            mission, tmp_path / f"m{seed}.plan", sky.ExportOptions(altitude=above, end=end, allow_close=True)
        ):
            plan = json.loads(file.read_text())
            validator.validate(plan)
            # PX4 answers UNSUPPORTED_FRAME to altitudes above ground; ArduPilot wants a number to loiter
            assert plan["mission"]["firmwareType"] == (3 if above == "agl" else 12)
            yaws = [item["params"][3] for item in plan["mission"]["items"] if item["command"] == LOITER]
            assert all((yaw is None) == (above != "agl") for yaw in yaws)
            items = plan["mission"]["items"]
            assert [item["doJumpId"] for item in items] == list(range(1, len(items) + 1))
            assert all(i["Altitude"] == i["params"][6] for i in items if i["frame"] != 2)
            modes = {0: 2, 3: 1, 10: 4}
            assert all(i["AltitudeMode"] == modes[i["frame"]] for i in items if i["frame"] != 2)


def test_a_geofence_holds_what_nothing_may_fly_over():
    flight = handmade.along([(0, 0, 10), (50, 0, 10)], 10)
    somewhere = Origin(latitude=47.0, longitude=8.5, altitude=400.0)
    scenario = handmade.mission([flight], boxes=[((20, 20, -50), (30, 30, 0))], origin=somewhere).scenario
    (low,) = scenario.obstacles
    closed = scenario.model_copy(update={"obstacles": (low.model_copy(update={"closed_above": True}),)})
    assert [len(geofence(one)["polygons"]) for one in (scenario, closed)] == [1, 2]


@pytest.mark.parametrize("latitude", [0.0, 47.0, 70.0])
def test_the_fence_of_wide_bounds_is_that_of_the_map(tmp_path, latitude):
    side = 40_000.0
    origin = sky.Origin(latitude=latitude, longitude=10.0, altitude=0.0)
    flight = handmade.along([(0, side - 50, 50), (300, side - 50, 50)], 60)
    mission = handmade.mission([flight], origin=origin, low=(-side, -side, 0.0), high=(side, side, 200.0))
    sky.export(mission, tmp_path / "wide.plan", sky.ExportOptions(altitude="home"))
    (fence,) = json.loads((tmp_path / "wide.plan").read_text())["geoFence"]["polygons"]
    ring = np.array(fence["polygon"])
    ways = np.linspace(ring, np.roll(ring, -1, axis=0), 50).reshape(-1, 2)
    off = np.abs(np.abs(proj_local(origin, *ways.T, 0.0)[:, :2]).max(axis=1) - side)
    assert off.max() < 0.6
    assert len(ring) < 150
