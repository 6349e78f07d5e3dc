"""Lower bounds on the lengths of paths among boxes, beside lengths of paths that exist."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.numerics.kernel import kernel
from skyverse.numerics.tolerances import BOUND_ROUNDING, SIGHT_MARGIN
from skyverse.search.taut.interval_graph import finer, first_graph, legs_by_interval
from skyverse.search.taut.lower_bound import sharpen
from skyverse.space.obstacles import with_margin


def walls(seed: int, most: int) -> sky.Scenario:
    """Return a room with a few thin walls and slabs between start and target."""
    rng = np.random.default_rng(seed)
    size = np.array([10.0, 10.0, 5.0])
    boxes = []
    for _ in range(rng.integers(1, most + 1)):
        extent = rng.uniform(0.3, 0.9, 3) * size
        extent[rng.integers(3)] = rng.uniform(0.02, 0.3)
        middle = rng.uniform([0.0, 2.0, 0.0], [10.0, 8.0, 5.0])
        low, high = np.maximum(middle - extent / 2, [-1, 1, -1]), np.minimum(middle + extent / 2, [11, 9, 6])
        if (high > low).all():
            boxes.append(sky.Box(min=tuple(low.tolist()), max=tuple(high.tolist())))
    start, target = rng.uniform([0.5, 0.2, 0.5], [9.5, 0.8, 4.5]), rng.uniform([0.5, 9.2, 0.5], [9.5, 9.8, 4.5])
    return sky.Scenario(
        name=f"walls-{seed}",
        bounds=sky.Bounds(min=(0, 0, 0), max=tuple(size.tolist())),
        obstacles=tuple(boxes),
        clearance=float(rng.choice([0.001, 0.1])),
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5)),
        objective=sky.Objective(unit="metres"),
        uavs=(sky.UAV(start=tuple(start.tolist())),),
        targets=(sky.Target(position=tuple(target.tolist())),),
    )


@kernel
def bound_up_to(space, edges, start, goal, limit, most):
    """Return the greatest of the bounds that a search up to some limit finds on its way."""
    spacing = limit / 6
    graph, looked = first_graph(space, edges, start, goal, limit, spacing, most)
    bound = 0.0
    for turn in range(12):
        if looked > most:
            break
        graph, found = sharpen(graph, legs_by_interval(graph), turn % 2, limit)
        bound = max(bound, found)
        if bound == limit:
            break
        spacing *= 0.5
        graph, more = finer(space, edges, graph, limit, spacing, most - looked)
        looked += more
    return bound


def excess_of_bound(scenario: sky.Scenario, factor: float) -> tuple[float, float]:
    """Return by how much the bound exceeds the length of a path, metres, and the room that it had to do so.

    The search is told of a longer path only, so that it is not the known length that keeps its bound low.
    """
    problem = sky.Problem(scenario)
    result = sky.Taut(proof=100).plan(problem)
    if not result.status.reached or len(result.path) < 3:
        return 0.0, 0.0
    space = with_margin(problem.airspace.world.space, SIGHT_MARGIN)
    ends = np.array(problem.start), np.array(problem.end)
    bound = bound_up_to(space, problem.airspace.edges, *ends, factor * result.cost, 40_000)
    return bound - result.cost - BOUND_ROUNDING, (factor - 1.0) * result.cost


@given(st.integers(0, 2**32), st.floats(1.0, 1.2))
@settings(max_examples=100, deadline=None)
def test_no_bound_exceeds_the_length_of_a_path_that_exists(seed, factor):
    assert excess_of_bound(walls(seed, most=4), factor)[0] <= 0.0


def test_no_bound_exceeds_the_length_of_a_path_in_many_rooms():
    rng = np.random.default_rng(0)
    found = [excess_of_bound(walls(seed, most=2 + seed % 12), rng.uniform(1.0, 1.1)) for seed in range(600)]
    assert max(excess for excess, _ in found) <= 0.0
    assert sum(room > 0.01 for _, room in found) > 250


@pytest.mark.parametrize("factor", [1.001, 1.0201, 1.021])
def test_a_path_under_a_thin_wall_that_crosses_its_edges_far_from_their_middles_is_counted(factor):
    wall = sky.Box(min=(0.7, 1.44, 2.5), max=(2.8, 1.51, 6.0))
    scenario = walls(0, most=1).model_copy(
        update={
            "obstacles": (wall,),
            "clearance": 0.001,
            "uavs": (sky.UAV(start=(1.9, 0.7, 2.65)),),
            "targets": (sky.Target(position=(1.37, 9.0, 3.8)),),
        }
    )
    assert excess_of_bound(scenario, factor)[0] <= 0.0


def test_around_forty_corners_the_bound_gains_nothing_from_the_margins_of_the_edges():
    """A slalom whose length is known by hand: the bound counts paths that keep the clearance and no more."""
    reach, tips = 0.1, [(0.4 * k + 0.4, 2.8 if k % 2 else 2.2) for k in range(20)]
    slalom = walls(0, most=1).model_copy(
        update={
            "obstacles": tuple(
                sky.Box(min=(x, -1 if k % 2 else y, -1), max=(x + 0.02, y if k % 2 else 6, 6))
                for k, (x, y) in enumerate(tips)
            ),
            "bounds": sky.Bounds(min=(0, 0, 0), max=(9, 5, 1)),
            "clearance": 0.1,
            "uavs": (sky.UAV(start=(0.1, 2.5, 0.5)),),
            "targets": (sky.Target(position=(8.8, 2.5, 0.5)),),
        }
    )
    at = [(0.1, 2.5)]
    for k, (x, y) in enumerate(tips):
        aside = y + reach if k % 2 else y - reach
        at += [(x - reach, aside), (x + 0.02 + reach, aside)]
    length = sum(itertools.starmap(math.dist, itertools.pairwise([*at, (8.8, 2.5)])))
    problem = sky.Problem(slalom)
    space = with_margin(problem.airspace.world.space, SIGHT_MARGIN)
    ends = np.array(problem.start), np.array(problem.end)
    bound = bound_up_to(space, problem.airspace.edges, *ends, 1.001 * length, 400_000)
    assert 0.999 * length < bound <= length + BOUND_ROUNDING
    result = sky.Taut().plan(problem)
    assert result.bound <= length
    assert result.cost == pytest.approx(length, abs=1e-4)


@pytest.mark.parametrize("seed", range(40))
def test_a_path_past_a_few_walls_is_proven_within_two_percent_of_the_shortest(seed):
    result = sky.Taut().plan(sky.Problem(walls(seed, most=8)))
    assert not result.status.reached or result.gap < 0.021
