"""What every planner owes its callers: one call, one kind of answer, honest counts, repeatable runs."""

import dataclasses
import importlib.util
import math
import multiprocessing
import threading

import numpy as np
import pytest

import skyverse as sky
from judged_missions import mission_of
from patience import PATIENCE_S
from skyverse.planners import make_planner
from worlds import ROOM, price_of

ON_THE_LATTICE = [
    sky.MVO(universes=8),
    sky.MVO(universes=8, as_run=True),
    sky.MVO(universes=8, generator="uniform"),
    sky.HybridMVO(universes=8),
    sky.HybridMVO(universes=8, straighten=0, tries=1, rejoin=False, segments=False, wormholes=False, roam=0.0),
    sky.GSO(glowworms=8),
    sky.GSO(glowworms=8, as_run=True),
    sky.BBO(habitats=8),
    sky.BBO(habitats=8, as_run=True),
    sky.RandomRestart(samples=8),
    *(
        method(waypoints=3, candidates=8)
        for method in (sky.CMAES, sky.PSO, sky.GA, sky.DE, sky.LSHADE, sky.WOA, sky.MFO, sky.GWO, sky.DA)
        if not method.library or importlib.util.find_spec(method.library)
    ),
]
OFF_THE_LATTICE = [
    *(
        method(waypoints=3, candidates=8, legs="straight")
        for method in (sky.CMAES, sky.LSHADE, sky.MFO)
        if not method.library or importlib.util.find_spec(method.library)
    ),
]
METAHEURISTICS = [*ON_THE_LATTICE, *OFF_THE_LATTICE]
ANY_ANGLE = [sky.ThetaStar(), sky.Taut(), sky.Cheapest(legs=20_000)]
LATTICE = [*ON_THE_LATTICE, sky.AStar()]
PLANNERS = [*LATTICE, *OFF_THE_LATTICE, *ANY_ANGLE]
on_the_lattice = pytest.mark.parametrize("planner", ON_THE_LATTICE, ids=repr)
every_lattice_planner = pytest.mark.parametrize("planner", LATTICE, ids=repr)
every_any_angle_planner = pytest.mark.parametrize("planner", ANY_ANGLE, ids=repr)
every_planner = pytest.mark.parametrize("planner", PLANNERS, ids=repr)
every_metaheuristic = pytest.mark.parametrize("planner", METAHEURISTICS, ids=repr)
STOP = sky.MaxIterations(6)


def plan(planner, scenario=ROOM, stop=STOP, rng=1, **other):
    return planner.plan(sky.Problem(scenario), stop=stop, rng=rng, **other)


def same(a, b):
    """Whether two results are equal but for the clock."""
    return dataclasses.replace(a, seconds=0.0) == dataclasses.replace(b, seconds=0.0)


def variants():
    for connectivity in (6, 26):
        for objective in ("thesis", "turns", sky.Objective(divergence=0.2, unit="metres")):
            lattice = sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=connectivity)
            yield sky.Scenario.model_validate({**dict(ROOM), "lattice": lattice, "objective": objective})


@every_lattice_planner
def test_the_answer_has_every_part_and_the_parts_agree(planner):
    for scenario in variants():
        problem = sky.Problem(scenario)
        result = planner.plan(problem, stop=STOP, rng=1)
        assert result.status in (sky.Status.OPTIMAL, sky.Status.COMPLETE, sky.Status.INCOMPLETE)
        assert result.path.dtype == np.float64
        assert result.path.shape[1:] == (3,)
        np.testing.assert_allclose(result.path[0], (0.5, 0.5, 1.0))
        np.testing.assert_allclose(result.start, (0.5, 0.5, 1.0))
        np.testing.assert_allclose(result.goal, (5.5, 4.0, 3.0))
        assert result.status.reached == np.allclose(result.path[-1], result.goal)
        terms = price_of(scenario, result.path, result.goal)
        assert list(result.terms) == ["fuel", "divergence", "end"]
        np.testing.assert_allclose(list(result.terms.values()), terms, rtol=1e-9, atol=1e-9)
        assert result.cost == pytest.approx(sum(terms))
        assert result.bound == problem.route.price
        if result.status.reached:
            assert result.gap == pytest.approx(result.cost / result.bound - 1)
            assert result.gap >= -1e-12
        else:
            assert result.gap is None
        assert (result.status is sky.Status.OPTIMAL) == (result.status.reached and result.gap < 1e-9)


