"""Aerial point clouds stand where PROJ puts them, to the cell."""

import numpy as np
import pytest

import skyverse as sky
from of_maps import of_maps
from proj_map import proj_local
from skyverse.cli import main

laspy = pytest.importorskip("laspy")
pytest.importorskip("lazrs")
pyproj = pytest.importorskip("pyproj")
pytest.importorskip("shapely")

LAT, LON = 47.5, 8.7
UTM = 32632
TO_UTM = pyproj.Transformer.from_crs(4326, UTM, always_xy=True)
ORIGIN = sky.Origin(latitude=LAT, longitude=LON, altitude=400.0)
WIDE = (LON - 0.08, LAT - 0.05, LON + 0.08, LAT + 0.05)


def las(path, points, codes=None, crs=5555, version="1.4"):
    """Write points, those of UTM 32 and altitudes where nothing else is said."""
    header = laspy.LasHeader(point_format=6 if version == "1.4" else 3, version=version)
    header.scales, header.offsets = (0.001, 0.001, 0.001), np.floor(np.min(points, axis=0))
    if crs is not None:
        header.add_crs(pyproj.CRS(crs))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.asarray(points).T
    if codes is not None:
        cloud.classification = np.asarray(codes, dtype=np.uint8)
    cloud.write(path)
    return path


def some(seed, wide=300.0, count=400, high=60.0):
    """Points on the map around the origin, and as local metres by PROJ's own pipeline."""
    rng = np.random.default_rng(seed)
    x, y = TO_UTM.transform(LON, LAT)
    points = rng.uniform((x - wide, y - wide, 400), (x + wide, y + wide, 400 + high), (count, 3)).round(3)
    return points, local(points)


def local(points):
    lon, lat = TO_UTM.transform(points[:, 0], points[:, 1], direction="INVERSE")
    return proj_local(ORIGIN, lat, lon, points[:, 2])


def columns(voxels):
    """The number of the highest voxel of each column, counted from the frame's zero; all below must be occupied."""
    first = np.rint(np.array(voxels.origin) / voxels.step).astype(int)
    heights = voxels.occupied.sum(axis=2)
    assert (voxels.occupied == (np.arange(voxels.occupied.shape[2]) < heights[:, :, None])).all()
    return {(first[0] + i, first[1] + j): first[2] + heights[i, j] - 1 for i, j in np.argwhere(heights)}


def wanted(places, size):
    cells = np.floor(places / size).astype(int)
    found = {}
    for i, j, k in cells.tolist():
        found[i, j] = max(k, found.get((i, j), k))
    return found


@pytest.mark.parametrize("text", [None, "", " ", "\0", "no system at all"])
def test_a_file_that_claims_a_coordinate_system_and_holds_none_is_read_with_the_users(tmp_path, text, refuses):
    """The bit of the header that promises a text is set; the text is missing, empty or none of a system."""
    points, _ = some(1)
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = (0.001, 0.001, 0.001), np.floor(np.min(points, axis=0))
    header.global_encoding.wkt = True
    if text is not None:
        header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(text))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = points.T
    cloud.write(tmp_path / "a.las")
    with refuses():
        of_maps("c", voxels=[tmp_path / "a.las"], area=WIDE)
    built = of_maps("c", voxels=[tmp_path / "a.las"], area=WIDE, reading=sky.Reading(crs="EPSG:5555"))
    assert built.obstacles[0].occupied.any()


@pytest.mark.parametrize(("seed", "wide", "size"), [(1, 300, 2.0), (2, 300, 5.0), (3, 5000, 20.0), (4, 40, 0.5)])
@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_points_are_where_proj_puts_them_and_all_below_is_shut(tmp_path, seed, wide, size, suffix):
    points, places = some(seed, wide)
    scenario = of_maps("a", voxels=[las(tmp_path / f"a{suffix}", points)], origin=ORIGIN, area=WIDE, voxel_size=size)
    (voxels,) = scenario.obstacles
    assert voxels.step == (size, size, size)
    assert columns(voxels) == wanted(places, size)
    assert voxels.origin[2] <= places[:, 2].min()
    assert scenario.bounds.max[2] > places[:, 2].max()
    assert [(s.file, s.gives, s.crs) for s in scenario.sources] == [(f"a{suffix}", "voxels", "EPSG:25832")]


