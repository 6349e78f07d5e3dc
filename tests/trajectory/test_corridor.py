"""Corridors are free, follow the path, and overlap, by brute force over random boxes."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from handmade import hall
from skyverse.numerics.tolerances import MIN_OVERLAP
from skyverse.trajectory.corridor import grow_corridor


def assert_a_corridor(scenario, path, boxes):
    low, high = boxes[:, :3], boxes[:, 3:]
    for obstacle in scenario.obstacles:
        inside = np.minimum(high, np.array(obstacle.max) + scenario.clearance) - np.maximum(
            low, np.array(obstacle.min) - scenario.clearance
        )
        assert inside.min(axis=1).max() <= 6e-7, "a box reaches into an obstacle"
    assert (low >= np.array(scenario.bounds.min) - 1e-12).all()
    assert (high <= np.array(scenario.bounds.max) + 1e-12).all()
    joints = np.minimum(high[:-1], high[1:]) - np.maximum(low[:-1], low[1:])
    assert (joints >= MIN_OVERLAP).all()
    shares = np.linspace(0, 1, 201)[:, None]
    at = 0  # the path goes through the boxes in their order
    for a, b in itertools.pairwise(path):
        for p in a + shares * (b - a):
            ahead = [k for k in range(len(boxes)) if (p >= low[k] - 1e-6).all() and (p <= high[k] + 1e-6).all()]
            assert ahead, "the path leaves the corridor"
            assert max(ahead) >= at
            at = max(at, min(ahead))


@pytest.mark.parametrize("name", ["map1", "map2", "map3"])
@pytest.mark.parametrize("reach", [0.5, 10.0])
def test_a_shortest_path_of_a_map_has_a_corridor_though_it_touches_the_obstacles(name, reach):
    scenario = sky.read(name)
    problem = sky.Problem(scenario)
    path = sky.Taut().plan(problem).path
    boxes = grow_corridor(problem.airspace.world.space, path, reach, 2 * reach)
    assert len(boxes)
    assert_a_corridor(scenario, path, boxes)


@given(st.integers(0, 10**6))
def test_corridors_of_random_rooms_are_free_and_joined_or_there_is_none(seed):
    scenario = sky.random_room(seed=seed)
    problem = sky.Problem(scenario)
    result = sky.Taut().plan(problem)
    if result.status.reached and len(result.path) > 1:
        boxes = grow_corridor(problem.airspace.world.space, np.ascontiguousarray(result.path), 10.0, np.inf)
        if len(boxes):
            assert_a_corridor(scenario, result.path, boxes)


@given(st.integers(1, 200), st.sampled_from([0.05, 0.1, 0.25, 0.3]))
def test_a_path_along_a_wall_exactly_at_the_clearance_has_a_corridor(twentieths, clearance):
    wall = twentieths / 20
    box = {"min": (wall, 2, 0), "max": (wall + 0.1, 8, 5)}
    scenario = hall((20, 10, 5), obstacles=[box], clearance=clearance)
    for x in (wall - clearance, wall + 0.1 + clearance):
        path = np.array([(x, 1, 2), (x, 9, 2), (x, 9, 4.0)])
        if x < 0:
            continue
        boxes = grow_corridor(sky.World(scenario).space, path, 10.0, np.inf)
        assert len(boxes)
        assert_a_corridor(scenario, path, boxes)
