"""What a mission says of its fleet: costs in one unit, gaps rounded up, and what tables tell of flights."""

import dataclasses
import math
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.flight_table import measure_flight
from skyverse.model.short_lines import told_gap


def test_a_mission_that_leaves_a_pair_out_is_not_complete(mission):
    assert mission.complete
    left_out = sky.Mission(
        mission.scenario,
        (mission.assignment[0], None),
        (mission.results[0], None),
        (mission.trajectories[0], None),
        (),
        mission.provenance,
    )
    assert not left_out.complete
    assert [v.fault for v in sky.check(mission.scenario, left_out)] == [sky.Fault.ASSIGNMENT]


def test_the_makespan_is_the_last_arrival_and_the_total_time_the_sum_of_all(mission):
    arrivals = [trajectory.end for trajectory in mission.trajectories]
    assert mission.makespan == max(arrivals)
    assert mission.total_time == sum(arrivals)


@pytest.fixture(scope="module")
def fleet():
    """The mission of a fleet on the lattice, priced in nodes, and that of the same fleet off the lattice, in metres."""
    scenario = sky.read("table-4.9-2")
    return tuple(sky.plan_mission(scenario, planner, rng=1) for planner in (sky.AStar(), sky.Taut()))


def mixed(fleet):
    nodes, metres = fleet
    return dataclasses.replace(nodes, results=(nodes.results[0], metres.results[1]))


def test_the_cost_is_the_sum_and_has_the_unit_of_its_results(fleet):
    for mission, unit in zip(fleet, ("nodes", "metres"), strict=True):
        total = sum(result.cost for result in mission.results)
        assert mission.cost == total
        assert mission.costs == {unit: total}


def test_costs_of_two_units_have_no_sum_but_one_each(fleet):
    nodes, metres = fleet
    mission = mixed(fleet)
    assert math.isnan(mission.cost)
    assert mission.costs == {"nodes": nodes.results[0].cost, "metres": metres.results[1].cost}


def test_a_uav_without_a_path_makes_every_sum_infinite(fleet):
    nodes, _ = fleet
    lost = dataclasses.replace(nodes.results[1], path=nodes.results[1].path[:0], cost=math.inf)
    assert dataclasses.replace(nodes, results=(nodes.results[0], lost)).cost == math.inf
    assert dataclasses.replace(nodes, results=(lost, lost)).cost == math.inf
    assert dataclasses.replace(nodes, results=(None, None)).cost == 0
    everything = dataclasses.replace(nodes, results=(*mixed(fleet).results, lost))
    assert everything.costs == {"nodes": math.inf, "metres": math.inf}


def test_a_scenario_priced_in_metres_has_metres_on_the_lattice_too():
    scenario = sky.read("table-4.9-2")
    objective = scenario.objective.model_copy(update={"unit": "metres"})
    mission = sky.plan_mission(scenario.model_copy(update={"objective": objective}), sky.AStar(), rng=1)
    assert list(mission.costs) == ["metres"]


@pytest.mark.parametrize(
    ("gap", "told"),
    [
        (None, "-"),
        (float("inf"), "-"),
        (0.0, "0 %"),
        (-1e-12, "0 %"),
        (1e-12, "0 %"),
        (1e-6, "0.1 %"),
        (0.02, "2 %"),
        (0.0201, "2.1 %"),
        (1.0885, "109 %"),
        (12.3456, "1,235 %"),
        (-0.25, "-25 %"),
    ],
)
def test_a_gap_is_told_in_per_cent_and_rounded_up(gap, told):
    assert told_gap(gap) == told


@given(st.floats(1e-8, 1e4))
def test_no_gap_is_told_smaller_than_it_is(gap):
    told = float(told_gap(gap).removesuffix(" %").replace(",", "")) / 100
    assert gap * (1 - 1e-8) <= told <= gap + max(0.0011, 0.011 * (gap >= 0.1))


@pytest.fixture(scope="module")
def around_a_wall():
    wall = sky.Box(min=(4, -1, 0), max=(6, 9, 10))
    return sky.Scenario(
        name="wall",
        bounds=sky.Bounds(min=(0, -1, 0), max=(10, 10, 10)),
        obstacles=(wall,),
        clearance=0.25,
        lattice=sky.Lattice(step=(1, 1, 1)),
        objective="turns",
        uavs=(sky.UAV(start=(1, 1, 1)),),
        targets=(sky.Target(position=(9, 1, 1)),),
    )


