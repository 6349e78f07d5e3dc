"""Whether exported legs are clear as an autopilot flies them, by dense sampling on the globe."""

import json
from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin, Terrain, to_local, to_wgs84
from skyverse.exports import Apart, LegChecker, LegSpace
from woods import woods

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=52.0, longitude=4.37, altitude=10.0, geoid=43.0)
CLEARANCE_ALLOWANCE = 0.02


def flown(mission, route, above="amsl", steps=60):
    """Local metres of what an autopilot may fly: straight in latitude, longitude and altitude, corners cut anyhow."""
    scenario = mission.scenario
    origin = scenario.frame.origin

    def line(a, b):
        shares = np.linspace(0, 1, steps)[:, None]
        globe = to_wgs84(origin, np.stack([a, b]))
        points = to_local(origin, globe[0] + shares * (globe[1] - globe[0]))
        if above == "agl":
            ground = handmade.under(scenario, np.stack([a, b]))
            over = np.array([a[2], b[2]]) - ground
            points[:, 2] = handmade.under(scenario, points) + over[0] + shares[:, 0] * (over[1] - over[0])
        return points

    parts = [line(a, b) for a, b in zip(route.points, route.points[1:], strict=False)]
    turned = [route.points[0]] * 10
    for k in range(1, len(route.points) - 1):
        at, after = route.points[k], route.points[k + 1]
        shares = np.where(route.holds[k] > 0, 0.0, np.linspace(0.1, 1, 10))
        ways = [came - at for came in turned]
        turned = [
            at + way * min(1, share * route.radius / np.linalg.norm(way))
            for way, share in zip(ways, shares, strict=True)
        ]
        parts += [line(came, after) for came in turned]  # straight on to the next from wherever it turned
    return np.concatenate(parts)


def gaps(mission, points):
    """Metres of each point to the nearest box, along the axis where they are most, by brute force."""
    least = np.full(len(points), np.inf)
    for box in mission.scenario.obstacles:
        least = np.minimum(least, np.maximum(np.array(box.min) - points, points - np.array(box.max)).max(axis=1))
    return least


def around(box, clearance, height):
    """A path that touches the corners of a grown box."""
    (x0, y0, _), (x1, y1, _) = box
    x0, y0, x1, y1 = x0 - clearance, y0 - clearance, x1 + clearance, y1 + clearance
    return [(x0 - 20, (y0 + y1) / 2, height), (x0, y1, height), (x1, y1, height), (x1 + 20, (y0 + y1) / 2, height)]


