"""Zones and buildings from files that other programs write: as they are, or one sentence that says what is wrong."""

import copy
import json
import math
import os
import sys
import time
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyverse.errors import InputError
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")
pytest.importorskip("pyogrio")

from skyverse.maps.georeference.choices import Choices  # noqa: E402
from skyverse.maps.readers.buildings_and_zones import read_features  # noqa: E402

SQUARE = [[7.0, 47.0], [7.001, 47.0], [7.001, 47.001], [7.0, 47.001], [7.0, 47.0]]
COURT = [[7.0004, 47.0004], [7.0006, 47.0004], [7.0006, 47.0006], [7.0004, 47.0006], [7.0004, 47.0004]]
ZONE = {"lower": "0 m agl", "upper": "120 m agl"}
GEOD = pyproj.Geod(ellps="WGS84")


def feature(rings=(SQUARE,), kind="Polygon", **fields):
    return {"type": "Feature", "properties": fields or ZONE, "geometry": {"type": kind, "coordinates": list(rings)}}


def collection(*features, **more):
    return {"type": "FeatureCollection", "features": list(features), **more}


@pytest.fixture
def read(tmp_path):
    def written(document, name="zones.geojson", **choices):
        path = tmp_path / name
        path.write_text(document if isinstance(document, str) else json.dumps(document), encoding="utf-8")
        return read_features(path, Choices(**choices))

    return written


def polygon(one):
    return shapely.Polygon(one.outline, one.holes)


def outcome(path, **choices):
    """Return what is read, or the one sentence that it ends in."""
    try:
        return read_features(path, Choices(**choices)), ""
    except InputError as error:
        return None, str(error)


def refused(read, document, *words, **choices):
    with pytest.raises(InputError) as error:
        read(document, **choices)
    for word in words:
        assert word in str(error.value)
    assert "\n" not in str(error.value)


def test_a_zone_is_its_outline_its_holes_and_its_limits(read):
    (zone,) = read(collection(feature([SQUARE, COURT], name="Lake", kind="Polygon")))
    assert zone.outline.tolist() == SQUARE[:-1]
    assert [hole.tolist() for hole in zone.holes] == [COURT[:-1]]
    assert (zone.low, zone.high, zone.kind, zone.name, zone.risk) == (None, None, "no-fly zone", "Lake", None)
    assert zone.where.endswith("zones.geojson: feature 1")


@pytest.mark.parametrize(
    ("fields", "low", "high"),
    [
        (
            {
                "lowerLimit": 0,
                "upperLimit": 400,
                "uomDimensions": "FT",
                "lowerVerticalReference": "AGL",
                "upperVerticalReference": "AMSL",
            },
            AboveGround(0.0),
            AboveSea(121.92),
        ),
        ({"lower": 10, "upper": 50, "reference": "AMSL", "unit": "m"}, AboveSea(10.0), AboveSea(50.0)),
        ({"min_altitude": "GND", "max_altitude": "400 ft agl"}, None, AboveGround(121.92)),
        ({"lower": "SFC", "upper": "UNL"}, None, None),
        ({"upper": {"value": 100, "unit": "ft", "referenceDatum": "MSL"}}, None, AboveSea(30.48)),
        ({"upper": "100 ft", "reference": "agl"}, None, AboveGround(30.48)),
        ({"upper": "30 home"}, None, AboveHome(30.0)),
        ({"height": 12}, None, AboveGround(12.0)),
        ({"building": "yes", "building:levels": "2"}, None, AboveGround(9.0)),
        ({"nothing": 1}, None, None),
    ],
)
def test_limits_are_read_as_their_schema_means_them(read, fields, low, high):
    (zone,) = read(collection(feature(**fields)))
    for found, meant in ((zone.low, low), (zone.high, high)):
        assert type(found) is type(meant)
        assert meant is None or found.metres == pytest.approx(meant.metres)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"upper": 120}, ("'upper'", "Reading(altitudes=")),
        ({"upper": "120"}, ("'upper'", "Reading(altitudes=")),
        ({"upper": "120 ft"}, ("'upper'", "Reading(altitudes=")),
        ({"upper": "FL95"}, ("flight levels",)),
        ({"upper": 95, "reference": "STD"}, ("'reference'", "AGL or AMSL")),
        ({"upper": 95, "reference": "WGS84"}, ("'reference'", "AGL or AMSL")),
        ({"upper": 95, "reference": "AGL", "unit": "furlong"}, ("'unit'", "M or FT")),
        ({"upper": [1], "reference": "AGL"}, ("'upper'", "[1]")),
        ({"upper": True, "reference": "AGL"}, ("'upper'", "True")),
        ({"upper": 10, "lower": 20, "reference": "AGL"}, ("below the upper",)),
        ({"upper": 10, "ceiling": 20, "reference": "AGL"}, ("'upper'", "'ceiling'")),
    ],
)
def test_what_could_be_either_is_refused_with_file_feature_and_field(read, fields, words):
    refused(read, collection(feature(), feature(**fields)), "zones.geojson: feature 2", *words)


