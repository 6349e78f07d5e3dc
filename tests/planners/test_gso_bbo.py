"""GSO, BBO and the operators that they brought, against the published numbers, their papers and plain Python."""

import dataclasses
import itertools
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.planners import bbo, gso, path_changes
from skyverse.planners.base import provenance

RUNS = 50
PUBLISHED = [  # Tables 4.2 to 4.4, 20 runs a cell: map, population, iterations, BBO, GSO: mean and deviation each
    ("map1", 20, 25, (293.7, 18.04), (280.9, 9.65)),
    ("map1", 25, 40, (279.9, 8.32), (277.2, 5.73)),
    ("map2", 20, 25, (475.4, 124.5), (331.2, 22.2)),
    ("map2", 25, 40, (404.1, 82.2), (324.4, 21.4)),
    ("map3", 20, 25, (320.0, 23.89), (304.6, 16.29)),
    ("map3", 25, 40, (313.0, 11.77), (296.2, 8.06)),
]


@cache
def problem(name):
    return sky.Problem(sky.read(name))


def costs(planner, name, stop):
    return np.array([planner.plan(problem(name), stop=stop, rng=seed).cost for seed in range(RUNS)])


def test_what_was_run_gives_the_published_means():
    away = []
    for name, population, iterations, of_bbo, of_gso in PUBLISHED:
        for planner, (mean, deviation) in (
            (sky.BBO(habitats=population, as_run=True), of_bbo),
            (sky.GSO(glowworms=population, as_run=True), of_gso),
        ):
            ours = costs(planner, name, sky.MaxIterations(iterations))
            error = np.hypot(ours.std(ddof=1) / np.sqrt(RUNS), deviation / np.sqrt(20))
            away.append(abs(ours.mean() - mean) / error)
    assert sorted(away)[-2] < 2
    assert max(away) < 2.5  # of twelve cells one may well lie beyond two standard errors


@pytest.mark.parametrize("planner", [sky.GSO(), sky.BBO()], ids=repr)
def test_as_described_they_reach_the_goal_and_learn(planner):
    for name in ("map1", "map2", "map3"):
        runs = [planner.plan(problem(name), stop=sky.MaxPaths(1400), rng=seed) for seed in range(10)]
        assert all(run.status.reached for run in runs)
        early = [run.history.cost[np.searchsorted(run.history.generated_paths, 300)] for run in runs]
        assert np.mean([run.cost for run in runs]) < np.mean(early)


def test_random_points_alone_are_worse_than_bbo_on_the_map_of_many_walls():
    restart = costs(sky.RandomRestart(), "map2", sky.MaxPaths(1000))
    assert costs(sky.BBO(), "map2", sky.MaxPaths(1000)).mean() < restart.mean() - 30


def opened(planner, name="map1", rng=3):
    """A run of the planner that has begun."""
    stop = sky.MaxIterations(10)
    run = planner.open_run(problem(name), stop, np.random.default_rng(rng), provenance("", stop, rng))
    memory = planner.begin(run)
    return run, memory


def test_luciferin_follows_the_paper_with_cheaper_as_brighter():
    planner = sky.GSO(glowworms=6, luciferin=7.0)
    run, swarm = opened(planner)
    assert (swarm.luciferin == 7.0).all()
    assert (swarm.reach == 5.0).all()
    gso._glow(run.task, run.paths, swarm, 0.4, 0.6)
    np.testing.assert_allclose(swarm.luciferin, 0.6 * 7.0 - 0.6 * run.paths.cost)


def test_the_samples_of_a_path_are_places_on_it_and_end_where_it_ends():
    run, swarm = opened(sky.GSO(glowworms=5))
    gso._glow(run.task, run.paths, swarm, 0.4, 0.6)
    for i in range(5):
        places = problem("map1").places(run.paths.nodes[i, : run.paths.length[i]])
        assert all((np.abs(places - sample).max(axis=1) < 1e-9).any() for sample in swarm.places[i])
        np.testing.assert_allclose(swarm.places[i, -1], places[-1])


def test_the_distance_of_two_paths_is_the_mean_distance_of_their_samples():
    run, swarm = opened(sky.GSO(glowworms=4))
    gso._glow(run.task, run.paths, swarm, 0.4, 0.6)
    for i, j in ((0, 1), (2, 3), (1, 1)):
        expected = np.linalg.norm(swarm.places[i] - swarm.places[j], axis=1).mean()
        assert gso._distance(swarm, i, j) == pytest.approx(expected)


def test_the_decision_range_follows_the_wish_for_neighbours():
    planner = sky.GSO(glowworms=6, neighbours=20, beta=0.5, reach=5.0, reach_max=12.0)
    run, swarm = opened(planner)
    # while nobody has reached the goal nobody is followed, so that all see none: 5 + 0.5 * 20, at most 12
    assert run.best.nodes[0, run.best.length[0] - 1] != run.task.goal
    planner.step(dataclasses.replace(run, memory=swarm), 0.1)
    assert swarm.reach.max() == 12.0


def test_emigrants_are_drawn_by_mu():
    rng, n, host = np.random.default_rng(0), 8, 3
    draws = np.bincount([bbo._emigrant(n, host, rng) for _ in range(40_000)], minlength=n)
    mu = np.where(np.arange(n) == host, 0, n - np.arange(n))
    np.testing.assert_allclose(draws / 40_000, mu / mu.sum(), atol=0.01)


def test_elites_are_left_alone_and_the_rest_is_not():
    planner = sky.BBO(habitats=10, elites=3, mutation=1.0)
    run, _ = opened(planner)
    before = run.paths.cost.copy()
    elites = np.argsort(before, kind="stable")[:3]
    planner.step(run, 0.1)
    assert (run.paths.cost[elites] == before[elites]).all()
    assert (np.delete(run.paths.cost, elites) != np.delete(before, elites)).mean() > 0.8


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32))
def test_a_graft_is_a_path_without_loops_that_holds_parts_of_both(seed):
    planner = sky.BBO(habitats=4, as_run=True, mutation=1.0)
    run, _ = opened(planner, "map2", seed)
    for _ in range(30):
        planner.step(run, 0.5)
    i, j = 1, 2
    rng = np.random.default_rng(seed)
    length = path_changes.graft(run.task, run.workspace, rng, run.paths, i, j)
    path = run.workspace.draft[:length].tolist()
    assert path[0] == run.task.source
    assert len(set(path)) == length
    grid = run.task.grid
    for a, b in itertools.pairwise(path):
        move = np.flatnonzero(grid.offsets == b - a)
        assert len(move) == 1
        assert grid.exits[a] >> int(move[0]) & 1
    of_j = set(run.paths.nodes[j, : run.paths.length[j]].tolist())
    if path[-1] == run.task.goal and run.paths.nodes[j, run.paths.length[j] - 1] == run.task.goal:
        assert of_j & set(path)


@settings(deadline=None)
@given(st.lists(st.integers(0, 5), min_size=1, max_size=12))
def test_ranking_is_stable(costs):
    order = path_changes.ranked(np.array(costs, float))
    assert order.tolist() == sorted(range(len(costs)), key=costs.__getitem__)


def test_a_greedy_habitat_that_migrates_and_mutates_keeps_within_the_evaluations():
    problem, planner = sky.Problem(sky.read("map1")), sky.BBO(habitats=10, mutation=1.0, greedy=True)
    for most in range(60, 72):
        assert planner.plan(problem, stop=sky.MaxEvaluations(most), rng=3).effort.evaluations == most
