"""Fences never allow more than their areas, and hardly less, as PROJ, shapely and geodesics see the areas."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

pyproj = pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
shapely = pytest.importorskip("shapely", reason="building scenarios needs shapely")

import skyverse as sky  # noqa: E402
from of_maps import of_maps  # noqa: E402
from proj_map import proj_local  # noqa: E402
from skyverse.maps.assembly.fences import fence_area, fence_around, fence_circle  # noqa: E402

LAT, LON = 46.8, 9.85
DEGREES = np.array([1 / (111_200 * np.cos(np.radians(LAT))), 1 / 111_200])
"""Degrees east and north that are a metre, near enough to draw areas by."""
HALF = 400.0
"""Metres from the middle of the bounds to each side."""
ROUND = np.array([(np.cos(t), np.sin(t)) for t in np.linspace(0, 2 * np.pi, 16, endpoint=False)])


def ring(*metres):
    """Return corners, longitude and latitude, so many metres east and north of the middle, near enough."""
    return (np.array([LON, LAT]) + np.array(metres) * DEGREES).tolist()


def square(x, y, half):
    return ring((x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half))


def globe(points):
    """Return longitude and latitude of local places (n, 2), by PROJ."""
    to_map = pyproj.Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
        f"+step +proj=tmerc +ellps=WGS84 +lat_0={LAT!r} +lon_0={LON!r}"
    )
    return np.column_stack(to_map.transform(*np.asarray(points).T, direction="INVERSE"))


def blocked(prisms, points):
    solid = shapely.union_all([shapely.Polygon(one.vertices, one.holes) for one in prisms])
    return shapely.intersects_xy(solid, *np.asarray(points).T)


@st.composite
def areas(draw):
    """An area as what `fence_area` or `fence_circle` takes, and the same as a function of longitude and latitude."""
    place = st.floats(-500, 500)
    x, y, size = draw(place), draw(place), draw(st.floats(5, 600))
    if draw(st.booleans()):
        (longitude, latitude), geod = ring((x, y))[0], pyproj.Geod(ellps="WGS84")

        def near(at):
            n = len(at)
            return geod.inv(np.full(n, longitude), np.full(n, latitude), *at.T)[2] <= size

        return fence_circle(longitude, latitude, size, "a.plan: circle"), near
    corners = draw(st.lists(st.floats(0.3, 1.0), min_size=3, max_size=9))
    turns = np.linspace(0, 2 * np.pi, len(corners), endpoint=False)
    star = np.column_stack([np.cos(turns), np.sin(turns)]) * np.array(corners)[:, None]
    outline = ring(*((x, y) + size * star))
    holes = [ring(*((x, y) + 0.1 * size * star))] if draw(st.booleans()) else []
    polygon = shapely.Polygon(outline, holes)
    return fence_area(outline, holes, "a.plan: polygon"), lambda at: shapely.intersects_xy(polygon, *at.T)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    some=st.lists(areas(), min_size=1, max_size=4),
    rule=st.sampled_from(["union", "intersection"]),
    tolerance=st.sampled_from([0.0, 0.5, 3.0]),
    seed=st.integers(0, 2**31),
)
def test_a_fence_is_the_outside_of_its_areas(some, rule, tolerance, seed):
    bounds = sky.Bounds(min=(-HALF, -HALF, 0), max=(HALF, HALF, 100))
    origin = sky.Origin(latitude=LAT, longitude=LON, altitude=400)
    given_areas = [area for found, _ in some for area in found]

    def allowed(points):
        held = np.array([inside(globe(points)) for _, inside in some])
        return held.any(axis=0) if rule == "union" else held.all(axis=0)

    points = np.random.default_rng(seed).uniform(-HALF, HALF, (4000, 2))
    near = np.array([allowed(points + 0.02 * way) for way in ROUND])
    try:
        fence = fence_around(given_areas, origin, bounds, rule=rule, tolerance=tolerance)
    except sky.InputError:
        assert not allowed(points).any() or not np.array([allowed(points + 0.1 * way) for way in ROUND]).all(0).any()
        return
    shut = blocked(fence.prisms, points)
    assert shut[~near.any(axis=0)].all()
    assert not shapely.intersects_xy(fence.inside, *points[shut].T).any()
    deep = np.ones(len(points), dtype=bool)
    for reach in (0.05, 0.5, 1.2 + tolerance):  # a circle of 600 m loses 1 m
        deep &= np.array([allowed(points + reach * way) for way in ROUND]).all(axis=0)
    lost = shut & deep
    assert lost.sum() <= 0.002 * len(points)  # necks, and holes that nearly touch, may be lost
    assert all(one.low < 0 and one.high > 100 and not one.solid and one.kind == "fence" for one in fence.prisms)


def written(folder, *features, name="area.geojson"):
    path = folder / name
    made = [{"type": "Feature", "properties": fields, "geometry": shape} for shape, fields in features]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": made}))
    return path


def polygon(*rings, **fields):
    return {"type": "Polygon", "coordinates": [[*one, one[0]] for one in rings]}, fields


def flight(start, target, **options):
    places = [(*reversed(ring(at)[0]), sky.AboveGround(60)) for at in (start, target)]
    return {"ground": sky.AboveSea(400), "uavs": places[:1], "targets": places[1:], **options}


def test_areas_of_several_files_are_one_and_heights_in_them_do_not_count(tmp_path):
    first = written(tmp_path, polygon(square(0, 0, 200), square(0, 0, 50), CEILING=3, upper="20 m"))
    second = written(tmp_path, polygon(square(399.999, 0, 200)), name="second.geojson")
    options = flight((-150, 0), (500, 0), margin=300.0)
    scenario = of_maps("f", fences=[first, second], **options)
    points = proj_local(
        scenario.frame.origin,
        *np.array(ring((-180, 0), (0, 0), (45, 0), (200, 0), (590, 0), (610, 0), (0, 210)))[:, ::-1].T,
        0,
    )[:, :2]
    assert blocked(scenario.obstacles, points).tolist() == [False, True, True, False, False, True, True]
    low, high = scenario.bounds.min[2], scenario.bounds.max[2]
    assert all(one.low < low and one.high > high for one in scenario.obstacles)
    assert [(source.file, source.gives) for source in scenario.sources] == [
        ("area.geojson", "fence"),
        ("second.geojson", "fence"),
    ]
    mission = sky.plan_mission(scenario)
    assert sky.check(scenario, mission) == []
    (line,) = [result.path for result in mission.results]
    assert np.ptp(line[:, 1]) > 50.0  # around the hole


def test_a_fence_alone_says_where_the_scenario_is(tmp_path):
    path = written(tmp_path, polygon(square(0, 0, 200)))
    scenario = of_maps("f", fences=[path], ground=sky.AboveSea(400))
    assert np.abs(np.array([scenario.bounds.min, scenario.bounds.max])[:, :2]) == pytest.approx(200, abs=2)
    wide = of_maps("f", fences=[path], ground=sky.AboveSea(400), margin=100)
    assert np.array(wide.bounds.max[:2]) - scenario.bounds.max[:2] == pytest.approx(100, abs=1)


def test_a_fence_around_everything_shuts_nothing(tmp_path):
    path = written(tmp_path, polygon(square(0, 0, 2000)))
    assert of_maps("f", fences=[path], **flight((0, 0), (100, 0))).obstacles == ()


def test_a_circle_and_a_band_hold_no_more_than_they_say(tmp_path):
    point = {"type": "Point", "coordinates": ring((0, 0))[0]}
    line = {"type": "LineString", "coordinates": ring((0, 0), (300, 0))}
    path = written(tmp_path, (point, {"radius": "100 m"}), (line, {}))
    scenario = of_maps("f", fences=[path], reading=sky.Reading(buffer=20), **flight((0, 0), (200, 0)))
    geod, (longitude, latitude) = pyproj.Geod(ellps="WGS84"), ring((0, 0))[0]
    (end_longitude, end_latitude), turns = ring((300, 0))[0], np.arange(110, 431, 10)

    def at(places):
        longitudes, latitudes = np.array(places).T
        return proj_local(scenario.frame.origin, latitudes, longitudes, 0)[:, :2]

    for metres, shut in ((0.01, True), (-1.0, False)):
        circle = [geod.fwd(longitude, latitude, turn, 100 + metres)[:2] for turn in turns]
        beside = [geod.fwd((longitude + end_longitude) / 2, latitude, turn, 20 + metres)[:2] for turn in (0, 180)]
        ahead = [geod.fwd(end_longitude, end_latitude, turn, 20 + metres)[:2] for turn in (60, 90, 120)]
        assert (blocked(scenario.obstacles, at([*circle, *beside, *ahead])) == shut).all()


def test_refusals_name_the_file_or_the_point(tmp_path, refuses):
    area = written(tmp_path, polygon(square(0, 0, 200), square(0, 0, 50)))
    line = {"type": "LineString", "coordinates": ring((0, 0), (10, 0))}, {}
    bow = {"type": "Polygon", "coordinates": [ring((0, 0), (10, 10), (10, 0), (0, 10), (0, 0))]}, {}
    for points in (((-100, 0), (230, 0)), ((0, 10), (100, 0)), ((-197, 0), (100, 0)), ((-100, 0), (52, 0))):
        with refuses():
            of_maps("f", fences=[area], **flight(*points))
    for shape in (line, bow, polygon(ring((0, 0), (5, 0), (10, 0))), polygon(square(0, 0, 0.001))):
        with refuses():
            of_maps("f", fences=[written(tmp_path, shape, name="odd.geojson")], **flight((0, 0), (100, 0)))
    swapped = written(tmp_path, polygon([corner[::-1] for corner in square(0, 0, 200)]), name="swapped.geojson")
    for path in (swapped, written(tmp_path, polygon(square(5000, 0, 200)), name="far.geojson")):
        with refuses():
            of_maps("f", fences=[path], **flight((0, 0), (100, 0)))


@pytest.mark.parametrize(
    "wrong", [{"fences": "area.kml"}, {"fences": [3]}, {"fences": ["area.dxf"]}, {"fences": ["none.kml"]}]
)
def test_files_that_are_none_are_refused(wrong, refuses):
    with refuses():
        of_maps("f", **wrong, **flight((0, 0), (100, 0)))


def test_areas_of_other_rooms_are_checked(refuses):
    for outline, holes in (
        ([(9, 47), (9, 48)], []),
        ([(9, 97), (9, 48), (8, 47)], []),
        (square(0, 0, 9), [square(9, 0, 5)]),
    ):
        with refuses():
            fence_area(np.array(outline), [np.array(hole) for hole in holes], "a.plan: polygon 1")
    for radius in (0, -5.0, np.nan, 0.02):
        with refuses():
            fence_circle(LON, LAT, radius, "a.plan: circle 1")
    bounds, origin = sky.Bounds(min=(0, 0, 0), max=(99, 99, 9)), sky.Origin(latitude=LAT, longitude=LON, altitude=0)
    apart = [
        *fence_circle(*ring((0, 0))[0], 20.0, "a.plan: circle 1"),
        *fence_circle(*ring((60, 0))[0], 20.0, "a.plan: circle 2"),
    ]
    assert fence_around(apart, origin, bounds).prisms
    with refuses():
        fence_around(apart, origin, bounds, rule="intersection")


def test_areas_to_stay_out_of_are_covered(refuses):
    """Circles by geodesics; an outline that crosses itself, by either rule of what is inside of it."""
    bounds, origin = sky.Bounds(min=(-99, -99, 0), max=(99, 99, 9)), sky.Origin(latitude=LAT, longitude=LON, altitude=0)
    geod, (longitude, latitude) = pyproj.Geod(ellps="WGS84"), ring((0, 0))[0]
    for radius in (0.02, 5.0, 60.0):
        kept_out = fence_circle(longitude, latitude, radius, "a.plan: circle 1", outside=True)
        fence = fence_around([], origin, bounds, outside=kept_out)
        at = np.array([geod.fwd(longitude, latitude, turn, radius)[:2] for turn in range(0, 360, 3)])
        assert blocked(fence.prisms, proj_local(origin, *at[:, ::-1].T, 0)[:, :2]).all()
        at = np.array([geod.fwd(longitude, latitude, turn, 1.002 * radius + 0.8)[:2] for turn in range(0, 360, 3)])
        assert not blocked(fence.prisms, proj_local(origin, *at[:, ::-1].T, 0)[:, :2]).any()
    star = ring(*(50 * np.array([(np.sin(0.8 * np.pi * k), np.cos(0.8 * np.pi * k)) for k in range(5)])))
    pentagram = fence_around([], origin, bounds, outside=fence_area(np.array(star), [], "a.plan", outside=True))
    assert blocked(pentagram.prisms, [(0, 0), (0, 30)]).all()
    with refuses():
        fence_area(np.array(star), [], "a.plan: polygon 1")


def test_the_example_of_the_documentation_runs(tmp_path, monkeypatch):
    text = (Path(__file__).parents[3] / "docs" / "maps.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", text.split("### Fences")[1].split("### ")[0], re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "docs/maps.md", "exec"), {})
    assert len(sky.read_scenario("field.yaml").obstacles) == 2
