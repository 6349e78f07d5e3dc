"""What the check of missions must keep to, whatever the mission: lifts, jumps, formats, fences, frames and radii."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.waypoints import FindingKind
from skyverse.waypoints.report import as_data, finding_lines
from written_missions import item, litchi, litchi_row, plan

LEVEL = sky.AboveSea(400.0)
NORTH = 0.001
"""Degrees: some 111 m."""


def checked(folder, *contents, suffix="plan", **more):
    """Write missions, and judge them over level ground or in what is given."""
    files = []
    for k, content in enumerate(contents, 1):
        path = folder / f"m{k}.{suffix}"
        path.write_text(content)
        files.append(sky.read_waypoints(path))
    where = {"ground": LEVEL, "clearance": 2.0, "ground_clearance": 2.0, "vehicle": "camera"}
    settings = {"return_altitude": 40.0, **more.pop("settings", {})}
    where |= {"max_height": sky.AboveGround(120.0), **more}
    return sky.check_waypoints(files, sky.BuildOptions("site", **where), sky.FlightSettings(**settings))


def tour(*places, end=20):
    """Return items that take off, fly to places (degrees north and east of home, metres), and return."""
    flown = [item(16, 0, 0, 0, None, 47 + y, 8 + x, z, number=k) for k, (y, x, z) in enumerate(places, 2)]
    last = item(end, 0, 0, 0, None, 0, 0, 0, frame=2, number=len(places) + 2)
    return [item(22, 0, 0, 0, None, 47.0, 8.0, 30, number=1), *flown, last]


def wpl(items, home=(47.0, 8.0, 400.0)):
    """Return the same items as QGC WPL."""
    rows = [[0, 1, 0, 16, 0, 0, 0, 0, *home, 1]]
    rows += [
        [k, 0, one["frame"], one["command"], *(0 if value is None else value for value in one["params"]), 1]
        for k, one in enumerate(items, 1)
    ]
    return "\n".join(["QGC WPL 110", *("\t".join(map(str, row)) for row in rows)]) + "\n"


def wrong(fleet, number=0):
    return [(one.subject.value, one.items, one.what) for one in fleet.missions[number].findings if one.wrong]


def squares(folder, *boxes, name="zones.geojson"):
    """Write zones, each given by degrees south, west, north and east beside home."""
    made = []
    for s, w, n, e in boxes:
        ring = [[8 + x, 47 + y] for x, y in ((w, s), (e, s), (e, n), (w, n), (w, s))]
        made.append(
            {"type": "Feature", "properties": {"name": "Z"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
        )
    path = folder / name
    path.write_text(json.dumps({"type": "FeatureCollection", "features": made}))
    return path


@pytest.mark.parametrize("command", [23, 30, 34, 83, 92, 94, 113, 176, 179, 185, 186, 192, 42702, 42703, 65000])
def test_an_order_that_may_lead_elsewhere_refutes_a_mission(tmp_path, command):
    items = tour((NORTH, 0, 30), (NORTH, NORTH, 30))
    items.insert(2, item(command, 1, 0, 0, None, 47.5, 8.5, -50))
    fleet = checked(tmp_path, wpl(items), suffix="waypoints")
    assert wrong(fleet) == [("orders", (3,), fleet.missions[0].flown.waypoints.orders[2].name)]


@pytest.mark.parametrize("command", [181, 183, 189, 207, 211, 216, 600, 42600])
def test_an_order_that_moves_nothing_refutes_none(tmp_path, command):
    items = tour((NORTH, 0, 30), (NORTH, NORTH, 30))
    items.insert(2, item(command, 1, 0, 0, None, 0, 0, 0, frame=2))
    assert not wrong(checked(tmp_path, wpl(items), suffix="waypoints"))


@pytest.mark.parametrize("by_tag", [False, True])
def test_a_round_through_a_zone_is_found_however_the_jump_names_its_target(tmp_path, by_tag):
    items = tour((NORTH, 0, 30), (NORTH, NORTH, 30), (0, NORTH, 30))
    items[1:1] = [item(600, 5, 0, 0, 0, 0, 0, 0, frame=2)]
    items[-1:-1] = [item(601 if by_tag else 177, 5 if by_tag else 2, 1, 0, 0, 0, 0, 0, frame=2)]
    zone = squares(tmp_path, (0.0004, 0.0004, 0.0006, 0.0006))  # which only the way back to the first place meets
    found = wrong(checked(tmp_path, wpl(items), suffix="waypoints", zones=[zone]))
    assert ("legs", (5, 3), "no-fly zone Z") in found


places = st.tuples(
    st.floats(-0.004, 0.004), st.floats(-0.004, 0.004), st.floats(20, 60).map(lambda metres: round(metres, 1))
)


@given(st.lists(places, min_size=2, max_size=6), st.floats(0, 40))
def test_lifting_a_proven_mission_over_level_ground_keeps_it_proven(tmp_path_factory, found, more):
    folder = tmp_path_factory.mktemp("lift")
    assert not wrong(checked(folder, plan(tour(*found)), settings={"return_altitude": 60.0}))
    lifted = [(y, x, z + round(more, 1)) for y, x, z in found]
    assert not wrong(checked(folder, plan(tour(*lifted)), settings={"return_altitude": 60.0}))


def test_unrolled_jumps_are_flown_as_the_mission_that_is_written_out(tmp_path):
    way = [(NORTH, 0, 30), (NORTH, NORTH, 40), (0, NORTH, 50)]
    jumps = tour(*way)
    jumps.insert(4, item(177, 2, 2, 0, 0, 0, 0, 0, frame=2, number=5))
    jumps[5]["doJumpId"] = 6
    round_about, written = checked(tmp_path, plan(jumps)), checked(tmp_path, plan(tour(*way * 3)))
    flown, expected = (one.missions[0].flown.plan for one in (round_about, written))
    np.testing.assert_allclose(flown.waypoints, expected.waypoints)
    np.testing.assert_allclose(flown.arrivals, expected.arrivals)
    assert wrong(round_about) == wrong(written) == []
    assert [round_about.missions[0].flown.numbers(k) for k in range(1, 6)] == [(1, 2), (2, 3), (3, 4), (4, 2), (2, 3)]


@pytest.mark.parametrize("high", [50, 150])
def test_both_formats_of_a_mission_get_the_same_verdict(tmp_path, high):
    way = tour((NORTH, 0, 30), (NORTH, NORTH, high), (0, NORTH, 50))
    settings = {"autopilot": "px4", "speed": 5.0}
    found = [
        wrong(checked(tmp_path, text, suffix=suffix, settings=settings))
        for suffix, text in (("plan", plan(way)), ("waypoints", wpl(way)))
    ]
    assert found[0] == found[1]
    assert bool(found[0]) == (high == 150)


def test_a_zone_between_two_waypoints_is_found_at_them_with_its_name(tmp_path):
    zones = squares(tmp_path, (0.0004, -0.0002, 0.0006, 0.0002))
    found = checked(tmp_path, plan(tour((NORTH, 0, 30), (NORTH, NORTH, 30), (0, NORTH, 30))), zones=[zones])
    (leg,) = [one for one in found.missions[0].findings if one.subject.value == "legs"]
    assert leg.items == (1, 2)
    assert leg.what.endswith("Z")
    assert leg.clear_at is None  # it has no upper end
    assert 0.0004 < leg.place[0] - 47 < 0.0006
    assert not found.is_proven


@pytest.mark.parametrize(
    ("autopilot", "radius", "cut"), [("px4", 60, True), ("px4", 2, False), ("ardupilot", 60, False)]
)
def test_a_corner_is_cut_by_the_radius_that_the_autopilot_takes(tmp_path, autopilot, radius, cut):
    """ArduPilot drops the radius of items."""
    zones = squares(tmp_path, (NORTH - 0.0003, 0.0002, NORTH - 0.0002, 0.0003))
    way = tour((NORTH, 0, 30), (NORTH, NORTH, 30))
    way[1]["params"][1] = radius
    found = wrong(checked(tmp_path, plan(way), zones=[zones], settings={"autopilot": autopilot}))
    assert [one[:2] for one in found if one[0] == "corners"] == ([("corners", (2,))] if cut else [])
    assert not [one for one in found if one[0] == "legs"]


@pytest.mark.parametrize(("autopilot", "cut"), [("px4", 0.8), ("ardupilot", 0.0)])
def test_px4_may_end_a_take_off_by_the_whole_radius_of_its_altitudes_below_its_end(tmp_path, autopilot, cut):
    told = {"autopilot": autopilot, "altitude_radius": 0.8 if autopilot == "px4" else None}
    found = checked(tmp_path, plan(tour((NORTH, 0, 30))), settings=told)
    assert found.missions[0].flown.plan.takeoff_cut == cut


def ring(south, west, north, east, *, inclusion=True):
    corners = [[47 + y, 8 + x] for y, x in ((south, west), (south, east), (north, east), (north, west))]
    return {"inclusion": inclusion, "version": 1, "polygon": corners}


def fenced(*polygons, circles=(), firmware=12):
    fence = {"version": 2, "polygons": list(polygons), "circles": list(circles)}
    return plan(tour((NORTH, 0, 30), (NORTH, NORTH, 30)), firmware, geoFence=fence)


WIDE = ring(-0.0005, -0.0005, 0.0015, 0.0015)
WEST, EAST = ring(-0.0005, -0.0005, 0.0015, 0.0006), ring(-0.0005, 0.0004, 0.0015, 0.0015)


@pytest.mark.parametrize(
    ("fence", "legs"),
    [
        ([WIDE], []),
        ([ring(-0.0005, -0.0005, 0.0008, 0.0015)], [(1, 2), (2, 3)]),
        ([WEST, EAST], []),
        ([WIDE, ring(0.0004, -0.0001, 0.0006, 0.0001, inclusion=False)], [(1, 2)]),
        ([ring(0.0004, -0.0001, 0.0006, 0.0001, inclusion=False)], [(1, 2)]),
    ],
)
def test_px4_keeps_a_mission_in_any_area_of_its_fence_and_out_of_all_exclusions(tmp_path, fence, legs):
    found = wrong(checked(tmp_path, fenced(*fence)))
    assert [items for subject, items, what in found if subject == "legs" and what.startswith("fence")] == legs


def test_ardupilot_keeps_a_mission_in_all_areas_of_its_fence(tmp_path):
    found = wrong(checked(tmp_path, fenced(WEST, EAST, firmware=3)))
    assert {items for subject, items, what in found if what.startswith("fence")} >= {(1,), (1, 2), (2, 3)}


def test_a_leg_tells_all_kinds_of_things_that_it_meets(tmp_path):
    zones = squares(tmp_path, (0.0004, -0.0002, 0.0006, 0.0002))
    found = checked(tmp_path, fenced(ring(-0.0005, -0.0005, 0.0008, 0.0015)), zones=[zones]).missions[0].findings
    leg = [one for one in found if one.items == (1, 2) and one.subject.value == "legs"]
    assert {one.kind.value for one in leg} == {"zone", "fence"}
    assert all(one.deep > 0 for one in leg)
    south, north = (next(one.place[0] - 47 for one in leg if one.kind.value == kind) for kind in ("zone", "fence"))
    assert 0.0003 < south < 0.0007 < north


def test_circles_of_a_fence_count(tmp_path):
    circle = {"inclusion": True, "version": 1, "circle": {"center": [47.0, 8.0], "radius": 80.0}}
    found = wrong(checked(tmp_path, fenced(circles=[circle])))
    assert (("legs", (1, 2), "fence") in found, ("legs", (2, 3), "fence") in found) == (True, True)


def test_a_fence_binds_the_mission_of_its_own_file_alone(tmp_path):
    east = [(NORTH, 0.003, 30), (NORTH, 0.004, 30)]
    other = [item(22, 0, 0, 0, None, 47.0, 8.003, 30, number=1), *tour(*east)[1:]]
    text = json.loads(plan(other))
    text["mission"]["plannedHomePosition"] = [47.0, 8.003, 400.0]
    found = checked(tmp_path, fenced(WIDE), json.dumps(text))
    assert (wrong(found, 0), wrong(found, 1)) == ([], [])


def test_home_outside_of_the_fence_is_found_at_the_take_off(tmp_path):
    found = wrong(checked(tmp_path, fenced(ring(0.0005, -0.0005, 0.0015, 0.0015))))
    assert ("take-off", (1,), "fence") in found


def ridge(folder):
    """Write a ridge 60 m high, east of home, at longitude 8.002."""
    import rasterio

    n = 120
    east = np.arange(n)
    heights = np.broadcast_to(400 + 60 * np.exp(-(((east - 70) / 8.0) ** 2)), (n, n)).astype("float32")
    transform = rasterio.Affine(0.0001, 0, 7.995, 0, -0.0001, 47.006)
    with rasterio.open(
        folder / "dem.tif", "w", driver="GTiff", height=n, width=n, count=1, dtype="float32", crs="EPSG:4326",
        transform=transform,
    ) as file:  # fmt: skip
        file.write(heights, 1)
        file.units = ("metre",)
    return [folder / "dem.tif"]


def test_litchi_s_heights_above_ground_are_those_of_waypoints_alone_and_its_legs_are_straight(tmp_path):
    """Litchi takes home to be as high as the ground below the first waypoint: here it is 60 m higher."""
    rows = [litchi_row(47.0, longitude, 40.0) for longitude in (8.0, 8.004)]
    for home, lift in ((8.0, 0.0), (8.002, 60.0)):
        fleet = checked(
            tmp_path, litchi(rows), suffix="csv", ground=None, terrain=ridge(tmp_path),
            settings={"home": (47.0, home), "return_altitude": 90.0},
        )  # fmt: skip
        points, scenario = fleet.missions[0].flown.plan.waypoints, fleet.scenario
        above = points[-2:, 2] - scenario.terrain.height(points[-2:, :2])
        np.testing.assert_allclose(above, 40.0 + lift, atol=1.0)
        assert not any(visit.follows for visit in fleet.missions[0].flown.visits)
        assert any(subject == "legs" and what == "ground" for subject, _, what in wrong(fleet)) == (lift == 0.0)


def test_legs_that_follow_the_ground_are_flown_along_it(tmp_path):
    """Over a ridge that a straight leg would meet."""
    terrain, verdicts = ridge(tmp_path), {}
    for frame in (3, 10):
        way = tour((0, 0.004, 40), (NORTH, 0.004, 40))
        for one in way[1:3]:
            one["frame"] = frame
        fleet = checked(
            tmp_path, wpl(way), suffix="waypoints", ground=None, terrain=terrain,
            settings={"autopilot": "ardupilot", "return_altitude": 90.0},
        )  # fmt: skip
        verdicts[frame] = wrong(fleet)
        if frame == 10:
            mission = fleet.missions[0]
            points = mission.flown.plan.waypoints
            above = points[:, 2] - fleet.scenario.terrain.height(points[:, :2])
            assert above.min() > 29
            assert max(np.linalg.norm(b - a) for a, b in pairwise(points[1:])) < 120
            assert mission.flown.legs == 2
    assert ("legs", (1, 2), "ground") in verdicts[3]
    assert verdicts[10] == []


def test_two_missions_head_on_come_too_close_and_apart_in_height_do_not(tmp_path):
    east = [(NORTH, -0.002, 30), (NORTH, 0.002, 30)]
    found = {}
    for up in (0, 25):
        west = [(y, x, z + up) for y, x, z in reversed(east)]
        other = json.loads(plan([item(22, 0, 0, 0, None, 47.0, 8.0005, 30 + up, number=1), *tour(*west)[1:]]))
        other["mission"]["plannedHomePosition"] = [47.0, 8.0005, 400.0]
        fleet = checked(tmp_path, plan(tour(*east)), json.dumps(other))
        found[up] = [one for one in wrong(fleet) if one[0] == "separation"]
    assert found[0]


def test_circles_of_aeroplanes_are_no_circles_of_multirotors_and_heights_are_above_home(tmp_path):
    text = json.loads(
        plan([*tour((4 * NORTH, 0, 60))[:2], item(18, 2, 0, 200, 1, 47.0 + 4 * NORTH, 8.0, 60, number=3)])
    )
    text["mission"]["vehicleType"] = 1
    ring = [[47.0 + 3 * NORTH, 7.99], [47.0 + 3 * NORTH, 8.01], [47.0 + 5 * NORTH, 8.01], [47.0 + 5 * NORTH, 7.99]]
    text["geoFence"] = {"version": 2, "circles": [], "polygons": [{"version": 1, "inclusion": False, "polygon": ring}]}
    fleet = checked(tmp_path, json.dumps(text), vehicle="mapping")
    (mission,) = fleet.missions
    assert not any(one.kind is FindingKind.NO_CIRCLES for one in mission.findings)
    crossed = [line for line in finding_lines(fleet, 0) if "the fence" in line]
    assert crossed
    assert all(" 60.0 m above home" in line for line in crossed), crossed


@pytest.mark.parametrize("vehicle", ["camera", "mapping"])
def test_what_is_not_proven_of_aeroplanes_is_said(tmp_path, vehicle):
    text = json.loads(plan(tour((4 * NORTH, 0, 60), (4 * NORTH, 4 * NORTH, 60))))
    text["mission"]["vehicleType"] = 1
    fleet = checked(tmp_path, json.dumps(text), vehicle=vehicle)
    (mission,) = fleet.missions
    heeded = {one.subject.value for one in mission.findings if not one.wrong}
    assert heeded == ({"corners", "way home"} if vehicle == "mapping" else set())
    assert mission.is_proven == (vehicle == "mapping")
    (told,) = as_data(fleet)
    assert told["verdict"] == (
        "proven, but for corners and the take-off and the way home" if vehicle == "mapping" else "1 fault"
    )
    assert [told["table"][name].startswith("proven") for name in ("take-off", "end", "way home")] == [
        vehicle == "camera"
    ] * 3


@pytest.mark.parametrize(
    ("autopilot", "retraces", "ignored"),
    [("px4", False, False), ("ardupilot", False, False), ("px4", True, True), ("dji", False, True)],
)
def test_rally_points_to_which_it_may_return_are_found(tmp_path, autopilot, retraces, ignored):
    """PX4 and Copter return to the nearest of home and rally points; along a mission, and in DJI's, there are none."""
    rally = {"points": [[47.001, 8.001, 30], [47.002, 8.001, 30]], "version": 2}
    text = plan(tour((NORTH, 0, 30), (NORTH, NORTH, 30)), rallyPoints=rally)
    fleet = checked(tmp_path, text, settings={"autopilot": autopilot, "retraces": retraces})
    (told,) = as_data(fleet)
    assert wrong(fleet) == ([] if ignored else [("way home", (), "rally points")])
    assert [told["table"][row].startswith("NOT") for row in ("end", "way home")] == [not ignored] * 2


