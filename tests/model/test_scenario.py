"""What a scenario may be, and what its schema says."""

import json
import math

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

import skyverse as sky
from skyverse.files.builtin import BUILTIN_NAMES
from skyverse.model.pad import ground_height, home_height
from skyverse.model.round_steps import MAX_BELOW_CEILING, MAX_DEFAULT_NODES, round_steps
from skyverse.model.scenario import MAX_STATES, PRESETS, upright_step, with_fitting_lattice
from worlds import scenarios

VALID = {
    "name": "one",
    "bounds": {"min": [0, 0, 0], "max": [4, 3, 2]},
    "obstacles": [{"min": [1, 1, 0], "max": [2, 2, 1]}],
    "clearance": 0.25,
    "lattice": {"step": [0.5, 0.5, 0.5]},
    "uavs": [{"start": [0, 0, 0]}],
    "targets": [{"position": [4, 3, 2]}],
}


CYLINDER = {"shape": "cylinder", "centre": [1, 1], "radius": 1, "low": 0, "high": 1, "risk": 0.5}


def prism(*vertices):
    return {"shape": "prism", "vertices": vertices, "low": 0, "high": 1, "risk": 0.5}


def changed(place, value):
    """The valid scenario with one thing put elsewhere; `place` is a path of keys."""
    data = json.loads(json.dumps(VALID))
    at = data
    for key in place[:-1]:
        at = at[key]
    at[place[-1]] = value
    return data


def test_the_valid_scenario_is_valid():
    scenario = sky.Scenario.model_validate(VALID)
    assert scenario.obstacles == (sky.Box(min=(1, 1, 0), max=(2, 2, 1)),)
    assert scenario.objective == PRESETS["thesis"]
    assert scenario.lattice.connectivity == 6


def test_zones_and_soft_terms_are_off_unless_given():
    assert sky.Scenario.model_validate(VALID).zones == ()
    objective = sky.Scenario.model_validate(VALID).objective
    assert (objective.altitude, objective.climb) == (None, None)


