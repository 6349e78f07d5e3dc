"""Scenario files name recorded tracks, which are read with them; missions hold the motions themselves."""

import json

import jsonschema
import pytest

import skyverse as sky
from skyverse.documents.yaml import load_yaml

BALL = "{shape: sphere, centre: [0, 0, 0], radius: 0.3}"
TRACK = "t,x,y,z,error\n0,2,-2,2,0.1\n6,2,6,2,0.25\n"


def scenario_file(folder, motion, more="", origin=False):
    scenario = sky.read("map3")
    if origin:
        scenario = scenario.model_copy(
            update={"frame": sky.Frame(origin=sky.Origin(latitude=46.8, longitude=9.85, altitude=1500.0))}
        )
    file = folder / "moving.yaml"
    sky.write(scenario, file)
    text = file.read_text().replace("movers: []\n", "")
    file.write_text(f"{text}movers:\n- {{name: drone, shape: {BALL}, motion: {motion}{more}}}\n")
    return file


def test_a_track_is_read_with_its_error_and_stays_in_the_mission(tmp_path):
    (tmp_path / "drone.csv").write_text(TRACK)
    scenario = sky.read(scenario_file(tmp_path, "{track: drone.csv}"))
    (mover,) = scenario.movers
    assert mover.motion == sky.WaypointMotion(points=[(2, -2, 2), (2, 6, 2)], times=[0, 6])
    assert mover.doubt == sky.Doubt(radius=0.25)
    mission = sky.plan_mission(scenario)
    assert mission.violations == ()
    sky.write(mission, tmp_path / "mission.json")
    (tmp_path / "drone.csv").unlink()
    again = sky.read_mission(tmp_path / "mission.json")
    assert again.scenario == scenario
    assert sky.check(again.scenario, again) == []


def test_a_doubt_of_the_movers_own_takes_the_place_of_the_tracks(tmp_path):
    (tmp_path / "drone.csv").write_text(TRACK)
    (mover,) = sky.read(scenario_file(tmp_path, "{track: drone.csv}", ", doubt: {growth: 0.01}")).movers
    assert mover.doubt == sky.Doubt(growth=0.01)


def test_the_schema_knows_tracks(tmp_path):
    data = load_yaml(scenario_file(tmp_path, "{track: drone.csv, altitude: amsl, gap: 100.0}").read_text())
    schema = sky.scenario_schema()
    jsonschema.validate(json.loads(json.dumps(data)), schema)
    data["movers"][0]["motion"]["altitude"] = "sea"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(json.loads(json.dumps(data)), schema)


@pytest.mark.parametrize(
    ("motion", "said"),
    [
        ("{track: other.csv}", r"movers\[0\].motion.track: .*other.csv: no such file"),
        ("{track: drone.csv, speed: 3}", r"movers\[0\].motion: speed: there is no such key"),
        ("{motion: track}", r"movers\[0\].motion: track: is missing"),
        ("{track: drone.csv, altitude: sea}", r"movers\[0\].motion: altitude: .*'amsl' or 'ellipsoid'"),
        (
            "{track: drone.csv, gap: 2}",
            r"movers\[0\].motion.track: .*drone.csv: line 3: time: 6 s have passed since line 2",
        ),
        (
            "{track: globe.csv}",
            r"movers\[0\].motion.track: .*globe.csv: altitude: expected word what it is counted from",
        ),
    ],
)
def test_what_is_wrong_names_both_files_and_the_field(tmp_path, motion, said, refuses):
    (tmp_path / "drone.csv").write_text(TRACK)
    (tmp_path / "globe.csv").write_text("t,lat,lon,altitude\n0,46.8,9.85,1600\n")
    with refuses() as error:
        sky.read(scenario_file(tmp_path, motion, origin=True))
    assert "\n" not in str(error.value)
