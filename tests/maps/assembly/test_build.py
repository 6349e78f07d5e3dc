"""Scenarios of maps: everything that a file has is inside of what the scenario has, as PROJ and shapely see it."""

import json
import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

rasterio = pytest.importorskip("rasterio", reason="building scenarios needs rasterio")
pyproj = pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
shapely = pytest.importorskip("shapely", reason="building scenarios needs shapely")

from rasterio.transform import Affine  # noqa: E402
from scipy.ndimage import map_coordinates  # noqa: E402

import skyverse as sky  # noqa: E402
from of_maps import of_maps  # noqa: E402
from proj_map import proj_local  # noqa: E402
from skyverse.cli import main  # noqa: E402
from skyverse.maps.assembly.obstacles import ROUNDING, LocalFeatures, prisms  # noqa: E402
from skyverse.maps.georeference.feature import Feature  # noqa: E402
from skyverse.space.mission_cautions import mission_cautions  # noqa: E402

DATA = Path(os.environ.get("SKYVERSE_DATA", Path(__file__).parents[4] / "shared" / "data"))
LAT, LON = 46.8, 9.85
DEGREE = 111_200.0


def place(east, north, altitude):
    """Return a place so many metres from the middle of the valley, near enough."""
    return LAT + north / DEGREE, LON + east / (DEGREE * np.cos(np.radians(LAT))), altitude


@pytest.fixture(scope="module")
def valley(tmp_path_factory):
    """A slope of one in ten towards the east, with some roughness: 2.4 km wide, 1500 m high in the middle."""
    path = tmp_path_factory.mktemp("maps") / "valley.tif"
    x, y = pyproj.Transformer.from_crs(4326, 32632, always_xy=True).transform(LON, LAT)
    rng = np.random.default_rng(5)
    heights = 1500 + 2.0 * (np.arange(120) - 60) + rng.uniform(-1, 1, (120, 120))
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=120,
        height=120,
        count=1,
        dtype="float32",
        crs="EPSG:32632",
        transform=Affine(20, 0, x - 1200, 0, -20, y + 1200),
    ) as file:
        file.write(heights.astype("float32"), 1)
        file.update_tags(TIFFTAG_COPYRIGHT="CC-BY, the surveyors")
    return path


def outline(*corners):
    ring = [place(east, north, 0)[1::-1] for east, north in corners]
    return {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}


def geojson(path, *features, **more):
    listed = [{"type": "Feature", "properties": fields, "geometry": shape} for shape, fields in features]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": listed, **more}))
    return path


SQUARE = outline((-50, -50), (50, -50), (50, 50), (-50, 50))
START, GOAL = place(-300, 0, sky.AboveGround(60)), place(300, 50, sky.AboveGround(60))


def test_uavs_and_targets_are_where_they_were_said_to_be_in_each_frame(valley):
    scenario = of_maps(
        "valley",
        terrain=[valley],
        uavs={"sea": place(-300, 0, sky.AboveSea(1600)), "ground": START, "home": place(100, -80, sky.AboveHome(30))},
        targets=[GOAL],
        ground_clearance=20,
    )
    origin = scenario.frame.origin
    starts = {uav.name: uav.start for uav in scenario.uavs}
    lat, lon, altitude = place(-300, 0, sky.AboveSea(1600))
    assert starts["sea"] == pytest.approx(proj_local(origin, lat, lon, altitude.metres)[0], abs=1e-3)
    x, y, z = starts["ground"]
    assert z - scenario.terrain.height((x, y)) == pytest.approx(60, abs=1e-3)
    assert sky.to_wgs84(origin, starts["home"])[0, 2] == pytest.approx(surveyed(valley, *place(100, -80, 30)), abs=1e-3)
    assert sky.to_wgs84(origin, starts["home"])[0, :2] == pytest.approx(place(100, -80, 0)[:2], abs=1e-8)
    assert scenario.targets[0].name == "target-1"
    assert scenario.sources[0].licence == "CC-BY, the surveyors"
    assert scenario.sources[0].crs == "EPSG:32632"
    assert scenario.terrain.heights.min() >= 0
    assert scenario.terrain.heights.min() < 1


def surveyed(path, latitude, longitude, above=0.0):
    """The height of a raster at a place by SciPy, bilinear between pixels' centres."""
    with rasterio.open(path) as file:
        heights = file.read(1).astype(float)
        x, y = pyproj.Transformer.from_crs(4326, file.crs, always_xy=True).transform(longitude, latitude)
        column, row = ~file.transform @ (x, y)
    return float(map_coordinates(heights, [[row - 0.5], [column - 0.5]], order=1)[0]) + above


