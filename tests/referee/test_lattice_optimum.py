"""The optimum of the lattice is that of an oracle, which searches anew with the referee's geometry."""

import numpy as np
import pytest

import skyverse as sky
from judged_missions import SCENARIO
from lattice_oracle import cheapest_costs, cheapest_path, free_moves, judged_lattice, reachable_nodes, soft_price
from skyverse.model.result import Status
from skyverse.model.scenario import AltitudeBand, Bounds, ClimbLimit, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere
from skyverse.model.uav import UAV
from skyverse.referee.world import referee_world


def room(seed, **objective):
    rng = np.random.default_rng(seed)
    middles = rng.uniform(1, 7, size=(6, 3)) * [1, 1, 0.5]
    reach = np.array([0.6, 0.8, 1.0])
    shapes = [Box(min=tuple(middle - reach), max=tuple(middle + reach)) for middle in middles[:3]]
    shapes += [Sphere(centre=tuple(middles[3]), radius=1.0), Sphere(centre=tuple(middles[4]), radius=0.7)]
    shapes.append(Cylinder(centre=tuple(middles[5, :2]), radius=0.8, low=0.0, high=3.0))
    connectivity = 26 if seed % 2 else 6
    return Scenario(
        name=f"room {seed}",
        bounds=Bounds(min=(0, 0, 0), max=(8, 8, 4)),
        obstacles=tuple(shapes),
        clearance=0.1,
        lattice=Lattice(step=(0.5, 0.5, 0.5), connectivity=connectivity),
        objective=Objective(**({"fuel": 1, "end": 10, "unit": "metres"} | objective)),
        uavs=(UAV(start=(0.2, 0.2, 0.2)),),
        targets=(Target(position=(7.8, 7.8, 3.8)),),
    )


def optimum_of(scenario):
    """The cost of the planner's optimum, and the least and the most that the oracle finds."""
    result = sky.AStar().plan(sky.Problem(scenario))
    assert result.status is Status.OPTIMAL
    assert result.bound == pytest.approx(result.cost, rel=1e-9)
    return result.cost, *cheapest_costs(scenario, result.start, result.goal)


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 6))])
@pytest.mark.parametrize(
    "objective",
    [{}, {"unit": "nodes"}, {"divergence": 0.7}, {"divergence": 0.7, "unit": "nodes", "fuel": 0.3}],
    ids=["metres", "nodes", "turns", "turns and nodes"],
)
def test_the_planners_optimum_is_the_oracles(seed, objective):
    cost, least, most = optimum_of(room(seed, **objective))
    assert least * (1 - 1e-9) <= cost <= most * (1 + 1e-9)
    assert most == pytest.approx(least)


def test_nodes_are_numbered_by_their_places():
    lattice = judged_lattice(referee_world(SCENARIO), strict=False)
    for node in (0, 1, 40, int(np.prod(lattice.shape)) - 1):
        index = np.array(np.unravel_index(node, lattice.shape))
        assert lattice.position(node).tolist() == (lattice.low + lattice.step * index).tolist()
        assert lattice.node(lattice.position(node)) == node
    coarse = room(1).model_copy(update={"lattice": Lattice(step=(4, 4, 4), connectivity=26)})
    whole = judged_lattice(referee_world(coarse), strict=False)
    assert len({tuple(move) for move in np.vstack([whole.moves, -whole.moves]).tolist()}) == 26
    assert np.abs(whole.moves).max() == 1
    assert lattice.node(lattice.position(0) - [0, 0, 1]) is None
    assert lattice.node(lattice.position(0) + lattice.step * lattice.shape * [0, 1, 0]) is None


@pytest.mark.parametrize(
    "soft",
    [
        {"altitude": AltitudeBand(low=1.0, high=2.0, weight=0.5), "climb": ClimbLimit(angle=20, weight=2.0)},
        {"risk": 0.5},
        {"risk": 3.0},
    ],
)
def test_the_optimum_with_soft_terms_is_the_oracles(soft):
    zones = (Box(min=(2, 2, 0), max=(5.3, 5.3, 3.3), risk=2.0),) if "risk" in soft else ()
    changes = {"lattice": Lattice(step=(1, 1, 0.5), connectivity=26), "zones": zones}
    cost, least, most = optimum_of(room(1, **soft).model_copy(update=changes))
    assert least * (1 - 1e-9) <= cost <= most * (1 + 1e-9)


def test_the_optimum_through_a_gap_that_is_too_narrow_by_what_is_let_pass_lies_between_both_of_the_oracle():
    walls = (Box(min=(4, 0, 0), max=(4.2, 3.9, 4)), Box(min=(4, 4.1 - 5e-7, 0), max=(4.2, 8, 3)))
    low = (Target(position=(7.8, 7.8, 0.2)),)
    cost, least, most = optimum_of(Scenario.model_validate(room(0).model_dump() | {"obstacles": walls, "targets": low}))
    assert least < cost <= most


def test_where_no_path_is_found_the_lattice_joins_no_nodes_at_its_ends():
    shut = room(0).model_copy(update={"obstacles": (Box(min=(4, 0, 0), max=(4.2, 8, 4)),)})
    assert sky.AStar().plan(sky.Problem(shut)).status is Status.NO_PATH
    lattice = judged_lattice(referee_world(shut), strict=False)
    assert lattice.node(np.array([8.0, 8, 4])) not in reachable_nodes(lattice, {lattice.node(np.zeros(3))})


