"""Rasters of many kinds against PROJ's own pixels: the ground is where they are, and nowhere below them."""

import os
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skyverse as sky

rasterio = pytest.importorskip("rasterio", reason="reading rasters needs rasterio")
pyproj = pytest.importorskip("pyproj", reason="reading rasters needs pyproj")

from rasterio.transform import Affine  # noqa: E402

from proj_map import proj_local  # noqa: E402
from skyverse.maps.assembly.frame import covered  # noqa: E402
from skyverse.maps.assembly.terrain import (  # noqa: E402
    ground_range,
    level_ground,
    read_terrain,
)
from skyverse.maps.readers import raster_tiles  # noqa: E402
from skyverse.maps.readers.raster import open_raster  # noqa: E402

DATA = Path(os.environ.get("SKYVERSE_DATA", Path(__file__).parents[4] / "shared" / "data"))
DAVOS = sky.Origin(latitude=46.8, longitude=9.85, altitude=1500.0)


def written(path, heights, crs, transform, **more):
    """Write a GeoTIFF; what is no setting of the profile is an attribute of the file."""
    attributes = {name: more.pop(name) for name in ("units", "scales", "offsets") if name in more}
    heights = np.atleast_3d(np.asarray(heights).T).T
    with rasterio.open(
        path,
        "w",
        driver=more.pop("driver", "GTiff"),
        height=heights.shape[1],
        width=heights.shape[2],
        count=heights.shape[0],
        dtype=heights.dtype,
        crs=crs,
        transform=transform,
        **more,
    ) as file:
        file.write(heights)
        for name, value in attributes.items():
            setattr(file, name, value)
    return path


def around(origin, crs, pixel, size, turn=0.0):
    """Return the geotransform of a square raster around an origin, pixels in the raster's units."""
    to = pyproj.Transformer.from_crs("EPSG:4326", crs, always_xy=True)
    x, y = to.transform(origin.longitude, origin.latitude)
    c, s = pixel * np.cos(np.radians(turn)), pixel * np.sin(np.radians(turn))
    return shifted(Affine(c, s, x, s, -c, y), -size / 2, -size / 2)


def from_corner(west, north, pixel):
    return Affine(pixel, 0, west, 0, -pixel, north)


def shifted(transform, columns, rows):
    """Return a geotransform that begins so many pixels later."""
    a, b, c, d, e, f = transform[:6]
    return Affine(a, b, a * columns + b * rows + c, d, e, d * columns + e * rows + f)


def pixels(path, origin, crs, unit=1.0):
    """Return local points (n, 3) of all pixels' centres, as PROJ has them."""
    with rasterio.open(path) as file:
        heights, transform = file.read(1).astype(float) * unit, file.transform
    rows, columns = np.mgrid[: heights.shape[0], : heights.shape[1]] + 0.5
    a, b, c, d, e, f = transform[:6]
    x, y = (k * columns.ravel() + m * rows.ravel() + n for k, m, n in ((a, b, c), (d, e, f)))
    lon, lat = pyproj.Transformer.from_crs(crs, "EPSG:4326", always_xy=True).transform(x, y)
    return proj_local(origin, lat, lon, heights.ravel())


def above(terrain, points):
    """Return how far the ground is above points that lie over it."""
    (x0, y0), (x1, y1) = terrain.extent
    over = (points[:, 0] >= x0) & (points[:, 0] <= x1) & (points[:, 1] >= y0) & (points[:, 1] <= y1)
    assert over.sum() > 10
    return terrain.height(points[over, :2]) - points[over, 2]


def hills(size, seed=0):
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:size, :size] / size
    return (1600 + 300 * np.sin(7 * x) * np.cos(5 * y) + rng.normal(0, 5, (size, size))).astype("float32")


SYSTEMS = [
    ("EPSG:4326", 1 / 3600),
    ("EPSG:32632", 30.0),
    ("EPSG:21781", 30.0),
    ("EPSG:2056", 30.0),
    ("EPSG:3857", 40.0),
]


