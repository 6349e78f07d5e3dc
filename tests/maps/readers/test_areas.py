"""Areas and lines of surveys from files, beside geodesy of PROJ and what was written."""

import json
import math
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.frame import Origin

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")

ALPS = Origin(latitude=46.8, longitude=9.85, altitude=1500.0)


def placemark(rings, kind="Polygon"):
    """Return a placemark of KML with an outline and holes, longitude and latitude."""
    said = [" ".join(f"{x:.10f},{y:.10f},0" for x, y in ring) for ring in rings]
    if kind == "LineString":
        return f"<Placemark><LineString><coordinates>{said[0]}</coordinates></LineString></Placemark>"
    sides = ["outer", *["inner"] * (len(rings) - 1)]
    bounds = [
        f"<{side}BoundaryIs><LinearRing><coordinates>{ring}</coordinates></LinearRing></{side}BoundaryIs>"
        for side, ring in zip(sides, said, strict=True)
    ]
    return f"<Polygon>{''.join(bounds)}</Polygon>"


def kml(*shapes):
    return f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{"".join(shapes)}</Document></kml>'


def marked(*polygons):
    inner = "".join(polygons)
    whole = f"<MultiGeometry>{inner}</MultiGeometry>" if len(polygons) > 1 else inner
    return f"<Placemark><name>Field</name>{whole}</Placemark>"


def square(x, y, size, origin=ALPS):
    """Return the corners of a square about x, y, metres, as longitude and latitude."""
    h = size / 2
    local = [(x - h, y - h, 0), (x + h, y - h, 0), (x + h, y + h, 0), (x - h, y + h, 0)]
    return [(lon, lat) for lat, lon, _ in sky.to_wgs84(origin, local).tolist()]


def written(path, text):
    path.write_text(text if isinstance(text, str) else json.dumps(text), encoding="utf-8")
    return path


def area_of(regions):
    return sum(shapely.Polygon(one.vertices, one.holes).area for one in regions)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.floats(30, 240), min_size=3, max_size=12),  # edges so short that they get no corners between
    st.floats(-77, 77),
    st.sampled_from([-179.9995, -60.0, 0.0, 9.85, 179.9995]),
)
def test_a_polygon_is_read_as_it_was_written_anywhere_on_the_globe(tmp_path_factory, radii, latitude, longitude):
    origin = Origin(latitude=latitude, longitude=longitude, altitude=0.0)
    turns = 2 * math.pi * np.arange(len(radii)) / len(radii)
    local = np.column_stack([np.cos(turns) * radii, np.sin(turns) * radii, np.zeros(len(radii))])
    ring = [(lon, lat) for lat, lon, _ in sky.to_wgs84(origin, local).tolist()]
    path = tmp_path_factory.mktemp("kml") / "field.kml"
    (region,) = sky.read_area(written(path, kml(marked(placemark([[*ring, ring[0]]])))), origin)
    read, meant = shapely.Polygon(region.vertices), shapely.Polygon(local[:, :2])
    assert len(region.vertices) == len(radii)
    assert read.symmetric_difference(meant).area < 1e-3 * meant.length
    true = abs(pyproj.Geod(ellps="WGS84").polygon_area_perimeter(*zip(*ring, strict=True))[0])
    assert read.area == pytest.approx(true, rel=1e-4)


def test_holes_parts_and_placemarks_become_regions_and_overlaps_count_once(tmp_path):
    holed = placemark([square(0, 0, 200), square(20, 10, 50)])
    far, over = placemark([square(500, 0, 100)]), placemark([square(550, 0, 100)])
    path = written(tmp_path / "field.kml", kml(marked(holed, far), marked(over)))
    regions = sky.read_area(path, ALPS)
    assert sorted(len(one.holes) for one in regions) == [0, 1]
    assert area_of(regions) == pytest.approx(200**2 - 50**2 + 100 * 150, rel=1e-6)
    packed = tmp_path / "field.kmz"
    with zipfile.ZipFile(packed, "w") as archive:
        archive.write(path, "doc.kml")
    assert sky.read_area(packed, ALPS) == regions


@pytest.mark.parametrize(
    ("hole", "share"),
    [
        (square(75, 0, 50), 200**2 - 50**2),  # shares an edge with the outline
        (square(100, 0, 50), 200**2 - 50 * 25),  # lies across it
        ([square(0, 0, 200)[0], *square(0, 0, 100)[1:3]], 200**2 - 7500),  # touches a corner of it
    ],
)
def test_holes_at_the_border_are_cut_out_and_nothing_beside_them_is_lost(tmp_path, hole, share):
    regions = sky.read_area(written(tmp_path / "field.kml", kml(marked(placemark([square(0, 0, 200), hole])))), ALPS)
    assert share - 1e-3 <= area_of(regions) <= share + 0.02 * 400


