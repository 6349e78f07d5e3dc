"""Safe space: points, segments and distances against plain NumPy."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.space import tree, world
from worlds import ROOM, scenarios

FRACTIONS = np.linspace(0, 1, 401)


def depth(scenario, points):
    """How deep (n, 3) points are inside grown boxes (the deepest), or outside the bounds: positive is unsafe."""
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    worst = np.maximum(low - points, points - high).max(axis=1)
    for b in scenario.obstacles:
        a, z = np.array(b.min) - scenario.clearance, np.array(b.max) + scenario.clearance
        worst = np.maximum(worst, np.minimum(points - a, z - points).min(axis=1))
    return worst


def some_points(scenario, seed, count):
    """Points in and around the bounds, many of them on faces, edges and corners of grown boxes."""
    rng = np.random.default_rng(seed)
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    points = low + rng.uniform(-0.1, 1.1, (count, 3)) * (high - low)
    for axis in range(3):
        c = scenario.clearance
        planes = [v for b in scenario.obstacles for v in (b.min[axis] - c, b.max[axis] + c)]
        planes += [low[axis], high[axis]]
        special = rng.random(count) < 0.4
        points[special, axis] = rng.choice(planes, special.sum())
    return points


@given(scenarios(), st.integers(0, 2**32))
def test_a_point_is_free_where_brute_force_says_so(scenario, seed):
    points = some_points(scenario, seed, 300)
    inside = depth(scenario, points)
    free = sky.World(scenario).free(points)
    assert free[inside <= 1e-9].all()  # a face itself is free, and its points are rounded
    assert not free[inside > 6e-7].any()


@given(scenarios(), st.integers(0, 2**32))
def test_a_segment_is_free_where_dense_samples_of_it_are(scenario, seed):
    ends = some_points(scenario, seed, 160).reshape(2, 80, 3)
    a, b = np.clip(ends, scenario.bounds.min, scenario.bounds.max)
    samples = a[:, None] + FRACTIONS[None, :, None] * (b - a)[:, None]
    deepest = depth(scenario, samples.reshape(-1, 3)).reshape(len(a), -1).max(axis=1)
    free = sky.World(scenario).segments_free(a, b)
    assert not free[deepest > 6e-7].any()
    # between two samples a segment gets deeper by at most half their distance
    apart = np.linalg.norm(b - a, axis=1) / (len(FRACTIONS) - 1)
    assert free[deepest < -apart].all()


@given(scenarios(), st.integers(0, 2**32))
def test_a_segment_is_as_free_backwards(scenario, seed):
    a, b = some_points(scenario, seed, 160).reshape(2, 80, 3)
    a, b = (p[np.abs(depth(scenario, p)) > 1e-6] for p in (a, b))
    n = min(len(a), len(b))
    compiled = sky.World(scenario)
    np.testing.assert_array_equal(compiled.segments_free(a[:n], b[:n]), compiled.segments_free(b[:n], a[:n]))


@given(scenarios(), st.integers(0, 2**32))
def test_the_segment_from_a_point_to_itself_is_as_free_as_the_point(scenario, seed):
    points = some_points(scenario, seed, 100)
    compiled = sky.World(scenario)
    np.testing.assert_array_equal(compiled.segments_free(points, points), compiled.free(points))


@given(scenarios(), st.integers(0, 2**32))
def test_the_distance_is_the_smallest_over_the_boxes_and_negative_inside(scenario, seed):
    points = some_points(scenario, seed, 60)
    distances = sky.World(scenario).distance(points)
    if not scenario.obstacles:
        assert np.isposinf(distances).all()
        return
    for point, found in zip(points, distances, strict=True):
        true = np.inf
        for b in scenario.obstacles:
            low, high = np.array(b.min), np.array(b.max)
            nearest = np.clip(point, low, high)
            outside = np.sqrt(((point - nearest) ** 2).sum())
            depth_in = -min((point - low).min(), (high - point).min())
            true = min(true, outside if outside > 0 else depth_in)
        assert found == pytest.approx(true, abs=1e-12)


CUBE = sky.Scenario(
    name="cube",
    bounds=sky.Bounds(min=(-5, -5, -5), max=(5, 5, 5)),
    obstacles=(sky.Box(min=(-1, -1, -1), max=(1, 1, 1)),),
    clearance=0.3,
    lattice=sky.Lattice(step=(1, 1, 1)),
)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [-1, 1])
def test_touching_the_surface_is_free_and_a_millionth_inside_is_not(axis, side):
    compiled = sky.World(CUBE)
    point = np.full(3, 0.7)
    point[axis] = side * 1.3
    along = np.eye(3)[(axis + 1) % 3] * 4
    assert compiled.free(point).all()
    assert compiled.segments_free(point - along, point + along).all()
    point[axis] = side * (1.3 - 1e-6)
    assert not compiled.free(point).any()
    assert not compiled.segments_free(point - along, point + along).any()


@pytest.mark.parametrize("corner", list(itertools.product((-1.3, 1.3), repeat=3)))
def test_a_segment_may_touch_a_corner_or_run_along_an_edge_but_not_cut_it(corner):
    compiled = sky.World(CUBE)
    corner = np.array(corner)
    outward = np.sign(corner)
    across = np.array([outward[0], -outward[1], 0])
    assert compiled.segments_free(corner - across, corner + across).all()
    inside = corner - 1e-6 * outward
    assert not compiled.segments_free(inside - across, inside + across).any()
    edge = corner * [1, 1, -1]
    assert compiled.segments_free(corner, edge).all()


def test_the_bounds_are_free_and_a_millionth_outside_is_not():
    compiled = sky.World(CUBE)
    corners = np.array(list(itertools.product((-5, 5), repeat=3)), float)
    assert compiled.free(corners).all()
    assert not compiled.free(corners * (1 + 2e-7)).any()
    assert compiled.segments_free(corners, np.roll(corners, 1, axis=0))[[1, 3, 5, 7]].all()
    assert not compiled.segments_free([[-5, 4, 4]], [[5.000001, 4, 4]]).any()
    assert not compiled.free([[np.nan, 4, 4], [4, np.inf, 4]]).any()


def test_free_is_what_keeps_the_clearance_but_for_half_a_micrometre():
    near = sky.World(CUBE.model_copy(update={"clearance": 0.001}))
    assert near.free([[1.001, 0, 0], [1.001 - 4e-7, 0, 0]]).all()
    assert not near.free([[1.001 - 6e-7, 0, 0]]).any()


def test_why_a_point_is_unsafe_is_said_in_words():
    compiled = sky.World(CUBE)
    assert compiled.why_unsafe((3, 3, 3)) is None
    assert "obstacles[0] grown by the clearance of 0.3 m" in compiled.why_unsafe((1.2, 0, 0))
    assert "outside the bounds (-5, -5, -5) to (5, 5, 5)" in compiled.why_unsafe((6, 0, 0))


@pytest.mark.parametrize("points", [[1, 2], [[1, 2, 3, 4]], np.zeros((2, 2, 3))])
def test_points_that_are_not_rows_of_three_are_refused(points):
    with pytest.raises(ValueError, match="rows of x, y, z"):
        sky.World(CUBE).free(points)


def test_there_must_be_as_many_starts_as_ends():
    with pytest.raises(ValueError, match="1 ends and 2 starts"):
        sky.World(CUBE).segments_free([[0, 0, 0], [1, 1, 1]], [[0, 0, 0]])


@given(scenarios(), st.integers(0, 2**32))
def test_the_kernels_say_what_their_plain_python_says(scenario, seed):
    space = sky.World(scenario).space
    points = some_points(scenario, seed, 40)
    index, boxes, growth = space.tree, space.boxes, space.clearance
    for p, q in itertools.pairwise(points):
        assert tree.containing(index, boxes, growth, *p) == plain(tree.containing)(index, boxes, growth, *p)
        assert tree.crossed(index, boxes, growth, p, q) == plain(tree.crossed)(index, boxes, growth, p, q)
        assert tree.distance(index, boxes, *p) == pytest.approx(plain(tree.distance)(index, boxes, *p), abs=1e-15)
        assert world.point_free(space, p) == plain(world.point_free)(space, p)
        assert world.segment_free(space, p, q) == plain(world.segment_free)(space, p, q)


def plain(kernel):
    """The function itself, also where numba is switched off."""
    return getattr(kernel, "py_func", kernel)


def test_the_room_has_the_two_gaps_that_other_tests_count_on():
    compiled = sky.World(ROOM)
    assert compiled.segments_free([[2.5, 4.5, 2]], [[1, 4.5, 2]]).all()
    assert not compiled.segments_free([[1, 3, 2]], [[4, 3, 2]]).any()
