"""Scenario files: what is written reads back equal, and what cannot be read is refused in one line."""

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.files.builtin import _BUILTIN_FLEETS, BUILTIN_NAMES
from worlds import scenarios

GOOD = """\
name: yard
bounds: {min: [0, 0, 0], max: [4, 3, 2]}
obstacles:
  - {min: [1, 1, 0], max: [2, 2, 1]}
clearance: 0.25
lattice: {step: [0.5, 0.5, 0.5]}
uavs:
  - {start: [0, 0, 0]}
targets:
  - {position: [4, 3, 2]}
"""


def refused(path, *says):
    """Reading the file ends in one line that names the file and says this."""
    with pytest.raises(sky.InputError) as error:
        sky.read(path)
    message = str(error.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    for words in says:
        assert words in message, message


@pytest.mark.parametrize("name", BUILTIN_NAMES)
@pytest.mark.parametrize("suffix", [".yaml", ".yml", ".json", ".YAML"])
def test_every_built_in_scenario_survives_a_round_trip(name, suffix, tmp_path):
    scenario = sky.read(name)
    assert scenario.name == name
    sky.write(scenario, tmp_path / f"scenario{suffix}")
    assert sky.read(tmp_path / f"scenario{suffix}") == scenario
    assert sky.read_scenario(str(tmp_path / f"scenario{suffix}")) == scenario


NAMES_AND_WORDS = st.text(st.characters(codec="utf-8", exclude_characters="\x00"), min_size=1, max_size=20)


@given(
    scenarios(uavs=2, targets=2),
    NAMES_AND_WORDS,
    st.text(st.characters(codec="utf-8"), max_size=60),
    st.none()
    | st.builds(sky.Origin, latitude=st.floats(-90, 90), longitude=st.floats(-180, 180), altitude=st.floats(-1e3, 1e4)),
)
@settings(max_examples=60, suppress_health_check=[*HealthCheck])
def test_every_scenario_survives_a_round_trip(tmp_path, scenario, name, description, origin):
    scenario = sky.Scenario.model_validate(
        {**dict(scenario), "name": name, "description": description, "frame": sky.Frame(origin=origin)}
    )
    for suffix in (".yaml", ".json"):
        sky.write(scenario, tmp_path / f"s{suffix}")
        assert sky.read(tmp_path / f"s{suffix}") == scenario


@pytest.mark.parametrize("break_", ["\x85", "\u2028", "\u2029"])
def test_line_breaks_of_yaml_alone_survive_a_round_trip(tmp_path, break_):
    scenario = sky.read("map1").model_copy(update={"description": f"a{break_}é", "name": break_})
    sky.write(scenario, tmp_path / "s.yaml")
    assert sky.read(tmp_path / "s.yaml") == scenario


def test_a_file_by_hand_reads_as_it_says(tmp_path):
    path = tmp_path / "yard.yaml"
    path.write_text(GOOD + "objective: turns\n")
    scenario = sky.read(path)
    assert scenario.obstacles == (sky.Box(min=(1, 1, 0), max=(2, 2, 1)),)
    assert scenario.objective == sky.Objective(divergence=0.3, end=80)
    assert scenario.uavs[0].name == "uav-1"


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("clearance:", "clearence:", ["clearence: there is no such key; did you mean 'clearance'?"]),
        ("uavs:", "colour: red\nuavs:", ["colour", "there is no such key"]),
        ("name: yard", "name: yard\nclearence: 1", ["clearence", "no such key", "did you mean 'clearance'?"]),
        ("start: [0, 0, 0]", "start: [0, 0, 0], spead: 2", ["uavs[0].spead", "there is no such key"]),
        ("start: [0, 0, 0]", "start: [0, .nan, 0]", ["uavs[0].start[1]", "finite", "found nan"]),
        ("start: [0, 0, 0]", "start: [0, .inf, 0]", ["uavs[0].start[1]", "finite", "found inf"]),
        ("start: [0, 0, 0]", "start: [0, 0]", ["uavs[0].start", "missing"]),
        ("start: [0, 0, 0]", "start: here", ["uavs[0].start", "found 'here'"]),
        ("start: [0, 0, 0]", "begin: [0, 0, 0]", ["uavs[0]."]),
        ("max: [2, 2, 1]", "max: [2, 1, 1]", ["obstacles[0]", "y runs from 1 to 1"]),
        ("max: [4, 3, 2]", "max: [4, 3, -2]", ["bounds", "z runs from 0 to -2"]),
        ("0.25", "wide", ["clearance", "found 'wide'"]),
        ("0.25", "true", ["clearance", "found True"]),
        ("0.25", "-1", ["clearance", "expected 0 or more", "found -1"]),
        ("step: [0.5, 0.5, 0.5]", "step: [0.5, 9, 0.5]", ["lattice.step is 9 m along y", "3 m"]),
        ("step: [0.5, 0.5, 0.5]", "step: [0.5, 0.5, 0.5], connectivity: 8", ["lattice.connectivity", "found 8"]),
        ("name: yard", "name: yard\nobjective: cheap", ["objective", "'cheap'", "thesis, turns"]),
        ("name: yard", "name: yard\nformat: skyverse/scenario/9", ["format", "skyverse/scenario/2"]),
        ("name: yard\n", "", ["name", "is missing"]),
    ],
)
def test_a_field_that_is_wrong_is_named_with_what_was_found(old, new, says, tmp_path):
    assert old in GOOD
    path = tmp_path / "bad.yaml"
    path.write_text(GOOD.replace(old, new, 1))
    refused(path, *says)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("twice.yaml", GOOD + "clearance: 1\n", ["line", "duplicate key", "clearance"]),
        ("twice.json", '{"name": "a",\n "name": "b"}', ["'name': expected it once"]),
        ("deep.json", '{"name": "a", "bounds": {"min": 1, "min": 2}}', ["'min': expected it once"]),
        ("cut.json", '{"name": "a",\n "bounds"', ["line 2: expected JSON"]),
        ("empty.json", "", ["line 1: expected JSON"]),
        ("cut.yaml", GOOD[:40], ["line", "is not YAML"]),
        ("tabs.yaml", "name:\n\t- a", ["line 2", "is not YAML"]),
        ("empty.yaml", "", ["expected a scenario", "found None"]),
        ("list.yaml", "- 1\n- 2\n", ["expected a scenario", "found [1, 2]"]),
        ("list.json", "[1, 2]", ["expected a scenario", "found [1, 2]"]),
        ("word.yaml", "hello", ["expected a scenario", "found 'hello'"]),
        ("two.yaml", "name: a\n---\nname: b\n", ["document"]),
        ("nan.json", '{"name": "a", "clearance": NaN}', []),
        ("huge.json", '{"name": "a", "clearance": 1e999}', []),
        ("digits.json", '{"name": "a", "clearance": ' + "9" * 5000 + "}", []),
        ("deep-lists.json", "[" * 100_000, []),
        ("deep-lists.yaml", "[" * 2_000, []),
        ("alias.yaml", "a: &a [*a]", []),
        ("anchors.yaml", "name: *nobody", ["is not YAML"]),
        ("tag.yaml", "name: !!python/object/apply:os.system ['true']", []),
        ("numbers.yaml", "1: 2\n", []),
        ("null.yaml", "null: 2\n~: 3\n", []),
        ("surrogate.json", '{"name": "\\ud800"}', []),
        ("format.json", '{"format": 5}', []),
        ("format.yaml", "format: [skyverse/mission/1]\n", []),
    ],
)
def test_a_file_that_is_no_scenario_is_refused_in_one_line(name, content, says, tmp_path):
    (tmp_path / name).write_text(content)
    refused(tmp_path / name, *says)


