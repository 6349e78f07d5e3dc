"""Tables that GDAL reads: Shapefile, GeoPackage, FlatGeobuf."""

import numpy as np
import pytest

import skyverse as sky
from altitudes import About

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")
pytest.importorskip("pyogrio")

from zones import COURT, SQUARE, polygon, read_file  # noqa: E402


@pytest.mark.parametrize("suffix", [".shp", ".gpkg", ".fgb"])
def test_tables_come_back_from_their_coordinates_with_their_fields(tmp_path, suffix):
    from pyogrio.raw import write

    there = pyproj.Transformer.from_crs("OGC:CRS84", "EPSG:2056", always_xy=True)
    house = shapely.transform(shapely.Polygon(SQUARE, [COURT]), there.transform, interleaved=False)
    hut = shapely.transform(shapely.box(7.01, 47.0, 7.0101, 47.0001), there.transform, interleaved=False)
    path = tmp_path / f"houses{suffix}"
    fields = [np.array([12.5, np.nan]), np.array(["Haus", "Hütte"], dtype=object)]
    shapes = shapely.to_wkb(np.array([house, hut]))
    write(path, shapes, fields, ["height", "name"], geometry_type="Polygon", crs="EPSG:2056")
    first, second = sorted(read_file(path, kind="building", building_height=4.0, unit="m"), key=lambda f: f.name)
    assert (first.name, first.high) == ("Haus", sky.AboveGround(12.5))
    assert (second.name, second.high) == ("Hütte", sky.AboveGround(4.0))
    same = shapely.Polygon(SQUARE, [COURT])
    assert polygon(first).symmetric_difference(same).area < 1e-4 * same.area


def written(path, count=1, **options):
    from pyogrio.raw import write

    shapes = shapely.to_wkb(np.array([shapely.Polygon(SQUARE)] * count))
    write(path, shapes, [], [], **{"geometry_type": "Polygon", "crs": "EPSG:4326", **options})


def test_a_shapefile_without_coordinate_system_is_refused_unless_the_user_says(tmp_path, refuses):
    path = tmp_path / "zones.shp"
    written(path)
    path.with_suffix(".prj").unlink()
    with refuses():
        read_file(path)
    assert len(read_file(path, crs="EPSG:4326")) == 1
    with refuses():
        read_file(path, crs="EPSG:nonsense")


def test_a_geopackage_gives_all_its_layers(tmp_path):
    path = tmp_path / "zones.gpkg"
    written(path, layer="a")
    written(path, layer="b", append=True)
    assert [one.where.split(": ")[1] for one in read_file(path)] == ["layer 'a', feature 1", "layer 'b', feature 1"]


def test_a_shapefile_cut_off_anywhere_is_refused(tmp_path, refuses):
    path = tmp_path / "zones.shp"
    written(path, 3)
    whole = path.read_bytes()
    for cut in range(0, len(whole), 50):
        path.write_bytes(whole[:cut])
        with refuses():
            read_file(path)


CALIFORNIA, UTM = "EPSG:2230", "EPSG:26911"  # in US survey feet, and in metres
NAVD88_FT, NAVD88_M = "EPSG:6360", "EPSG:5703"


def roofs(path, crs, z=100.0):
    """A zone in San Diego whose corners have altitudes, in a coordinate system."""
    from pyogrio.raw import write

    there = pyproj.Transformer.from_crs("OGC:CRS84", pyproj.CRS(crs).to_2d(), always_xy=True)
    flat = shapely.transform(shapely.box(-117.01, 32.8, -117.0, 32.81), there.transform, interleaved=False)
    write(path, shapely.to_wkb(np.array([shapely.force_3d(flat, z)])), [], [], geometry_type="Polygon Z", crs=crs)


@pytest.mark.parametrize("suffix", [".shp", ".gpkg", ".fgb"])
@pytest.mark.parametrize(
    ("crs", "unit", "metres"),
    [
        (CALIFORNIA, None, None),
        ("EPSG:4326", None, None),
        (CALIFORNIA, "ft", 30.48),
        (CALIFORNIA, "m", 100),
        (UTM, None, 100),
        (UTM, "ft", 30.48),
        (f"{CALIFORNIA}+{NAVD88_FT[5:]}", None, 1200 / 3937 * 100),
        (f"{UTM}+{NAVD88_FT[5:]}", "m", 1200 / 3937 * 100),  # the file says it
        (f"{CALIFORNIA}+{NAVD88_M[5:]}", None, 100),
    ],
)
def test_altitudes_of_corners_are_in_the_unit_that_is_said_or_refused(tmp_path, suffix, crs, unit, metres, refuses):
    path = tmp_path / f"roofs{suffix}"
    roofs(path, crs)
    if metres is None:
        with refuses():
            read_file(path, altitudes="amsl")
        return
    (zone,) = read_file(path, altitudes="amsl", unit=unit)
    assert zone.high == About(sky.AboveSea, metres)
    if "+" in crs:  # its heights are those above the sea
        assert read_file(path, unit=unit)[0].high == zone.high


def test_altitudes_of_corners_above_the_ellipsoid_are_refused(tmp_path, refuses):
    roofs(tmp_path / "roofs.gpkg", "EPSG:4979")
    with refuses():
        read_file(tmp_path / "roofs.gpkg", altitudes="amsl", unit="m")