@pytest.mark.parametrize("corners", [[(0, 0), (2, 0), (2, 2)], [(0, 0), (1, 0), (2, 0), (2, 2), (1, 1), (0, 2)]])
def test_an_outline_may_turn_either_way_and_have_straight_and_inward_corners(corners):
    for vertices in (corners, corners[::-1]):
        zone = sky.Scenario.model_validate(changed(("zones",), [prism(*vertices)])).zones[0]
        assert zone == sky.Prism(vertices=np.array(vertices, float), low=0, high=1, risk=0.5)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("clearence",), 1),
        (("uavs", 0, "speed"), 1),
        (("uavs", 0, "start", 1), float("nan")),
        (("uavs", 0, "start", 1), float("inf")),
        (("targets", 0, "position"), [0, 0]),
        (("targets", 0, "position"), [0, 0, 0, 0]),
        (("targets", 0, "position"), "here"),
        (("targets", 0, "position", 0), "1"),
        (("targets", 0, "position", 0), True),
        (("clearance",), True),
        (("clearance",), -0.1),
        (("clearance",), None),
        (("bounds", "max"), [4, 0, 2]),
        (("obstacles", 0, "max"), [2, 2, -1]),
        (("obstacles", 0, "shape"), "cone"),
        (("obstacles",), 3),
        (("lattice", "step", 2), 0),
        (("lattice", "step", 2), 2.5),
        (("lattice", "step"), [0.001, 0.001, 0.001]),
        (("lattice", "connectivity"), 18),
        (("objective",), "thesys"),
        (("objective",), {"fuel": 0}),
        (("objective",), {"fuel": -1}),
        (("objective",), {"unit": "feet"}),
        (("objective",), {"altitude": {"low": 3, "high": 2, "weight": 1}}),
        (("objective",), {"altitude": {"low": 1, "high": 2, "weight": 0}}),
        (("objective",), {"climb": {"angle": 90, "weight": 1}}),
        (("objective",), {"risk": -1}),
        (("zones",), [CYLINDER | {"radius": 0}]),
        (("zones",), [CYLINDER | {"high": 0}]),
        (("zones",), [CYLINDER | {"risk": 0}]),
        (("zones",), [CYLINDER | {"max_speed": 0}]),
        (("zones",), [{"min": [0, 0, 0], "max": [1, 1, 1]}]),
        (("obstacles",), [{"min": [0, 0, 0], "max": [1, 1, 1], "max_speed": 2}]),
        (("zones",), [CYLINDER | {"shape": "cone"}]),
        (("zones",), [prism((0, 0), (1, 0))]),
        (("zones",), [prism((0, 0), (1, 0), (0, 1), (1, 1))]),
        (("zones",), [prism((0, 0), (1, 0), (1, 0), (0, 1))]),
        (("zones",), [prism((0, 0), (2, 0), (1, 0), (1, 1))]),
        (("zones",), [prism((0, 0), (4, 0), (4, 4), (2, 0), (0, 4))]),
        (("zones",), [prism((0, 0), (1, 0), (2, 0))]),
        (("uavs", 0, "max_speed"), 0),
        (("uavs", 0, "max_acceleration"), -1),
        (("uavs", 0, "separation"), -1),
        (("uavs",), [{"name": "a", "start": [0, 0, 0]}] * 2),
        (("uavs",), [{"name": "uav-2", "start": [0, 0, 0]}, {"start": [0, 0, 0]}]),
        (("targets",), [{"name": "b", "position": [0, 0, 0]}] * 3),
        (("frame",), {"origin": {"latitude": 91, "longitude": 0, "altitude": 0}}),
        (("name",), ""),
        (("format",), "skyverse/scenario/3"),
        (("format",), 2),
        (("max_height",), 120),
        (("max_height",), 0),
        (("obstacles", 0, "closed_above"), "yes"),
        (("zones",), [CYLINDER | {"closed_above": True}]),
        (("uavs", 0, "max_climb"), 0),
        (("uavs", 0, "max_descent"), -1),
        (("uavs", 0, "tracking_error"), 1),
        (("uavs", 0, "tracking_error"), {"horizontal": -1}),
    ],
)
def test_what_is_wrong_is_refused_and_named(place, value, refuses):
    with refuses():
        sky.Scenario(**changed(place, value))


def test_a_scenario_says_how_far_uavs_may_stray_how_fast_they_climb_and_how_high_they_may_fly():
    uav = {
        "start": [0, 0, 1],
        "tracking_error": {"horizontal": 1.5, "vertical": 2},
        "max_climb": 3,
        "max_descent": 2,
        "vehicle": "",
    }
    terrain = {"origin": [0, 0], "step": [4, 3], "heights": [[0, 0], [0, 0]]}
    scenario = sky.Scenario.model_validate({**VALID, "uavs": [uav], "terrain": terrain, "max_height": 1.5})
    assert scenario.uavs[0].tracking_error == sky.TrackingError(horizontal=1.5, vertical=2)
    assert (scenario.uavs[0].max_climb, scenario.uavs[0].max_descent, scenario.max_height) == (3, 2, 1.5)
    with pytest.raises(ValidationError, match=r"max_height, 0\.25 m, must be above the clearance"):
        sky.Scenario.model_validate({**VALID, "uavs": [uav], "terrain": terrain, "max_height": 0.25})