@pytest.mark.parametrize("above", ["amsl", "home"])
@pytest.mark.parametrize("radius", [0.5, 2.0, 5.0, 40.0])
def test_a_path_that_touches_corners_is_moved_out_until_they_may_be_cut(above, radius):
    box = ((-10, -10, 0), (10, 10, 40))
    mission = handmade.mission([handmade.along(around(box, 1.0, 15.0), 10)], boxes=[box], clearance=1.0, origin=ORIGIN)
    (route,) = sky.routes(mission, altitude=above, radius=radius)
    points = flown(mission, route)
    assert gaps(mission, points).min() >= 1.0 - CLEARANCE_ALLOWANCE
    assert route.radius > 0.1
    assert len(route.points) <= 9
    np.testing.assert_allclose(route.points[[0, -1]], mission.trajectories[0].at([0, 30]).position, atol=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_routes_through_random_towers_are_clear_as_flown(seed):
    rng = np.random.default_rng(seed)
    boxes = []
    for _ in range(12):
        low = rng.uniform([-120, -120, -50], [100, 100, -50])
        boxes.append((low, low + rng.uniform([5, 5, 60], [30, 30, 140])))
    clearance = 1.0
    corners = handmade.walk_among(rng, boxes, clearance, 5, [-140, -140, 10], [140, 140, 100])  # often near by
    mission = handmade.mission([handmade.along(corners, 20)], boxes=boxes, clearance=clearance, origin=ORIGIN)
    (route,) = sky.routes(mission, radius=3.0)
    assert gaps(mission, flown(mission, route)).min() >= clearance - CLEARANCE_ALLOWANCE
    assert np.linalg.norm(route.points[-1] - corners[-1]) < 1e-9


def test_a_flight_with_bends_close_together_between_trunks_is_exported():
    mission = sky.plan_mission(woods(85, frame=sky.Frame(origin=ORIGIN)))
    assert mission.violations == ()
    (route,) = sky.routes(mission)
    points = flown(mission, route)
    for trunk in mission.scenario.obstacles:
        gap = np.hypot(*(points[:, :2] - trunk.centre).T) - trunk.radius
        assert gap.min() >= mission.scenario.clearance - CLEARANCE_ALLOWANCE
    legs = np.diff(route.waypoints, axis=0)
    way = points[-1] - points[0]
    assert (legs @ way > 0).all()


def test_a_bent_flight_in_the_open_takes_few_waypoints_near_it():
    mission = handmade.mission([handmade.bent((0, 0, 50), (100, 0, 50), (100, 100, 80), 20)], origin=ORIGIN)
    (route,) = sky.routes(mission, radius=2.0, takeoff=0)
    t = np.linspace(0, 20, 2001)
    curve = mission.trajectories[0].at(t).position
    points = np.concatenate([np.linspace(a, b, 400) for a, b in zip(route.points, route.points[1:], strict=False)])
    off = np.linalg.norm(curve[:, None] - points[None], axis=2).min(axis=1).max()
    assert off <= 4.01
    assert route.off == pytest.approx(off, abs=0.2)
    assert 3 <= len(route.points) <= 5
    (finer,) = sky.routes(mission, radius=0.2, takeoff=0)
    assert len(finer.points) > len(route.points)


def test_a_straight_flight_takes_its_start_a_takeoff_and_its_target():
    mission = handmade.mission([handmade.along([(0, 0, 50), (60, 0, 50), (100, 0, 50)], 20)], origin=ORIGIN)
    (route,) = sky.routes(mission)
    np.testing.assert_allclose(route.points, [(0, 0, 50), (0, 0, 53), (100, 0, 50)], atol=1e-9)
    assert route.takeoff == 3.0
    assert "3 waypoints" in route.sentence(mission.scenario)


def test_a_takeoff_ends_below_what_is_above_the_start():
    lid = ((-5, -5, 52.2), (5, 5, 60))
    flight = [handmade.along([(0, 0, 50), (60, 0, 50)], 20)]
    (route,) = sky.routes(handmade.mission(flight, boxes=[lid], origin=ORIGIN))
    assert route.takeoff == 1.5
    lid = ((-5, -5, 50.52), (5, 5, 60))
    (route,) = sky.routes(handmade.mission(flight, boxes=[lid], origin=ORIGIN))
    assert route.takeoff == 0.0


def test_legs_over_terrain_keep_their_height_over_every_summit():
    rng = np.random.default_rng(5)
    heights = rng.uniform(0, 30, (65, 65))
    ground = Terrain(origin=(-320.0, -320.0), step=(10.0, 10.0), heights=heights, clearance=5.0)
    corners = [(-200, -100, 60), (0, 50, 36), (200, -30, 60)]
    mission = handmade.mission([handmade.along(corners, 30)], terrain=ground, origin=ORIGIN)
    for above in ("amsl", "agl"):
        (route,) = sky.routes(mission, altitude=above)
        points = flown(mission, route, above, steps=2000)
        height = points[:, 2] - handmade.under(mission.scenario, points)
        assert height.min() >= 5.0 - CLEARANCE_ALLOWANCE
        assert points[:, 2].max() <= 150 + CLEARANCE_ALLOWANCE


def test_a_low_flight_over_a_summit_is_not_taken_for_clear():
    heights = np.zeros((65, 65))
    heights[32, 32] = 30.0
    ground = Terrain(origin=(-320.0, -320.0), step=(10.0, 10.0), heights=heights, clearance=5.0)
    mission = handmade.mission([handmade.along([(-200, 0, 34.5), (200, 0, 34.5)], 30)], terrain=ground, origin=ORIGIN)
    with pytest.raises(sky.InputError, match="5 m are required"):
        sky.routes(mission, takeoff=0)
    (route,) = sky.routes(
        mission.__class__(
            **{**vars(mission), "trajectories": (handmade.along([(-200, 0, 34.5), (0, 0, 35.0), (200, 0, 34.5)], 30),)}
        ),
        takeoff=0,
    )
    assert flown(mission, route, steps=2000)[:, 2].max() < 36


def off_line(legs, a, b):
    """How far a leg may be off the straight line."""
    return legs.deviations(np.stack([a, b]), 0.0, np.ones(2))[0]


@pytest.mark.parametrize("length", [500, 5_000, 40_000])
def test_long_legs_count_the_curvature_of_earth(length):
    low, high = (-50.0, -length - 50.0, -2000.0), (length + 50.0, length + 50.0, 3000.0)
    flight = handmade.along([(0, 0, 100), (length, length / 2, 100)], 3600)
    mission = handmade.mission([flight], origin=Origin(latitude=60, longitude=10, altitude=0), low=low, high=high)
    legs = LegChecker(LegSpace(mission.scenario, "amsl"))
    a, b = flight.at([0, 3600]).position
    shares = np.linspace(0, 1, 101)[:, None]
    globe = to_wgs84(mission.scenario.frame.origin, np.stack([a, b]))
    points = to_local(mission.scenario.frame.origin, globe[0] + shares * (globe[1] - globe[0]))
    off = np.linalg.norm(points - (a + shares * (b - a)), axis=1).max()
    assert off <= off_line(legs, a, b) <= 2 * off + 0.02


def test_long_legs_along_a_slope_count_that_the_ground_rises_beside_them():
    length, slope = 5_000.0, 2.0
    ground = Terrain(origin=(-6e3, -6e3), step=(12e3, 12e3), heights=[[12e3, -12e3], [12e3, -12e3]], clearance=5.0)
    a, b = np.array([0.0, 0.0, 100.0]), np.array([length, 0.0, 100.0])
    origin = Origin(latitude=60, longitude=10, altitude=0)
    mission = handmade.mission(
        [handmade.along([a, b], 400)], terrain=ground, origin=origin, low=(-5e3, -5e3, -9e3), high=(6e3, 5e3, 9e3)
    )
    globe = to_wgs84(origin, np.stack([a, b]))
    points = to_local(origin, globe[0] + np.linspace(0, 1, 101)[:, None] * (globe[1] - globe[0]))
    lower = 100 - (points[:, 2] - ground.height(points[:, :2]))
    assert lower.max() > 1.0  # the line in latitude and longitude is to the side where the ground is higher
    assert (
        lower.max()
        <= off_line(LegChecker(LegSpace(mission.scenario, "amsl")), a, b)
        <= 2 * lower.max() * (1 + 1 / slope)
    )


def test_scenarios_without_an_origin_say_how_to_give_one(tmp_path, refuses):
    mission = handmade.mission([handmade.along([(0, 0, 50), (60, 0, 50)], 20)])
    for suffix in ("plan", "waypoints", "wpml.kmz", "kml", "kmz", "geojson", "gpx", "geo.csv"):
        with refuses():
            sky.export(mission, tmp_path / f"m.{suffix}")
        assert sky.export(mission, tmp_path / f"m.{suffix}", sky.ExportOptions(origin=ORIGIN)) == [
            tmp_path / f"m.{suffix}"
        ]
    for suffix in ("path.json", "trajectory.yaml", "skybrush.zip", "csv", "waypoints.csv"):
        assert sky.export(mission, tmp_path / f"m.{suffix}") == [tmp_path / f"m.{suffix}"]


def test_routes_are_apart_only_if_their_straight_legs_are_on_schedule():
    east = handmade.along([(-100, 0, 50), (100, 0, 50)], 40)
    for begin, verdict in ((0.0, sky.Verdict.REFUTED), (25.0, sky.Verdict.PROVEN)):
        north = handmade.along([(0, -100, 50), (0, 100, 50)], 40, begin)
        mission = handmade.mission([east, north], origin=ORIGIN)
        assert sky.routes_apart(mission, sky.routes(mission)).verdict is verdict


def test_legs_above_ground_do_not_follow_a_valley_that_the_trajectory_crosses():
    heights = np.zeros((33, 33))
    heights[10:22] = -40 * np.sin(np.linspace(0, np.pi, 12))[:, None]
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=heights, clearance=5.0)
    mission = handmade.mission([handmade.along([(-250, 0, 30), (250, 0, 30)], 60)], terrain=ground, origin=ORIGIN)
    assert len(sky.routes(mission, altitude="amsl", takeoff=0)[0].points) == 2
    (route,) = sky.routes(mission, altitude="agl", takeoff=0)
    assert len(route.points) > 2
    assert np.abs(flown(mission, route, "agl", steps=500)[:, 2] - 30).max() <= route.off <= 15