def test_the_user_decides_what_bare_altitudes_are_counted_from(read):
    document = collection(feature(upper=120))
    assert read(document, altitudes="agl")[0].high == AboveGround(120.0)
    assert read(document, altitudes="amsl")[0].high == AboveSea(120.0)


def test_a_field_of_risk_opens_no_zone_unless_the_user_does(read):
    document, told = collection(feature(risk=0.3, **ZONE), feature()), []
    assert [zone.risk for zone in read(document, tell=told.append)] == [None, None]
    assert len(told) == 1
    assert "zones.geojson: 1 with a field 'risk' must not be entered" in told[0]
    assert [zone.risk for zone in read(document, risk=0.5, tell=told.append)] == [0.3, 0.5]
    for wrong in ("much", 0, True):
        refused(read, collection(feature(risk=wrong, **ZONE)), "'risk': expected a number", risk=0.5)
    assert len(told) == 1


def test_buildings_stand_on_the_ground_and_need_a_height(read):
    plain = collection(feature(use="house"))
    refused(read, plain, "feature 1", "Reading.building_height", kind="building")
    (house,) = read(plain, kind="building", building_height=8.0)
    assert (house.kind, house.low, house.high) == ("building", None, AboveGround(8.0))
    (tower,) = read(collection(feature(h_max=31.5)), kind="building", height_field="h_max")
    assert tower.high == AboveGround(31.5)


def test_of_several_heights_the_greatest_counts_and_guesses_are_told(read):
    document, told = collection(feature(height=3, measuredHeight=30), feature(levels=2, **{"building:levels": 4})), []
    assert [one.high.metres for one in read(document, kind="building", tell=told.append)] == [30.0, 15.0]
    assert ["several heights" in sentence for sentence in told] == [True, False]
    assert "1 with a height guessed from levels" in told[1]
    chosen = read(collection(feature(height=3, measuredHeight=30)), kind="building", height_field="height")
    assert chosen[0].high == AboveGround(3.0)


def test_limits_without_a_unit_are_told_once_a_file_unless_the_user_says(read):
    document, told = collection(*[feature(lower=0, upper=100, reference="AGL")] * 3), []
    assert read(document, tell=told.append)[0].high == AboveGround(100.0)
    assert len(told) == 1
    assert "3 limits without a unit taken as metres; give Reading(unit='ft') to" in told[0]
    assert read(document, unit="ft", tell=told.append)[0].high.metres == pytest.approx(30.48)
    assert len(told) == 1


def test_ed_269_gives_a_record_for_each_volume_and_circles_are_circumscribed(read):
    volume = {"uomDimensions": "M", "lowerLimit": 0, "lowerVerticalReference": "AGL"}
    volume |= {"upperLimit": 120, "upperVerticalReference": "AGL"}
    flat = {"type": "Circle", "center": [7.0, 47.0], "radius": 500}
    square = {"type": "Polygon", "coordinates": [SQUARE]}
    volumes = [{**volume, "horizontalProjection": flat}, {**volume, "horizontalProjection": square}]
    closed = {"identifier": "A1", "name": "Airfield", "restriction": "PROHIBITED", "geometry": volumes}
    free = {"identifier": "A2", "restriction": "NO_RESTRICTION", "geometry": volumes[:1]}
    told = []
    disc, zone = read({"title": "zones", "features": [closed, free]}, name="zones.json", tell=told.append)
    assert disc.name == zone.name == "Airfield"
    assert (disc.kind, disc.high) == ("PROHIBITED", AboveGround(120.0))
    middles = (disc.outline + np.roll(disc.outline, -1, axis=0)) / 2
    for places, least, most in ((middles, 500, 500.2), (disc.outline, 500, 501)):
        far = GEOD.inv(np.full(len(places), 7.0), np.full(len(places), 47.0), *places.T)[2]
        assert least <= far.min() <= far.max() <= most
    assert ["restricts nothing" in sentence for sentence in told] == [True]


