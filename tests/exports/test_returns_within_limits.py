"""Ways home stay within bounds and below the ceiling with all that a UAV may stray by."""

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Bounds, Box, Origin, Terrain
from skyverse.exports import WAYS, Apart
from skyverse.exports.leg_space import Segments
from skyverse.exports.way_home_space import Lines, ReturnSpace, proven

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
ERROR = sky.TrackingError(horizontal=1.6, vertical=3.0)
NO_ERROR = sky.TrackingError()
FLAT = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=np.zeros((33, 33)), clearance=2.0)
STRAIGHT_ON = [(-100, 0, 30), (100, 0, 30)]


def straying(mission, error=ERROR):
    return handmade.with_uavs(mission, tracking_error=error)


def way_home(mission, folder, suffix="plan", **how):
    """How the only UAV of a mission returns, and all notes of the export in one text."""
    told = handmade.exported(mission, folder, suffix, **how)
    return told.back, told.said


def planned(error=ERROR, start=3.0, **fields):
    """A flight over a wall from near the ground, planned with a tracking error."""
    given = {
        "name": "wall",
        "bounds": {"min": (-300, -300, -50), "max": (300, 300, 150)},
        "clearance": 1.0,
        "terrain": FLAT,
        "lattice": {"step": (20, 20, 20)},
        "objective": {"unit": "metres"},
        "obstacles": (Box(min=(-10, -200, -50), max=(10, 200, 40)),),
        "uavs": ({"start": (-200, 0, start), "tracking_error": error, "max_speed": 8},),
        "targets": ({"position": (200, 0, 30)},),
        "frame": {"origin": {"latitude": 47, "longitude": 8, "altitude": 400, "geoid": 48}},
    }
    return sky.plan_mission(sky.Scenario.model_validate(given | fields), sky.Taut())


@pytest.mark.parametrize(
    ("suffix", "error"),
    [
        *(("plan", error) for error in (NO_ERROR, ERROR)),
        *(("waypoints", error) for error in (NO_ERROR, ERROR)),
        # near home it returns as high as it is: twice 3 m are more than it has above ground
        *(("wpml.kmz", error) for error in (NO_ERROR, sky.TrackingError(horizontal=1.6, vertical=0.7))),
    ],
)
def test_a_uav_that_strays_comes_home_from_everywhere_and_lands_on_its_pad(tmp_path, suffix, error):
    back, said = way_home(planned(error), tmp_path, suffix)
    assert all(gap.why == WAYS[-1] for gap in back.gaps)
    assert back.altitude >= 40 + 0.5 + error.vertical - 0.02
    assert ("and its tracking error" in said) == (error != NO_ERROR)


def test_a_flight_rises_straight_up_from_its_pad():
    flown = planned().trajectories[0]
    places = flown.at(np.linspace(flown.start, flown.end, 20_000)).position
    assert np.abs(places[places[:, 2] < 5.0, 0] + 200.0).max() < 1e-9


@pytest.mark.parametrize("error", [0.0, 3.0])
def test_a_return_exceeds_neither_the_bounds_nor_the_ceiling_by_what_the_uav_may_stray(tmp_path, error):
    wall = ((30, -200, -50), (31, 200, 40))
    flight = handmade.along([(0, 0, 10), (0, 250, 10), (60, 250, 10), (60, 0, 10)], 10)
    mission = handmade.mission([flight], boxes=[wall], clearance=4.0, origin=ORIGIN, terrain=FLAT)
    tube = sky.TrackingError(horizontal=0.0, vertical=error)
    for over, whole in ((0.3, True), (-0.2, False)):  # beside what it needs above the wall
        top = 40 + 2 + error + over + error
        bounds = Bounds(min=handmade.LOW, max=(300.0, 300.0, top))
        for limits in ({"bounds": bounds}, {"max_height": top}):
            back, said = way_home(straying(handmade.changed(mission, **limits), tube), tmp_path, "waypoints")
            higher = "max_height" in limits and not whole  # which is told
            assert (not back.gaps) == (whole or higher), (over, limits)
            assert ("held to the ceiling" in said) == higher
            assert higher or back.level + error <= top + 0.02


