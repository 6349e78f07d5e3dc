"""Waypoint vectors: what they decode to, what is reported of them, and the optimisers that move them."""

import itertools
import logging
import math
import random
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from judged_missions import mission_of
from skyverse.planners import waypoints
from skyverse.planners.metaheuristic import lattice_run
from worlds import ROOM, exits_of, neighbours, price_of, scenarios, shape_of

STOP = sky.MaxIterations(4)
PACKAGES = {
    sky.CMAES: "cma",
    sky.PSO: "pymoo",
    sky.GA: "pymoo",
    sky.DE: "pymoo",
    sky.LSHADE: "niapy",
    sky.GWO: "niapy",
    sky.WOA: None,
    sky.MFO: None,
    sky.DA: None,
    sky.WaypointMVO: None,
    sky.WaypointGSO: None,
    sky.WaypointBBO: None,
}
every_method = pytest.mark.parametrize("kind", PACKAGES, ids=lambda kind: kind.__name__)

shares = st.integers(0, 64).map(lambda n: n / 64)  # exact numbers, so that halves between two nodes are met exactly
vectors = st.lists(st.lists(shares, min_size=9, max_size=9), min_size=1, max_size=4).map(np.array)


def need(package):
    if package is not None:
        pytest.importorskip(package)


def plain(kernel):
    return getattr(kernel, "py_func", kernel)


def opened(problem, stop=STOP, k=3, **settings):
    planner = sky.WOA(waypoints=k, **settings)
    capacity = planner.longest(problem.airspace.grid)
    return lattice_run(problem, planner.task(problem), 0, capacity, stop, np.random.default_rng(0))


def digital_line(a, b, connectivity):
    """The nodes after a up to b, (3,) indices, on the digital straight line, in exact numbers."""
    size, sign = np.abs(b - a), np.sign(b - a)
    if connectivity == 6:
        crossings = sorted(
            (Fraction(2 * j + 1, int(2 * size[axis])), axis) for axis in range(3) for j in range(size[axis])
        )
        steps = np.array([sign * (np.arange(3) == axis) for _, axis in crossings]).reshape(-1, 3)
        return list(a + np.cumsum(steps, axis=0))
    count = int(size.max())
    shares_ = (Fraction(t, count) for t in range(1, count + 1))
    return [a + sign * [math.floor(int(n) * share + Fraction(1, 2)) for n in size] for share in shares_]


def walked(problem, x):
    """Decode a candidate by brute force: its nodes (n, 3), how many are free, and the metres that are not."""
    scenario, shape = problem.scenario, np.array(shape_of(problem.scenario))
    connectivity = scenario.lattice.connectivity
    stops = [np.array(np.unravel_index(problem.source, shape))]
    for triple in x.reshape(-1, 3):
        nearest = [Fraction(share) * (int(n) - 1) + Fraction(1, 2) for share, n in zip(triple, shape, strict=True)]
        stops.append(np.array([math.floor(index) for index in nearest]))
    stops.append(np.array(np.unravel_index(problem.goal, shape)))
    nodes = [stops[0]]
    for a, b in itertools.pairwise(stops):
        nodes += digital_line(a, b, connectivity)
    moves = neighbours(connectivity)
    open_ = exits_of(scenario, moves)
    free, metres = len(nodes), 0.0
    for i, (a, b) in enumerate(itertools.pairwise(nodes)):
        (m,) = np.flatnonzero((moves == b - a).all(axis=1))
        if not open_[np.ravel_multi_index(a, shape), m]:
            free = min(free, i + 1)
            metres += float(np.linalg.norm((b - a) * np.array(scenario.lattice.step)))
    return np.array(nodes), free, metres


def without_loops(nodes):
    kept = []
    for node in map(tuple, nodes):
        kept = kept[: kept.index(node)] if node in kept else kept
        kept.append(node)
    return np.array(kept)


def places(scenario, nodes):
    return np.array(scenario.bounds.min) + nodes * np.array(scenario.lattice.step)


@given(scenarios(most_nodes=6), vectors, st.sampled_from([0.0, 1.0, 100.0]))
def test_candidates_decode_to_digital_lines_and_cost_what_brute_force_says(scenario, X, collision):
    problem = sky.Problem(scenario)
    if problem.refusal is not None:
        return
    for kernel, decode in (
        (waypoints.draft_through, waypoints.decode),
        (plain(waypoints.draft_through), plain(waypoints.decode)),
    ):
        run = opened(problem)
        cheapest = math.inf
        for x in X:
            nodes, free, metres = walked(problem, x)
            length, drawn_free, drawn_metres = kernel(run.task, run.workspace, x)
            shape = tuple(shape_of(scenario))
            np.testing.assert_array_equal(np.transpose(np.unravel_index(run.workspace.draft[:length], shape)), nodes)
            assert drawn_free == free
            assert drawn_metres == pytest.approx(metres)
            fuel, divergence, _ = price_of(scenario, places(scenario, nodes))
            (fitness,) = decode(run.task, run.workspace, run.best, x[None], collision)
            assert fitness == pytest.approx(fuel + divergence + collision * metres)
            best = places(scenario, without_loops(nodes[:free]))
            price = sum(price_of(scenario, best, problem.places([problem.goal])[0]))
            cheapest = min(cheapest, price)
            assert run.best.cost[0] == pytest.approx(cheapest)
        np.testing.assert_array_equal(run.workspace.spent[[0, 2]], len(X))
        assert run.workspace.spent[1] == sum(len(walked(problem, x)[0]) - 1 for x in X)