def test_returns_that_the_referee_does_not_prove_are_found(tmp_path, monkeypatch):
    monkeypatch.setattr("skyverse.exports.return_altitudes.proven", lambda lines: False)
    fleet = checked(tmp_path, plan(tour((NORTH, 0, 30), (NORTH, NORTH, 30))))
    assert {one[2] for one in wrong(fleet)} == {"the referee does not prove it"}


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_an_order_that_moves_home_is_found_by_its_number(tmp_path, suffix):
    """Autopilots return to where it says, and count heights above home from there."""
    items = tour((NORTH, 0, 30), (NORTH, NORTH, 40))
    items.insert(2, item(179, 0, 0, 0, 0, 47.001, 8.001, 430, frame=0, number=3))
    for number, one in enumerate(items, 1):
        one["doJumpId"] = number
    found = checked(tmp_path, plan(items) if suffix == "plan" else wpl(items), suffix=suffix)
    assert wrong(found) == [("orders", (3,), "DO_SET_HOME")]


@pytest.mark.parametrize(("vehicle", "fastest", "wrongs"), [(None, None, 0), (None, 10.0, 1), ("camera", None, 1)])
def test_no_vehicle_is_too_slow_unless_it_or_its_speed_is_named(tmp_path, vehicle, fastest, wrongs):
    way = tour((NORTH, 0, 30), (NORTH, NORTH, 30))
    way.insert(2, item(178, 1, 18, -1, 0, 0, 0, 0, frame=2, number=5))
    mission = checked(tmp_path, plan(way), vehicle=vehicle, max_speed=fastest).missions[0]
    found = [one for one in mission.findings if one.wrong]
    assert [one.kind.value for one in found] == ["speed"] * wrongs
    assert all(one.found == 18 and one.limit in (10, 15) for one in found)


