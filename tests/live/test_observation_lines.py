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


def test_an_overlong_line_is_refused_and_the_next_one_taken(refuses):
    splitter = LineSplitter()
    found = []
    for _ in range(5):
        found += splitter.lines(b" " * (MAX_LINE // 3))
    found += splitter.lines(b"\n" + line() + b"\n")
    assert len(found[0]) == MAX_LINE + 1
    with refuses():
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
    "text",
    [
        *(b"\xff", b"{", b"[" * 1000, b'{"t": 1, "t": 2}', b'{"t": ' + b"1" * 5000 + b"}", b"3", b"{}"),
        *(b'{"t": %s}' % value for value in (b"NaN", b"-1", b"true", b'"1"')),
        *(line(movers=[{**SEEN, **more}]) for more in ({"position": [1, 2, None]}, {"top_speed": 0}, {"name": ""})),
        line(movers=[{**SEEN, "shape": {"shape": "ball"}}]),
        line(movers=[SEEN, {**SEEN, "speed": 1}]),
        line(mover=[]),
        line(movers={}),
        line(obstacles=[{"min": [0, 0, 0], "max": [1, 1, -1]}]),
        line(states={"uav-1": {"position": [0, 0, 0]}}),
        line(deadline_ms=-1),
    ],
)
def test_what_is_no_observation_is_refused_in_one_sentence(text, refuses):
    with refuses():
        read_observation(text)


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
