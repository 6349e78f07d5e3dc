"""Files that version 0.1.0 wrote are read and judged as they were then, and written in the newest format.

The files in `written_by_0_1_0` are never written anew: a version that cannot read them breaks what users have kept.
"""

import json
import re
import shutil
from pathlib import Path

import pytest
from ruamel.yaml import YAML

import skyverse as sky
from skyverse.model.shapes import Voxels

HERE = Path(__file__).parent / "written_by_0_1_0"
ADDED = {
    "movers": [],
    "tracking_error": {"horizontal": 0.0, "vertical": 0.0},
    "max_climb": None,
    "max_descent": None,
    "hover_power": None,
    "vehicle": "",
    "closed_above": False,
    "solid": True,
    "active": None,
    "max_height": None,
    "max_speed": None,
    "max_yaw_rate": 60.0,
    "max_yaw_acceleration": 120.0,
    "look_at": None,
    "pointing": None,
    "flights": [],
    "straight_bound": False,
    "source": None,
    "objective": "",
    "scenario": "",
    "cautions": [],
    "built_with": [],
    "disturbances": {"gusts": False, "mismatch": 0.0, "position_noise": 0.0, "delay": 0.0},
}
"""What the newest version writes of a file of version 1: the fields that it added, each of which says nothing."""
NOT_KEPT = ("certificates", "apart")
"""Fields of missions of version 1 that are neither read nor written: what the referee said then."""


def load(path):
    text = path.read_text()
    return json.loads(text) if path.suffix == ".json" else YAML(typ="safe").load(text)


def without_added(data):
    """Return the data of a file without what was added and says nothing, and as of version 1.

    These are the fields of ADDED, and the iterations of a history, each row of which ends one.
    """
    if isinstance(data, list):
        return [without_added(entry) for entry in data]
    if not isinstance(data, dict):
        return data
    return {
        key: value[:-1] + "1" if key == "format" else without_added(value)
        for key, value in data.items()
        if (key not in ADDED or value != ADDED[key]) and (key != "iteration" or value != list(range(len(value))))
    }


def test_a_scenario_with_every_kind_of_shape_is_read_from_yaml_and_json_alike():
    scenario = sky.read_scenario(HERE / "yard.yaml")
    assert scenario == sky.read_scenario(HERE / "yard.json")
    assert [shape.shape for shape in scenario.obstacles] == ["box", "cylinder", "sphere", "prism", "voxels"]
    assert isinstance(scenario.obstacles[4], Voxels)
    assert scenario.obstacles[4].occupied.sum() == 4
    assert (scenario.zones[0].risk, scenario.zones[0].kind) == (2.0, "crowd")
    assert scenario.terrain.heights[4, 4] == pytest.approx(0.6)
    assert scenario.frame.origin.geoid == 50.5
    assert [uav.name for uav in scenario.uavs] == ["uav-1", "scout"]


@pytest.mark.parametrize("name", ["yard.yaml", "yard.json", "hills.yaml"])
def test_a_scenario_is_written_as_it_was_but_for_fields_without_a_limit(name, tmp_path):
    scenario = sky.read_scenario(HERE / name)
    sky.write(scenario, tmp_path / name)
    assert without_added(load(tmp_path / name)) == load(HERE / name)
    assert load(tmp_path / name)["format"] == "skyverse/scenario/2"
    assert sky.read_scenario(tmp_path / name) == scenario


def test_a_terrain_is_read_from_the_file_beside_its_scenario():
    scenario = sky.read_scenario(HERE / "hills.yaml")
    assert scenario.terrain.heights.shape == (70, 70)
    assert scenario.objective == sky.Objective(fuel=1, divergence=0.3, end=80)
    assert scenario.uavs[0].fixed_wing.turn_radius == 150


