"""Taut against what is known: closed forms, near-exact lengths, another search, and the exhaustive lattice."""

import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import shortest_path

import skyverse as sky
from skyverse.numerics.tolerances import SIGHT_MARGIN
from skyverse.space.cells import FREE, SHUT, make_cells
from worlds import hall as empty_hall
from worlds import scenarios


def hall(*boxes, start=(1, 5, 2), target=(9, 5, 2), **changes):
    return empty_hall(*boxes, start=start, target=target, **changes)


def taut(scenario, **settings_):
    result = sky.Taut(**settings_).plan(sky.Problem(scenario))
    assert sky.check_result(scenario, 0, 0, result) == []
    return result


@pytest.mark.parametrize(
    ("name", "clearance", "length"),
    [
        ("map1", 0.25, 22.4106),
        ("map2", 0.25, 26.5205),
        ("map3", 0.25, 22.6379),
        ("map1", 0.001, 22.0181),
        ("map2", 0.001, 23.8601),
        ("map3", 0.001, 22.0762),
    ],
)
def test_the_maps_near_exact_lengths_are_met(name, clearance, length):
    result = taut(sky.read(name).model_copy(update={"clearance": clearance}))
    assert result.cost == pytest.approx(length, rel=1e-5 if clearance > 0.001 else 5e-4)  # these without any
    assert 0 <= result.gap < 0.07
    np.testing.assert_array_equal(result.path[0], sky.read(name).uavs[0].start)


@pytest.mark.parametrize("clearance", [0.001, 0.3])
def test_around_one_pillar_the_shorter_side_is_taken(clearance):
    result = taut(hall(((4, 3, 0), (5, 6, 5)), clearance=clearance))
    across = 1 + clearance
    by_hand = math.hypot(3 - clearance, across) + (1 + 2 * clearance) + math.hypot(4 - clearance, across)
    assert result.cost == pytest.approx(by_hand, abs=1e-5)


def test_over_one_wall_and_under_the_next_the_bends_lie_where_the_path_is_shortest():
    """Two walls cross the whole hall; another optimiser finds where on the walls' edges the path bends."""
    scenario = hall(((3, 0, 0), (3.5, 10, 3)), ((6, 0, 1), (6.5, 10, 5)), start=(1, 1, 1), target=(9, 8, 4))
    edges = np.array([(3, 3), (3.5, 3), (6, 1), (6.5, 1)])  # x and z of the edges that it must pass

    def length(y):
        points = np.vstack([[1, 1, 1], np.column_stack([edges[:, 0], y, edges[:, 1]]), [9, 8, 4]])
        return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()

    best = minimize(length, [2, 3, 5, 6], tol=1e-12)
    result = taut(scenario, proof=5000)
    assert result.cost == pytest.approx(best.fun, abs=5e-3)  # which keeps no clearance
    assert result.gap < 1e-3  # the edges are parallel: one pull takes away all jumps along them


def test_through_a_window_the_path_bends_at_its_corner():
    wall = [
        ((4, 0, 0), (4.5, 10, 2.5)),
        ((4, 0, 2.5), (4.5, 7, 5)),
        ((4, 8, 2.5), (4.5, 10, 5)),
        ((4, 7, 4), (4.5, 8, 5)),
    ]
    result = taut(hall(*wall, start=(1, 1, 1), target=(9, 2, 1)))
    inside = result.path[(result.path[:, 0] > 3.9) & (result.path[:, 0] < 4.6)]
    assert ((inside[:, 1] > 7 - 1e-6) & (inside[:, 2] > 2.5 - 1e-6)).all()
    assert result.cost < sky.ThetaStar().plan(sky.Problem(hall(*wall, start=(1, 1, 1), target=(9, 2, 1)))).cost + 1e-9


@pytest.mark.parametrize("more", [-1e-3, -3e-6, -1.1e-6, 0.0, 1e-9, 3e-7, 6.5e-7, 1.2e-6, 1e-5, 1e-3])
def test_where_a_path_bends_at_a_slit_it_is_found_if_it_leaves_the_clearance_on_both_sides(more):
    width = 0.002 + more
    scenario = hall(((4, 0, 0), (5, 5, 5)), ((4, 5 + width, 0), (5, 10, 5)), start=(1, 2, 1), target=(9, 3, 4))
    result = taut(scenario, proof=5000)
    assert result.status.reached == (more >= 0)
    if result.status.reached:
        flat = math.hypot(3, 3) + 1 + math.hypot(4, 2)
        assert result.cost == pytest.approx(math.hypot(flat, 3), abs=2e-3)
        assert result.bound <= result.cost


