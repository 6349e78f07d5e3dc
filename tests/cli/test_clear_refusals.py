"""What a user gives by mistake is refused, or told of, in one sentence that helps."""

import json

import pytest

import skyverse as sky


@pytest.mark.parametrize("words", [("check",), ("fly",), ("export", "m.plan")])
def test_a_missing_mission_is_no_scenario(skyverse, words):
    verb, *more = words
    assert skyverse(verb, "missing.json", *more) == (2, "", "skyverse: missing.json: no such file\n")


def test_a_misspelt_name_is_answered_with_the_nearest_ones(skyverse, tmp_path):
    (tmp_path / "mine.yaml").write_text("")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "map1.json").write_text("")
    for words, sentence in {
        ("plan", "mine.yam"): "mine.yam: no such file, nor a built-in scenario; did you mean 'mine.yaml'?",
        ("show", "jaksboro"): "jaksboro: no such file, nor a built-in scenario; did you mean 'jacksboro'?",
        ("plan", "Table4.8"): "Table4.8: no such file, nor a built-in scenario; did you mean 'table-4.8' or ",
        ("check", "out/map1.jsn"): "out/map1.jsn: no such file; did you mean 'map1.json'?",
        ("check", "out/mission.json"): "out/mission.json: no such file\n",
    }.items():
        code, _, said = skyverse(*words)
        assert code == 2
        assert said.startswith(f"skyverse: {sentence}")


def test_a_second_scenario_is_refused_with_what_is_expected(skyverse):
    code, _, said = skyverse("plan", "map1", "map2")
    assert code == 2
    assert said == (
        "skyverse: plan: expected SCENARIO alone, found 'map2' too; "
        "several values of an option stand each after its name, as in --uav A --uav B\n"
    )


def test_a_built_in_scenario_is_no_mission(skyverse):
    code, _, said = skyverse("check", "map1")
    assert code == 2
    assert "map1: expected a mission" in said


@pytest.mark.parametrize("text", ["-5 m agl", "0 m agl"])
def test_a_ceiling_below_the_ground_is_refused(skyverse, tmp_path, text):
    refused = f"skyverse: --max-height: expected a height above ground, as in '120 m agl', found '{text}'\n"
    built = skyverse("scenario", "build", "--area", "9.8,46.8,9.81,46.81", "--max-height", text, "-o", "m.yaml")
    assert built == (2, "", refused)
    assert skyverse("plan", "jacksboro", "--max-height", text) == (2, "", refused)
    assert not list(tmp_path.iterdir())


def test_json_is_no_terrain(skyverse, tmp_path):
    (tmp_path / "m.json").write_text(json.dumps({"format": "skyverse-mission"}))
    code, _, said = skyverse("scenario", "build", "--terrain", "m.json", "-o", "m.yaml")
    assert (code, said) == (
        2,
        "skyverse: m.json: expected a raster of heights, such as a GeoTIFF, found a JSON file\n",
    )


def test_targets_without_uavs_are_warned_of(skyverse, tmp_path):
    words = ["scenario", "build", "--ground", "0 m amsl", "--target", "46.8,9.8,60 m agl", "-o", "m.yaml"]
    warning = (
        "WARNING: 1 target for no UAVs, each of which flies to one at most; give --uav latitude,longitude,altitude"
    )
    code, out, _ = skyverse(*words)
    assert code == 0
    assert warning in [line.strip() for line in out.splitlines()]
    assert not sky.read(tmp_path / "m.yaml").uavs
    code, out, _ = skyverse(*words, "--uav", "46.801,9.801,60 m agl")
    assert code == 0
    assert "WARNING" not in out


def test_a_verb_of_a_verb_is_told_where_only_its_end_is_given(skyverse):
    said = "skyverse: expected a verb, found 'build'; did you mean 'scenario build'?\n"
    assert skyverse("build", "-o", "x.yaml") == (2, "", said)
    assert "Did you mean" in skyverse("plna", "map1")[2]