def test_a_bound_with_a_turn_in_it_is_not_called_the_straight_line(around_a_wall):
    result = sky.ThetaStar().plan(sky.Problem(around_a_wall))
    assert result.bound == pytest.approx(8 + around_a_wall.objective.divergence)
    assert not result.straight_bound
    assert result.gap_sentence.endswith("above the best possible")


@pytest.mark.parametrize("planner", [sky.ThetaStar(), sky.Taut(proof=0), sky.Cheapest(proof=0)], ids=repr)
def test_a_bound_that_is_the_straight_line_is_called_so(around_a_wall, planner):
    plain = around_a_wall.model_copy(update={"objective": sky.Objective(unit="metres", fuel=2)})
    result = planner.plan(sky.Problem(plain))
    assert result.bound == pytest.approx(2 * 8)
    assert result.straight_bound
    assert result.gap_sentence.endswith("above the straight line, which no path beats")


def test_a_bound_that_knows_the_obstacles_is_not_called_the_straight_line(around_a_wall):
    result = sky.Taut().plan(sky.Problem(around_a_wall))
    assert result.bound > 8.5
    assert not result.straight_bound
    assert not sky.AStar().plan(sky.Problem(around_a_wall)).straight_bound


def test_the_straight_line_of_a_path_with_lifts_joins_their_tops(around_a_wall):
    strays = sky.UAV(start=(1, 1, 0.5), tracking_error=sky.TrackingError(horizontal=0.2, vertical=1))
    problem = sky.Problem(
        around_a_wall.model_copy(update={"objective": sky.Objective(unit="metres"), "uavs": (strays,)})
    )
    up, down = problem.start[2] - 0.5, problem.end[2] - 1
    assert up > 0
    result = sky.Taut(proof=0).plan(problem)
    assert result.bound == pytest.approx(up + np.linalg.norm(problem.end - problem.start) + down)
    assert result.straight_bound


def test_an_optimum_on_the_lattice_is_not_called_the_best_of_all():
    result = sky.AStar().plan(sky.Problem(sky.read("map1")))
    assert result.gap_sentence == "no path on the lattice costs less"
    assert replace(result, cost=1.015 * result.cost).gap_sentence == (
        "at most 1.5 % above the best possible on the lattice"
    )
    assert "impossible" in replace(result, cost=0.9 * result.cost).gap_sentence
    assert replace(result, bound=None).gap_sentence == ""


@pytest.fixture
def over_a_hill():
    """Return a flight that climbs 3 m over 4 m, descends 1 m over 4 m, and hovers for a while."""
    legs = np.array([[(0, 0, 1), (4, 0, 3)], [(4, 0, 4), (4, 0, -1)], [(8, 0, 3), (0, 0, 0)]], dtype=float)
    return sky.Trajectory(np.array([0.0, 1, 2, 5]), legs)


def test_climb_slope_and_heights_are_those_of_the_flight(over_a_hill):
    found = measure_flight(over_a_hill)
    assert found.climb == pytest.approx(3)
    assert found.steepest == pytest.approx(np.degrees(np.arctan2(3, 4)))
    assert (found.lowest, found.highest) == pytest.approx((1, 4))


def test_heights_are_counted_from_a_terrain(over_a_hill):
    ramp = sky.Terrain(origin=(-10, -10), step=(20, 20), heights=[[-5, -5], [5, 5]])
    found = measure_flight(over_a_hill, ramp)
    assert (found.lowest, found.highest) == pytest.approx((3 - 8 / 2, 4 - 4 / 2))


def test_a_flight_that_stands_still_has_no_slope():
    found = measure_flight(sky.Trajectory(np.array([0.0, 1.0]), np.array([[(1.0, 2, 3), (0, 0, 0)]])))
    assert (found.climb, found.steepest, found.lowest, found.highest) == (0, 0, 3, 3)


def test_a_gap_is_told_only_of_a_path_that_arrives(mission):
    for result in mission.results:
        assert (result.gap is not None) == result.status.reached


@pytest.mark.parametrize(("cost", "bound", "gap"), [(6, 4, 0.5), (0, 0, 0), (6, 0, inf), (6, -1, inf)])
def test_a_bound_that_says_nothing_makes_no_path_look_optimal(mission, cost, bound, gap):
    assert replace(mission.results[0], cost=cost, bound=bound).gap == gap