@given(scenarios(most_nodes=6), vectors)
def test_a_free_candidate_costs_its_fitness_if_it_has_no_loop_and_never_less_than_the_optimum(scenario, X):
    problem = sky.Problem(scenario)
    if problem.refusal is not None or problem.route is None:
        return
    for x in X:
        nodes, free, metres = walked(problem, x)
        run = opened(problem)
        (fitness,) = waypoints.decode(run.task, run.workspace, run.best, x[None], 100.0)
        last = run.best.nodes[0, run.best.length[0] - 1]
        if metres == 0.0:
            assert last == problem.goal
            assert fitness >= run.best.cost[0] - 1e-9
            assert run.best.cost[0] >= problem.route.price - 1e-9
            if len(np.unique(nodes, axis=0)) == len(nodes):
                assert fitness == pytest.approx(run.best.cost[0])
        else:
            assert (last == problem.goal) == (tuple(nodes[free - 1]) == tuple(nodes[-1]))


@settings(max_examples=25)
@given(
    scenarios(most_nodes=7),
    st.sampled_from([sky.WOA, sky.MFO, sky.DA]),
    st.sampled_from(["lattice", "straight"]),
    st.integers(0, 99),
)
def test_the_referee_passes_whatever_is_reported(scenario, kind, legs, seed):
    problem = sky.Problem(scenario)
    result = kind(waypoints=2, candidates=6, legs=legs).plan(problem, stop=STOP, rng=seed)
    assert sky.check_result(scenario, 0, 0, result) == []
    assert result.any_angle == (legs == "straight" and len(result.path) > 0)
    if not len(result.path):
        return
    if result.status.reached:
        assert result.bound <= result.cost * (1 + 1e-12)
    assert sky.check(scenario, mission_of(problem, result)) == []


def test_a_draft_has_room_for_the_longest_path_and_no_more():
    corners = {"uavs": (sky.UAV(start=(0, 0, 0)),), "targets": (sky.Target(position=(6, 5, 4)),)}
    problem = sky.Problem(sky.Scenario.model_validate({**dict(ROOM), **corners}))
    run = opened(problem, k=6)
    length, _, _ = waypoints.draft_through(run.task, run.workspace, np.array([1.0, 1, 1, 0, 0, 0] * 3))
    assert length == len(run.workspace.draft)


def test_more_habitats_than_counts_of_species_fit_into_a_float_are_bred_all_the_same():
    habitats = sky.WaypointBBO(waypoints=1, candidates=1100)
    assert habitats.plan(sky.Problem(ROOM), stop=sky.MaxIterations(1), rng=0).effort.evaluations == 2200


def test_candidates_beyond_the_budget_are_not_looked_at():
    run = opened(sky.Problem(ROOM), stop=sky.MaxPaths(3))
    fitness = waypoints.decode(run.task, run.workspace, run.best, np.random.default_rng(0).random((5, 9)), 100.0)
    np.testing.assert_array_equal(np.isfinite(fitness), [True, True, True, False, False])
    assert run.workspace.spent[0] == 3


@pytest.mark.parametrize("name", ["map1", "map3"])
def test_a_candidate_through_the_optimum_s_corners_costs_the_optimum(name):
    problem = sky.Problem(sky.read(name))
    best = sky.AStar().plan(problem).path
    turns = [i for i in range(1, len(best) - 1) if np.any(np.cross(best[i + 1] - best[i], best[i] - best[i - 1]))]
    grid = problem.airspace.grid
    x = ((best[turns] - grid.origin) / grid.step / (grid.shape - 1)).reshape(1, -1)
    run = opened(problem, k=len(turns))
    (fitness,) = waypoints.decode(run.task, run.workspace, run.best, x, 100.0)
    assert fitness == run.best.cost[0] == problem.route.price


@every_method
def test_methods_with_one_seed_begin_with_the_same_candidates(kind):
    need(PACKAGES[kind])
    problem = sky.Problem(ROOM)
    begun = {m(candidates=7).plan(problem, stop=sky.MaxPaths(7), rng=3).cost for m in (sky.WOA, kind)}
    assert len(begun) == 1