@every_any_angle_planner
def test_an_any_angle_answer_joins_the_true_ends_at_the_price_of_its_metres(planner):
    for scenario in variants():
        result = planner.plan(sky.Problem(scenario), stop=STOP, rng=1)
        assert result.any_angle
        assert result.status in (sky.Status.OPTIMAL, sky.Status.COMPLETE)
        assert result.path.dtype == np.float64
        np.testing.assert_array_equal(result.path[[0, -1]], [(0.6, 0.7, 1.2), (5.8, 4.3, 3.1)])
        np.testing.assert_array_equal([result.start, result.goal], result.path[[0, -1]])
        metres = np.linalg.norm(np.diff(result.path, axis=0), axis=1).sum()
        joints = len(result.path) - 2
        objective = scenario.objective
        terms = objective.fuel * metres, objective.divergence * joints, 0.0
        assert list(result.terms) == ["fuel", "divergence", "end"]
        np.testing.assert_allclose(list(result.terms.values()), terms, rtol=1e-9)
        assert result.cost == pytest.approx(sum(terms))
        assert objective.fuel * math.dist(*result.path[[0, -1]]) <= result.bound <= result.cost * (1 + 1e-12)


def test_a_path_that_is_a_little_dearer_than_the_optimum_is_not_called_optimal():
    problem = sky.Problem(ROOM)
    results = [sky.MVO(universes=12).plan(problem, stop=sky.MaxIterations(60), rng=seed) for seed in range(30)]
    near = [r for r in results if 1e-6 < r.cost / problem.route.price - 1 < 0.09]
    assert near
    assert {r.status for r in near} == {sky.Status.COMPLETE}


@every_planner
def test_the_referee_finds_nothing_wrong_with_the_mission_made_of_it(planner):
    for scenario in variants():
        problem = sky.Problem(scenario)
        result = planner.plan(problem, stop=STOP, rng=2)
        assert sky.check(scenario, mission_of(problem, result)) == []


@every_planner
def test_effort_is_counted_and_the_history_never_gets_worse(planner):
    result = plan(planner)
    effort, history = result.effort, result.history
    assert effort.generated_paths >= 1
    assert effort.generated_nodes >= len(result.path) - 1
    assert effort.evaluations >= 1
    assert result.seconds >= 0
    assert (np.diff(history.cost) <= 0).all()
    assert history.cost[-1] == pytest.approx(result.cost)
    for name in ("generated_paths", "generated_nodes", "evaluations"):
        assert (np.diff(getattr(history, name)) >= 0).all()
        assert getattr(history, name)[-1] == getattr(effort, name)


@every_metaheuristic
def test_the_history_has_a_row_for_the_start_and_one_an_iteration(planner):
    result = plan(planner, stop=sky.MaxIterations(5))
    history = result.history.by_iteration()
    np.testing.assert_array_equal(history.iteration, range(6))
    assert history.evaluations[0] == planner.population
    assert result.stopped_by == "MaxIterations"
    most = planner.samples if isinstance(planner, sky.RandomRestart) else planner.population
    if isinstance(planner, sky.HybridMVO):
        most *= 2 + planner.straighten
    assert (np.diff(history.evaluations) <= most).all()
    if isinstance(planner, sky.MVO):
        np.testing.assert_array_equal(np.diff(history.evaluations), planner.universes - 1)


@every_metaheuristic
def test_the_history_has_a_row_for_each_improvement_when_it_was_found(planner):
    history = plan(planner).history
    assert (np.diff(history.iteration) >= 0).all()
    for limit in (1, 2, 3, 5, 8, 13, 21, 34):  # the run with so small a budget has found just what the history says
        short = plan(planner, stop=sky.MaxEvaluations(limit) | STOP)
        if isinstance(planner, sky.GSO | sky.BBO | sky.RandomRestart):  # the budget steers no schedule of theirs
            row = np.searchsorted(history.evaluations, short.effort.evaluations, side="right") - 1
            assert short.cost == pytest.approx(history.cost[row])
    improved = np.diff(history.cost) < 0
    moved = np.diff(history.evaluations) > 0
    assert (moved | ~improved).all()


def rerouted(planner):
    """The most walks that one candidate can take: a graft, a detour and its retries, and the way to the goal."""
    return 1 if isinstance(planner, sky.WaypointSearch) else getattr(planner, "retries", 0) + 5