RADII = [
    ({"radius": 1.5, "radiusUnit": "km"}, 1500),
    ({"radius": 1.5, "radius_uom": "KM"}, 1500),
    ({"radius": 2, "radius_unit": "NM"}, 3704),
    ({"radius": 2, "uomRadius": "nm"}, 3704),
    ({"radius": 1, "radius-units": "Miles"}, 1609.344),
    ({"radius": 1000, "unitOfRadius": "ft"}, 304.8),
    ({"radius": 500, "radiusUnit": "m"}, 500),
    ({"radius": "1.5 km"}, 1500),
    ({"radius": "1.5", "radiusUnit": "km"}, 1500),
    ({"radius": "1.5 km", "radiusUnit": "km"}, 1500),
    ({"radius": "2 NM"}, 3704),
    ({"radius": "1000ft"}, 304.8),
    ({"radius": {"value": 1.5, "unit": "km"}}, 1500),
    ({"radius_km": 1.5}, 1500),
    ({"radiusInMeters": 250, "radius": 250}, 250),
    ({"radius": 1.5, "unit": "km"}, 1500),
    ({"radius": 500, **ZONE}, 500),
    ({"radius": 500, "unit": "ft", "upper": 400, "reference": "AGL"}, 500),
]


@pytest.mark.parametrize(("fields", "metres"), RADII)
def test_a_radius_is_in_the_unit_that_stands_beside_it(read, fields, metres):
    (disc,) = read(collection(feature([7.0, 47.0], "Point", **fields)), buffer=10)
    middles = (disc.outline + np.roll(disc.outline, -1, axis=0)) / 2
    far = GEOD.inv(np.full(len(middles), 7.0), np.full(len(middles), 47.0), *middles.T)[2]
    assert metres <= far.min() <= far.max() <= metres * 1.001


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"radius": 3, "radiusUnit": "furlong"}, "'radiusUnit': expected m, km, ft, NM or mi, found 'furlong'"),
        ({"radius": 3, "radius_uom": 7}, "'radius_uom': expected m, km, ft, NM or mi, found 7"),
        ({"radius": "3 furlongs"}, "'radius': expected m, km, ft, NM or mi, found 'furlongs'"),
        ({"radius": 3, "unit": "deg"}, "'unit': expected m, km, ft, NM or mi, found 'deg'"),
        ({"radius": "wide"}, "'radius': expected metres above zero, at most 100000, found 'wide'"),
        ({"radius": "3 km", "radiusUnit": "m"}, "fields 'radiusUnit' and 'radius' say different units; keep one"),
        ({"radius": 3, "radius_km": 3}, "fields 'radius' and 'radius_km' say different things; keep one"),
        ({"radius": 300, "radiusUnit": "km"}, "'radius': expected metres above zero, at most 100000, found 300"),
        ({"radius": -3}, "'radius': expected metres above zero"),
    ],
)
def test_a_radius_in_no_unit_that_is_known_is_refused(read, fields, words):
    refused(read, collection(feature([7.0, 47.0], "Point", **fields)), "zones.geojson: feature 1", words, buffer=10)


def test_the_unit_of_a_circle_is_not_that_of_the_limits_of_its_zone(read):
    layer = {"upper": 400, "upperReference": "AGL", "uom": "ft"}
    extent = {"subType": "Circle", "radius": 1.5, "uom": "km"}
    part = {"type": "Point", "coordinates": [7.0, 47.0], "extent": extent, "layer": layer}
    (disc,) = read(collection({"type": "Feature", "properties": {}, "geometry": part}))
    assert disc.high == AboveGround(pytest.approx(121.92))
    assert np.ptp(disc.outline[:, 1]) * 111_180 == pytest.approx(3000, rel=0.01)
    volume = {"uomDimensions": "FT", "upperLimit": 400, "upperVerticalReference": "AGL"}
    flat = {"type": "Circle", "center": [7.0, 47.0], "radius": 500}
    told = []
    zone = {"identifier": "A1", "geometry": [{**volume, "horizontalProjection": flat}]}
    (disc,) = read({"features": [zone]}, name="zones.json", tell=told.append)
    assert np.ptp(disc.outline[:, 1]) * 111_180 == pytest.approx(1000, rel=0.01)
    assert "1 with a radius taken as metres, though limits are in feet" in told[0]