def test_without_area_and_origin_all_of_the_cloud_is_taken(tmp_path):
    points, _ = some(5)
    scenario = of_maps("a", voxels=[las(tmp_path / "a.laz", points)])
    assert abs(scenario.frame.origin.latitude - LAT) < 1e-3
    assert sum(scenario.bounds.max[:2]) == pytest.approx(1100, abs=10)  # 300 m of points, 250 m around
    assert scenario.obstacles[0].step[0] == 2


def test_noise_is_left_out_and_the_ground_where_a_terrain_says_it(tmp_path):
    points, places = some(6, count=600)
    codes = np.resize([2, 7, 18, 5, 6, 1], len(points))
    path, told = las(tmp_path / "a.las", points, codes), []
    options = {"voxels": [path], "origin": ORIGIN, "area": WIDE, "on_note": lambda note: told.append(note.text)}
    (bare,) = of_maps("a", **options).obstacles
    assert columns(bare) == wanted(places[~np.isin(codes, (7, 18))], 2.0)
    told.clear()
    (grown,) = of_maps("a", ground=sky.AboveSea(395), **options).obstacles
    assert columns(grown) == wanted(places[~np.isin(codes, (2, 7, 18))], 2.0)
    assert grown.origin[2] < -5
    assert told[-1].startswith("300 points, 100 of the ground left out, 200 of noise left out; ")


def test_what_is_outside_the_area_is_left_out_and_told(tmp_path):
    points, places = some(7, wide=2000, count=2000)
    told, path = [], las(tmp_path / "a.las", points)
    near = (LON - 0.004, LAT - 0.002, LON + 0.004, LAT + 0.002)
    scenario = of_maps("a", voxels=[path], origin=ORIGIN, area=near, clearance=0.5, on_note=told.append)
    low, high = np.array(scenario.bounds.min[:2]) - 11, np.array(scenario.bounds.max[:2]) + 11
    inside = ((places[:, :2] >= low) & (places[:, :2] <= high)).all(axis=1)
    assert columns(scenario.obstacles[0]) == wanted(places[inside], 2.0)
    assert f"{(~inside).sum():,} outside left out" in told[-1].text
    away = (LON + 1, LAT - 0.002, LON + 1.01, LAT + 0.002)
    nothing = of_maps("a", voxels=[path], area=away, ground=sky.AboveSea(0), on_note=told.append)
    assert nothing.obstacles == ()
    assert told[-1].text == "WARNING: nothing of it stands in the area"


def test_feet_are_feet_and_the_ellipsoid_needs_a_geoid(tmp_path, refuses):
    points, _ = some(8)
    feet = (points / [1, 1, 0.3048]).round(3)
    points = feet * [1, 1, 0.3048]
    places = local(points)
    path = las(tmp_path / "ft.las", feet, crs=pyproj.crs.CompoundCRS("a", [UTM, 8228]))  # NAVD88 height (ft)
    (voxels,) = of_maps("a", voxels=[path], origin=ORIGIN, area=WIDE).obstacles
    assert columns(voxels) == wanted(places, 2.0)
    high = las(tmp_path / "e.las", points + np.array([0, 0, 47.0]), crs=pyproj.CRS(UTM).to_3d())
    with refuses():
        of_maps("a", voxels=[high], origin=ORIGIN, area=WIDE)
    (voxels,) = of_maps("a", voxels=[high], origin=ORIGIN, area=WIDE, geoid=47.0).obstacles
    assert columns(voxels) == wanted(local(points.round(3)), 2.0)


