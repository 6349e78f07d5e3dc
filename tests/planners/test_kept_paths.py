"""Searches that begin with the paths of earlier ones: what they take up, what they replace, and what that costs."""

import dataclasses

import numpy as np
import pytest

import skyverse as sky
from judged_missions import mission_of
from skyverse.planners.kept_paths import nodes_ahead
from worlds import ROOM

SEARCHES = (
    sky.MVO(universes=8),
    sky.GSO(glowworms=8),
    sky.BBO(habitats=8),
    sky.HybridMVO(universes=8),
)
every_search = pytest.mark.parametrize("planner", [*SEARCHES, sky.MVO(as_run=True), sky.RandomRestart()], ids=repr)
every_elitist = pytest.mark.parametrize("planner", SEARCHES, ids=repr)
STOP = sky.MaxIterations(8)


def moved(scenario, start=None, target=None, wall=None):
    """The scenario in which the UAV or its target is elsewhere, or in which a wall has come up."""
    more = {}
    if start is not None:
        more["uavs"] = (scenario.uavs[0].model_copy(update={"start": tuple(map(float, start))}),)
    if target is not None:
        more["targets"] = (sky.Target(position=tuple(map(float, target))),)
    if wall is not None:
        more["obstacles"] = (*scenario.obstacles, wall)
    return sky.Scenario.model_validate({**dict(scenario), **more})


def violations(problem, result):
    return sky.check(problem.scenario, mission_of(problem, result))


@every_search
def test_to_begin_with_nothing_is_to_plan(planner):
    problem = sky.Problem(ROOM)
    result, _ = planner.evolve(problem, stop=STOP, rng=3)
    planned = planner.plan(problem, stop=STOP, rng=3)
    assert dataclasses.replace(result, seconds=0.0) == dataclasses.replace(planned, seconds=0.0)


@every_search
def test_the_population_is_the_best_path_and_others_none_of_them_twice(planner):
    problem = sky.Problem(ROOM)
    result, kept = planner.evolve(problem, stop=STOP, rng=3)
    np.testing.assert_array_equal(kept[0], result.path)
    assert len({path.tobytes() for path in kept}) == len(kept)
    for path in kept:
        np.testing.assert_array_equal(path[0], result.start)


@every_elitist
def test_a_search_that_goes_on_is_never_worse_than_where_it_ended_and_the_same_seed_gives_the_same(planner):
    problem = sky.Problem(ROOM)
    first, kept = planner.evolve(problem, stop=sky.MaxIterations(3), rng=5)
    assert first.status.reached
    later, after = planner.evolve(problem, kept, stop=STOP, rng=6)
    again, same = planner.evolve(problem, kept, stop=STOP, rng=6)
    assert later.history.by_iteration().cost[0] <= first.cost
    assert later.cost <= first.cost
    assert dataclasses.replace(later, seconds=0.0) == dataclasses.replace(again, seconds=0.0)
    assert all(map(np.array_equal, after, same))
    assert "begun with" in later.provenance.planner


@every_elitist
def test_a_uav_that_is_under_way_goes_on_along_its_best_path(planner):
    first, kept = planner.evolve(sky.Problem(ROOM), stop=STOP, rng=5)
    there = 8
    problem = sky.Problem(moved(ROOM, start=first.path[there]))
    later, _ = planner.evolve(problem, kept, stop=sky.MaxIterations(1), rng=6)
    np.testing.assert_array_equal(later.path[0], first.path[there])
    assert later.history.by_iteration().cost[0] <= len(first.path) - there
    assert not violations(problem, later)


