"""The costs of a mission: sums in one unit, and never a sum of nodes and metres."""

import dataclasses
import math

import pytest

import skyverse as sky


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
