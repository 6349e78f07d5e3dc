"""A UAV that stands on the ground rises straight up to where it may stray, and flies, pays and lands from there."""

import json

import numpy as np
import pytest

import skyverse as sky
from skyverse.cli.given_scenario import from_the_ground, refuse_unsafe, with_ends
from skyverse.maps.assembly.build import build_scenario
from skyverse.maps.assembly.options import BuildOptions
from skyverse.model.take_off import take_off

HERE = (46.81, 9.85, sky.AboveGround(0.0))
TARGET = (46.8105, 9.8505, sky.AboveGround(60.0))


def built(start=HERE, **options):
    notes = []
    given = {"vehicle": "camera", "ground": sky.AboveSea(1500.0)} | options
    made = build_scenario(BuildOptions("field", uavs=[start], targets=[TARGET], on_note=notes.append, **given))
    return made, [note.text for note in notes if "takes off" in note.text]


@pytest.mark.parametrize("reference", [sky.AboveGround, sky.AboveHome])
def test_a_start_on_the_ground_is_straight_above_it_and_is_told(reference):
    scenario, (said,) = built((*HERE[:2], reference(0.0)))
    (uav,) = scenario.uavs
    x, y, z = uav.start
    assert (x, y) == pytest.approx(sky.to_local(scenario.frame.origin, [(*HERE[:2], 0.0)])[0, :2])
    up = z - float(scenario.terrain.height((x, y)))
    assert scenario.ground_clearance + uav.tracking_error.vertical < up < 40.0
    assert said == f"uav-1 takes off from the ground and rises straight up by {up:.1f} m, where its flight starts"
    assert take_off(scenario, 0, uav.start).seconds == pytest.approx(up / 1.5)
    refuse_unsafe("field", scenario)


def test_plan_raises_a_start_on_the_ground_as_scenario_build_does(capsys):
    scenario, _ = built()
    asked = from_the_ground(with_ends("field", scenario, ["46.81,9.85,0 m agl"], None))
    assert asked.uavs[0].start == pytest.approx(scenario.uavs[0].start)
    assert "takes off from the ground" in capsys.readouterr().err
    assert from_the_ground(asked) is asked


def test_a_mission_from_the_ground_to_home_is_proven_and_pays_for_its_take_off():
    scenario, _ = built()
    home = scenario.model_copy(update={"uavs": (scenario.uavs[0].model_copy(update={"end": "home"}),)})
    mission = sky.plan_mission(home)
    assert mission.complete
    assert not sky.check(home, mission)
    flight, (sortie,) = mission.flights[0], mission.sorties[0]
    spent = flight.energy_bound - flight.energy
    assert spent >= take_off(home, 0, home.uavs[0].start).joules > 0
    assert np.array(mission.trajectories[0].at([sortie.end]).position[0]) == pytest.approx(home.uavs[0].start)


def test_what_cannot_rise_is_refused(refuses, tmp_path):
    square = [[9.8499, 46.8099], [9.8501, 46.8099], [9.8501, 46.8101], [9.8499, 46.8101], [9.8499, 46.8099]]
    hangar = tmp_path / "roof.geojson"
    hangar.write_text(json.dumps({"type": "Polygon", "coordinates": [square]}), encoding="utf-8")
    with refuses():
        built(buildings=[hangar], reading=sky.Reading(building_height=8.0))
    with refuses():
        built(vehicle="mapping")
