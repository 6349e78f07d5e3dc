"""Where zones begin and end, as their files say it."""

import json

import pytest

from skyverse.model.altitude import AboveGround, AboveHome, AboveSea

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")
pytest.importorskip("pyogrio")

from zones import SQUARE, ZONE, collection, feature, kml, kml_polygon, refused  # noqa: E402


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
        ({"upper": "400 agl", "uom": "ft"}, None, AboveGround(121.92)),
        ({"upper": "30 m home"}, None, AboveHome(30.0)),
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
        ({"upper": "400 agl"}, ("'upper'", "expected an altitude in m or ft", "Reading(unit='ft')")),
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


def test_limits_without_a_unit_are_told_once_a_file_unless_the_user_says(read):
    document, told = collection(*[feature(lower=0, upper=100, reference="AGL")] * 3), []
    assert read(document, tell=told.append)[0].high == AboveGround(100.0)
    assert len(told) == 1
    assert "3 limits without a unit taken as metres; give Reading(unit='ft') to" in told[0]
    assert read(document, unit="ft", tell=told.append)[0].high.metres == pytest.approx(30.48)
    assert len(told) == 1


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
def test_a_unit_stated_beside_a_limit_counts_whatever_its_field_is_called(read, unit_fields):
    told = []
    limits = {"lower": "300", "upper": "1000"}
    (zone,) = read(collection(feature(**limits, **dict.fromkeys(unit_fields, "FT"))), altitudes="agl", tell=told.append)
    assert (zone.low.metres, zone.high.metres) == (pytest.approx(91.44), pytest.approx(304.8))
    assert not any("without a unit" in note for note in told)
    unknown = collection(feature(**limits, **dict.fromkeys(unit_fields, "furlong")))
    refused(read, unknown, "zones.geojson: feature 1", f"{unit_fields[0]!r}", "M or FT", "furlong", altitudes="agl")


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
    assert zone.high == AboveSea(100.0)


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


def test_corners_with_altitudes_need_to_say_what_they_are_counted_from(read):
    document = collection(feature([[[*place, 30.0] for place in SQUARE]], use="none"))
    refused(read, document, "feature 1", "30", "Reading(altitudes=")
    assert read(document, altitudes="amsl")[0].high == AboveSea(30.0)