def test_where_a_corner_cannot_be_cut_the_uav_stops_at_it_and_is_held_there(tmp_path):
    boxes = [((-60, 1.1, 0), (60, 60, 140)), ((-60, -60, 0), (-1.1, -1.1, 140)), ((1.1, -60, 0), (60, 1.1, 140))]
    corners = [(-50, 0, 50), (0, 0, 50), (0, -50, 50)]  # a lane 2.2 m wide that turns by a right angle
    mission = handmade.mission([handmade.along(corners, 20)], boxes=boxes, clearance=1.0, origin=ORIGIN)
    (route,) = sky.routes(mission, radius=2.0, takeoff=0)
    assert gaps(mission, flown(mission, route)).min() >= 1.0 - CLEARANCE_ALLOWANCE
    assert (route.holds > 0).tolist() == [False, True, False]
    np.testing.assert_allclose(route.points, corners, atol=1e-9)
    assert route.times[-1] == pytest.approx(40 + route.holds[1])
    assert "but at 1, where it stops" in route.sentence(mission.scenario)
    (file,) = sky.export(mission, tmp_path / "m.waypoints", sky.ExportOptions(takeoff=0))
    held = [float(row.split("\t")[4]) for row in file.read_text().splitlines()[1:] if row.split("\t")[3] == "16"]
    assert held[1:] == [route.holds[1], 0.0]
    assert sky.routes_apart(mission, [route]).verdict is sky.Verdict.PROVEN


