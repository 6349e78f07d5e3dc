"""The way home: returns from many instants of exported flights, flown by code of the tests, against brute force."""

import json
import zipfile

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin, Terrain, TrackingError
from skyverse.exports import WAYS

pytestmark = pytest.mark.usefixtures("unjudged")

pytest.importorskip("pyproj", reason="an independent geodesy")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
NO_ERROR = TrackingError()
RIM = [(np.cos(angle), np.sin(angle)) for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False)]
PATH = [(0, 10), (0, 70), (1000, 70), (1000, 15)]  # how far from home, how high above it, metres


def return_settings(folder, suffix):
    """The return altitude above home, from the files, none of which has rally points."""
    if suffix == "wpml.kmz":
        with zipfile.ZipFile(folder / "m.wpml.kmz") as archive:
            text = archive.read("wpmz/waylines.wpml").decode()
        return float(text.split("globalRTHHeight>")[1].split("<")[0])
    values = handmade.parameters(folder, suffix)
    if suffix == "plan":
        assert values["RTL_TYPE"] == values["RTL_CONE_ANG"] == 0
        assert not json.loads((folder / "m.plan").read_text())["rallyPoints"]["points"]
        return values["RTL_RETURN_ALT"]
    assert {values[name] for name in ("RTL_CONE_SLOPE", "RTL_CLIMB_MIN", "RTL_ALT_FINAL", "RTL_ALT_TYPE")} == {0}
    return values["RTL_ALT"] / 100


def way_home(at, home, altitude):
    """Places on the way home from one place: up, straight to above home, down to 2 m above the ground there."""
    level = max(home[2] + altitude, at[2])
    shares = np.linspace(0, 1, 400)[:, None]
    top, over = np.array([*at[:2], level]), np.array([*home[:2], level])
    low = np.array([*home[:2], min(home[2] + 2.0, level)])
    return np.concatenate([a + shares * (b - a) for a, b in ((at, top), (top, over), (over, low))])


def least_gap(mission, points, error=NO_ERROR):
    """The least distance of points, or of cylinders about them, from any box, outside; metres."""
    least = np.inf
    for box in mission.scenario.obstacles:
        off = np.maximum(np.array(box.min) - points, points - np.array(box.max))
        level = np.hypot(*np.maximum(off[:, :2], 0).T) - error.horizontal
        upright = off[:, 2] - error.vertical
        outside = np.hypot(np.maximum(level, 0), np.maximum(upright, 0))
        inside = np.maximum(np.maximum(off[:, 0], off[:, 1]), off[:, 2])
        least = min(least, float(np.where(outside > 0, outside, np.minimum(inside, 0)).min()))
    return least


def called_back(place, error):
    """Where a UAV may be, off its path by its tracking error, when it is called back at a place of its path, (n, 3)."""
    if error == NO_ERROR:
        return [place]
    h, v = error.horizontal, error.vertical
    return [place + np.array([h * x, h * y, z]) for x, y in RIM for z in (-v, v)]


def instants(mission, plan_of, count=60):
    """Times and places of the flight as it is predicted."""
    flight = plan_of.predicted()
    times = np.linspace(plan_of.arrivals[0], plan_of.arrivals[-1], count)
    return times, flight.at(times).position


def check(mission, folder, suffix):
    """Compare what an export says of the way home with returns from many instants; return how many were safe."""
    certificate, *_ = handmade.exported(mission, folder, suffix)
    (back,) = certificate.returns
    altitude = return_settings(folder, suffix)
    assert altitude == pytest.approx(back.altitude, abs=0.01)
    scenario, home = mission.scenario, back.plan.home
    safe, error = 0, scenario.uavs[0].tracking_error
    for time, place in zip(*instants(mission, back.plan), strict=True):
        if any(gap.begin - 0.5 <= time <= gap.end + 0.5 for gap in back.gaps):
            continue
        for at in called_back(place, error):
            points = way_home(at, home, altitude)
            climb = least_gap(mission, points[:400], error.model_copy(update={"vertical": 0.0}))  # it does not sink
            gap = min(climb, least_gap(mission, points[400:], error))
            assert gap >= 0.5 * scenario.clearance - 0.02, (time, place, at)
            assert points[:, 2].max() + error.vertical <= scenario.bounds.max[2] + 0.02
            if scenario.terrain is not None:
                assert_above_ground(scenario, place, points, error, home)
        safe += 1
    return safe


