"""Values that cannot be used are named in one sentence of skyverse's own, whatever pydantic calls them."""

import copy

import pytest

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
    (("clearance",), -1),
    (("clearance",), "two"),
    (("uavs", 0, "max_speed"), "10 km/h"),
    (("uavs", 0, "max_tilt"), "20 deg"),
    (("uavs", 0, "start"), [1, "2 m", 3]),
    (("movers", 0, "motion", "period"), "9 s"),
    (("objective",), {"altitude": {"low": 1, "high": 2, "weight": "x"}}),
    (("clearance",), None),
    (("clearance",), float("nan")),
    (("name",), 3),
    (("name",), ""),
    (("uavs",), "x"),
    (("uavs", 0, "start"), [1, 2, 3, 4]),
    (("uavs", 0, "start"), [1, 2]),
    (("uavs", 0, "priority"), 1.5),
    (("uavs", 0, "fixed_wing"), True),
    (("uavs", 0, "max_speed"), 0),
    (("lattice", "connectivity"), 7),
    (("lattice", "step"), [1, 0, 1]),
    (("bounds",), [1, 2]),
    (("frame",), {"axes": "map", "origin": {"latitude": 99}}),
    (("obstacles", 0), {"shape": "cube"}),
    (("obstacles", 0), {"low": 0, "min": [0, 0, 0], "max": [1, 1, 1]}),
    (("obstacles", 0, "centre"), [1, 2]),
    (("movers", 0, "motion", "bearing"), "east"),
    (("movers", 0, "motion", "period"), 0),
    (("movers", 0, "motion", "centre"), [1, 2]),
    (("movers", 0, "motion"), {"motion": "circle", "radius": 1, "period": 9}),
    (("movers", 0, "motion", "motion"), "circl"),
    (("movers", 0, "motion", "times"), [0, 1]),
    (("movers", 0, "motion", "perod"), 3),
    (("movers", 0, "motion"), {"points": [[0, 0, 0]], "times": []}),
    (("movers", 0, "shape"), {"shape": "sphere", "centre": [0, 0, 0]}),
    (("cleerance",), 1),
]


@pytest.mark.parametrize(("place", "value"), CASES)
def test_a_wrong_value_is_named_with_what_was_expected(place, value, refuses):
    data = copy.deepcopy(GIVEN)
    at = data
    for part in place[:-1]:
        at = at[part]
    at[place[-1]] = value
    with refuses():
        scenario_from_data("yard.yaml", data)


def test_limits_of_a_fleet_say_what_they_expect(refuses):
    (uav,) = scenario_from_data("yard.yaml", GIVEN).uavs
    with refuses():
        with_limits(uav, FleetLimits(max_speed=-3.0))