def homes(scenario):
    """Where UAVs stand, metres above mean sea level."""
    points = [(*uav.start[:2], uav.home) for uav in scenario.uavs]
    return sky.to_wgs84(scenario.frame.origin, points)[:, 2]


def test_a_uav_stands_on_the_rasters_ground_not_on_the_raised_one(valley):
    rng = np.random.default_rng(3)
    places = [place(*rng.uniform(-800, 800, 2), sky.AboveGround(40)) for _ in range(40)]
    near = {"separation": 1.0, "tracking_error": (0.0, 0.0)}
    scenario = of_maps("v", terrain=[valley], uavs=places, terrain_step=60, **near)
    expected = [surveyed(valley, latitude, longitude) for latitude, longitude, _ in places]
    assert homes(scenario) == pytest.approx(expected, abs=1e-4)
    raised = [scenario.terrain.height(uav.start[:2]) - uav.home for uav in scenario.uavs]
    assert np.mean(raised) > 0.5


@pytest.mark.skipif(not (DATA / "davosdorf.tif").is_file(), reason="the terrain of Davos is not here")
def test_in_davos_too_home_is_the_rasters_ground():
    path, rng = DATA / "davosdorf.tif", np.random.default_rng(4)
    south, north, west, east = 46.80, 46.83, 9.80, 9.86
    places = [(rng.uniform(south, north), rng.uniform(west, east), sky.AboveGround(60)) for _ in range(60)]
    scenario = of_maps("davos", terrain=[path], uavs=places)
    assert homes(scenario) == pytest.approx([surveyed(path, *at[:2]) for at in places], abs=0.02)  # PROJ's grids
    raised = [scenario.terrain.height(uav.start[:2]) - uav.home for uav in scenario.uavs]
    assert max(raised) > 1


def test_home_is_of_the_higher_file_in_metres_above_the_sea_and_unknown_beside_holes(valley, tmp_path):
    with rasterio.open(valley) as file:
        heights, profile = file.read(1), file.profile

    def changed(name, values, **more):
        with rasterio.open(tmp_path / name, "w", **{**profile, **more}) as file:
            file.write(values.astype("float32"), 1)
        return tmp_path / name

    feet = changed("feet.tif", (heights + 5) / 0.3048)
    both = of_maps("v", terrain=[valley, sky.Raster(feet, unit="ft")], uavs=[START])
    assert homes(both)[0] == pytest.approx(surveyed(valley, *START[:2], 5), abs=1e-3)
    ellipsoid = changed("e.tif", heights + 50, crs=pyproj.CRS("EPSG:32632").to_3d().to_wkt())
    above = of_maps("v", terrain=[ellipsoid], uavs=[START], geoid=50.0)
    assert homes(above)[0] == pytest.approx(surveyed(valley, *START[:2]), abs=1e-3)
    holed = np.where(np.indices(heights.shape)[1] < 50, -9999, heights)  # START is there
    hole = changed("hole.tif", holed, nodata=-9999)
    assert of_maps("v", terrain=[hole], uavs=[START], fill_nodata=1500.0).uavs[0].home is None
    assert of_maps("v", ground=sky.AboveSea(1500), uavs=[START]).uavs[0].home is None


