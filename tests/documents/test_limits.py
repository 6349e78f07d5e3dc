"""Documents that would fill the memory: refused in one short sentence, before anything is built of them."""

import json
import time

import pytest

import skyverse as sky
from skyverse.documents import limits
from skyverse.documents.json import load_json
from skyverse.documents.limits import MAX_DEPTH, MAX_REPEATED, LimitError
from skyverse.documents.yaml import LONG_LIST, load_yaml
from skyverse.maps.georeference.reading import Choices
from skyverse.maps.readers import read_features

SCENARIO = """name: x
bounds: {min: [0, 0, 0], max: [9, 9, 9]}
clearance: 0.1
lattice: {step: [1, 1, 1]}
uavs: [{start: [1, 1, 5]}]
targets: [{position: [8, 8, 5]}]
"""


def refusal(path, read=sky.read):
    """Return the sentence by which a file is refused, which must be short and quick."""
    begun = time.process_time()
    with pytest.raises(sky.InputError) as refused:
        read(path)
    assert time.process_time() - begun < 60  # what is not bounded takes hours
    said = str(refused.value)
    assert said.startswith(str(path))
    assert len(said) < len(str(path)) + 300
    assert said.isprintable()
    return said


def written(folder, name, text):
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def bomb(levels):
    """Return YAML in which ten aliases of each level stand in the next one: ten to the power of levels values."""
    text = "&a0 [1,1,1,1,1,1,1,1,1,1]"
    for level in range(1, levels + 1):
        text = f"&a{level} [{text}{f',*a{level - 1}' * 9}]"
    return text


@pytest.mark.parametrize(
    "field",
    [
        f"description: {bomb(11)}",
        f"terrain: {{origin: [0, 0], step: [1, 1], heights: {bomb(8)}}}",
        f"obstacles: [{{shape: voxels, origin: [0, 0, 0], step: [1, 1, 1], occupied: {bomb(8)}}}]",
        f"sources: {bomb(20)}",
        f"{bomb(20)}: 1",
        f"objective: {bomb(20)}",
        f"format: {bomb(20)}",
        f"frame: {{<<: [{{axes: {bomb(9)}}}, {{axes: *a9}}]}}",
    ],
)
def test_aliases_cannot_multiply_what_a_document_holds(tmp_path, field):
    said = refusal(written(tmp_path, "a.yaml", f"{SCENARIO}{field}\n"))
    assert f"line 7: expected aliases that repeat at most {MAX_REPEATED:,} values, found more" in said


def test_aliases_in_the_lines_of_a_long_list_are_counted_together(tmp_path):
    line = f"- {{shape: box, min: {bomb(3)}, max: [1, 1, 1]}}\n"
    said = refusal(written(tmp_path, "a.yaml", f"{SCENARIO}obstacles:\n{line * 10 * LONG_LIST}"))
    assert "expected aliases that repeat at most" in said


def test_an_alias_of_what_it_stands_in_is_refused(tmp_path):
    for text in ("description: &a [*a]", "description: &a {b: [1, *a]}"):
        assert "expected an alias of what stands before it" in refusal(written(tmp_path, "a.yaml", SCENARIO + text))


def test_fair_aliases_are_read(tmp_path):
    text = "&limits {max_speed: 2.0}"
    assert load_yaml(f"a: {text}\nb: [*limits, *limits]\nc: {{<<: *limits, d: 1}}\n") == {
        "a": {"max_speed": 2.0},
        "b": [{"max_speed": 2.0}] * 2,
        "c": {"max_speed": 2.0, "d": 1},
    }
    assert load_yaml("- &a 1\n- *a\n- &a 2\n- *a\n") == [1, 1, 2, 2]
    assert len(load_yaml(f"[&a {[0] * 1000}, {', '.join(['*a'] * 99)}]")) == 100


