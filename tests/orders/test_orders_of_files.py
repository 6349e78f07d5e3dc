"""What the orders of each format are, one by one."""

import math
import re
from dataclasses import replace

import pytest

import skyverse as sky
import written_missions as given
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea
from skyverse.model.waypoints import OrderKind as Kind


def read(tmp_path, name, content=None, **how):
    standing, told = given.EVERY_FORMAT.get(name, (None, {}))
    return sky.read_waypoints(given.write(tmp_path / name, standing if content is None else content), **(told | how))


def kinds(waypoints):
    return [order.kind for order in waypoints.orders]


def test_a_plan_is_read_item_by_item_as_qgroundcontrol_numbers_them(tmp_path):
    told = read(tmp_path, "m.plan")
    assert [order.number for order in told.orders] == list(range(1, 10))
    assert kinds(told) == [
        *(Kind.TAKEOFF, Kind.SPEED, Kind.WAYPOINT, Kind.CAMERA, Kind.WAYPOINT, Kind.JUMP, Kind.OTHER),
        *(Kind.WAYPOINT, Kind.RETURN),
    ]
    takeoff, speed, _, camera, corner, jump, other, high, _ = told.orders
    assert takeoff.place == (47.0, 8.0, AboveHome(30.0))
    assert (speed.speed, camera.spacing, jump.to, jump.times) == (6.5, 12.5, 3, 2)
    assert (corner.seconds, corner.radius, corner.heading) == (2.5, 3.0, 90.0)
    assert high.place == (47.003, 8.003, AboveSea(460.0))
    assert (other.name, told.passed_on) == ("MAV_CMD 31010", {})
    assert (told.home, told.speed, told.autopilot) == ((47.0, 8.0, 400.0), 5, "px4")


LANDING = {
    "altitudesAreRelative": True,
    "complexItemType": "fwLandingPattern",
    "landCoordinate": [47.01, 8.0, 2.0],
    "landingApproachCoordinate": [47.005, 8.0, 40.0],
    "loiterClockwise": False,
    "loiterRadius": 75,
    "stopTakingPhotos": True,
    "stopVideoPhotos": False,
    "type": "ComplexItem",
    "useLoiterToAlt": True,
    "version": 2,
}
"""With the keys of QGroundControl's LandingComplexItem.h."""


@pytest.mark.parametrize("kind", ["fwLandingPattern", "vtolLandingPattern"])
@pytest.mark.parametrize("loiters", [True, False])
def test_a_landing_pattern_stands_for_the_items_that_qgroundcontrol_makes_of_it(tmp_path, kind, loiters):
    pattern = LANDING | {"complexItemType": kind, "useLoiterToAlt": loiters}
    told = read(tmp_path, "l.plan", given.plan([*given.FLIGHT[:2], pattern]))
    start, stop, photos, approach, land = told.orders[2:]
    assert [start.name, stop.name, photos.name] == ["DO_LAND_START", "DO_SET_CAM_TRIGG_DIST", "IMAGE_STOP_CAPTURE"]
    assert (approach.number, approach.place) == (6, (47.005, 8.0, AboveHome(40.0)))
    assert (approach.kind, approach.radius) == ((Kind.LOITER, 75.0) if loiters else (Kind.WAYPOINT, None))
    assert (land.kind, land.place) == (Kind.LAND, (47.01, 8.0, AboveHome(2.0)))
    assert land.name == ("NAV_LAND" if kind == "fwLandingPattern" else "NAV_VTOL_LAND")
    moved = replace(land, place=(47.011, 8.0, AboveHome(2.0)))
    changed = tmp_path / "changed.plan"
    sky.write_waypoints(replace(told, orders=(*told.orders[:-1], moved)), changed)
    assert sky.read_waypoints(changed).orders == (*told.orders[:-1], moved)


