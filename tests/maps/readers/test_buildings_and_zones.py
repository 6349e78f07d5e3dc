"""Buildings and zones from files that other programs write: as they are, or one sentence that says what is wrong."""

import copy
import json
import os
import sys
import time
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from altitudes import About

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")
pytest.importorskip("pyogrio")

from zones import (  # noqa: E402
    COURT,
    EXTRUDE,
    RELATIVE,
    SQUARE,
    ZONE,
    collection,
    feature,
    kml,
    kml_polygon,
    outcome,
    polygon,
    read_file,
)

GEOD = pyproj.Geod(ellps="WGS84")


def test_a_field_of_risk_opens_no_zone_unless_the_user_does(read, refuses):
    document, told = collection(feature(risk=0.3, **ZONE), feature()), []
    assert [zone.risk for zone in read(document, tell=told.append)] == [None, None]
    assert len(told) == 1
    assert "zones.geojson: 1 with a field 'risk' must not be entered" in told[0]
    assert [zone.risk for zone in read(document, risk=0.5, tell=told.append)] == [0.3, 0.5]
    for wrong in ("much", 0, True):
        with refuses():
            read(collection(feature(risk=wrong, **ZONE)), risk=0.5)
    assert len(told) == 1


@pytest.mark.parametrize(
    "name", ["office space", "flyover", "skyspace museum", "no-fly zone", "Geofence Ltd", "tower", None]
)
def test_buildings_are_solid_and_zones_are_not_whatever_they_are_called(read, name):
    said = {} if name is None else {"category": name, "name": name}
    assert [one.solid for one in read(collection(feature(**said, height="10 m")), kind="building")] == [True]
    assert [one.solid for one in read(collection(feature(**said, **ZONE)))] == [False]
    assert [one.solid for one in read(collection(feature(building="office", height="10 m")))] == [True]


def test_buildings_stand_on_the_ground_and_need_a_height(read, refuses):
    plain = collection(feature(use="house"))
    with refuses():
        read(plain, kind="building")
    (house,) = read(plain, kind="building", building_height=8.0)
    assert (house.kind, house.low, house.high) == ("building", None, sky.AboveGround(8.0))
    (tower,) = read(collection(feature(h_max="31.5 m")), kind="building", height_field="h_max")
    assert tower.high == sky.AboveGround(31.5)


def test_of_several_heights_the_greatest_counts_and_guesses_are_told(read):
    document, told = (
        collection(feature(height="3 m", measuredHeight="30 m"), feature(levels=2, **{"building:levels": 4})),
        [],
    )
    assert [one.high.metres for one in read(document, kind="building", tell=told.append)] == [30.0, 15.0]
    assert ["several heights" in sentence for sentence in told] == [True, False]
    assert "1 with a height guessed from levels" in told[1]
    chosen = read(collection(feature(height="3 m", measuredHeight=30)), kind="building", height_field="height")
    assert chosen[0].high == sky.AboveGround(3.0)


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
    assert (disc.kind, disc.high) == ("PROHIBITED", sky.AboveGround(120.0))
    middles = (disc.outline + np.roll(disc.outline, -1, axis=0)) / 2
    for places, least, most in ((middles, 500, 500.2), (disc.outline, 500, 501)):
        far = GEOD.inv(np.full(len(places), 7.0), np.full(len(places), 47.0), *places.T)[2]
        assert least <= far.min() <= far.max() <= most
    assert ["restricts nothing" in sentence for sentence in told] == [True]


@pytest.mark.parametrize("field", ["restriction", "type"])
def test_only_zones_without_restriction_are_left_out(read, field):
    # ED-269 says it in `restriction`, ED-318 in `type`; whoever needs an authorisation or meets conditions has to ask
    values = ("PROHIBITED", "REQ_AUTHORISATION", "REQ_AUTHORIZATION", "CONDITIONAL", "NO_RESTRICTION", "no restriction")
    told = []
    zones = [feature(**{field: value, "upper": "100 m agl", "name": value}) for value in values]
    kept = read(collection(*zones), tell=told.append)
    assert [zone.name for zone in kept] == list(values[:4])
    assert [zone.kind for zone in kept] == list(values[:4])
    assert ["restricts nothing" in sentence for sentence in told] == [True, True]


SCHEDULE = {"day": ["MON"], "startTime": "08:00Z", "endTime": "16:00Z"}


@pytest.mark.parametrize(
    ("fields", "warned"),
    [
        ({"applicability": [{"permanent": "YES"}]}, False),
        ({"applicability": [{"permanent": "NO", "schedule": [SCHEDULE]}]}, True),
        ({"limitedApplicability": [{"startDateTime": "2026-05-01T08:00:00Z", "endDateTime": None}]}, True),
        ({"limitedApplicability": []}, False),
        ({"startDateTime": "2026-05-01T08:00:00Z"}, True),
        ({"valid_until": 20260501}, True),
        ({"TIMESOFUSE": "CONTINUOUS"}, False),
        ({"TIMESOFUSE": "SR-SS"}, True),
        ({"hoursOfOperation": {"operatingHours": [{"dayOfWeek": 0, "sunrise": True}]}}, True),
        ({"startTime": ""}, False),
        ({"building": "yes", "height": "9 m", "startTime": "08:00"}, False),
    ],
)
def test_zones_with_times_are_always_active_and_the_pilot_is_told(read, fields, warned):
    told = []
    assert len(read(collection(feature(**fields), feature(**fields)), tell=told.append)) == 2
    warnings = [sentence.split("zones.geojson: ")[1] for sentence in told if "WARNING" in sentence]
    assert len(warnings) == warned
    assert all(sentence.startswith("WARNING: 2 with times") for sentence in warnings)


