"""Any-angle paths over the lattice: closed forms, the lattice's optimum, and boxes that touch."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings

import skyverse as sky
from skyverse.search.lazy_theta_star import lazy_theta_star
from skyverse.search.path_shortening.shorten_by_steps import shorten_by_steps
from skyverse.space.lattice import positions
from skyverse.space.world import segment_free
from worlds import hall as empty_hall
from worlds import scenarios

either = pytest.mark.parametrize("connectivity", [6, 26])


def hall(start, target, *obstacles, step=1.0, **changes):
    lattice = sky.Lattice(step=(step,) * 3, connectivity=changes.pop("connectivity", 26))
    return empty_hall(*obstacles, start=start, target=target, size=(10, 10, 10), lattice=lattice, **changes)


def plan(scenario):
    result = sky.ThetaStar().plan(sky.Problem(scenario))
    assert sky.check_result(scenario, 0, 0, result) == []
    return result


def length(path):
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


@either
@pytest.mark.parametrize("thickness", [0.02, 1.5])
def test_over_a_wall_the_path_is_the_shortest_one_over_its_edges(connectivity, thickness):
    clearance, top = 0.25, 6.2
    wall = ((5 - thickness / 2, 0, 0), (5 + thickness / 2, 10, top))
    result = plan(hall((1, 5, 2), (9, 5, 2), wall, clearance=clearance, connectivity=connectivity))
    half = thickness / 2 + clearance
    best = 2 * math.hypot(4 - half, top + clearance - 2) + 2 * half
    assert best <= result.cost <= 1.002 * best
    assert result.status is sky.Status.COMPLETE
    assert result.bound == 8


def test_around_a_pillar_the_path_touches_the_two_corners_on_the_shorter_side():
    result = plan(hall((1, 5, 5), (9, 5, 5), ((4, 2.1, 0), (6, 6.3, 10)), step=0.5))
    best = 2 * math.hypot(3, 1.3) + 2
    assert best <= result.cost <= 1.002 * best


@given(scenarios(most_nodes=7))
@settings(max_examples=60, deadline=None)
def test_the_path_is_never_longer_than_the_lattices_shortest_and_the_referee_agrees(scenario):
    problem = sky.Problem(scenario)
    result = sky.ThetaStar().plan(problem)
    assert sky.check_result(scenario, 0, 0, result) == []
    plain = {**dict(scenario), "objective": sky.Objective(unit="metres")}
    lattice = sky.AStar().plan(sky.Problem(sky.Scenario.model_validate(plain)))
    if not lattice.status.reached:
        assert result.status is lattice.status
        return
    assert result.status.reached
    joined = math.dist(problem.start, lattice.start) + lattice.cost + math.dist(lattice.goal, problem.end)
    assert length(result.path) <= joined * (1 + 1e-12)
    assert length(result.path) >= math.dist(problem.start, problem.end) * (1 - 1e-12)
    assert result.effort.generated_nodes >= 1


@given(scenarios(most_nodes=7))
@settings(max_examples=60, deadline=None)
def test_corners_see_each_other_and_a_shortened_path_keeps_its_ends(scenario):
    problem = sky.Problem(scenario)
    if problem.route is None:
        return
    grid, space = problem.airspace.grid, problem.airspace.world.space
    nodes, _ = lazy_theta_star(grid, space, problem.source, problem.goal, math.inf)
    assert nodes[0] == problem.source
    assert nodes[-1] == problem.goal
    corners = positions(grid, nodes)
    tight = shorten_by_steps(space, float(grid.step.max()), corners)
    assert length(tight) <= length(corners) * (1 + 1e-12)
    np.testing.assert_array_equal(tight[[0, -1]], corners[[0, -1]])
    for path in (corners, tight):
        for a, b in itertools.pairwise(path):
            assert segment_free(space, a, b)


@pytest.mark.parametrize(("name", "best"), [("map1", 22.4106), ("map2", 26.5205), ("map3", 22.6379)])
def test_on_the_thesis_maps_the_path_is_within_a_thousandth_of_the_shortest_known(name, best):
    scenario = sky.read(name)
    result = plan(scenario)
    assert best * (1 - 1e-5) <= length(result.path) <= 1.001 * best


def test_the_lattice_is_searched_only_where_its_path_could_be_the_shorter_one():
    """A zigzag along the lattice's moves is far longer than the straight way over a low wall."""
    over = plan(hall((1, 5, 2), (9, 6, 2), ((4.9, 0, 0), (5.1, 10, 3.2)), connectivity=6))
    assert over.effort.generated_paths == 1
    tied = plan(hall((1, 5, 0), (9, 5, 0), ((4.5, 0, 0), (5.5, 10, 9.5)), connectivity=26))
    assert tied.effort.generated_paths == 1
    assert over.effort.generated_nodes + tied.effort.generated_nodes < 1000
