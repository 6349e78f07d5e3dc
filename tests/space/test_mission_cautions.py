"""What a mission leaves out or assumes is one list of records, which all that print, draw or export it show."""

import dataclasses
import io
import json

import numpy as np
import pytest

import skyverse as sky
from of_maps import of_maps
from skyverse.draw import found, scene
from skyverse.space.mission_cautions import mission_cautions

ORIGIN = sky.Frame(origin=sky.Origin(latitude=46.8, longitude=9.85, altitude=1500))
FLAT = sky.Terrain(origin=(0, 0), step=(50, 50), heights=np.zeros((3, 3)), clearance=5)
SHAPES = [
    sky.Box(min=(45, 20, 0), max=(55, 80, 30), solid=False),
    sky.Prism(vertices=[(45, 20), (55, 20), (55, 80), (45, 80)], low=0, high=30, solid=False),
    sky.Cylinder(centre=(50, 50), radius=10, low=0, high=30, solid=False),
    sky.Sphere(centre=(50, 50, 15), radius=15, solid=False),
    sky.Voxels(origin=(45, 45, 0), step=(10, 10, 10), occupied=np.ones((1, 1, 3), bool), solid=False),
]


def planned(*heights, targets=1, assignment="identity", **more):
    """Flights along y = 50, 60 ... at the heights given, in metres, over flat ground."""
    given = {
        "name": "over",
        "bounds": sky.Bounds(min=(0, 0, 0), max=(100, 100, 300)),
        "terrain": FLAT,
        "clearance": 1.0,
        "lattice": sky.Lattice(step=(5, 5, 5)),
        "objective": sky.Objective(unit="metres"),
        "uavs": [sky.UAV(start=(5, 50 + 10 * k, z)) for k, z in enumerate(heights)],
        "targets": [sky.Target(position=(95, 50 + 10 * k, 50)) for k in range(targets)],
        "frame": ORIGIN,
    }
    return sky.plan_mission(sky.Scenario(**(given | more)), sky.Taut(), assignment=assignment)


def kinds(mission):
    return {caution.kind: caution for caution in mission_cautions(mission)}


def test_a_mission_that_leaves_nothing_out_has_no_cautions():
    assert mission_cautions(planned(50)) == []


def test_targets_to_which_no_uav_flies_are_named():
    found = kinds(planned(50, targets=3))
    assert found.keys() == {"no UAV"}
    assert found["no UAV"].names == ("target-2", "target-3")


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.shape)
def test_airspace_that_is_flown_over_is_told_unless_it_is_solid_or_closed_or_elsewhere(shape):
    (over,) = mission_cautions(planned(50, obstacles=[shape]))
    assert (over.kind, over.names) == ("flown over", ("uav-1",))
    assert over.metres == pytest.approx(20, abs=0.01)
    for other in ({"solid": True}, {"closed_above": True}):
        assert "flown over" not in kinds(planned(50, obstacles=[shape.model_copy(update=other)]))
    aside = sky.Box(min=(45, 0, 0), max=(55, 49, 30), solid=False)
    assert "flown over" not in kinds(planned(50, obstacles=[aside]))


def test_flights_above_what_rules_allow_are_told_unless_a_ceiling_above_ground_is_given():
    found = kinds(planned(130))
    assert (found["high"].names, found["high"].metres) == (("uav-1",), pytest.approx(130))
    assert "high" not in kinds(planned(130, max_height=200))
    assert "high" not in kinds(planned(119))
    assert "high" not in kinds(planned(130, frame=sky.Frame()))  # a room


def test_flights_lower_than_both_their_ends_are_told_where_nobody_knows_of_trees():
    hill = np.zeros((11, 3))
    hill[4:7] = 40
    ground = sky.Terrain(origin=(0, 0), step=(10, 50), heights=hill, clearance=5)
    found = kinds(planned(50, terrain=ground))
    assert found["low"].names == ("uav-1",)
    assert found["low"].metres == pytest.approx(10, abs=0.5)
    tree = sky.Cylinder(centre=(50, 10), radius=2, low=40, high=60, kind="tree")
    assert "low" not in kinds(planned(50, terrain=ground, obstacles=[tree]))
    assert "low" not in kinds(planned(50, terrain=ground, frame=sky.Frame()))