@pytest.mark.parametrize(("crs", "pixel"), SYSTEMS)
@pytest.mark.parametrize("step", [None, 7.0, 90.0])
def test_the_ground_is_nowhere_below_a_pixel_and_not_far_above(tmp_path, crs, pixel, step):
    path = written(tmp_path / "a.tif", hills(120), crs, around(DAVOS, crs, pixel, 120))
    terrain, raised = read_terrain([sky.Raster(path)], DAVOS, (-900, -900, 900, 900), step=step)
    over = above(terrain, pixels(path, DAVOS, crs))
    assert over.min() >= 0
    assert over.mean() < (60 if step == 90 else 15)
    assert raised.most >= 0
    assert terrain.extent == ((-900, -900), pytest.approx((900, 900)))


@pytest.mark.parametrize(("crs", "pixel"), SYSTEMS)
def test_a_smooth_slope_comes_out_as_it_is(tmp_path, crs, pixel):
    transform = around(DAVOS, crs, pixel, 120)
    rows, columns = np.mgrid[:120, :120]
    path = written(tmp_path / "a.tif", 1500.0 + 2.0 * columns + 3.0 * rows, crs, transform)
    terrain, raised = read_terrain([sky.Raster(path)], DAVOS, (-900, -900, 900, 900), step=20.0)
    over = above(terrain, pixels(path, DAVOS, crs))
    assert over.min() >= 0
    assert over.max() < 0.05
    assert raised.most < 0.05


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 1000),
    crs=st.sampled_from(["EPSG:4326", "EPSG:32632", "EPSG:21781"]),
    turn=st.floats(-180, 180),
    step=st.floats(3, 200),
    latitude=st.floats(46.5, 47.2),
    pooled=st.booleans(),
)
def test_however_it_is_turned_and_read_no_pixel_stands_out(tmp_path, seed, crs, turn, step, latitude, pooled):
    origin = sky.Origin(latitude=latitude, longitude=9.0, altitude=500.0, geoid=48.0)
    pixel = 1 / 3600 if crs == "EPSG:4326" else 20.0
    path = written(tmp_path / "a.tif", hills(150, seed), crs, around(origin, crs, pixel, 150, turn))
    limits = raster_tiles.MAX_PIXELS, raster_tiles.POOLED_PIXELS
    if pooled:
        raster_tiles.MAX_PIXELS, raster_tiles.POOLED_PIXELS = 100.0, 200.0
    try:
        terrain, _ = read_terrain([sky.Raster(path)], origin, (-850, -700, 640, 730), step=step)
    finally:
        raster_tiles.MAX_PIXELS, raster_tiles.POOLED_PIXELS = limits
    assert above(terrain, pixels(path, origin, crs)).min() >= 0


def test_a_crop_of_a_raster_of_20000_by_20000_reads_its_window_only(tmp_path):
    path = tmp_path / "huge.tif"
    with rasterio.open(
        path, "w", driver="GTiff", width=20_000, height=20_000, count=1, dtype="float32", crs="EPSG:32632", tiled=True,
        blockxsize=256, blockysize=256, sparse_ok=True, transform=from_corner(500_000, 5_300_000, 5),
    ) as file:  # fmt: skip
        window = rasterio.windows.Window(9_900, 9_900, 256, 256)
        file.write(np.full((256, 256), 700, dtype="float32"), 1, window=window)
    assert path.stat().st_size < 20e6
    lon, lat = pyproj.Transformer.from_crs(32632, 4326, always_xy=True).transform(550_140, 5_249_860)
    origin = sky.Origin(latitude=lat, longitude=lon, altitude=700)
    tracemalloc.start()
    terrain, _ = read_terrain([sky.Raster(path)], origin, (-500, -500, 500, 500))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50e6
    assert np.abs(terrain.heights).max() < 0.1


