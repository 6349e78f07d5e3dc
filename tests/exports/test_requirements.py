"""What a format cannot hold is refused before anything is judged or searched."""

import contextlib
import os

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin, Terrain
from skyverse.exports import routes

BARE = Origin(latitude=46.8, longitude=9.8, altitude=1500.0)
STRAIGHT = handmade.along([(-100, 0, 50), (100, 0, 50)], 40)


@pytest.fixture
def no_judge(monkeypatch):
    def judged(scenario, mission):
        raise AssertionError("judged before what cannot be exported was refused")

    monkeypatch.setattr("skyverse.exports.requirements.judged", judged)


def straight(home=None, terrain=None, wing=None, origin=BARE):
    made = handmade.mission([STRAIGHT], origin=origin, terrain=terrain, wing=wing)
    uavs = tuple(uav.model_copy(update={"home": home}) for uav in made.scenario.uavs)
    scenario = made.scenario.model_copy(update={"uavs": uavs})
    return sky.Mission(scenario, made.assignment, made.results, made.trajectories, (), made.provenance)


@pytest.mark.usefixtures("no_judge")
@pytest.mark.parametrize(
    ("name", "options", "mission"),
    [
        ("m.wpml.kmz", {}, {}),
        ("m.geojson", {}, {}),
        ("m.plan", {"altitude": "agl"}, {}),
        ("m.plan", {"altitude": "sea"}, {}),
        ("m.kml", {"altitude": "home"}, {}),
        ("m.wpml.kmz", {"autopilot": "px4"}, {"origin": BARE.model_copy(update={"geoid": 52})}),
        ("m.plan", {"autopilot": "dji"}, {}),
        *(("m.plan", {"radius": radius}, {}) for radius in (-1.0, 0.0, 1e6, float("nan"))),
        *(("m.plan", {"takeoff": height}, {}) for height in (-1.0, float("nan"))),
        ("m.gpx", {}, {"origin": None}),
        ("m.plan", {}, {"home": -400.0}),
        ("m.wpml.kmz", {"altitude": "home"}, {"wing": sky.FixedWing(speed=8.0, turn_radius=60.0, climb=10.0)}),
        ("m.litchi.csv", {"altitude": "home"}, {"wing": sky.FixedWing(speed=8.0, turn_radius=60.0, climb=10.0)}),
    ],
)
def test_it_is_refused_before_the_mission_is_judged(tmp_path, name, options, mission, refuses):
    with refuses():
        sky.export(straight(**mission), tmp_path / name, sky.ExportOptions(**options))
    assert not list(tmp_path.iterdir())


def test_a_home_may_be_as_low_as_the_lowest_ground_but_no_lower(refuses):
    low = handmade.LOW[2]
    assert routes(straight(home=low))
    with refuses():
        routes(straight(home=low - 1))
    heights = np.full((35, 35), low)
    ground = Terrain(origin=(-340, -340), step=(20, 20), heights=heights, lowest=heights - 5, clearance=1.0)
    assert routes(straight(home=low - 4, terrain=ground))
    with refuses():
        routes(straight(home=low - 6, terrain=ground))


@pytest.mark.usefixtures("unjudged")
@pytest.mark.parametrize(
    "broken", ["waypoint_files.cautions", "waypoint_files.details", "waypoint_files.flight_verdicts", "report.page"]
)
def test_files_appear_whole_or_not_at_all(tmp_path, monkeypatch, broken):
    def fails(*args, **kwargs):
        raise RuntimeError(broken)

    monkeypatch.setattr(f"skyverse.exports.{broken}", fails)
    with pytest.raises(RuntimeError, match=broken):
        sky.export(straight(), tmp_path / "m.plan", page=tmp_path / "m.html")
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("unjudged")
def test_where_one_of_the_files_cannot_be_written_none_is(tmp_path, refuses):
    (tmp_path / "m.params").mkdir()
    (tmp_path / "m.plan").write_text("old", encoding="utf-8")
    with refuses():
        sky.export(straight(), tmp_path / "m.plan")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.params", "m.plan"]
    assert (tmp_path / "m.plan").read_text(encoding="utf-8") == "old"


@pytest.mark.usefixtures("unjudged")
@pytest.mark.parametrize("renamed", [0, 1, 2, 3])
def test_whenever_it_is_killed_no_file_stands_beside_one_of_another_mission(tmp_path, monkeypatch, renamed):
    files, rename, done = [tmp_path / f"m.{ending}" for ending in ("plan", "params", "html")], os.replace, []
    for path in files:
        path.write_text("old", encoding="utf-8")

    def killed(beside, path):
        if len(done) == renamed:
            raise KeyboardInterrupt
        done.append(path)
        rename(beside, path)

    monkeypatch.setattr("os.replace", killed)
    with contextlib.suppress(KeyboardInterrupt):
        sky.export(straight(), files[0], page=files[2])
    left = [path.read_text(encoding="utf-8") for path in tmp_path.iterdir()]
    assert len(left) == renamed
    assert "old" not in left


def test_an_export_that_is_refused_leaves_no_folder_behind(tmp_path, monkeypatch, capsys):
    from skyverse.cli import main

    monkeypatch.chdir(tmp_path)
    sky.write(straight(), tmp_path / "m.json")
    with pytest.raises(SystemExit) as ended:
        main(["export", "m.json", "new/below/m.plan", "--radius=-1"])
    assert ended.value.code == 2
    assert capsys.readouterr().err == "skyverse: --radius: expected metres from 0.1 to 1000, found -1.0\n"
    assert [path.name for path in tmp_path.iterdir()] == ["m.json"]
