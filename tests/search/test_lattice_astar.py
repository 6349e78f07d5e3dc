"""Exact search against other exact searches, and against published optimal lengths."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

import skyverse as sky
from skyverse.search import lattice_astar as exact
from skyverse.search.few_turns import ORIGIN, SEEN, price_with_few_turns
from skyverse.search.lattice_astar import prices_to, shortest_route
from worlds import OBJECTIVES, exits_of, indices_of, neighbours, price_of, scenarios, shape_of


@pytest.mark.parametrize(("name", "nodes"), [("map1", 265), ("map2", 229), ("map3", 267)])
def test_the_thesis_maps_have_their_known_optima(name, nodes):
    problem = sky.Problem(sky.read(name))
    assert problem.route.price == nodes
    assert len(problem.route.nodes) == nodes


def graph(scenario):
    """Edges by brute force: from node, to node, which of the neighbourhood's steps, its price."""
    steps = neighbours(scenario.lattice.connectivity)
    open_ = exits_of(scenario, steps)
    indices, shape = indices_of(scenario), shape_of(scenario)
    a, m = np.nonzero(open_)
    b = np.ravel_multi_index(tuple((indices[a] + steps[m]).T), shape)
    lengths = np.linalg.norm(steps * np.array(scenario.lattice.step), axis=1)
    objective = scenario.objective
    price = objective.fuel * (np.ones(len(steps)) if objective.unit == "nodes" else lengths)
    return len(indices), a, b, m, price[m], steps


def prices_by_dijkstra(scenario, source):
    """The price of every node from one: scipy over nodes and *directed* headings, turns paid on the edge."""
    n, a, b, m, price, steps = graph(scenario)
    k = len(steps)
    objective = scenario.objective
    first = objective.fuel if objective.unit == "nodes" else 0.0
    if objective.divergence == 0.0:
        found = dijkstra(coo_array((price, (a, b)), shape=(n, n)).tocsr(), indices=source)
        return first + found
    turn = np.array([[bool(np.any(np.cross(h, g))) for g in steps] for h in steps])
    h = np.arange(k)
    rows = (a[:, None] * k + h).ravel()
    columns = np.repeat(b * k + m, k)
    weights = (price[:, None] + objective.divergence * turn[:, m].T).ravel()
    begin = a == source  # one more state: at the source, with no heading yet
    rows = np.r_[rows, np.full(begin.sum(), n * k)]
    columns = np.r_[columns, (b * k + m)[begin]]
    weights = np.r_[weights, price[begin]]
    found = dijkstra(coo_array((weights, (rows, columns)), shape=(n * k + 1, n * k + 1)).tocsr(), indices=n * k)
    prices = found[:-1].reshape(n, k).min(axis=1)
    prices[source] = 0.0
    return first + prices


def compiled(scenario):
    airspace = sky.Airspace(scenario)
    return airspace.grid, airspace.pricing


TURNS = st.builds(
    sky.Objective,
    fuel=st.sampled_from([0.1, 1.0, 3.0]),
    divergence=st.sampled_from([0.001, 0.3, 1.0, 20.0]),
    unit=st.sampled_from(["nodes", "metres"]),
)


def check_route(scenario, source, goal):
    grid, pricing = compiled(scenario)
    truth = prices_by_dijkstra(scenario, source)[goal]
    route = shortest_route(grid, pricing, source, goal)
    if math.isinf(truth):
        assert route is None
        return
    assert route is not None
    assert route.price == pytest.approx(truth, rel=1e-9)
    assert route.nodes[0] == source
    assert route.nodes[-1] == goal
    _, a, b, *_ = graph(scenario)
    assert shortest_route(grid, pricing, source, goal, 1.0001 * truth).price == route.price
    assert source == goal or shortest_route(grid, pricing, source, goal, 0.9999 * truth) is None
    edges = set(zip(a.tolist(), b.tolist(), strict=True))
    assert all(edge in edges for edge in zip(route.nodes[:-1].tolist(), route.nodes[1:].tolist(), strict=True))
    places = np.array(scenario.bounds.min) + indices_of(scenario)[route.nodes] * np.array(scenario.lattice.step)
    assert sum(price_of(scenario, places)) == pytest.approx(route.price, rel=1e-9)