def test_an_area_of_many_pixels_at_a_long_step_is_pooled_and_still_covers_them(tmp_path, monkeypatch):
    monkeypatch.setattr(raster_tiles, "MAX_PIXELS", 1e4)
    monkeypatch.setattr(raster_tiles, "POOLED_PIXELS", 1e4)
    heights = np.full((600, 600), 1500, dtype="float32")
    heights[301, 287] = 1800  # one mast
    path = written(tmp_path / "a.tif", heights, "EPSG:32632", around(DAVOS, "EPSG:32632", 5.0, 600))
    terrain, raised = read_terrain([sky.Raster(path)], DAVOS, (-1200, -1200, 1200, 1200), step=50.0)
    assert above(terrain, pixels(path, DAVOS, "EPSG:32632")).min() >= 0
    assert np.median(terrain.heights) == pytest.approx(0, abs=0.2)
    assert raised.most > 0


def test_two_tiles_side_by_side_are_as_one(tmp_path, refuses):
    heights = hills(120)
    transform = around(DAVOS, "EPSG:32632", 20.0, 120)
    whole = written(tmp_path / "whole.tif", heights, "EPSG:32632", transform)
    left = written(tmp_path / "l.tif", heights[:, :60], "EPSG:32632", transform)
    right = written(tmp_path / "r.tif", heights[:, 60:], "EPSG:32632", shifted(transform, 60, 0))
    region = (-800, -800, 800, 800)
    one, _ = read_terrain([sky.Raster(whole)], DAVOS, region, step=20.0)
    two, _ = read_terrain([sky.Raster(left), sky.Raster(right)], DAVOS, region, step=20.0)
    assert above(two, pixels(whole, DAVOS, "EPSG:32632")).min() >= 0
    same = np.abs(one.heights - two.heights) < 1e-3
    assert same.mean() > 0.95  # all but beside the seam, where there is nothing to interpolate with
    with refuses():
        read_terrain([sky.Raster(left)], DAVOS, region)


def square(path, heights, **more):
    return written(path, heights, "EPSG:32632", around(DAVOS, "EPSG:32632", 20.0, len(heights)), **more)


REGION = (-300.0, -300.0, 300.0, 300.0)


@pytest.mark.parametrize(
    ("said", "given", "metres"),
    [
        ("ft", None, 0.3048),
        ("US survey foot", None, 1200 / 3937),
        ("metre", None, 1.0),
        ("m", "ft", 0.3048),
        ("", None, 1),
    ],
)
def test_heights_in_feet_come_out_in_metres(tmp_path, said, given, metres):
    path = square(tmp_path / "a.tif", np.full((60, 60), 5000.0), units=(said,))
    terrain, _ = read_terrain([sky.Raster(path, unit=given)], DAVOS, REGION)
    middle = terrain.height((0, 0))
    assert middle == pytest.approx(5000 * metres - 1500, abs=0.01)


def test_the_unit_of_a_vertical_coordinate_system_is_used(tmp_path):
    path = square(tmp_path / "a.tif", np.full((60, 60), 5000.0))
    with rasterio.open(path, "r+") as file:
        file.crs = rasterio.crs.CRS.from_user_input("EPSG:32632+6360")  # NAVD88, US survey feet
    terrain, _ = read_terrain([sky.Raster(path)], DAVOS, REGION)
    assert terrain.height((0, 0)) == pytest.approx(5000 * 1200 / 3937 - 1500, abs=0.01)


def test_heights_without_a_unit_in_a_system_in_feet_are_refused(tmp_path, refuses):
    origin = sky.Origin(latitude=40.7, longitude=-74.0, altitude=0.0)
    crs = "EPSG:2263"  # New York, US survey feet
    path = written(tmp_path / "a.tif", np.full((60, 60), 100.0), crs, around(origin, crs, 30.0, 60))
    with refuses():
        read_terrain([sky.Raster(path)], origin, REGION)
    terrain, _ = read_terrain([sky.Raster(path, unit="us-ft")], origin, (-200.0, -200.0, 200.0, 200.0))
    assert terrain.height((0, 0)) == pytest.approx(100 * 1200 / 3937, abs=0.01)