def test_a_flight_that_touches_the_bounds_and_the_ceiling_has_a_way_home(tmp_path):
    mission = handmade.mission([handmade.along([(-100, 0, 30), (-20, 0, 30)], 20)], origin=ORIGIN, terrain=FLAT)
    low, high = handmade.LOW, handmade.HIGH
    for limits in (
        {"bounds": Bounds(min=(low[0], 0.0, low[2]), max=high)},
        {"bounds": Bounds(min=(-100.0, *low[1:]), max=(-20.0, high[1], 30.0))},
        {"max_height": 30.05},
    ):
        back, _ = way_home(handmade.changed(mission, **limits), tmp_path)
        assert not back.gaps, limits


@pytest.mark.parametrize(("wider", "clear"), [(-1e-4, False), (1e-4, True)])
def test_no_return_is_proven_through_a_gap_that_is_too_narrow(wider, clear):
    """Half the clearance is kept, and lines are grown by 1 cm at least: a gap must be twice the sum."""
    gap = 1.0 + 0.01 + wider
    blocks = [((30, -299, -50), (31, -gap, 150)), ((30, gap, -50), (31, 200, 150))]
    mission = handmade.mission([handmade.along(STRAIGHT_ON, 10)], boxes=blocks, clearance=2.0, origin=ORIGIN)
    ends = np.array([[0.0, 0.0, 10.0], [60.0, 0.0, 10.0]])
    line = Lines(ReturnSpace(mission.scenario).obstacles, Segments(ends[:1], ends[1:], 0.01), np.array([0]))
    assert proven([line]) == clear
    assert line.free().tolist() == [clear]


def test_a_waypoint_file_for_dji_names_the_return_height_and_the_rise_that_were_proven(tmp_path):
    flight = handmade.along([(-20, 0, 0.5), (20, 0, 0.5)], 20)
    mission = handmade.mission([flight], origin=ORIGIN, boxes=[((-300, -300, 3.0), (300, 300, 5.0))])
    mission = handmade.with_uavs(mission, home=0.0)
    back, _ = way_home(mission, tmp_path, "wpml.kmz")
    text = handmade.waylines(tmp_path / "m.wpml.kmz")
    told = float(text.split("globalRTHHeight>")[1].split("<")[0])
    assert told == pytest.approx(back.altitude, abs=1e-4)
    rise = float(text.split("takeOffSecurityHeight>")[1].split("<")[0])
    assert rise == pytest.approx(back.plan.waypoints[0][2] - back.plan.home[2], abs=1e-4)
    low = handmade.changed(mission, bounds=Bounds(min=handmade.LOW, max=(300.0, 300.0, 1.9)), obstacles=())
    back, said = way_home(low, tmp_path, "wpml.kmz")
    assert len(back.gaps) == 1
    assert "no way home" in said


def test_pairs_are_judged_with_the_height_to_which_the_file_lets_them_climb_first(tmp_path):
    """UAV 2 passes 6 m above the place where UAV 1 takes off."""
    low = handmade.along([(0, 0, 1), (0, 100, 1)], 40)
    over = handmade.along([(-100, 0, 7), (100, 0, 7)], 40)
    mission = handmade.mission([low, over], origin=ORIGIN)
    mission = handmade.with_uavs(mission, home=0.0)
    for takeoff, apart in ((3.0, True), (7.0, False)):
        certificate, *_ = handmade.exported(mission, tmp_path, takeoff=takeoff, allow_close=True)
        (kind,) = certificate.apart.pairs.values()
        assert (kind is Apart.SPACE) == apart
        (first, _) = (back.plan for back in certificate.returns)
        assert first.waypoints[0][2] == takeoff


