"""What players and referee both keep: each case is asked of both."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from depths import depth
from drawn_shapes import HOLE, SQUARE, along, places, worlds
from judged_clearance import LET_PASS, ROUNDING, world
from skyverse.referee.clearance import judge_segments
from skyverse.referee.pads import parts_of_flight
from skyverse.referee.sorties import Tour
from skyverse.referee.tracking_error import raised_heights
from skyverse.referee.world import referee_world
from skyverse.space.tracking_error import raised

EXACT = sky.TrackingError()


def players(scenario, a, b, error=EXACT):
    return sky.World(scenario, error).segments_free(a, b)


def referee(scenario, a, b, error=EXACT):
    judge, (a, b) = referee_world(scenario, error), (np.atleast_2d(np.array(end, float)) for end in (a, b))
    found = [judge_segments(judge, p[None], q[None]) for p, q in zip(a, b, strict=True)]
    inside = np.maximum(judge.beyond_bounds(a), judge.beyond_bounds(b)) <= LET_PASS
    return inside & np.array([one.incursion is None and bool(one.peaks.proven[0]) for one in found], dtype=bool)


both = pytest.mark.parametrize("free", [players, referee])


@both
@given(worlds(), places, places)
def test_segments_and_points_are_free_where_dense_samples_are(free, scenario, a, b):
    deep = depth(scenario, along(a, b))
    steep = 0.0 if scenario.terrain is None else np.abs(np.diff(scenario.terrain.heights, axis=0)).max() / 0.7
    steep += 0.0 if scenario.terrain is None else np.abs(np.diff(scenario.terrain.heights, axis=1)).max() / 1.2
    clear = free(scenario, a, b)[0]
    if deep.max() > LET_PASS + ROUNDING:
        assert not clear
    elif deep.max() < -np.linalg.norm(np.subtract(b, a)) / 2000 * (1 + steep) - ROUNDING:
        assert clear
    assert clear == free(scenario, b, a)[0] or abs(deep.max()) < 2e-6
    if not -ROUNDING < deep[0] <= LET_PASS + ROUNDING:
        assert free(scenario, a, a)[0] == (deep[0] < 0)


BOX = sky.Box(min=(2, 2, 2), max=(4, 4, 4))
YARD = sky.Prism(vertices=SQUARE, holes=(HOLE,), low=1, high=6)
ROUND = sky.Cylinder(centre=(5, 5), radius=2, low=0, high=8)
BALL = sky.Sphere(centre=(5, 5, 5), radius=2)
CELLS = sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=np.ones((9, 3, 3)))
SLOPE = sky.Terrain(origin=(0, 0), step=(10, 10), heights=[[0, 1], [2, 3]])
SADDLE = sky.Terrain(origin=(0, 0), step=(10, 10), heights=[[0, 4], [4, 0]])
LIMITS = {
    "the side of a box": (world(BOX), (0, 4.25, 3), (9, 4.25, 3), (0, -1, 0)),
    "an edge of a box": (world(BOX), (4.25, 4.25, 0), (4.25, 4.25, 9), (-1, -1, 0)),
    "a corner of a box": (world(BOX), (3.25, 5.25, 4.25), (5.25, 3.25, 4.25), (-1, -1, -1)),
    "the top of voxels": (world(CELLS), (0, 1, 3.25), (9, 2, 3.25), (0, 0, -1)),
    "the side of a cylinder": (world(ROUND), (7.25, 5, 0), (7.25, 5, 9), (-1, 0, 0)),
    "the top of a cylinder": (world(ROUND), (0, 5, 8.25), (9, 5, 8.25), (0, 0, -1)),
    "a sphere": (world(BALL), (0, 5, 7.25), (9, 5, 7.25), (0, 0, -1)),
    "the side of a prism": (world(YARD), (0, 1.75, 2), (9, 1.75, 5), (0, 1, 0)),
    "the roof of a prism": (world(YARD), (0, 3, 6.25), (9, 7, 6.25), (0, 0, -1)),
    "below a prism": (world(YARD), (0, 3, 0.75), (9, 7, 0.75), (0, 0, 1)),
    "a slope": (world(terrain=SLOPE), (0, 0, 0.25), (10, 10, 3.25), (0, 0, -1)),
    "the middle of a saddle": (world(terrain=SADDLE), (0, 0, 2.25), (10, 10, 2.25), (0, 0, -1)),
    "a ceiling": (world(terrain=SLOPE).model_copy(update={"max_height": 5}), (0, 0, 5), (10, 10, 8), (0, 0, 1)),
    "the bounds": (world(), (0, 0, 5), (10, 0, 5), (0, -1, 0)),
}


@both
@pytest.mark.parametrize("name", LIMITS)
def test_exactly_the_limit_is_free_and_some_micrometres_beyond_it_are_not(free, name):
    scenario, a, b, beyond = LIMITS[name]
    eased = 4e-7 if name != "the bounds" else 1e-10  # within which the clearance, but no bound, may be missed
    for off, expected in ((-1e-7, True), (0.0, True), (eased, True), (3e-6, False), (1e-3, False)):
        ends = np.array([a, b]) + off * np.array(beyond)
        assert free(scenario, *ends)[0] == expected, off
        assert free(scenario, *ends[::-1])[0] == expected, off


@both
def test_a_corridor_of_twice_the_clearance_is_open_and_a_narrower_one_is_shut(free):
    for gap, expected in ((0.5, True), (0.5 - 4e-6, False)):
        walls = sky.Box(min=(0, 0, 0), max=(10, 4, 10)), sky.Box(min=(0, 4 + gap, 0), max=(10, 10, 10))
        assert free(world(*walls), (0, 4 + gap / 2, 5), (10, 4 + gap / 2, 5))[0] == expected


# ---------------------------------------------------------------- tracking errors

ERRORS = [sky.TrackingError(horizontal=h, vertical=v) for h, v in ((0.5, 2.0), (1.7, 0.3), (0.0, 1.0), (1.0, 0.0))]
errors = pytest.mark.parametrize("error", ERRORS, ids=str)


def tube(**changes):
    given = {
        "name": "tube",
        "bounds": {"min": (0, 0, 0), "max": (20, 20, 12)},
        "clearance": 0.4,
        "lattice": {"step": (1, 1, 1)},
        "obstacles": (
            sky.Box(min=(3, 3, 0), max=(5, 6, 4)),
            sky.Box(min=(2, 12, 7), max=(9, 16, 7.2)),
            sky.Cylinder(centre=(12, 4), radius=1.5, low=1, high=6),
            sky.Sphere(centre=(12, 13, 5), radius=2),
            sky.Prism(vertices=[(15, 8), (18, 8), (16.5, 11)], low=0, high=3),
            sky.Voxels(origin=(5, 8, 0), step=(1, 1, 1), occupied=np.ones((1, 2, 2), bool)),
        ),
        "terrain": sky.Terrain(
            origin=(0, 0), step=(4, 4), heights=np.random.default_rng(5).uniform(-1.5, 0.5, (6, 6)), clearance=0.2
        ),
        "max_height": 11,
    }
    return sky.Scenario.model_validate(given | changes)


def strayed(error, count, rng):
    """Return random positions (count, 3) within an error of the origin, many of them on its rim."""
    turn, far = rng.uniform(0, 2 * np.pi, count), error.horizontal * np.minimum(rng.uniform(0, 1.5, count), 1.0)
    up = error.vertical * np.clip(rng.uniform(-1.5, 1.5, count), -1, 1)
    return 0.9999999 * np.column_stack([far * np.cos(turn), far * np.sin(turn), up])


@both
@errors
def test_all_positions_within_the_error_of_a_clear_one_are_clear(free, error):
    rng = np.random.default_rng(3)
    points = rng.uniform((0, 0, 0), (20, 20, 12), (150, 3))
    clear = points[free(tube(), points, points, error)]
    assert 20 < len(clear) < free(tube(), points, points).sum()
    around = np.repeat(clear, 12, axis=0) + strayed(error, 12 * len(clear), rng)
    assert free(tube(), around, around).all()


@both
@errors
def test_no_more_is_closed_than_the_error_asks_for(free, error):
    h, v = error.horizontal, error.vertical
    given = tube(terrain=None, max_height=None)
    for point, expected in (
        ((5.4 + h, 4.5, 5), True),  # the side of a box
        ((5.3 + h, 4.5, 3), False),
        ((4, 4.5, 4.4 + v), True),  # its roof
        ((4, 4.5, 4.3 + v), False),
        ((12, 5.9 + h, 3), True),  # the side of a cylinder, and what is above it
        ((12, 5.8 + h, 3), False),
        ((12, 4, 6.4 + v), True),
        ((12, 4, 6.3 + v), False),
        ((12, 13, 7.4 + np.hypot(h, v)), True),  # a sphere
        ((12, 13, 7.3 + np.hypot(h, v)), False),
        ((16.5, 7.6 - h, 4), True),  # the side of a prism
        ((16.5, 7.7 - h, 2), False),
        ((20 - h, 1 + h, 12 - v), True),  # the bounds
        ((20.1 - h, 1 + h, 12 - v), False),
        ((20 - h, 1 + h, 12.1 - v), False),
    ):
        assert free(given, point, point, error)[0] == expected, point


@errors
def test_the_players_and_the_referee_agree_on_what_is_safe(error):
    points = np.random.default_rng(4).uniform((0, 0, 0), (20, 20, 12), (200, 3))
    judged = referee(tube(), points, points, error)
    assert (players(tube(), points, points, error) == judged).all()
    assert 0 < judged.sum() < len(points)


@errors
@pytest.mark.parametrize("step", [(4.0, 4.0), (0.5, 3.0)])
def test_both_raise_the_ground_alike_and_nowhere_below_the_highest_within_the_error(error, step):
    rng = np.random.default_rng(2)
    terrain = sky.Terrain(origin=(0, 0), step=step, heights=rng.uniform(0, 5, (12, 9)))
    above = raised(terrain, error)
    np.testing.assert_allclose(raised_heights(terrain, error), above.heights, rtol=0, atol=1e-12)
    at = rng.uniform((0, 0), np.array(terrain.extent[1]), (4000, 2))
    moved = np.clip(at + strayed(error, 4000, rng)[:, :2], 0, terrain.extent[1])
    assert (above.height(at) >= terrain.height(moved) + error.vertical - 1e-9).all()


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
    given = tube(uavs=(uav,), terrain=None, max_height=None)
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
    given = tube(terrain=None, max_height=None)
    judged = judge_segments(referee_world(given, ERRORS[0]), np.array([[2.2, 1, 2.0]]), np.array([[2.2, 8, 2.0]]))
    told = judged.incursion.sentence(given, "It", "there")
    assert told.startswith("It comes within 0.3 m of obstacle 0 there")
    assert told.endswith("0.4 m are required.")


def test_a_flight_up_and_down_one_line_is_judged_once():
    """Start and target lie on one vertical line, so that every piece is on both pads."""
    error = ERRORS[0]
    uav, target = sky.UAV(start=(1.5, 1.5, 0.5), tracking_error=error), sky.Target(position=(1.5, 1.5, 1.0))
    given = tube(terrain=None, max_height=None, uavs=(uav,), targets=(target,))
    b = np.array([[[1.5, 1.5, low], [1.5, 1.5, low + 0.1]] for low in (0.5, 0.6, 0.7, 0.8, 0.9)])
    world = referee_world(given, error)
    ((judged_in, part),) = parts_of_flight(world, 0, Tour((0,)), b, np.zeros(len(b)))
    assert (part.start, part.stop) == (0, 5)
    assert judged_in.error == sky.TrackingError()


# ---------------------------------------------------------------- closed above

CLOSED = (
    sky.Box(min=(4, 4, 0), max=(6, 6, 2), closed_above=True),
    sky.Cylinder(centre=(5, 5), radius=1, low=0, high=2, closed_above=True),
    sky.Sphere(centre=(5, 5, 1), radius=1, closed_above=True),
    sky.Prism(vertices=((4, 4), (6, 4), (6, 6), (4, 6)), low=0, high=2, closed_above=True),
    sky.Voxels(origin=(4, 4, 0), step=(1, 1, 1), occupied=np.ones((2, 2, 2)), closed_above=True),
)


@both
@pytest.mark.parametrize("shape", CLOSED, ids=lambda shape: shape.shape)
@pytest.mark.parametrize("z", [1.5, 5.0, 10.0])
def test_nothing_may_fly_over_an_obstacle_that_is_closed_above(free, shape, z):
    opened = world(shape.model_copy(update={"closed_above": False}))
    assert not free(world(shape), (0, 5, z), (10, 5, z))[0]
    assert free(world(shape), (0, 3.74, z), (10, 3.74, z))[0]
    assert free(opened, (0, 5, z), (10, 5, z))[0] == (z > 2)


@pytest.mark.parametrize("clearance", [0.001, 0.5, 2.5])
@pytest.mark.parametrize("z", [0.0, 4.0, 10.0, 10.5, 11.5, 13.0])
def test_about_the_rim_of_a_sphere_that_is_closed_above_players_and_referee_agree(z, clearance):
    scenario = world(sky.Sphere(centre=(5, 5, z), radius=1.5, closed_above=True), clearance=clearance)
    rim = 1.5 + clearance
    out, up = np.meshgrid(rim + np.array([-0.3, -1e-4, 1e-4, 0.3]), np.r_[-1.01, -0.99, -0.5, -1e-3, 1e-3, 1] * rim + z)
    turn = np.linspace(0, 6, out.size)
    at = np.column_stack([5 + out.ravel() * np.cos(turn), 5 + out.ravel() * np.sin(turn), up.ravel()])
    at = at[((at >= 0.01) & (at <= 9.99)).all(axis=1)]
    assert (players(scenario, at, at) == referee(scenario, at, at)).all()


@both
@pytest.mark.parametrize("clearance", [0.001, 0.25])
def test_the_rim_of_a_sphere_that_is_closed_above_may_be_touched(free, clearance):
    scenario = world(sky.Sphere(centre=(5, 5, 5), radius=1, closed_above=True), clearance=clearance)
    rim = 6 + clearance
    for begin, end in (((rim, 5, 1), (rim, 5, 9)), ((rim, 1, 5), (rim, 9, 5)), ((rim, 1, 1), (rim, 9, 9))):
        assert free(scenario, begin, end)[0]
        assert not free(scenario, *(np.array([begin, end]) - (1e-4, 0, 0)))[0]


# ---------------------------------------------------------------- voxels


@both
@given(st.integers(0, 2**32), st.sampled_from([0.3, 0.7, 0.9]))
def test_no_border_between_voxels_is_open(free, seed, share):
    rng = np.random.default_rng(seed)
    occupied = rng.random(rng.integers(1, 4, 3)) < share
    scenario = world(sky.Voxels(origin=(1, 1, 1), step=(0.5, 1, 2), occupied=occupied), clearance=0.001, size=20.0)
    halves = np.argwhere(np.ones(2 * np.array(occupied.shape) + 1, dtype=bool))
    points = 1 + halves * (0.25, 0.5, 1)  # middles, faces, edges and corners of cells
    filled = np.pad(occupied, 1)
    shut = np.array([filled[tuple(slice((c + 1) // 2, c // 2 + 2) for c in half)].any() for half in halves])
    assert np.array_equal(~free(scenario, points, points), shut)


@both
def test_no_path_leads_along_the_border_of_voxels(free):
    grid = np.ones((4, 4, 4), dtype=bool)
    grid[0, 0, 0] = grid[3, 3, 0] = False  # so that it is not one box
    scenario = world(sky.Voxels(origin=(3, 3, 3), step=(1, 1, 1), occupied=grid), clearance=0.001)
    for y, z in ((5, 5), (4, 4), (4, 5.5), (5, 6)):
        assert not free(scenario, (1, y, z), (9, y, z))[0]
    assert free(scenario, (1, 5, 7.001), (9, 5, 7.001))[0]  # on the surface