def test_coordinates_that_a_file_does_not_say_are_asked_for(tmp_path, refuses):
    points, places = some(9)
    bare = las(tmp_path / "bare.las", points, crs=None)
    with refuses():
        of_maps("a", voxels=[bare])
    (voxels,) = of_maps("a", voxels=[bare], origin=ORIGIN, area=WIDE, reading=sky.Reading(crs="EPSG:5555")).obstacles
    assert columns(voxels) == wanted(places, 2.0)
    flat = las(tmp_path / "flat.las", points, crs=UTM)
    with refuses():
        of_maps("a", voxels=[flat])
    assert of_maps("a", voxels=[flat], reading=sky.Reading(altitudes="amsl")).obstacles
    feet = las(tmp_path / "feet.las", [(1.5e6, 6e5, 100), (1.5001e6, 6.001e5, 120)], crs=2230)
    with refuses():
        of_maps("a", voxels=[feet], reading=sky.Reading(altitudes="amsl"))
    with refuses():
        of_maps("a", voxels=[tmp_path / "a.ply"])
    with refuses():
        of_maps("a", voxels=[tmp_path / "none.las"])


def test_geotiff_keys_say_what_altitudes_are_counted_from(tmp_path):
    points, places = some(10)
    path = las(tmp_path / "k.las", points, crs=None, version="1.2")
    entries = np.array([(1, 1, 0, 3), (3072, 0, 1, UTM), (4096, 0, 1, 5783), (1024, 0, 1, 1)], dtype="<u2")
    cloud = laspy.read(path)
    cloud.header.vlrs.append(laspy.VLR("LASF_Projection", 34735, "keys", entries.tobytes()))
    cloud.write(path)
    (voxels,) = of_maps("a", voxels=[path], origin=ORIGIN, area=WIDE).obstacles
    assert columns(voxels) == wanted(places, 2.0)


def test_a_header_that_lies_is_not_believed(tmp_path, refuses):
    points, _ = some(11)
    path = las(tmp_path / "a.las", points)
    data = bytearray(path.read_bytes())
    data[179:187] = np.float64(points[:, 0].max() - 100).tobytes()  # the greatest x
    path.write_bytes(data)
    with refuses():
        of_maps("a", voxels=[path], origin=ORIGIN, area=WIDE)


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.95])
def test_a_cloud_that_is_cut_off_is_refused_in_one_sentence(tmp_path, suffix, share):
    path = las(tmp_path / f"a{suffix}", some(12)[0])
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(
        sky.InputError, match=rf"a\{suffix}: cannot be read as LAS, it is cut off or damaged: "
    ) as caught:
        of_maps("a", voxels=[path], origin=ORIGIN, area=WIDE)
    assert "\n" not in str(caught.value)


def test_the_command_takes_clouds(tmp_path, capsys):
    path = las(tmp_path / "a.laz", some(13)[0])
    with pytest.raises(SystemExit) as ended:
        main(
            ["scenario", "build", "--voxels", str(path), "--ground", "395 m amsl", "--voxel-size", "4", "--uav",
             f"{LAT},{LON},90 m agl", "-o", str(tmp_path / "a.json"), "--licence", "a.laz=CC0"]
        )  # fmt: skip
    assert not ended.value.code
    assert "columns of voxels of 4 m" in capsys.readouterr().out
    scenario = sky.read_scenario(tmp_path / "a.json")
    assert scenario.obstacles[0].step[0] == 4
    assert scenario.sources[0].licence == "CC0"


def test_a_start_or_target_in_or_near_a_cloud_is_refused(tmp_path, refuses):
    tower = (*TO_UTM.transform(LON, LAT), 430.0)
    path = las(tmp_path / "a.las", np.array([tower]))
    options = {
        "voxels": [path],
        "ground": sky.AboveSea(395),
        "origin": ORIGIN,
        "clearance": 3.0,
        "ground_clearance": 3.0,
    }
    free = (LAT + 0.001, LON, sky.AboveGround(20))  # UAVs may stray by 1.6 m
    for east, up, safe in ((0, 20, 0), (4, 20, 0), (7, 20, 1), (0, 37, 0), (0, 41, 1), (-5, 20, 1)):
        at = (LAT, LON + east / 75_300, sky.AboveGround(up))  # the voxel is 2 m wide, from the origin on
        for places in ({"uavs": [at]}, {"uavs": [free], "targets": [at]}):
            if safe:
                of_maps("a", **places, **options)
                continue
            with refuses():
                of_maps("a", **places, **options)