def test_a_field_that_is_said_twice_is_refused(read):
    twice = '{"name": "A", "upper": 2500, "upper": 1, "reference": "AMSL"}'
    document = json.dumps(collection(feature())).replace(json.dumps(ZONE), twice)
    words = "zones.geojson: field 'upper': expected it once in an object, found it 2 times: 2500 and 1"
    refused(read, document, words, "where 'name' is 'A'")
    spelt = collection(feature(maxAlt=2500, max_alt=1, reference="AMSL"))
    refused(read, spelt, "feature 1: fields 'maxAlt' and 'max_alt' say different things; keep one")
    data = "".join(f'<Data name="upper"><value>{value}</value></Data>' for value in ("2500 m amsl", "1 m agl"))
    document = kml(f"<ExtendedData>{data}</ExtendedData>" + kml_polygon())
    words = "placemark 1: field 'upper': expected it once, found '2500 m amsl' and '1 m agl'"
    refused(read, document, words, name="zones.kml")


def test_zones_without_limits_are_told(read):
    told = []
    zones = [feature(name="a"), feature(maxHeight=120, name="b"), feature(alt_max="120 m"), feature()]
    read(collection(*zones), tell=told.append)
    assert [sentence.split("zones.geojson: ")[1] for sentence in told] == [
        "3 zones name no limits: shut from the ground up",
        "1 of them have a field 'maxHeight', which is not read as a limit",
        "1 of them have a field 'alt_max', which is not read as a limit",
    ]


def test_ed_318_layers_and_circles_belong_to_their_part(read):
    layer = {"upper": 400, "upperReference": "AGL", "lower": 100, "lowerReference": "AMSL", "uom": "ft"}
    extent = {"subType": "Circle", "radius": 300.0}
    parts = [
        {"type": "Point", "coordinates": [7.0, 47.0], "extent": extent, "layer": layer},
        {"type": "Polygon", "coordinates": [SQUARE], "layer": {**layer, "upper": 50, "lower": None}},
    ]
    fields = {"name": [{"text": "Hospital", "lang": "en"}]}
    geometry = {"type": "GeometryCollection", "geometries": parts}
    disc, zone = read(collection({"type": "Feature", "properties": fields, "geometry": geometry}))
    assert disc.name == "Hospital"
    assert disc.low == AboveSea(pytest.approx(30.48))
    assert disc.high == AboveGround(pytest.approx(121.92))
    assert (zone.low, zone.high) == (None, AboveGround(pytest.approx(15.24)))


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
    first, second = sorted(read_features(path, Choices(kind="building", building_height=4.0)), key=lambda f: f.name)
    assert (first.name, first.high) == ("Haus", AboveGround(12.5))
    assert (second.name, second.high) == ("Hütte", AboveGround(4.0))
    same = shapely.Polygon(SQUARE, [COURT])
    assert polygon(first).symmetric_difference(same).area < 1e-4 * same.area


def written(path, count=1, **options):
    from pyogrio.raw import write

    shapes = shapely.to_wkb(np.array([shapely.Polygon(SQUARE)] * count))
    write(path, shapes, [], [], **{"geometry_type": "Polygon", "crs": "EPSG:4326", **options})


def test_a_shapefile_without_coordinate_system_is_refused_unless_the_user_says(tmp_path):
    path = tmp_path / "zones.shp"
    written(path)
    path.with_suffix(".prj").unlink()
    with pytest.raises(InputError, match=r"\.prj.*Reading\(crs="):
        read_features(path)
    assert len(read_features(path, Choices(crs="EPSG:4326"))) == 1
    with pytest.raises(InputError, match="coordinate system"):
        read_features(path, Choices(crs="EPSG:nonsense"))


def test_a_geopackage_gives_all_its_layers(tmp_path):
    path = tmp_path / "zones.gpkg"
    written(path, layer="a")
    written(path, layer="b", append=True)
    assert [one.where.split(": ")[1] for one in read_features(path)] == ["layer 'a', feature 1", "layer 'b', feature 1"]


def kml(*placemarks):
    return (
        '<?xml version="1.0" encoding="UTF-8"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document><Folder>'
        + "".join(f"<Placemark>{one}</Placemark>" for one in placemarks)
        + "</Folder></Document></kml>"
    )


