"""Fields that look like a limit, a radius or a time and are not read are named, whatever the file's format."""

import json

import pytest

pytest.importorskip("pyproj", reason="files of zones need pyproj")
shapely = pytest.importorskip("shapely", reason="files of zones need shapely")

import skyverse as sky  # noqa: E402
from skyverse.maps.georeference.reading import Choices  # noqa: E402
from skyverse.maps.readers import read_features  # noqa: E402

RING = [[8.7, 50.8], [8.71, 50.8], [8.71, 50.81], [8.7, 50.8]]
POLYGON, POINT = {"type": "Polygon", "coordinates": [RING]}, {"type": "Point", "coordinates": RING[0]}


def geojson(folder, geometry, fields):
    path = folder / "zones.geojson"
    path.write_text(json.dumps({"type": "Feature", "properties": fields, "geometry": geometry}), encoding="utf-8")
    return path


def kml(folder, geometry, fields):
    data = "".join(f'<Data name="{name}"><value>{value}</value></Data>' for name, value in fields.items())
    places = " ".join(f"{x},{y}" for x, y in (RING if geometry is POLYGON else RING[:1]))
    shape = f"<coordinates>{places}</coordinates>"
    if geometry is POLYGON:
        shape = f"<Polygon><outerBoundaryIs><LinearRing>{shape}</LinearRing></outerBoundaryIs></Polygon>"
    else:
        shape = f"<Point>{shape}</Point>"
    path = folder / "zones.kml"
    path.write_text(f"<kml><Placemark><ExtendedData>{data}</ExtendedData>{shape}</Placemark></kml>", encoding="utf-8")
    return path


def table(folder, geometry, fields):
    import numpy as np

    pyogrio = pytest.importorskip("pyogrio", reason="reading tables needs pyogrio")
    path, shapes = folder / "zones.gpkg", shapely.to_wkb([shapely.from_geojson(json.dumps(geometry))])
    columns = [np.array([value], dtype=object if isinstance(value, str) else None) for value in fields.values()]
    kind = geometry["type"]
    pyogrio.raw.write(path, shapes, columns, list(fields), geometry_type=kind, crs="EPSG:4326", driver="GPKG")
    return path


def read(path, **reading):
    told = []
    return read_features(path, Choices(**reading, tell=told.append)), [str(said).partition(": ")[2] for said in told]


UNREAD = [
    ({"Hoehe_limit": "120 m"}, "1 with 'Hoehe_limit', not read as a limit"),
    ({"top_height": 120}, "1 with 'top_height', not read as a limit"),
    ({"start": "2026-10-01T10:00Z", "end": "2026-10-02T10:00Z"}, "1 with 'start' and 'end', not read as a time"),
    ({"active": "MO-FR 08:00-16:00"}, "1 with 'active', not read as a time"),
    ({"Bufferzone": "2 km"}, "1 with 'Bufferzone', not read as a radius; give Reading(radius_field='Bufferzone')"),
]
READ = {"upper": "120 m agl", "lower": "0 m agl", "radius": "1 km", "name": "5 m from the end", "limits": "see text"}


@pytest.mark.parametrize("written", [geojson, kml, table])
@pytest.mark.parametrize(("fields", "said"), UNREAD)
def test_they_are_named(tmp_path, written, fields, said):
    _, told = read(written(tmp_path, POLYGON, fields))
    assert said in told


@pytest.mark.parametrize("written", [geojson, kml, table])
def test_those_that_are_read_are_not(tmp_path, written):
    _, told = read(written(tmp_path, POLYGON, READ))
    assert not any("not read" in said for said in told)