def test_an_unknown_unit_is_refused(tmp_path, refuses):
    path = square(tmp_path / "a.tif", np.full((60, 60), 5000.0), units=("fathom",))
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION)


def test_scale_and_offset_are_used(tmp_path):
    path = square(tmp_path / "a.tif", np.full((60, 60), 600, dtype="int16"), scales=(0.5,), offsets=(1300.0,))
    terrain, _ = read_terrain([sky.Raster(path)], DAVOS, REGION)
    assert terrain.height((0, 0)) == pytest.approx(100, abs=0.01)


def test_ellipsoidal_heights_lose_the_geoid(tmp_path):
    origin = DAVOS.model_copy(update={"geoid": 50.0})
    transform = around(DAVOS, "EPSG:4326", 1 / 3600, 60)
    path = written(tmp_path / "a.tif", np.full((60, 60), 1600.0), "EPSG:4979", transform)
    with rasterio.open(path) as file:
        if len(pyproj.CRS(file.crs.to_wkt()).axis_info) != 3:
            pytest.skip("this GDAL does not keep three-dimensional systems")
    terrain, _ = read_terrain([sky.Raster(path)], origin, REGION)
    assert terrain.height((0, 0)) == pytest.approx(50, abs=0.01)


def test_ellipsoidal_heights_without_a_geoid_are_refused(tmp_path, refuses):
    transform = around(DAVOS, "EPSG:4326", 1 / 3600, 60)
    path = written(tmp_path / "a.tif", np.full((60, 60), 1600.0), "EPSG:4979", transform)
    unknown = DAVOS.model_copy(update={"geoid": None})
    with refuses():
        read_terrain([sky.Raster(path)], unknown, REGION)
    level = DAVOS.model_copy(update={"geoid": 0.0})
    assert read_terrain([sky.Raster(path)], level, REGION)[0].heights.max() < 101


def test_depths_are_no_heights(tmp_path, refuses):
    path = square(tmp_path / "a.tif", np.full((60, 60), 50.0))
    with rasterio.open(path, "r+") as file:
        file.crs = rasterio.crs.CRS.from_user_input("EPSG:32632+5715")
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION)


@pytest.mark.parametrize(
    ("crs", "doubt"),
    [
        ("EPSG:27700", "OSGB36 / British National Grid are known to 2 m"),
        ("+proj=tmerc +lat_0=52 +lon_0=-1 +ellps=airy", "as if their datum were WGS84's"),
        ("EPSG:32630", ""),
    ],
)
def test_how_well_coordinates_are_known_is_said(tmp_path, crs, doubt):
    england = sky.Origin(latitude=52.0, longitude=-1.0, altitude=0.0)
    path = written(tmp_path / "a.tif", np.full((60, 60), 100.0), crs, around(england, crs, 20.0, 60))
    with open_raster(sky.Raster(path)) as file:
        assert doubt in file.doubt
        assert bool(doubt) == bool(file.doubt)


def test_of_several_bands_one_must_be_chosen(tmp_path, refuses):
    both = np.stack([np.full((60, 60), 1500.0), np.full((60, 60), 1700.0)])
    path = written(tmp_path / "a.tif", both, "EPSG:32632", around(DAVOS, "EPSG:32632", 20.0, 60))
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION)
    with refuses():
        read_terrain([sky.Raster(path, band=3)], DAVOS, REGION)
    terrain, _ = read_terrain([sky.Raster(path, band=2)], DAVOS, REGION)
    assert terrain.height((0, 0)) == pytest.approx(200, abs=0.01)