corner = st.tuples(st.floats(-400, 400), st.floats(-400, 400))
low = st.sampled_from([None, "1490 m amsl", "20 m agl", "1650 m amsl"])
high = st.sampled_from([None, "1700 m amsl", "90 m agl", "400 ft agl"])


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25, deadline=None)
@given(
    corners=st.lists(corner, min_size=3, max_size=9),
    low=low,
    high=high,
    tolerance=st.sampled_from([0, 0.5, 20]),
    seed=st.integers(0, 99),
)
def test_what_is_in_a_zone_is_in_its_prisms(valley, tmp_path, corners, low, high, tolerance, seed):
    shape = shapely.MultiPoint(corners).convex_hull
    if shape.geom_type != "Polygon" or shape.area < 1 or (low == "1650 m amsl" and high and "agl" in high):
        return
    fields = {"lower": low, "upper": high}
    path = geojson(tmp_path / "zones.geojson", (outline(*shape.exterior.coords[:-1]), fields))
    scenario = of_maps(
        "valley", terrain=[valley], zones=[path], area=(*place(-400, -100, 0)[1::-1], *place(400, 150, 0)[1::-1]),
        tolerance=tolerance,
    )  # fmt: skip
    origin, bounds = scenario.frame.origin, scenario.bounds
    rng = np.random.default_rng(seed)
    west, south, east, north = shape.bounds
    spots = rng.uniform([west, south], [east, north], (300, 2))
    spots = spots[shapely.contains_xy(shape, *spots.T)]
    if not len(spots):
        return
    lat, lon, _ = place(*spots.T, 0)
    flat = sky.to_local(origin, np.column_stack([lat, lon, np.full(len(lat), origin.altitude)]))
    ground = scenario.terrain.height(flat[:, :2])
    sea = sky.to_wgs84(origin, np.column_stack([flat[:, :2], ground]))[:, 2]

    def altitude(text, otherwise):
        if text is None:
            return np.full(len(sea), otherwise) if np.isscalar(otherwise) else otherwise
        number, unit, frame = text.split()
        metres = float(number) * (0.3048 if unit == "ft" else 1)
        return np.full(len(sea), metres) if frame == "amsl" else sea + metres

    bottom, top = altitude(low, sea), altitude(high, 3000.0)
    points = sky.to_local(origin, np.column_stack([lat, lon, bottom + rng.uniform(0, 1, len(sea)) * (top - bottom)]))
    inside = np.all((points > bounds.min) & (points < bounds.max), axis=1) & (top > bottom)
    inside &= points[:, 2] > ground
    hit = np.zeros(len(points), dtype=bool)
    for prism in scenario.obstacles:
        polygon = shapely.Polygon(prism.vertices, prism.holes)
        hit |= shapely.covers(polygon, shapely.points(points[:, :2])) & (
            (points[:, 2] >= prism.low - 1e-6) & (points[:, 2] <= prism.high + 1e-6)
        )
    assert hit[inside].all()


@pytest.mark.parametrize(
    ("east", "north", "altitude", "safe"),
    [
        (0, 0, sky.AboveSea(1540), False),
        (51, 0, sky.AboveSea(1540), False),  # nearer than the clearance
        (51.9, 51.9, sky.AboveSea(1540), True),  # though 1.9 m from both sides
        (53, 0, sky.AboveSea(1540), True),
        (0, 0, sky.AboveSea(1591), False),
        (0, 0, sky.AboveSea(1593), True),
        (-20, 10, sky.AboveSea(1540), True),  # in its court
        (-31, 10, sky.AboveSea(1540), False),
    ],
)
def test_a_start_or_target_in_a_zone_or_near_it_is_refused_by_both_names(
    valley, tmp_path, east, north, altitude, safe, refuses
):
    court = outline((-30, 0), (-10, 0), (-10, 20), (-30, 20))["coordinates"]
    shape = {"type": "Polygon", "coordinates": SQUARE["coordinates"] + court}
    zone = geojson(tmp_path / "z.geojson", (shape, {"upper": "1590 m amsl", "name": "Castle"}))
    options = {"terrain": [valley], "zones": [zone], "tolerance": 0, "tracking_error": (0.0, 0.0), "clearance": 2.0}
    at = place(east, north, altitude)
    for ends in ({"uavs": {"alpha": at}}, {"uavs": [START], "targets": {"alpha": at}}):
        if safe:
            of_maps("v", **ends, **options)
            continue
        with refuses():
            of_maps("v", **ends, **options)


def test_a_building_stands_on_the_lowest_ground_and_ends_above_the_highest(valley, tmp_path):
    path = geojson(tmp_path / "b.geojson", (SQUARE, {"height": "12 m", "name": "town hall"}), license="CC0")
    scenario = of_maps("valley", terrain=[valley], buildings=[path], uavs=[START], targets=[GOAL], tolerance=0)
    (prism,) = scenario.obstacles
    x, y = (at.ravel() for at in np.meshgrid(np.linspace(-49, 49, 40), np.linspace(-49, 49, 40)))
    middle = sky.to_local(scenario.frame.origin, [LAT, LON, 1500])[0]
    ground = scenario.terrain.height(np.column_stack([x + middle[0], y + middle[1]]))
    assert ground.min() - 3 < prism.low <= ground.min()
    assert ground.max() + 12 <= prism.high < ground.max() + 15
    assert (prism.name, prism.kind) == ("town hall", "building")
    assert scenario.sources[1].gives == "buildings"
    assert scenario.sources[1].licence == "CC0"


def test_soft_zones_carry_their_risk_and_no_end_reaches_past_the_bounds(valley, tmp_path):
    path = geojson(tmp_path / "z=1.geojson", (SQUARE, {"lower": "0 m agl", "name": "school"}))
    told = []
    scenario = of_maps(
        "valley", terrain=[valley], soft_zones=[(path, 0.5)], uavs=[START], targets=[GOAL], on_note=told.append
    )
    (zone,) = scenario.zones
    assert zone.risk == 0.5
    assert zone.high > scenario.bounds.max[2]
    assert scenario.obstacles == ()
    assert any("1 outline, 1 prism" in note.text for note in told)


