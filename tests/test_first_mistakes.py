"""What newcomers give in place of what is meant is refused in one sentence that names it, with one type of error."""

import copy
import dataclasses
import pickle
from functools import cache

import numpy as np
import pytest

import skyverse as sky

MAP1 = sky.read("map1")
FIELD = sky.Survey([(0, 0), (20, 0), (20, 10)], "mavic-3e", gsd="2 cm")
SPOT = sky.Survey([(0, 0), (2, 0), (2, 2)], "mavic-3e", gsd="3 cm")
PROBLEM = sky.Problem(MAP1)


@cache
def planned():
    return sky.plan_mission(MAP1)


def by_one(vehicle, survey):
    """Plan a survey over level ground, by one UAV."""
    uav = {"vehicle": vehicle, "start": (-50, 0, 30), "end": "home"}
    world = {"bounds": {"min": (-500, -500, 0), "max": (500, 500, 140)}, "uavs": [uav], "surveys": [survey]}
    return sky.plan_mission(sky.Scenario.model_validate(world | {"name": "field", "clearance": 2.0}))


@pytest.fixture(scope="module")
def mission():
    return planned()


@pytest.mark.parametrize(
    ("call", "field", "says"),
    [
        (lambda: sky.plan_mission("map1"), "scenario", "expected a Scenario"),
        (lambda: sky.Problem("map1"), "scenario", "expected a Scenario"),
        (lambda: sky.Problem(MAP1, uav="uav-2"), "uav", "did you mean 'uav-1'"),
        (lambda: sky.Problem(MAP1, uav=True), "uav", "found True"),
        (lambda: sky.Problem(MAP1, target=1.0), "target", "found 1.0"),
        (lambda: sky.Problem(MAP1, departs="soon"), "departs", "found 'soon'"),
        (lambda: sky.plan_mission(MAP1, "mv"), None, "there is no planner 'mv'; did you mean 'mvo'"),
        (lambda: sky.plan_mission(MAP1, sky.MVO), "planner", r"MVO\(\) is one"),
        (lambda: sky.plan_many(MAP1, sky.MVO), "planner", r"MVO\(\) is one"),
        (lambda: sky.plan_mission(MAP1, 3), "planner", "found 3"),
        (lambda: sky.photos_of(None), "mission", "expected a Mission"),
        (lambda: sky.photos_of(planned(), 0), "survey", "one of no surveys, found 0"),
        (lambda: FIELD.without(None), "coverage", "expected a Coverage"),
        (lambda: FIELD.without(sky.Photos), "coverage", "expected a Coverage"),
        (lambda: by_one("mapping", SPOT), "assignment", "uav-1 is an aeroplane.*single photos"),
        (lambda: sky.plan_mission(MAP1, "mvo", stop=40), "stop", r"MaxIterations\(40\)"),
        (lambda: sky.plan_many(MAP1, "mvo", stop=40), "stop", "found 40"),
        *((lambda one=one: one().plan(PROBLEM, stop=40), "stop", "found 40") for one in (sky.MVO, sky.Taut, sky.Auto)),
        *((lambda one=one: one().plan(MAP1), "problem", "is one") for one in (sky.MVO, sky.Taut, sky.Auto)),
        (lambda: sky.MVO(universes="many"), None, "whole number"),
        (lambda: sky.MaxIterations(0), None, "whole number"),
        (lambda: sky.MaxSeconds("1"), None, "a number above 0"),
        (lambda: sky.UAV(start=(0, 0, 0), max_sped=1), "max_sped", "did you mean 'max_speed'"),
        (lambda: sky.Sensor(range=-1), "range", "above 0"),
        (lambda: sky.Study(scenarios=["map1"], planners=["mvo"], budget={}), "budget", "expected"),
        (lambda: sky.write(3, "x.json"), None, "expected a Scenario, a Mission"),
        (lambda: sky.read(3), "source", "found 3"),
        *((lambda one=one: one(MAP1), "mission", "expected a Mission, found") for one in (sky.fly, sky.fly_until_safe)),
        (lambda: sky.check(MAP1, None), "mission", "expected a Mission, found None"),
        (lambda: sky.export(None, "x.plan"), "mission", "expected a Mission, found None"),
        (lambda: sky.write_html(3, "x.html"), "mission", "expected a Mission or a Scenario, found 3"),
        (lambda: sky.write_html(MAP1, 3), "path", "found 3"),
    ],
)  # fmt: skip
def test_a_first_mistake_is_refused_in_one_sentence(call, field, says):
    with pytest.raises(sky.InputError, match=says) as refused:
        call()
    assert "\n" not in str(refused.value)
    if field is not None:
        assert refused.value.sentence.field == field