def test_nobody_lands_on_a_no_fly_zone(tmp_path, refuses):
    """A zone up to 20 m lies under the far end of the flight."""
    wall = ((30, -300, -50), (31, 200, 150))
    flight = handmade.along([(0, 0, 40), (0, 250, 40), (60, 250, 40), (60, 0, 40)], 10)
    mission = handmade.mission([flight], boxes=[wall], clearance=1.0, origin=ORIGIN)
    zone = Box(min=(40, -100, -50), max=(100, 299, 20), kind="no-fly zone", solid=False)
    mission = handmade.changed(mission, obstacles=(*mission.scenario.obstacles, zone))
    with refuses():
        sky.export(mission, tmp_path / "l.plan", sky.ExportOptions(end="land"))


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_of_an_aeroplane_it_is_told_from_when_to_when_no_way_home_is_proven(tmp_path, suffix):
    wing = sky.FixedWing(speed=15, turn_radius=40, climb=20)
    flight = handmade.along([(-150, 0, 60), (150, 0, 60)], 20)
    back, said = way_home(handmade.mission([flight], origin=ORIGIN, wing=wing), tmp_path, suffix)
    assert back is None
    assert "uav-1: no way home is proven of an aeroplane" in said
    assert [file.suffix for file in tmp_path.iterdir()] == [f".{suffix}"]  # no parameters of a multirotor


def returned(back, place):
    """Places on the way home from one place, but for the descent to the pad, where nobody strays."""
    goal = back.plan.home
    level = max(goal[2] + back.altitude, place[2])
    shares = np.linspace(0, 1, 300)[:, None]
    top, over = np.array([*place[:2], level]), np.array([*goal[:2], level])
    return np.concatenate([a + shares * (b - a) for a, b in ((place, top), (top, over))])


@pytest.mark.parametrize("seed", range(8))
def test_all_that_a_straying_uav_reaches_on_its_way_home_is_safe(tmp_path, seed):
    """Flights among towers over a hill, below a ceiling; whoever strays from the way home is judged by brute force."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(-320, 320, 33), np.linspace(-320, 320, 33), indexing="ij")
    hill = 30 * np.exp(-((x - 50) ** 2 + (y - 20) ** 2) / 80**2)
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=hill, clearance=3.0)
    error = sky.TrackingError(horizontal=float(rng.uniform(0, 2)), vertical=float(rng.uniform(0, 3)))
    clearance = 2.0
    towers = [
        (low := rng.uniform([-150, -150, -5], [120, 120, -5]), low + rng.uniform([5, 5, 40], [40, 40, 90]))
        for _ in range(8)
    ]
    corners = handmade.walk_among(rng, towers, clearance + 3.0, 4, [-200, -200, 40], [200, 200, 80], ground=0)
    most = float(rng.uniform(85, 110))
    mission = handmade.mission(
        [handmade.along(corners, 20)], boxes=towers, clearance=clearance, terrain=ground, origin=ORIGIN
    )
    mission = straying(handmade.changed(mission, max_height=most), error)
    back, _ = way_home(mission, tmp_path, ["plan", "waypoints"][seed % 2])
    flight, times = back.plan.predicted(), np.linspace(back.plan.arrivals[0], back.plan.arrivals[-1], 80)
    safe, wide = 0, np.array([error.horizontal, error.horizontal, error.vertical])
    for time, place in zip(times, flight.at(times).position, strict=True):
        if any(gap.begin - 0.5 <= time <= gap.end + 0.5 for gap in back.gaps):
            continue
        safe += 1
        points = returned(back, place)
        points = points + rng.uniform(-1, 1, points.shape) * wide * [np.sqrt(0.5), np.sqrt(0.5), 1]
        for low, high in towers:
            assert np.maximum(low - points, points - high).max(axis=1).min() >= 0.5 * clearance - 0.02
        height = points[:, 2] - handmade.under(mission.scenario, points)
        assert height.min() >= 3.0 - 0.5 * clearance - 0.03
        assert height.max() <= most + 0.03
        assert points[:, 2].max() <= handmade.HIGH[2] + 0.02
    assert safe > 20
