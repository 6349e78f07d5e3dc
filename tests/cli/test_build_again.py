"""A scenario keeps the options that it was built with, so that building it again asks for what is changed alone."""

import json
from pathlib import Path

import pytest

pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
pytest.importorskip("shapely", reason="building scenarios needs shapely")

import skyverse as sky
from of_maps import of_maps
from skyverse.model.altitude import AboveGround, AboveSea

START, GOAL, OTHER = "46.8,9.85,60 m agl", "46.803,9.85,60 m agl", "46.803,9.853,70 m agl"


@pytest.fixture
def zones(tmp_path):
    ring = [[9.849, 46.801], [9.851, 46.801], [9.851, 46.802], [9.849, 46.801]]
    feature = {
        "type": "Feature",
        "properties": {"upper": "80 m agl"},
        "geometry": {"type": "Polygon", "coordinates": [ring]},
    }
    (tmp_path / "maps").mkdir()
    path = tmp_path / "maps/z=1.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    return path


def test_what_is_not_changed_is_as_it_was_from_any_folder(skyverse, zones, tmp_path):
    words = ["--ground", "1500 m amsl", "--uav", f"a={START}", "--target", GOAL, "--ceiling", "120 m agl"]
    words += ["--max-speed", 7, "--zones-closed-above", "--margin", 300, "--soft-zones", f"{zones}=0.5"]
    code, _, err = skyverse("scenario", "build", "--zones", "maps/z=1.geojson", *words, "-o", "maps/first.yaml")
    assert code == 0, err
    code, _, err = skyverse("scenario", "build", "--from", "maps/first.yaml", "--target", OTHER, "-o", "second.yaml")
    assert code == 0, err
    first, second = sky.read_scenario("maps/first.yaml"), sky.read_scenario("second.yaml")
    options = {
        "zones": [zones],
        "soft_zones": [(zones, 0.5)],
        "ground": AboveSea(1500),
        "uavs": {"a": (46.8, 9.85, AboveGround(60))},
        "max_speed": 7.0,
        "ceiling": AboveGround(120),
        "zones_closed_above": True,
        "margin": 300.0,
    }
    for made, target in ((first, (46.803, 9.85, AboveGround(60))), (second, (46.803, 9.853, AboveGround(70)))):
        direct = of_maps(made.name, targets=[target], **options)
        assert made.model_copy(update={"built_with": ()}) == direct
    assert {name: rest for name, *rest in second.built_with}["zones"] == [str(zones)]
    assert "maps/z=1.geojson=0.5" in Path("second.yaml").read_text()
    code, _, err = skyverse("scenario", "build", "--from", "second.yaml", "-o", "maps/third.yaml")
    assert code == 0, err
    assert sky.read_scenario("maps/third.yaml").targets == second.targets


@pytest.mark.parametrize("name", ["other/copy.yaml", "other/deep/copy.json", "other/mission.json"])
def test_its_files_are_found_again_wherever_it_was_written(skyverse, zones, tmp_path, monkeypatch, name):
    words = ["--ground", "1500 m amsl", "--uav", START, "--target", GOAL, "--ceiling", "120 m agl"]
    words += ["--zones", "maps/z=1.geojson", "--soft-zones", "maps/z=1.geojson=0.5"]
    code, _, err = skyverse("scenario", "build", *words, "-o", "first.yaml")
    assert code == 0, err
    first = sky.read_scenario("first.yaml")
    Path(name).parent.mkdir(parents=True)
    if "mission" in name:
        assert skyverse("plan", "first.yaml", "-o", name)[0] == 0
    else:
        sky.write(first, name)
    assert "maps/z=1.geojson" in Path(name).read_text()
    assert str(tmp_path) not in Path(name).read_text()  # a folder with all of it may be moved
    assert sky.read_scenario(name) == first
    (tmp_path / "moved").mkdir()
    for part in ("maps", "other"):
        (tmp_path / part).rename(tmp_path / "moved" / part)
    monkeypatch.chdir(tmp_path / "moved" / "maps")
    code, _, err = skyverse("scenario", "build", "--from", f"../{name}", "-o", "again.yaml")
    assert code == 0, err
    again = sky.read_scenario("again.yaml")
    assert again.model_copy(update={"name": "first", "built_with": first.built_with}) == first
    assert sky.read_scenario(f"../{name}").digest == first.digest


def test_a_scenario_that_was_not_built_and_options_that_cannot_be_are_refused(skyverse):
    code, _, err = skyverse("scenario", "build", "--from", "map1", "-o", "x.yaml")
    assert (code, "expected a scenario of skyverse scenario build, found no options in it" in err) == (2, True)
    for words, said in (("nonsense", "1"), "found 'nonsense'"), (("max_speed", "fast"), "max_speed: found ['fast']"):
        sky.write(sky.read("map1").model_copy(update={"built_with": (words,)}), "odd.yaml")
        code, _, err = skyverse("scenario", "build", "--from", "odd.yaml", "-o", "x.yaml")
        assert (code, said in err) == (2, True), err


def test_a_scenario_in_an_older_frame_is_refused_and_built_anew(skyverse, zones):
    words = ["--ground", "1500 m amsl", "--uav", START, "--target", GOAL, "--zones", "maps/z=1.geojson"]
    assert skyverse("scenario", "build", *words, "-o", "new.yaml")[0] == 0
    Path("old.yaml").write_text(Path("new.yaml").read_text().replace("axes: map", "axes: enu"))
    Path("unsaid.yaml").write_text(Path("new.yaml").read_text().replace("  axes: map\n", ""))
    code, _, err = skyverse("plan", "unsaid.yaml")
    assert (code, "unsaid.yaml: frame: axes: expected 'map' beside an origin, but it is missing" in err) == (2, True), (
        err
    )
    code, _, err = skyverse("plan", "old.yaml")
    assert (code, "build the scenario anew, with the options in its built_with" in err) == (2, True), err
    code, _, err = skyverse("scenario", "build", "--from", "old.yaml", "--name", "new", "-o", "again.yaml")
    assert code == 0, err
    assert sky.read_scenario("again.yaml").digest == sky.read_scenario("new.yaml").digest


def test_a_fence_is_among_the_files_of_a_scenario(skyverse, tmp_path):
    ring = [[9.84, 46.79], [9.86, 46.79], [9.86, 46.81], [9.84, 46.81], [9.84, 46.79]]
    (tmp_path / "maps").mkdir()
    Path("maps/area.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
    words = ["--ground", "1500 m amsl", "--fence", "maps/area.geojson", "--margin", 10]
    code, out, err = skyverse("scenario", "build", *words, "-o", "first.yaml")
    assert (code, "area.geojson: fence" in out) == (0, True), err
    code, _, err = skyverse("scenario", "build", "--from", "first.yaml", "-o", "maps/again.yaml")
    assert code == 0, err
    first, again = sky.read_scenario("first.yaml"), sky.read_scenario("maps/again.yaml")
    assert [one.kind for one in first.obstacles] == ["fence"]
    assert first.obstacles == again.obstacles
    code, _, err = skyverse("scenario", "build", *words, "-o", "maps/area.geojson")
    assert code == 2
    assert Path("maps/area.geojson").read_text().startswith("{")