def test_a_mission_is_read_judged_and_written_as_it_was(tmp_path):
    mission = sky.read_mission(HERE / "yard.mission.json")
    assert mission.scenario == sky.read_scenario(HERE / "yard.yaml")
    assert sky.check(mission.scenario, mission) == []
    assert (mission.certificates, mission.apart) == ((), None)
    then = load(HERE / "yard.mission.json")
    now = sky.certify(mission.scenario, mission)
    for again, before in zip((*now.trajectories, now.apart), (*then["certificates"], then["apart"]), strict=True):
        assert again.verdict.value == before["verdict"]
        said = before["sentence"].removesuffix(".").replace("thrust and tilt", "thrust, tilt and yaw")  # judged since
        assert again.sentence.startswith(said)
        assert (again.time, again.position) == (before["time"], before["position"])
        assert again.subdivisions == before["subdivisions"]
    sky.write(mission, tmp_path / "again.json")
    assert without_added(load(tmp_path / "again.json")) == {k: v for k, v in then.items() if k not in NOT_KEPT}
    assert load(tmp_path / "again.json")["format"] == "skyverse/mission/2"
    assert sky.read_mission(tmp_path / "again.json") == mission


def test_a_flight_is_read_and_written_as_it_was(tmp_path):
    flight = sky.read_flight(HERE / "yard.flight.json")
    assert flight.mission == sky.read_mission(HERE / "yard.mission.json")
    assert flight.safe
    assert flight.rounds == ("Nothing had to change.",)
    sky.write(flight, tmp_path / "again.json")
    then = load(HERE / "yard.flight.json")
    then["mission"] = {key: value for key, value in then["mission"].items() if key not in NOT_KEPT}
    assert without_added(load(tmp_path / "again.json")) == then
    assert sky.read_flight(tmp_path / "again.json") == flight


@pytest.mark.parametrize("place", ["uavs[0].max_climb", "uavs[1].vehicle", "obstacles[2].closed_above", "max_height"])
@pytest.mark.parametrize("name", ["yard.yaml", "yard.json", "yard.mission.json", "yard.flight.json"])
def test_a_file_of_version_1_with_a_field_of_version_2_is_refused_by_name(name, place, tmp_path):
    data = load(HERE / name)
    at = data.get("mission", data)
    at = at.get("scenario", at)
    part, _, field = place.partition(".")
    if field:
        at = at[part[:-3]][int(part[-2])]
    at[field or part] = 1
    (tmp_path / name.replace("yaml", "json")).write_text(json.dumps(data))
    with pytest.raises(sky.InputError, match=f"{re.escape(place)}: 'skyverse/scenario/1' has no such field; "):
        sky.read(tmp_path / name.replace("yaml", "json"))


@pytest.mark.parametrize(("field", "value"), [("straight_bound", True), ("objective", "length")])
@pytest.mark.parametrize("name", ["yard.mission.json", "yard.flight.json"])
def test_a_result_of_version_1_cannot_say_what_its_bound_or_its_objective_is(name, field, value, tmp_path):
    data = load(HERE / name)
    data.get("mission", data)["results"][0][field] = value
    (tmp_path / name).write_text(json.dumps(data))
    with pytest.raises(sky.InputError, match=rf"results\[0\]\.{field}: 'skyverse/mission/1' has no such field; "):
        sky.read(tmp_path / name)


@pytest.mark.parametrize(("field", "value"), [("flights", []), ("source", "map1")])
def test_a_mission_of_version_1_has_no_fields_of_version_2(field, value, tmp_path):
    data = load(HERE / "yard.mission.json") | {field: value}
    (tmp_path / "m.json").write_text(json.dumps(data))
    with pytest.raises(sky.InputError, match=f"m.json: {field}: 'skyverse/mission/1' has no such field; "):
        sky.read(tmp_path / "m.json")


def test_rows_of_code_that_is_not_known_are_read_and_never_taken_for_done(tmp_path):
    for name in ("study.yaml", "study.db", "yard.yaml"):
        shutil.copy(HERE / name, tmp_path)
    with pytest.raises(
        sky.InputError, match=r"study\.db: holds the run yard, astar, 2 iterations, seed 0, but of .* code"
    ):
        sky.run_study(sky.read_study(tmp_path / "study.yaml"), tmp_path / "study.db")
    with sky.Rows(tmp_path / "study.db") as rows:
        found = [(row.planner, row.budget, row.seed, row.cost, len(row.history.cost)) for row in rows]
    assert found == [
        (planner, "2 iterations", seed, 12.0, length)
        for planner, length in (("astar", 1), ("small MVO", 3))
        for seed in (0, 1)
    ]