def test_a_terrain_says_from_which_surface_a_ceiling_is_counted():
    terrain = {"origin": [0, 0], "step": [4, 3], "heights": [[2, 2], [2, 3]], "lowest": [[2, 1], [2, 2]]}
    scenario = sky.Scenario.model_validate({**VALID, "terrain": terrain})
    assert scenario.terrain.lowest_ground.heights.tolist() == terrain["lowest"]
    assert scenario.terrain.lowest_ground.height((0, 3)) == 1
    without = scenario.terrain.model_copy(update={"lowest": None})
    assert without.lowest_ground is without
    assert scenario.digest != scenario.model_copy(update={"terrain": without}).digest
    for lowest, says in (
        ([[2, 1], [2, 4]], r"lowest must not be above heights, but at \[1\]\[1\] they are 4 and 3"),
        ([[2, 1, 0], [2, 2, 0]], r"lowest must have as many rows and numbers as heights, \(2, 2\), found \(2, 3\)"),
        ([[2, 1], [2, None]], "expected"),
    ):
        with pytest.raises(ValidationError, match=says):
            sky.Scenario.model_validate({**VALID, "terrain": terrain | {"lowest": lowest}})


@pytest.mark.parametrize("key", ["name", "bounds", "clearance"])
def test_what_cannot_be_guessed_must_be_given(key):
    with pytest.raises(ValidationError, match=key):
        sky.Scenario.model_validate({k: v for k, v in VALID.items() if k != key})


def test_a_lattice_may_have_as_many_nodes_as_the_limit_says_and_no_more():
    side = round(MAX_STATES ** (1 / 3))
    fits = {"step": [1, 1, 1]}
    bounds = {"min": [0, 0, 0], "max": [side - 1, side - 1, side - 3]}
    assert sky.Scenario.model_validate({**VALID, "bounds": bounds, "lattice": fits})
    bounds["max"] = [side + 1, side + 1, side + 1]
    with pytest.raises(ValidationError, match="take longer steps"):
        sky.Scenario.model_validate({**VALID, "bounds": bounds, "lattice": fits})


@pytest.mark.parametrize(("low", "high", "step"), [(0.2, 0.3, 0.1), (-0.7, -0.6, 0.1), (5.8, 6.0, 0.2)])
def test_a_step_may_be_exactly_as_long_as_the_bounds(low, high, step):
    bounds = {"min": [low, 0, 0], "max": [high, 1, 1]}
    scenario = sky.Scenario.model_validate({**VALID, "bounds": bounds, "lattice": {"step": [step, 1, 1]}})
    assert tuple(sky.Airspace(scenario).grid.shape) == (2, 2, 2)


def test_nothing_in_a_scenario_can_be_set():
    scenario = sky.Scenario.model_validate(VALID)
    for thing, name in [(scenario, "clearance"), (scenario.uavs[0], "start"), (scenario.bounds, "min")]:
        with pytest.raises(ValidationError, match="frozen"):
            setattr(thing, name, getattr(thing, name))
    assert isinstance(scenario.uavs, tuple)
    assert isinstance(scenario.obstacles, tuple)
    assert isinstance(scenario.uavs[0].start, tuple)


def test_names_that_were_left_out_are_filled_in_by_number():
    scenario = sky.Scenario.model_validate(
        {
            **VALID,
            "uavs": [{"start": [0, 0, 0]}, {"name": "scout", "start": [1, 0, 0]}, {"start": [0, 0, 1]}],
            "targets": [{"position": [0, 0, 0]}, {"position": [1, 0, 0]}],
        }
    )
    assert [u.name for u in scenario.uavs] == ["uav-1", "scout", "uav-3"]
    assert [t.name for t in scenario.targets] == ["target-1", "target-2"]


def test_points_may_be_numpy_arrays():
    uav = sky.UAV(start=np.array([1.0, 2.0, 3.0]))
    assert uav == sky.UAV(start=(1, 2, 3))
    assert sky.Lattice(step=np.array([1, 2, 3])) == sky.Lattice(step=(1, 2, 3))
    assert sky.Box(min=np.zeros(3), max=np.ones(3)) == sky.Box(min=(0, 0, 0), max=(1, 1, 1))
    with pytest.raises(sky.InputError):
        sky.UAV(start=np.array([1.0, np.nan, 3.0]))
    with pytest.raises(sky.InputError):
        sky.UAV(start=np.zeros((3, 3)))


