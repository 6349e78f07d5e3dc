"""Straight flights and the stretches that they replace, against brute force and the exact optimum."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse import cost
from skyverse.planners import subpaths
from skyverse.planners.contact import contact_of
from skyverse.planners.moves import LatticeTask
from skyverse.search.lattice_astar import shortest_route
from worlds import exits_of, indices_of, scenarios


@settings(deadline=None)
@given(scenarios(most_nodes=6), st.integers(0, 5), st.data())
def test_a_flight_is_safe_as_long_as_the_way_and_turns_twice_at_most(scenario, order, data):
    grid = sky.Airspace(scenario).grid
    open_, indices = exits_of(scenario, grid.moves), indices_of(scenario)
    a, b = (data.draw(st.integers(0, len(indices) - 1)) for _ in range(2))
    draft, spent = np.full(60, a), np.zeros(3, np.int64)
    length = subpaths.fly(grid, draft, spent, order, 1, b)
    flown = spent[1] + 1
    assert spent[0] == 1
    steps = np.diff(indices[draft[:flown]], axis=0).tolist()
    moves = [grid.moves.tolist().index(step) for step in steps]
    assert all(open_[node, m] for node, m in zip(draft[: flown - 1], moves, strict=True))
    assert sum(m != n for m, n in itertools.pairwise(moves)) <= 2
    if length:
        way = np.abs(indices[b] - indices[a])
        assert length == flown == 1 + (way.sum() if len(grid.moves) == 6 else way.max())
        assert draft[length - 1] == b
    else:
        left = indices[b] - indices[draft[flown - 1]]
        onward = [m for m, move in enumerate(grid.moves) if ((move == 0) | (move == np.sign(left))).all()]
        assert not open_[draft[flown - 1], onward].all()


@settings(deadline=None)
@given(scenarios(most_nodes=6), st.data())
def test_in_empty_space_a_flight_is_the_cheapest_path(scenario, data):
    objective = sky.Objective(unit=scenario.objective.unit)
    airspace = sky.Airspace(scenario.model_copy(update={"obstacles": (), "objective": objective}))
    grid, pricing = airspace.grid, airspace.pricing
    a, b = (data.draw(st.integers(0, len(grid.exits) - 1)) for _ in range(2))
    diagonal = len(grid.moves) > 6
    price = subpaths.flight_price(pricing.steps, grid.shape[1], grid.shape[2], diagonal, a, b)
    np.testing.assert_allclose(price + pricing.first, shortest_route(grid, pricing, a, b).price, atol=1e-9)


@settings(deadline=None)
@given(scenarios(most_nodes=5), st.data())
def test_a_stretch_in_anothers_place_changes_the_cost_by_the_gain(scenario, data):
    airspace = sky.Airspace(scenario.model_copy(update={"obstacles": ()}))
    grid, pricing = airspace.grid, airspace.pricing
    node = st.integers(0, len(grid.exits) - 1)
    order, spent = st.integers(0, 5), np.zeros(3, np.int64)
    row = np.zeros(300, np.int64)
    row[0] = data.draw(node)
    n = 1
    for _ in range(4):
        n = subpaths.fly(grid, row, spent, data.draw(order), n, data.draw(node))
    a = data.draw(st.integers(0, n - 1))
    b = data.draw(st.integers(a, n - 1))
    goal = data.draw(node)
    task = LatticeTask(grid, pricing, contact_of(sky.Problem(airspace)), int(row[0]), goal)
    path, draft = row[:n].tolist(), np.zeros(300, np.int64)
    length = subpaths.begin_stretch(draft, row, a)
    end = int(row[b]) if b < n - 1 else data.draw(node)
    for via in (data.draw(node), end):
        length = subpaths.fly(grid, draft, spent, data.draw(order), length, via)
    new = path[:a] + draft[min(1, a) : length].tolist() + path[b + 1 :]
    gain = subpaths.gain_of(task, row, n, a, b, draft, length)
    m = subpaths.replace_stretch(row, n, a, b, draft, length)
    assert row[:m].tolist() == new
    old, now = (cost.total(grid, pricing, np.array(nodes), goal) for nodes in (path, new))
    np.testing.assert_allclose(gain, old - now, atol=1e-8)