@every_elitist
@pytest.mark.parametrize("change", ["start", "target", "wall", "all"])
def test_what_has_changed_is_led_around_and_the_referee_agrees(planner, change):
    first, kept = planner.evolve(sky.Problem(ROOM), stop=STOP, rng=5)
    x, y, z = first.path[len(first.path) // 2]
    more = {
        "start": (1.1, 1.4, 1.1),
        "target": (5.6, 0.9, 0.8),
        "wall": sky.Box(min=(x - 0.1, y - 0.1, z - 0.1), max=(x + 0.1, y + 0.1, z + 0.1)),
    }
    problem = sky.Problem(moved(ROOM, **(more if change == "all" else {change: more[change]})))
    later, after = planner.evolve(problem, kept, stop=STOP, rng=6)
    assert later.status.reached
    for path in (later.path, *after):
        np.testing.assert_array_equal(path[0], later.start)
    assert not violations(problem, later)


def test_work_on_given_paths_is_counted_and_what_needs_no_walk_generates_nothing():
    problem, planner = sky.Problem(ROOM), sky.MVO(universes=8)
    first, kept = planner.evolve(problem, stop=STOP, rng=5)
    complete = [path for path in kept if np.array_equal(path[-1], first.goal)]
    eight = [complete[k % len(complete)] for k in range(8)]
    result, _ = planner.evolve(problem, eight, stop=sky.MaxIterations(1), rng=6)
    assert result.history.by_iteration().generated_paths[0] == 0
    assert result.history.by_iteration().evaluations[0] == 8
    result, _ = planner.evolve(problem, eight[:5], stop=sky.MaxIterations(1), rng=6)
    assert result.history.by_iteration().generated_paths[0] == 3
    result, _ = planner.evolve(problem, [path[:3] for path in eight], stop=sky.MaxIterations(1), rng=6)
    assert result.history.by_iteration().generated_paths[0] >= 8  # walks lead on to the goal


def test_a_budget_that_is_spent_ends_the_taking_up_of_paths():
    problem, planner = sky.Problem(ROOM), sky.MVO(universes=8)
    _, kept = planner.evolve(problem, stop=STOP, rng=5)
    result, _ = planner.evolve(problem, kept, stop=sky.MaxEvaluations(3), rng=6)
    assert result.effort.evaluations == 3


def test_paths_of_any_kind_in_metres_are_taken_up_and_those_that_lead_nowhere_replaced():
    problem = sky.Problem(ROOM)
    taut = sky.Taut().plan(problem)
    far = [(40.0, 40.0, 40.0), (50.0, 50.0, 50.0)]
    result, _ = sky.MVO(universes=4).evolve(problem, [taut.path, far], stop=sky.MaxIterations(1), rng=1)
    assert result.status.reached
    assert not violations(problem, result)


def test_the_nodes_ahead_begin_with_the_one_that_is_nearest_to_the_uav():
    problem = sky.Problem(ROOM)
    grid, path = problem.airspace.grid, sky.AStar().plan(problem).path
    indices = np.rint((path - grid.origin) / grid.step).astype(int)
    nodes = np.ravel_multi_index(tuple(indices.T), tuple(grid.shape))
    np.testing.assert_array_equal(nodes_ahead(grid, int(nodes[4]), path), nodes[4:])
    np.testing.assert_array_equal(nodes_ahead(grid, int(nodes[0]), np.repeat(path, 3, axis=0) + 0.01), nodes)
    inside = np.array([(2.5, 1.0, 1.0)])
    assert len(nodes_ahead(grid, int(nodes[0]), inside)) == 0


@pytest.mark.parametrize("path", [[], [(1, 2)], [(1, 2, np.nan)], [(1, 2, 3), (1,)], "a path", 7])
def test_what_is_no_path_is_refused(path, refuses):
    with refuses():
        sky.MVO().evolve(sky.Problem(ROOM), [path], stop=STOP)


def test_there_is_no_population_where_there_is_nothing_to_search():
    walled = moved(ROOM, wall=sky.Box(min=(3.2, 0, 0), max=(3.4, 5, 4)))
    result, kept = sky.MVO().evolve(sky.Problem(walled), stop=STOP)
    assert (result.status, kept) == (sky.Status.NO_PATH, ())
