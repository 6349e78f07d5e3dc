"""The verb ``survey``: it plans what `build_survey` builds; its help begins with what everybody needs; ``cameras``."""

import importlib
import json
import re

import pytest

import skyverse as sky

CORNERS = "9.85,46.8,0 9.852,46.8,0 9.852,46.801,0 9.85,46.801,0 9.85,46.8,0"
FIELD = (
    '<kml xmlns="http://www.opengis.net/kml/2.2"><Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>'
    f"{CORNERS}</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></kml>"
)
CAMERA = "13.2x8.8 mm, 5472x3648 px, 8.8 mm"
NEEDED = ["--camera", "--gsd", "--overlap", "--drones", "--battery", "--launch", "--output"]


def options_of(**changes):
    """What is known of the maps and UAVs of a field on level ground."""
    level = {"ground": sky.AboveSea(500.0), "vehicle": "camera", "max_height": sky.AboveGround(120.0)}
    return sky.BuildOptions("field", **(level | changes))


@pytest.fixture
def field(tmp_path, monkeypatch):
    """The file of a field, in the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "field.kml").write_text(FIELD)
    return "field.kml"


def test_the_command_line_plans_what_is_built_in_python(skyverse, field, monkeypatch):
    planned = []
    verb = importlib.import_module("skyverse.cli.survey")
    monkeypatch.setattr(verb, "plan_scenario", lambda scenario, *how: planned.append(scenario) or 0)
    words = ["--ground=500 m amsl", f"--camera={CAMERA}, 2.5 s", "--gsd=2 cm", "--overlap=75,65", "--drones=2"]
    assert skyverse("survey", field, *words, "--battery=20 min", "--launch=46.8005,9.8495")[0] == 0
    built = sky.build_survey(
        [field],
        options_of(battery="20 min"),
        uavs=2,
        launch=[(46.8005, 9.8495)],
        camera=f"{CAMERA}, 2.5 s",
        gsd="2 cm",
        overlap=(75, 65),
    )
    assert planned == [built]
    assert built.surveys[0].camera == sky.CAMERAS["phantom-4-rtk"].model_copy(update={"name": ""})
    hover = sky.VEHICLE_PROFILES["camera"].limits["hover_power"]
    assert [uav.battery for uav in built.uavs] == pytest.approx([hover / 3.0] * 2)
    (place,) = sky.to_wgs84(built.frame.origin, [built.uavs[0].start])[:, :2].tolist()
    assert place == pytest.approx((46.8005, 9.8495))


def test_without_seconds_between_photos_a_camera_is_as_slow_as_the_slowest_that_is_known():
    asked = {"area": [(0, 0), (9, 0), (9, 9)], "gsd": "2 cm"}
    own = sky.Survey(camera=CAMERA, **asked).camera
    assert own.min_interval == max(camera.min_interval for camera in sky.CAMERAS.values())
    assert sky.Survey(camera="13.2 x 8.8mm,5472x3648,8.8 mm", **asked).camera == own


@pytest.mark.parametrize(
    ("changes", "asked", "said"),
    [
        ({"ground": None}, {}, r"^terrain: expected a file of ground heights, found none; give ground"),
        ({}, {"uavs": 0}, r"^uavs: expected a whole number from 1 on"),
        ({}, {"launch": [(46.8,)]}, r"^launch\[0\]: expected 2 numbers"),
        ({}, {"gsd": None}, r"give gsd or height"),
        ({}, {"pattern": "corridor", "width": 20.0}, r"field.kml.*expected a line"),
    ],
)
def test_what_cannot_be_built_is_refused(field, changes, asked, said):
    with pytest.raises(sky.InputError, match=said):
        sky.build_survey([field], options_of(**changes), **({"camera": "mavic-3e", "gsd": "2 cm"} | asked))


def test_help_begins_with_what_everybody_needs(skyverse):
    _, out, _ = skyverse("survey", "--help")
    assert out.index("skyverse survey field.kml") < out.rindex("--camera STR")
    panel = re.search(r"╭─ Parameters ─+╮\n(.*?)╰", out, re.DOTALL)[1]
    assert re.findall(r"^│ \*? *(--[a-z-]+)", panel, re.MULTILINE) == NEEDED


def test_cameras_are_listed_on_narrow_lines(skyverse):
    code, out, _ = skyverse("cameras")
    assert code == 0
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 60
    assert [line.split()[0] for line in out.splitlines()[1:]] == list(sky.CAMERAS)
    _, out, _ = skyverse("cameras", "--json")
    assert {one["name"]: one["gsd_at_100_m"] for one in json.loads(out)} == {
        name: camera.gsd(100.0) for name, camera in sky.CAMERAS.items()
    }
