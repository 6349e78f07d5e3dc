"""Nobody is sent to land on a slope or on the edge of a roof, and where a UAV lands is told."""

import math

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin, Terrain
from skyverse.exports.landing import Descents, why_not_level

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
AXIS = np.linspace(-320, 320, 65)


def ground(heights, clearance=1.0):
    return Terrain(origin=(-320.0, -320.0), step=(10.0, 10.0), heights=heights, clearance=clearance)


def slope(degrees):
    return ground(math.tan(math.radians(degrees)) * AXIS[:, None] * np.ones((1, 65)))


def mission_over(terrain, corners=((0, 0, 12), (0, 100, 12)), boxes=(), error=0.0):
    made = handmade.mission([handmade.along(corners, 20)], boxes=boxes, clearance=1.0, origin=ORIGIN, terrain=terrain)
    return handmade.with_uavs(made, tracking_error=sky.TrackingError(horizontal=error, vertical=error))


@pytest.mark.parametrize(("degrees", "lands"), [(14.5, True), (15.5, False), (43.0, False)])
def test_a_landing_on_a_slope_is_refused(tmp_path, degrees, lands, refuses):
    mission = mission_over(slope(degrees))
    if lands:
        handmade.exported(mission, tmp_path, end="land")
    else:
        with refuses():
            handmade.exported(mission, tmp_path, end="land")


def test_landings_of_many_are_refused_in_one_message(tmp_path, refuses):
    flights = [handmade.along([(x, 0, 20 + x / 2), (x, 100, 20 + x / 2)], 20) for x in range(0, 100, 20)]
    mission = handmade.mission(flights, clearance=1.0, origin=ORIGIN, terrain=slope(30.0))
    with refuses():
        handmade.exported(mission, tmp_path, end="land")


@pytest.mark.parametrize(("half", "error", "lands"), [(1.2, 0.0, True), (0.8, 0.0, False), (1.2, 1.5, False)])
@pytest.mark.parametrize("kind", ["box", "cylinder"])
def test_a_landing_on_a_roof_needs_a_roof_as_large_as_the_error(tmp_path, half, error, lands, kind, refuses):
    """The roof is 4 m above the ground."""
    mission = mission_over(slope(0), error=error)
    roof = sky.Box(min=(-half, 100 - half, -1), max=(half, 100 + half, 4))
    if kind == "cylinder":
        roof = sky.Cylinder(centre=(0.0, 100.0), radius=half, low=-1.0, high=4.0)
    mission = handmade.changed(mission, obstacles=(roof,))
    if lands:
        handmade.exported(mission, tmp_path, end="land")
    else:
        with refuses():
            handmade.exported(mission, tmp_path, end="land")


def test_homes_that_are_not_level_are_told_in_one_line_and_trees_are_told_to_be_unknown_once(tmp_path):
    notes = handmade.exported(mission_over(slope(30)), tmp_path).notes
    assert [note.partition(".")[0] for note in notes if "level" in note and "WARNING" in note] == [
        "WARNING: homes that are not level: uav-1"
    ]
    assert " ".join(notes).count("are unknown") == 1
    said = handmade.exported(mission_over(slope(3), boxes=[((-50, -50, 0), (-40, -40, 5))]), tmp_path).said
    assert "not level" not in said
    assert "unknown" not in said


@pytest.mark.parametrize("suffix", ["plan", "waypoints", "wpml.kmz"])
def test_of_homes_that_are_not_known_it_is_told_once(tmp_path, suffix):
    """Two UAVs start in mid-air, one on the lower bound, and one states its home."""
    starts = [(0, 0, 5), (40, 0, 7.25), (80, 0, 0), (120, 0, 5)]
    flights = [handmade.along([(x, y, z), (x, y, 20), (x, 100, 20)], 20) for x, y, z in starts]
    made = handmade.mission(flights, origin=ORIGIN, low=(-300, -300, 0))
    homes = zip(made.scenario.uavs, [None, None, None, 0.0], strict=True)
    mission = handmade.changed(made, uavs=tuple(uav.model_copy(update={"home": z}) for uav, z in homes))
    (told,) = [note for note in handmade.exported(mission, tmp_path, suffix).notes if "not known" in note]
    assert ": uav-1, uav-2. " in told
    wing = sky.FixedWing(speed=15.0, turn_radius=30.0, climb=15.0)
    plane = handmade.mission([handmade.along([(0, 0, 50), (100, 0, 50)], 20)], origin=ORIGIN, wing=wing)
    for known in (mission_over(slope(0)), plane):
        assert "not known" not in handmade.exported(known, tmp_path).said