def test_heights_of_buildings_without_a_unit_are_in_the_unit_that_is_given(read):
    fields = ({"height": 100}, {"height": "100"}, {"height": "100 m"}, {"height": "100 ft"}, {"building:levels": 10})
    document = collection(*(feature(**one) for one in fields))
    metres = [house.high.metres for house in read(document, kind="building", unit="ft")]
    assert metres == pytest.approx([30.48, 30.48, 100, 30.48, 33])
    low = read(collection(feature(height=100, min_height=50)), kind="building", unit="ft")[0].low
    assert low == About(sky.AboveGround, 15.24)
    assert [house.high.metres for house in read(document, kind="building", unit="m")][:2] == [100, 100]


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
    assert disc.low == About(sky.AboveSea, 30.48)
    assert disc.high == About(sky.AboveGround, 121.92)
    assert (zone.low, zone.high) == (None, About(sky.AboveGround, 15.24))


def test_coordinates_that_cannot_be_degrees_are_refused_with_a_hint(read, refuses):
    swapped = [[7, 95], [7.1, 95], [7.1, 95.1]]
    metres = [[2600000, 1200000], [2600010, 1200000], [2600010, 1200010]]
    with refuses():
        read(collection(feature([swapped])))
    with refuses():
        read(collection(feature([metres])))


def test_coordinates_known_to_some_metres_are_told(read):
    told = []
    kansas = [[x - 107, y - 7] for x, y in SQUARE]
    nad27 = {"type": "name", "properties": {"name": "EPSG:4267"}}  # dozens of operations, by state
    read(collection(feature([kansas]), crs=nad27), tell=told.append)
    assert [sentence.split(": ", 1)[1] for sentence in told] == ["coordinates in NAD27 are known to 7 m on the globe"]


def test_an_older_crs_member_is_followed(read, refuses):
    there = pyproj.Transformer.from_crs("OGC:CRS84", "EPSG:2056", always_xy=True)
    ring = [list(there.transform(x, y)) for x, y in SQUARE]
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::2056"}}
    (zone,) = read(collection(feature([ring]), crs=crs))
    assert np.allclose(zone.outline, SQUARE[:-1], atol=1e-8)
    with refuses():
        read(collection(feature(), crs={"type": "link"}))


def test_a_zone_across_the_antimeridian_stays_in_one_piece(read, refuses):
    whole = shapely.box(179.9, -17, 180.1, -16.9)
    jumping = [[179.9, -17], [-179.9, -17], [-179.9, -16.9], [179.9, -16.9], [179.9, -17]]
    west = [[-180, -17], [-179.9, -17], [-179.9, -16.9], [-180, -16.9], [-180, -17]]
    east = [[179.9, -17], [180, -17], [180, -16.9], [179.9, -16.9], [179.9, -17]]
    for document in (feature([jumping]), feature([[east], [west]], "MultiPolygon")):
        (zone,) = read(collection(document))
        assert polygon(zone).symmetric_difference(whole).area < 1e-9
    pole = [[-120, 80], [0, 80], [120, 80], [-120, 80]]
    with refuses():
        read(collection(feature([pole])))


def test_features_without_geometry_are_left_out_and_told(read, refuses):
    told = []
    nothing = {"type": "Feature", "properties": {}, "geometry": None}
    empty = feature([], "Polygon")
    assert len(read(collection(nothing, empty, feature()), tell=told.append)) == 1
    assert [sentence.split(": ")[1] for sentence in told] == ["feature 1", "feature 2"]
    with refuses():
        read(collection(nothing))


def test_collections_are_the_sum_of_their_parts(read):
    square = {"type": "Polygon", "coordinates": [SQUARE]}
    other = {"type": "MultiPolygon", "coordinates": [[[[x + 1, y] for x, y in SQUARE]]]}
    geometry = {"type": "GeometryCollection", "geometries": [square, other]}
    assert len(read(collection({"type": "Feature", "properties": {}, "geometry": geometry}))) == 2
    assert len(read(square)) == 1
    assert len(read(feature())) == 1


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
    with pytest.raises(sky.InputError, match=r"zones\.geojson") as error:
        read(text)
    assert "\n" not in str(error.value)


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


@pytest.mark.parametrize(
    "suffix", [".gpkg", ".fgb", ".shp", ".geojson", ".kml", ".kmz", ".osm", ".pbf", ".json", ".txt"]
)
def test_a_file_of_another_kind_or_none_at_all_is_refused(tmp_path, suffix):
    path = tmp_path / f"x{suffix}"
    with pytest.raises(sky.InputError, match=r"no such file|expected a file"):
        read_file(path)
    path.write_bytes(os.urandom(200))
    with pytest.raises(sky.InputError, match=r"expected|cannot"):
        read_file(path)


@pytest.mark.parametrize(
    "choices", [{"building_height": -1.0}, {"buffer": 0.0}, {"unit": "km"}, {"altitudes": "fl"}, {"lod": "nan"}]
)
def test_a_choice_that_cannot_be_is_refused_by_the_name_of_its_field(read, choices, refuses):
    with refuses():
        read(collection(feature()), **choices)


def test_a_missing_library_is_named_with_the_line_that_installs_it(read, monkeypatch, refuses):
    monkeypatch.setitem(sys.modules, "pyproj", None)
    with refuses():
        read(collection(feature()))


def test_five_thousand_footprints_are_read_in_seconds(read):
    rings = [[[x + 7 + k % 200 / 100, y + k // 200 / 100] for x, y in SQUARE] for k in range(5_000)]
    text = json.dumps(collection(*(feature([ring], height=f"{5 + k % 9} m") for k, ring in enumerate(rings))))
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
        with pytest.raises(sky.InputError, match=rf"whole\{suffix}: .*cut off") as caught:
            read_file(whole)
        assert "\n" not in str(caught.value)
