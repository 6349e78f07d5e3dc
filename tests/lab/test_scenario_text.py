"""The text by which a study finds its runs again."""

import hashlib
import json

import pytest

import skyverse as sky
from skyverse.lab.scenario_text import scenario_text


def test_a_scenario_that_version_1_could_say_keeps_the_text_of_version_1():
    text = scenario_text(sky.read("map1"))
    assert json.loads(text)["format"] == "skyverse/scenario/1"
    # the digest of the text that version 0.1.0 made of this scenario
    assert hashlib.sha256(text.encode()).hexdigest().startswith("4ef7260410656466")


@pytest.mark.parametrize(
    "limit", [{"max_climb": 2.0}, {"max_descent": 2.0}, {"tracking_error": sky.TrackingError(vertical=1)}]
)
def test_a_limit_of_version_2_is_part_of_the_text(limit):
    scenario = sky.read("map1")
    limited = scenario.model_copy(update={"uavs": (scenario.uavs[0].model_copy(update=limit),)})
    assert json.loads(scenario_text(limited))["format"] == "skyverse/scenario/2"
    assert sky.Scenario.model_validate_json(scenario_text(limited)) == limited


def test_an_obstacle_that_is_closed_above_is_part_of_the_text():
    scenario = sky.read("map1")
    closed = scenario.obstacles[0].model_copy(update={"closed_above": True})
    scenario = scenario.model_copy(update={"obstacles": (closed, *scenario.obstacles[1:])})
    assert json.loads(scenario_text(scenario))["obstacles"][0]["closed_above"] is True
