"""KML and KMZ: placemarks as they are, or one sentence that says what is wrong."""

import zipfile

import numpy as np
import pytest

import skyverse as sky
from altitudes import About

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")
pytest.importorskip("pyogrio")

from zones import ABSOLUTE, COURT, EXTRUDE, RELATIVE, SQUARE, kml, kml_polygon, polygon, read_file  # noqa: E402


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
        (None, sky.AboveGround(60.0)),
        (None, sky.AboveSea(600.0)),
        (None, About(sky.AboveGround, 121.92)),
        (None, None),
        (None, sky.AboveGround(5.0)),
    ]
    assert found[0].name == "A & B"
    assert [len(one.holes) for one in found] == [0, 0, 0, 1, 0, 0]
    assert found[3].where.endswith("zones.kml: placemark 4")


TIMES = "<TimeSpan><begin>2026-05-01</begin></TimeSpan>"


@pytest.mark.parametrize(
    ("document", "timed"),
    [
        (kml(kml_polygon(), kml_polygon()), 0),
        (kml(TIMES + kml_polygon(), kml_polygon()), 1),
        (kml(kml_polygon(), kml_polygon()).replace("<Placemark>", TIMES + "<Placemark>", 1), 2),
        (kml("<gx:TimeStamp><when>2026</when></gx:TimeStamp>" + kml_polygon(), kml_polygon()), 1),
    ],
)
def test_times_of_placemarks_and_of_what_holds_them_are_told(read, document, timed):
    told = []
    read(document, name="zones.kml", tell=told.append)
    warnings = [sentence.split("zones.kml: ")[1].split()[:4] for sentence in told if "WARNING" in sentence]
    assert warnings == [["WARNING:", str(timed), "with", "times"]] * (timed > 0)


SPACED = "<outerBoundaryIs><LinearRing><coordinates>7, 47 8, 47</coordinates></LinearRing></outerBoundaryIs>"


@pytest.mark.parametrize(
    "document",
    [
        kml(kml_polygon(60, RELATIVE)),
        kml(kml_polygon(60, "<altitudeMode>relativeToSeaFloor</altitudeMode>")),
        kml("<LineString><coordinates>7,47 7.1,47</coordinates></LineString>"),
        kml(f"<Polygon>{SPACED}</Polygon>"),
        kml("<name>nothing</name>"),
        kml(kml_polygon()).replace("<Placemark>", "<NetworkLink/><Placemark>", 1),
        '<!DOCTYPE x [<!ENTITY a "b">]>' + kml(kml_polygon()),
        "<kml>",
        "",
    ],
)
def test_kml_that_is_no_body_is_refused(read, document, refuses):
    with refuses():
        read(document, name="zones.kml")


def test_kml_as_gdal_writes_it_reads_the_same(tmp_path):
    from pyogrio.raw import write

    path = tmp_path / "zones.kml"
    lake = shapely.to_wkb(np.array([shapely.Polygon(SQUARE, [COURT])]))
    write(path, lake, [], [], geometry_type="Polygon", crs="EPSG:4326", driver="KML")
    (zone,) = read_file(path)
    assert polygon(zone).equals(shapely.Polygon(SQUARE, [COURT]))


def test_a_kmz_is_read_and_one_that_unpacks_to_too_much_or_is_cut_off_is_refused(tmp_path, monkeypatch):
    from skyverse.documents import kmz

    path = tmp_path / "zones.kmz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("doc.kml", kml(kml_polygon()))
    assert len(read_file(path)) == 1
    monkeypatch.setattr(kmz, "MAX_UNPACKED", 100)
    with pytest.raises(sky.InputError, match="unpacked"):
        read_file(path)
    monkeypatch.undo()
    whole = path.read_bytes()
    for cut in range(0, len(whole), 7):
        path.write_bytes(whole[:cut])
        with pytest.raises(sky.InputError, match=r"zones\.kmz"):
            read_file(path)
