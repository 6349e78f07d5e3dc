"""The objective's terms against NumPy that spells the equations out."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse import cost
from worlds import OBJECTIVES, ROOM, indices_of, neighbours, price_of, scenarios, shape_of


@st.composite
def walks(draw):
    """A scenario, and a walk of up to 20 nodes on its lattice, walls or not."""
    scenario = draw(scenarios(most_nodes=4, most_boxes=0, objectives=OBJECTIVES))
    shape, steps = np.array(shape_of(scenario)), neighbours(scenario.lattice.connectivity)
    at = np.array([draw(st.integers(0, n - 1)) for n in shape])
    indices = [at]
    for m in draw(st.lists(st.integers(0, len(steps) - 1), max_size=20)):
        if np.all((at + steps[m] >= 0) & (at + steps[m] < shape)):
            at = at + steps[m]
            indices.append(at)
    nodes = np.ravel_multi_index(tuple(np.array(indices).T), tuple(shape))
    goal = draw(st.integers(0, int(shape.prod()) - 1))
    return scenario, nodes.astype(draw(st.sampled_from([np.int32, np.int64]))), goal


@given(walks())
def test_every_term_is_what_its_equation_says(walk):
    scenario, nodes, goal = walk
    airspace = sky.Airspace(scenario)
    grid, pricing = airspace.grid, airspace.pricing
    places = np.array(scenario.bounds.min) + indices_of(scenario) * np.array(scenario.lattice.step)
    fuel, divergence, end = price_of(scenario, places[nodes], places[goal])
    assert cost.fuel(grid, pricing, nodes) == pytest.approx(fuel, rel=1e-12)  # (3.2)
    assert cost.divergence(grid, pricing, nodes) == pytest.approx(divergence, rel=1e-12)
    assert cost.end(grid, pricing, nodes, goal) == pytest.approx(end, rel=1e-9, abs=1e-12)  # (3.3)
    assert cost.total(grid, pricing, nodes, goal) == pytest.approx(fuel + divergence + end, rel=1e-9)  # (3.4)
    for kernel in (cost.fuel, cost.divergence):
        assert kernel(grid, pricing, nodes) == plain(kernel)(grid, pricing, nodes)
    for kernel in (cost.end, cost.total):
        assert kernel(grid, pricing, nodes, goal) == plain(kernel)(grid, pricing, nodes, goal)


def plain(kernel):
    return getattr(kernel, "py_func", kernel)


def priced(objective, connectivity, *indices, goal=(0, 0, 0)):
    scenario = sky.Scenario(
        name="hall",
        bounds=sky.Bounds(min=(0, 0, 0), max=(4, 4, 4)),
        clearance=0.001,
        lattice=sky.Lattice(step=(0.5, 1, 2), connectivity=connectivity),
        objective=objective,
    )
    grid, pricing = (getattr(sky.Airspace(scenario), name) for name in ("grid", "pricing"))
    nodes = np.array([np.ravel_multi_index(i, tuple(grid.shape)) for i in indices])
    target = int(np.ravel_multi_index(goal, tuple(grid.shape)))
    return [
        cost.fuel(grid, pricing, nodes),
        cost.divergence(grid, pricing, nodes),
        cost.end(grid, pricing, nodes, target),
    ]


STAIR = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 2, 0), (1, 2, 1)]


def test_the_thesis_counts_nodes_with_the_start_and_a_hundred_a_metre_of_gap():
    assert priced("thesis", 6, *STAIR, goal=(1, 2, 1)) == [5, 0, 0]
    assert priced("thesis", 6, *STAIR, goal=(7, 2, 1)) == [5, 0, pytest.approx(300)]
    assert priced("thesis", 6, *STAIR, goal=(7, 2, 0)) == [5, 0, pytest.approx(100 * np.hypot(3, 2))]


def test_the_sibling_study_prices_a_turn_at_three_tenths_and_a_metre_of_gap_at_eighty():
    assert priced("turns", 6, *STAIR, goal=(7, 2, 1)) == [5, pytest.approx(0.6), pytest.approx(240)]


def test_metres_are_the_length_of_the_path():
    metres = sky.Objective(fuel=2, unit="metres")
    assert priced(metres, 6, *STAIR, goal=(1, 2, 1)) == [pytest.approx(2 * (0.5 + 1 + 1 + 2)), 0, 0]
    diagonal = [(0, 0, 0), (1, 1, 0), (2, 2, 1), (2, 3, 2)]
    length = np.hypot(0.5, 1) + np.sqrt(0.25 + 1 + 4) + np.hypot(1, 2)
    assert priced(metres, 26, *diagonal, goal=(2, 3, 2)) == [pytest.approx(2 * length), 0, 0]


def test_a_path_of_one_node_costs_that_node_and_its_gap():
    assert priced("turns", 6, (0, 0, 0), goal=(0, 0, 1)) == [1, 0, pytest.approx(160)]
    assert priced(sky.Objective(unit="metres"), 6, (0, 0, 0)) == [0, 0, 0]


def test_turning_back_is_no_turn_because_its_cross_product_is_zero():
    assert priced("turns", 6, (0, 0, 0), (1, 0, 0), (0, 0, 0))[1] == 0


def test_steps_of_equal_metres_and_of_equal_nodes_are_told_apart():
    """All moves of a cubic 6-lattice cost the same in metres too, but n nodes are n - 1 steps."""
    scenario = sky.Scenario(
        name="cubes",
        bounds=sky.Bounds(min=(0, 0, 0), max=(4, 4, 4)),
        clearance=0.001,
        lattice=sky.Lattice(step=(2, 2, 2)),
        objective=sky.Objective(unit="metres"),
    )
    airspace = sky.Airspace(scenario)
    assert cost.fuel(airspace.grid, airspace.pricing, np.array([0, 1, 2])) == 4


@pytest.mark.parametrize("unit", ["nodes", "metres"])
@pytest.mark.parametrize("planner", [sky.AStar(), sky.MVO(universes=5), sky.Taut()])
def test_what_results_state_is_what_their_paths_cost_and_nothing_else_is_taken_for_it(unit, planner):
    weights = {"fuel": 0.7, "divergence": 0.3, "end": 9.0, "unit": unit}
    problem = sky.Problem(ROOM.model_copy(update={"objective": sky.Objective(**weights)}))
    result = planner.plan(problem, stop=sky.MaxIterations(3), rng=1)
    rates = problem.airspace.rates
    assert cost.wrong_figures(problem.scenario, rates, result) == ""
    for change in (
        {"cost": result.cost * (1 + 3e-6)},
        {"cost": math.nan},
        {"terms": result.terms | {"fuel": result.terms["fuel"] + 0.1, "end": result.terms["end"] - 0.1}},
        {"terms": result.terms | {"luck": 0.0}},
        {"bound": result.cost + 0.1},
        {"bound": math.nan, "status": sky.Status.OPTIMAL},
        {"bound": None, "status": sky.Status.OPTIMAL},
        {"path": result.path[:-1]},
        {"path": np.zeros((0, 3))},
        {"path": result.path * math.nan},
    ):
        assert cost.wrong_figures(problem.scenario, rates, replace(result, **change)), change