def test_what_is_too_low_over_level_ground_is_told_as_too_near_to_the_ground(tmp_path):
    found = checked(tmp_path, plan(tour((NORTH, 0, 30), (NORTH, NORTH, 1)))).missions[0].findings
    legs = [one for one in found if one.subject.value == "legs"]
    assert {one.kind.value for one in legs} == {"ground"}
    assert {one.items for one in legs} == {(2, 3)}
    assert all(
        one.deep == pytest.approx(4.0, abs=0.1) and one.clear_at == pytest.approx(405.0, abs=0.1) for one in legs
    )


@pytest.mark.parametrize("home", [(95.0, 8.0), (47.0, 188.0), (47.0,), "here"])
def test_a_home_off_the_globe_is_refused(refuses, home):
    with refuses():
        sky.FlightSettings(home=home)


@pytest.mark.parametrize("y", [0.0001, NORTH])
def test_returns_of_dji_that_are_not_proven_near_home_alone_refute_nothing(tmp_path, y):
    fleet = checked(tmp_path, plan(tour((NORTH, 0, 30), (y, 0, 30))), settings={"autopilot": "dji"})
    (told,) = as_data(fleet)
    assert told["proven"]
    assert {one["kind"] for one in told["findings"] if not one["wrong"]} == {fleet.missions[0].back.gaps[0].why}
    assert told["verdict"] == "proven, but for returns within 50 m of home"
    assert told["table"]["way home"].startswith("ONLY")
    assert told["table"]["end"].startswith("ONLY") == (y < 0.0005)


