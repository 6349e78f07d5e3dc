"""Tours on the command line: options, tables, JSON, what is not visited, and the exit code."""

import json
from pathlib import Path

import pytest

import skyverse as sky
from rounds import rounds
from skyverse.cli.report import report


@pytest.fixture
def given(tmp_path):
    """The scenario of the small mission, without the target that nobody can reach."""
    scenario = rounds().scenario
    targets = [target.model_copy(update={"stay": 0.0, "window": None}) for target in scenario.targets[:3]]
    uavs = [uav.model_copy(update={"end": "target", "battery": None}) for uav in scenario.uavs[:1]]
    sky.write(scenario.model_copy(update={"targets": targets, "uavs": uavs}), tmp_path / "given.json")
    return tmp_path / "given.json"


def test_options_make_a_tour_with_stays_that_comes_home_on_a_battery(skyverse, given):
    words = "--end home --stay 4 --battery 3 --reserve 0.3 --order given --planner taut --no-page -o m.json"
    code, out, err = skyverse("plan", given, *words.split())
    assert code == 0, out + err
    mission = sky.read_mission("m.json")
    (sortie,) = mission.sorties[0]
    assert [visit.target for visit in sortie.visits] == [0, 1, 2]
    assert [round(visit.departure - visit.arrival, 6) for visit in sortie.visits] == [4.0] * 3
    uav = mission.scenario.uavs[0]
    assert (uav.end, uav.battery, uav.reserve) == ("home", 3.0, 0.3)
    assert "fits by" in out


def test_without_options_more_targets_than_uavs_are_a_tour_in_the_best_order(skyverse, given):
    assert skyverse("plan", given, "--planner", "taut", "--no-page", "-o", "m.json")[0] == 0
    assert len(sky.read_mission("m.json").visited) == 3


@pytest.mark.parametrize(
    "words",
    ["--stay -1", "--battery 0", "--reserve 0.95", "--order best-of-all", "--end away", "--battery 3 --vehicle nobody"],
)
def test_what_cannot_be_is_refused(refused, given, words):
    refused("plan", given.name, *words.split())


def test_a_battery_needs_a_vehicle_of_which_mass_and_power_are_known(refused):
    refused("plan", "map1", "--battery", "3")


def test_a_target_that_nobody_visits_is_told_with_why_and_the_mission_is_not_complete(capsys):
    mission = rounds()
    assert not mission.complete
    report(mission, [Path("m.json")], as_json=False)
    out = capsys.readouterr().out
    assert f"no UAV flies to <shut>: {mission.unvisited[0].why}" in out
    report(mission, [Path("m.json")], as_json=True)
    data = json.loads(capsys.readouterr().out)
    assert data["unvisited"] == [{"target": "<shut>", "why": mission.unvisited[0].why}]
    own = data["uavs"][1]["sorties"]
    assert [[visit["target"] for visit in sortie["visits"]] for sortie in own] == [
        [mission.scenario.targets[visit.target].name for visit in sortie.visits] for sortie in mission.sorties[1]
    ]
    assert all(sortie["spare_wh"] > 0 for sortie in own)