ORIGIN = sky.Origin(latitude=46.8, longitude=9.85, altitude=1500)
NOT_A_NUMBER = (None, "x", np.nan, np.inf, [[1.0]], True, object())
NOT_PLACES = (None, "x", [1.0, 2.0], [[1.0, 2.0]], [[1.0, np.nan, 0.0]], [[["x"]]], object())
NOT_FILES = ("dem.tif", 3, [3], [["dem.tif"]], {"dem.tif": 1}, object())
NOT_A_PATH = (None, 3, ["x"], np.nan, object())
NOT_A_THING = (None, "map1", 3, [MAP1], object())
NOT_A_TEXT = (3, ["x"], np.nan, object())
NOT_A_FLAG = (None, "yes", 1, np.nan, [True], object())
NOT_A_LENGTH = (*NOT_A_NUMBER, -1.0)
OF_MAPS = {
    name: wrong
    for names, wrong in (
        ("terrain buildings zones fences max_heights voxels", (None, *NOT_FILES)),
        ("soft_zones", (None, *NOT_FILES, ["a.geojson"], [("a.geojson", "x")])),
        ("uavs targets", (None, 3, "46.8,9.85", object())),
        ("around", (None, 3, "a.kml", [3], [(1.0,)])),
        ("licences", (3, ["x"], {"a.tif": 3}, {3: "CC0"}, object())),
        ("zones_closed_above", NOT_A_FLAG),
        ("area", ("x", 3, (1.0, 2.0), (1.0, 2.0, 3.0, "x"))),
        ("band tracking_error", ("x", 3, (1.0,), (1.0, "x"), object())),
        ("origin", ("x", 3, (46.8, 9.85, 1500.0))),
        ("ground ceiling max_height", (120, "60 m agl", sky.AboveHome(3.0), object())),
        ("clearance ground_clearance tolerance band_weight", NOT_A_LENGTH),
        ("margin lattice_step terrain_step voxel_size", NOT_A_LENGTH[1:]),
        ("max_speed max_climb max_descent separation battery reserve", NOT_A_LENGTH[1:]),
        ("geoid fill_nodata", NOT_A_NUMBER[1:]),
        ("vehicle", ("ufo", 3, ["camera"])),
        ("name", (None, *NOT_A_TEXT)),
        ("reading", ({}, "x", sky.Raster("x"))),
        ("on_note", (None, 3, "print")),
    )
    for name in names.split()
}
OF_RASTERS = {
    "path": NOT_A_PATH,
    "crs": NOT_A_TEXT,
    "unit": NOT_A_TEXT,
    "band": (0, 1.5, "1", True, object()),
    "nodata": ("x", np.inf, [[1.0]], True, object()),
}
OF_READING = {
    **dict.fromkeys(("altitudes", "unit", "maximum_altitudes"), ("x", 3, ["m"], np.zeros(2), object())),
    **dict.fromkeys(("building_height", "buffer"), NOT_A_LENGTH[1:]),
    **dict.fromkeys(("height_field", "crs"), NOT_A_TEXT),
    "radius_field": (3, True, {}, [1], ["a", 1], np.zeros(2), object()),
    "lod": ("x", "", True, {}, [[1]], np.nan, 10**400, object()),
    "date": ("x", "", True, {}, [[1]], np.nan, "2026-11-26", "2026-11-26T10:00", object()),
}
OF_MISSIONS = {
    **dict.fromkeys(("criterion", "shape"), (None, "best", 3, ["min-sum"])),
    "order": (None, "shortest", 3, ["best"]),
    **dict.fromkeys(("keep_apart", "apart_in_space"), NOT_A_FLAG),
}


@pytest.mark.parametrize(
    ("kind", "tried"),
    [
        (sky.BuildOptions, OF_MAPS),
        (sky.Raster, OF_RASTERS),
        (sky.Reading, OF_READING),
        (sky.MissionOptions, OF_MISSIONS),
    ],
)
def test_every_field_is_tried_with_wrong_values(kind, tried):
    assert {field.name for field in dataclasses.fields(kind)} == set(tried)