@pytest.mark.parametrize(("up", "takeoff"), [(30, "proven"), (1, "NOT proven"), (-25, "NOT proven")])
def test_a_take_off_is_proven_only_where_it_leads_up_from_home(tmp_path, up, takeoff):
    way = tour((NORTH, 0, 30), (NORTH, NORTH, 30))
    way[0]["params"][6] = up
    (told,) = as_data(checked(tmp_path, plan(way)))
    assert told["table"]["take-off"] == takeoff
    assert told["proven"] == (up == 30)


def test_whatever_is_met_the_clearance_is_what_is_required_beyond_the_tracking_error(tmp_path):
    """At the level of home and over a ridge, in bounds and below them; a tower beside a leg, and one below it."""
    ridge_met = {"ground": None, "terrain": ridge(tmp_path), "settings": {"return_altitude": 90.0}}
    corners = [(x, y) for x, y in ((0.0009, 0.0004), (0.00105, 0.0004), (0.00105, 0.0006), (0.0009, 0.0006))]
    shapes = []
    for metres, aside in ((60, 0.0), (25.5, -0.003)):
        ring = [[8 + x + aside, 47 + y] for x, y in (*corners, corners[0])]
        where = {"type": "Polygon", "coordinates": [ring]}
        shapes.append(
            {"type": "Feature", "properties": {"name": f"{metres}", "height": f"{metres} m"}, "geometry": where}
        )
    (tmp_path / "towers.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": shapes}))
    cases = [
        (tour((NORTH, 0, 30), (NORTH, NORTH, 1)), {}),
        (tour((NORTH, 0, 30), (NORTH, NORTH, -20)), {}),
        (tour((0, 0.004, 40), (NORTH, 0.004, 40)), ridge_met),
        (tour((0, 0.001, 30), (NORTH, 0.001, 30), (NORTH, -0.002, 30), (0, -0.002, 30)), {"buildings": "towers"}),
    ]
    for way, more in cases:
        more |= {"buildings": [tmp_path / "towers.geojson"]} if "buildings" in more else {}
        fleet = checked(tmp_path, plan(way), **more)
        found = [one for one in fleet.missions[0].findings if one.deep is not None and one.kind.value != "ceiling"]
        assert found
        assert [one.limit for one in found] == [2.0] * len(found)