@pytest.mark.parametrize("written", [geojson, kml, table])
@pytest.mark.parametrize("fields", [{"Bufferzone": "2 km"}, {"buffer_m": 2000}, {"width (km)": "2"}])
def test_a_point_with_a_radius_that_is_not_read_is_refused_or_warned_of(tmp_path, refuses, written, fields):
    path, (name,) = written(tmp_path, POINT, fields), fields
    with refuses():
        read(path)
    _, told = read(path, buffer=150.0)
    assert f"WARNING: 1 with {name!r}, not read as a radius; give Reading(radius_field={name!r})" in told
    (feature,), told = read(path, radius_field=name, buffer=150.0)
    assert not any("not read" in said for said in told)
    width = feature.outline[:, 1].max() - feature.outline[:, 1].min()
    assert width == pytest.approx(2 * 2000 / 111_200, rel=0.01)


def test_several_fields_may_hold_radii(tmp_path):
    for fields in ({"Bufferzone": "2 km"}, {"buffer_m": 2000}):
        (feature,), _ = read(geojson(tmp_path, POINT, fields), radius_field=("Bufferzone", "buffer_m"))
        assert len(feature.outline) > 10
    with pytest.raises(sky.InputError, match="radius_field"):
        sky.Reading(radius_field=[1])


def test_a_height_that_is_not_read_is_named_beside_the_one_that_is_given(tmp_path):
    _, told = read(geojson(tmp_path, POLYGON, {"HEIGHT_M": 45}), kind="building", building_height=10.0)
    assert "WARNING: 1 with 'HEIGHT_M', not read as a height; give Reading(height_field='HEIGHT_M')" in told


def test_what_restricts_nothing_is_left_out_by_name_and_message(tmp_path):
    path = tmp_path / "zones.json"
    volume = {"uomDimensions": "M", "lowerLimit": 0, "lowerVerticalReference": "AGL", "upperLimit": 100}
    volume |= {"upperVerticalReference": "AGL", "horizontalProjection": POLYGON}
    zone = {"identifier": "A1", "name": "D-AREA 7", "message": "DANGER AREA ACTIVATED", "geometry": [volume]}
    zones = [{**zone, "restriction": "NO_RESTRICTION"}, {**zone, "restriction": "PROHIBITED"}]
    path.write_text(json.dumps({"features": zones}), encoding="utf-8")
    found, told = read(path)
    assert len(found) == 1
    assert any(said.endswith("left out, it restricts nothing: D-AREA 7, DANGER AREA ACTIVATED") for said in told)


@pytest.mark.parametrize(
    ("fields", "nothing"),
    [({}, True), ({"start": "2026-11-26T10:00Z"}, True), ({"startDateTime": "2026-11-26T10:00Z"}, False)],
)
def test_a_date_that_changes_nothing_is_told(tmp_path, fields, nothing):
    told = []
    place = (50.81, 8.8, sky.AboveGround(40.0))
    sky.build_scenario(
        sky.BuildOptions(
            "s",
            zones=[geojson(tmp_path, POLYGON, fields)],
            uavs=[place],
            ground=sky.AboveSea(0.0),
            reading=sky.Reading(date="2026-11-26T10:00Z"),
            on_note=lambda note: told.append(note.text),
        )
    )
    assert any("it changes nothing" in text for text in told) == nothing


OFFICE = {"CEILING": 200, "UNIT": "ABC TOWER"}


def test_a_field_of_another_unit_s_name_does_not_keep_the_user_from_saying_it(tmp_path, refuses):
    path = geojson(tmp_path, POLYGON, OFFICE)
    with refuses():
        read(path, kind="airspace above the permitted height")
    (cell,), told = read(path, kind="airspace above the permitted height", unit="ft")
    assert cell.low == sky.AboveGround(200 * 0.3048)
    assert "1 with 'UNIT', which holds no unit" in told
    for known in ("FL", "km", "flight level", "hundreds of feet", "pressure altitude"):
        with refuses():
            read(
                geojson(tmp_path, POLYGON, OFFICE | {"UNIT": known}),
                unit="ft",
                altitudes="agl",
                maximum_altitudes="forbidden",
            )