def assert_above_ground(scenario, place, points, error, home):
    """Returning from somewhere by its path, wherever it strays, a UAV keeps above ground, but over home."""
    climb, level = points[:400], points[400:800]
    kept = scenario.ground_clearance - 0.5 * min(scenario.clearance, scenario.ground_clearance)
    near = 0.5 * min(scenario.clearance, scenario.ground_clearance)
    for flown, least, sinks in ((climb, near, 0.0), (level, kept, error.vertical)):
        if flown is climb and min(np.hypot(*(place - one)[:2]) for one in (home, points[-1])) < 0.01:
            continue  # on the pad at home
        for around in (flown, *(flown + error.horizontal * np.array([x, y, 0]) for x, y in RIM)):
            assert (around[:, 2] - sinks - handmade.under(scenario, around)).min() >= least - 0.05, place


def over_a_wall(top, low=-50.0):
    wall = ((30, -200, low), (31, 200, top))
    corners = [(0, 0, 10), (0, 0, 70), (60, 0, 70), (60, 0, 10)]
    return handmade.mission(
        [handmade.along(corners, 10)], boxes=[wall], clearance=1.0, origin=ORIGIN, high=(300, 300, 150)
    )


def around_a_wall():
    """A wall up to the ceiling: from beyond it there is no straight way home."""
    corners = [(0, 0, 10), (0, 250, 10), (60, 250, 10), (60, 0, 10)]
    wall = ((30, -300, -50), (31, 200, 150))
    return handmade.mission([handmade.along(corners, 10)], boxes=[wall], clearance=1.0, origin=ORIGIN)


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_the_return_altitude_is_above_what_stands_between_the_flight_and_home(tmp_path, suffix):
    certificate, notes, _ = handmade.exported(over_a_wall(50.0), tmp_path, suffix)
    (back,) = certificate.returns
    assert 50 + 0.5 <= 10 + back.altitude <= 62
    assert not back.gaps
    assert "it returns at" in " ".join(notes)
    assert "its way home is proven at every instant" in " ".join(notes)
    assert check(over_a_wall(50.0), tmp_path, suffix) == 60


@pytest.mark.parametrize("suffix", ["plan", "waypoints", "wpml.kmz"])
def test_the_export_says_from_when_to_when_no_way_home_is_proven_and_why(tmp_path, suffix):
    mission = around_a_wall()
    certificate, notes, _ = handmade.exported(mission, tmp_path, suffix)
    (back,) = certificate.returns
    assert back.gaps[-1].why == WAYS[1]
    assert back.gaps[-1].end == back.plan.arrivals[-1]
    assert "no way home is proven from t = " in " ".join(notes)
    assert check(mission, tmp_path, suffix) > 10
    times, places = instants(mission, back.plan)
    blind = [least_gap(mission, way_home(p, back.plan.home, back.altitude)) < 0 for p in places]
    lost = [any(gap.begin <= t <= gap.end for gap in back.gaps) for t in times]
    assert all(b <= one for b, one in zip(blind, lost, strict=True))


@pytest.mark.parametrize("suffix", ["plan", "waypoints", "wpml.kmz"])
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("error", [NO_ERROR, TrackingError(horizontal=2.0, vertical=1.0)], ids=["exact", "straying"])
def test_returns_among_random_towers_are_clear_where_the_export_says_so(tmp_path, suffix, seed, error):
    rng = np.random.default_rng(seed)
    boxes = []
    for _ in range(15):
        low = rng.uniform([-120, -120, -50], [100, 100, -50])
        boxes.append((low, low + np.r_[rng.uniform(5, 30, 2), rng.uniform(60, 195)]))
    clearance = 2.0
    corners = handmade.walk_among(rng, boxes, clearance, 4, [-140, -140, 10], [140, 140, 100], ground=-50)
    mission = handmade.mission(
        [handmade.along(corners, 20)], boxes=boxes, clearance=clearance, origin=ORIGIN, error=error
    )
    check(mission, tmp_path, suffix)


