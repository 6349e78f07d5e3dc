"""What a format cannot hold is refused before anything is judged or searched."""

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse.exports.routes import routes
from skyverse.model.frame import Origin
from skyverse.model.shapes import Terrain
from skyverse.model.uav import FixedWing

BARE = Origin(latitude=46.8, longitude=9.8, altitude=1500.0)
STRAIGHT = handmade.along([(-100, 0, 50), (100, 0, 50)], 40)


@pytest.fixture
def no_judge(monkeypatch):
    def judged(scenario, mission):
        raise AssertionError("judged before what cannot be exported was refused")

    monkeypatch.setattr("skyverse.exports.requirements.judge", judged)


def straight(home=None, terrain=None, wing=None, origin=BARE):
    made = handmade.mission([STRAIGHT], origin=origin, terrain=terrain, wing=wing)
    uavs = tuple(uav.model_copy(update={"home": home}) for uav in made.scenario.uavs)
    scenario = made.scenario.model_copy(update={"uavs": uavs})
    return sky.Mission(scenario, made.assignment, made.results, made.trajectories, (), made.provenance)


@pytest.mark.usefixtures("no_judge")
@pytest.mark.parametrize(
    ("name", "options", "mission", "sentence"),
    [
        ("m.wpml.kmz", {}, {}, "DJI's waylines, above the sea: its heights are above the WGS84 ellipsoid"),
        ("m.geojson", {}, {}, "its heights are above the WGS84 ellipsoid"),
        ("m.plan", {"altitude": "agl"}, {}, "altitudes above ground .* need a terrain"),
        (
            "m.wpml.kmz",
            {"autopilot": "px4"},
            {"origin": BARE.model_copy(update={"geoid": 52})},
            "from dji, found 'px4'",
        ),
        ("m.plan", {"radius": -1.0}, {}, "radius: expected metres from 0.1 to 1000, found -1.0"),
        ("m.plan", {"takeoff": float("nan")}, {}, "takeoff: expected metres from 0 on, found nan"),
        ("m.kml", {"altitude": "home"}, {}, "expected altitudes as amsl or agl, found 'home'"),
        ("m.gpx", {}, {"origin": None}, "expected a scenario that says where its zero lies"),
        ("m.plan", {}, {"home": -400.0}, r"uavs\[0\].home \(uav-1\): expected the ground below the start"),
        (
            "m.wpml.kmz",
            {"altitude": "home"},
            {"wing": FixedWing(speed=8.0, turn_radius=60.0, climb=10.0)},
            "uav-1: DJI's waylines are for multirotors",
        ),
    ],
)
def test_it_is_refused_before_the_mission_is_judged(tmp_path, name, options, mission, sentence):
    with pytest.raises(sky.InputError, match=sentence):
        sky.export(straight(**mission), tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_a_home_may_be_as_low_as_the_lowest_ground_but_no_lower():
    low = handmade.LOW[2]
    assert routes(straight(home=low))
    with pytest.raises(sky.InputError, match=r"at z = .* m or higher, found .*, which is below the bounds"):
        routes(straight(home=low - 1))
    heights = np.full((35, 35), low)
    ground = Terrain(origin=(-340, -340), step=(20, 20), heights=heights, lowest=heights - 5, clearance=1.0)
    assert routes(straight(home=low - 4, terrain=ground))
    with pytest.raises(sky.InputError, match="which is below the lowest ground there"):
        routes(straight(home=low - 6, terrain=ground))


def test_an_export_that_is_refused_leaves_no_folder_behind(tmp_path, monkeypatch, capsys):
    from skyverse.cli import main

    monkeypatch.chdir(tmp_path)
    sky.write(straight(), tmp_path / "m.json")
    with pytest.raises(SystemExit) as ended:
        main(["export", "m.json", "new/below/m.plan", "--radius=-1"])
    assert ended.value.code == 2
    assert capsys.readouterr().err == "skyverse: --radius: expected metres from 0.1 to 1000, found -1.0\n"
    assert [path.name for path in tmp_path.iterdir()] == ["m.json"]
