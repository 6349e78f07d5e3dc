"""A warning has one wording, and is told by the verb that can do something about it, not by each that follows."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.caution import NO_UNIT, warning_of
from skyverse.space.mission_cautions import mission_cautions

rasterio = pytest.importorskip("rasterio", reason="terrain from rasters needs rasterio")
pytest.importorskip("pyproj", reason="building scenarios needs pyproj")

WARNED = warning_of("dem.tif", NO_UNIT.text)
PLAN = ("plan", "built.yaml", "--planner", "taut", "-o", "mission.json")


@pytest.fixture
def build(skyverse, tmp_path):
    """Return the words that build a scenario over terrain whose heights have no unit."""
    corner = rasterio.Affine(0.001, 0, 9.84, 0, -0.001, 46.82)
    grid = {"width": 20, "height": 20, "count": 1, "dtype": "float32", "crs": "EPSG:4326", "transform": corner}
    with rasterio.open(tmp_path / "dem.tif", "w", driver="GTiff", **grid) as raster:
        raster.write(np.full((1, 20, 20), 1500.0, np.float32))
    ends = ("--uav", "46.81,9.85,60 m agl", "--target", "46.811,9.85,60 m agl")
    return "scenario", "build", "--terrain", "dem.tif", *ends, "--vehicle", "camera", "-o", "built.yaml"


def test_a_warning_on_a_map_is_told_where_the_map_is_read_and_stays_on_pages(skyverse, build, tmp_path):
    code, out, err = skyverse(*build)
    assert code == 0, err
    ask = "give --terrain-unit m if they are or --terrain-unit ft to take them as feet"
    assert f"{WARNED}; {ask}\n" in out
    export = ("export", "mission.json", "mission.plan", "--altitude", "amsl", "--geoid", "50")
    for words in (PLAN, ("check", "mission.json"), export, ("show", "mission.json")):
        code, out, err = skyverse(*words)
        assert code == 0, err
        assert "unit" not in out + err
    assert WARNED in (tmp_path / "mission.html").read_text()
    assert WARNED in [caution.sentence for caution in mission_cautions(sky.read_mission(tmp_path / "mission.json"))]


def test_a_scenario_of_others_is_warned_of_where_it_is_planned(skyverse, build, tmp_path):
    skyverse(*build)
    theirs = sky.read_scenario(tmp_path / "built.yaml").model_copy(update={"built_with": ()})
    sky.write(theirs, tmp_path / "built.yaml")
    assert f"{WARNED}\n" in skyverse(*PLAN, "--no-page")[1]


def test_what_a_mission_is_warned_of_is_told_when_it_is_planned_and_judged_by_another_scenario(skyverse, tmp_path):
    zone = sky.Box(min=(3, 0, 0), max=(4, 4, 2), solid=False)
    scenario = sky.Scenario(
        name="over",
        bounds=sky.Bounds(min=(0, 0, 0), max=(8, 4, 4)),
        obstacles=[zone],
        clearance=0.25,
        uavs=[sky.UAV(start=(1, 1, 3))],
        targets=[sky.Target(position=(6, 1, 3))],
    )
    lower = scenario.model_copy(update={"obstacles": (zone.model_copy(update={"max": (4, 4, 1)}),)})
    sky.write(scenario, tmp_path / "built.yaml")
    sky.write(lower, tmp_path / "lower.yaml")
    said = "WARNING: uav-1 flies over the no-fly zone obstacles[0], {} m above its upper end"
    assert said.format(1) in skyverse(*PLAN, "--no-page")[1]
    assert "flies over" not in skyverse("check", "mission.json")[1]
    assert said.format(2) in skyverse("check", "mission.json", "--scenario", "lower.yaml")[1]
