"""The built-in mountain mission."""

import numpy as np
import pytest
from matplotlib.cbook import get_sample_data

import skyverse as sky


@pytest.fixture(scope="module")
def mountains():
    return sky.read("jacksboro")


def test_the_ground_is_nowhere_below_the_elevation_model_and_hardly_above_it(mountains):
    terrain, origin = mountains.terrain, mountains.frame.origin
    with get_sample_data("jacksboro_fault_dem.npz") as file:
        heights, west, north, pitch = (file[name] for name in ("elevation", "xmin", "ymin", "dx"))
    (x0, y0), (dx, dy) = terrain.origin, terrain.step
    excess = []
    for row in range(heights.shape[0]):
        for column in range(heights.shape[1]):
            if (row + column) % 7:
                continue
            place = (north - (row + 0.5) * pitch, west + (column + 0.5) * pitch, float(heights[row, column]))
            x, y, z = sky.to_local(origin, place)[0]
            i, j = (x - x0) / dx, (y - y0) / dy
            a, b = int(i), int(j)
            if not (i >= 0 and a < terrain.heights.shape[0] - 1 and j >= 0 and b < terrain.heights.shape[1] - 1):
                continue
            u, v = i - a, j - b
            corners = terrain.heights[a : a + 2, b : b + 2]
            excess.append(np.array([1 - u, u]) @ corners @ np.array([1 - v, v]) - z)
    assert len(excess) > 1000
    assert min(excess) >= 0
    assert np.median(excess) < 12


def test_starts_and_targets_are_above_the_ground_that_the_model_knows(mountains):
    world = sky.World(mountains)
    places = [*(uav.start for uav in mountains.uavs), *(target.position for target in mountains.targets)]
    assert world.distance(places) == pytest.approx(np.full(len(places), 40.0), abs=0.06)
    assert world.free(places).all()
    latitude, longitude, _ = sky.to_wgs84(mountains.frame.origin, places).T
    assert (np.abs(latitude - 36.51) < 0.05).all()
    assert (np.abs(longitude + 84.22) < 0.1).all()


def test_its_source_is_named(mountains):
    assert "USGS" in mountains.sources[0].licence
