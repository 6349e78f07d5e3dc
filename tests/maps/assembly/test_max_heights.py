"""Permitted heights: nothing above them is left open, as rasterio sees the ground and shapely the cells."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

rasterio = pytest.importorskip("rasterio", reason="building scenarios needs rasterio")
pyproj = pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
shapely = pytest.importorskip("shapely", reason="building scenarios needs shapely")

from rasterio.transform import Affine  # noqa: E402

import skyverse as sky  # noqa: E402
from of_maps import of_maps  # noqa: E402

LAT, LON = 46.8, 9.85
EAST, NORTH = 1 / 76_200, 1 / 111_200
"""Degrees that are about a metre."""


def cell(x, y, wide, deep, **fields):
    """Return a cell of which a corner lies so many metres east and north of the middle."""
    corners = [(x, y), (x + wide, y), (x + wide, y + deep), (x, y + deep), (x, y)]
    ring = [[LON + east * EAST, LAT + north * NORTH] for east, north in corners]
    return {"type": "Feature", "properties": fields, "geometry": {"type": "Polygon", "coordinates": [ring]}}


def written(folder, *cells):
    path = folder / "grid.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": cells}))
    return path


def built(path, notes=None, **options):
    area = (LON - 400 * EAST, LAT - 400 * NORTH, LON + 400 * EAST, LAT + 400 * NORTH)
    given_options = {"ground": sky.AboveSea(1000), "ceiling": sky.AboveGround(150), "area": area, **options}
    on_note = (lambda note: None) if notes is None else lambda note: notes.append(note.text)
    return of_maps("m", max_heights=[path], on_note=on_note, **given_options)


def shut(scenario, points):
    found = np.zeros(len(points), dtype=bool)
    for one in scenario.obstacles:
        inside = shapely.intersects_xy(shapely.Polygon(one.vertices, one.holes), *points[:, :2].T)
        found |= inside & (points[:, 2] >= one.low) & (points[:, 2] <= one.high)
    return found


def lowest_of(document, scenario, points):
    """Return the lowest height that the cells around points permit, infinite outside of all of them."""
    globe = sky.to_wgs84(scenario.frame.origin, points)
    least = np.full(len(points), np.inf)
    for one in json.loads(document.read_text())["features"]:
        inside = shapely.intersects_xy(shapely.geometry.shape(one["geometry"]), globe[:, 1], globe[:, 0])
        metres = one["properties"]["CEILING"] * {"Feet": 0.3048, "m": 1.0}[one["properties"]["UNIT"]]
        least[inside] = np.minimum(least[inside], metres)
    return least


def points_of(scenario, seed, many=4000):
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    return np.random.default_rng(seed).uniform(low, high, (many, 3))


cells = st.builds(
    cell,
    st.floats(-500, 300),
    st.floats(-500, 300),
    st.floats(20, 600),
    st.floats(20, 600),
    CEILING=st.sampled_from([0, 50, 100, 400]),
    UNIT=st.sampled_from(["Feet", "m"]),
)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(some=st.lists(cells, min_size=1, max_size=5), seed=st.integers(0, 2**31))
def test_over_level_ground_just_what_is_above_the_lowest_permitted_height_is_shut(tmp_path, some, seed):
    path = written(tmp_path, *some)
    scenario = built(path, tolerance=0.0)
    points = points_of(scenario, seed)
    above = points[:, 2] - (1000 - scenario.frame.origin.altitude) - lowest_of(path, scenario, points)
    found = shut(scenario, points)
    assert found[above > 1e-3].all()
    moved = [points + np.array([x, y, 0.0]) for x, y in ((0.02, 0), (-0.02, 0), (0, 0.02), (0, -0.02))]
    free = np.array(
        [at[:, 2] - (1000 - scenario.frame.origin.altitude) < lowest_of(path, scenario, at) for at in moved]
    )
    assert not found[(above < -1e-3) & free.all(axis=0)].any()


@pytest.fixture(scope="module")
def slope(tmp_path_factory):
    """A slope of one in four towards the east, with some roughness: 1000 m high in the middle."""
    path = tmp_path_factory.mktemp("maps") / "slope.tif"
    x, y = pyproj.Transformer.from_crs(4326, 32632, always_xy=True).transform(LON, LAT)
    heights = 1000 + 2.5 * (np.arange(120) - 60) + np.random.default_rng(5).uniform(-1, 1, (120, 120))
    to_map = Affine(10, 0, x - 600, 0, -10, y + 600)
    profile = {"driver": "GTiff", "width": 120, "height": 120, "count": 1, "dtype": "float32"}
    with rasterio.open(path, "w", crs="EPSG:32632", transform=to_map, **profile) as file:
        file.write(heights.astype("float32"), 1)
        file.update_tags(1, units="m")
    return path


def test_over_a_slope_no_pixel_is_flown_higher_above_than_permitted(tmp_path, slope):
    path = written(
        tmp_path, cell(-350, -350, 500, 700, CEILING=60, UNIT="m"), cell(150, -350, 200, 700, CEILING=0, UNIT="m")
    )
    notes = []
    scenario = built(path, notes, terrain=[slope], ground=None)
    points = points_of(scenario, 7)
    globe = sky.to_wgs84(scenario.frame.origin, points)
    with rasterio.open(slope) as file:
        to_map = pyproj.Transformer.from_crs(4326, file.crs, always_xy=True)
        at = np.column_stack(to_map.transform(globe[:, 1], globe[:, 0]))
        ground = np.array(list(file.sample(at.tolist())))[:, 0]
    height = globe[:, 2] - ground
    least = lowest_of(path, scenario, points)
    found = shut(scenario, points)
    assert found[height > least].all()
    # cells are divided until the ground below a part rises by 10 m or it is 50 m wide, which is 12.5 m on this slope
    beside = np.abs((globe[:, 1] - LON) / EAST - 150) < 1.0  # outlines grow by half a metre
    assert not found[np.isfinite(least) & (height < least - 12.5 - 5.0) & (height > 0) & ~beside].any()
    assert 20 < len(scenario.obstacles) < 300
    assert not np.isfinite(least).all()
    assert not found[np.isinf(least) & (np.abs(globe[:, 1] - LON) > 355 * EAST)].any()
    assert any("merged with others" in note for note in notes)


def test_cells_alike_become_one_and_the_scenario_says_where_they_come_from(tmp_path):
    notes = []
    row = [cell(100.0 * k, 0, 100.001, 100, CEILING=200, UNIT="Feet", name=f"c{k}") for k in range(-3, 3)]
    scenario = built(written(tmp_path, *row), notes)
    (one,) = scenario.obstacles
    assert one.kind == "airspace above the permitted height"
    assert not one.solid
    assert one.low == pytest.approx(200 * 0.3048, abs=1e-6)
    assert one.high > scenario.bounds.max[2]
    assert [source.gives for source in scenario.sources] == ["permitted heights"]
    assert any("6 outlines, 1 prism, 5 merged with others" in note for note in notes)


def test_what_does_not_say_a_permitted_height_is_refused(tmp_path, refuses):
    for fields in (
        {},
        {"CEILING": 400},
        {"CEILING": "400 ft", "floor": "0 ft"},
        {"floor": "50 m agl"},
        {"CEILING": -10, "UNIT": "Feet"},
        {"CEILING": "UNL"},
        {"CEILING": 400, "UNIT": "Feet", "reference": "AMSL"},
        {"CEILING": 400, "UNIT": "cubits"},
        {"height": "50 m"},
    ):
        with refuses():
            built(written(tmp_path, cell(0, 0, 100, 100, **fields)))
    for options in (
        {"ground": None, "ceiling": None},
        {"uavs": [(LAT + 50 * NORTH, LON + 50 * EAST, sky.AboveGround(70))]},
    ):
        with refuses():
            built(written(tmp_path, cell(0, 0, 100, 100, CEILING="60 m")), **options)


def test_the_example_of_the_documentation_runs(tmp_path, monkeypatch):
    text = (Path(__file__).parents[3] / "docs" / "maps.md").read_text(encoding="utf-8")
    (example,) = re.findall(
        r"```python\n(.*?)```", text.split("### Heights that are permitted")[1].split("### ")[0], re.DOTALL
    )
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "docs/maps.md", "exec"), {})