def test_zones_with_latitude_first_are_not_dropped_as_lying_elsewhere(valley, tmp_path, refuses):
    (ring,) = SQUARE["coordinates"]
    turned = {"type": "Polygon", "coordinates": [[corner[::-1] for corner in ring]]}
    path = geojson(tmp_path / "z.geojson", (turned, {"upper": "90 m agl"}))
    with refuses():
        of_maps("valley", terrain=[valley], zones=[path], uavs=[START], targets=[GOAL])


def test_what_lies_outside_is_dropped_and_what_crosses_the_edge_is_cut(valley, tmp_path):
    far = outline((700, 0), (720, 0), (710, 20))
    long = outline((-5000, 90), (5000, 90), (5000, 110), (-5000, 110))
    path = geojson(tmp_path / "z.geojson", (far, {"upper": "90 m agl"}), (long, {"upper": "90 m agl"}))
    told = []
    scenario = of_maps(
        "valley", terrain=[valley], zones=[path], uavs=[START], targets=[GOAL], margin=100, on_note=told.append
    )
    (prism,) = scenario.obstacles
    xs = [x for x, _ in prism.vertices]
    assert min(xs) < scenario.bounds.min[0] - scenario.clearance
    assert max(xs) < scenario.bounds.max[0] + 30
    assert any("1 outside, 1 cut at the edge of the area" in note.text for note in told)


def test_buildings_that_touch_become_one_unless_they_are_to_stay_as_they_are(valley, tmp_path):
    row = [
        (outline((k * 10, 0), (k * 10 + 10, 0), (k * 10 + 10, 10), (k * 10, 10)), {"height": "9 m"}) for k in range(4)
    ]
    path = geojson(tmp_path / "b.geojson", *row)
    options = {"terrain": [valley], "buildings": [path], "uavs": [START], "targets": [GOAL]}
    assert len(of_maps("v", **options, tolerance=0).obstacles) == 4
    assert len(of_maps("v", **options, tolerance=5).obstacles) == 1


@pytest.mark.parametrize("width", [2e-4, 4e-4, 9e-4])
def test_what_is_thinner_than_a_grain_becomes_a_thin_prism(width):
    sliver = shapely.box(0, 0, 10, width)
    court = shapely.Polygon(shapely.box(20, 0, 40, 20).exterior, [shapely.box(25, 5, 25 + width, 15).exterior])
    features = [Feature(np.zeros((3, 2)), (), None, None, "zone", False, None, "z") for _ in range(2)]
    made, _ = prisms(LocalFeatures([sliver, court], features, np.zeros(2), np.ones(2)))
    for prism, outline in zip(made, (sliver, court), strict=True):
        polygon = shapely.Polygon(prism.vertices, prism.holes)
        assert polygon.buffer(ROUNDING / 2 + 1e-9, join_style="mitre").covers(outline)
        assert polygon.bounds == pytest.approx(outline.bounds, abs=3 * ROUNDING)


def test_outlines_of_thousands_of_corners_lose_some_even_if_all_are_to_stay_as_they_are(valley, tmp_path):
    turn = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    lake = outline(*(100 * np.column_stack([np.cos(turn), np.sin(turn)])))
    path, told = geojson(tmp_path / "z.geojson", (lake, {"upper": "90 m agl"})), []
    options = {"terrain": [valley], "uavs": [START], "targets": [GOAL], "on_note": told.append}
    (prism,) = of_maps("v", zones=[path], tolerance=0, **options).obstacles
    assert len(prism.vertices) <= 1000
    assert 100**2 * np.pi - 1 < shapely.Polygon(prism.vertices).area < 101**2 * np.pi
    assert any("of more than 1000 corners, simplified by 0.0" in note.text for note in told)