def kml_polygon(z=None, mode="", extrude="", inner=""):
    ring = " ".join(f"{x},{y}" + ("" if z is None else f",{z}") for x, y in SQUARE)
    outer = f"<outerBoundaryIs><LinearRing><coordinates>\n{ring}\n</coordinates></LinearRing></outerBoundaryIs>"
    return f"<Polygon>{extrude}{mode}{outer}{inner}</Polygon>"


RELATIVE, ABSOLUTE = (f"<altitudeMode>{mode}</altitudeMode>" for mode in ("relativeToGround", "absolute"))
EXTRUDE = "<extrude>1</extrude>"


def test_kml_altitudes_follow_their_mode(read):
    data = '<ExtendedData><Data name="upper"><value>400 ft agl</value></Data></ExtendedData>'
    court = " ".join(f"{x},{y}" for x, y in COURT)
    inner = f"<innerBoundaryIs><LinearRing><coordinates>{court}</coordinates></LinearRing></innerBoundaryIs>"
    document = kml(
        "<name>A &amp; B</name>" + kml_polygon(),
        kml_polygon(60, RELATIVE, EXTRUDE),
        kml_polygon(600, ABSOLUTE, EXTRUDE),
        data + kml_polygon(60, RELATIVE, inner=inner),
        "<MultiGeometry>" + kml_polygon(9) + kml_polygon(5, RELATIVE, EXTRUDE) + "</MultiGeometry>",
    )
    found = read(document, name="zones.kml")
    assert [(one.low, one.high) for one in found] == [
        (None, None),
        (None, AboveGround(60.0)),
        (None, AboveSea(600.0)),
        (None, AboveGround(pytest.approx(121.92))),
        (None, None),
        (None, AboveGround(5.0)),
    ]
    assert found[0].name == "A & B"
    assert [len(one.holes) for one in found] == [0, 0, 0, 1, 0, 0]
    assert found[3].where.endswith("zones.kml: placemark 4")


SPACED = "<outerBoundaryIs><LinearRing><coordinates>7, 47 8, 47</coordinates></LinearRing></outerBoundaryIs>"


@pytest.mark.parametrize(
    ("document", "words"),
    [
        (kml(kml_polygon(60, RELATIVE)), ("placemark 1", "sheet")),
        (kml(kml_polygon(60, "<altitudeMode>relativeToSeaFloor</altitudeMode>")), ("altitudeMode",)),
        (kml("<LineString><coordinates>7,47 7.1,47</coordinates></LineString>"), ("line", "Reading.buffer")),
        (kml(f"<Polygon>{SPACED}</Polygon>"), ("longitude,latitude",)),
        (kml("<name>nothing</name>"), ("found none",)),
        (kml(kml_polygon()).replace("<Placemark>", "<NetworkLink/><Placemark>", 1), ("NetworkLink",)),
        ('<!DOCTYPE x [<!ENTITY a "b">]>' + kml(kml_polygon()), ("document type",)),
        ("<kml>", ("expected XML",)),
        ("", ("expected XML",)),
    ],
)
def test_kml_that_is_no_body_is_refused(read, document, words):
    refused(read, document, "zones.kml", *words, name="zones.kml")


def test_kml_as_gdal_writes_it_reads_the_same(tmp_path):
    from pyogrio.raw import write

    path = tmp_path / "zones.kml"
    lake = shapely.to_wkb(np.array([shapely.Polygon(SQUARE, [COURT])]))
    write(path, lake, [], [], geometry_type="Polygon", crs="EPSG:4326", driver="KML")
    (zone,) = read_features(path)
    assert polygon(zone).equals(shapely.Polygon(SQUARE, [COURT]))


def test_a_kmz_is_read_and_one_that_unpacks_to_too_much_or_is_cut_off_is_refused(tmp_path, monkeypatch):
    from skyverse.maps.readers import kml as reader

    path = tmp_path / "zones.kmz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("doc.kml", kml(kml_polygon()))
    assert len(read_features(path)) == 1
    monkeypatch.setattr(reader, "MAX_UNPACKED", 100)
    with pytest.raises(InputError, match="unpacked"):
        read_features(path)
    monkeypatch.undo()
    whole = path.read_bytes()
    for cut in range(0, len(whole), 7):
        path.write_bytes(whole[:cut])
        with pytest.raises(InputError, match=r"zones\.kmz"):
            read_features(path)


