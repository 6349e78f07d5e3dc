"""Files that version 0.1.0 wrote are read, judged and written as they were then.

The files in `written_by_0_1_0` are never written anew: a version that cannot read them breaks what users have kept.
"""

import shutil
from pathlib import Path

import pytest

import skyverse as sky
from skyverse.model.shapes import Voxels

HERE = Path(__file__).parent / "written_by_0_1_0"


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
def test_a_scenario_is_written_as_it_was(name, tmp_path):
    sky.write(sky.read_scenario(HERE / name), tmp_path / name)
    assert (tmp_path / name).read_bytes() == (HERE / name).read_bytes()


def test_a_terrain_is_read_from_the_file_beside_its_scenario():
    scenario = sky.read_scenario(HERE / "hills.yaml")
    assert scenario.terrain.heights.shape == (70, 70)
    assert scenario.objective == sky.Objective(fuel=1, divergence=0.3, end=80)
    assert scenario.uavs[0].fixed_wing.turn_radius == 150


def test_a_mission_is_read_judged_and_written_as_it_was(tmp_path):
    mission = sky.read_mission(HERE / "yard.mission.json")
    assert mission.scenario == sky.read_scenario(HERE / "yard.yaml")
    assert sky.check(mission.scenario, mission) == []
    assert sky.certify(mission.scenario, mission) == (mission.certificates, mission.apart)
    sky.write(mission, tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (HERE / "yard.mission.json").read_bytes()


def test_a_flight_is_read_and_written_as_it_was(tmp_path):
    flight = sky.read_flight(HERE / "yard.flight.json")
    assert flight.mission == sky.read_mission(HERE / "yard.mission.json")
    assert flight.safe
    assert flight.rounds == ("Nothing had to change.",)
    sky.write(flight, tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (HERE / "yard.flight.json").read_bytes()


def test_a_study_goes_on_from_its_rows_where_it_was(tmp_path):
    for name in ("study.yaml", "study.db", "yard.yaml"):
        shutil.copy(HERE / name, tmp_path)
    done = []
    study = sky.read_study(tmp_path / "study.yaml")
    with sky.run_study(study, tmp_path / "study.db", on_run=lambda count, _: done.append(count)) as rows:
        found = [(row.planner, row.budget, row.seed, row.cost, len(row.history.cost)) for row in rows]
    assert done == [4]
    assert found == [
        (planner, "2 iterations", seed, 12.0, length)
        for planner, length in (("astar", 1), ("small MVO", 3))
        for seed in (0, 1)
    ]