@pytest.mark.parametrize(
    "options",
    [
        {"uavs": {"low": place(0, 0, sky.AboveGround(1))}},
        {"uavs": [place(0, 0, sky.AboveSea(1400))]},
        {"uavs": {"far": (46.9, 9.85, sky.AboveGround(60))}},
        {"uavs": [START], "targets": [place(0, 900, GOAL[2])], "area": (9.843, 46.796, 9.857, 46.804)},
        {"uavs": {"turned": (9.85, 46.8, sky.AboveGround(60))}},
        {"uavs": {"odd": (146.8, 9.85, sky.AboveGround(60))}},
        {"uavs": {"bare": (46.8, 9.85, 60)}},
        {"uavs": [START, START], "targets": [place(0, 0, sky.AboveHome(60))]},
        {"uavs": [START], "ceiling": sky.AboveSea(1000)},
        {"uavs": [START], "ceiling": sky.AboveGround(1)},
        {"uavs": [START], "ceiling": sky.AboveGround(90), "max_height": sky.AboveGround(80)},
        {"uavs": [START], "ceiling": sky.AboveHome(100)},
        {"uavs": [START], "margin": 5000},
        {"uavs": [START], "margin": 100, "area": (9.84, 46.79, 9.86, 46.81)},
        {"area": (46.79, 9.84, 46.81, 9.86)},
        {"area": (9.835, 46.79, 9.88, 46.81)},
        {"area": (9.86, 46.79, 9.84, 46.81)},
        {"uavs": [START], "origin": sky.Origin(latitude=9.85, longitude=46.8, altitude=1500)},
        {"area": (9.86, 46.81, 9.84, 46.79)},
        {"area": (9.84, 146.79, 9.86, 146.81)},
        {"uavs": [START], "ground": sky.AboveSea(0)},
        {"uavs": [START], "clearance": -1.0},
        {"uavs": [START], "clearance": 1000000000.0},
        {"uavs": [START], "lattice_step": 0.0},
        {"uavs": [START], "terrain_step": float("nan")},
        {"uavs": [START], "lattice_step": 0.01},
        {"uavs": [START], "band": (80, 40)},
        {"uavs": [START], "licences": {"no.tif": "x"}},
        {"uavs": [START], "zones": ["none.geojson"]},
        {"uavs": [START], "zones": ["zones.xyz"]},
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(valley, options, refuses):
    with refuses():
        of_maps("valley", terrain=[valley], **options)


def test_heights_above_ground_need_the_ground_and_above_home_a_home(valley, tmp_path, refuses):
    path = geojson(tmp_path / "z.geojson", (SQUARE, {"upper": "90 m agl"}))
    start = [place(-300, 0, sky.AboveSea(1600))]
    with refuses():
        of_maps("flat", zones=[path], uavs=start)
    with refuses():
        of_maps("flat", uavs=[START])
    flat = of_maps("flat", zones=[path], uavs=start, ground=sky.AboveSea(1500))
    assert sky.to_wgs84(flat.frame.origin, [0, 0, flat.obstacles[0].high])[0, 2] == pytest.approx(1590, abs=0.1)
    home = geojson(tmp_path / "h.geojson", (SQUARE, {"upper": "90 m home"}))
    with refuses():
        of_maps("v", terrain=[valley], zones=[home], uavs=[START])
    with refuses():
        of_maps("nothing")


def test_an_area_across_the_antimeridian_is_one(tmp_path):
    path = tmp_path / "z.geojson"
    ring = [[179.99, -16.81], [180.01, -16.81], [180.01, -16.79], [179.99, -16.79], [179.99, -16.81]]
    geojson(path, ({"type": "Polygon", "coordinates": [ring]}, {"lower": "0 m amsl", "upper": "90 m amsl"}))
    scenario = of_maps("fiji", zones=[path], area=(179.95, -16.85, -179.95, -16.75), ground=sky.AboveSea(0))
    assert abs(scenario.frame.origin.longitude) == pytest.approx(180)
    wide = 0.1 * DEGREE * np.cos(np.radians(16.8))
    assert scenario.bounds.max[0] - scenario.bounds.min[0] == pytest.approx(wide, rel=0.01)
    (prism,) = scenario.obstacles
    xs = [x for x, _ in prism.vertices]
    assert min(xs) < -1000 < 1000 < max(xs) < 1100


def test_without_area_and_uavs_all_of_the_terrain_is_taken(valley):
    scenario = of_maps("valley", terrain=[valley])
    sizes = np.subtract(scenario.bounds.max, scenario.bounds.min)
    assert (sizes[:2] > 2300).all()
    assert (sizes[:2] < 2400).all()
    nodes = np.prod(sizes / scenario.lattice.step + 1)
    assert nodes <= 2e6


def test_an_origin_that_is_given_is_kept(valley):
    origin = sky.Origin(latitude=46.79, longitude=9.84, altitude=1234.5, geoid=50.0)
    scenario = of_maps("valley", terrain=[valley], uavs=[START], targets=[GOAL], origin=origin)
    usual = of_maps("valley", terrain=[valley], uavs=[START], targets=[GOAL], geoid=50.0)
    assert scenario.frame.origin == origin
    altitudes = [sky.to_wgs84(s.frame.origin, s.uavs[0].start)[0, 2] for s in (scenario, usual)]
    assert altitudes[0] == pytest.approx(altitudes[1], abs=1.5)  # their grids differ, and are raised differently


def test_a_geoid_goes_with_an_origin_that_has_none_and_not_with_another(valley, refuses):
    origin = sky.Origin(latitude=46.79, longitude=9.84, altitude=1234.5)
    options = {"terrain": [valley], "uavs": [START], "geoid": 50.0}
    assert of_maps("v", origin=origin, **options).frame.origin.geoid == 50.0
    with refuses():
        of_maps("v", origin=origin.model_copy(update={"geoid": 48.0}), **options)


def test_files_of_one_name_have_their_own_licences(valley, tmp_path, refuses):
    paths = []
    for folder in "ab":
        (tmp_path / folder).mkdir()
        paths.append(geojson(tmp_path / folder / "z.geojson", (SQUARE, {"upper": "90 m agl"})))
    options = {"terrain": [valley], "zones": paths, "uavs": [START]}
    made = of_maps("v", **options, licences={str(paths[1]): "CC0", "valley.tif": "mine"})
    assert [(s.file, s.licence) for s in made.sources] == [
        ("valley.tif", "mine"), ("z.geojson", ""), ("z.geojson", "CC0")
    ]  # fmt: skip
    with refuses():
        of_maps("v", **options, licences={"z.geojson": "CC0"})


def test_a_missing_extra_is_told_with_the_line_that_installs_it(valley, monkeypatch, refuses):
    monkeypatch.setitem(sys.modules, "rasterio", None)
    with refuses():
        of_maps("valley", terrain=[valley], uavs=[START])


def command(*words):
    with pytest.raises(SystemExit) as ended:
        main(["scenario", "build", *map(str, words)])
    return ended.value.code or 0


def test_several_files_may_follow_one_option(valley, tmp_path):
    first = geojson(tmp_path / "a.geojson", (SQUARE, {"upper": "50 m agl"}))
    second = geojson(tmp_path / "b.geojson", (outline((80, 0), (99, 0), (99, 9)), {"upper": "50 m agl"}))
    start = f"{START[0]},{START[1]},60 m agl"
    options = ["--terrain", valley, "--uav", start, "-o", tmp_path / "v.yaml", "--margin", "500"]
    options += ["--licence", "a.geojson=A", "b.geojson=B"]
    assert command(*options, "--zones", first, second) == 0
    made = sky.read_scenario(tmp_path / "v.yaml")
    assert len(made.obstacles) == 2
    assert [source.licence for source in made.sources[1:]] == ["A", "B"]
    assert command(*options, "--zones", first, "--zones", second) == 0
    assert sky.read_scenario(tmp_path / "v.yaml") == made


def test_a_folder_that_is_not_there_is_made_as_by_the_other_verbs(valley, tmp_path):
    assert command("--terrain", valley, "--uav", f"{START[0]},{START[1]},60 m agl", "-o", tmp_path / "a/b/v.yaml") == 0
    assert (tmp_path / "a/b/v.yaml").is_file()


def test_the_command_writes_what_is_read_back_equal(valley, tmp_path, capsys):
    zones = geojson(tmp_path / "z.geojson", (SQUARE, {"upper": "50 m agl"}))
    out = tmp_path / "valley.yaml"
    start, goal = place(-300, 0, 0), place(300, 50, 0)
    code = command(
        "--terrain", valley, "--zones", zones, "--uav", f"alpha={start[0]},{start[1]},60 m agl",
        "--target", f"{goal[0]},{goal[1]},200 ft agl", "--band", "40,80", "--licence", f"{zones}=mine: free=yes",
        "-o", out,
    )  # fmt: skip
    assert code == 0
    said = capsys.readouterr().out
    assert "z.geojson: 1 outline, 1 prism" in said
    assert "raised" in said
    scenario = sky.read_scenario(out)
    assert scenario.uavs[0].name == "alpha"
    assert scenario.sources[1].licence == "mine: free=yes"
    again = of_maps(
        "valley",
        terrain=[valley],
        zones=[zones],
        uavs={"alpha": (start[0], start[1], sky.AboveGround(60))},
        targets=[(goal[0], goal[1], sky.AboveGround(200 * 0.3048))],
        band=(40, 80),
        licences={"z.geojson": "mine: free=yes"},
    )
    assert scenario.model_copy(update={"built_with": ()}) == again


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--uav", "46.8,9.85,60"], "--uav 46.8,9.85,60: expected an altitude with what it is counted from"),
        (["--uav", "46.8,9.85,400 agl"], "--uav 46.8,9.85,400 agl: expected an altitude in m or ft, as in '400 m agl'"),
        (["--uav", "46.8,9.85"], "--uav: expected latitude,longitude,altitude"),
        (["--uav", "a=46.8,9.85,60 m agl", "--uav", "a=46.8,9.85,60 m agl"], "--uav: expected names that differ"),
        (["--area", "1,2,3"], "--area: expected west,south,east,north in degrees, found '1,2,3'"),
        (["--terrain", "none.tif"], "none.tif: no such file"),
        (["--ground", "10 m agl"], "--ground: expected an altitude above mean sea level"),
        (["--ground", "0 m amsl", "--geoid", "470"], "--geoid: expected metres from -150 to 150, found 470"),
        (["--ground", "0 m amsl", "--geoid", "-5000"], "--geoid: expected metres from -150 to 150, found -5000"),
        (["--fill-nodata", "much"], "--fill-nodata: expected metres above sea level, or nearest"),
        (["--soft-zones", "z.geojson"], "--soft-zones: expected FILE=RISK"),
        (["--origin", "146,9,5 m amsl"], "--origin: expected a latitude"),
        (["--origin", "46.8,9.8"], "--origin: expected latitude,longitude,altitude above mean sea level, as in '46.81"),
        (["--origin", "46.8,9.8,5 m agl"], "--origin: expected latitude,longitude,altitude above mean sea level"),
        (
            ["--uav", "46.8,9.85,60 m agl", "b.geojson"],
            "several values of an option stand each after its name, as in --uav A --uav B",
        ),
        (["--zones", "a.geojson", "b.geojson"], "a.geojson: no such file"),
    ],
)
def test_bad_input_to_the_command_ends_in_one_sentence_and_2(tmp_path, capsys, monkeypatch, words, sentence):
    monkeypatch.chdir(tmp_path)
    assert command(*words, "-o", "x.yaml") == 2
    said = capsys.readouterr().err
    assert said.startswith("skyverse: ")
    assert sentence in said
    assert said.count("\n") == 1
    assert not (tmp_path / "x.yaml").exists()