def test_a_slit_just_wide_enough_is_found_and_a_narrower_one_is_not():
    def slit(width):
        return hall(((4, 0, 0), (5, 5, 5)), ((4, 5 + width, 0), (5, 10, 5)), clearance=0.25, start=(1, 2, 2))

    assert taut(slit(0.5001)).status.reached
    assert taut(slit(0.4999)).status is sky.Status.NO_PATH_EXISTS


@pytest.mark.parametrize(
    "start", [(3.999, 5, 2), (5.001, 5, 2), (3.999, 2.999, 2), (3.999, 2.999, 0), (3.999, 2.999, 5), (4.5, 2.999, 2)]
)
def test_a_path_leads_away_from_a_start_on_a_wall_or_on_its_edge(start):
    scenario = hall(((4, 3, 0), (5, 6, 5)), start=start)
    assert taut(scenario).status.reached


@pytest.mark.parametrize("seed", range(40))
def test_in_random_rooms_it_is_safe_and_never_longer_than_the_lattice(seed):
    scenario = sky.random_room(seed=seed)
    problem = sky.Problem(scenario)
    result = taut(scenario)
    if problem.any_angle_refusal is None and problem.refusal is None and problem.route is not None:
        ends = problem.places([problem.source, problem.goal])
        to_lattice = math.dist(problem.start, ends[0]) + math.dist(problem.end, ends[1])
        assert result.cost <= problem.route.price + to_lattice + 1e-6
    if result.status.reached:
        assert math.dist(problem.start, problem.end) <= result.bound + 1e-9


@given(scenarios(), st.integers(0, 100))
@settings(max_examples=60)
def test_no_other_path_beats_the_bound(scenario, seed):
    scenario = scenario.model_copy(update={"objective": sky.Objective(unit="metres")})
    problem = sky.Problem(scenario)
    result = sky.Taut(proof=400).plan(problem)
    if result.status.reached and problem.refusal is None:
        other = sky.ThetaStar().plan(problem)
        if other.status.reached:
            assert result.bound <= other.cost + 1e-6


@given(scenarios(most_boxes=8), st.integers(0, 2**32))
def test_the_cells_are_free_or_shut_as_points_in_them_are(scenario, seed):
    space = sky.World(scenario).space
    cells = make_cells(space, space.clearance + SIGHT_MARGIN)
    leaves = np.flatnonzero(cells.axis < 0)
    sizes = (cells.high - cells.low)[leaves]
    assert sizes.prod(axis=1).sum() == pytest.approx((space.high - space.low).prod())
    rng = np.random.default_rng(seed)
    wide = leaves[(sizes > 1e-5).all(axis=1)]
    for leaf in rng.choice(wide, min(20, len(wide)), replace=False):
        p = cells.low[leaf] + rng.uniform(0.1, 0.9, 3) * (cells.high - cells.low)[leaf]
        assert cells.axis[leaf] in (FREE, SHUT)
        assert sky.World(scenario).free(p)[0] == (cells.axis[leaf] == FREE)


def test_a_city_is_crossed_within_a_percent_of_the_straight_line():
    city = sky.random_city(2000, seed=0)
    result = taut(city)
    assert result.gap < 0.002


@pytest.mark.parametrize(("name", "world"), json.loads((Path(__file__).parent / "clutter.json").read_text()).items())
def test_among_crossing_walls_the_shortest_way_round_is_found_that_is_known(name, world):
    given = {key: world[key] for key in ("start", "target", "size")}
    scenario = hall(*map(tuple, world["boxes"]), clearance=max(world["clearance"], 0.001), **given)
    assert taut(scenario).cost == pytest.approx(world["known"], rel=1e-3), name