@every_method
def test_an_iteration_evaluates_every_candidate_once(kind):
    need(PACKAGES[kind])
    history = kind(candidates=7).plan(sky.Problem(ROOM), stop=sky.MaxIterations(3), rng=3).history.by_iteration()
    left = {sky.LSHADE: [7, 7, 6, 5], sky.WaypointMVO: [7, 6, 6, 6]}.get(kind, [7] * 4)  # the best universe stays
    np.testing.assert_array_equal(history.evaluations, np.cumsum(left))


@every_method
def test_a_method_finds_its_way_round_a_wall(kind):
    need(PACKAGES[kind])
    problem = sky.Problem(sky.Scenario.model_validate({**dict(ROOM), "obstacles": ROOM.obstacles[:1]}))
    for seed in range(3):
        result = kind(waypoints=3).plan(problem, stop=sky.MaxPaths(600), rng=seed)
        assert result.status.reached
        assert result.gap < (1.0 if kind is sky.WaypointGSO else 0.3)
        assert result.effort.generated_paths == result.effort.evaluations == 600


@every_method
def test_a_missing_package_is_named_with_the_line_that_installs_it(kind, monkeypatch, refuses):
    if PACKAGES[kind] is None:
        kind()
    else:
        monkeypatch.setitem(sys.modules, PACKAGES[kind], None)
        with refuses():
            kind()


def minimise(optimiser, seed, iterations=80, n=25, d=12):
    """Run an optimiser on a sphere round a point that is neither the middle nor a corner; return all values."""
    seen = []

    def sphere(X):
        X = np.asarray(X)
        assert X.shape[1] == d
        assert X.min() >= 0.0
        assert X.max() <= 1.0
        seen.append(((X - np.linspace(0.2, 0.7, d)) ** 2).sum(axis=1))
        return seen[-1]

    rng = np.random.default_rng(seed)
    search = optimiser(sphere, rng.random((n, d)), rng)
    next(search)
    assert sum(map(len, seen)) == n
    for i in range(iterations):
        search.send((i + 1) / iterations)
    return np.concatenate(seen)


@every_method
def test_an_optimiser_beats_random_search_on_a_sphere(kind):
    if kind is sky.WaypointGSO:  # it seeks many optima, and the brightest glowworm never moves
        return
    need(PACKAGES[kind])
    for seed in range(2):
        seen = minimise(kind().optimise, seed)
        drawn = np.random.default_rng(seed).random((2025, 12))
        blind = ((drawn - np.linspace(0.2, 0.7, 12)) ** 2).sum(axis=1).min()
        assert seen.min() < 0.5 * blind


@every_method
def test_an_optimiser_draws_from_its_generator_alone_and_leaves_no_trace(kind):
    need(PACKAGES[kind])
    optimiser = kind().optimise
    minimise(optimiser, 0, iterations=1)
    state, other, handlers = np.random.get_state(), random.getstate(), logging.root.handlers[:]  # noqa: NPY002
    first = minimise(optimiser, 5, iterations=6)
    np.testing.assert_array_equal(np.random.get_state()[1], state[1])  # noqa: NPY002
    assert np.random.get_state()[2:] == state[2:]  # noqa: NPY002
    assert random.getstate() == other
    assert logging.root.handlers == handlers
    np.random.seed(1)  # noqa: NPY002
    random.seed(1)
    np.testing.assert_array_equal(minimise(optimiser, 5, iterations=6), first)
    assert not np.array_equal(minimise(optimiser, 6, iterations=6), first)


@every_method
def test_an_optimiser_says_nothing(kind, capfd):
    need(PACKAGES[kind])
    minimise(kind().optimise, 0, iterations=6)
    assert capfd.readouterr() == ("", "")


def test_l_shade_shrinks_its_population_to_four():
    need("niapy")
    assert len(minimise(sky.LSHADE().optimise, 0, iterations=3, n=10)) == 10 + 10 + 8 + 6


def test_moths_fly_to_fewer_flames_and_whales_to_the_best_in_the_end():
    """At the end of the budget whales that encircle land on the best, and moths circle round the best flame."""
    rng = np.random.default_rng(0)
    first = rng.random((40, 3))
    calls = []

    def slope(X):
        calls.append(X.copy())
        return X.sum(axis=1)

    search = sky.WOA().optimise(slope, first, rng)
    next(search)
    search.send(1.0)
    best = first[first.sum(axis=1).argmin()]
    landed = (calls[1] == best).all(axis=1)
    assert 0.25 < landed.mean() < 0.75
    calls.clear()
    search = sky.MFO().optimise(slope, np.repeat([[0.5, 0.5, 0.5], [0.2, 0.2, 0.2]], 20, axis=0), rng)
    next(search)
    search.send(1.0)
    np.testing.assert_array_equal(calls[1][20:], 0.2)