@pytest.mark.parametrize("margin", [250, 280, 300, 340])
def test_what_is_given_at_the_least_height_above_ground_is_free_whatever_rounding_does(margin):
    place = (50.0, 10.0, sky.AboveGround(30)), (50.0, 10.01, sky.AboveGround(60))
    scenario = of_maps("level", ground=sky.AboveSea(300), uavs=place[:1], targets=place[1:], margin=margin)
    for point, metres in ((scenario.uavs[0].start, 30), (scenario.targets[0].position, 60)):
        assert point[2] - scenario.terrain.height(point[:2]) == pytest.approx(metres, abs=1e-12)


def test_an_origin_has_a_geoid_that_there_is():
    with pytest.raises(ValueError, match="at most 150"):
        sky.Origin(latitude=46.8, longitude=9.8, altitude=0, geoid=470)
    assert sky.Origin(latitude=46.8, longitude=9.8, altitude=0, geoid=-107).geoid == -107


def test_a_raster_that_says_no_unit_is_told_unless_the_user_says_one(valley):
    def told(raster):
        notes = []
        of_maps("v", terrain=[raster], uavs=[START], on_note=notes.append)
        return [note.text for note in notes if note.file == str(valley) and "unit" in note.text]

    give = "give Raster(unit='m') if they are or Raster(unit='ft') to take them as feet"
    assert told(valley) == [f"WARNING: heights without a unit are taken as metres; {give}"]
    assert told(sky.Raster(valley, unit="m")) == []
    for raster, kept in ((valley, 1), (sky.Raster(valley, unit="m"), 0)):
        (source,) = of_maps("v", terrain=[raster], uavs=[START]).sources
        assert len(source.cautions) == kept
        assert not [said for said in source.cautions if "Raster(" in said]