DEEP = 100_000


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.yaml", f"{SCENARIO}description: {'[' * DEEP}"),
        ("a.yaml", f"{SCENARIO}description: {'{a: ' * DEEP}"),
        ("a.yaml", f"{SCENARIO}description:\n {'- ' * DEEP}1\n"),
        ("a.yaml", f"{SCENARIO}obstacles:\n" + f'  - {{"min": {"[" * 200}{"]" * 200}}}\n' * LONG_LIST),
        ("a.json", "[" * DEEP),
        ("a.json", '{"a": ' * DEEP + "1" + "}" * DEEP),
        ("a.json", '{"scenario": ' + "[" * DEEP + "]" * DEEP + "}"),
    ],
)
def test_documents_nested_too_deeply_are_refused(tmp_path, name, text):
    said = refusal(written(tmp_path, name, text))
    assert f"expected its parts nested at most {MAX_DEPTH} deep" in said


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.geojson", '{"type": "FeatureCollection", "features": ' + "[" * DEEP + "]" * DEEP + "}"),
        ("a.geojson", '{"type": "GeometryCollection", "geometries": [' * DEEP),
        ("a.json", '{"type": "CityJSON", "version": "2.0", "vertices": ' + "[" * DEEP),
        ("a.kml", "<kml>" + "<Folder>" * DEEP),
        ("a.osm", "<osm>" + "<way id='1'>" * DEEP),
    ],
)
def test_maps_nested_too_deeply_are_refused(tmp_path, name, text):
    said = refusal(written(tmp_path, name, text), read_features)
    assert f"expected its parts nested at most {MAX_DEPTH} deep" in said


def test_brackets_within_texts_do_not_count():
    text = json.dumps({"a" + "[{" * 200: '"]\\' + "[" * 1000, "b": "," * 1000})
    assert load_json(text) == json.loads(text)
    nested = "[" * MAX_DEPTH + "]" * MAX_DEPTH
    assert load_json(nested) == json.loads(nested)
    with pytest.raises(LimitError):
        load_json(f"[{nested}]")


def test_documents_of_too_many_values_or_bytes_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(limits, "MAX_VALUES", 1000)
    zones = '{"type": "FeatureCollection", "features": [' + "1," * 1000 + "1]}"
    for name, text, read in (
        ("a.yaml", f"{SCENARIO}description: {[1] * 1000}", sky.read),
        ("a.json", f'{{"name": {[1] * 1000}}}', sky.read),
        ("a.geojson", zones, read_features),
        ("a.kml", "<kml>" + "<name/>" * 1001 + "</kml>", read_features),
    ):
        assert "expected at most 1,000 values" in refusal(written(tmp_path, name, text), read)
    monkeypatch.setattr(limits, "MAX_BYTES", 1000)
    for name, text, read in (
        ("a.yaml", "#" * 1001, sky.read),
        ("a.json", " " * 1001, sky.read),
        ("a.txt", " " * 1001, sky.read),
        ("a.geojson", " " * 1001, read_features),
    ):
        assert "expected at most 1,000 bytes, found 1,001" in refusal(written(tmp_path, name, text), read)


def test_a_terrain_of_a_million_heights_is_read(tmp_path):
    data = load_yaml(SCENARIO) | {
        "terrain": {"origin": [0, 0], "step": [0.01, 0.01], "heights": [[0.0] * 1000 for _ in range(1000)]}
    }
    assert sky.read(written(tmp_path, "a.json", json.dumps(data))).terrain.heights.shape == (1000, 1000)


LONG = "1" * 5000
ZONE = (
    '{"type": "Feature", "properties": {"upper": %s}, "geometry": {"type": "Polygon", "coordinates": '
    "[[[8, 47], [8.1, 47], [8.1, 47.1], [8, 47]]]}}"
)


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        (
            "a.yaml",
            SCENARIO.replace("0.1", LONG),
            "line 3: expected numbers of at most 250 digits, found one of 5,000",
        ),
        ("a.yaml", SCENARIO.replace("0.1", f"0x{LONG}"), "line 3: expected numbers of at most 250 digits"),
        ("a.yaml", SCENARIO.replace("0.1", f"{LONG}.5"), "clearance: expected a finite number"),
        ("a.yaml", SCENARIO.replace("0.1", LONG[:251]), "line 3: expected numbers of at most 250 digits"),
        ("a.json", json.dumps(load_yaml(SCENARIO)).replace("0.1", LONG), "expected numbers of at most 250 digits"),
        ("a.json", f'{{\n"format": {LONG[:251]}}}', "line 2: expected numbers of at most 250 digits, found one of 251"),
        ("a.txt", f"boundary 0 0 0 1 1 {LONG}", "line 1: "),
    ],
)
def test_numbers_of_thousands_of_digits_are_not_printed(tmp_path, name, text, expected):
    assert expected in refusal(written(tmp_path, name, text))