def test_coordinates_that_cannot_be_degrees_are_refused_with_a_hint(read):
    swapped = [[7, 95], [7.1, 95], [7.1, 95.1]]
    metres = [[2600000, 1200000], [2600010, 1200000], [2600010, 1200010]]
    refused(read, collection(feature([swapped])), "feature 1", "swapped")
    refused(read, collection(feature([metres])), "metres", "say its coordinate system")


def test_coordinates_known_to_some_metres_are_told(read):
    told = []
    kansas = [[x - 107, y - 7] for x, y in SQUARE]
    nad27 = {"type": "name", "properties": {"name": "EPSG:4267"}}  # dozens of operations, by state
    read(collection(feature([kansas]), crs=nad27), tell=told.append)
    assert [sentence.split(": ", 1)[1] for sentence in told] == ["coordinates in NAD27 are known to 7 m on the globe"]


def test_an_older_crs_member_is_followed(read):
    there = pyproj.Transformer.from_crs("OGC:CRS84", "EPSG:2056", always_xy=True)
    ring = [list(there.transform(x, y)) for x, y in SQUARE]
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::2056"}}
    (zone,) = read(collection(feature([ring]), crs=crs))
    assert np.allclose(zone.outline, SQUARE[:-1], atol=1e-8)
    refused(read, collection(feature(), crs={"type": "link"}), "'crs'")


def test_a_zone_across_the_antimeridian_stays_in_one_piece(read):
    whole = shapely.box(179.9, -17, 180.1, -16.9)
    jumping = [[179.9, -17], [-179.9, -17], [-179.9, -16.9], [179.9, -16.9], [179.9, -17]]
    west = [[-180, -17], [-179.9, -17], [-179.9, -16.9], [-180, -16.9], [-180, -17]]
    east = [[179.9, -17], [180, -17], [180, -16.9], [179.9, -16.9], [179.9, -17]]
    for document in (feature([jumping]), feature([[east], [west]], "MultiPolygon")):
        (zone,) = read(collection(document))
        assert polygon(zone).symmetric_difference(whole).area < 1e-9
    pole = [[-120, 80], [0, 80], [120, 80], [-120, 80]]
    refused(read, collection(feature([pole])), "feature 1", "pole")


@given(st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), min_size=3, max_size=9))
def test_a_repaired_outline_loses_nothing_that_it_winds_around(tmp_path_factory, corners):
    path = tmp_path_factory.mktemp("zones") / "zones.geojson"
    ring = [[7 + x / 1024, 47 + y / 1024] for x, y in corners]
    path.write_text(json.dumps(collection(feature([ring]))))
    meant = shapely.Polygon(ring)
    odd_even = shapely.make_valid(meant, method="linework")
    told = []
    found, message = outcome(path, tell=told.append)
    if found is None:
        assert "without an area" in message
        assert odd_even.area < 1e-12
        return
    whole = shapely.union_all([polygon(one) for one in found])
    assert whole.buffer(1e-9).covers(odd_even.buffer(0))
    assert whole.difference(meant.convex_hull.buffer(1e-9)).area < 1e-15
    assert all(polygon(one).is_valid for one in found)
    assert bool(told) == (not meant.is_valid)


def test_an_outline_that_goes_around_twice_has_no_hole(read):
    twice = [[7, 47], [7.003, 47], [7.003, 47.003], [7, 47.003], [7, 47.001], [7.001, 47.001]]
    twice += [[7.002, 47.001], [7.002, 47.002], [7.001, 47.002], [7.001, 47]]
    (zone,) = read(collection(feature([twice])))
    assert not zone.holes
    assert polygon(zone).covers(shapely.Point(7.0015, 47.0015))


def test_holes_that_leave_the_outline_are_filled_rather_than_cutting_it(read):
    outside = [[x + 0.0005, y] for x, y in SQUARE]
    told = []
    (zone,) = read(collection(feature([SQUARE, outside])), tell=told.append)
    assert polygon(zone).equals(shapely.Polygon(SQUARE))
    assert "repaired" in told[0]


def test_unclosed_rings_repeated_corners_and_altitudes_of_zero_change_nothing(read):
    ring = [[*place, 0.0] for place in [SQUARE[0], *SQUARE[:-1]]]
    (zone,) = read(collection(feature([ring])))
    assert polygon(zone).equals(shapely.Polygon(SQUARE))
    assert len(zone.outline) == 4