@pytest.mark.parametrize("hole", ["nodata", "nan", "said"])
def test_holes_are_refused_with_their_share_and_place_or_filled(tmp_path, hole, refuses):
    heights = np.full((60, 60), 1600.0)
    heights[28:32, 28:32] = {"nodata": -1.0, "nan": np.nan, "said": -9999.0}[hole]
    path = square(tmp_path / "a.tif", heights, **({"nodata": -1.0} if hole == "nodata" else {}))
    raster = sky.Raster(path, nodata=-9999.0 if hole == "said" else None)
    with refuses():
        read_terrain([raster], DAVOS, REGION)
    filled, told = read_terrain([raster], DAVOS, REGION, fill=1550.0)
    assert filled.height((0, 0)) == pytest.approx(50, abs=0.01)
    assert 0.01 < told.filled < 0.06
    nearest, _ = read_terrain([raster], DAVOS, REGION, fill="nearest")
    assert nearest.height((0, 0)) == pytest.approx(100, abs=0.05)


def test_a_single_pixel_without_data_between_far_nodes_is_seen(tmp_path, refuses):
    heights = np.full((60, 60), 1600.0)
    heights[33, 22] = np.nan
    path = square(tmp_path / "a.tif", heights)
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION, step=100.0)


def test_a_pixel_without_data_raises_no_ground_below_the_sea(tmp_path):
    heights = np.full((60, 60), -430.0)
    heights[33, 22] = np.nan
    shore = DAVOS.model_copy(update={"altitude": -430.0})
    terrain, told = read_terrain([sky.Raster(square(tmp_path / "a.tif", heights))], shore, REGION, fill="nearest")
    assert told.filled > 0
    assert terrain.heights.max() < 0.1


def test_what_looks_like_no_data_or_a_wrong_unit_is_refused(tmp_path, refuses):
    heights = np.full((60, 60), 1600.0)
    heights[30, 30] = -9999
    with refuses():
        read_terrain([sky.Raster(square(tmp_path / "a.tif", heights))], DAVOS, REGION)
    with refuses():
        read_terrain([sky.Raster(square(tmp_path / "b.tif", np.full((60, 60), 16000.0)))], DAVOS, REGION)


def slopes(size=100, level=1500.0):
    """Ground with slopes of up to 45 degrees at pixels of 20 m."""
    rows, columns = np.mgrid[:size, :size]
    return (level + 150 * np.sin(rows / 8) * np.cos(columns / 9)).astype("float32")


@pytest.mark.parametrize("value", [0.0, 1.0, -3.0, -999.0, -9998.0, -9999.9, 8888.0])
@pytest.mark.parametrize("part", [np.s_[40:60, 35:70], np.s_[:60, :50], np.s_[50:51, 50:51], np.s_[10:90, 10:90]])
def test_a_block_of_one_number_with_cliffs_all_round_is_no_ground(tmp_path, value, part):
    heights = slopes()
    heights[part] = value
    path = square(tmp_path / "a.tif", heights)
    said = f"{value:g}"
    with pytest.raises(
        sky.InputError, match=rf"a\.tif: it holds {said}, .* at latitude 46\.\d+, .*Raster\(nodata={said}\) if"
    ) as error:
        read_terrain([sky.Raster(path)], DAVOS, REGION)
    assert "\n" not in str(error.value)
    with pytest.raises(sky.InputError, match="of the area has no data"):
        read_terrain([sky.Raster(path, nodata=value)], DAVOS, REGION)
    if value < 0 or value == 8888:
        terrain, _ = read_terrain([sky.Raster(path, nodata=np.nan)], DAVOS, REGION)
        assert np.isfinite(terrain.heights).all()


def test_an_area_that_lies_in_a_block_of_no_data_is_judged_by_what_is_around(tmp_path, refuses):
    heights = slopes(200)
    heights[60:140, 60:140] = 0
    with refuses():
        read_terrain([sky.Raster(square(tmp_path / "a.tif", heights))], DAVOS, REGION)


def test_a_block_of_no_data_is_found_where_pixels_are_pooled(tmp_path, monkeypatch, refuses):
    monkeypatch.setattr(raster_tiles, "MAX_PIXELS", 100.0)
    monkeypatch.setattr(raster_tiles, "POOLED_PIXELS", 200.0)
    heights = slopes(200)
    heights[80:120, 80:120] = 0
    with refuses():
        read_terrain([sky.Raster(square(tmp_path / "a.tif", heights))], DAVOS, (-1500, -1500, 1500, 1500), step=120.0)


