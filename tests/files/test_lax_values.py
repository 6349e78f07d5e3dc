"""What is not a number or not true or false in a file is refused, and never taken for one."""

import copy
import json
from functools import cache

import pytest

import skyverse as sky
from skyverse import InputError
from skyverse.files.missions import FLIGHTS, MISSIONS, mission_from_data
from skyverse.files.scenarios import scenario_from_data


@cache
def mission_text():
    mission = sky.plan_mission(sky.read("table-4.9-2"), sky.MVO(universes=5), stop=sky.MaxIterations(2), rng=1)
    data = json.loads(MISSIONS.text(mission))
    conflict = {"uavs": [0, 1], "begin": 1.0, "end": 2.0, "time": 1.5, "nearness": 0.5, "position": [1.0, 2.0, 3.0]}
    data["deconfliction"]["found"] = [conflict | {"given": False}]
    data["violations"] = [{"fault": "status", "uavs": [0], "message": "Too fast.", "time": 1.0, "position": None}]
    return json.dumps(data)


def changed(data, place, value):
    """Return data with another value at a place."""
    data = copy.deepcopy(data)
    part = data
    for key in place[:-1]:
        part = part[key]
    assert place[-1] in part if isinstance(part, dict) else len(part) > place[-1]
    part[place[-1]] = value
    return data


def told(place):
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place).removeprefix(".")


NUMBERS = [
    ("results", 0, "cost"),
    ("results", 0, "terms", "fuel"),
    ("results", 0, "bound"),
    ("results", 0, "seconds"),
    ("violations", 0, "time"),
    ("deconfliction", "found", 0, "begin"),
    ("deconfliction", "found", 0, "position", 1),
    ("deconfliction", "total_after"),
    ("flights", 0, "length"),
    ("flights", 0, "deviation"),
]
WHOLES = [
    ("assignment", 0),
    ("results", 0, "effort", "evaluations"),
    ("results", 0, "provenance", "seed"),
    ("violations", 0, "uavs", 0),
    ("deconfliction", "found", 0, "uavs", 1),
]
FLAGS = [("interrupted",), ("results", 0, "any_angle"), ("deconfliction", "found", 0, "given")]
ARRAYS = [
    ("trajectories", 0, "coefficients"),
    ("trajectories", 0, "knots"),
    ("results", 0, "path"),
    ("results", 0, "start"),
    ("results", 0, "history", "cost"),
]


def refusal(place, value, read=mission_from_data, text=mission_text):
    with pytest.raises(InputError) as refused:
        read("m.json", changed(json.loads(text()), place, value))
    return str(refused.value)


def test_the_mission_is_read_as_it_is():
    mission = mission_from_data("m.json", json.loads(mission_text()))
    assert mission.deconfliction.found[0].given is False
    infinite = changed(json.loads(mission_text()), ("results", 0, "history", "cost", 0), "Infinity")
    assert mission_from_data("m.json", infinite).results[0].history.cost[0] == float("inf")


@pytest.mark.parametrize("place", NUMBERS, ids=told)
@pytest.mark.parametrize("value", [True, "1e3", "inf"])
def test_a_number_is_a_number(place, value):
    assert refusal(place, value) == f"m.json: {told(place)}: expected a number, found {value!r}"


@pytest.mark.parametrize("place", WHOLES, ids=told)
@pytest.mark.parametrize("value", [True, "1", 1.0])
def test_a_whole_number_is_a_whole_number(place, value):
    assert refusal(place, value) == f"m.json: {told(place)}: expected a whole number, found {value!r}"


@pytest.mark.parametrize("place", FLAGS, ids=told)
@pytest.mark.parametrize("value", [1, "true", "no", 0.0])
def test_true_is_neither_one_nor_a_word(place, value):
    assert refusal(place, value) == f"m.json: {told(place)}: expected true or false, found {value!r}"


@pytest.mark.parametrize("place", ARRAYS, ids=told)
@pytest.mark.parametrize("value", [True, "1e3"])
def test_the_numbers_of_an_array_are_numbers(place, value):
    array = json.loads(mission_text())
    for key in place:
        array = array[key]
    row = array
    while isinstance(row[0], list):
        row = row[0]
    row[-1] = value
    assert f"m.json: {told(place)}: expected numbers in rows of equal length, found " in refusal(place, array)


@pytest.mark.parametrize("value", [True, "25"])
def test_the_efforts_of_a_history_are_whole_numbers(value):
    place = ("results", 0, "history", "generated_paths")
    efforts = json.loads(mission_text())["results"][0]["history"]["generated_paths"]
    assert f"m.json: {told(place)}: expected whole numbers, found " in refusal(place, [value, *efforts[1:]])


SCENARIO = {
    "name": "yard",
    "bounds": {"min": [0, 0, 0], "max": [10, 10, 10]},
    "clearance": 0.5,
    "lattice": {"step": [1, 1, 1]},
    "terrain": {"origin": [0, 0], "step": [10, 10], "heights": [[0, 1], [1, 2]]},
    "obstacles": [{"shape": "voxels", "origin": [2, 2, 5], "step": [1, 1, 1], "occupied": [[[1, 0]]]}],
}


@pytest.mark.parametrize(
    ("place", "value", "sentence"),
    [
        (("terrain", "heights"), [[0, 1], [True, 2]], "terrain.heights: expected rows of numbers of equal length"),
        (("terrain", "heights"), [[0, 1], ["1e1", 2]], "terrain.heights: expected rows of numbers of equal length"),
        (("obstacles", 0, "occupied"), [[["1", "0"]]], "obstacles[0].occupied: expected 0 for what is free and 1"),
    ],
)
def test_the_grids_of_a_scenario_hold_numbers(place, value, sentence):
    assert scenario_from_data("s.json", SCENARIO).terrain is not None
    with pytest.raises(InputError) as refused:
        scenario_from_data("s.json", changed(SCENARIO, place, value))
    assert str(refused.value).startswith(f"s.json: {sentence}")


@pytest.mark.parametrize(
    ("place", "value", "expected"),
    [
        (("conditions", "gusts"), "yes", "true or false"),
        (("conditions", "gusts"), 1, "true or false"),
        (("conditions", "delay"), "0.1", "a number"),
        (("conditions", "noise"), True, "a number"),
        (("conditions", "wind", 0), "1", "a number"),
    ],
)
def test_the_weather_of_a_flight_is_told_in_numbers(place, value, expected):
    flight = {
        "mission": json.loads(mission_text()),
        "seed": 1,
        "margin": 0.5,
        "flown": [None, None],
        "passings": [],
        "violations": [],
        "conditions": {"vehicle": "thesis", "wind": [1, 0, 0], "noise": 0.0, "gusts": True, "delay": 0.0},
        "format": "skyverse/flight/1",
    }
    assert FLIGHTS.from_data("f.json", flight).conditions.gusts
    with pytest.raises(InputError) as refused:
        FLIGHTS.from_data("f.json", changed(flight, place, value))
    assert str(refused.value) == f"f.json: {told(place)}: expected {expected}, found {value!r}"