def test_latitude_and_longitude_0_leave_the_place_to_ardupilot_and_are_a_place_for_px4(tmp_path):
    items = [given.item(22, 0, 0, 0, 0, 0, 0, 20), given.item(16, 0, 0, 0, 0, 0, 0, 20, number=2)]
    copter = read(tmp_path, "a.plan", given.plan(items, firmware=3))
    assert all(math.isnan(order.place[0]) and math.isnan(order.place[1]) for order in copter.orders)
    assert [order.place[2] for order in copter.orders] == [AboveHome(20.0)] * 2
    assert all(order.place[:2] == (0.0, 0.0) for order in read(tmp_path, "p.plan", given.plan(items)).orders)


def test_a_plan_of_2017_has_its_places_apart(tmp_path):
    old = given.item(16, 0, 0, 0, None, coordinate=[47.001, 8.002, 25])
    (order,) = read(tmp_path, "old.plan", given.plan([old])).orders
    assert order.place == (47.001, 8.002, AboveHome(25.0))


def test_a_fence_and_rally_points_are_read(tmp_path):
    ring = [[47.0, 8.0], [47.0, 8.1], [47.1, 8.1]]
    fence = {
        "circles": [{"circle": {"center": [47.0, 8.0], "radius": 80}, "inclusion": False, "version": 1}],
        "polygons": [{"polygon": ring, "inclusion": True, "version": 1}],
        "version": 2,
    }
    text = given.plan(given.FLIGHT, geoFence=fence, rallyPoints={"points": [[47.0, 8.0, 60]], "version": 2})
    told = read(tmp_path, "f.plan", text)
    assert told.fence.inside == (tuple(map(tuple, ring)),)
    assert told.fence.circles_outside == ((47.0, 8.0, 80.0),)
    assert told.rally == ((47.0, 8.0, AboveHome(60.0)),)


def test_a_file_of_mission_planner_is_read_row_by_row(tmp_path):
    told = read(tmp_path, "m.waypoints")
    assert kinds(told) == [Kind.TAKEOFF, Kind.WAYPOINT, Kind.LOITER, Kind.JUMP, Kind.WAYPOINT, Kind.LAND]
    takeoff, _, circle, jump, terrain, land = told.orders
    assert math.isnan(takeoff.place[0])
    assert (circle.turns, circle.radius) == (2.0, 25.0)
    assert (jump.to, jump.times) == (2, 1)
    assert (terrain.place[2], terrain.seconds) == (AboveGround(50.0), 1.5)
    assert math.isnan(land.place[1])
    assert told.home == (47.0, 8.0, 400.0)


def test_rows_count_in_their_order_whatever_their_numbers(tmp_path):
    renumbered = given.WPL.replace("\n5\t", "\n9\t").replace("\n6\t", "\n9\t")
    assert read(tmp_path, "odd.waypoints", renumbered).orders == read(tmp_path, "m.waypoints").orders


def test_rows_of_version_120_have_no_home_and_count_from_the_first_item(tmp_path):
    """As QGroundControl loads them: MissionController.cc, _loadTextMissionFile."""
    _, _, *rows = (line.split("\t") for line in given.WPL.splitlines())
    for number, row in enumerate(rows):
        row[0] = str(number)
        if row[3] == "177":
            row[4] = str(int(float(row[4])) - 1)
    text = "\n".join(["QGC WPL 120", *map("\t".join, rows)]) + "\n"
    told, known = read(tmp_path, "old.waypoints", text), read(tmp_path, "m.waypoints")
    assert (told.orders, told.home) == (known.orders, None)
    first = replace(told.orders[1], kind=Kind.WAYPOINT, item=None)
    sky.write_waypoints(replace(told, orders=(first, *told.orders)), tmp_path / "new.waypoints")
    again = read(tmp_path, "again.txt", (tmp_path / "new.waypoints").read_text())
    assert [order.to for order in again.orders if order.to is not None] == [
        order.to + 1 for order in known.orders if order.to is not None
    ]
    assert not read(tmp_path, "empty.txt", "QGC WPL 120\n").orders