def test_the_presets_are_the_published_weights():
    assert PRESETS["thesis"] == sky.Objective(fuel=1, divergence=0, end=100, unit="nodes")
    assert PRESETS["turns"] == sky.Objective(fuel=1, divergence=0.3, end=80, unit="nodes")
    assert sky.Scenario.model_validate({**VALID, "objective": "turns"}).objective == PRESETS["turns"]


@pytest.mark.parametrize("name", BUILTIN_NAMES)
@pytest.mark.parametrize("suffix", [".json", ".yaml"])
def test_the_schema_accepts_every_built_in_scenario_as_written(name, suffix, tmp_path):
    from ruamel.yaml import YAML

    path = tmp_path / f"scenario{suffix}"
    sky.write(sky.read(name), path)
    data = json.loads(path.read_text()) if suffix == ".json" else YAML(typ="safe").load(path.read_text())
    validator = jsonschema.Draft202012Validator(sky.scenario_schema())
    validator.check_schema(sky.scenario_schema())
    validator.validate(data)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("clearence",), 0.25),
        (("uavs", 0, "spead"), 1),
        (("lattice", "steps"), [1, 1, 1]),
        (("objective",), "thesys"),
        (("objective",), {"fule": 1}),
        (("bounds", "min"), [0, 0]),
        (("clearance",), "wide"),
    ],
)
def test_the_schema_refuses_what_the_model_refuses(place, value):
    validator = jsonschema.Draft202012Validator(sky.scenario_schema())
    validator.validate(VALID)
    with pytest.raises(jsonschema.ValidationError):
        validator.validate(changed(place, value))


@given(scenarios(uavs=2, targets=3))
def test_every_scenario_survives_its_own_dump(scenario):
    dumped = json.loads(scenario.model_dump_json())
    assert sky.Scenario.model_validate(dumped) == scenario
    jsonschema.Draft202012Validator(sky.scenario_schema()).validate(dumped)


def test_the_built_in_maps_are_those_of_the_thesis():
    one, two, three = (sky.read(name) for name in ("map1", "map2", "map3"))
    assert (len(one.obstacles), len(two.obstacles), len(three.obstacles)) == (8, 7, 14)
    # the corrected rows of Table 3.2
    assert one.obstacles[1].min == (0, 2, 4.5)
    assert one.obstacles[2] == sky.Box(min=(0, 2, 1.5), max=(3, 2.5, 4.5))
    assert two.obstacles[1] == sky.Box(min=(9.1, 0, 2.1), max=(9.9, 5, 6))
    assert three.obstacles[8] == sky.Box(min=(0, -2, 0), max=(10, -1.5, 1.5))
    assert three.obstacles[9] == sky.Box(min=(0, -2, 3), max=(10, -1.5, 5.5))
    for scenario in (one, two, three):
        assert scenario.clearance == 0.25
        assert scenario.lattice == sky.Lattice(step=(0.1, 0.1, 0.5))
        assert scenario.objective == PRESETS["thesis"]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("max_speed", 0),
        ("max_speed", -1),
        ("max_acceleration", 1e200),
        ("max_jerk", 1e-200),
        ("max_jerk", float("nan")),
        ("max_tilt", 90),
        ("max_tilt", 0),
        ("thrust_to_weight", 1),
        ("thrust_to_weight", 1e9),
        ("separation", -0.1),
        ("priority", 1.5),
    ],
)
def test_limits_that_no_vehicle_has_are_refused_by_name(field, value):
    with pytest.raises(sky.InputError) as error:
        sky.UAV(start=(0, 0, 0), **{field: value})
    assert error.value.sentence.field == field