def beside_a_wall(away, error):
    """A flight along a wall that is higher than it, so far from its clearance and the tracking error."""
    boxes = [((0, 10, -50), (100, 12, 60))]
    y = 10 - 0.5 - error.horizontal - away
    return handmade.mission([handmade.along([(-10, y, 20), (110, y, 20)], 30)], boxes=boxes, origin=ORIGIN, error=error)


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_a_uav_that_is_called_back_where_it_strays_strays_again(tmp_path, suffix):
    """It returns from where it is, up to one tracking error off its path, and from that line it may be another off."""
    error = TrackingError(horizontal=2.0, vertical=0.5)
    assert check(beside_a_wall(2.2, error), tmp_path, suffix) == 60
    assert check(beside_a_wall(0.05, error), tmp_path, suffix) < 50


@pytest.mark.parametrize("error", [NO_ERROR, TrackingError(horizontal=2.0, vertical=1.0)], ids=["exact", "straying"])
@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_returns_over_hills_keep_above_ground(tmp_path, suffix, error):
    x, y = np.meshgrid(np.linspace(-320, 320, 33), np.linspace(-320, 320, 33), indexing="ij")
    heights = 60 * np.exp(-((x - 0) ** 2 + (y - 20) ** 2) / 60**2)
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=heights, clearance=5.0)
    corners = [(-200, 0, 20), (-200, 220, 20), (200, 220, 20), (200, 0, 20)]
    mission = handmade.mission([handmade.along(corners, 30)], terrain=ground, clearance=1.0, origin=ORIGIN, error=error)
    certificate, *_ = handmade.exported(mission, tmp_path, suffix)
    (back,) = certificate.returns
    assert not back.gaps
    assert back.altitude >= 50
    assert check(mission, tmp_path, suffix) == 60


@pytest.mark.parametrize("end", ["rtl", "land"])
def test_a_mission_ends_at_home_or_on_the_roof_below(tmp_path, end):
    mission = over_a_wall(50.0)
    roof = ((50, -10, -50), (70, 10, 0))
    mission = handmade.mission(
        list(mission.trajectories), boxes=[((30, -200, -50), (31, 200, 50)), roof], clearance=1.0, origin=ORIGIN
    )
    (file,) = sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end=end))
    last = json.loads(file.read_text())["mission"]["items"][-1]
    if end == "rtl":
        assert last["command"] == 20
    else:
        assert last["command"] == 21
        assert last["params"][6] == pytest.approx(0.0 - 10.0, abs=0.02)  # the roof, from home at z = 10


def test_a_return_from_where_there_is_no_way_home_is_refused(tmp_path, refuses):
    with refuses():
        sky.export(around_a_wall(), tmp_path / "m.wpml.kmz", sky.ExportOptions(end="rtl"))


def test_a_landing_beside_a_ledge_is_refused(tmp_path, refuses):
    ledge = ((60.5, -10, 0), (70, 10, 5))
    mission = over_a_wall(50.0)
    mission = handmade.mission(list(mission.trajectories), boxes=[ledge], clearance=1.0, origin=ORIGIN)
    with refuses():
        sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="land"))


def test_a_return_keeps_below_a_ceiling_above_ground_or_is_told_to_lead_higher(tmp_path, refuses):
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=np.zeros((33, 33)), clearance=5.0)
    wall = ((30, -300, -50), (31, 280, 50))
    corners = [(0, 0, 10), (0, 290, 10), (60, 290, 10), (60, 0, 10)]
    mission = handmade.mission(
        [handmade.along(corners, 20)], boxes=[wall], terrain=ground, clearance=1.0, origin=ORIGIN
    )
    for ceiling, higher in ((80.0, False), (40.0, True)):
        capped = handmade.changed(mission, max_height=ceiling)
        told = handmade.exported(capped, tmp_path)
        assert told.back.gaps == ()
        assert ("held to the ceiling of 40 m above ground" in told.said) == higher
        assert (told.back.altitude > ceiling + 0.5) == higher
    with refuses():
        sky.export(capped, tmp_path / "m.plan", sky.ExportOptions(end="rtl"))  # no emergency: it is planned


