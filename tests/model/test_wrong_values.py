"""Values that cannot be used are named in one sentence of skyverse's own, whatever pydantic calls them."""

import copy

import pytest

import skyverse as sky
from skyverse.files.scenarios import scenario_from_data
from skyverse.model.uav import with_limits
from skyverse.model.vehicle_profiles import FleetLimits

GIVEN = {
    "name": "yard",
    "bounds": {"min": [0, 0, 0], "max": [10, 10, 10]},
    "clearance": 0.5,
    "lattice": {"step": [1, 1, 1]},
    "obstacles": [{"min": [4, 4, 0], "max": [5, 5, 5]}],
    "movers": [
        {
            "shape": {"shape": "sphere", "centre": [0, 0, 0], "radius": 1},
            "motion": {"motion": "circle", "centre": [5, 5, 5], "radius": 2, "period": 9},
        }
    ],
    "uavs": [{"start": [1, 1, 1]}],
    "targets": [{"position": [9, 9, 9]}],
}
CASES = [
    (("clearance",), -1, "clearance: expected 0 or more, found -1"),
    (("clearance",), "two", "clearance: expected a number of metres, found 'two'"),
    (("uavs", 0, "max_speed"), "10 km/h", "uavs[0].max_speed: expected a number of m/s, found '10 km/h'"),
    (("uavs", 0, "max_tilt"), "20 deg", "uavs[0].max_tilt: expected a number of degrees, found '20 deg'"),
    (("uavs", 0, "start"), [1, "2 m", 3], "uavs[0].start[1]: expected a number of metres, found '2 m'"),
    (("movers", 0, "motion", "period"), "9 s", "movers[0].motion.period: expected a number of seconds, found '9 s'"),
    (
        ("objective",),
        {"altitude": {"low": 1, "high": 2, "weight": "x"}},
        "objective.altitude.weight: expected a number, found 'x'",
    ),
    (("clearance",), None, "clearance: expected a number of metres, found None"),
    (("clearance",), float("nan"), "clearance: expected a finite number, found nan"),
    (("name",), 3, "name: expected a text, found 3"),
    (("name",), "", "name: expected a text that is not empty, found ''"),
    (("uavs",), "x", "uavs: expected a list, found 'x'"),
    (("uavs", 0, "start"), [1, 2, 3, 4], "uavs[0].start: expected 3 values at most, found [1, 2, 3, 4]"),
    (("uavs", 0, "start"), [1, 2], "uavs[0].start[2]: is missing"),
    (("uavs", 0, "priority"), 1.5, "uavs[0].priority: expected a whole number, found 1.5"),
    (("uavs", 0, "fixed_wing"), True, "uavs[0].fixed_wing: expected a mapping of keys to values, found True"),
    (("uavs", 0, "max_speed"), 0, "uavs[0].max_speed: expected 0.001 or more, found 0"),
    (("lattice", "connectivity"), 7, "lattice.connectivity: expected 6 or 26, found 7"),
    (("lattice", "step"), [1, 0, 1], "lattice.step[1]: expected a number above 0, found 0"),
    (("bounds",), [1, 2], "bounds: expected a mapping of keys to values, found [1, 2]"),
    (("frame",), {"axes": "map", "origin": {"latitude": 99}}, "frame.origin.latitude: expected at most 90, found 99"),
    (
        ("obstacles", 0),
        {"shape": "cube"},
        "obstacles[0].shape: expected one of 'box', 'cylinder', 'sphere', 'prism', 'voxels', found 'cube'",
    ),
    (
        ("obstacles", 0),
        {"low": 0, "min": [0, 0, 0], "max": [1, 1, 1]},
        "obstacles[0].low: the shape 'box' has no such key; the key 'shape' says which shape it is",
    ),
    (("obstacles", 0, "centre"), [1, 2], "obstacles[0].centre: the shape 'box' has no such key; the key 'shape'"),
    (
        ("movers", 0, "motion", "bearing"),
        "east",
        "movers[0].motion.bearing: expected a number of degrees, found 'east'",
    ),
    (("movers", 0, "motion", "period"), 0, "movers[0].motion.period: expected 0.01 or more, found 0"),
    (("movers", 0, "motion", "centre"), [1, 2], "movers[0].motion.centre[2]: is missing"),
    (("movers", 0, "motion"), {"motion": "circle", "radius": 1, "period": 9}, "movers[0].motion.centre: is missing"),
    (
        ("movers", 0, "motion", "motion"),
        "circl",
        "movers[0].motion.motion: expected one of 'waypoints', 'circle', 'periodic', 'polynomials', found 'circl'; "
        "did you mean 'circle'?",
    ),
    (
        ("movers", 0, "motion", "times"),
        [0, 1],
        "movers[0].motion.times: the motion 'circle' has no such key; the key 'motion' says which motion it is",
    ),
    (("movers", 0, "motion", "perod"), 3, "movers[0].motion.perod: there is no such key; did you mean 'period'?"),
    (("movers", 0, "motion"), {"points": [[0, 0, 0]], "times": []}, "movers[0].motion: times must be as many"),
    (("movers", 0, "shape"), {"shape": "sphere", "centre": [0, 0, 0]}, "movers[0].shape.radius: is missing"),
    (("cleerance",), 1, "cleerance: there is no such key; did you mean 'clearance'?"),
]


@pytest.mark.parametrize(("place", "value", "sentence"), CASES)
def test_a_wrong_value_is_named_with_what_was_expected(place, value, sentence):
    data = copy.deepcopy(GIVEN)
    at = data
    for part in place[:-1]:
        at = at[part]
    at[place[-1]] = value
    with pytest.raises(sky.InputError) as refused:
        scenario_from_data("yard.yaml", data)
    assert str(refused.value).startswith(f"yard.yaml: {sentence}")


def test_limits_of_a_fleet_say_what_they_expect(refuses):
    (uav,) = scenario_from_data("yard.yaml", GIVEN).uavs
    with refuses():
        with_limits(uav, FleetLimits(max_speed=-3.0))