def lake():
    """A lake between slopes of 45 degrees."""
    rows, columns = np.mgrid[:100, :100]
    return np.maximum(600.0, 20.0 * np.hypot(rows - 50, columns - 50))


def coast():
    """The sea, and a shore that is a cliff of 400 m in its middle, and else rises by one in ten."""
    rows, columns = np.mgrid[:100, :100]
    cliff = np.abs(rows - 50) < 20
    return np.where(columns < 50, 0.0, np.where(cliff, 400.0, 2.0 * (columns - 49)))


def quarry():
    """A plain in whole metres with a pit of 80 m, its walls upright."""
    heights = np.full((100, 100), 90.0)
    heights[40:60, 45:60] = 10
    return heights


def towers():
    """Level ground, and roofs 500 m above it."""
    heights = np.full((100, 100), 4.0)
    heights[50:53, 50:53] = heights[40:44, 60:63] = 504
    return heights


def dam():
    """A lake that a wall of 250 m holds back, and what it holds it back from."""
    rows, columns = np.mgrid[:100, :100]
    valley = 500.0 + 18.0 * np.abs(columns - 50)
    return np.where(rows < 50, np.maximum(valley, 750.0), valley)


@pytest.mark.parametrize("ground", [lake, coast, quarry, towers, dam, lambda: np.zeros((100, 100))])
@pytest.mark.parametrize("whole", [False, True])
def test_real_levels_are_ground_whatever_their_shores(tmp_path, ground, whole):
    heights = ground().astype("int16" if whole else "float32")
    for x, y in ((0, 0), (-500, 300), (400, -200)):
        region = (x - 300, y - 300, x + 300, y + 300)
        read_terrain([sky.Raster(square(tmp_path / "a.tif", heights))], DAVOS, region)


def test_the_mountains_of_a_real_elevation_model_are_all_ground(tmp_path):
    cbook = pytest.importorskip("matplotlib.cbook")
    heights = cbook.get_sample_data("jacksboro_fault_dem.npz")["elevation"]
    path = square(tmp_path / "a.tif", heights)
    read_terrain([sky.Raster(path)], DAVOS, (-3000, -3000, 3000, 3000))


def test_an_ascii_grid_has_no_coordinates_until_they_are_said(tmp_path, refuses):
    text = (
        "ncols 3\nnrows 3\nxllcorner 9.84\nyllcorner 46.79\ncellsize 0.01\nNODATA_value -9999\n"
        + "1600 1600 1600\n" * 3
    )
    path = tmp_path / "a.asc"
    path.write_text(text)
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION)
    with refuses():
        read_terrain([sky.Raster(path, crs="EPSG:nonsense")], DAVOS, REGION)
    origin = DAVOS.model_copy(update={"latitude": 46.805, "longitude": 9.855})
    terrain, _ = read_terrain([sky.Raster(path, crs="EPSG:4326")], origin, REGION)
    assert terrain.height((0, 0)) == pytest.approx(100, abs=0.1)


def test_an_hgt_tile_is_read(tmp_path):
    path = tmp_path / "N46E009.hgt"
    np.full((1201, 1201), 1600, dtype=">i2").tofile(path)
    terrain, _ = read_terrain([sky.Raster(path)], DAVOS, REGION)
    assert terrain.height((0, 0)) == pytest.approx(100, abs=0.2)


def test_a_file_without_a_geotransform_is_refused(tmp_path, refuses):
    with pytest.warns(rasterio.errors.NotGeoreferencedWarning):
        path = written(tmp_path / "a.tif", np.full((9, 9), 1.0), "EPSG:32632", Affine.identity())
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION)


