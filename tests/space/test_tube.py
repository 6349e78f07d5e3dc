"""A nominal position is safe if all positions within the tracking error of it are."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import skyverse as sky
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Terrain, Voxels
from skyverse.numerics.tolerances import CLEARANCE_EASE
from skyverse.space.lattice import make_grid, positions
from skyverse.space.tube import raised
from skyverse.space.world import World

ERRORS = [sky.TrackingError(horizontal=h, vertical=v) for h, v in ((0.5, 2.0), (1.7, 0.3), (0.0, 1.0), (1.0, 0.0))]
SHAPES = (
    Box(min=(3, 3, 0), max=(5, 6, 4)),
    Box(min=(2, 12, 7), max=(9, 16, 7.2)),
    Cylinder(centre=(12, 4), radius=1.5, low=1, high=6),
    Sphere(centre=(12, 13, 5), radius=2),
    Prism(vertices=[(15, 8), (18, 8), (16.5, 11)], low=0, high=3),
    Voxels(origin=(5, 8, 0), step=(1, 1, 1), occupied=np.ones((1, 2, 2), bool)),
)


def scenario(**changes):
    rng = np.random.default_rng(5)
    heights = rng.uniform(-1.5, 0.5, (6, 6))
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


def cylinder(error, count, rng):
    """Return random positions (count, 3) within an error of the origin, many of them on its rim."""
    turn, far = rng.uniform(0, 2 * np.pi, count), error.horizontal * np.minimum(rng.uniform(0, 1.5, count), 1.0)
    up = error.vertical * np.clip(rng.uniform(-1.5, 1.5, count), -1, 1)
    return np.column_stack([far * np.cos(turn), far * np.sin(turn), up])


@pytest.mark.parametrize("error", ERRORS, ids=str)
def test_all_positions_within_the_error_of_a_free_one_are_free(error):
    rng = np.random.default_rng(1)
    nominal, tube = World(scenario()), World(scenario(), error)
    points = rng.uniform((0, 0, 0), (20, 20, 12), (3000, 3))
    free = points[tube.free(points)]
    assert 100 < len(free) < np.sum(nominal.free(points))
    for point in free[:150]:
        around = point + 0.9999999 * cylinder(error, 100, rng)
        assert nominal.free(around).all(), point


@pytest.mark.parametrize("error", ERRORS, ids=str)
def test_no_more_is_closed_than_the_error_asks_for(error):
    h, v = error.horizontal, error.vertical
    tube = World(scenario(terrain=None, max_height=None), error)
    free = [
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
    ]
    for point, expected in free:
        assert tube.free(point)[0] == expected, point


@pytest.mark.parametrize("step", [(4.0, 4.0), (0.5, 3.0)])
@pytest.mark.parametrize("error", ERRORS, ids=str)
def test_the_raised_ground_is_nowhere_below_the_highest_within_the_error(error, step):
    rng = np.random.default_rng(2)
    terrain = Terrain(origin=(0, 0), step=step, heights=rng.uniform(0, 5, (12, 9)))
    above = raised(terrain, error)
    places = rng.uniform((0, 0), np.array(terrain.extent[1]), (4000, 2))
    turn = rng.uniform(0, 2 * np.pi, 4000)
    moved = places + error.horizontal * np.column_stack([np.cos(turn), np.sin(turn)])
    moved = np.clip(moved, 0, terrain.extent[1])
    assert (above.height(places) >= terrain.height(moved) + error.vertical - 1e-9).all()


def test_without_an_error_the_world_is_the_same_to_the_last_bit():
    plain, zero = World(scenario()).space, World(scenario(), sky.TrackingError()).space
    for a, b in zip(plain, zero, strict=True):
        for one, other in zip(*(part if isinstance(part, tuple) else (part,) for part in (a, b)), strict=True):
            if not isinstance(one, tuple):
                assert_array_equal(one, other)
    assert plain.clearance == 0.4 - CLEARANCE_EASE


@pytest.mark.parametrize("error", ERRORS, ids=str)
def test_the_lattice_stays_where_it_is_and_its_moves_are_free(error):
    given = scenario(obstacles=(SHAPES[0],), terrain=None, max_height=None)
    tube = World(given, error)
    grid, plain = make_grid(tube, given.lattice), make_grid(World(given), given.lattice)
    assert_array_equal(grid.origin, plain.origin)
    assert_array_equal(grid.shape, plain.shape)
    nodes = np.flatnonzero(grid.exits)
    for m, offset in enumerate(grid.offsets):
        some = nodes[(grid.exits[nodes] >> m & 1) == 1]
        assert tube.segments_free(positions(grid, some), positions(grid, some + offset)).all()
    assert not (grid.exits & ~plain.exits).any()
    free = tube.free(positions(grid, np.arange(len(grid.exits))))
    assert free[nodes].all()


def test_a_point_that_only_the_error_makes_unsafe_is_told_so():
    tube = World(scenario(), sky.TrackingError(horizontal=1, vertical=2))
    said = tube.why_unsafe((6, 4.5, 2.5))
    assert "grown by the clearance of 0.4 m and the tracking error of 1 m horizontally and 2 m vertically" in said
    assert "too near the bounds" in tube.why_unsafe((0.5, 10, 5))
