"""Paths, their moves, ends and costs are judged as the scenario's objective says."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from judged_missions import (
    MADE_BY,
    METRES,
    SCENARIO,
    STRAIGHT,
    VALID,
    alpha,
    grounded,
    in_metres,
    no_result,
    put,
    result,
    resulting,
    row,
    walking,
)


def test_a_goal_between_lattice_nodes_is_refused():
    goal = np.array([9.0, 4.5, 2])
    path = [(0, 4, 1), (9, 4, 1), goal]
    mission = in_metres(result(path, 2 * (9 + 1.25**0.5), 1.0))
    assert [(found.fault, found.uavs) for found in sky.check(METRES, mission)] == [(sky.Fault.PATH_ENDS, (0,))]


def test_a_goal_node_out_of_bounds_is_refused():
    at_the_ceiling = sky.Target(position=(9.3, 4.2, 4.0))
    scenario = SCENARIO.model_copy(update={"targets": put(SCENARIO.targets, 1, at_the_ceiling)})
    goal = {"goal": np.array([9.0, 4, 5]), "status": sky.Status.INCOMPLETE}
    mission = grounded(walking(STRAIGHT, 11, 0.3, 80.0 * 3, **goal))
    found = sky.check(scenario, replace(mission, scenario=scenario))
    assert [(violation.fault, violation.uavs) for violation in found] == [(sky.Fault.PATH_ENDS, (0,))]


def test_an_any_angle_path_in_metres_passes():
    path = [(0, 4, 1), (6, 4, 1), (9, 4, 2)]
    assert sky.check(METRES, in_metres(result(path, 2 * (6 + 10**0.5), 1.0))) == []


def test_an_any_angle_path_cannot_be_called_the_lattices_optimum():
    cost = 2 * (6 + 10**0.5) + 1.0
    path = [(0, 4, 1), (6, 4, 1), (9, 4, 2)]
    named = result(path, cost - 1.0, 1.0, status=sky.Status.OPTIMAL, bound=cost)
    assert [found.fault for found in sky.check(METRES, in_metres(named))] == [sky.Fault.PATH_STEP]


def test_a_status_that_its_path_belies_is_told_where_the_path_ends():
    found = [one for one in sky.check(SCENARIO, alpha(status=sky.Status.INCOMPLETE)) if one.fault is sky.Fault.STATUS]
    assert [one.position for one in found] == [tuple(VALID.results[0].path[-1])]


@pytest.mark.parametrize("out", [0.0, 1e-6, 0.5, 2.0])
@pytest.mark.parametrize("status", [sky.Status.START_OUT_OF_BOUNDS, sky.Status.TARGET_OUT_OF_BOUNDS])
def test_a_place_said_to_be_out_of_bounds_must_be(status, out):
    place = (2.0, 2.0, 4.0 + out)
    start = put(SCENARIO.uavs, 0, sky.UAV(name="alpha", start=place))
    target = put(SCENARIO.targets, 1, sky.Target(position=place))
    changed = {"uavs": start} if status is sky.Status.START_OUT_OF_BOUNDS else {"targets": target}
    scenario = SCENARIO.model_copy(update=changed)
    mission = replace(grounded(resulting(no_result(status))), scenario=scenario)
    assert [one.fault for one in sky.check(scenario, mission)] == ([] if out else [sky.Fault.STATUS])


@pytest.mark.parametrize("goal", [None, "there", np.zeros(2)])
def test_a_goal_that_is_no_place_is_told(goal):
    assert [found.fault for found in sky.check(SCENARIO, alpha(goal=goal))] == [sky.Fault.PATH_ENDS]


def test_a_path_of_one_node_is_judged_as_a_point():
    at_home = sky.UAV(name="alpha", start=(4, 4, 1))
    scenario = SCENARIO.model_copy(
        update={"uavs": (at_home,), "targets": (sky.Target(position=(4, 4, 1)),), "obstacles": SCENARIO.obstacles}
    )
    stay = sky.Trajectory(np.array([0.0, 1.0]), np.array([[[4.0, 4, 1]]]))
    mission = sky.Mission(scenario, (0,), (result([(4, 4, 1)], 1),), (stay,), (), MADE_BY)
    assert sky.check(scenario, mission) == []
    shut = scenario.model_copy(update={"clearance": 1.1})
    faults = [found.fault for found in sky.check(shut, replace(mission, scenario=shut))]
    assert faults == [sky.Fault.PATH_CLEARANCE, sky.Fault.TRAJECTORY_CLEARANCE]


@pytest.mark.parametrize(("inside", "faults"), [(0, []), (8e-7, []), (1.2e-6, [sky.Fault.PATH_CLEARANCE])])
def test_a_path_may_touch_a_grown_box_but_not_enter_it(inside, faults):
    y = 3.25 - inside
    path = np.array([(0, 4, 1), (2.5, y, 1), (6.5, y, 1), (9, 4, 2)])
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert [found.fault for found in sky.check(METRES, in_metres(result(path, 2 * length, 2.0)))] == faults


def test_a_path_inside_an_obstacle_is_told_its_depth():
    legs = ("x", 4), ("y", -2), ("x", 2), ("y", 2), ("x", 3), ("z", 1)
    (found,) = sky.check(SCENARIO, walking(row((0, 4, 1), *legs), 15, 0.3 * 5))
    assert found.message == (
        "alpha's path is 0.5 m inside obstacle 0 after node 6, position (4.5, 2, 1); 0.25 m are required."
    )
    assert found.position == pytest.approx((4.5, 2, 1))


def test_of_two_obstacles_the_one_entered_deeper_is_told():
    legs = ("x", 4), ("y", -2), ("x", 2), ("y", 2), ("x", 3), ("z", 1)
    for more in (sky.Box(min=(6.9, 3.9, 0), max=(7.1, 4.1, 2)), sky.Box(min=(1.9, 3.9, 0), max=(2.1, 4.1, 2))):
        for boxes in ((more, *SCENARIO.obstacles), (*SCENARIO.obstacles, more)):
            scenario = SCENARIO.model_copy(update={"obstacles": boxes})
            mission = grounded(walking(row((0, 4, 1), *legs), 15, 0.3 * 5))
            found = sky.check(scenario, replace(mission, scenario=scenario))
            assert f"0.5 m inside obstacle {boxes.index(SCENARIO.obstacles[0])} " in found[1].message


@pytest.mark.parametrize(("field", "node"), [("start", 0), ("goal", -1)])
def test_ends_that_are_wrong_are_told_where_they_are(field, node):
    elsewhere = np.array([np.nan, 4.0, 1.0])
    found = [one for one in sky.check(SCENARIO, alpha(**{field: elsewhere})) if one.fault is sky.Fault.PATH_ENDS]
    assert [one.position for one in found] == [tuple(STRAIGHT[node])]