@given(scenarios(most_nodes=7), st.data())
@settings(max_examples=60)
def test_a_route_costs_what_dijkstra_finds(scenario, data):
    node = st.integers(0, len(indices_of(scenario)) - 1)
    check_route(scenario, data.draw(node), data.draw(node))


@given(scenarios(most_nodes=5, objectives=TURNS), st.data())
@settings(max_examples=60)
def test_a_route_that_pays_for_turns_costs_what_dijkstra_over_headings_finds(scenario, data):
    node = st.integers(0, len(indices_of(scenario)) - 1)
    check_route(scenario, data.draw(node), data.draw(node))


@pytest.mark.parametrize("connectivity", [6, 26])
@pytest.mark.parametrize("unit", ["nodes", "metres"])
@pytest.mark.parametrize("turn", [0.0, 0.3, 7.0])
def test_a_maze_of_thin_walls_costs_what_dijkstra_finds(connectivity, unit, turn):
    rng = np.random.default_rng(0)
    walls = []
    for x in range(1, 9):
        gap, up = rng.uniform(0.5, 7.5, 2)
        walls += [
            sky.Box(min=(x - 0.55, -1, -1), max=(x - 0.5, gap, 9)),
            sky.Box(min=(x - 0.55, gap + 1.2, -1), max=(x - 0.5, 9, 9)),
            sky.Box(min=(x - 0.55, -1, up), max=(x - 0.5, 9, up + 1.5)),
        ]
    scenario = sky.Scenario(
        name="maze",
        bounds=sky.Bounds(min=(0, 0, 0), max=(8, 8, 8)),
        obstacles=[w.model_dump() for w in walls],
        clearance=0.05,
        lattice=sky.Lattice(step=(1, 0.5, 1), connectivity=connectivity),
        objective=sky.Objective(divergence=turn, unit=unit),
    )
    n = len(indices_of(scenario))
    check_route(scenario, 0, n - 1)
    check_route(scenario, n - 1, n // 2)


@given(scenarios(most_nodes=5, objectives=OBJECTIVES), st.data())
def test_prices_to_many_goals_are_what_dijkstra_finds(scenario, data):
    node = st.integers(0, len(indices_of(scenario)) - 1)
    source, goals = data.draw(node), data.draw(st.lists(node, min_size=1, max_size=6))
    found = prices_to(*compiled(scenario), source, np.array(goals))
    np.testing.assert_allclose(found, prices_by_dijkstra(scenario, source)[goals], rtol=1e-9)


@pytest.mark.parametrize("connectivity", [6, 26])
@pytest.mark.parametrize("unit", ["nodes", "metres"])
@pytest.mark.parametrize("step", [(1, 1, 1), (0.1, 0.25, 1), (1, 0.1, 0.25), (0.25, 1, 0.1)])
def test_the_heuristic_is_exact_on_an_empty_lattice_and_never_too_high_with_turns(connectivity, unit, step):
    scenario = sky.Scenario(
        name="empty",
        bounds=sky.Bounds(min=(0, 0, 0), max=[6 * s for s in step]),
        clearance=0.001,
        lattice=sky.Lattice(step=step, connectivity=connectivity),
        objective=sky.Objective(unit=unit),
    )
    grid, pricing = compiled(scenario)
    middle = int(np.ravel_multi_index((3, 3, 3), shape_of(scenario)))
    away = indices_of(scenario) - 3
    guide = pricing.first + np.array([exact._steps_left(grid, pricing, *map(int, d)) for d in away])
    np.testing.assert_allclose(guide, prices_by_dijkstra(scenario, middle), rtol=1e-12)
    # a dear turn: what is left over after the steps is turns, so there are at least as many as the guide says
    turning = scenario.model_copy(update={"objective": sky.Objective(unit=unit, divergence=1000)})
    axes = range(connectivity // 2)  # the first move may be along any
    turns = np.array([min(exact._turns_left(grid, axis, *map(int, d)) for axis in axes) for d in away])
    needed = np.floor(prices_by_dijkstra(turning, middle) / 1000)
    assert (turns <= needed).all()
    assert turns.max() == (2 if connectivity == 6 else 1)


def test_where_turns_have_a_price_few_of_the_13_states_of_a_node_are_expanded():
    scenario = sky.read("map2").model_copy(update={"objective": sky.Objective(divergence=0.3)})
    diagonal = scenario.lattice.model_copy(update={"connectivity": 26})
    problem = sky.Problem(scenario.model_copy(update={"lattice": diagonal}))
    assert problem.route.expanded < 3 * len(problem.airspace.grid.exits)


def test_a_goal_behind_a_wall_has_no_route_and_no_price():
    wall = sky.Box(min=(1.4, 0, 0), max=(1.6, 3, 3))
    for objective in ("thesis", "turns"):
        scenario = sky.Scenario(
            name="cut",
            bounds=sky.Bounds(min=(0, 0, 0), max=(3, 3, 3)),
            obstacles=(wall,),
            clearance=0.001,
            lattice=sky.Lattice(step=(1, 1, 1)),
            objective=objective,
        )
        assert shortest_route(*compiled(scenario), 0, 63) is None
        np.testing.assert_array_equal(
            prices_to(*compiled(scenario), 0, np.array([63, 0, 15])), [np.inf, 1, pay(objective)]
        )


def pay(objective):
    return 7 if objective == "thesis" else 7.3


def test_the_path_from_a_node_to_itself_is_that_node():
    scenario = sky.read("map1")
    airspace = sky.Airspace(scenario)
    for pricing in (airspace.pricing, airspace.pricing._replace(turn=0.3)):
        route = shortest_route(airspace.grid, pricing, 5, 5)
        assert route.nodes.tolist() == [5]
        assert route.price == 1


def price_with_few(scenario, node):
    """What the function says, the length alone, and the exact price, each without the first node; all from node 0."""
    plain = scenario.model_copy(update={"objective": scenario.objective.model_copy(update={"divergence": 0.0})})
    first = scenario.objective.fuel if scenario.objective.unit == "nodes" else 0.0
    lengths = prices_by_dijkstra(plain, 0) - first
    flags = np.where(np.isfinite(lengths), SEEN, 0).astype(np.uint8)
    flags[0] = SEEN | ORIGIN
    grid, pricing = compiled(scenario)
    found = price_with_few_turns(grid, pricing, flags, lengths, node)
    return found, lengths[node], prices_by_dijkstra(scenario, 0)[node] - first


@given(scenarios(most_nodes=6, objectives=TURNS), st.data())
@settings(max_examples=60, deadline=None)
def test_few_turns_are_whole_turns_of_a_shortest_path_and_no_cheaper_than_the_cheapest(scenario, data):
    grid, _ = compiled(scenario)
    node = data.draw(st.integers(0, len(grid.exits) - 1))
    found, length, cheapest = price_with_few(scenario, node)
    if not np.isfinite(length) or node == 0:
        return
    assert found >= cheapest * (1 - 1e-9)
    turns = (found - length) / scenario.objective.divergence
    assert turns == pytest.approx(round(turns), abs=1e-3 + 1e-9 * length / scenario.objective.divergence)
    assert 0 <= round(turns) < len(grid.exits)


@given(st.tuples(*[st.integers(0, 4)] * 3), st.sampled_from([6, 26]), TURNS)
@settings(max_examples=60, deadline=None)
def test_where_nothing_is_in_the_way_no_path_with_other_turns_is_cheaper(place, connectivity, objective):
    scenario = sky.Scenario(
        name="empty",
        bounds=sky.Bounds(min=(0, 0, 0), max=(4, 4, 4)),
        clearance=0.001,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=connectivity),
        objective=objective.model_copy(update={"divergence": 0.01 * objective.fuel}),
    )
    found, _, cheapest = price_with_few(scenario, int(np.ravel_multi_index(place, (5, 5, 5))))
    assert found == pytest.approx(cheapest)