@pytest.mark.parametrize(
    ("call", "field", "wrong"),
    [
        *((one, "metres", NOT_A_NUMBER) for one in (sky.AboveGround, sky.AboveSea, sky.AboveHome)),
        (sky.parse_altitude, "text", (None, 3, ["60 m agl"])),
        (lambda one: sky.wind_from(one, 270.0), "speed", (*NOT_A_NUMBER, -1.0)),
        (lambda one: sky.wind_from(8.0, one), "direction", NOT_A_NUMBER),
        (lambda one: sky.to_local(ORIGIN, one), "places", NOT_PLACES),
        (lambda one: sky.to_wgs84(ORIGIN, one), "points", NOT_PLACES),
        (lambda one: sky.to_local(one, [[46.8, 9.85, 1500.0]]), "origin", (None, "x", (46.8, 9.85, 1500.0))),
        (lambda one: sky.to_wgs84(one, [[0.0, 0.0, 0.0]]), "origin", (None, "x", (46.8, 9.85, 1500.0))),
        *(
            (lambda one, name=name: sky.BuildOptions(**{"name": "x", name: one}), name, wrong)
            for name, wrong in OF_MAPS.items()
        ),
        *(
            (lambda one, name=name: sky.Raster(**{"path": "a.tif", name: one}), f"Raster.{name}", wrong)
            for name, wrong in OF_RASTERS.items()
        ),
        *(
            (lambda one, name=name: sky.Reading(**{name: one}), f"Reading.{name}", wrong)
            for name, wrong in OF_READING.items()
        ),
        *(
            (lambda one, name=name: sky.MissionOptions(**{name: one}), name, wrong)
            for name, wrong in OF_MISSIONS.items()
        ),
        (sky.build_scenario, "options", NOT_A_THING),
        (lambda one: sky.plan_mission(MAP1, options=one), "options", (*NOT_A_THING, {"shape": "x"}, sky.Raster("x"))),
        (lambda one: sky.MaxIterations(2) | one, "stop", (3, None, "MaxSeconds(1)")),
        (lambda one: sky.Conditions(vehicle=one), "vehicle", ("ufo", 3, ["camera"])),
        (sky.World, "scenario", NOT_A_THING),
        (lambda one: sky.find_conflicts(one, ()), "scenario", NOT_A_THING),
        (sky.routes, "mission", NOT_A_THING),
        (lambda one: sky.routes_apart(one, []), "mission", NOT_A_THING),
        (lambda one: sky.export(planned(), "x.csv", scenario=one), "scenario", NOT_A_THING[1:]),
        (lambda one: sky.export(planned(), "x.plan", page=one), "page", NOT_A_PATH[1:]),
        (lambda one: sky.certify(MAP1, one), "mission", NOT_A_THING),
        (sky.window_swap, "room", NOT_A_THING),
        *(
            (lambda one, name=name: sky.random_city(**{name: one}), name, (*NOT_A_NUMBER, -1.0))
            for name in ("ceiling", "clearance")
        ),
        (lambda one: sky.write_figures(one, "x"), "mission", NOT_A_THING),
        (lambda one: sky.write_figures(MAP1, one), "folder", NOT_A_PATH),
        (lambda one: sky.write(MAP1, one), "path", NOT_A_PATH),
        (sky.read_flight, "path", NOT_A_PATH),
        (sky.read_mission, "source", NOT_A_PATH),
        (sky.read_study, "path", NOT_A_PATH),
        (sky.read_track, "path", NOT_A_PATH),
    ],
)  # fmt: skip
def test_wrong_values_of_one_argument_are_refused_in_one_sentence(call, field, wrong):
    for one in wrong:
        with pytest.raises(sky.InputError) as refused:
            call(one)
        told = refused.value
        assert "\n" not in str(told)
        assert (told.sentence.field or "").partition("[")[0] == (field or ""), (one, str(told))


NOT_A_WORD = ("hover", None, 3, ["rtl"], object())
NOT_A_FLAG = ("no", None, 0, [True], np.True_)


