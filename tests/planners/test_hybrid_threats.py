"""HybridMVO on objectives that no exact search prices: against its peers, and what it owes with seeds and without."""

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.planners.base import provenance
from skyverse.planners.polyline_moves import small_move
from skyverse.planners.straight_legs import open_straight_run
from skyverse.trajectory import fly_along
from worlds import ROOM, scenarios

FIELDS = list(itertools.product((15, 30), range(20)))
BUDGET = sky.MaxEvaluations(500)


@pytest.mark.slow
def test_seeded_by_taut_and_astar_it_beats_the_best_of_six_peers_on_nine_fields_of_ten():
    """40 random fields of threats at 500 evaluations; the peers but MVO have straight legs too."""
    for package in ("cma", "pymoo", "niapy"):
        pytest.importorskip(package, reason="the peers need the extra optimisers")
    ours = sky.HybridMVO(seeds=(sky.Taut(), sky.AStar()))
    peers = [*(kind(legs="straight") for kind in (sky.DE, sky.CMAES, sky.LSHADE, sky.PSO, sky.GWO)), sky.MVO()]
    wins = 0
    for threats, seed in FIELDS:
        problem = sky.Problem(sky.random_threats(threats, seed=seed))
        result = ours.plan(problem, stop=BUDGET, rng=seed)
        assert result.effort.evaluations == 500
        assert sky.check_result(problem.scenario, 0, 0, result) == []
        wins += result.status.reached and all(
            result.cost < peer.plan(problem, stop=BUDGET, rng=seed).cost for peer in peers
        )
    assert wins >= 36


def test_what_a_seed_knows_is_never_lost_and_its_effort_and_seconds_count():
    for threats, seed in FIELDS[::5]:
        problem = sky.Problem(sky.random_threats(threats, seed=seed))
        taut = sky.Taut().plan(problem)
        result = sky.HybridMVO(seeds=(sky.Taut(),)).plan(problem, stop=sky.MaxIterations(3), rng=1)
        assert result.history.by_iteration().cost[0] <= taut.cost * (1 + 1e-12)
        assert result.cost < taut.cost
        assert result.history.by_iteration().evaluations[0] == 25 + taut.effort.evaluations
        assert result.history.by_iteration().generated_nodes[0] > taut.effort.generated_nodes
        assert "seeds=(Taut(" in result.provenance.planner


def test_a_lattice_path_that_is_a_seed_is_pulled_tight_from_the_true_start_to_the_true_target():
    problem = sky.Problem(sky.random_threats(30, seed=1))
    result = sky.HybridMVO(universes=2, seeds=(sky.AStar(),)).plan(problem, stop=sky.MaxEvaluations(3), rng=0)
    assert result.any_angle
    np.testing.assert_array_equal(result.path[[0, -1]], [problem.start, problem.end])
    assert result.terms["fuel"] < sky.AStar().plan(problem).terms["fuel"]


def test_it_flies_round_a_zone_over_a_low_one_and_level_where_that_pays():
    wall = sky.Prism(vertices=((4, 0), (6, 0), (6, 8), (4, 8)), low=0, high=5, risk=10)
    field = sky.Scenario(
        name="field",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 5)),
        zones=(wall,),
        clearance=0.001,
        lattice=sky.Lattice(step=(1, 1, 1)),
        objective=sky.Objective(unit="metres"),
        uavs=(sky.UAV(start=(0, 2, 1)),),
        targets=(sky.Target(position=(10, 2, 1)),),
    )
    round_it = 2 * np.hypot(4, 6) + 2
    low = field.model_copy(update={"zones": (wall.model_copy(update={"high": 2.0}),)})
    over_it = 2 * np.hypot(4, 1) + 2
    for scenario, least in ((field, round_it), (low, over_it)):
        result = sky.HybridMVO().plan(sky.Problem(scenario), stop=sky.MaxEvaluations(8000), rng=1)
        assert least * (1 - 1e-9) <= result.cost < 1.01 * least
    band = field.model_copy(
        update={
            "zones": (),
            "objective": sky.Objective(unit="metres", altitude=sky.AltitudeBand(low=3, high=4, weight=5)),
        }
    )
    result = sky.HybridMVO().plan(sky.Problem(band), stop=sky.MaxEvaluations(4000), rng=1)
    assert 2.9 < np.interp(5, *result.path[:, [0, 2]].T) < 4.1


def test_the_flight_keeps_to_the_joints_that_lead_round_a_zone():
    problem = sky.Problem(sky.random_threats(15, seed=1))
    result = sky.HybridMVO().plan(problem, stop=BUDGET, rng=1)
    stops = fly_along(problem, result, "stop-and-go")
    at_rest = stops.at(stops.knots[np.linalg.norm(stops.at(stops.knots).velocity, axis=1) < 1e-9]).position
    np.testing.assert_allclose(at_rest, result.path, atol=1e-6)


@settings(max_examples=40, deadline=None)
@given(scenarios(), st.integers(0, 2**32), st.booleans())
def test_in_random_worlds_the_referee_passes_what_it_says(scenario, seed, seeded):
    planner = sky.HybridMVO(universes=4, legs="straight", joints=3, seeds=(sky.AStar(),) if seeded else ())
    problem = sky.Problem(scenario)
    result = planner.plan(problem, stop=sky.MaxIterations(5), rng=seed)
    assert sky.check_result(scenario, 0, 0, result) == []
    if result.status.reached:
        assert result.cost >= result.bound * (1 - 1e-12)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.integers(2, 6), st.floats(0, 1))
def test_small_moves_keep_the_ends_the_bounds_and_the_room(seed, n, reach):
    rng = np.random.default_rng(seed)
    scenario = sky.random_threats(9, seed=seed % 7)
    problem = sky.Problem(scenario)
    origin = provenance("by hand", None, None)
    course = open_straight_run(problem, BUDGET, rng, origin, population=1, joints=4, collision=100.0).task
    path = np.full((6, 3), np.nan)
    path[:n] = rng.uniform(0, 200, (n, 3))
    ends = path[[0, n - 1]].copy()
    for _ in range(50):
        n = small_move(course, rng, path, n, reach)
        assert 2 <= n <= 6
        np.testing.assert_array_equal(path[[0, n - 1]], ends)
        assert np.all((path[:n] >= scenario.bounds.min) & (path[:n] <= scenario.bounds.max))


def test_the_kind_of_legs_follows_the_unit_unless_it_is_given():
    stop = sky.MaxIterations(2)
    metres = ROOM.model_copy(update={"objective": sky.Objective(unit="metres")})
    for scenario, legs, straight_ in (
        (ROOM, None, 0),
        (metres, None, 1),
        (ROOM, "straight", 1),
        (metres, "lattice", 0),
    ):
        planner = dataclasses.replace(sky.HybridMVO(universes=4), legs=legs)
        assert planner.plan(sky.Problem(scenario), stop=stop, rng=1).any_angle == bool(straight_)