@pytest.mark.parametrize("name", ["binary.yaml", "binary.json", "binary.txt"])
@pytest.mark.parametrize("content", [b"\xff\xfe\x00", bytes(range(256)), b"\x89PNG\r\n\x1a\n", b"name: \x00"])
def test_a_binary_file_is_refused_in_one_line(name, content, tmp_path):
    (tmp_path / name).write_bytes(content)
    refused(tmp_path / name)


@given(st.integers(0, len(GOOD)), st.sampled_from([".yaml", ".json", ".txt"]), st.binary(max_size=3))
@settings(max_examples=80, suppress_health_check=[*HealthCheck])
def test_a_file_cut_off_or_garbled_anywhere_reads_or_is_refused(tmp_path, at, suffix, garbage):
    text = GOOD
    if suffix == ".json":
        sky.write(sky.read("map2"), tmp_path / "whole.json")
        text = (tmp_path / "whole.json").read_text()
        at *= len(text) // len(GOOD)
    path = tmp_path / f"cut{suffix}"
    path.write_bytes(text.encode()[:at] + garbage)
    try:
        message = None if isinstance(sky.read(path), sky.Scenario) else "something else"
    except sky.InputError as error:
        message = str(error)
    assert message is None or (message.startswith(str(path)) and "\n" not in message)


def test_what_is_not_there_is_refused_with_the_names_that_are(tmp_path):
    refused(tmp_path / "none.yaml", "no such file", "map1, map2, map3, table-4.8")
    refused("mapp1", "no such file, nor a built-in scenario")


def test_a_folder_and_an_unknown_ending_are_refused(tmp_path):
    (tmp_path / "dir.yaml").mkdir()
    refused(tmp_path / "dir.yaml", "expected a file, found a folder")
    for name, found in [("map.xml", "'.xml'"), ("map", "'no ending'")]:
        (tmp_path / name).write_text(GOOD)
        refused(tmp_path / name, ".yaml, .yml, .json, .txt", found)


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_an_unwritable_output_leaves_nothing_behind(suffix, tmp_path, monkeypatch, refuses):
    scenario = sky.read("map1")
    with refuses():
        sky.write(scenario, tmp_path / "nowhere" / f"a{suffix}")
    (tmp_path / f"dir{suffix}").mkdir()
    with refuses():
        sky.write(scenario, tmp_path / f"dir{suffix}")
    assert [p.name for p in tmp_path.iterdir()] == [f"dir{suffix}"]
    old = tmp_path / f"old{suffix}"
    old.write_text("precious")

    def full(self, text, **how):
        with self.open("w") as file:
            file.write(text[: len(text) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with refuses():
        sky.write(scenario, old)
    assert old.read_text() == "precious"
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"dir{suffix}", f"old{suffix}"]


@pytest.mark.parametrize("name", ["map1.txt", "map1", "map1.csv"])
def test_a_scenario_is_written_as_yaml_or_json_only(name, tmp_path, refuses):
    with refuses():
        sky.write(sky.read("map1"), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_written_json_is_json_for_others_too(tmp_path):
    sky.write(sky.read("table-4.8"), tmp_path / "a.json")
    data = json.loads((tmp_path / "a.json").read_text())
    assert data["uavs"][0]["start"] == [5, -4.9, 3]
    assert data["lattice"]["step"] == [0.1, 0.1, 0.5]


def test_type_checkers_know_all_built_in_scenarios():
    assert set(BUILTIN_NAMES) == {*_BUILTIN_FLEETS, "jacksboro"}
