"""Safe space: points, segments and distances against plain NumPy."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.space import tree, world
from worlds import ROOM, scenarios


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


def test_why_a_point_is_unsafe_is_said_in_words():
    compiled = sky.World(CUBE)
    assert compiled.why_unsafe((3, 3, 3)) is None
    assert "obstacles[0] grown by the clearance of 0.3 m" in compiled.why_unsafe((1.2, 0, 0))
    assert "outside the bounds (-5, -5, -5) to (5, 5, 5)" in compiled.why_unsafe((6, 0, 0))
    tube = sky.World(CUBE, sky.TrackingError(horizontal=1, vertical=2))
    grown = "grown by the clearance of 0.3 m and the tracking error of 1 m horizontally and 2 m vertically"
    assert grown in tube.why_unsafe((2, 0, 0))
    assert "too near the bounds" in tube.why_unsafe((4.5, 0, 0))


@pytest.mark.parametrize("points", [[1, 2], [[1, 2, 3, 4]], np.zeros((2, 2, 3))])
def test_points_that_are_not_rows_of_three_are_refused(points, refuses):
    with refuses():
        sky.World(CUBE).free(points)


def test_there_must_be_as_many_starts_as_ends(refuses):
    with refuses():
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