def test_corners_with_altitudes_need_to_say_what_they_are_counted_from(read):
    document = collection(feature([[[*place, 30.0] for place in SQUARE]], use="none"))
    refused(read, document, "feature 1", "30", "Reading(altitudes=")
    assert read(document, altitudes="amsl")[0].high == AboveSea(30.0)


def test_lines_and_points_get_a_width_or_are_refused(read):
    line = feature([[7.0, 47.0], [7.01, 47.0]], "LineString")
    refused(read, collection(line), "line", "Reading.buffer")
    refused(read, collection(feature([7.0, 47.0], "Point")), "point", "Reading.buffer")
    (disc,) = read(collection(feature([7.0, 47.0], "Point", radius=50, **ZONE)))
    assert abs(GEOD.geometry_area_perimeter(polygon(disc))[0]) == pytest.approx(math.pi * 50**2, rel=0.01)
    (strip,) = read(collection(line), buffer=20.0)
    length = GEOD.inv(7.0, 47.0, 7.01, 47.0)[2]
    area = abs(GEOD.geometry_area_perimeter(polygon(strip))[0])
    assert length * 40 + math.pi * 400 <= area <= (length * 40 + math.pi * 400) * 1.02


def test_features_without_geometry_are_left_out_and_told(read):
    told = []
    nothing = {"type": "Feature", "properties": {}, "geometry": None}
    empty = feature([], "Polygon")
    assert len(read(collection(nothing, empty, feature()), tell=told.append)) == 1
    assert [sentence.split(": ")[1] for sentence in told] == ["feature 1", "feature 2"]
    refused(read, collection(nothing), "found none")


def test_collections_are_the_sum_of_their_parts(read):
    square = {"type": "Polygon", "coordinates": [SQUARE]}
    other = {"type": "MultiPolygon", "coordinates": [[[[x + 1, y] for x, y in SQUARE]]]}
    geometry = {"type": "GeometryCollection", "geometries": [square, other]}
    assert len(read(collection({"type": "Feature", "properties": {}, "geometry": geometry}))) == 2
    assert len(read(square)) == 1
    assert len(read(feature())) == 1


def test_long_edges_have_corners_between_and_lose_nothing(read):
    (zone,) = read(collection(feature([[[7, 47], [7.5, 47], [7.25, 47.5]]])))
    steps = np.hypot(*(zone.outline - np.roll(zone.outline, 1, axis=0)).T)
    assert steps.max() <= 0.005 + 1e-12
    assert polygon(zone).area == pytest.approx(0.125, rel=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "not json",
        "[]",
        "null",
        "3",
        '"x"',
        "{}",
        '{"type": "FeatureCollection"}',
        '{"type": "Topology"}',
        '{"type": "FeatureCollection", "features": []}',
        '{"type": "FeatureCollection", "features": {}}',
        '{"features": [NaN]}',
        "[" * 100_000,
        '{"features": ' + "[" * 100_000,
        "\ufeff{",
        "1" * 5000,
    ],
)
def test_what_is_no_geojson_ends_in_one_sentence(read, text):
    refused(read, text, "zones.geojson")


def places_in(value, path=()):
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, one in inner:
        yield from places_in(one, (*path, key))


CIRCLE = {"type": "Circle", "center": [7, 47], "radius": 9}
LAYERED = {"type": "Polygon", "coordinates": [SQUARE], "layer": {"upper": 5, "upperReference": "AGL", "uom": "m"}}
WHOLE = collection(
    feature([SQUARE, COURT], name="a", lower=0, upper=9, reference="AGL", risk=1),
    feature([[SQUARE]], "MultiPolygon", radius=3, height=5),
    {"geometry": [{"upperLimit": 5, "upperVerticalReference": "AGL", "horizontalProjection": CIRCLE}]},
    {"properties": {}, "geometry": {"type": "GeometryCollection", "geometries": [LAYERED]}},
    crs={"type": "name", "properties": {"name": "EPSG:4326"}},
)


@pytest.mark.parametrize("wrong", [None, True, "x", "", -1, 1e300, 10**400, [], {}, [[]], [None], {"a": 1}, "\ud800"])
def test_a_wrong_type_at_any_place_of_the_file_is_read_or_refused_in_one_sentence(tmp_path, wrong):
    path = tmp_path / "zones.geojson"
    refusals = 0
    for place in places_in(WHOLE):
        document = copy.deepcopy(WHOLE)
        if place:
            holder = document
            for key in place[:-1]:
                holder = holder[key]
            holder[place[-1]] = wrong
        else:
            document = wrong
        path.write_text(json.dumps(document))
        found, message = outcome(path)
        if found is None:
            assert str(path) in message
            assert "\n" not in message
            refusals += 1
        else:
            assert all(polygon(one).is_valid and np.isfinite(one.outline).all() for one in found)
    assert refusals > 20


