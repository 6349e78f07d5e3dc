"""Where zones begin and end, as their files say it."""

import json

import pytest

import skyverse as sky

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")
pytest.importorskip("pyogrio")

from zones import SQUARE, ZONE, collection, feature, kml, kml_polygon  # noqa: E402


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
            sky.AboveGround(0.0),
            sky.AboveSea(121.92),
        ),
        ({"lower": 10, "upper": 50, "reference": "AMSL", "unit": "m"}, sky.AboveSea(10.0), sky.AboveSea(50.0)),
        ({"min_altitude": "GND", "max_altitude": "400 ft agl"}, None, sky.AboveGround(121.92)),
        ({"lower": "SFC", "upper": "UNL"}, None, None),
        ({"upper": {"value": 100, "unit": "ft", "referenceDatum": "MSL"}}, None, sky.AboveSea(30.48)),
        ({"upper": "100 ft", "reference": "agl"}, None, sky.AboveGround(30.48)),
        ({"upper": "400 agl", "uom": "ft"}, None, sky.AboveGround(121.92)),
        ({"upper": "30 m home"}, None, sky.AboveHome(30.0)),
        ({"height": "12 m"}, None, sky.AboveGround(12.0)),
        ({"building": "yes", "building:levels": "2"}, None, sky.AboveGround(9.0)),
        ({"nothing": 1}, None, None),
    ],
)
def test_limits_are_read_as_their_schema_means_them(read, fields, low, high):
    (zone,) = read(collection(feature(**fields)))
    for found, meant in ((zone.low, low), (zone.high, high)):
        assert type(found) is type(meant)
        assert meant is None or found.metres == pytest.approx(meant.metres)


@pytest.mark.parametrize(
    "fields",
    [
        {"upper": 120},
        {"upper": "120"},
        {"upper": "120 ft"},
        {"upper": "FL95"},
        {"upper": "400 agl"},
        {"upper": 95, "reference": "STD"},
        {"upper": 95, "reference": "WGS84"},
        {"upper": 95, "reference": "AGL", "unit": "furlong"},
        {"upper": [1], "reference": "AGL"},
        {"upper": True, "reference": "AGL"},
        {"upper": 10, "lower": 20, "reference": "AGL", "uom": "M"},
        {"upper": 10, "ceiling": 20, "reference": "AGL", "uom": "M"},
    ],
)
def test_what_could_be_either_is_refused_with_file_feature_and_field(read, fields, refuses):
    with refuses():
        read(collection(feature(), feature(**fields)))


def test_the_user_decides_what_bare_altitudes_are_counted_from(read):
    document = collection(feature(upper=120))
    assert read(document, altitudes="agl", unit="m")[0].high == sky.AboveGround(120.0)
    assert read(document, altitudes="amsl", unit="m")[0].high == sky.AboveSea(120.0)


@pytest.mark.parametrize(
    "fields",
    [
        {"lower": 0, "upper": 100, "reference": "AGL"},
        {"lower": "0", "upper": "100 agl", "reference": "AGL"},
        {"lower": 0, "upper": {"value": 100, "referenceDatum": "AGL"}, "reference": "AGL"},
        {"height": 100},
        {"building": "yes", "height": "100"},
        {"building": "yes", "building:levels": 3, "roof:height": 100, "height": "0 m"},
    ],
)
def test_limits_and_heights_without_a_unit_need_one_of_the_user(read, fields, refuses):
    document, told = collection(feature(**fields)), []
    with refuses():
        read(document)
    by_unit = [read(document, unit=unit, tell=told.append)[0].high.metres for unit in ("m", "ft")]
    assert by_unit[0] - by_unit[1] == pytest.approx(100 - 30.48)


def test_nought_needs_no_unit(read):
    (zone,) = read(collection(feature(lower=0, upper="100 m", reference="AGL", min_height=0)))
    assert (zone.low, zone.high) == (sky.AboveGround(0.0), sky.AboveGround(100.0))


MAXIMA = ("CEILING", "max_alt", "maxAltitude", "MAX_ALTITUDE")


