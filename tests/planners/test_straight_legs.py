"""Straight legs: what a polyline costs, what is kept of it, and searches that leave the lattice."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.planners.base import provenance
from skyverse.planners.straight_legs import judge_legs, open_straight_run
from skyverse.space.world import segment_free
from worlds import ROOM, scenarios

STOP = sky.MaxIterations(4)


def opened(problem, joints=8, collision=100.0):
    origin = provenance("by hand", None, None)
    rng = np.random.default_rng(0)
    return open_straight_run(problem, sky.MaxPaths(10**6), rng, origin, joints, collision)


def metres_inside(scenario, a, b, more=0.0):
    """Sample a leg densely against all grown boxes together: its metres inside, and half a sample's length."""
    at = a + ((np.arange(4000) + 0.5) / 4000)[:, None] * (b - a)
    size = np.linalg.norm(b - a)
    low = np.array([box.min for box in scenario.obstacles]).reshape(-1, 1, 3) - scenario.clearance - more
    high = np.array([box.max for box in scenario.obstacles]).reshape(-1, 1, 3) + scenario.clearance + more
    inside = np.all((at > low) & (at < high), axis=2)
    return inside.any(axis=0).sum() * size / 4000, size / 4000 * len(low)


@settings(max_examples=50)
@given(scenarios(), st.lists(st.tuples(*[st.floats(0, 1)] * 3), max_size=5))
def test_fitness_is_price_and_metres_inside_and_the_free_part_is_kept(scenario, shares):
    problem = sky.Problem(scenario)
    run = opened(problem)
    if isinstance(run, sky.Result):
        return
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    path = np.vstack([problem.start, low + np.array(shares).reshape(-1, 3) * (high - low), problem.end])
    fitness = judge_legs(run.task, run.workspace, run.best, path)
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    space = run.task.space  # its obstacles are closed, unless an end touches one
    safe = np.array([segment_free(space, a, b) for a, b in itertools.pairwise(path)])
    free = len(path) if safe.all() else 1 + int(np.argmin(safe))
    kept = path[:free]
    np.testing.assert_array_equal(run.best.points[: run.best.length[0]], kept)
    objective = scenario.objective
    places = kept[np.r_[True, np.any(np.diff(kept, axis=0) != 0, axis=1)]]  # a place twice in a row hides no turn
    turns = sum(
        np.linalg.norm(np.cross(b - a, c - b)) > 1e-9 * np.linalg.norm(b - a) * np.linalg.norm(c - b)
        for a, b, c in zip(places, places[1:], places[2:], strict=False)
    )
    gap = math.dist(kept[-1], problem.end)
    price = objective.fuel * lengths[: free - 1].sum() + objective.divergence * turns + objective.end * gap
    assert run.best.cost[0] == pytest.approx(price, rel=1e-9, abs=1e-9)
    if safe.all():
        assert fitness == pytest.approx(price)
    sampled = [metres_inside(scenario, a, b) for a, b in itertools.pairwise(path)]
    inside, doubt = (sum(part) for part in zip(*sampled, strict=True))
    without = judge_legs(run.task._replace(collision=0.0), run.workspace, run.best, path)
    # a leg along a face may count as inside or not
    most = sum(sum(metres_inside(scenario, a, b, 1e-6)) for a, b in itertools.pairwise(path))
    least = sum(metres_inside(scenario, a, b, -1e-6)[0] for a, b in itertools.pairwise(path))
    assert min(inside, least) - doubt - 1e-6 <= (fitness - without) / 100 <= max(inside + doubt, most) + 1e-6
    np.testing.assert_array_equal(run.workspace.spent, [2, 2 * (len(path) - 1), 2])


def hall(*obstacles, step=0.5):
    return sky.Scenario.model_validate(
        {**dict(ROOM), "obstacles": obstacles, "lattice": sky.Lattice(step=(step, step, step))}
    )


def test_a_straight_line_that_is_safe_is_optimal():
    result = sky.WOA(waypoints=1, legs="straight").plan(sky.Problem(hall()), stop=sky.MaxPaths(4000), rng=1)
    assert result.cost == pytest.approx(math.dist((0.6, 0.7, 1.2), (5.8, 4.3, 3.1)), rel=1e-3)
    assert result.gap < 1e-3


def test_a_way_is_found_where_the_lattice_has_none():
    """The gap, 0.3 m wide once the wall has grown, lies between two planes of the lattice."""
    wall = (
        sky.Box(min=(2.9, 0, 0), max=(3.1, 2.1, 4)),
        sky.Box(min=(2.9, 2.9, 0), max=(3.1, 5, 4)),
    )
    scenario = hall(*wall, step=1.0)
    scenario = scenario.model_copy(update={"lattice": sky.Lattice(step=(2.0, 1.9, 2.0))})
    problem = sky.Problem(scenario)
    assert sky.MVO().plan(problem, rng=1).status is sky.Status.NO_PATH
    result = sky.MFO(waypoints=2, legs="straight").plan(problem, stop=sky.MaxPaths(3000), rng=1)
    assert result.status is sky.Status.COMPLETE
    assert sky.check_result(scenario, 0, 0, result) == []