@given(st.data())
def test_broken_bytes_are_read_or_refused_in_one_sentence(tmp_path_factory, data):
    text = data.draw(st.sampled_from([json.dumps(WHOLE), kml("<name>x</name>" + kml_polygon(60, RELATIVE, EXTRUDE))]))
    content = bytearray(text.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    content = content[: data.draw(st.one_of(st.just(len(content)), st.integers(0, len(content))))]
    path = tmp_path_factory.mktemp("broken") / ("zones.geojson" if text.startswith("{") else "zones.kml")
    path.write_bytes(content)
    found, message = outcome(path)
    assert found or str(path) in message


def test_a_shapefile_cut_off_anywhere_is_refused(tmp_path):
    path = tmp_path / "zones.shp"
    written(path, 3)
    whole = path.read_bytes()
    for cut in range(0, len(whole), 50):
        path.write_bytes(whole[:cut])
        with pytest.raises(InputError, match=r"zones\.shp"):
            read_features(path)


@pytest.mark.parametrize(
    "suffix", [".gpkg", ".fgb", ".shp", ".geojson", ".kml", ".kmz", ".osm", ".pbf", ".json", ".txt"]
)
def test_a_file_of_another_kind_or_none_at_all_is_refused(tmp_path, suffix):
    path = tmp_path / f"x{suffix}"
    with pytest.raises(InputError, match=r"no such file|expected a file"):
        read_features(path)
    path.write_bytes(os.urandom(200))
    with pytest.raises(InputError, match=r"expected|cannot"):
        read_features(path)


@pytest.mark.parametrize(
    ("choices", "field"),
    [
        ({"building_height": -1.0}, "building_height"),
        ({"buffer": 0.0}, "buffer"),
        ({"unit": "km"}, "unit"),
        ({"altitudes": "fl"}, "altitudes"),
        ({"lod": "nan"}, "lod"),
    ],
)
def test_a_choice_that_cannot_be_is_refused_by_the_name_of_its_field(read, choices, field):
    refused(read, collection(feature()), f"Reading.{field}: expected", **choices)


def test_a_missing_library_is_named_with_the_line_that_installs_it(read, monkeypatch):
    monkeypatch.setitem(sys.modules, "shapely", None)
    refused(read, collection(feature()), 'pip install "skyverse[maps]"', "shapely")


@pytest.mark.slow
def test_five_thousand_footprints_are_read_in_seconds(read):
    rings = [[[x + 7 + k % 200 / 100, y + k // 200 / 100] for x, y in SQUARE] for k in range(5_000)]
    text = json.dumps(collection(*(feature([ring], height=5 + k % 9) for k, ring in enumerate(rings))))
    start = time.process_time()
    assert len(read(text, kind="building")) == 5_000
    assert time.process_time() - start < 6


@pytest.mark.parametrize("suffix", [".gpkg", ".fgb", ".shp", ".kml", ".kmz", ".geojson"])
def test_a_file_that_is_cut_off_is_said_to_be(tmp_path, suffix):
    import pyogrio

    whole = tmp_path / f"whole{suffix}"
    if suffix == ".kmz":
        with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("doc.kml", "<kml>" + "<Placemark/>" * 100 + "</kml>")
    elif suffix == ".kml":
        whole.write_text("<kml>" + "<Placemark/>" * 100 + "</kml>")
    elif suffix == ".geojson":
        whole.write_text(json.dumps(collection(feature(), feature())))
    else:
        shape = np.array([shapely.to_wkb(shapely.Polygon(SQUARE))] * 20, dtype=object)
        pyogrio.raw.write(whole, shape, [], [], geometry_type="Polygon", crs="EPSG:4326")
    data = whole.read_bytes()
    for share in (0.1, 0.5, 0.9):
        whole.write_bytes(data[: int(share * len(data))])
        with pytest.raises(InputError, match=rf"whole\{suffix}: .*cut off") as caught:
            read_features(whole)
        assert "\n" not in str(caught.value)
