"""Within 5 m of home a DJI aircraft lands where it is: that is clear down to the ground or roof there."""

import math
from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse.exports.level_roofs import roof_under_disc
from skyverse.model.frame import Origin
from skyverse.model.shapes import Terrain

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
AXIS = np.linspace(-320, 320, 65)


def plane(degrees, level):
    """Ground at a level below x = 0 that falls to the east."""
    heights = level - math.tan(math.radians(degrees)) * AXIS[:, None] * np.ones((1, 65))
    return Terrain(origin=(-320.0, -320.0), step=(10.0, 10.0), heights=heights, clearance=1.0)


def returned(folder, ground, boxes=(), error=None):
    flight = handmade.along([(0, 0, 12), (30, 0, 12)], 20)
    low = (-300, -300, -150)
    mission = handmade.mission([flight], boxes=boxes, clearance=1.0, origin=ORIGIN, terrain=ground, low=low)
    if error is not None:
        stray = sky.TrackingError(horizontal=error, vertical=0.2)
        uavs = tuple(uav.model_copy(update={"tracking_error": stray}) for uav in mission.scenario.uavs)
        mission = replace(mission, scenario=mission.scenario.model_copy(update={"uavs": uavs}))
    seen = []
    sky.export(mission, folder / "m.wpml.kmz", on_certificate=seen.append)
    (back,) = seen[0].returns
    assert back.proven
    return back


def lost_places(back):
    """Where along x it is between the times without a way home, (n, 2), with its run-up and its braking."""
    return back.plan.predicted().at(back.lost.ravel()).position[:, 0].reshape(-1, 2)


def lands(ground, boxes, x, y=0.0):
    """Whether the descent at x, y keeps half the clearance down to a clearance above what is there."""
    at = np.array([x, y])
    inside = [box for box in boxes if all(low <= k <= high for low, k, high in zip(box[0], at, box[1], strict=False))]
    surface = max([float(ground.height(at)), *(box[1][2] for box in inside)])
    z = np.linspace(surface + 1, 12, 400)
    points = np.column_stack([np.tile(at, (400, 1)), z])
    off = [np.maximum(np.array(low) - points, points - np.array(high)) for low, high in boxes]
    return all(np.linalg.norm(np.maximum(one, 0), axis=1).min() >= 0.5 for one in off)


ROOF = ((-6, -10, -21), (2, 10, 0))
LARGE = ((-20, -20, -21), (20, 20, 0))
POST = ((4.6, -1, -21), (4.8, 1, -3))
HALVES = ((-20, -20, -21), (1.234, 20, 0)), ((1.234, -20, -21), (20, 20, 0))
CASES = {
    "level ground": (plane(0, 0), ()),
    "a slope": (plane(14, 0), ()),
    "a slope and a post below home": (plane(40, 0), (((4.6, -1, -21), (4.8, 1, -1)),)),
    "a large roof": (plane(0, -20), (LARGE,)),
    "a roof of two halves": (plane(0, -20), HALVES),
    "the edge of a roof": (plane(0, -20), (ROOF,)),
    "a post beside a roof": (plane(0, -20), (ROOF, POST)),
}


@pytest.mark.parametrize("case", CASES)
def test_where_it_lands_at_once_it_is_clear_down_to_what_is_there(tmp_path, case):
    ground, boxes = CASES[case]
    back = returned(tmp_path, ground, boxes)
    lost = lost_places(back)
    clear = []
    places = np.linspace(0, 5, 1001)
    for x in places:
        clear.append(lands(ground, boxes, x))
        assert clear[-1] or ((lost[:, 0] <= x) & (x <= lost[:, 1])).any(), (x, lost)
    assert all(clear) == (len(lost) == 0)
    assert np.diff(lost).sum() <= (len(clear) - sum(clear)) * places[1] + 3.0  # not much more than those


ANGLES, STEP = np.linspace(0.0, 2 * np.pi, 24, endpoint=False), 0.05
STRAYING = {
    "level ground": (plane(0, 0), ()),
    "a large roof": (plane(0, -20), (LARGE,)),
    "a roof of two halves": (plane(0, -20), HALVES),
    "the edge of a roof": (plane(0, -20), (((-20, -20, -21), (4, 20, 0)),)),
    "a post on a roof": (plane(0, -20), (LARGE, ((5.2, -1, -21), (5.4, 1, 3)))),
    "a post beside the flight": (plane(0, -20), (LARGE, ((3.0, 1.8, -21), (3.2, 2.2, 3)))),
}


@pytest.mark.parametrize("error", [0.5, pytest.param(1.0, marks=pytest.mark.slow), 1.5])
@pytest.mark.parametrize("case", STRAYING)
def test_where_it_lands_at_once_off_its_flight_it_is_clear_too(tmp_path, case, error):
    """It is anywhere within its tracking error of its path, lands there if home is within 5 m, and strays meanwhile."""
    ground, boxes = STRAYING[case]
    lost = lost_places(returned(tmp_path, ground, boxes, error))
    off = error * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    bad = 0
    for x in np.arange(0.0, 8.0, STEP):
        aside = np.concatenate([off, off / 2, [[0.0, 0.0]]])
        around = np.array([x, 0.0]) + aside
        clear = all(lands(ground, boxes, *at) for at in (around + aside)[np.hypot(*around.T) <= 5.0])
        assert clear or ((lost[:, 0] <= x) & (x <= lost[:, 1])).any(), (x, lost)
        bad += not clear
    assert (bad == 0) == (len(lost) == 0)
    assert np.diff(lost).sum() <= bad * STEP + 4.0


SQUARE = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
SHAPES = (
    sky.Box(min=(0, 0, 0), max=(10, 10, 5)),
    sky.Prism(vertices=SQUARE, low=0.0, high=5.0),
    sky.Cylinder(centre=(5.0, 5.0), radius=5.0, low=0.0, high=5.0),
    sky.Voxels(origin=(0.0, 0.0, 0.0), step=(1.0, 1.0, 1.0), occupied=np.ones((10, 10, 5), dtype=bool)),
)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
@pytest.mark.parametrize(("x", "radius", "held"), [(5, 4.9, True), (5, 5.1, False), (8, 1.9, True), (8, 2.1, False)])
def test_a_roof_is_level_under_a_disc_that_does_not_reach_over_its_edge(shape, x, radius, held):
    assert roof_under_disc(shape, x, 5.0, radius) == (5.0 if held else None)


def test_a_roof_is_not_level_over_a_court_or_a_step():
    hole = ((4.0, 4.0), (6.0, 4.0), (6.0, 6.0), (4.0, 6.0))
    court = sky.Prism(vertices=SQUARE, holes=(hole,), low=0.0, high=5.0)
    assert roof_under_disc(court, 5.0, 5.0, 0.1) is None
    assert roof_under_disc(court, 2.0, 5.0, 1.9) == 5.0
    assert roof_under_disc(court, 2.0, 5.0, 2.1) is None
    stairs = np.ones((10, 10, 5), dtype=bool)
    stairs[7:, :, 4] = False
    steps = sky.Voxels(origin=(0.0, 0.0, 0.0), step=(1.0, 1.0, 1.0), occupied=stairs)
    assert roof_under_disc(steps, 5.0, 5.0, 1.9) == 5.0
    assert roof_under_disc(steps, 5.0, 5.0, 2.1) is None
    assert roof_under_disc(steps, 8.5, 5.0, 1.4) == 4.0
    assert roof_under_disc(sky.Sphere(centre=(5.0, 5.0, 0.0), radius=5.0), 5.0, 5.0, 0.1) is None