@pytest.mark.parametrize(("high", "away", "lands"), [(0.4, 0.9, False), (0.4, 1.1, True), (1.9, 0.9, False)])
@pytest.mark.parametrize("error", [0.0, 0.5])
def test_a_landing_beside_something_low_is_refused(tmp_path, high, away, lands, error, refuses):
    post = ((away + error, 99, -1), (away + error + 1, 101, high))
    mission = mission_over(slope(0), boxes=[post], error=error)
    if lands:
        handmade.exported(mission, tmp_path, end="land")
    else:
        with refuses():
            handmade.exported(mission, tmp_path, end="land")


@pytest.mark.parametrize(
    ("box", "clear"),
    [
        (((0.5, 99, -1), (2, 101, 0.015)), True),
        (((0.5, 99, -1), (2, 101, 0.025)), False),
        *((((-1, 99, low), (1, 101, low + 0.3)), clear) for low, clear in ((0.5, False), (1.9, False), (2.1, True))),
    ],
)
def test_what_is_near_the_last_metre_of_a_landing_is_no_higher_than_rounding(box, clear):
    """A plate beside the place, or a canopy above it, which within twice the clearance of 1 m is too near."""
    descents = Descents(mission_over(slope(0), boxes=[box]).scenario)
    assert (descents.why_not_clear(0, np.array([0.0, 100.0, 1.0]), np.array([0.0, 100.0, 0.0])) is None) == clear


@pytest.mark.parametrize(("rise", "level"), [(0.12, True), (0.15, False), (0.25, False), (-0.12, True), (-0.2, False)])
def test_a_step_of_a_roof_may_rise_or_fall_as_a_slope_of_15_degrees_does(rise, level):
    """The step is half a metre away, where 15 degrees make 0.134 m and 30 degrees 0.289 m."""
    boxes = [((-5, 90, -1), (0.5, 110, 4)), ((0.5, 90, -1), (5, 110, 4 + rise))]
    scenario = mission_over(slope(0), boxes=boxes).scenario
    assert (why_not_level(scenario, 0, np.array([0.0, 100.0, 4.0])) is None) == level


@pytest.mark.parametrize(("slit", "lands"), [(0.15, False), (0.0, True)])
def test_a_landing_on_a_roof_with_a_slit_is_refused(tmp_path, slit, lands, refuses):
    halves = [((-5, 90, -1), (0.2, 110, 4)), ((0.2 + slit, 90, -1), (5, 110, 4))]
    mission = mission_over(slope(0), boxes=halves)
    if lands:
        handmade.exported(mission, tmp_path, end="land")
    else:
        with refuses():
            handmade.exported(mission, tmp_path, end="land")


HALVES = [((-30, 60, -1), (0.2, 140, 4)), ((0.2, 60, -1), (30, 140, 4))]
ON_ROOFS = {
    "a roof": ([((-30, 60, -1), (30, 140, 4))], 25.0, True),
    "two halves": (HALVES, 9.9, True),
    "two halves of a wide disc": (HALVES, 10.1, True),
    "a step down": ([HALVES[0], ((0.2, 60, -1), (30, 140, 3))], 5.0, False),
    "a chimney beside the place": ([*HALVES, ((0.5, 100, 4), (0.7, 100.2, 4.4))], 2.0, False),
    "a chimney on one roof": ([((-30, 60, -1), (30, 140, 4)), ((0.5, 100, 4), (0.7, 100.2, 4.4))], 2.0, False),
    "a bridge above": ([*HALVES, ((-30, 99, 20), (30, 101, 21))], 5.0, True),
}


@pytest.mark.parametrize("case", ON_ROOFS)
def test_whether_a_roof_is_level(case):
    boxes, error, level = ON_ROOFS[case]
    scenario = mission_over(slope(0), boxes=boxes, error=error).scenario
    assert (why_not_level(scenario, 0, np.array([0.0, 100.0, 4.0])) is None) == level


@pytest.mark.parametrize(("degrees", "level"), [(1.0, True), (8.0, True), (40.0, False)])
def test_a_roof_is_not_level_where_the_ground_rises_above_it(degrees, level):
    """Eight degrees reach 0.7 m above the roof, 5 m away, which is less steep than what is landed on."""
    boxes = [((-30, 60, -90), (30, 140, 0.01))]
    scenario = mission_over(slope(degrees), boxes=boxes, error=5.0).scenario
    assert (why_not_level(scenario, 0, np.array([0.0, 100.0, 0.01])) is None) == level
