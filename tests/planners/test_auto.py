"""Which planner is used where none is named, and that no other one finds cheaper paths between the same ends."""

import numpy as np
import pytest

import skyverse as sky
from kernel_workloads import world

BAND = sky.AltitudeBand(low=3, high=7, weight=0.2)
CLIMB = sky.ClimbLimit(angle=10, weight=1)
WING = sky.FixedWing(speed=8.0, turn_radius=6.0, climb=12)


@pytest.mark.parametrize(
    ("objective", "chosen"),
    [
        ("thesis", sky.AStar()),
        ("turns", sky.AStar()),
        (sky.Objective(unit="nodes", altitude=BAND), sky.AStar()),
        (sky.Objective(unit="metres", fuel=3.0, end=7.0), sky.Taut()),
        (sky.Objective(unit="metres", divergence=0.1), sky.Cheapest(legs=1_200_000)),
        (sky.Objective(unit="metres", altitude=BAND), sky.Cheapest(legs=1_200_000)),
        (sky.Objective(unit="metres", climb=CLIMB), sky.Cheapest(legs=1_200_000)),
    ],
)
def test_what_the_objective_prices_decides(objective, chosen):
    scenario = sky.Scenario.model_validate({**dict(world(1, ("box",))), "objective": objective, "zones": ()})
    assert sky.Auto().choose(scenario) == chosen
    result = sky.Auto().plan(sky.Problem(scenario))
    assert result.provenance.planner == repr(chosen)
    assert result.any_angle == sky.Auto().leaves_lattice(scenario) == (scenario.objective.unit == "metres")


@pytest.mark.parametrize(("threats", "legs", "restarts"), [(0, 1_000_000, 0), (4, 700_000, 1), (30, 1_500_000, 1)])
def test_more_legs_are_priced_among_more_obstacles_and_zones(threats, legs, restarts):
    assert sky.Auto().choose(sky.random_threats(threats, seed=3)) == sky.Cheapest(legs=legs, restarts=restarts)


@pytest.mark.parametrize("seed", [3, 7])
def test_a_search_that_begins_anew_finds_nothing_dearer(seed):
    problem = sky.Problem(sky.random_threats(15, seed=seed))
    once, twice = (sky.Cheapest(legs=300_000, restarts=restarts, proof=0).plan(problem) for restarts in (0, 1))
    assert twice.cost <= once.cost
    assert twice.effort.evaluations > 1.2 * once.effort.evaluations


def test_zones_are_priced_unless_their_risk_has_no_weight():
    zones = (sky.Box(min=(5, 5, 0), max=(9, 9, 9), risk=1.0),)
    scenario = world(1, ("box",)).model_copy(update={"zones": zones, "objective": sky.Objective(unit="metres")})
    assert isinstance(sky.Auto().choose(scenario), sky.Cheapest)
    careless = scenario.model_copy(update={"objective": sky.Objective(unit="metres", risk=0.0)})
    assert isinstance(sky.Auto().choose(careless), sky.Taut)


def test_an_aeroplane_follows_no_lattice():
    scenario = world(1, ("box",), unit="nodes", max_speed=12, max_acceleration=15, fixed_wing=WING)
    scenario = scenario.model_copy(update={"objective": sky.Objective()})
    assert isinstance(sky.Auto().choose(scenario), sky.Taut)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("unit", ["nodes", "metres"])
def test_no_planner_that_counts_in_the_same_unit_finds_a_cheaper_path(seed, unit):
    kinds = ("box", "cylinder", "sphere", "prism", "voxels")[: seed % 6]
    scenario = world(seed, kinds, terrain=seed % 2 == 1, soft=seed % 4 > 1, unit=unit)
    problem = sky.Problem(scenario)
    found = sky.Auto().plan(problem)
    assert found.status.reached
    assert sky.check_result(scenario, 0, 0, found) == []
    off = sky.Auto().leaves_lattice(scenario)
    others = [sky.Taut(), sky.ThetaStar(), sky.WaypointMVO(legs="straight")] if off else [sky.HybridMVO(), sky.MVO()]
    for other in others:
        result = other.plan(problem, stop=sky.MaxIterations(10), rng=seed)
        assert found.cost <= result.cost * 1.005


def test_a_mission_that_names_no_planner_is_planned_by_the_best_one():
    scenario = sky.read("table-4.9-2")
    mission = sky.plan_mission(scenario, rng=1)
    named = sky.plan_mission(scenario, sky.AStar(), rng=1)
    assert mission.cost == named.cost
    assert mission.provenance.planner == named.provenance.planner
    for result, other in zip(mission.results, named.results, strict=True):
        np.testing.assert_array_equal(result.path, other.path)


def test_detours_seek_the_whole_objective():
    band = sky.AltitudeBand(low=8, high=8.5, weight=1.0)
    objective = sky.Objective(unit="metres", altitude=band)
    scenario = sky.circle_swap(6, radius=12.0).model_copy(update={"objective": objective})
    mission = sky.plan_mission(scenario, rng=1, assignment="identity")
    led = [r for r in mission.results if r.provenance.planner == "Cheapest, led around others"]
    assert led
    for uav, result in enumerate(mission.results):
        straight = sky.Taut().plan(sky.Problem(scenario, uav, uav)).cost
        assert result.cost < straight  # the detour too is within the band on most of its way


@pytest.mark.parametrize("unit", ["nodes", "metres"])
def test_detours_keep_to_the_unit_of_the_objective(unit):
    scenario = sky.circle_swap(6, radius=12.0).model_copy(update={"objective": sky.Objective(unit=unit)})
    mission = sky.plan_mission(scenario, rng=1, assignment="identity")
    assert mission.complete
    assert any(action.kind == "detour" for action in mission.deconfliction.actions)
    assert list(mission.costs) == [unit]
    assert mission.violations == ()


@pytest.mark.parametrize("seed", [10, 13])
def test_the_default_leaves_no_way_through_a_forest_of_cylinders_to_others(seed):
    rng = np.random.default_rng(seed)
    trunks: list[tuple[float, float, float]] = []
    for _ in range(4000):
        x, y, r = float(rng.uniform(4, 96)), float(rng.uniform(4, 96)), float(rng.uniform(0.8, 2.5))
        ends = all(np.hypot(x - e, y - e) >= r + 2 for e in (3, 97))
        if ends and all(np.hypot(x - a, y - b) >= r + c + 0.55 for a, b, c in trunks):
            trunks.append((x, y, r))
    forest = sky.Scenario(
        name="forest",
        bounds=sky.Bounds(min=(0, 0, 0), max=(100, 100, 10)),
        obstacles=[sky.Cylinder(centre=(x, y), radius=r, low=0, high=10) for x, y, r in trunks],
        clearance=0.25,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=(3, 3, 5))],
        targets=[sky.Target(position=(97, 97, 5))],
    )
    problem = sky.Problem(forest)
    default, others = sky.Auto().plan(problem), [sky.Taut(), sky.ThetaStar(), sky.Cheapest(legs=300_000)]
    assert default.cost <= 1.002 * min(other.plan(problem).cost for other in others)
    assert sky.check_result(forest, 0, 0, default) == []
