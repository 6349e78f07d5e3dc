"""Point clouds become the voxels that hold their points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.maps.readers.voxel_grid import read_las, voxels_of_points


def las(path, points, scales=(0.001, 0.001, 0.001), crs=None):
    laspy = pytest.importorskip("laspy")
    pytest.importorskip("lazrs")
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales, header.offsets = scales, np.floor(np.min(points, axis=0))
    if crs is not None:
        header.add_crs(crs)
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.asarray(points).T
    cloud.write(path)
    return path


def held(voxels):
    """Return the numbers of the occupied voxels, counted from the frame's zero."""
    first = np.rint(np.array(voxels.origin) / voxels.step).astype(int)
    return {tuple(cell) for cell in (first + np.argwhere(voxels.occupied)).tolist()}


@given(st.integers(0, 2**32 - 1), st.floats(0.2, 3))
def test_occupied_is_what_holds_points_and_nothing_else(seed, size):
    points = np.random.default_rng(seed).normal(scale=2, size=(300, 3)).round(3)
    wanted = {tuple(cell) for cell in np.floor(points / size).astype(int).tolist()}
    assert held(voxels_of_points("a", lambda: iter([points[:100], points[100:]]), size)) == wanted


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_a_las_or_laz_gives_a_scenario(suffix, tmp_path):
    points = np.random.default_rng(1).uniform((0, 0, 0), (20, 10, 5), (2000, 3)).round(3)
    scenario = sky.read(las(tmp_path / f"a{suffix}", points))
    (voxels,) = scenario.obstacles
    assert voxels.step == (0.5, 0.5, 0.5)
    assert held(voxels) == {tuple(cell) for cell in np.floor(points / 0.5).astype(int).tolist()}
    assert scenario.bounds.min == (-5, -5, -5)
    assert scenario.bounds.max == (25, 15, 10)


def test_a_cloud_too_wide_for_half_metres_is_read_in_larger_voxels(tmp_path, refuses):
    path = las(tmp_path / "a.las", [(0, 0, 0), (1000, 1000, 50)])
    assert read_las(path).step == (2, 2, 2)
    with refuses():
        read_las(path, size=0.01)


def test_a_cloud_in_degrees_or_feet_is_refused(tmp_path, refuses):
    pyproj = pytest.importorskip("pyproj")
    points = [(8.1, 47.2, 500), (8.2, 47.3, 510)]
    las(tmp_path / "metres.las", points, crs=pyproj.CRS(32632))
    assert sky.read(tmp_path / "metres.las").obstacles[0].occupied.sum() == 2
    for code in (4326, 2225):
        las(tmp_path / "a.las", points, crs=pyproj.CRS(code))
        with refuses():
            sky.read(tmp_path / "a.las")


def test_a_cloud_that_claims_a_coordinate_system_and_holds_none_is_in_metres(tmp_path):
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.global_encoding.wkt = True
    header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(""))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]).T
    cloud.write(tmp_path / "a.las")
    assert read_las(tmp_path / "a.las").occupied.any()


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize("length", [0, 3, 100, 230, 500])
def test_a_cloud_that_is_cut_off_is_refused(length, suffix, tmp_path, refuses):
    path = las(tmp_path / f"a{suffix}", np.random.default_rng(1).uniform(0, 5, (2000, 3)))
    path.write_bytes(path.read_bytes()[:length])
    with refuses():
        sky.read(path)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e12])
def test_points_that_are_nowhere_are_refused(value, refuses):
    with refuses():
        voxels_of_points("a", lambda: iter([np.array([[0, 0, 0], [1, value, 1.0]])]))


def test_a_cloud_without_points_is_refused(refuses):
    with refuses():
        voxels_of_points("a", lambda: iter([]))


def test_an_unpacker_that_gives_up_ends_in_one_sentence(tmp_path, monkeypatch, refuses):
    class Panic(BaseException):
        """As pyo3 raises it where Rust code panics."""

    def panics(*_):
        raise Panic("capacity overflow")

    path = las(tmp_path / "cloud.laz", np.zeros((3, 3)))
    monkeypatch.setattr(pytest.importorskip("laspy").LasReader, "chunk_iterator", panics)
    with refuses():
        read_las(path)