@pytest.mark.parametrize("suffix", [".plan", ".waypoints", ".wpml.kmz", ".kml", ".csv"])
@pytest.mark.parametrize(
    ("field", "wrong"),
    [
        ("altitude", NOT_A_WORD),
        ("origin", (3, "x", (46.8, 9.85, 1500.0), object())),
        ("rate", (*NOT_A_NUMBER[1:], 0, -1.0)),
        ("radius", (*NOT_A_NUMBER, 0.0, -1.0, 1e6)),
        ("takeoff", (*NOT_A_NUMBER, -1.0)),
        ("end", NOT_A_WORD),
        ("return_altitude", (*NOT_A_NUMBER[1:], -1.0)),
        ("autopilot", ("mikrokopter", 3, ["px4"], object())),
        ("apart_in_space", NOT_A_FLAG),
        ("allow_close", NOT_A_FLAG),
        ("survey_item", NOT_A_FLAG),
    ],
)
def test_wrong_values_of_an_export_are_refused_in_one_sentence(mission, suffix, field, wrong, tmp_path):
    placed = {"origin": ORIGIN.model_copy(update={"geoid": 52.0})}
    for one in wrong:
        with pytest.raises(sky.InputError) as refused:
            sky.export(mission, tmp_path / f"x{suffix}", sky.ExportOptions(**placed | {field: one}))
        assert refused.value.sentence.field == field
        assert "\n" not in str(refused.value)
    assert not list(tmp_path.iterdir())


def test_every_field_of_an_export_is_tried_with_wrong_values():
    (tried,) = [
        mark.args[1]
        for mark in test_wrong_values_of_an_export_are_refused_in_one_sentence.pytestmark
        if mark.args[0] == ("field", "wrong")
    ]
    assert [field for field, _ in tried] == [one.name for one in dataclasses.fields(sky.ExportOptions)]


@pytest.mark.parametrize("t", [None, np.nan, [0.0, np.nan], [[1.0]], "now", [1, "a"], [[1.0], [1.0, 2.0]], object()])
def test_what_is_no_instant_is_refused(mission, t):
    motion = sky.CircularMotion(centre=(0, 0, 0), radius=1.0, period=3.0)
    moving = (motion, motion.as_periodic, sky.WaypointMotion(points=[(0, 0, 0)], times=[0.0]))
    for at in (mission.trajectory(0).at, mission.trajectory(0).heading, *(one.at for one in moving)):
        with pytest.raises(sky.InputError) as refused:
            at(t)
        assert refused.value.sentence.field == "t"


def test_one_instant_is_a_row_of_one(mission):
    flown = mission.trajectory("uav-1")
    assert flown.at(0).position.shape == flown.at(np.float32(0.0)).position.shape == (1, 3)
    np.testing.assert_array_equal(flown.at(np.inf).position, flown.at(flown.end).position)
    assert flown.duration == flown.end - flown.start


def test_parts_of_a_mission_are_found_by_index_and_by_name(mission, refuses):
    assert mission.trajectory("uav-1") is mission.trajectory(np.int64(0)) is mission.trajectories[0]
    assert mission.result("uav-1") is mission.results[0]
    assert mission.certificate("uav-1") is mission.certificates[0]
    assert mission.actions == mission.deconfliction.actions
    for column in (mission.result, mission.trajectory, mission.certificate):
        with refuses():
            column("uav-2")
    nobody = sky.plan_mission(MAP1.model_copy(update={"targets": ()}))
    for column in (nobody.result, nobody.trajectory, nobody.certificate):
        with refuses():
            column(0)


def test_a_mission_that_was_read_is_equal_to_the_one_that_was_written(mission, tmp_path):
    sky.write(mission, tmp_path / "mission.json")
    again = sky.read(tmp_path / "mission.json")
    assert again == mission
    assert again.apart is None
    assert pickle.loads(pickle.dumps(mission)) == copy.deepcopy(mission) == mission
    assert again != sky.plan_mission(MAP1, "astar")


def test_problems_are_equal_if_all_that_is_given_is():
    assert sky.Problem(sky.read("map1"), "uav-1", "target-1") == PROBLEM
    assert hash(sky.Problem(MAP1)) == hash(PROBLEM)
    assert sky.Problem(MAP1, departs=1.0) != PROBLEM
    assert sky.Problem(MAP1.model_copy(update={"clearance": 0.2})) != PROBLEM
    assert PROBLEM != MAP1


def test_a_misspelt_public_name_gets_a_suggestion():
    with pytest.raises(AttributeError, match="did you mean 'plan_mission'"):
        _ = sky.plan_misson
