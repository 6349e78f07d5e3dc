"""The referee's certificate holds for all flights within a UAV's tracking error."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Terrain, Voxels
from skyverse.referee.clearance import judge_segments
from skyverse.referee.pads import parts_of_flight
from skyverse.referee.tube import raised_heights
from skyverse.referee.world import referee_world
from skyverse.space.tube import raised
from skyverse.space.world import World

ERRORS = [sky.TrackingError(horizontal=h, vertical=v) for h, v in ((0.5, 2.0), (1.7, 0.3), (0.0, 1.0), (1.0, 0.0))]
SHAPES = (
    Box(min=(3, 3, 0), max=(5, 6, 4)),
    Cylinder(centre=(12, 4), radius=1.5, low=1, high=6),
    Sphere(centre=(12, 13, 5), radius=2),
    Prism(vertices=[(15, 8), (18, 8), (16.5, 11)], low=0, high=3),
    Voxels(origin=(5, 8, 0), step=(1, 1, 1), occupied=np.ones((1, 2, 2), bool)),
)


def scenario(**changes):
    heights = np.random.default_rng(5).uniform(-1.5, 0.5, (6, 6))
    given = {
        "name": "tube",
        "bounds": {"min": (0, 0, 0), "max": (20, 20, 12)},
        "clearance": 0.4,
        "lattice": {"step": (1, 1, 1)},
        "obstacles": SHAPES,
        "terrain": Terrain(origin=(0, 0), step=(4, 4), heights=heights, clearance=0.2),
        "max_height": 11,
    }
    return sky.Scenario.model_validate(given | changes)


def clear(world, points):
    """Return which points (n, 3) the referee finds clear and in bounds."""
    found = [judge_segments(world, point[None], point[None]) for point in points]
    kept = np.array([one.incursion is None and bool(one.peaks.proven[0]) for one in found])
    return kept & (world.beyond_bounds(points) == 0)


@pytest.mark.parametrize("error", ERRORS, ids=str)
def test_all_positions_within_the_error_of_a_clear_one_are_clear(error):
    rng = np.random.default_rng(3)
    world = referee_world(scenario(), error)
    points = rng.uniform((0, 0, 0), (20, 20, 12), (150, 3))
    points = points[clear(world, points)]
    assert len(points) > 20
    turn, far = rng.uniform(0, 2 * np.pi, (2, len(points), 12))[0], np.sqrt(rng.uniform(0.5, 1, (len(points), 12)))
    up = rng.choice([-1.0, -0.3, 1.0], (len(points), 12)) * error.vertical
    aside = error.horizontal * far
    around = points[:, None] + np.stack([aside * np.cos(turn), aside * np.sin(turn), up], axis=2)
    assert clear(world.nominal, around.reshape(-1, 3)).all()


@pytest.mark.parametrize("error", ERRORS, ids=str)
def test_the_players_and_the_referee_agree_on_what_is_safe(error):
    points = np.random.default_rng(4).uniform((0, 0, 0), (20, 20, 12), (200, 3))
    judged = clear(referee_world(scenario(), error), points)
    assert (World(scenario(), error).free(points) == judged).all()
    assert 0 < judged.sum() < len(points)


@pytest.mark.parametrize("step", [(4.0, 4.0), (0.5, 3.0)])
@pytest.mark.parametrize("error", ERRORS, ids=str)
def test_the_ground_is_raised_as_the_players_raise_it(error, step):
    terrain = Terrain(origin=(0, 0), step=step, heights=np.random.default_rng(2).uniform(0, 5, (7, 9)))
    np.testing.assert_allclose(raised_heights(terrain, error), raised(terrain, error).heights, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("start", "top"),
    [
        ((1.5, 1.5, 0.5), 2.0),  # above the bounds' floor
        ((4, 4.5, 4.5), 6.4),  # above a roof
        ((12, 4, 9.5), 9.5),  # higher above a roof than the UAV strays
        ((12, 13, 7.45), 7.45),  # above a sphere, which grows by the diagonal of the error
        ((1.5, 1.5, 3), 3),  # it may stray from there
        ((0.1, 1, 3), 3),  # it may stray from nowhere above
    ],
)
def test_a_uav_lifts_off_to_the_lowest_place_from_which_it_may_stray(start, top):
    uav = sky.UAV(start=start, tracking_error=ERRORS[0])
    given = scenario(uavs=(uav,), terrain=None, max_height=None)
    planned = sky.Airspace(given).of(0).lifted(0, start)[2]
    assert planned == pytest.approx(top + 1e-3 * (top > start[2]), abs=1e-5)


@pytest.mark.parametrize("turn", [0, 20, 45, 70, 90])
@pytest.mark.parametrize("outside", [0.999, 1.001])
def test_uavs_keep_their_separation_wherever_they_are_within_their_errors(turn, outside):
    """Two UAVs fly side by side, one obliquely above the other."""
    across, above, error = 5.0, 10.0, sky.TrackingError(horizontal=1.6, vertical=3.0)
    aside, up = 2 * error.horizontal, 2 * error.vertical
    factor = 1 + np.hypot(aside / across, up / above)
    way = np.array([across * np.cos(np.radians(turn)), 0, above * np.sin(np.radians(turn))])
    places = np.array([30.0, 30, 20]), [30.0, 30, 20] + outside * factor * way
    flights = [sky.Trajectory(np.array([0.0, 2.0]), np.array([[place, [1, 0, 0]]])) for place in places]
    uavs = [sky.UAV(start=flight.coefficients[0, 0], separation=across, tracking_error=error) for flight in flights]
    bounds = sky.Bounds(min=(0, 0, 0), max=(100, 100, 100))
    given = sky.Scenario(name="beside", bounds=bounds, uavs=uavs, clearance=0.001, lattice=sky.Lattice(step=(1, 1, 1)))
    mission = sky.Mission(given, (None, None), (None, None), tuple(flights), (), sky.Provenance("", "", "", None, ""))
    proven = sky.certify(given, mission).apart.verdict is sky.Verdict.PROVEN
    assert proven == (outside > 1) == (not sky.find_conflicts(given, flights))
    x, _, z = outside * factor * way
    nearest = np.hypot(max(x - aside, 0) / across, max(z - up, 0) / above)
    assert nearest >= 1 or not proven


def test_a_violation_tells_what_is_left_of_the_distance_within_the_error_and_the_clearance_alone():
    given = scenario(terrain=None, max_height=None)
    judged = judge_segments(referee_world(given, ERRORS[0]), np.array([[2.2, 1, 2.0]]), np.array([[2.2, 8, 2.0]]))
    told = judged.incursion.sentence(given, "It", "there")
    assert told.startswith("It comes within 0.3 m of obstacle 0 there")
    assert told.endswith("0.4 m are required.")


def test_a_flight_up_and_down_one_line_is_judged_once():
    """Start and target lie on one vertical line, so that every piece is on both pads."""
    error = ERRORS[0]
    uav, target = sky.UAV(start=(1.5, 1.5, 0.5), tracking_error=error), sky.Target(position=(1.5, 1.5, 1.0))
    given = scenario(terrain=None, max_height=None, uavs=(uav,), targets=(target,))
    b = np.array([[[1.5, 1.5, low], [1.5, 1.5, low + 0.1]] for low in (0.5, 0.6, 0.7, 0.8, 0.9)])
    world = referee_world(given, error)
    ((judged_in, part),) = parts_of_flight(world, 0, 0, b, np.zeros(len(b)))
    assert (part.start, part.stop) == (0, 5)
    assert judged_in.error == sky.TrackingError()