def test_two_holes_that_touch_are_told_apart(tmp_path):
    holes = [square(-25, -25, 50), square(25, 25, 50)]
    (region,) = sky.read_area(written(tmp_path / "f.kml", kml(marked(placemark([square(0, 0, 200), *holes])))), ALPS)
    assert len(region.holes) == 2
    assert 35000 <= area_of([region]) <= 35000 + 8


def test_open_rings_and_corners_given_twice_change_nothing(tmp_path):
    ring = square(0, 0, 200)
    twice = [ring[0], ring[0], ring[1], *ring[1:], (ring[0][0] + 1e-10, ring[0][1]), ring[0]]
    for name, corners in (("open", ring), ("twice", twice)):
        document = {"type": "Polygon", "coordinates": [corners]}
        (region,) = sky.read_area(written(tmp_path / f"{name}.geojson", document), ALPS)
        assert len(region.vertices) == 4
        assert area_of([region]) == pytest.approx(200**2, rel=1e-6)


def test_a_shapefile_in_another_coordinate_system_lies_where_that_is(tmp_path):
    pyogrio = pytest.importorskip("pyogrio")
    to_lv95 = pyproj.Transformer.from_crs(4326, 2056, always_xy=True)
    corners = [to_lv95.transform(*place) for place in square(100, 50, 300)]
    for suffix, driver in ((".shp", "ESRI Shapefile"), (".gpkg", "GPKG")):
        path = tmp_path / f"field{suffix}"
        shapes = np.array([shapely.to_wkb(shapely.Polygon(corners))], dtype=object)
        columns = {"field_data": [np.array([1])], "fields": ["id"], "geometry_type": "Polygon"}
        pyogrio.raw.write(path, shapes, crs="EPSG:2056", driver=driver, **columns)
        (region,) = sky.read_area(path, ALPS)
        middle = np.mean(region.vertices, axis=0)
        assert np.hypot(*(middle - [100, 50])) < 1.5  # the two datums are known to a metre
        assert area_of([region]) == pytest.approx(300**2, rel=2e-4)
    for beside in (".prj", ".cpg"):
        (tmp_path / "field.shp").with_suffix(beside).unlink(missing_ok=True)
    with pytest.raises(sky.InputError, match=r"field.shp: expected its coordinate system"):
        sky.read_area(tmp_path / "field.shp", ALPS)
    assert sky.read_area(tmp_path / "field.shp", ALPS, crs="EPSG:2056")


def test_lines_are_read_with_their_bends(tmp_path):
    way = [square(0, 0, 200)[k] for k in (0, 1, 2)]
    path = written(tmp_path / "road.kml", kml(placemark([[*way, way[-1]]], "LineString")))
    (line,) = sky.read_lines(path, ALPS)
    assert np.allclose(line, [(-100, -100), (100, -100), (100, 100)], atol=1e-3)
    with pytest.raises(sky.InputError, match=r"road.kml: placemark 1: expected a polygon, found a line; give pattern"):
        sky.read_area(path, ALPS)


def test_what_of_a_file_is_no_area_is_named_and_a_closed_line_may_be_one(tmp_path, refuses):
    ring = "8.7,50.8 8.71,50.8 8.71,50.81 8.7,50.8"
    line = f"<LineString><coordinates>{ring}</coordinates></LineString>"
    outline = f"<LinearRing><coordinates>{ring}</coordinates></LinearRing>"
    polygon = f"<Polygon><outerBoundaryIs>{outline}</outerBoundaryIs></Polygon>"
    point = "<Point><coordinates>8.7,50.8</coordinates></Point>"
    origin = sky.Origin(latitude=50.8, longitude=8.7, altitude=0.0)
    for shapes, said in (
        ((point, polygon, line), "left out, no polygon: placemark 1 (a point) and placemark 3 (a line)"),
        ((polygon,), None),
        (
            (polygon, *[point] * 7),
            "left out, no polygon: " + ", ".join(f"placemark {k} (a point)" for k in range(2, 7)),
        ),
    ):
        path, told = tmp_path / "a.kml", []
        path.write_text(f"<kml>{''.join(f'<Placemark>{one}</Placemark>' for one in shapes)}</kml>", encoding="utf-8")
        assert len(sky.read_area(path, origin, tell=told.append)) == 1
        assert [one.startswith(f"{path}: {said}") for one in told] == [True] * (said is not None)
    assert told[0].endswith(" and 2 more")
    path.write_text(f"<kml><Placemark>{line}</Placemark></kml>", encoding="utf-8")
    with refuses():
        sky.read_area(path, origin)