@pytest.mark.parametrize("content", [b"", b"not a raster", b"II*\0\x08\0\0\0"])
def test_what_is_no_raster_is_refused_in_one_sentence(tmp_path, content, refuses):
    path = tmp_path / "a.tif"
    path.write_bytes(content)
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION)
    with refuses():
        read_terrain([sky.Raster(tmp_path / "none.tif")], DAVOS, REGION)


@pytest.mark.parametrize("name", ["far.vrt", "far.tif"])
@pytest.mark.parametrize(
    "content",
    [
        '<VRTDataset rasterXSize="1" rasterYSize="1"/>',
        "\ufeff\n<GDAL_WMS><Service name='TMS'><ServerUrl>http://127.0.0.1:9/</ServerUrl></Service></GDAL_WMS>",
        '{"stac_version": "1.0.0"}',
    ],
)
def test_a_file_that_only_points_to_others_is_refused_unopened(tmp_path, monkeypatch, name, content, refuses):
    monkeypatch.setattr(rasterio, "open", None)
    (tmp_path / name).write_text(content, encoding="utf-8")
    with refuses():
        read_terrain([sky.Raster(tmp_path / name)], DAVOS, REGION)


def test_a_damaged_file_is_refused_in_one_sentence(tmp_path, refuses):
    path = square(tmp_path / "a.tif", hills(200), compress="deflate")
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION)


@pytest.mark.parametrize("west", [179.9, -180.1, 539.9])
def test_the_antimeridian_is_a_line_like_any_other(tmp_path, west):
    origin = sky.Origin(latitude=-16.8, longitude=179.999, altitude=0)
    heights = hills(200)
    path = written(tmp_path / "a.tif", heights, "EPSG:4326", from_corner(west, -16.7, 0.001))
    terrain, _ = read_terrain([sky.Raster(path)], origin, (-2000, -2000, 2000, 2000))
    points = pixels(path, origin, "EPSG:4326")
    assert above(terrain, points).min() >= 0
    assert above(terrain, points).mean() < 30


def test_a_raster_of_the_globe_is_read_across_its_edge(tmp_path):
    origin = sky.Origin(latitude=-16.8, longitude=179.9, altitude=0)
    rows, columns = np.mgrid[:180, :360]
    path = written(tmp_path / "a.tif", (columns + rows).astype("float32"), "EPSG:4326", from_corner(-180, 90, 1))
    terrain, _ = read_terrain([sky.Raster(path)], origin, (-90_000, -20_000, 90_000, 20_000), step=5000.0)
    (west,), (east,) = (terrain.height([(x, 0)]) for x in (-80_000.0, 80_000.0))
    assert west > 300 - 600  # the last columns; the level bends down by 500 m so far away
    assert east < west - 250


def test_a_pole_in_degrees_is_refused_and_in_a_polar_projection_read(tmp_path, refuses):
    origin = sky.Origin(latitude=90, longitude=0, altitude=0)
    degrees = written(tmp_path / "a.tif", np.full((100, 3600), 100.0), "EPSG:4326", from_corner(-180, 90, 0.1))
    with refuses():
        read_terrain([sky.Raster(degrees)], origin, (-5000, -5000, 5000, 5000))
    polar = written(tmp_path / "b.tif", hills(200), "EPSG:3413", around(origin, "EPSG:3413", 100.0, 200))
    terrain, _ = read_terrain([sky.Raster(polar)], origin, (-5000, -5000, 5000, 5000))
    assert above(terrain, pixels(polar, origin, "EPSG:3413")).min() >= 0


def test_too_many_heights_are_refused_before_they_are_read(tmp_path, refuses):
    path = square(tmp_path / "a.tif", hills(200))
    with refuses():
        read_terrain([sky.Raster(path)], DAVOS, REGION, step=0.1)


def test_what_a_raster_covers_lies_in_it(tmp_path):
    path = square(tmp_path / "a.tif", hills(60))
    with open_raster(sky.Raster(path)) as file:
        x0, y0, x1, y1 = covered(file, DAVOS)
    points = pixels(path, DAVOS, "EPSG:32632")
    assert points[:, 0].min() - 25 < x0 < x1 < points[:, 0].max() + 25
    assert x1 - x0 > 1100
    assert y1 - y0 > 1100
    read_terrain([sky.Raster(path)], DAVOS, (x0, y0, x1, y1))