def test_places_cut_off_at_1e_7_degrees_are_within_what_is_added_to_the_clearance():
    rng = np.random.default_rng(3)
    origin = Origin(latitude=0.0, longitude=20.0, altitude=0.0)
    mission = handmade.mission([handmade.along([(0, 0, 50), (60, 0, 50)], 20)], origin=origin)
    points = rng.uniform(-100, 100, (1000, 3))
    globe = to_wgs84(origin, points)
    globe[:, :2] = np.trunc(globe[:, :2] * 1e7) / 1e7  # as QGroundControl turns degrees into whole numbers
    off = np.linalg.norm(to_local(origin, globe) - points, axis=1).max()
    assert 0.014 < off <= off_line(LegChecker(LegSpace(mission.scenario, "amsl")), points[0], points[1])


def crossing(begin):
    east = handmade.along([(-100, 0, 50), (100, 0, 50)], 40)
    return handmade.mission([east, handmade.along([(0, -100, 50), (0, 100, 50)], 40, begin)], origin=ORIGIN)


def test_waypoints_of_uavs_that_would_meet_are_refused_unless_one_says_that_they_may(tmp_path):
    for suffix in ("plan", "waypoints", "wpml.kmz"):
        with pytest.raises(sky.InputError, match="give allow_close"):
            sky.export(crossing(0.0), tmp_path / f"m.{suffix}")
        assert not list(tmp_path.iterdir())
    told = handmade.exported(crossing(0.0), tmp_path, allow_close=True)
    assert len(told.files) == 2
    assert set(told.certificate.apart.pairs.values()) == {Apart.CLOSE}
    told = handmade.exported(crossing(25.0), tmp_path)
    assert [flight.legs_proven for flight in told.certificate.flights] == [True, True]
    assert "uav-1 and uav-2 keep" in told.said


