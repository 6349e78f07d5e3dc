"""Points of files: one list of places reads the same in every format, and each altitude says what it counts from."""

import json

import pytest

import skyverse as sky

POINTS = {"tower 3": (46.81, 9.85, 60.0), "a = b, c": (46.8125, 9.8512, 72.5)}
KML_MODES = {"agl": "relativeToGround", "amsl": "absolute"}


def kml(points, reference):
    mode = f"<altitudeMode>{KML_MODES[reference]}</altitudeMode>" if reference else ""
    marks = [
        f"<Placemark><name>{name}</name><Point>{mode}<coordinates>{x},{y},{z}</coordinates></Point></Placemark>"
        for name, (y, x, z) in points
    ]
    return f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{"".join(marks)}</Document></kml>'


def gpx(points, reference):
    marks = [f'<wpt lat="{y}" lon="{x}"><ele>{z}</ele><name>{name}</name></wpt>' for name, (y, x, z) in points]
    return f'<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">{"".join(marks)}</gpx>'


def geojson(points, reference):
    features = [
        {
            "type": "Feature",
            "properties": {"name": name} | ({f"height_{reference}_m": z} if reference else {}),
            "geometry": {"type": "Point", "coordinates": [x, y] + ([] if reference else [z])},
        }
        for name, (y, x, z) in points
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


def csv(points, reference):
    said = f" (m {reference})" if reference else ""
    rows = [f'"{name}",{y},{x},{z}' for name, (y, x, z) in points]
    return "\n".join([f"Name,Latitude,Longitude,Altitude{said}", *rows])


FORMATS = {"kml": kml, "gpx": gpx, "geojson": geojson, "csv": csv}
SAYS_SO = [name for name in FORMATS if name != "gpx"]


def written(folder, suffix, *more, reference=None):
    path = folder / f"points.{suffix}"
    path.write_text(FORMATS[suffix]([*POINTS.items(), *more], reference), encoding="utf-8")
    return path


@pytest.mark.parametrize("suffix", SAYS_SO)
@pytest.mark.parametrize(("reference", "kind"), [("agl", sky.AboveGround), ("amsl", sky.AboveSea)])
def test_what_a_file_says_of_its_altitudes_counts(tmp_path, suffix, reference, kind):
    expected = {name: (y, x, kind(z)) for name, (y, x, z) in POINTS.items()}
    assert sky.read_points(written(tmp_path, suffix, reference=reference)) == expected
    assert sky.read_points(written(tmp_path, suffix, reference=reference), altitude="amsl") == expected


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_bare_number_is_refused_in_every_format(tmp_path, refuses, suffix):
    with refuses():
        sky.read_points(written(tmp_path, suffix))


@pytest.mark.parametrize("suffix", ["gpx", "geojson", "csv"])
def test_what_a_file_leaves_open_is_given(tmp_path, suffix):
    path = written(tmp_path, suffix)
    assert sky.read_points(path, altitude="m agl") == {
        name: (y, x, sky.AboveGround(z)) for name, (y, x, z) in POINTS.items()
    }


@pytest.mark.parametrize("suffix", FORMATS)
def test_one_altitude_for_all_stands_for_those_of_the_file(tmp_path, suffix):
    expected = {name: (y, x, sky.AboveGround(50.0)) for name, (y, x, _) in POINTS.items()}
    assert sky.read_points(written(tmp_path, suffix), altitude="50 m agl") == expected


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("twin", [("tower 3", (46.9, 9.9, 1)), ("tower 4", POINTS["tower 3"])], ids=["name", "place"])
def test_twins_are_refused_by_name(tmp_path, refuses, suffix, twin):
    with refuses():
        sky.read_points(written(tmp_path, suffix, twin), altitude="50 m agl")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("nothing.geojson", '{"type": "FeatureCollection", "features": []}'),
        ("area.geojson", '{"type": "Polygon", "coordinates": [[[9, 46], [9.1, 46], [9.1, 46.1]]]}'),
        ("no-place.csv", "name,lat\na,46.8"),
        ("two-altitudes.csv", "lat,lon,alt_agl_m,alt_amsl_m\n46.8,9.8,60,1600"),
        ("ellipsoid.csv", "lat,lon,altitude_ellipsoid_m\n46.8,9.8,60"),
        ("pole.csv", "lat,lon,agl_m\n96.8,9.8,60"),
        ("empty.gpx", "<gpx/>"),
        ("points.txt", "46.8,9.8,60"),
    ],
    ids=["nothing", "area", "no place", "two altitudes", "ellipsoid", "pole", "empty", "suffix"],
)
def test_what_holds_no_points_is_refused(tmp_path, refuses, name, text):
    (tmp_path / name).write_text(text, encoding="utf-8")
    with refuses():
        sky.read_points(tmp_path / name)


def test_altitudes_in_cells_and_other_units_and_points_without_names(tmp_path):
    (tmp_path / "p.csv").write_text("lat;lon;alt\n46.8;9.8;60 m agl\n46.9;9.9;200 ft msl\n", encoding="utf-8")
    found = sky.read_points(tmp_path / "p.csv")
    assert [*found] == ["point-1", "point-2"]
    assert found["point-1"][2] == sky.AboveGround(60.0)
    assert found["point-2"][2].metres == pytest.approx(60.96)