def test_a_mission_among_zones_whose_times_are_not_read_warns_of_it(tmp_path):
    square = [[10.0, 50.0], [10.001, 50.0], [10.001, 50.001], [10.0, 50.0]]
    said = {"lower": "0 m agl", "upper": "50 m agl", "startDateTime": "2026-05-01T08:00:00Z"}
    zone = {"type": "Feature", "properties": said, "geometry": {"type": "Polygon", "coordinates": [square]}}
    (tmp_path / "zones.geojson").write_text(json.dumps(zone))
    ends = {"uavs": [(50.002, 10.0, sky.AboveGround(60))], "targets": [(50.002, 10.002, sky.AboveGround(60))]}
    scenario = of_maps("z", ground=sky.AboveSea(300), zones=[tmp_path / "zones.geojson"], **ends)
    warned = [one.sentence for one in mission_cautions(sky.plan_mission(scenario))]
    assert any("with times ('startDateTime')" in sentence for sentence in warned)


@pytest.mark.skipif(not (DATA / "delft.city.json").is_file(), reason="the Delft buildings are not here")
def test_delft_is_flown_over_as_it_stands():
    scenario = of_maps("delft", buildings=[DATA / "delft.city.json"], tolerance=0)
    assert len(scenario.obstacles) >= 160
    document = json.loads((DATA / "delft.city.json").read_text())
    used: set[int] = set()
    for one in document["CityObjects"].values():
        if one["type"] in ("Building", "Bridge", "PlantCover"):
            used.update(int(n) for n in re.findall(r"\d+", json.dumps([g["boundaries"] for g in one["geometry"]])))
    vertices = np.array(document["vertices"])[sorted(used)] * document["transform"]["scale"]
    x, y, z = (vertices + document["transform"]["translate"]).T
    lon, lat = pyproj.Transformer.from_crs(28992, 4326, always_xy=True).transform(x, y)
    corners = sky.to_local(scenario.frame.origin, np.column_stack([lat, lon, z]))
    low = np.min([np.min(prism.vertices, axis=0) for prism in scenario.obstacles], axis=0)
    high = np.max([np.max(prism.vertices, axis=0) for prism in scenario.obstacles], axis=0)
    assert low == pytest.approx(corners[:, :2].min(axis=0), abs=0.02)
    assert high == pytest.approx(corners[:, :2].max(axis=0), abs=0.02)
    assert max(prism.high for prism in scenario.obstacles) == pytest.approx(corners[:, 2].max(), abs=0.02)