def test_the_command_line_says_what_is_proven_of_waypoints(tmp_path, capsys):
    from skyverse.cli.export import PlaceOptions, export

    sky.write(crossing(25.0), tmp_path / "m.json")
    export(str(tmp_path / "m.json"), tmp_path / "m.plan", place=PlaceOptions(altitude="home"))
    out, said = capsys.readouterr()
    first = [line.split(" ")[0].strip(":") for line in said.splitlines()]
    assert first[:4] == ["UAV", "uav-1", "uav-2", "fleet"]
    heeded = [word for word in first[4:] if word.isupper()]
    assert heeded == sorted(heeded, key=["NOT", "WARNING", "ONLY", "BEFORE"].index)
    assert heeded.count("BEFORE") == 2  # homes and parameters
    assert first[4 + len(heeded) :] == ["--details", "Judged"]
    export(str(tmp_path / "m.json"), tmp_path / "m.plan", place=PlaceOptions(altitude="home"), details=True)
    out, said = capsys.readouterr()
    assert out.splitlines() == [str(tmp_path / f"m-uav-{k}.plan") for k in (1, 2)]
    assert said.count("straight legs proven") == 2
    assert "compare home, above mean sea level: uav-1 60.00 m, uav-2 60.00 m;" in said
    assert "uav-1 and uav-2 keep" in said
    assert "load the rates for PX4: " in said
    sky.write(crossing(0.0), tmp_path / "m.json")
    with pytest.raises(sky.InputError, match="give allow_close"):
        export(str(tmp_path / "m.json"), tmp_path / "m.plan")
    export(str(tmp_path / "m.json"), tmp_path / "m.plan", allow_close=True)


@pytest.mark.parametrize("suffix", ["plan", "waypoints", "wpml.kmz"])
def test_a_home_below_a_roof_is_refused_by_name(tmp_path, suffix, refuses):
    level = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=np.zeros((33, 33)), clearance=1.0)
    house = ((-5, -5, -2), (5, 5, 30))
    flight = [handmade.along([(0, 0, 31), (60, 0, 50)], 20)]
    mission = handmade.mission(flight, boxes=[house], terrain=level, origin=ORIGIN)
    with refuses():
        sky.export(mission, tmp_path / f"m.{suffix}", sky.ExportOptions(altitude="home"))
    assert sky.export(mission, tmp_path / f"m.{suffix}", sky.ExportOptions(altitude="amsl"))
    beside = handmade.mission(flight, boxes=[((6, 6, -2), (9, 9, 30))], terrain=level, origin=ORIGIN)
    assert sky.export(beside, tmp_path / f"m.{suffix}", sky.ExportOptions(altitude="home"))


@pytest.mark.parametrize("suffix", ["plan", "waypoints", "geo.csv"])
def test_heights_are_counted_from_the_home_that_the_scenario_says(tmp_path, suffix):
    raised = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=np.full((33, 33), 8.0), clearance=1.0)
    mission = handmade.mission([handmade.along([(0, 0, 31), (60, 0, 50)], 20)], terrain=raised, origin=ORIGIN)
    (uav,) = mission.scenario.uavs
    real = uav.model_copy(update={"home": -3.5})
    mission = replace(mission, scenario=mission.scenario.model_copy(update={"uavs": (real,)}))
    notes = []
    (file,) = sky.export(mission, tmp_path / f"m.{suffix}", sky.ExportOptions(altitude="home"), on_note=notes.append)
    if suffix == "plan":
        read = json.loads(file.read_text())["mission"]
        at = read["plannedHomePosition"][2]
        first = next(item["Altitude"] for item in read["items"] if item["command"] == 22)
    elif suffix == "waypoints":
        rows = [line.split("\t") for line in file.read_text().splitlines()[1:]]
        at = float(rows[0][10])
        first = next(float(row[10]) for row in rows if row[3] == "22")
    else:
        at, first = ORIGIN.altitude - 3.5, float(file.read_text().splitlines()[1].split(",")[4])
    assert at == pytest.approx(ORIGIN.altitude - 3.5, abs=1e-3)
    assert first == pytest.approx(31 + 3.5, abs=1e-3)
    assert suffix == "geo.csv" or f"uav-1 {ORIGIN.altitude - 3.5:.2f} m" in " ".join(notes)


def test_a_home_above_its_start_is_refused(refuses):
    with refuses(ValueError):
        sky.UAV(start=(0, 0, 2), home=3)


@pytest.mark.parametrize("seed", [seed for seed in range(24) if seed % 3 != 2])
def test_routes_of_random_missions_among_towers_are_clear_as_flown(seed):
    mission = handmade.random_mission(seed, towers=True)
    for route in sky.routes(mission, altitude=("amsl", "home")[seed % 3]):
        assert gaps(mission, flown(mission, route)).min() >= 0.5 - CLEARANCE_ALLOWANCE
