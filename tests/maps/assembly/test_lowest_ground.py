"""The two surfaces of a terrain against its raster, sampled by brute force: one nowhere above it, one nowhere below."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skyverse as sky

rasterio = pytest.importorskip("rasterio", reason="reading rasters needs rasterio")
pyproj = pytest.importorskip("pyproj", reason="reading rasters needs pyproj")

from rasterio.transform import Affine  # noqa: E402

from skyverse.maps.assembly.terrain import read_terrain  # noqa: E402
from skyverse.maps.readers import raster_tiles  # noqa: E402

ORIGIN = sky.Origin(latitude=46.8, longitude=9.85, altitude=1500.0)
SYSTEMS = {"EPSG:4326": 30.0 / 111_200, "EPSG:32632": 20.0, "EPSG:21781": 25.0, "EPSG:3857": 40.0, "EPSG:3413": 20.0}
"""Coordinate systems, and the size of a pixel in their units; the last one is turned by 55 degrees at the origin."""
SIZE = 40


def rough(rng, size=SIZE):
    """Ground of waves, noise, and cliffs of up to 80 m along random lines."""
    rows, columns = np.mgrid[:size, :size] / 5.0
    heights = 1600 + 40 * np.sin(rows * rng.uniform(0, 2)) * np.cos(columns * rng.uniform(0, 2))
    heights += rng.normal(0, rng.choice([0.0, 0.5, 5.0]), heights.shape)
    for _ in range(3):
        a, b, c = rng.normal(size=3)
        heights += rng.uniform(0, 80) * (a * rows + b * columns > c + 4 * (a + b))
    return heights.astype("float32")


def written(path, heights, crs, pixel, east=0.0, north=0.0, shear=0.0):
    """Write a raster whose middle lies so many pixels from the origin."""
    x, y = pyproj.Transformer.from_crs("EPSG:4326", crs, always_xy=True).transform(ORIGIN.longitude, ORIGIN.latitude)
    rows, columns = heights.shape
    corner = x + (east - columns / 2) * pixel, y + (north + rows / 2) * pixel
    transform = Affine(pixel, shear * pixel, corner[0], 0, -pixel, corner[1])
    profile = {"driver": "GTiff", "count": 1, "dtype": heights.dtype, "crs": crs, "transform": transform}
    with rasterio.open(path, "w", width=columns, height=rows, nodata=np.nan, **profile) as file:
        file.write(heights, 1)
    return path


def samples(path, rng, count):
    """Return longitude, latitude and height (n,) of the raster: at the centres of pixels, and anywhere in between."""
    with rasterio.open(path) as file:
        heights, transform, crs = file.read(1).astype(float), file.transform, file.crs
    rows, columns = heights.shape
    centres = np.stack(np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"), -1).reshape(-1, 2).astype(float)
    between = rng.uniform(0, [columns - 1, rows - 1], (count, 2))
    on_lines = between.copy()
    on_lines[::2, 0], on_lines[1::2, 1] = on_lines[::2, 0].round(), on_lines[1::2, 1].round()
    at = np.concatenate([centres, between, on_lines])
    i, j = np.minimum(at.astype(int), [columns - 2, rows - 2]).T
    u, v = at.T - np.stack([i, j])
    corners = [((1 - u) * (1 - v), heights[j, i]), (u * (1 - v), heights[j, i + 1])]
    corners += [((1 - u) * v, heights[j + 1, i]), (u * v, heights[j + 1, i + 1])]
    z = sum(np.where(share > 0, share * height, 0.0) for share, height in corners)
    x, y = transform @ (at.T + 0.5) if hasattr(transform, "__matmul__") else transform * (at.T + 0.5)
    longitude, latitude = pyproj.Transformer.from_crs(crs, "EPSG:4326", always_xy=True).transform(x, y)
    return longitude, latitude, z


def require_between(terrain, path, rng, origin=ORIGIN, height=120.0, count=4000):
    """Require that samples are between both surfaces, and that no place at most `height` above the lower is higher."""
    longitude, latitude, altitude = samples(path, rng, count)
    known = np.isfinite(altitude)
    ground, high = (
        sky.to_local(origin, np.column_stack([latitude, longitude, altitude + more])[known]) for more in (0.0, height)
    )
    (x0, y0), (x1, y1) = terrain.extent
    over = (np.abs(ground[:, :2] - [(x0 + x1) / 2, (y0 + y1) / 2]) <= [(x1 - x0) / 2, (y1 - y0) / 2]).all(axis=1)
    assert over.sum() > 50
    lower = terrain.lowest_ground
    assert (terrain.height(ground[over, :2]) - ground[over, 2]).min() >= 0
    assert (ground[over, 2] - lower.height(ground[over, :2])).min() >= 0
    assert (high[over, 2] - lower.height(high[over, :2])).min() >= height
    return ground[over, 2] - lower.height(ground[over, :2])


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(list(SYSTEMS)), st.sampled_from([None, 6.0, 23.0, 60.0]))
def test_no_sample_of_a_raster_is_outside_of_the_two_surfaces(tmp_path, seed, crs, step):
    rng = np.random.default_rng(seed)
    heights = rough(rng)
    holes = rng.random() < 0.3
    if holes:
        heights[rng.random(heights.shape) < 0.03] = np.nan
    path = written(tmp_path / "a.tif", heights, crs, SYSTEMS[crs], *rng.uniform(-0.5, 0.5, 2), rng.choice([0.0, 0.3]))
    x, y, wide, tall = *rng.uniform(-150, -60, 2), *rng.uniform(110, 210, 2)
    terrain, _ = read_terrain(
        [sky.Raster(path)], ORIGIN, (x, y, x + wide, y + tall), step=step, fill="nearest" if holes else None
    )
    require_between(terrain, path, rng)


@pytest.mark.parametrize("crs", ["EPSG:32632", "EPSG:3413"])
def test_pooled_pixels_are_between_the_two_surfaces(tmp_path, monkeypatch, crs):
    monkeypatch.setattr(raster_tiles, "MAX_PIXELS", 100.0)
    monkeypatch.setattr(raster_tiles, "POOLED_PIXELS", 400.0)
    rng = np.random.default_rng(5)
    heights = rough(rng, 120)
    heights[20, 30] = np.nan
    path = written(tmp_path / "a.tif", heights, crs, 4.0)
    for step in (20.0, 37.0):
        terrain, _ = read_terrain([sky.Raster(path)], ORIGIN, (-70, -60, 80, 75), step=step, fill="nearest")
        require_between(terrain, path, rng, count=20_000)


def test_of_two_rasters_the_lower_one_counts_for_the_lowest_surface(tmp_path):
    rng = np.random.default_rng(7)
    one, other = rough(rng), rough(rng)
    paths = [written(tmp_path / f"{k}.tif", each, "EPSG:32632", 20.0, 5.0 * k) for k, each in enumerate((one, other))]
    terrain, _ = read_terrain([sky.Raster(path) for path in paths], ORIGIN, (-90, -100, 120, 80), step=15.0)
    for path in paths:
        require_between(terrain, path, rng)


def test_on_a_smooth_slope_both_surfaces_are_the_raster(tmp_path):
    rows, columns = np.mgrid[:60, :60]
    path = written(tmp_path / "a.tif", (1500.0 + 4.0 * columns + 6.0 * rows).astype("float32"), "EPSG:32632", 20.0)
    terrain, told = read_terrain([sky.Raster(path)], ORIGIN, (-300, -300, 300, 300), step=15.0)
    assert require_between(terrain, path, np.random.default_rng(1)).max() < 0.02
    assert told.most_lowered < 0.02