@pytest.mark.parametrize("digits", [251, 309, 1000, 5000])
def test_whole_numbers_beyond_those_of_a_float_are_refused_in_every_document(tmp_path, digits):
    number = "9" * digits
    item = f'{{"type": "SimpleItem", "command": 16, "frame": 3, "params": [0, 0, 0, null, 47.0, 8.0, {number}]}}'
    mission = f'{{"fileType": "Plan", "mission": {{"items": [{item}]}}}}'
    refusal(written(tmp_path, "a.plan", mission), sky.read_waypoints)
    refusal(written(tmp_path, "a.geojson", ZONE % number), read_zones)
    refusal(written(tmp_path, "a.json", json.dumps(load_yaml(SCENARIO)).replace("0.1", number)))
    refusal(written(tmp_path, "a.yaml", SCENARIO.replace("0.1", number)))


def test_whole_numbers_beyond_those_of_a_float_are_refused_in_python():
    with pytest.raises(sky.InputError, match="clearance"):
        sky.Scenario(**load_yaml(SCENARIO) | {"clearance": 10**400})
    with pytest.raises(sky.InputError, match="image"):
        sky.Camera(sensor=(13.2, 8.8), image=(10**400, 3648), focal=8.8, min_interval=1.0)


def test_zones_with_numbers_of_thousands_of_digits_are_refused(tmp_path):
    for number in (LONG, LONG[:4000], f'"{LONG}"', f'"{LONG} m agl"'):
        refusal(written(tmp_path, "a.geojson", ZONE % number), read_zones)


def read_zones(path):
    return read_features(path, Choices(altitudes="agl"))


@pytest.mark.parametrize(
    "text",
    [
        f"{'k' * 10**5}: 1\n",
        f"? {['k'] * 10**4}\n: 1\n",
        f"objective: {'k' * 10**5}\n",
        f"uavs: [{{name: {'k' * 10**5}, start: [1, 1, 5]}}, {{name: {'k' * 10**5}, start: [1, 1, 5]}}]\n",
        f"frame: {{axes: {'k' * 10**5}}}\n",
        f"frame: {{axes: {{{'k' * 10**5}: 1}}}}\n",
        f"format: {'k' * 10**5}\n",
        f"sources: {[1] * 10**4}\n",
        f"a: 1\na: {'k' * 10**5}\n",
        f"description: &{'k' * 1000} 1\nname: *{'j' * 10**5}\n",
        f"obstacles: [{{shape: {'k' * 10**5}}}]\n",
        f"description: !{'k' * 10**5} 1\n",
        f"description: {'k' * 10**5}: 1\n",
    ],
)
def test_no_refusal_prints_a_value_at_length(tmp_path, text):
    data = "".join(line for line in SCENARIO.splitlines(True) if line.split(":")[0] != text.split(":")[0])
    refusal(written(tmp_path, "a.yaml", data + text))


def test_entities_of_xml_are_not_expanded(tmp_path):
    entities = "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10))
    text = f'<!DOCTYPE kml [<!ENTITY a0 "x">{entities}]><kml>&a9;</kml>'
    assert "document type declaration" in refusal(written(tmp_path, "a.kml", text), read_features)


@pytest.mark.parametrize(
    "value", ['!!int "x"', '!!float "x"', '!!bool "x"', '!!timestamp "x"', '!!binary "é"', "!!set [1]", "!!omap {a: 1}",
              "!!pairs 1", "!!null [1]", "!!python/object:os.system 1", "!<x> 1", "2001-99-99", "1:99:99"]
)  # fmt: skip
def test_values_that_are_not_what_their_tag_says_are_refused(tmp_path, value):
    refusal(written(tmp_path, "a.yaml", SCENARIO.replace("0.1", value)))


def test_endless_blanks_and_digits_are_refused_at_once(tmp_path):
    for text in (" " * 10**5 + "x", "1" * 10**5 + "x", "1" + " " * 10**5 + "x", "1." + "1" * 10**5 + "x"):
        refusal(written(tmp_path, "a.geojson", ZONE % f'"{text}"'), read_zones)
        circle = (ZONE % 100).replace('"properties": {', f'"properties": {{"radius": "{text}", ')
        refusal(written(tmp_path, "a.geojson", circle), read_zones)
        building = (ZONE % 100).replace('"properties": {', f'"properties": {{"building": "yes", "height": "{text}", ')
        refusal(written(tmp_path, "a.geojson", building), read_zones)