@pytest.mark.parametrize("name", MAXIMA)
def test_a_maximum_altitude_alone_may_be_what_is_permitted_or_forbidden(read, name, refuses):
    """Cells as those of the FAA's UAS facility maps, of 400 and of 0 feet."""
    cells = collection(*(feature(**{name: feet, "UNIT": "Feet", "MAP_EFF": "1/23/2026"}) for feet in (400, 0)))
    with refuses():
        read(cells, altitudes="agl")
    above = read(cells, altitudes="agl", maximum_altitudes="permitted")
    assert [(zone.low, zone.high) for zone in above] == [(sky.AboveGround(121.92), None), (sky.AboveGround(0.0), None)]
    told = []
    below = read(cells, altitudes="agl", maximum_altitudes="forbidden", tell=told.append)
    assert [(zone.low, zone.high) for zone in below] == [(None, sky.AboveGround(121.92)), (None, None)]
    assert len(told) == 1


@pytest.mark.parametrize("fields", [{"floor": "GND"}, {"min_alt": 0}, {"lower": "10 m agl"}])
@pytest.mark.parametrize("name", MAXIMA)
def test_a_maximum_altitude_beside_a_minimum_is_an_upper_limit(read, name, fields):
    (zone,) = read(collection(feature(**{name: "120 m agl"}, reference="AGL", **fields)))
    assert zone.high == sky.AboveGround(120.0)


NO_LOWER = ({}, {"lower": "SFC"}, {"lower": "GND"}, {"lower": 0}, {"lower": "0 ft agl"}, {"lower": -5})


@pytest.mark.parametrize("lower", NO_LOWER)
@pytest.mark.parametrize("upper", [0, -1, -9999, "0 ft agl", "-1 m agl", "0", "SFC", "GND", 0.0, {"value": 0}])
def test_a_zone_that_would_end_at_or_below_the_ground_is_shut_as_one_without_limits(read, upper, lower):
    told = []
    fields = {"upper": upper, "reference": "AGL", "uom": "M", **lower}
    (zone,) = read(collection(feature(**fields)), tell=told.append)
    assert (zone.low, zone.high) == (None, None)
    (said,) = told
    assert "1 with an upper limit at or below the ground, which is none: shut from the ground up" in said


def test_a_zone_that_would_end_below_where_it_begins_is_refused(read, refuses):
    for upper in (0, -1, 40):
        with refuses():
            read(collection(feature(lower=50, upper=upper, reference="AGL", uom="M")))


def test_corners_at_or_below_the_ground_are_no_upper_limit_either(read):
    told = []
    (zone,) = read(
        collection(feature([[[*place, -3.0] for place in SQUARE]], use="none")), altitudes="agl", tell=told.append
    )
    assert (zone.low, zone.high) == (None, None)
    assert len(told) == 1


LAYER = {"upper": 900, "upperReference": "AGL", "lower": 45, "lowerReference": "AGL"}


@pytest.mark.parametrize("name", ["verticalLayer", "VerticalLayer", "vertical_layer", "layer"])
@pytest.mark.parametrize("unit", ["UOM", "uom"])
def test_limits_and_names_within_a_property_are_read(read, name, unit, refuses):
    zone = {"identifier": "X1", "name": "HELIPORT", "type": "REQ_AUTHORIZATION"}
    (found,) = read(collection(feature(UASZone=zone, **{name: LAYER | {unit: "M"}})))
    assert (found.low, found.high) == (sky.AboveGround(45.0), sky.AboveGround(900.0))
    assert (found.name, found.kind) == ("HELIPORT", "REQ_AUTHORIZATION")
    assert read(collection(feature(), feature(UASZone=zone | {"type": "NO_RESTRICTION"})))[0].name is None
    twice = collection(feature(upper=800, **{name: LAYER | {unit: "M"}}))
    with refuses():
        read(twice)


def test_a_note_names_limits_within_other_properties(read):
    told = []
    read(collection(feature(volume={"airspace": LAYER})), tell=told.append)
    named = next(said for said in told if said.endswith("not read as a limit"))
    assert "'volume.airspace.upper'" in named
    assert "'volume.airspace.lower'" in named


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ((0, 0), sky.AboveGround(1000.0)),
        ((1, 0), sky.AboveGround(304.8)),
        ((0, 1), sky.AboveSea(1000.0)),
        ((6, 2), None),
    ],
)
def test_numbers_of_openaip_stand_for_words(read, said, meant, refuses):
    unit, datum = said
    document = collection(feature(upperLimit={"value": 1000, "unit": unit, "referenceDatum": datum}))
    if meant is None:
        with refuses():
            read(document)
    else:
        assert read(document)[0].high.metres == pytest.approx(meant.metres)
        assert type(read(document)[0].high) is type(meant)
    unknown = collection(feature(upperLimit={"value": 1000, "unit": 9, "referenceDatum": 1}))
    with refuses():
        read(unknown)