@pytest.mark.parametrize("apart", [10_000.0, -60_000.0, 60_000.0])
@pytest.mark.parametrize("goes", [1, -1])
def test_far_from_the_origin_a_way_home_keeps_clear_by_another_geodesy(tmp_path, apart, goes):
    ground = -(apart**2) / (2 * 6.37e6)
    low, high = (min(apart, apart + 1000 * goes) - 300, -300.0, ground - 50), (0, 300.0, ground + 200)
    high = (low[0] + 1600, *high[1:])
    wall = sorted([apart + 600 * goes, apart + 650 * goes])
    corners = [(apart, 0, ground + z) if not x else (apart + 1000 * goes, 0, ground + z) for x, z in PATH]
    boxes = [
        ((wall[0], -200.0, low[2]), (wall[1], 200.0, ground + 40)),
        ((wall[0], -200.0, ground + 95), (wall[1], 200.0, high[2])),
    ]
    mission = handmade.mission(
        [handmade.along(corners, 100)], boxes=boxes, clearance=1.0, origin=ORIGIN, low=low, high=high
    )
    certificate, *_ = handmade.exported(mission, tmp_path)
    (back,) = certificate.returns
    home = sky.to_wgs84(ORIGIN, back.plan.home[None])[0]
    returned = 0
    for time, place in zip(*instants(mission, back.plan), strict=True):
        if any(gap.begin - 0.5 <= time <= gap.end + 0.5 for gap in back.gaps):
            continue
        above = sky.to_wgs84(ORIGIN, place[None])[0]
        nearest = home
        level = max(above[2], nearest[2] + back.altitude)
        shares = np.linspace(0, 1, 400)
        ways = [
            (np.repeat(above[None, :2], 400, axis=0), above[2] + shares * (level - above[2])),
            (above[:2] + shares[:, None] * (nearest - above)[:2], np.full(400, level)),
            (np.repeat(nearest[None, :2], 400, axis=0), nearest[2] + 2 + shares * (level - nearest[2] - 2)),
        ]
        for degrees, altitudes in ways:
            points = handmade.local(ORIGIN, *degrees.T, altitudes)
            assert least_gap(mission, points) >= 0.5 - 0.02, (time, place)
        returned += 1
    assert returned > 10


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_a_uav_may_land_on_a_slope_from_however_far_it_returns(tmp_path, suffix):
    """The descent is above home, wherever the UAV comes from: the Earth's bend on its way does not widen it."""
    slope = Terrain(origin=(-300.0, -300.0), step=(100.0, 100.0), heights=np.tile(20.0 * np.arange(7), (34, 1)))
    scenario = sky.Scenario(
        name="slope",
        bounds=sky.Bounds(min=(-300, -300, 0), max=(3000, 300, 200)),
        terrain=slope,
        clearance=2.0,
        lattice=sky.Lattice(step=(50.0, 50.0, 20.0)),
        uavs=(sky.UAV(start=(0, 0, 120), tracking_error=sky.TrackingError(horizontal=1.6, vertical=3)),),
        targets=(sky.Target(position=(2700, 0, 120)),),
        frame=sky.Frame(origin=ORIGIN),
    )
    certificate, *_ = handmade.exported(sky.plan_mission(scenario, sky.Taut()), tmp_path, suffix)
    (back,) = certificate.returns
    assert back.everywhere


def from_under_a_slab():
    """A flight from below a slab that reaches up to the upper bound: a climb to any return altitude meets it."""
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=np.zeros((33, 33)), clearance=0.3)
    flight = handmade.along([(0, 0, 1.4), (60, 0, 1.4)], 20)
    return handmade.mission([flight], boxes=[((-4, -4, 2.15), (6, 4, 150))], terrain=ground, origin=ORIGIN)


def test_a_way_home_that_is_lost_at_the_end_of_the_take_off_is_lost_from_its_beginning(tmp_path):
    mission = handmade.mission([handmade.along([(0, 0, 20), (200, 0, 20)], 20)], origin=ORIGIN)
    certificate, notes, _ = handmade.exported(mission, tmp_path, "wpml.kmz")
    (back,), (flight,) = certificate.returns, certificate.flights
    (gap,) = back.gaps
    end = gap.end
    assert gap.begin == flight.gaps[0][0] == 0.0
    assert gap.why == WAYS[-1]
    assert back.plan.arrivals[0] < end < back.plan.arrivals[-1]
    assert flight.row[3] == f"NOT from 0 to {end:.2f} s, 30 m up"
    assert f"no way home is proven from t = 0 s to {end:.2f} s: {WAYS[-1]}" in " ".join(notes)
    assert "its way home is proven at every other instant" in " ".join(notes)


