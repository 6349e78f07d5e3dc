"""UAVs that keep each other from going on, off the mission that would have led them past each other."""

from dataclasses import replace

import numpy as np

import skyverse as sky

MEETING = (3, 4, 6, 8)
"""Of the UAVs of a maze, some from either hall, which meet in a passage and then waited there for ever."""
GUST = np.array((0.0, 0.0, 0.05))
"""Metres by which all of them are moved at the beginning, so that they leave the mission's flights."""


def mission_in_a_maze():
    maze = sky.random_maze(10, seed=0)
    uavs = [sky.UAV(name=f"uav-{k}", start=maze.uavs[k].start, max_speed=1.0, separation=0.4) for k in MEETING]
    fields = {"uavs": uavs, "targets": [maze.targets[k] for k in MEETING]}
    return sky.plan_mission(sky.Scenario(**{**dict(maze), **fields}), assignment="identity")


def test_uavs_that_meet_in_a_passage_are_led_apart():
    mission = mission_in_a_maze()
    assert not mission.violations
    replanner, answers, uavs = sky.Replanner(mission), [], range(len(MEETING))
    for k in range(1, 300):
        gust = {uav: (one.start + GUST, np.zeros(3)) for uav, one in enumerate(mission.scenario.uavs)}
        answers += replanner.observe(k / 10, states=gust if k == 1 else None)
        if all((replanner.arrival(uav) or np.inf) <= replanner.now for uav in uavs):
            break
    else:
        raise AssertionError("they have not arrived after 30 s")
    assert all(answer.proven for answer in answers)
    flown = tuple(replanner.flown(uav) for uav in uavs)
    assert sky.certify(mission.scenario, replace(mission, trajectories=flown)).apart.verdict is sky.Verdict.PROVEN
