"""Lines become observations, or one sentence says what is wrong with them, whatever they hold."""

import json
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.live import MAX_LINE, LineSplitter, read_observation

BALL = {"shape": "sphere", "centre": [0, 0, 0], "radius": 0.3}
SEEN = {"name": "ball", "shape": BALL, "position": [1, 2, 3], "top_speed": 2}


def line(**fields):
    return json.dumps({"t": 1, **fields}).encode()


@given(st.lists(st.binary(max_size=20)), st.lists(st.integers(1, 9), min_size=1))
def test_lines_are_the_same_however_they_are_cut_into_chunks(parts, sizes):
    text, splitter, found = b"\n".join(parts), LineSplitter(), []
    sizes, k = sizes * (len(text) + 1), 0
    while text:
        found += splitter.lines(text[: sizes[k]])
        text, k = text[sizes[k] :], k + 1
    assert found + splitter.end() == b"\n".join(parts).split(b"\n")[: None if parts and parts[-1] else -1]


def test_an_overlong_line_is_refused_and_the_next_one_taken():
    splitter = LineSplitter()
    found = []
    for _ in range(5):
        found += splitter.lines(b" " * (MAX_LINE // 3))
    found += splitter.lines(b"\n" + line() + b"\n")
    assert len(found[0]) == MAX_LINE + 1
    with pytest.raises(sky.InputError, match="expected at most 8,388,608 bytes in a line, found more"):
        read_observation(found[0])
    assert read_observation(found[1]).t == 1


def test_an_observation_is_read_with_all_its_fields():
    wall = {"min": [0, 0, 0], "max": [1, 1, 1]}
    state = {"position": [0, 0, 0], "velocity": [1, 0, 0]}
    seen = read_observation(line(movers=[SEEN], obstacles=[wall], states={"uav-1": state}, deadline_ms=8))
    assert seen.t == 1.0
    assert seen.movers == (sky.Sighting(**{**SEEN, "shape": sky.Sphere(centre=(0, 0, 0), radius=0.3)}),)
    assert seen.obstacles == (sky.Box(min=(0, 0, 0), max=(1, 1, 1)),)
    assert seen.states["uav-1"].velocity == (1, 0, 0)
    assert seen.deadline_ms == 8


@pytest.mark.parametrize(
    ("text", "field", "said"),
    [
        (b"\xff", None, "expected text in UTF-8, found something else at byte 0"),
        (b"{", None, "expected JSON, found something else at character 2"),
        (b"[" * 100_000, None, "nested at most 100 deep"),
        (b'{"t": 1, "t": 2}', None, "the key 't' stands twice"),
        (b'{"t": ' + b"1" * 5000 + b"}", None, "digits"),
        (b"3", None, "expected a mapping of keys to values, found 3"),
        (b"{}", "t", "is missing"),
        (b'{"t": NaN}', "t", "expected a finite number, found nan"),
        (b'{"t": -1}', "t", "expected 0 or more, found -1"),
        (b'{"t": true}', "t", "expected a number"),
        (b'{"t": "1"}', "t", "expected a number"),
        (line(mover=[]), "mover", "there is no such key; did you mean 'movers'?"),
        (line(movers={}), "movers", "expected a list"),
        (line(movers=[{**SEEN, "position": [1, 2, None]}]), "movers[0].position[2]", "expected a number"),
        (line(movers=[SEEN, {**SEEN, "speed": 1}]), "movers[1].speed", "there is no such key"),
        (line(movers=[{**SEEN, "shape": {"shape": "ball"}}]), "movers[0].shape.shape", "found 'ball'"),
        (line(movers=[{**SEEN, "top_speed": 0}]), "movers[0].top_speed", "expected 0.001 or more, found 0"),
        (line(movers=[{**SEEN, "name": ""}]), "movers[0].name", "expected a text that is not empty"),
        (line(obstacles=[{"min": [0, 0, 0], "max": [1, 1, -1]}]), "obstacles[0]", "min must be below max"),
        (line(states={"uav-1": {"position": [0, 0, 0]}}), "states.uav-1.velocity", "is missing"),
        (line(deadline_ms=-1), "deadline_ms", "expected 0 or more, found -1"),
    ],
)
def test_what_is_no_observation_is_refused_in_one_sentence(text, field, said):
    with pytest.raises(sky.InputError) as refused:
        read_observation(text)
    assert refused.value.sentence.field == field
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda held: st.lists(held, max_size=3) | st.dictionaries(st.text(max_size=5), held, max_size=3),
    max_leaves=10,
)
KEYS = st.sampled_from(["t", "movers", "obstacles", "states", "deadline_ms", "name", "shape", "position", "min"])


@given(st.dictionaries(KEYS, VALUES) | st.dictionaries(st.just("movers"), st.lists(st.dictionaries(KEYS, VALUES))))
def test_any_json_is_an_observation_or_refused(data):
    line = json.dumps({"t": 1, **data}).encode()
    with suppress(sky.InputError):
        assert read_observation(line).model_fields_set >= data.keys()


@given(st.binary())
def test_any_bytes_are_refused(text):
    with pytest.raises(sky.InputError):
        read_observation(text)