def generations(optimiser, first, spent):
    """Return the candidates that an optimiser evaluates, generation by generation, on a slope, and their values."""
    calls, rng = [], np.random.default_rng(0)

    def slope(X):
        calls.append(X.copy())
        return 1.0 + X.sum(axis=1)

    search = optimiser(slope, first, rng)
    next(search)
    for share in spent:
        search.send(share)
    return calls


def test_a_wormhole_leads_to_the_best_and_a_white_hole_gives_single_objects():
    """At the end of the budget WEP is 1 and TDR 0 (3.8, 3.9); without wormholes all objects come from others (3.6)."""
    first = np.random.default_rng(1).random((30, 4))
    best = first[first.sum(axis=1).argmin()]
    _, last = generations(sky.WaypointMVO().optimise, first, [1.0])
    np.testing.assert_array_equal(last, np.tile(best, (29, 1)))
    _, given = generations(sky.WaypointMVO(wep_min=0.0).optimise, first, [0.0])
    came_from = (given[:, None, :] == first).argmax(axis=1)
    assert (np.take_along_axis(first, came_from, axis=0) == given).all()
    exchanged = 1.0 - (given == first[np.argsort(first.sum(axis=1), kind="stable")][1:]).mean()
    rates = np.sort(1.0 + first.sum(axis=1))
    assert exchanged == pytest.approx((rates / np.linalg.norm(rates)).mean(), abs=0.06)
    _, near = generations(sky.WaypointMVO(wep_min=1.0).optimise, first, [0.5])
    assert np.abs(near - best).max() <= 1.0 - 0.5 ** (1 / 6)  # TDR (3.9)


def test_a_glowworm_moves_one_step_towards_a_brighter_one_that_it_sees():
    first = np.random.default_rng(1).random((30, 4))
    _, moved = generations(sky.WaypointGSO().optimise, first, [0.5])
    brightness = -first.sum(axis=1)
    for i, (was, now) in enumerate(zip(first, moved, strict=True)):
        apart = np.linalg.norm(first - was, axis=1)
        seen = np.flatnonzero((brightness > brightness[i]) & (apart < 0.35 * 2))
        ends = [was + 0.0035 * 2 * (first[j] - was) / apart[j] for j in seen] or [was]  # the diagonal is sqrt(4)
        assert min(np.abs(now - end).max() for end in ends) < 1e-12


def test_habitats_take_over_numbers_and_the_best_take_none():
    first = np.random.default_rng(1).random((30, 4))
    _, changed = generations(sky.WaypointBBO(mutation=0.0).optimise, first, [0.5])
    ranked = first[np.argsort(first.sum(axis=1), kind="stable")]
    assert (changed[:, None, :] == first).any(axis=1).all()
    np.testing.assert_array_equal(changed[0], ranked[0])  # lambda is 0
    taken = (changed != ranked).mean(axis=1)
    assert taken[:15].mean() < 0.4 < taken[15:].mean()
    _, mutated = generations(sky.WaypointBBO(mutation=1.0).optimise, first, [0.5])
    drawn = ~(mutated[:, None, :] == first).any(axis=1)
    assert drawn[0].all()  # the likeliest number of species is half of the largest one
    assert not drawn[14:16].any() or drawn[14:16].mean() < 0.2


@pytest.mark.parametrize("planner", [sky.WaypointMVO(), sky.WaypointBBO(mutation=0.5)], ids=repr)
@pytest.mark.parametrize("greedy", [False, True])
def test_only_a_greedy_population_gets_no_worse(planner, greedy):
    rng = np.random.default_rng(0)
    search = replace(planner, greedy=greedy).optimise(lambda X: 1.0 + X.sum(axis=1), rng.random((12, 3)), rng)
    next(search)
    kept = [np.sort(search.gi_frame.f_locals["cost"])]
    for spent in np.linspace(0.05, 0.5, 10):
        search.send(spent)
        kept.append(np.sort(search.gi_frame.f_locals["cost"]))
    assert (np.diff(kept, axis=0) <= 0.0).all() == greedy


def test_the_example_of_an_optimiser_of_one_s_own_plans_and_minimises():
    example = Path(__file__).parents[2] / "examples" / "5_own_optimiser.py"
    if not example.exists():
        pytest.skip("the examples are in the repository only")
    names = {"__name__": "example"}
    exec(example.read_text().split("# [end]")[0], names)
    assert sky.plan_mission(ROOM, names["Shake"](), stop=STOP, rng=1).results[0].effort.generated_paths == 125
    draw = names["Shake"]().optimise
    assert minimise(draw, 0).min() < 0.16  # half of what as many random vectors give
