"""Optima are searched anew with the referee's own code, and what it cannot search stays a claim."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from judged_missions import SCENARIO, VALID, alpha, no_result, resulting
from skyverse.model.result import Status
from skyverse.model.scenario import AltitudeBand, Bounds, ClimbLimit, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere
from skyverse.model.uav import UAV
from skyverse.model.verdict import Verdict
from skyverse.referee import check_optimality, optimality
from skyverse.referee.lattice import cheapest_path, free_moves, judged_lattice, reachable_nodes
from skyverse.referee.optimality import _soft_price
from skyverse.referee.world import referee_world

PROVEN, REFUTED, UNDECIDED = Verdict.PROVEN, Verdict.REFUTED, Verdict.UNDECIDED


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


def told_unit(scenario):
    return "nodes" if scenario.objective.unit == "nodes" else "m"


def judged(scenario, mission):
    (found,) = check_optimality(scenario, mission)
    assert found.scenario == scenario.digest
    return found


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 6))])
@pytest.mark.parametrize(
    "objective",
    [{}, {"unit": "nodes"}, {"divergence": 0.7}, {"divergence": 0.7, "unit": "nodes", "fuel": 0.3}],
    ids=["metres", "nodes", "turns", "turns and nodes"],
)
def test_the_planners_optimum_is_the_referees(seed, objective):
    scenario = room(seed, **objective)
    mission = sky.plan_mission(scenario, sky.AStar(), rng=1, shape="stop-and-go")
    assert mission.results[0].status is Status.OPTIMAL
    found = judged(scenario, mission)
    assert found.verdict is PROVEN, found.sentence
    result = mission.results[0]
    assert found.sentence.endswith(f" costs less than {result.cost:.9g} {told_unit(scenario)}.")
    dearer = replace(mission, results=(replace(result, cost=result.cost + 0.3, bound=result.bound + 0.3),))
    found = judged(scenario, dearer)
    assert found.verdict is not PROVEN
    assert found.verdict is REFUTED or "with what is let pass" in found.sentence
    modest = replace(mission, results=(replace(result, status=Status.COMPLETE, bound=result.bound - 0.3),))
    assert judged(scenario, modest).verdict is PROVEN


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


def test_altitude_and_climb_are_searched_too():
    soft = {"altitude": AltitudeBand(low=1.0, high=2.0, weight=0.5), "climb": ClimbLimit(angle=20, weight=2.0)}
    scenario = room(1, **soft).model_copy(update={"lattice": Lattice(step=(1, 1, 0.5), connectivity=26)})
    mission = sky.plan_mission(scenario, sky.AStar(), rng=1, shape="stop-and-go")
    assert judged(scenario, mission).verdict is PROVEN
    (found,) = check_optimality(scenario, mission, max_states=100)
    assert found.verdict is UNDECIDED
    assert "optimal, as claimed by the planner: its lattice has 729 states, above 100." in found.sentence


@pytest.mark.parametrize("risk", [0.5, 3.0])
def test_the_risk_of_zones_is_searched_too(risk):
    zones = (Box(min=(-9, -9, -9), max=(99, 99, 99), risk=2.0),)
    wide = {"obstacles": (), "zones": zones, "lattice": Lattice(step=(4, 4, 4), connectivity=6)}
    scenario = room(0, risk=risk).model_copy(update=wide)
    ends = {"start": np.zeros(3), "goal": np.array([8.0, 8, 4])}
    for more, refuted in ((0.0, False), (0.1, True)):
        claimed = replace(alpha(bound=20 * (1 + risk * 2.0) + more, **ends), assignment=(0,))
        assert (judged(scenario, claimed).verdict is REFUTED) is refuted


@pytest.mark.parametrize(
    ("objective", "zones"),
    [
        ({"altitude": AltitudeBand(low=1.0, high=2.0, weight=0.5)}, ()),
        ({"climb": ClimbLimit(angle=20, weight=2.0)}, ()),
        ({}, (Box(min=(0, 0, 0), max=(1, 1, 1), risk=2.0),)),
    ],
)
def test_fewer_states_are_searched_where_moves_have_soft_terms(objective, zones, monkeypatch):
    monkeypatch.setattr(optimality, "MAX_PRICED_STATES", 10)
    changes = {"objective": SCENARIO.objective.model_copy(update=objective), "zones": zones}
    assert "above 10." in check_optimality(SCENARIO.model_copy(update=changes), VALID)[0].sentence
    assert "above 10." not in check_optimality(SCENARIO, VALID)[0].sentence


def test_a_path_of_any_angle_is_optimal_where_it_is_straight_and_otherwise_as_claimed():
    free = room(0).model_copy(update={"obstacles": ()})
    mission = sky.plan_mission(free, sky.Taut(), rng=1, shape="stop-and-go")
    found = judged(free, mission)
    assert found.verdict is PROVEN
    assert found.sentence.endswith(f"the straight line alone costs {mission.results[0].cost:.9g} m.")
    bent = sky.plan_mission(room(0), sky.Taut(), rng=1, shape="stop-and-go")
    bound = bent.results[0].bound + 0.1
    found = judged(room(0), replace(bent, results=(replace(bent.results[0], bound=bound),)))
    assert found.verdict is UNDECIDED
    assert "as claimed by the planner: its result carries no witness" in found.sentence
    assert found.sentence.endswith(" m.")


@pytest.mark.parametrize(("more", "straight"), [(0.0, True), (0.1, False)])
def test_the_bound_of_a_path_of_any_angle_is_compared_with_the_straight_line(more, straight):
    fuel = SCENARIO.objective.fuel
    way = np.subtract(SCENARIO.targets[VALID.assignment[0]].position, SCENARIO.uavs[0].start)
    (found, *_) = check_optimality(SCENARIO, alpha(any_angle=True, bound=fuel * np.linalg.norm(way) + more))
    assert ("carries no witness" not in found.sentence) is straight


def test_a_path_that_needs_what_is_let_pass_refutes_nobody():
    """A gap that is a little too narrow is free for the referee, which lets a micrometre pass, but not for planners."""
    walls = (Box(min=(4, 0, 0), max=(4.2, 3.9, 4)), Box(min=(4, 4.1 - 5e-7, 0), max=(4.2, 8, 3)))
    low = (Target(position=(7.8, 7.8, 0.2)),)
    scenario = Scenario.model_validate(room(0).model_dump() | {"obstacles": walls, "targets": low})
    mission = sky.plan_mission(scenario, sky.AStar(), rng=1, shape="stop-and-go")
    found = judged(scenario, mission)
    assert found.verdict is UNDECIDED
    assert "keeps clear by less than 4e-06 m more than it must" in found.sentence


def test_that_there_is_no_path_is_proven_on_the_lattice():
    shut = room(0).model_copy(update={"obstacles": (Box(min=(4, 0, 0), max=(4.2, 8, 4)),)})
    mission = sky.plan_mission(shut, sky.AStar(), rng=1)
    assert mission.results[0].status is Status.NO_PATH
    assert judged(shut, mission).verdict is PROVEN
    lazy = replace(mission, scenario=room(0))
    found = judged(room(0), lazy)
    assert found.verdict is UNDECIDED
    assert "has no path, as claimed by the planner" in found.sentence


def test_what_claims_nothing_is_not_judged_and_junk_raises_nothing():
    assert check_optimality(SCENARIO, alpha(bound=None))[0] is None
    assert check_optimality(SCENARIO, alpha(status=Status.INCOMPLETE))[0] is None
    assert check_optimality(SCENARIO, VALID)[2] is None
    for field, value in (("bound", "low"), ("bound", np.nan), ("start", None), ("goal", np.zeros(2)), ("status", 3)):
        found = check_optimality(SCENARIO, alpha(**{field: value}))[0]
        assert found is None or found.verdict is not PROVEN
    assert check_optimality(SCENARIO, resulting(no_result(Status.NO_PATH)))[0].verdict is UNDECIDED
    assert check_optimality(SCENARIO, replace(VALID, results=(), assignment=()))[:1] == (None,)


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


def test_diagonal_moves_over_terrain_stay_a_claim():
    scenario = sky.read_scenario("jacksboro")
    claim = replace(VALID.results[1], path=np.zeros((1, 3)), cost=1.0, bound=1.0)
    mission = replace(VALID, scenario=scenario, results=(claim,) * 5, assignment=(0, 1, 2, 3, 4))
    found = check_optimality(scenario, mission)[0]
    assert found.verdict is UNDECIDED
    assert "only among boxes, cylinders and spheres" in found.sentence


def test_going_back_is_no_turn_and_turns_have_a_price():
    scenario = room(0).model_copy(update={"obstacles": ()})
    lattice = judged_lattice(referee_world(scenario), strict=False)
    start, goal = lattice.node(np.zeros(3)), lattice.node(np.array([1.0, 1.0, 0.0]))
    by_length = np.full(len(lattice.moves), 0.5)
    assert cheapest_path(lattice, start, goal, by_length, 0.0)[0] == 2.0
    cost, nodes = cheapest_path(lattice, start, goal, by_length, 10.0)
    assert (cost, len(nodes)) == (12.0, 5)


def test_a_bound_that_holds_for_other_ends_proves_nothing():
    scenario = room(1)
    mission = sky.plan_mission(scenario, sky.AStar(), rng=1, shape="stop-and-go")
    assert judged(scenario, mission).verdict is PROVEN
    result = mission.results[0]
    for forged in (replace(result, goal=np.zeros(3), bound=0.0), replace(result, path=result.path[:-1])):
        found = judged(scenario, replace(mission, results=(forged,)))
        assert found.verdict is UNDECIDED
        assert "its result is wrong elsewhere" in found.sentence


def test_nodes_that_planners_may_block_refute_nothing():
    wall = Box(min=(3, 0, 0), max=(5, 8, 2.9 - 2.5e-6))
    low = (Target(position=(7.8, 7.8, 0.2)),)
    scenario = room(2).model_copy(update={"obstacles": (wall,), "targets": low})
    mission = sky.plan_mission(scenario, sky.AStar(), rng=1, shape="stop-and-go")
    assert mission.results[0].status is Status.OPTIMAL
    assert judged(scenario, mission).verdict is not REFUTED


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


@pytest.mark.parametrize("field", ["start", "goal"])
def test_a_bound_between_places_that_are_no_nodes_stays_a_claim(field):
    found = check_optimality(SCENARIO, alpha(**{field: np.array([0.3, 4.0, 1.0])}))[0]
    assert found.verdict is not PROVEN


def test_moves_cost_what_their_soft_terms_cost():
    leg, length = np.array([[1.0, 1.0, 1.0], [2.0, 1.0, 2.0]]), np.sqrt(2)
    climb = ClimbLimit(angle=20, weight=3.0)
    band = AltitudeBand(low=0, high=0.5, weight=2.0)
    for fields, more in (({}, 0), ({"climb": climb}, 3 * np.radians(25) * length), ({"altitude": band}, 2 * length)):
        scenario = room(0).model_copy(update={"objective": Objective(unit="metres", fuel=5.0, **fields)})
        world = referee_world(scenario)
        found = [_soft_price(world, leg, by_nodes, strict=False) for by_nodes in (False, True)]
        assert found == pytest.approx([5 * length + more, 5 + more])