def test_commands_that_are_passed_on_have_their_names(tmp_path):
    rows = ["189\t0\t0\t0\t0", "179\t1\t0\t0\t0", "93\t-1\t12\t30\t0", "60123\t0\t0\t0\t0"]
    text = given.WPL + "".join(f"{k}\t0\t2\t{row}\t0\t0\t0\t1\n" for k, row in enumerate(rows, 7))
    told = read(tmp_path, "o.waypoints", text)
    assert told.passed_on == {"DO_LAND_START": [7]}
    others = [(order.name, order.number) for order in told.orders if order.kind is Kind.OTHER]
    assert others == [("DO_SET_HOME", 8), ("NAV_DELAY", 9), ("MAV_CMD 60123", 10)]


@pytest.fixture
def mavlink():
    dialects = pytest.importorskip("pymavlink.dialects.v20.all", reason="reads .waypoints")
    return {number: entry.name.removeprefix("MAV_CMD_") for number, entry in dialects.enums["MAV_CMD"].items()}


def test_names_of_commands_are_those_of_mavlink(mavlink):
    from skyverse.orders.mavlink_items import MEANINGS

    assert {number: meaning.name for number, meaning in MEANINGS.items()} == {k: mavlink[k] for k in MEANINGS}


MOVING = re.compile("NAV_|GUIDED|REPOSITION|ORBIT|FOLLOW|EIGHT|ALT|DO_SET_.*MODE|TERMINATION|HOME|ORIGIN|AUX|SCRIPT|"
    "REVERSE|TRANSITION|ENGINE|ARM|REBOOT|SHUTDOWN|MOTOR|PARACHUTE|GOTO|AUTOTUNE|MISSION|USER|PAUSE|AROUND|INVERTED|"
    "FIXED_|EKF|POSITION|WIND|ACTUATOR_TEST|DEPLOY|FAILURE")  # fmt: skip
"""What names of commands have that may move a vehicle, its home or what it takes for its place."""


def test_every_command_is_followed_or_moves_nothing_or_is_told_as_one_that_may(tmp_path, mavlink):
    numbers = [number for number in mavlink if number not in range(5000, 5101)] + [0, 65000]
    rows = [given.item(number, 1, 1, 0, 0, 47.0, 8.0, 30, number=k) for k, number in enumerate(numbers, 1)]
    rows[numbers.index(601)]["params"][0] = 1
    told = read(tmp_path, "all.plan", given.plan(rows))
    names = {
        mavlink.get(number, f"MAV_CMD {number}"): order for number, order in zip(numbers, told.orders, strict=True)
    }
    passed = {name for name, order in names.items() if order.kind is Kind.PASSED_ON}
    assert {"DO_SET_SERVO", "DO_GRIPPER", "DO_LAND_START", "DO_WINCH", "DO_FENCE_ENABLE"} < passed
    assert not {name for name in passed if MOVING.search(name)}
    told_of = {name for name, order in names.items() if order.kind is Kind.OTHER}
    assert {"NAV_PAYLOAD_PLACE", "DO_SET_HOME", "DO_SET_MODE", "DO_FLIGHTTERMINATION", "MAV_CMD 65000"} < told_of


def test_jumps_to_tags_lead_to_the_first_item_with_the_tag(tmp_path):
    rows = [
        given.item(number, tag, 3, 0, 0, 0, 0, 0, frame=2) for number, tag in ((600, 7), (600, 8), (600, 8), (601, 8))
    ]
    told = read(tmp_path, "t.plan", given.plan([*given.FLIGHT[:3], *rows]))
    assert (told.orders[-1].kind, told.orders[-1].to, told.orders[-1].times) == (Kind.JUMP, 7, 3)


@pytest.mark.parametrize(("known", "unknown"), [("takePhoto", "loopTheLoop"), (">goHome<", ">goAnywhere<")])
def test_what_dji_names_and_nobody_knows_may_lead_anywhere(tmp_path, known, unknown):
    text = given.waylines()
    assert known in text
    told = read(tmp_path, "m.wpml.kmz", given.kmz(wpmz__waylines_wpml=text.replace(known, unknown)))
    assert {order.name for order in told.orders if order.kind is Kind.OTHER} == {"megaphone", unknown.strip("<>")}


