"""What holds of every planner whose paths have straight legs off the lattice."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

import skyverse as sky
from worlds import ROOM, hall

DIRECT = [sky.Taut(), sky.ThetaStar(), sky.Cheapest(legs=20_000)]
every_direct_planner = pytest.mark.parametrize("planner", DIRECT, ids=repr)
every_planner = pytest.mark.parametrize("planner", [*DIRECT, sky.WOA(candidates=6, legs="straight")], ids=repr)
STOP = sky.MaxIterations(5)


def plan(planner, scenario):
    result = planner.plan(sky.Problem(scenario), stop=STOP, rng=1)
    assert sky.check_result(scenario, 0, 0, result) == []
    return result


@every_direct_planner
@pytest.mark.parametrize("connectivity", [6, 26])
def test_where_nothing_is_in_the_way_the_path_is_the_straight_line_between_the_true_ends(planner, connectivity):
    result = plan(planner, hall(start=(0.3, 0.4, 0.7), target=(9.1, 7.6, 3.2), connectivity=connectivity))
    np.testing.assert_array_equal(result.path, [(0.3, 0.4, 0.7), (9.1, 7.6, 3.2)])
    assert result.status is sky.Status.OPTIMAL
    assert result.cost == result.bound == math.dist(*result.path)
    assert result.any_angle


@every_planner
def test_a_target_at_the_start_is_reached_without_a_search(planner):
    result = plan(planner, hall(start=(1.2, 1.3, 1.4), target=(1.2, 1.3, 1.4)))
    assert (result.status, result.stopped_by, result.cost) == (sky.Status.OPTIMAL, "finished", 0.0)


@every_direct_planner
@pytest.mark.parametrize("gap", [1e-260, 1e-160, 5e-324])
def test_a_target_next_to_the_start_costs_no_less_than_the_bound(planner, gap):
    """The squares of such a distance underflow: the path once cost 0, less than the bound."""
    result = plan(planner, hall(start=(0.0, 0.7, 1.2), target=(gap, 0.7, 1.2)))
    assert (result.status, result.cost, result.bound) == (sky.Status.OPTIMAL, gap, gap)


@every_planner
@pytest.mark.parametrize(
    ("ends", "status"),
    [
        ({"start": (2.5, 1, 1)}, sky.Status.START_UNSAFE),
        ({"target": (2.5, 1, 1)}, sky.Status.TARGET_UNSAFE),
        ({"start": (-1, 1, 1)}, sky.Status.START_OUT_OF_BOUNDS),
        ({"target": (11, 4, 2)}, sky.Status.TARGET_OUT_OF_BOUNDS),
    ],
)
def test_what_cannot_be_planned_is_refused_with_the_reason(planner, ends, status):
    room = hall(*ROOM.obstacles, **{"start": (0.6, 0.7, 1.2), "target": (5.8, 4.3, 3.1), **ends})
    assert plan(planner, room).status is status


WALLS = {  # what touches lies right on the straight line between the ends
    "flush": (((4, 0, 0), (6, 5, 5)), ((4, 5, 0), (6, 10, 4)), (2, 5, 3), (8, 5, 3)),
    "diagonal": (((3, 0, 0), (5, 5, 5)), ((5, 5, 0), (7, 10, 5)), (4, 6, 3), (6, 4, 3)),
    "stacked": (((4, 0, 0), (6, 9, 2)), ((4, 0, 2), (6, 9, 5)), (2, 8, 2), (8, 8, 2)),
    "a wall": (((4, 0, 0), (5, 5, 5)), ((4, 5, 0), (5, 10, 5)), (1, 5, 2), (9, 5, 2)),
}


@every_planner
@pytest.mark.parametrize("name", WALLS)
def test_no_leg_slips_between_boxes_that_touch(planner, name):
    *boxes, start, target = WALLS[name]
    scenario = hall(*boxes, start=start, target=target)
    world = sky.World(scenario)
    assert not world.segments_free([start], [target]).any()
    result = plan(planner, scenario)
    if name in ("diagonal", "a wall"):  # from bound to bound
        assert not result.status.reached
        if isinstance(planner, sky.Taut | sky.Cheapest):
            assert result.status is sky.Status.NO_PATH_EXISTS
    elif planner in DIRECT:
        assert result.status.reached
        assert math.dist(start, target) + 0.3 < result.cost < math.dist(start, target) + 3
        shares = np.linspace(0, 1, 1000)[:, None]
        legs = [a + shares * (b - a) for a, b in itertools.pairwise(result.path)]
        assert world.distance(np.vstack(legs)).min() > 0


@pytest.mark.parametrize("planner", [sky.Taut(), sky.ThetaStar()], ids=repr)
def test_turns_are_priced_but_not_minimised_and_fuel_is_weighted(planner):
    objective = sky.Objective(divergence=0.3, fuel=2)
    pillar = ((4, 2.1, 0), (6, 6.3, 5))
    result = plan(planner, hall(pillar, start=(1, 5, 2), target=(9, 5, 2), objective=objective))
    metres = np.linalg.norm(np.diff(result.path, axis=0), axis=1).sum()
    assert metres == pytest.approx(2 * math.hypot(3, 1.3) + 2, rel=2e-3)
    assert result.terms["fuel"] == pytest.approx(2 * metres)
    assert result.terms["divergence"] == pytest.approx(0.3 * (len(result.path) - 2))
    assert 2 * 8 + 0.3 - 1e-9 <= result.bound <= result.cost
    free = plan(planner, hall(start=(1, 5, 2), target=(9, 5, 2), objective=objective))
    assert (free.status, free.bound) == (sky.Status.OPTIMAL, pytest.approx(16))


@every_direct_planner
def test_a_start_on_the_surface_of_an_obstacle_leaves_it(planner):
    result = plan(planner, hall(((1, 1, 0), (3, 9, 5)), start=(3.001, 5.2, 2), target=(9, 5, 2)))
    assert result.status.reached


@every_direct_planner
def test_the_same_problem_has_the_same_answer(planner):
    problem = sky.Problem(sky.random_threats(15, seed=7))
    first, second = (dataclasses.replace(planner.plan(problem), seconds=0.0) for _ in range(2))
    assert first == second
