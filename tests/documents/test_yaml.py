"""YAML of thousands of obstacles, one a line: fast, and the same as YAML's own reading of it."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

import skyverse as sky
from skyverse.documents.yaml import LONG_LIST, load_yaml, yaml_text

TEXTS = st.text(st.characters(codec="utf-8"), max_size=8) | st.sampled_from(
    ["\x85", "\u2028x", "\ufeff", "\x7f", "\U0001f600", "obstacles: []\n", "- {}", "'\"#: ", "~", "1e5", "no"]
)
DATA = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**9), 10**9) | st.floats(allow_nan=False, allow_infinity=False) | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=6,
)


@given(st.lists(st.dictionaries(TEXTS, DATA, max_size=3), min_size=1, max_size=3), TEXTS, st.booleans())
@settings(max_examples=20)
def test_long_lists_read_back_equal_and_as_yaml_says(some, text, zones):
    data = {"name": text, "obstacles": some * LONG_LIST, "zones": some * LONG_LIST if zones else [], "end": [text]}
    written = yaml_text(data)
    assert load_yaml(written) == data
    assert YAML(typ="safe", pure=True).load(written) == data


def many(line):
    return "name: a\nobstacles:\n" + f"  {line}\n" * LONG_LIST + "end: 1\n"


@pytest.mark.parametrize(
    "line",
    [
        '- {"shape":"box", "min": [0, 0, 0]}',
        "- {shape: box, min: [0, 0, 0]}  # by hand",
        "- {shape: box,\n     min: [0, 0, 0]}",
        "- {shape: box}\n    # a comment",
        '- {"a": 1e5, "b": 0x10, "c": "\\u00e9"}',
    ],
)
def test_lines_by_hand_read_as_yaml_says(line):
    assert load_yaml(many(line)) == YAML(typ="safe", pure=True).load(many(line))


def test_what_only_looks_like_a_list_is_left_alone():
    text = "description: |\n" + "".join("  " + row + "\n" for row in many('- {"a": 1}').splitlines())
    assert load_yaml(text) == YAML(typ="safe", pure=True).load(text)
    quoted = 'description: "\nobstacles:\n' + "- {}\n" * LONG_LIST + '"\n'
    assert load_yaml(quoted) == YAML(typ="safe", pure=True).load(quoted)


def test_a_mistake_below_a_long_list_is_named_by_its_line(tmp_path, refuses):
    text = many('- {"min": [0, 0, 0], "max": [1, 1, 1]}') + "x: [1\n"
    (tmp_path / "a.yaml").write_text(text)
    with refuses():
        sky.read(tmp_path / "a.yaml")


def test_a_key_that_stands_twice_in_a_line_is_refused(tmp_path, refuses):
    (tmp_path / "a.yaml").write_text(many('- {"min": [0, 0, 0], "min": [1, 1, 1]}'))
    with refuses():
        sky.read(tmp_path / "a.yaml")


def test_two_thousand_prisms_come_back_equal(tmp_path):
    prisms = tuple(
        sky.Prism(vertices=((i, 0), (i + 0.5, 0), (i + 0.5, 0.7), (i, 0.7 + i / 3)), low=0, high=1.5)
        for i in range(2000)
    )
    scenario = sky.read("map1").model_copy(update={"obstacles": prisms})
    sky.write(scenario, tmp_path / "a.yaml")
    assert sky.read(tmp_path / "a.yaml") == scenario