def test_flat_ground_is_level():
    origin = sky.Origin(latitude=52, longitude=4, altitude=10)
    terrain = level_ground(origin, (-5000, -100, 5000, 100), 12.0)
    assert terrain.height([[0.0, 0.0], [5000.0, 0.0]]).tolist() == [2.0, 2.0]


def test_the_ground_between_ends_holds_all_ground_under_a_polygon():
    shapely = pytest.importorskip("shapely", reason="polygons are shapely's")
    from skyverse.model.shapes import Terrain

    rng = np.random.default_rng(3)
    terrain = Terrain(origin=(-50, -30), step=(3, 2), heights=rng.normal(0, 20, (60, 70)))
    outlines = np.array(
        [shapely.Point(*rng.uniform(-40, 100, 2)).buffer(rng.uniform(0.5, 60)) for _ in range(60)], dtype=object
    )
    low, high = ground_range(terrain, outlines)
    (x0, y0), (x1, y1) = terrain.extent
    for outline, least, most in zip(outlines, low, high, strict=True):
        west, south, east, north = outline.bounds
        x, y = rng.uniform([west, south], [east, north], (500, 2)).T
        inside = shapely.contains_xy(outline, x, y) & (x > x0) & (x < x1) & (y > y0) & (y < y1)
        ground = terrain.height(np.column_stack([x[inside], y[inside]]))
        assert (ground >= least - 1e-9).all()
        assert (ground <= most + 1e-9).all()
    # a long thin one counts what is under it, not all of the box around it
    line = shapely.LineString([(-40, -20), (100, 90)]).buffer(0.5)
    ramp = Terrain(origin=(-50, -30), step=(3, 2), heights=np.add.outer(np.arange(60) * 3.0, -np.arange(70) * 2.0))
    least, most = ground_range(ramp, np.array([line], dtype=object))
    assert most[0] - least[0] < 50


@pytest.mark.skipif(not (DATA / "davosdorf.tif").is_file(), reason="the Davos terrain is not here")
@pytest.mark.parametrize("value", [0, -999, -9998, -9999.9, 8888])
def test_a_block_in_davos_is_refused_and_found_where_it_is(tmp_path, value):
    with rasterio.open(DATA / "davosdorf.tif") as file:
        heights, profile = file.read(1), file.profile
    heights[200:280, 200:280] = value
    with rasterio.open(tmp_path / "davos.tif", "w", **profile) as file:
        file.write(heights, 1)
    with open_raster(sky.Raster(tmp_path / "davos.tif")) as file:
        origin = sky.Origin(latitude=46.8155, longitude=9.8238, altitude=1500)
        with pytest.raises(sky.InputError) as error:
            read_terrain([sky.Raster(tmp_path / "davos.tif")], origin, (-1500, -1500, 1500, 1500))
        latitude, longitude = map(float, re.findall(r"latitude ([\d.]+), longitude ([\d.]+)", str(error.value))[0])
        column, row = file.pixel(latitude, longitude)
    assert 200 <= column <= 280
    assert 200 <= row <= 280
    assert f"davos.tif: it holds {value:g}, " in str(error.value)


@pytest.mark.skipif(not (DATA / "davosdorf.tif").is_file(), reason="the Davos terrain is not here")
def test_davos_is_nowhere_below_its_heights():
    path = DATA / "davosdorf.tif"
    origin = sky.Origin(latitude=46.81, longitude=9.85, altitude=1560)
    with open_raster(sky.Raster(path)) as file:
        region = covered(file, origin)
        assert file.name == "EPSG:21781"
    terrain, raised = read_terrain([sky.Raster(path)], origin, region)
    over = above(terrain, pixels(path, origin, "EPSG:21781"))
    assert over.min() >= 0
    assert raised.mean < 0.5