@pytest.mark.parametrize(
    "more",
    [
        {"fixed_wing": {"speed": 5, "turn_radius": 50, "climb": 10}},
        {"fixed_wing": {"speed": 4, "turn_radius": 2, "climb": 10}},
        {"fixed_wing": {"speed": 4, "turn_radius": 9, "climb": 20}, "max_climb": 1},
        {"fixed_wing": {"speed": 4, "turn_radius": 9, "climb": 20}, "max_descent": 1},
        {"separation": 0, "vertical_separation": 1},
    ],
)
def test_limits_that_contradict_each_other_are_refused_in_a_sentence(more, refuses):
    with refuses():
        sky.UAV(start=(0, 0, 0), **more)


@pytest.mark.parametrize("far", [1.1e12, -1e300])
def test_coordinates_that_no_place_has_are_refused(far, refuses):
    with refuses():
        sky.UAV(start=(0.0, far, 0.0))
    with refuses():
        sky.Bounds(min=(-1e12, min(far, -1), 0), max=(1, max(far, 1), 1))
    assert sky.Target(position=(1e12, -1e12, 0.0)).position[0] == 1e12


def test_a_scenario_without_a_lattice_gets_one_of_round_steps_and_few_nodes(tmp_path):
    for high, step in (((10, 10, 4), 0.1), ((10, 25, 6), 0.1), ((2000, 2000, 120), 10), ((1e6, 1e6, 1), 2e3)):
        given = {"name": "bare", "bounds": {"min": (0, 0, 0), "max": high}, "clearance": 0.25}
        scenario = sky.Scenario(**given)
        assert scenario.lattice.step == tuple(min(step, size) for size in high)
        assert np.prod(np.divide(high, scenario.lattice.step) + 1) <= 2e6
        sky.write(scenario, tmp_path / "bare.yaml")
        assert "lattice" in (tmp_path / "bare.yaml").read_text()
        again = sky.read_scenario(tmp_path / "bare.yaml")
        assert (again, again.digest) == (scenario, scenario.digest)
    with pytest.raises(sky.InputError) as refused:
        sky.Scenario(name="bare", bounds=3, clearance=0.25)
    assert refused.value.sentence.field == "bounds"
    assert "more" not in str(refused.value)


def test_an_older_frame_is_refused_where_it_has_an_origin():
    origin = {"latitude": 46.8, "longitude": 9.85, "altitude": 1500}
    assert sky.Scenario.model_validate({**VALID, "frame": {"axes": "enu"}}).frame == sky.Frame()
    with pytest.raises(ValidationError, match=r"axes: expected 'map' beside an origin, found 'enu'.*anew"):
        sky.Scenario.model_validate({**VALID, "frame": {"axes": "enu", "origin": origin}})


@pytest.mark.parametrize("x", [(-90_000.1, 0.0), (0.0, 90_000.1)])
def test_an_area_over_which_lengths_on_the_map_are_too_long_is_refused(x):
    given = {**VALID, "bounds": {"min": (x[0], 0, 0), "max": (x[1], 10, 10)}, "uavs": [], "targets": []}
    given |= {"obstacles": [], "zones": [], "lattice": {"step": (5000, 1, 1), "connectivity": 26}}
    origin = sky.Origin(latitude=46.8, longitude=9.85, altitude=1500)
    assert sky.Scenario.model_validate(given).frame.origin is None
    with pytest.raises(ValidationError, match="x within 90 km of the origin"):
        sky.Scenario.model_validate({**given, "frame": sky.Frame(origin=origin)})


def nodes(bounds, lattice):
    sizes = (high - low for low, high in zip(bounds.min, bounds.max, strict=True))
    return math.prod(size / step + 1 for size, step in zip(sizes, lattice.step, strict=True))