@pytest.mark.parametrize(
    "unit_fields",
    [
        ("uomLower", "uomUpper"),
        ("UOM_LOWER", "UOM_UPPER"),
        ("lower_uom", "upperUom"),
        ("unitLower", "unitUpper"),
        ("LowerUnits", "upper_units"),
        ("uomLowerLimit", "upperLimitUom"),
        ("unitOfMeasureLower", "upperUnitOfMeasure"),
        ("uomDimensionsLower", "uomDimensionsUpper"),
        ("altitudeUom",),
        ("uom_limits",),
        ("unitOfMeasure",),
    ],
)
def test_a_unit_stated_beside_a_limit_counts_whatever_its_field_is_called(read, unit_fields, refuses):
    told = []
    limits = {"lower": "300", "upper": "1000"}
    (zone,) = read(collection(feature(**limits, **dict.fromkeys(unit_fields, "FT"))), altitudes="agl", tell=told.append)
    assert (zone.low.metres, zone.high.metres) == (pytest.approx(91.44), pytest.approx(304.8))
    assert not any("without a unit" in note for note in told)
    unknown = collection(feature(**limits, **dict.fromkeys(unit_fields, "furlong")))
    with refuses():
        read(unknown, altitudes="agl")


def test_a_unit_beside_a_limit_goes_by_the_name_of_the_limit(read):
    fields = {"floor": 100, "floorUnit": "FT", "maxAltitude": 200, "unitMaxAltitude": "FT", "uom": "M"}
    (zone,) = read(collection(feature(**fields)), altitudes="amsl")
    assert (zone.low.metres, zone.high.metres) == (pytest.approx(30.48), pytest.approx(60.96))


def test_a_unit_beside_a_limit_with_its_own_fields_counts_where_those_have_none(read):
    fields = {"upper": {"value": 100, "referenceDatum": "AGL"}, "upperUom": "FT"}
    assert read(collection(feature(**fields)))[0].high.metres == pytest.approx(30.48)
    fields["upper"]["unit"] = "M"
    assert read(collection(feature(**fields)))[0].high.metres == 100.0


def test_a_reference_beside_a_limit_counts_in_either_order_of_words(read):
    (zone,) = read(collection(feature(upper="100 m", referenceUpper="AMSL")), altitudes="agl")
    assert zone.high == sky.AboveSea(100.0)


def test_a_field_that_is_said_twice_is_refused(read, refuses):
    twice = '{"name": "A", "upper": 2500, "upper": 1, "reference": "AMSL"}'
    document = json.dumps(collection(feature())).replace(json.dumps(ZONE), twice)
    with refuses():
        read(document)
    spelt = collection(feature(maxAlt=2500, max_alt=1, reference="AMSL", uom="M"))
    with refuses():
        read(spelt)
    data = "".join(f'<Data name="upper"><value>{value}</value></Data>' for value in ("2500 m amsl", "1 m agl"))
    document = kml(f"<ExtendedData>{data}</ExtendedData>" + kml_polygon())
    with refuses():
        read(document, name="zones.kml")


def test_zones_without_limits_are_told(read):
    told = []
    zones = [feature(name="a"), feature(maxHeight=120, name="b"), feature(alt_max="120 m"), feature()]
    read(collection(*zones), tell=told.append)
    assert [sentence.split("zones.geojson: ")[1] for sentence in told] == [
        "3 without limits: shut from the ground up",
        "1 with 'maxHeight', not read as a limit",
        "1 with 'alt_max', not read as a limit",
    ]


def test_corners_with_altitudes_need_to_say_what_they_are_counted_from(read, refuses):
    document = collection(feature([[[*place, 30.0] for place in SQUARE]], use="none"))
    with refuses():
        read(document)
    assert read(document, altitudes="amsl")[0].high == sky.AboveSea(30.0)
