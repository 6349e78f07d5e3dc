"""Fleets with one target for each UAV: the special case of tours, answered as before there were any."""

import pytest

import skyverse as sky
from skyverse.files import BUILTIN_NAMES

BEFORE = {
    "map1": (
        (0,),
        (265.0,),
        (0.0,),
        (7.58993,),
    ),
    "map2": (
        (0,),
        (229.0,),
        (0.0,),
        (12.712062,),
    ),
    "map3": (
        (0,),
        (267.0,),
        (0.0,),
        (6.523985,),
    ),
    "table-4.8": (
        (0, 2, 1, 4, 3),
        (146.0, 33.0, 14.0, 101.0, 244.0),
        (0.18, 0.0, 0.0, 0.0, 0.0),
        (5.025837, 1.955015, 1.605639, 4.663359, 6.605045),
    ),
    "table-4.9-2": (
        (1, 0),
        (136.0, 102.0),
        (0.0, 0.0),
        (8.042206, 5.457208),
    ),
    "table-4.9-3": (
        (2, 0, 1),
        (136.0, 72.0, 102.0),
        (0.0, 0.0, 0.0),
        (8.042206, 4.890908, 5.457208),
    ),
    "table-4.9-4": (
        (3, 0, 1, 2),
        (101.0, 72.0, 79.0, 125.0),
        (0.0, 0.0, 0.0, 0.0),
        (5.34469, 4.890908, 4.848209, 8.333386),
    ),
    "table-4.11": (
        (4, 2, 3, 0, 1),
        (189.0, 229.0, 131.0, 167.0, 251.0),
        (0.0, 0.82, 0.0, 0.0, 0.0),
        (6.21964, 6.933795, 4.048081, 5.080422, 7.160747),
    ),
    "table-4.12": (
        (0, 3, 4, 1, 2),
        (81.0, 134.0, 42.0, 79.0, 127.0),
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (5.117402, 8.394114, 2.002495, 4.848209, 8.322104),
    ),
    "table-4.13": (
        (2, 3, 0, 4, 1),
        (196.0, 205.0, 201.0, 160.0, 279.0),
        (0.1, 0.0, 0.0, 0.0, 0.0),
        (5.754753, 6.248208, 5.707261, 5.594546, 6.708185),
    ),
    "jacksboro": (
        (1, 0, 2, 4, 3),
        (9933.448561, 9867.258126, 9001.017215, 8785.190833, 9222.162796),
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (666.802234, 662.269101, 604.551907, 589.793169, 619.245574),
    ),
}
"""Of the last version without tours (commit 7c2dc212): targets, costs, and when UAVs depart and arrive, seconds."""


@pytest.mark.parametrize("name", BEFORE)
def test_fleets_with_one_target_each_are_answered_as_before_there_were_tours(name):
    mission = sky.plan_mission(sky.read(name), rng=1)
    assignment, costs, begins, ends = BEFORE[name]
    assert mission.assignment == assignment
    assert [result.cost for result in mission.results] == pytest.approx(costs)
    assert [one.start for one in mission.trajectories] == pytest.approx(begins)
    assert [one.end for one in mission.trajectories] == pytest.approx(ends)
    assert mission.sorties == ()
    assert mission.unvisited == ()
    targets = mission.scenario.targets
    for target, flown in zip(assignment, mission.trajectories, strict=True):
        assert flown.at([flown.end]).position[0] == pytest.approx(targets[target].position)


def test_all_built_in_scenarios_are_held():
    assert set(BEFORE) == set(BUILTIN_NAMES)