def test_uavs_have_the_limits_of_outdoor_flight_unless_others_are_given_and_that_is_told(valley):
    def uav_and_notes(**limits):
        told = []
        made = of_maps("v", terrain=[valley], uavs=[START], targets=[GOAL], on_note=told.append, **limits)
        return made.uavs[0], [note.text for note in told if note.text.startswith("UAVs ")]

    uav, (note,) = uav_and_notes()
    assert (uav.max_speed, uav.max_climb, uav.max_descent, uav.ellipsoid) == (5, 3, 1.5, (5, 10))
    assert note.startswith("UAVs fly 5 m/s at most, climb at 3 m/s, descend at 1.5 m/s and keep 5 m apart")
    assert uav.tracking_error == sky.TrackingError(horizontal=1.6, vertical=3)
    assert "may stray 1.6 m horizontally and 3 m vertically, by default twice a GPS receiver's " in note
    assert "vehicle='camera'" in note
    uav, (note,) = uav_and_notes(max_climb=2.0)
    assert (uav.max_speed, uav.max_climb, uav.max_descent) == (5, 2, 1.5)
    uav, notes = uav_and_notes(vehicle="camera", separation=20.0)
    assert uav == sky.UAV(start=uav.start, name=uav.name, home=uav.home, vehicle="camera", separation=20)
    assert notes == [
        "UAVs may stray 1.6 m horizontally and 3 m vertically in calm air, by the profile 'camera'; "
        "give tracking_error for those in wind"
    ]
    uav, notes = uav_and_notes(vehicle="camera", tracking_error=(2.0, 4.0))
    assert uav.tracking_error == sky.TrackingError(horizontal=2, vertical=4)
    assert notes == []


def test_a_ceiling_above_ground_bounds_the_scenario_and_its_ends(valley, refuses):
    ends = {"terrain": [valley], "uavs": [START], "targets": [GOAL]}
    scenario = of_maps("v", **ends, ceiling=sky.AboveGround(120))
    assert scenario == of_maps("v", **ends, max_height=sky.AboveGround(120))
    assert scenario.max_height == 120
    assert scenario.bounds.max[2] == pytest.approx(scenario.terrain.heights.max() + 120)
    with refuses():
        of_maps("v", **ends, max_height=sky.AboveGround(50))


def test_zones_end_where_their_file_says_which_is_told_unless_they_are_to_be_closed_above(valley, tmp_path):
    path = geojson(tmp_path / "z.geojson", (SQUARE, {"upper": "20 m agl"}))
    start = place(-300, 0, sky.AboveGround(60))

    def built(**more):
        told = []
        made = of_maps("v", terrain=[valley], zones=[path], uavs=[start], on_note=told.append, **more)
        return made, [note.text for note in told if "flown over" in note.text]

    scenario, (note,) = built()
    assert not scenario.obstacles[0].closed_above
    assert note.startswith("1 zone ends below the top of the bounds, and may be flown over")
    scenario, notes = built(zones_closed_above=True)
    assert scenario.obstacles[0].closed_above
    assert notes == []
    x, y = np.mean(scenario.obstacles[0].vertices, axis=0)
    assert not sky.World(scenario).free([[x, y, scenario.bounds.max[2]]])[0]