def test_moves_are_free_exactly_where_no_shape_is():
    scenario = room(1)
    world = referee_world(scenario)
    lattice = judged_lattice(world, strict=False)
    shares = np.stack(np.meshgrid(*[np.linspace(0, 1, 9)] * 3), axis=-1).reshape(-1, 3)
    assert tuple(lattice.shape) == (17, 17, 9)
    for number in range(0, 17 * 17 * 9, 7):
        place = lattice.position(number)
        assert lattice.node(place) == number
        for move, free in zip(lattice.moves, lattice.free[:, number], strict=True):
            places = place + shares * move * 0.5
            inside = ((places >= -1e-9) & (places <= np.array([8, 8, 4]) + 1e-9)).all()
            assert not free or (inside and not blocked(scenario, places, 0.1))
            assert free or not inside or blocked(scenario, places, 0.2)


def blocked(scenario, places, grown):
    boxes, spheres, (tower,) = scenario.obstacles[:3], scenario.obstacles[3:5], scenario.obstacles[5:]
    hits = [((places > np.array(b.min) - grown) & (places < np.array(b.max) + grown)).all(axis=1) for b in boxes]
    hits += [np.linalg.norm(places - s.centre, axis=1) < s.radius + grown for s in spheres]
    beside = np.linalg.norm(places[:, :2] - tower.centre, axis=1) < tower.radius + grown
    hits.append(beside & (places[:, 2] > tower.low - grown) & (places[:, 2] < tower.high + grown))
    return bool(np.any(hits))


@pytest.mark.parametrize(("corner", "free"), [(1.6, True), (1.7, False), (4.0, False)])
def test_a_move_is_free_where_its_block_keeps_clear_of_a_sphere(corner, free):
    sphere = Sphere(centre=(2, 2, 2), radius=0.5)
    judge = referee_world(room(0).model_copy(update={"obstacles": (sphere,)}))
    found = free_moves(judge, np.array([[1.0, 1, 1]]), np.full((1, 3), corner), strict=True)
    assert found.tolist() == [free]


def test_going_back_is_no_turn_and_turns_have_a_price():
    scenario = room(0).model_copy(update={"obstacles": ()})
    lattice = judged_lattice(referee_world(scenario), strict=False)
    start, goal = lattice.node(np.zeros(3)), lattice.node(np.array([1.0, 1.0, 0.0]))
    by_length = np.full(len(lattice.moves), 0.5)
    assert cheapest_path(lattice, start, goal, by_length, 0.0)[0] == 2.0
    cost, nodes = cheapest_path(lattice, start, goal, by_length, 10.0)
    assert (cost, len(nodes)) == (12.0, 5)


def test_nodes_that_planners_may_block_are_none_that_they_have_to_use():
    wall = Box(min=(3, 0, 0), max=(5, 8, 2.9 - 2.5e-6))
    low = (Target(position=(7.8, 7.8, 0.2)),)
    cost, least, most = optimum_of(room(2).model_copy(update={"obstacles": (wall,), "targets": low}))
    assert least <= cost <= most


def test_moves_out_of_a_lattice_of_two_rows_are_not_free():
    scenario = room(1).model_copy(update={"obstacles": (), "bounds": Bounds(min=(0, 0, 0), max=(8, 0.5, 4))})
    lattice = judged_lattice(referee_world(scenario), strict=False)
    last = lattice.free.shape[1] - 1
    price = np.ones(len(lattice.moves))
    assert reachable_nodes(lattice, {last}) == set(range(last + 1))
    assert cheapest_path(lattice, last, 0, price, 0.0)[0] == 16.0


@pytest.mark.parametrize("strict", [True, False])
@pytest.mark.parametrize(("a", "b"), [((1, 1, 1), (3, 1, 1)), ((3, 1, 1), (1, 1, 1)), ((1, 1, 1), (1, 3, 1))])
def test_a_move_out_of_a_prism_is_not_free(a, b, strict):
    prism = Prism(vertices=((0, 0), (2, 0), (2, 2), (0, 2)), low=0, high=2)
    judge = referee_world(room(0).model_copy(update={"obstacles": (prism,)}))
    assert free_moves(judge, np.array([a], float), np.array([b], float), strict).tolist() == [False]
    assert free_moves(judge, np.array([a], float) + 4, np.array([b], float) + 4, strict).tolist() == [True]


@pytest.mark.parametrize("strict", [True, False])
def test_nodes_on_the_bounds_less_the_error_count_unless_all_planners_must_be_able_to_use_them(strict):
    scenario = room(0).model_copy(update={"obstacles": ()})
    lattice = judged_lattice(referee_world(scenario, sky.TrackingError(horizontal=1.0, vertical=1.0)), strict=strict)
    usable = {tuple(lattice.position(int(n)).tolist()) for n in np.flatnonzero(lattice.free.any(axis=0))}
    assert ((1.0, 3.0, 2.0) in usable) is not strict
    assert (0.5, 3.0, 2.0) not in usable
    assert (2.0, 3.0, 2.0) in usable


def test_moves_cost_what_their_soft_terms_cost():
    leg, length = np.array([[1.0, 1.0, 1.0], [2.0, 1.0, 2.0]]), np.sqrt(2)
    climb = ClimbLimit(angle=20, weight=3.0)
    band = AltitudeBand(low=0, high=0.5, weight=2.0)
    for fields, more in (({}, 0), ({"climb": climb}, 3 * np.radians(25) * length), ({"altitude": band}, 2 * length)):
        scenario = room(0).model_copy(update={"objective": Objective(unit="metres", fuel=5.0, **fields)})
        world = referee_world(scenario)
        found = [soft_price(world, leg, by_nodes, strict=False) for by_nodes in (False, True)]
        assert found == pytest.approx([5 * length + more, 5 + more])