def test_where_no_instant_of_a_flight_has_a_way_home_that_is_told(tmp_path):
    certificate, notes, _ = handmade.exported(from_under_a_slab(), tmp_path, "wpml.kmz", takeoff=0)
    (flight,) = certificate.flights
    assert flight.gaps == ((0.0, flight.duration),)
    assert flight.row[3] == f"NOT proven, {certificate.returns[0].altitude:.4g} m up"
    assert f"no way home is proven from t = 0 s to {flight.duration:.2f} s: " in " ".join(notes)
    assert "its way home is proven" not in " ".join(notes)


LOW_FLIGHT = [(0, 0, 0), (0, 0, 12), (100, 0, 12)]
"""No higher than 12 m above home; nothing is in the way home at any altitude."""


@pytest.mark.parametrize("suffix", ["plan", "waypoints", "wpml.kmz"])
def test_a_uav_returns_at_a_usual_altitude_or_no_lower_than_it_flies_or_as_is_asked(tmp_path, suffix):
    flight = [handmade.along(LOW_FLIGHT, 20)]
    altitudes = []
    for high, asked in ((150.0, None), (20.0, None), (150.0, 12.5), (150.0, 45.0)):
        mission = handmade.mission(flight, origin=ORIGIN, low=(-300, -300, 0), high=(300, 300, high))
        certificate, *_ = handmade.exported(mission, tmp_path, suffix, return_altitude=asked)
        assert all(gap.why == WAYS[-1] for gap in certificate.returns[0].gaps)
        altitudes.append(return_settings(tmp_path, suffix))
    usual, below, *asked = altitudes
    assert usual == 30.0
    assert 12.0 <= below <= 20.0
    assert asked == [12.5, 45.0]


def test_an_altitude_that_is_asked_for_is_kept_and_told_where_it_leads_into_a_wall(tmp_path):
    mission = over_a_wall(50.0)
    certificate, *_ = handmade.exported(mission, tmp_path, return_altitude=20.0)
    assert certificate.returns[0].altitude == 20.0
    assert not certificate.flights[0].has_way_home
    assert handmade.exported(mission, tmp_path, return_altitude=60.0)[0].flights[0].has_way_home


@pytest.mark.parametrize(("suffix", "asked"), [("plan", 1.9), ("waypoints", 3000.1), ("wpml.kmz", float("nan"))])
def test_a_return_altitude_that_an_autopilot_does_not_keep_to_is_refused(tmp_path, suffix, asked, refuses):
    with refuses() as refused:
        handmade.exported(over_a_wall(50.0), tmp_path, suffix, return_altitude=asked)
    assert refused.value.sentence.field == "return_altitude"
    assert not list(tmp_path.iterdir())


def test_no_return_altitude_is_taken_for_an_aeroplane(tmp_path, refuses):
    wing = sky.FixedWing(speed=15, turn_radius=30, climb=15)
    plane = handmade.mission([handmade.along([(-100, 0, 50), (100, 0, 50)], 40)], origin=ORIGIN, wing=wing)
    with refuses():
        handmade.exported(plane, tmp_path, return_altitude=40.0)


def test_returns_that_have_a_gap_each_are_apart_where_there_is_room(tmp_path):
    """Each of two UAVs passes a gate that is too narrow for a return, whose error counts twice."""
    error = TrackingError(horizontal=0.8, vertical=0.5)
    gates = [(0, 8.4), (12.0, 30), (30, 44.2), (47.8, 60)]
    scenario = sky.Scenario(
        name="gates",
        bounds=sky.Bounds(min=(0, 0, 0), max=(60, 60, 60)),
        clearance=1.0,
        obstacles=[sky.Box(min=(28, low, 0), max=(32, high, 17)) for low, high in gates],
        lattice=sky.Lattice(step=(2, 2, 2)),
        uavs=[sky.UAV(start=(4, y, 1), home=1.0, separation=2.0, tracking_error=error) for y in (10.2, 46.0)],
        targets=[sky.Target(position=(56, y, 5)) for y in (10.2, 46.0)],
        frame=sky.Frame(origin=ORIGIN),
    )
    certificate, *_ = handmade.exported(sky.plan_mission(scenario, sky.Taut()), tmp_path)
    one, other = certificate.returns
    assert one.gaps
    assert other.gaps
    assert abs(one.altitude - other.altitude) >= 2.0 + 2 * 2 * error.vertical