@every_metaheuristic
@pytest.mark.parametrize("most", [1, 3, 8, 9, 50, 333])
def test_a_budget_of_paths_is_kept_but_for_the_candidate_under_way(planner, most):
    result = plan(planner, stop=sky.MaxPaths(most))
    assert result.stopped_by == "MaxPaths"
    assert most <= result.effort.generated_paths < most + rerouted(planner)


@every_metaheuristic
@pytest.mark.parametrize("most", [1, 3, 8, 9, 50, 333])
def test_a_budget_of_evaluations_is_kept_to_the_last_one(planner, most):
    result = plan(planner, stop=sky.MaxEvaluations(most))
    assert result.stopped_by == "MaxEvaluations"
    assert result.effort.evaluations == most


@every_metaheuristic
@pytest.mark.parametrize("stop", [sky.MaxPaths(300), sky.MaxNodes(900), sky.MaxEvaluations(300)], ids=repr)
def test_a_counted_run_ends_although_every_candidate_is_as_good_as_the_best(planner, stop):
    next_door = sky.Scenario.model_validate({**dict(ROOM), "targets": (sky.Target(position=(1.0, 0.5, 1.0)),)})
    result = plan(planner, next_door, stop=stop)
    assert result.stopped_by == type(stop).__name__


@on_the_lattice
def test_a_target_at_the_start_is_reached_without_a_search(planner):
    there = sky.Scenario.model_validate({**dict(ROOM), "targets": (sky.Target(position=(0.5, 0.5, 1.0)),)})
    result = plan(planner, there, stop=sky.MaxNodes(100))
    assert result.status is sky.Status.OPTIMAL
    assert result.stopped_by == "finished"
    assert result.path.tolist() == [[0.5, 0.5, 1.0]]


@every_metaheuristic
@pytest.mark.parametrize("most", [1, 1000, 5000])
def test_a_budget_of_nodes_is_kept_but_for_the_candidate_under_way(planner, most):
    result = plan(planner, stop=sky.MaxNodes(most))
    assert result.stopped_by == "MaxNodes"
    assert most <= result.effort.generated_nodes
    history = result.history.by_iteration()
    assert (history.generated_nodes[:-1] < most).all()


@every_metaheuristic
def test_a_seed_gives_one_answer_and_another_seed_another(planner):
    first = plan(planner, rng=7)
    assert same(first, plan(planner, rng=7))
    assert np.array_equal(first.path, plan(planner, rng=np.random.default_rng(7)).path)
    others = [plan(planner, rng=seed).history for seed in range(8, 12)]
    assert any(h != first.history for h in others)
    assert first.provenance.seed == 7
    assert plan(planner, rng=np.random.default_rng(7)).provenance.seed is None


@every_metaheuristic
def test_a_run_without_a_seed_tells_the_seed_that_repeats_it(planner):
    drawn = plan(planner, rng=None)
    assert same(drawn, plan(planner, rng=drawn.provenance.seed))


@every_metaheuristic
def test_a_clock_that_does_not_ring_changes_nothing(planner):
    timed = plan(planner, stop=sky.MaxIterations(6) | sky.MaxSeconds(1e6))
    assert timed.history == plan(planner).history


def test_every_planner_gives_the_same_answer_in_a_spawned_process():
    problem = sky.Problem(ROOM)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        jobs = [pool.apply_async(p.plan, (problem,), {"stop": STOP, "rng": 5}) for p in PLANNERS]
        for planner, job in zip(PLANNERS, jobs, strict=True):
            assert same(job.get(timeout=PATIENCE_S), planner.plan(problem, stop=STOP, rng=5))