def test_pages_exports_and_live_hold_what_plan_tells_and_no_verb_repeats_it(tmp_path, capsys, monkeypatch):
    from skyverse.cli import main

    mission = planned(130, targets=2, obstacles=SHAPES[:1])
    told = [caution.sentence for caution in mission_cautions(mission)]
    assert len(told) == 3
    assert list(scene(mission).cautions) == told
    assert not [word for word in "".join(found(scene(mission)).values()).split() if word.isidentifier() and "_" in word]
    sky.write(mission, tmp_path / "m.json")
    with pytest.raises(SystemExit):
        main(["check", str(tmp_path / "m.json")])
    assert "WARNING" not in capsys.readouterr().out
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO()))
    with pytest.raises(SystemExit):
        main(["live", str(tmp_path / "m.json")])
    sent, said = capsys.readouterr()
    assert json.loads(sent.splitlines()[0])["cautions"] == told
    assert "WARNING" not in said
    notes = []
    sky.export(mission, tmp_path / "m.gpx", on_note=notes.append)
    assert [note for note in notes if "WARNING" in note] == told


def test_what_a_file_gave_nothing_of_stays_with_the_scenario_and_its_missions(tmp_path):
    ring = [[9.0, 46.0], [9.001, 46.0], [9.001, 46.001], [9.0, 46.0]]
    shape = {"type": "Polygon", "coordinates": [ring]}
    feature = {"type": "Feature", "properties": {"upper": "60 m agl"}, "geometry": shape}
    (tmp_path / "far.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    notes = []
    scenario = of_maps(
        "elsewhere",
        zones=[tmp_path / "far.geojson"],
        ground=sky.AboveSea(1500),
        uavs=[(46.8, 9.85, sky.AboveGround(60))],
        targets=[(46.801, 9.85, sky.AboveGround(60)), (46.802, 9.85, sky.AboveGround(60))],
        on_note=notes.append,
    )
    assert [note.file for note in notes if "WARNING" in note.text] == [str(tmp_path / "far.geojson")]
    sky.write(scenario, tmp_path / "s.yaml")
    again = sky.read_scenario(tmp_path / "s.yaml")
    assert again.digest == scenario.digest
    found = kinds(sky.plan_mission(again))
    assert found["left out"].names == ("far.geojson",)
    assert "no UAV" not in found  # one UAV visits both targets


def test_a_mission_that_answers_another_scenario_has_the_cautions_of_that_one():
    mission = planned(50)
    other = mission.scenario.model_copy(update={"obstacles": (SHAPES[0],)})
    assert kinds(dataclasses.replace(mission, scenario=other)).keys() == {"flown over"}


def test_what_a_survey_asks_for_and_is_not_seen_is_told_of_a_flight_that_is_safe():
    house = sky.Box(min=(40, 40, 0), max=(60, 60, 20))
    uav = sky.UAV(start=(5, 5, 30), end="home")
    asked = sky.Survey([(20, 20), (80, 20), (80, 80), (20, 80)], "mavic-3e", gsd="1 cm", overlap=(40, 30), name="yard")
    high = sky.Survey([(20, 20), (80, 20), (80, 80), (20, 80)], "mavic-3e", height=30, overlap=(40, 30), name="yard")
    for survey, kept_from in ((asked, 0.0), (high, 25.0)):
        zone = sky.Cylinder(centre=(50, 50), radius=max(kept_from, 1.0), low=0, high=300, solid=False)
        mission = planned(obstacles=[house, zone], uavs=[uav], targets=0, assignment="tours", surveys=[survey])
        assert mission.violations == ()
        told = [caution for caution in mission_cautions(mission) if caution.kind == "not seen"]
        assert {one.names for one in told} == (set() if mission.seen else {("yard",)})
        assert mission.seen or mission.coverage[0].sentence in told[0].sentence
        assert mission.coverage[0].verdict.value in repr(mission)
        assert mission.seen is (kept_from == 0.0)
