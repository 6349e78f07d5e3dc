"""HybridMVO against the exact optimum, on the thesis's maps, on others, and on random worlds."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from worlds import price_of, scenarios

MAPS = {"map1": 265, "map2": 229, "map3": 267}
OFF = [
    {"straighten": 0},
    {"tries": 1},
    {"rejoin": False},
    {"segments": False},
    {"wormholes": False},
    {"roam": 0.0},
]


@cache
def problem(name, **changed):
    scenario = sky.read(name)
    return sky.Problem(sky.Scenario.model_validate({**dict(scenario), **changed}) if changed else scenario)


@cache
def runs(planner, name, seeds=50):
    return [planner.plan(problem(name), stop=sky.MaxIterations(40), rng=seed) for seed in range(seeds)]


@pytest.mark.parametrize(("name", "optimum"), MAPS.items())
def test_the_mean_of_50_runs_is_within_half_a_percent_of_the_optimum(name, optimum):
    results = runs(sky.HybridMVO(universes=25), name)
    costs = np.array([result.cost for result in results])
    assert all(result.status.reached for result in results)
    assert costs.min() == optimum
    assert costs.mean() <= 1.005 * optimum
    assert costs.std(ddof=1) < 1.5


@pytest.mark.parametrize("name", MAPS)
def test_the_referee_accepts_every_path(name):
    for result in runs(sky.HybridMVO(universes=25), name)[:10]:
        assert sky.check_result(problem(name).scenario, 0, 0, result) == []
        assert len({tuple(place) for place in result.path}) == len(result.path)


def mean(planner, name, iterations=12):
    results = [planner.plan(problem(name), stop=sky.MaxIterations(iterations), rng=seed) for seed in range(50)]
    return np.mean([result.cost for result in results])


@pytest.mark.parametrize("repair", [{"straighten": 0}, {"segments": False}], ids=repr)
def test_without_the_two_repairs_that_matter_most_short_runs_end_dearer_on_the_hardest_map(repair):
    assert mean(sky.HybridMVO(**repair), "map2") > mean(sky.HybridMVO(), "map2")


@pytest.mark.parametrize("repair", OFF, ids=repr)
def test_without_any_one_repair_it_still_plans_and_never_gets_worse(repair):
    for seed in range(5):
        result = sky.HybridMVO(**repair).plan(problem("map3"), stop=sky.MaxIterations(20), rng=seed)
        assert sky.check_result(problem("map3").scenario, 0, 0, result) == []
        assert (np.diff(result.history.cost) <= 0).all()
        assert result.cost == pytest.approx(result.history.cost[-1])


def test_roaming_finds_the_way_through_a_maze_that_small_tdr_does_not():
    fine = {"lattice": sky.Lattice(step=(0.1, 0.1, 0.1))}
    maze = sky.Problem(sky.read("map2").model_copy(update=fine))
    arrived = {
        roam: sum(sky.HybridMVO(roam=roam).plan(maze, rng=seed).status.reached for seed in range(6))
        for roam in (0.0, 0.2)
    }
    assert arrived[0.2] >= 5
    assert arrived[0.0] < arrived[0.2]


@pytest.mark.parametrize("unit", ["nodes", "metres"])
@pytest.mark.parametrize("connectivity", [6, 26])
@pytest.mark.parametrize("divergence", [0.0, 0.3])
def test_other_objectives_and_connectivities_come_as_near(unit, connectivity, divergence):
    for name in MAPS:
        scenario = sky.read(name)
        lattice = scenario.lattice.model_copy(update={"connectivity": connectivity})
        objective = sky.Objective(divergence=divergence, end=80, unit=unit)
        changed = sky.Problem(scenario.model_copy(update={"lattice": lattice, "objective": objective}))
        results = [sky.HybridMVO().plan(changed, rng=seed) for seed in range(2)]
        assert np.mean([result.gap for result in results]) < 0.04
        assert not any(sky.check_result(changed.scenario, 0, 0, result) for result in results)


@settings(max_examples=40, deadline=None)
@given(scenarios(), st.integers(0, 2**32), st.sampled_from([{}, *OFF]))
def test_in_random_worlds_it_is_never_better_than_the_optimum_and_safe(scenario, seed, repair):
    random = sky.Problem(scenario)
    result = sky.HybridMVO(universes=4, **repair).plan(random, stop=sky.MaxIterations(6), rng=seed)
    if len(result.path):
        assert sky.check_result(scenario, 0, 0, result) == []
        assert result.cost == pytest.approx(sum(price_of(scenario, result.path, result.goal)))
        assert all(cost == pytest.approx(result.cost, abs=1e-6) for cost in result.history.cost[-1:])
    if result.status.reached:
        assert result.cost >= random.route.price - 1e-9


def test_it_begins_with_the_paths_of_another_planner():
    given = [sky.AStar().plan(problem("map2")).path]
    seeded, _ = sky.HybridMVO().evolve(problem("map2"), given, stop=sky.MaxIterations(2), rng=1)
    assert seeded.history.by_iteration().cost[0] == 229
    assert seeded.status is sky.Status.OPTIMAL
    alone = sky.HybridMVO().plan(problem("map2"), stop=sky.MaxIterations(2), rng=1)
    assert alone.history.by_iteration().cost[0] > 229