@given(
    st.tuples(*[st.floats(2, 20_000)] * 2, st.floats(2, 2_000)),
    st.sampled_from([math.inf, 1.0, 5.0, 20.0]),
)
def test_steps_are_the_shortest_of_few_enough_nodes(size, upright):
    bounds = sky.Bounds(min=(0, 0, 0), max=size)
    lattice = sky.Lattice(step=round_steps(size, 1.0, upright))
    most = MAX_DEFAULT_NODES if upright == math.inf else MAX_BELOW_CEILING
    assert nodes(bounds, lattice) <= most
    assert lattice.step[2] <= upright
    shorter = max(lattice.step[:2]) / 2.5  # steps are 1, 2, 5, 10 ... times as long
    steps = zip((shorter, shorter, min(shorter, upright)), size, strict=True)
    assert shorter < 1 or nodes(bounds, sky.Lattice(step=tuple(min(one, side) for one, side in steps))) > most


STRAYS = {"horizontal": 1.6, "vertical": 3}


def slope(**more):
    """A scenario over a slope of 20 degrees, 2 km long."""
    x = np.linspace(0, 2000, 201)
    ground = sky.Terrain(
        origin=(0, 0), step=(10, 500), heights=np.tan(np.pi / 9) * np.tile(x[:, None], 2), clearance=30
    )
    given = {
        "name": "slope",
        "bounds": sky.Bounds(min=(0, 0, 0), max=(2000, 500, 1400)),
        "terrain": ground,
        "clearance": 5,
        "lattice": sky.Lattice(step=(50, 50, 50)),
        "objective": sky.Objective(unit="metres"),
        "uavs": [sky.UAV(start=(100, 250, 50 + float(ground.height((100, 250)))), tracking_error=STRAYS)],
        "targets": [sky.Target(position=(1900, 250, float(ground.height((1900, 250))) + 50))],
    }
    return sky.Scenario(**(given | more))


def test_upright_steps_fit_twice_between_clearance_and_ceiling():
    assert upright_step(slope()) == math.inf
    assert upright_step(slope(max_height=75)) == 10  # of 75 - 30 - 2 x 3 = 39 m
    assert upright_step(slope(max_height=170)) == 50
    fitted = with_fitting_lattice(slope(max_height=75))
    assert fitted.lattice.step == (50, 50, 10)
    assert with_fitting_lattice(fitted) is fitted


@pytest.mark.parametrize("most", [75, 80, 90])
def test_a_path_follows_a_slope_below_a_ceiling_on_the_fitting_lattice(most):
    fitted = with_fitting_lattice(slope(max_height=most))
    assert sky.AStar().plan(sky.Problem(fitted)).status.reached
    assert not sky.AStar().plan(sky.Problem(slope(max_height=75))).status.reached  # as this can fail


def scenario(**more):
    given = {
        "name": "yard",
        "bounds": {"min": (0, 0, -2), "max": (10, 10, 20)},
        "clearance": 0.5,
        "lattice": {"step": (1, 1, 1)},
        "uavs": [{"start": (2, 4, 8)}, {"start": (2, 4, 8), "home": 1.5}],
    }
    return sky.Scenario(**given | more)


def test_without_a_terrain_the_ground_is_the_lower_bound_and_a_home_the_start():
    level = scenario()
    assert ground_height(level, np.zeros((3, 5, 2))).tolist() == np.full((3, 5), -2.0).tolist()
    assert [home_height(level, uav) for uav in (0, 1)] == [8.0, 1.5]


def test_with_a_terrain_both_are_the_terrains_but_for_a_home_that_is_stated():
    heights = np.add.outer(np.arange(11.0), np.zeros(11)) / 2  # rises by half a metre for each metre north
    sloped = scenario(terrain={"origin": (0, 0), "step": (1, 1), "heights": heights.tolist()})
    found = ground_height(sloped, [(1, 3), (5, 7.5)])
    assert found == pytest.approx(sloped.terrain.height(np.array([(1, 3), (5, 7.5)])))
    assert home_height(sloped, 0) == pytest.approx(float(sloped.terrain.height(np.array((2, 4)))))
    assert home_height(sloped, 1) == 1.5