def test_actions_that_nobody_knows_of_litchi_may_lead_anywhere(tmp_path):
    told = read(tmp_path, "a.csv", given.litchi([given.litchi_row(47, 8, 30, [(1, 0), (9, 0)])]))
    assert [(order.name, order.number) for order in told.orders if order.kind is Kind.OTHER] == [("action 9", 1)]


def test_waylines_are_what_the_drone_is_told(tmp_path):
    told = read(tmp_path, "m.wpml.kmz")
    assert told.home == (47.0, 8.0, None)
    assert (told.speed, told.autopilot) == (9.0, "dji")
    rise, *between, back = told.orders
    assert (rise.kind, rise.name, rise.place[2]) == (Kind.TAKEOFF, "safely", AboveHome(20.0))
    assert (back.kind, back.name) == (Kind.RETURN, "goHome")
    flown = [order for order in between if order.kind is Kind.WAYPOINT]
    assert [order.number for order in flown] == [1, 2, 3, 4]
    places = [(*place, AboveHome(height)) for place, height in zip(given.PLACES, given.HEIGHTS, strict=True)]
    assert [order.place for order in flown] == places
    assert [order.speed for order in flown] == [4.0, 5.0, 6.0, 7.0]
    assert [order.radius for order in flown] == [None, 5.0, 0.5, None]
    assert [order.seconds > 0 for order in flown] == [True, False, False, False]
    assert [order.curved for order in flown] == [False, False, False, True]
    done = [(order.number, order.kind, order.name) for order in between if order.kind is not Kind.WAYPOINT]
    assert done == [
        (2, Kind.DELAY, "hover"),
        (2, Kind.CAMERA, "takePhoto"),
        (3, Kind.CAMERA, "takePhoto"),
        (3, Kind.HEADING, "rotateYaw"),
        (3, Kind.OTHER, "megaphone"),
        (4, Kind.CAMERA, "takePhoto"),
    ]
    hover, _, every, yaw, _, end = (order for order in between if order.kind is not Kind.WAYPOINT)
    assert (hover.seconds, every.spacing, yaw.heading, end.spacing) == (4.0, 15.0, -90.0, 0.0)
    assert [order.item for order in told.orders] == list(range(len(told.orders)))


@pytest.mark.parametrize("finish", ["autoLand", "gotoFirstWaypoint", "noAction", "doSomething"])
def test_a_wayline_ends_as_it_says(tmp_path, finish):
    content = given.kmz(wpmz__waylines_wpml=given.waylines(finish=finish, globalRTHHeight=70))
    told = read(tmp_path, "end.kmz", content)
    kind = {"autoLand": Kind.LAND, "gotoFirstWaypoint": Kind.WAYPOINT, "doSomething": Kind.OTHER}.get(finish)
    last = told.orders[-1]
    assert (last.kind is kind and last.name == finish) if kind else last.number == 4
    assert finish != "gotoFirstWaypoint" or last.place == told.orders[1].place
    assert told.return_altitude == 70.0


def test_a_template_alone_tells_where_it_differs_from_waylines(tmp_path):
    told = read(tmp_path, "t.kmz", given.kmz(wpmz__template_kml=given.template()))
    flown = [order for order in told.orders if order.kind is Kind.WAYPOINT]
    assert [order.place[2] for order in flown] == list(map(AboveHome, given.HEIGHTS))
    assert {order.name for order in flown} == {given.STOP}
    common = given.template().replace("<wpml:useGlobalHeight>0", "<wpml:useGlobalHeight>1")
    told = read(tmp_path, "g.kmz", given.kmz(wpmz__template_kml=common))
    assert {order.place[2] for order in told.orders if order.kind is Kind.WAYPOINT} == {AboveHome(40.0)}


