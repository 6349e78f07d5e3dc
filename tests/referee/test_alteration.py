"""A mission whose embedded scenario was altered says in which fields, and certificates are of one scenario."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from judged_missions import SCENARIO, VALID


def said(**changes):
    embedded = SCENARIO.model_copy(update=changes)
    found = [
        found for found in sky.check(SCENARIO, replace(VALID, scenario=embedded)) if found.fault is sky.Fault.SCENARIO
    ]
    assert len(found) == 1
    assert embedded.digest[:12] in found[0].message
    assert SCENARIO.digest[:12] in found[0].message
    return found[0].message


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"clearance": 0.1}, "clearance is 0.1 in the mission, not 0.25"),
        ({"obstacles": SCENARIO.obstacles[1:]}, "obstacles has 1 entry in the mission, not 2"),
        (
            {"obstacles": (SCENARIO.obstacles[0], sky.Box(min=(0, 0, 3.6), max=(1, 1, 4)))},
            "obstacles[1].min is (0.0, 0.0, 3.6) in the mission, not (0.0, 0.0, 3.5)",
        ),
        (
            {"uavs": (SCENARIO.uavs[0].model_copy(update={"max_speed": 50.0}), *SCENARIO.uavs[1:])},
            "uavs[0].max_speed is 50 in the mission, not 5",
        ),
        ({"description": "x" * 1000}, "description is 'xxxxxxxxxx"),
    ],
)
def test_fields_that_were_altered_are_named(changes, words):
    assert words in said(**changes)


def test_many_altered_fields_are_counted():
    uavs = tuple(uav.model_copy(update={"max_speed": 9.0, "max_jerk": 9.0, "max_tilt": 9.0}) for uav in SCENARIO.uavs)
    message = said(uavs=uavs)
    assert "; and 3 more." in message
    assert len(message) < 800


def test_an_altered_ground_is_told_in_numbers():
    heights = np.zeros((11, 7))
    flat = sky.Terrain(origin=(0, 0), step=(1, 1), heights=heights)
    heights[3, 3] = 1.0
    hill = sky.Terrain(origin=(0, 0), step=(1, 1), heights=heights)
    true = SCENARIO.model_copy(update={"terrain": hill})
    found = sky.check(true, replace(VALID, scenario=SCENARIO.model_copy(update={"terrain": flat})))
    assert any("terrain.heights differs in 1 of 77 numbers" in one.message for one in found)


def test_a_second_ground_that_only_one_of_both_has_is_told():
    heights = np.zeros((11, 7))
    grounds = (
        sky.Terrain(origin=(0, 0), step=(1, 1), heights=heights, lowest=lowest) for lowest in (None, heights - 1)
    )
    one, two = (SCENARIO.model_copy(update={"terrain": ground}) for ground in grounds)
    for true, embedded, words in (
        (one, two, "terrain.lowest is given in the mission only"),
        (two, one, "terrain.lowest is missing in the mission"),
    ):
        found = sky.check(true, replace(VALID, scenario=embedded))
        assert any(words in violation.message for violation in found)


def test_a_mission_without_a_scenario_is_refused():
    (found,) = sky.check(SCENARIO, replace(VALID, scenario=None))
    assert found.message == "The mission embeds no scenario."