@pytest.mark.parametrize(("low", "told"), [(4, 7), (5, 3)])
def test_of_many_legs_on_end_that_meet_the_same_the_worst_is_told(tmp_path, low, told):
    heights = [30, *(1.0 + k % 2 for k in range(low)), 30, 30, 1.0, 30]
    fleet = checked(tmp_path, plan(tour(*((k * NORTH, 0, z) for k, z in enumerate(heights)))))
    found = [one for one in fleet.missions[0].findings if one.wrong]
    legs = [said for said in finding_lines(fleet, 0) if said.startswith("leg ")]
    assert len([one for one in found if one.subject.value == "legs"]) == low + 3
    assert len(legs) == told
    assert sum("on end" in said for said in legs) == (told == 3)


def test_a_mission_that_the_battery_does_not_give_is_refuted_and_what_is_left_of_it_is_told(tmp_path):
    near = checked(tmp_path, plan(tour((5 * NORTH, 0, 30), (NORTH, 0, 30))))
    assert FindingKind.BATTERY not in {one.kind for one in near.missions[0].findings}
    assert 0.5 < near.missions[0].summary.left < 0.9
    far = checked(tmp_path, plan(tour((50 * NORTH, 0, 30), (NORTH, 0, 30))))
    (found,) = (one for one in far.missions[0].findings if one.kind is FindingKind.BATTERY)
    assert found.wrong
    assert found.limit == pytest.approx(0.7 * 77 * 3600)
    taken = far.missions[0].summary  # of which the bound counts that the last metres of a landing are slow
    assert taken.energy + 3000 < taken.energy_bound <= found.found < 1.01 * taken.energy_bound
    assert far.missions[0].summary.left < 0.2
    (line,) = (line for line in finding_lines(far, 0) if "battery" in line)
    assert "53.9 Wh" in line
