"""Lower bounds on the lengths of paths among boxes, beside lengths of paths that exist."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.numerics.kernel import in_plain_python
from skyverse.numerics.tolerances import BEND_GAIN, SEAM_MARGIN
from skyverse.search.taut.lower_bound import lower_bound
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
        clearance=float(rng.choice([0.0, 0.1])),
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5)),
        objective=sky.Objective(unit="metres"),
        uavs=(sky.UAV(start=tuple(start.tolist())),),
        targets=(sky.Target(position=tuple(target.tolist())),),
    )


def assert_no_bound_exceeds(scenario: sky.Scenario, factor: float) -> None:
    """Tell the search of a longer path only, so that it is not the known length that keeps its bound low."""
    problem = sky.Problem(scenario)
    result = sky.Taut(proof=0).plan(problem)
    straight = math.dist(problem.start, problem.end)
    if not result.status.reached or len(result.path) < 3:
        return
    space = with_margin(problem.airspace.world.space, SEAM_MARGIN)
    ends = np.array(problem.start), np.array(problem.end)
    with in_plain_python():
        bound = lower_bound(space, problem.airspace.edges, *ends, factor * result.cost, straight, 20_000)
    assert straight <= bound <= result.cost + BEND_GAIN * len(result.path)


@given(st.integers(0, 2**32), st.floats(1.0, 1.2))
@settings(max_examples=25, deadline=None)
def test_no_bound_exceeds_the_length_of_a_path_that_exists(seed, factor):
    assert_no_bound_exceeds(walls(seed, most=4), factor)


@pytest.mark.parametrize("factor", [1.001, 1.0201, 1.021])
def test_a_path_under_a_thin_wall_that_crosses_its_edges_far_from_their_middles_is_counted(factor):
    wall = sky.Box(min=(0.7, 1.44, 2.5), max=(2.8, 1.51, 6.0))
    scenario = walls(0, most=1).model_copy(
        update={
            "obstacles": (wall,),
            "clearance": 0.0,
            "uavs": (sky.UAV(start=(1.9, 0.7, 2.65)),),
            "targets": (sky.Target(position=(1.37, 9.0, 3.8)),),
        }
    )
    assert_no_bound_exceeds(scenario, factor)


@pytest.mark.parametrize("seed", range(40))
def test_a_path_past_a_few_walls_is_proven_within_two_percent_of_the_shortest(seed):
    result = sky.Taut().plan(sky.Problem(walls(seed, most=8)))
    assert not result.status.reached or result.gap < 0.021