def test_heights_above_the_ellipsoid_come_down_to_the_sea_by_the_template_or_the_geoid(tmp_path):
    parts = {"wpmz__waylines_wpml": given.waylines("WGS84", raised=47.5)}
    told = read(tmp_path, "g.kmz", given.kmz(**parts), geoid=47.5)
    seas = [order.place[2] for order in told.orders if order.kind is Kind.WAYPOINT]
    assert seas == list(map(AboveSea, given.HEIGHTS))
    parts["wpmz__template_kml"] = given.template("EGM96", geoid=47.5)
    both = read(tmp_path, "t.kmz", given.kmz(**parts))
    assert [order.place[2] for order in both.orders if order.kind is Kind.WAYPOINT] == seas
    assert both.home == (47.0, 8.0, 400.0)
    parts["wpmz__template_kml"] = given.template("EGM96", geoid=0.0)  # heights that are copies tell nothing
    with pytest.raises(sky.InputError, match="geoid"):
        read(tmp_path, "c.kmz", given.kmz(**parts))


@pytest.mark.parametrize("version", [f"1.0.{k}" for k in range(7)])
def test_every_version_of_wpml_and_files_beside_the_folder_are_read(tmp_path, version):
    text = given.waylines().replace("wpmz/1.0.6", f"wpmz/{version}")
    told = read(tmp_path, "v.kmz", given.kmz(waylines_wpml=text))
    assert [order.place for order in told.orders[1:]] == [
        order.place for order in read(tmp_path, "m.wpml.kmz").orders[1:]
    ]


def test_litchi_tells_of_turns_actions_photos_and_what_it_looks_at(tmp_path):
    told = read(tmp_path, "m.csv")
    flown = [order for order in told.orders if order.kind is Kind.WAYPOINT]
    assert [order.place for order in flown] == [
        (47.001, 8.0, AboveGround(30.0)),
        (47.001, 8.002, AboveGround(31.5)),
        (47.002, 8.002, AboveHome(32.0)),
    ]
    assert [order.radius for order in flown] == [4.5, 0.0, 0.0]
    assert [order.speed for order in flown] == [5.5, 5.5, None]
    assert [order.heading for order in flown] == [90.0, 0.0, 0.0]
    rest = [order for order in told.orders if order.kind is not Kind.WAYPOINT]
    assert [(order.number, order.kind) for order in rest] == [
        (1, Kind.DELAY),
        (1, Kind.CAMERA),
        (2, Kind.GIMBAL),
        (2, Kind.HEADING),
        (2, Kind.GIMBAL),
        (2, Kind.CAMERA),
        (3, Kind.LOOK_AT),
        (3, Kind.CAMERA),
    ]
    assert (rest[0].seconds, rest[3].heading, rest[5].spacing, rest[7].spacing) == (2.5, 180.0, 20.0, 0.0)
    assert rest[6].place == (47.005, 8.005, AboveHome(0.0))


def test_litchi_in_feet_is_read_in_metres(tmp_path):
    feet = [name.replace("(m)", "(ft)").replace("(m/s)", "(mph)") for name in given.LITCHI_COLUMNS]
    first = read(tmp_path, "feet.csv", given.litchi(columns=feet)).orders[0]
    assert first.place[2].metres == pytest.approx(30 * 0.3048)
    assert (first.radius, first.speed) == (pytest.approx(4.5 * 0.3048), pytest.approx(5.5 * 1609.344 / 3600))


def test_the_reference_of_altitudes_is_that_of_the_file_or_else_the_given_one(tmp_path):
    assert read(tmp_path, "line.kml").orders[0].place == (47.001, 8.0, AboveSea(30.0))
    assert read(tmp_path, "points.kml").orders[2].place == (47.001, 8.002, AboveGround(32.0))
    assert read(tmp_path, "m.gpx").orders[1].place == (47.001, 8.002, AboveSea(431.5))
    bare = given.kml(given.kml_mark("Route", "LineString", "8,47,30 8.1,47,40"))
    assert read(tmp_path, "bare.kml", bare, altitude="home").orders[1].place == (47.0, 8.1, AboveHome(40.0))
    column = given.LITCHI_COLUMNS.index("altitudemode")
    lines = [line.split(",") for line in given.litchi().split("\r\n")[:-1]]
    lacking = "\n".join(",".join(cells[:column] + cells[column + 1 :]) for cells in lines)
    assert read(tmp_path, "bare.csv", lacking, altitude="home").orders[0].place[2] == AboveHome(30.0)
