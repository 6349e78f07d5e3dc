"""The ground under places and under starts, with a terrain and without."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.pad import ground_height, home_height


def scenario(**more):
    given = {
        "name": "yard",
        "bounds": {"min": (0, 0, -2), "max": (10, 10, 20)},
        "clearance": 0.5,
        "lattice": {"step": (1, 1, 1)},
        "uavs": [{"start": (2, 4, 8)}, {"start": (2, 4, 8), "home": 1.5}],
    }
    return sky.Scenario(**given | more)


def test_without_a_terrain_the_ground_is_the_lower_bound_and_a_home_the_start():
    level = scenario()
    assert ground_height(level, np.zeros((3, 5, 2))).tolist() == np.full((3, 5), -2.0).tolist()
    assert [home_height(level, uav) for uav in (0, 1)] == [8.0, 1.5]


def test_with_a_terrain_both_are_the_terrains_but_for_a_home_that_is_stated():
    heights = np.add.outer(np.arange(11.0), np.zeros(11)) / 2  # rises by half a metre for each metre north
    sloped = scenario(terrain={"origin": (0, 0), "step": (1, 1), "heights": heights.tolist()})
    found = ground_height(sloped, [(1, 3), (5, 7.5)])
    assert found == pytest.approx(sloped.terrain.height(np.array([(1, 3), (5, 7.5)])))
    assert home_height(sloped, 0) == pytest.approx(float(sloped.terrain.height(np.array((2, 4)))))
    assert home_height(sloped, 1) == 1.5
