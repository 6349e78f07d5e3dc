"""What a user gives by mistake is refused, or told of, in one sentence that helps."""

import json

import pytest

import skyverse as sky


@pytest.mark.parametrize(
    "words",
    [
        "check missing.json",
        "fly missing.json",
        "export missing.json m.plan",
        "plan mine.yam",
        "show jaksboro",
        "plan Table4.8",
        "check out/map1.jsn",
        "plan map1 map2",
        "scenario build --terrain out/map1.json -o m.yaml",
        "build -o x.yaml",
    ],
)
def test_what_is_missing_misspelt_or_no_such_thing_is_refused_with_what_is_near(refused, tmp_path, words):
    (tmp_path / "mine.yaml").write_text("")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "map1.json").write_text(json.dumps({"format": "skyverse-mission"}))
    refused(*words.split())


@pytest.mark.parametrize("sign", ["\x1b[31m", "\x9b31m", "\x07", "\r", "\x7f"])
def test_control_characters_of_names_never_reach_a_terminal(refused, tmp_path, sign):
    name = f"a{sign}b.yaml"
    (tmp_path / name).write_text("")
    for words in (("plan", name), ("plan", "map1", "-o", name), ("check", name), (name,)):
        refused(*words)


@pytest.mark.parametrize("text", ["-5 m agl", "0 m agl"])
def test_a_ceiling_below_the_ground_is_refused(refused, tmp_path, text):
    refused("scenario", "build", "--area", "9.8,46.8,9.81,46.81", "--max-height", text, "-o", "m.yaml")
    refused("plan", "jacksboro", "--max-height", text)
    assert not list(tmp_path.iterdir())


def test_targets_without_uavs_are_warned_of(skyverse, tmp_path):
    words = ["scenario", "build", "--ground", "0 m amsl", "--target", "46.8,9.8,60 m agl", "-o", "m.yaml"]
    warning = "WARNING: 1 target, and no UAV that flies there; give --uav latitude,longitude,altitude"
    code, out, _ = skyverse(*words)
    assert code == 0
    assert warning in [line.strip() for line in out.splitlines()]
    assert not sky.read(tmp_path / "m.yaml").uavs
    code, out, _ = skyverse(*words, "--target", "46.801,9.8,60 m agl", "--uav", "46.801,9.801,60 m agl")
    assert code == 0
    assert "WARNING" not in out