@given(st.integers(0, 2), st.integers(0, 2**32))
@settings(max_examples=60)
def test_among_pillars_that_reach_through_the_space_the_path_and_its_bound_are_those_of_the_plane(axis, seed):
    """They are compared with the shortest path in the plane, among all corners that see each other."""
    rng = np.random.default_rng(seed)
    low = rng.uniform(0.5, 7.0, (rng.integers(1, 9), 3))
    high = low + rng.uniform(0.3, 3.0, low.shape)
    low[:, axis], high[:, axis] = -1.0, 11.0
    start, target = np.full(3, 0.2), rng.uniform(6.0, 9.8, 3)
    pillars = zip(low.tolist(), high.tolist(), strict=True)
    scenario = hall(*pillars, start=tuple(start), target=tuple(target), size=(10, 10, 10))
    result = sky.Taut().plan(sky.Problem(scenario))
    if not result.status.reached:
        return
    assert sky.check_result(scenario, 0, 0, result) == []
    b, c = (axis + 1) % 3, (axis + 2) % 3
    at = [start, target]
    for near, far in zip(low, high, strict=True):
        for x, y in itertools.product((near[b] - 0.001, far[b] + 0.001), (near[c] - 0.001, far[c] + 0.001)):
            at.append(np.zeros(3))
            at[-1][b], at[-1][c] = x, y
    at = np.array(at)
    at[:, axis] = 5.0
    i, j = np.triu_indices(len(at), 1)
    seen = sky.World(scenario).segments_free(at[i], at[j])
    legs = csr_matrix((np.linalg.norm(at[i] - at[j], axis=1)[seen], (i[seen], j[seen])), shape=(len(at), len(at)))
    plane = shortest_path(legs, directed=False, indices=0)[1]
    shortest = math.hypot(plane, target[axis] - start[axis])
    assert result.cost == pytest.approx(shortest, abs=2e-4)
    assert shortest - 2e-4 <= result.bound <= result.cost


def test_the_shortest_path_among_buildings_up_to_the_ceiling_is_found_where_no_lower_one_is_in_its_way():
    result = taut(sky.random_downtown(300, seed=31013))
    assert result.bound is not None
    assert result.cost <= 1.0001 * result.bound


def test_downtown_is_crossed_within_a_percent_of_the_bound():
    for seed in (1, 2, 3):
        result = taut(sky.random_downtown(400, seed=seed))
        assert len(result.path) > 10
        assert result.gap < 0.01


def test_many_paths_are_those_planned_one_by_one():
    city = sky.random_city(200, seed=2, uavs=6)
    pairs = list(itertools.product(range(6), range(3)))
    airspace = sky.Airspace(city)
    seen = []
    many = sky.plan_many(airspace, sky.Taut(), pairs, workers=3, on_result=lambda i, result: seen.append(i))
    assert sorted(seen) == list(range(len(pairs)))
    for (uav, target), result in zip(pairs, many, strict=True):
        alone = sky.Taut().plan(sky.Problem(airspace, uav, target))
        np.testing.assert_array_equal(result.path, alone.path)
        assert sky.check_result(city, uav, target, result) == []


def test_many_paths_are_by_default_those_of_each_uav_to_its_own_target_planned_by_auto():
    scenario = sky.read("table-4.8")
    for many in (sky.plan_many(scenario), sky.plan_many(sky.Airspace(scenario))):
        assert [result.provenance.planner for result in many] == ["AStar()"] * 5
        for i, result in enumerate(many):
            assert result.cost == sky.AStar().plan(sky.Problem(scenario, i, i)).cost


def test_many_seeded_paths_do_not_depend_on_how_many_work_at_them():
    scenario = sky.read("table-4.8")
    pairs = [(i, i) for i in range(4)]
    runs = [
        sky.plan_many(scenario, sky.MVO(universes=6), pairs, stop=sky.MaxIterations(4), rng=5, workers=n)
        for n in (1, 3)
    ]
    for one, other in zip(*runs, strict=True):
        np.testing.assert_array_equal(one.path, other.path)


def test_many_is_refused_in_one_sentence(refuses):
    with refuses():
        sky.plan_many(sky.read("map1"), sky.Taut(), [(0, 0)], workers=0)
    with refuses():
        sky.plan_many(sky.read("map1"), sky.Taut(), [(3, 0)])
    with refuses():
        sky.plan_many(sky.read("map1"), sky.Taut, [(0, 0)])
    assert sky.plan_many(sky.read("map1"), sky.Taut(), []) == []


def test_what_a_callback_raises_comes_out_of_many():
    def stop(i, result):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sky.plan_many(sky.read("map1"), sky.Taut(), [(0, 0)] * 50, on_result=stop)