@pytest.mark.parametrize("name", ["mvo", "random-restart", "astar", "theta-star"])
def test_a_misspelt_setting_is_refused_with_the_list_of_settings(name, refuses):
    with refuses():
        make_planner(name, univeres=3)


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        (sky.MVO, {"universes": 1}),
        (sky.MVO, {"universes": 2.5}),
        (sky.MVO, {"universes": True}),
        (sky.MVO, {"universes": "many"}),
        (sky.MVO, {"threshold": 0}),
        (sky.MVO, {"repair_threshold": -1}),
        (sky.MVO, {"retries": 0}),
        (sky.MVO, {"wep_min": -0.1}),
        (sky.MVO, {"wep_min": "little"}),
        (sky.MVO, {"p": True}),
        (sky.MVO, {"wep_min": math.nan}),
        (sky.MVO, {"wep_max": 1.1}),
        (sky.MVO, {"p": 0.0}),
        (sky.MVO, {"p": math.nan}),
        (sky.MVO, {"generator": "clever"}),
        (sky.MVO, {"as_run": "yes"}),
        (sky.HybridMVO, {"universes": 1}),
        (sky.HybridMVO, {"straighten": -1}),
        (sky.HybridMVO, {"tries": 0}),
        (sky.HybridMVO, {"rejoin": 1}),
        (sky.HybridMVO, {"segments": None}),
        (sky.HybridMVO, {"wormholes": "no"}),
        (sky.HybridMVO, {"roam": 1.5}),
        (sky.HybridMVO, {"p": 0.0}),
        (sky.RandomRestart, {"samples": 0}),
        (sky.RandomRestart, {"retries": None}),
        (sky.RandomRestart, {"generator": None}),
        (sky.GSO, {"glowworms": 1}),
        (sky.GSO, {"as_run": 1}),
        (sky.GSO, {"decay": 1.5}),
        (sky.GSO, {"gain": 0}),
        (sky.GSO, {"reach": 60.0}),
        (sky.GSO, {"neighbours": 0}),
        (sky.GSO, {"beta": -1}),
        (sky.BBO, {"habitats": 1}),
        (sky.BBO, {"as_run": None}),
        (sky.BBO, {"mutation": 1.1}),
        (sky.BBO, {"elites": -1}),
        (sky.BBO, {"elites": 25}),
        (sky.WOA, {"waypoints": 0}),
        (sky.WOA, {"waypoints": 2.5}),
        (sky.WOA, {"candidates": 5}),
        (sky.WOA, {"candidates": True}),
        (sky.WOA, {"collision": -1.0}),
        (sky.WOA, {"collision": "dear"}),
        (sky.WOA, {"legs": "curved"}),
        (sky.WOA, {"objective": "short"}),
        (sky.Cheapest, {"legs": -1}),
        (sky.Cheapest, {"proof": -1}),
    ],
)
def test_a_setting_that_cannot_be_is_refused_by_name(kind, settings, refuses):
    with refuses():
        kind(**settings)


def test_a_planner_is_frozen_and_equal_to_its_like():
    assert sky.MVO(universes=5) == sky.MVO(universes=5)
    assert hash(sky.AStar()) == hash(sky.AStar())
    with pytest.raises(dataclasses.FrozenInstanceError):
        sky.MVO().universes = 3


@every_metaheuristic
@pytest.mark.parametrize("stop", [sky.MaxSeconds(1), sky.TargetCost(5), sky.Cancelled(threading.Event())], ids=repr)
def test_what_counts_nothing_cannot_steer_a_metaheuristic(planner, stop):
    with pytest.raises(sky.InputError):
        plan(planner, stop=stop)


@every_metaheuristic
@pytest.mark.parametrize("seed", [-1, 1.5, True, "one"])
def test_a_seed_is_a_whole_number_from_zero_on(planner, seed):
    with pytest.raises(sky.InputError):
        plan(planner, rng=seed)


@every_metaheuristic
def test_setting_the_event_ends_the_run_with_the_best_so_far(planner):
    event = threading.Event()
    seen = []

    def watch(progress):
        seen.append(progress)
        if progress.iterations == 3:
            event.set()

    result = plan(planner, stop=sky.MaxIterations(50) | sky.Cancelled(event), on_iteration=watch)
    assert result.stopped_by == "Cancelled"
    history = result.history.by_iteration()
    np.testing.assert_array_equal(history.iteration, range(4))
    assert len(result.path)
    assert [p.iterations for p in seen] == [1, 2, 3]
    assert [p.cost for p in seen] == history.cost[1:].tolist()
    assert [p.generated_paths for p in seen] == history.generated_paths[1:].tolist()
    assert seen[-1].cost == pytest.approx(result.cost)


@every_metaheuristic
def test_a_target_cost_ends_the_run_as_soon_as_it_is_reached(planner):
    aim = plan(planner).history.by_iteration().cost[3]
    result = plan(planner, stop=STOP | sky.TargetCost(aim))
    assert result.stopped_by == "TargetCost"
    assert result.cost <= aim
    assert (result.history.by_iteration().cost[:-1] > aim).all()


def test_without_a_stop_a_metaheuristic_takes_forty_iterations():
    assert plan(sky.RandomRestart(samples=1), stop=None).history.iteration[-1] == 40
    assert plan(sky.AStar(), stop=None).status is sky.Status.OPTIMAL
