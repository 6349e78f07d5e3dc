"""Shorter paths and fewer waypoints, the same safety."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.search.path_shortening.merge_bends import merge_bends
from skyverse.search.path_shortening.shortcut import drop_collinear
from skyverse.search.path_shortening.shortcut import shortcut as shortcut_through
from skyverse.search.path_shortening.shorten import shorten
from skyverse.search.path_shortening.shorten_by_steps import shorten_by_steps
from skyverse.space import lattice
from skyverse.space.world import path_free
from worlds import ROOM, scenarios


def rows(*points):
    return np.array(points, float)


def shortcut(world, path):
    return shortcut_through(world.space, path)


def random_walk(grid, rng, moves):
    """A safe path over the lattice, (moves + 1, 3) metres; None where every node is blocked."""
    free = np.flatnonzero(grid.exits)
    if not len(free):
        return None
    nodes = [int(rng.choice(free))]
    for _ in range(moves):
        choices = [m for m in range(len(grid.moves)) if grid.exits[nodes[-1]] >> m & 1]
        nodes.append(nodes[-1] + int(grid.offsets[rng.choice(choices)]))
    return lattice.positions(grid, nodes)


def length(path):
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


@pytest.mark.parametrize(
    ("path", "kept"),
    [
        (rows((0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0)), rows((0, 0, 0), (2, 0, 0), (2, 1, 0))),
        (rows((0, 0, 0), (1, 1, 1), (3, 3, 3)), rows((0, 0, 0), (3, 3, 3))),
        (rows((0, 0, 0), (2, 0, 0), (1, 0, 0)), rows((0, 0, 0), (2, 0, 0), (1, 0, 0))),  # back the way it came
        (rows((0, 0, 0), (0, 0, 0), (1, 0, 0), (1, 0, 0)), rows((0, 0, 0), (1, 0, 0))),
        (rows((0, 0, 0), (0, 0, 0)), rows((0, 0, 0))),
        (rows((1, 2, 3)), rows((1, 2, 3))),
        (rows((0, 0, 0), (1, 0, 0), (2, 1e-3, 0)), rows((0, 0, 0), (1, 0, 0), (2, 1e-3, 0))),
    ],
)
def test_points_on_a_straight_line_are_dropped(path, kept):
    np.testing.assert_array_equal(drop_collinear(path), kept)


@given(st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=1, max_size=20))
def test_what_is_dropped_lies_between_what_is_kept(points):
    path = rows(*points)
    kept = drop_collinear(path)
    np.testing.assert_array_equal(kept[0], path[0])
    np.testing.assert_array_equal(kept[-1], path[-1])
    # walk both: the same length, and every point of the path lies on the kept polyline in the same order
    length = np.linalg.norm(np.diff(path, axis=0), axis=1)
    short = np.linalg.norm(np.diff(kept, axis=0), axis=1)
    assert short.sum() == pytest.approx(length.sum())
    along, mileposts = np.r_[0, np.cumsum(length)], np.r_[0, np.cumsum(short)]
    if len(kept) > 1:
        there = np.stack([np.interp(along, mileposts, kept[:, a]) for a in range(3)], axis=-1)
        np.testing.assert_allclose(there, path, atol=1e-9)
    # and nothing that is left could go: no point repeats, and each turns or goes back
    steps = np.diff(kept, axis=0)
    assert (short > 0).all()
    for a, b in itertools.pairwise(steps):
        assert np.any(np.cross(a, b)) or a @ b < 0


@given(scenarios(most_nodes=6), st.integers(0, 2**32))
def test_a_shortcut_leaves_a_subsequence_whose_every_segment_is_free_and_greedily_long(scenario, seed):
    compiled, rng = sky.World(scenario), np.random.default_rng(seed)
    grid = lattice.make_grid(compiled, scenario.lattice)
    path = random_walk(grid, rng, 25)
    if path is None:
        return
    kept = shortcut(compiled, path)
    np.testing.assert_array_equal(kept[[0, -1]], path[[0, -1]])
    assert compiled.segments_free(kept[:-1], kept[1:]).all()
    at, wanted = 0, [0]  # the greedy rule, spelt out
    while at < len(path) - 1:
        at = max(j for j in range(at + 1, len(path)) if j == at + 1 or compiled.segments_free(path[at], path[j])[0])
        wanted.append(at)
    np.testing.assert_array_equal(kept, path[wanted])


def test_a_shortcut_goes_round_the_walls_of_the_room_and_not_through():
    problem = sky.Problem(ROOM)
    path = problem.places(problem.route.nodes)
    kept = shortcut(problem.airspace.world, path)
    assert 3 <= len(kept) < len(drop_collinear(path))
    assert problem.airspace.world.segments_free(kept[:-1], kept[1:]).all()
    assert not problem.airspace.world.segments_free(path[0], path[-1]).any()


def test_a_corner_that_hides_the_point_after_next_is_kept():
    corner = rows((1, 1, 1), (1, 4.6, 1), (4, 4.6, 1))  # round the end of the first wall
    compiled = sky.World(ROOM)
    assert compiled.segments_free(corner[:-1], corner[1:]).all()
    np.testing.assert_array_equal(shortcut(compiled, corner), corner)


def test_in_an_empty_space_a_shortcut_is_one_segment():
    empty = ROOM.model_copy(update={"obstacles": ()})
    path = rows((0, 0, 0), (1, 0, 0), (1, 2, 0), (1, 2, 3))
    np.testing.assert_array_equal(shortcut(sky.World(empty), path), path[[0, -1]])


def test_a_shortcut_does_not_slip_between_obstacles_that_touch():
    wall = ROOM.model_copy(
        update={
            "obstacles": (sky.Box(min=(2, 0, 0), max=(3, 2, 4)), sky.Box(min=(2, 2, 0), max=(3, 4, 4))),
            "clearance": 0.001,
        }
    )
    around = rows((1, 2, 2), (1, 4.5, 2), (4, 4.5, 2), (4, 2, 2))
    assert not sky.World(wall).segments_free(around[0], around[-1])[0]
    np.testing.assert_array_equal(shortcut(sky.World(wall), around), around)


@given(scenarios(most_nodes=6), st.integers(0, 2**32))
def test_a_shortened_path_is_free_keeps_its_ends_and_is_never_longer(scenario, seed):
    compiled = sky.World(scenario)
    path = random_walk(lattice.make_grid(compiled, scenario.lattice), np.random.default_rng(seed), 12)
    if path is None:
        return
    path = drop_collinear(path)
    step = float(max(scenario.lattice.step))
    for shorter in (
        shortcut_through(compiled.space, path),
        shorten(compiled.space, path.copy()),
        shorten_by_steps(compiled.space, step, path.copy()),
    ):
        np.testing.assert_array_equal(shorter[[0, -1]], path[[0, -1]])
        assert path_free(compiled.space, shorter)
        assert length(shorter) <= length(path) * (1 + 1e-12)


@given(scenarios(most_nodes=6), st.integers(0, 2**32))
def test_merging_bends_leaves_a_free_path_with_no_more_bends(scenario, seed):
    compiled = sky.World(scenario)
    path = random_walk(lattice.make_grid(compiled, scenario.lattice), np.random.default_rng(seed), 12)
    if path is None:
        return
    path = drop_collinear(path)
    merged = merge_bends(compiled.space, path)
    assert len(merged) <= len(path)
    assert path_free(compiled.space, merged)
    np.testing.assert_array_equal(merged[[0, -1]], path[[0, -1]])
