"""Photos that were taken, as exiftool and OpenDroneMap write them."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.exports.expected_photos import HEADER
from skyverse.model.frame import Origin

pytest.importorskip("pyproj")
pytest.importorskip("shapely")

HERE = Origin(latitude=46.8, longitude=9.85, altitude=1500.0)


def test_a_table_of_exiftool_and_a_geo_text_say_the_same(tmp_path):
    table, text = tmp_path / "flown.csv", tmp_path / "geo.txt"
    head = "SourceFile,GPSLatitude,GPSLongitude,AbsoluteAltitude,GimbalYawDegree,GimbalPitchDegree"
    table.write_text(f'{head}\na.jpg,"46 deg 48\' 3.60"" N","9 deg 51\' 0.00"" E",+1575.50,-90.0,-80.0\n')
    text.write_text("EPSG:4326\na.jpg 9.85 46.801 1575.5 270 10 0\n")
    for path in (table, text):
        photos = sky.read_photos(path, HERE)
        assert np.allclose(photos.position, sky.to_local(HERE, [(46.801, 9.85, 1575.5)]), atol=1e-3)
        assert (photos.heading[0], photos.pitch[0], photos.roll[0]) == (270.0, -80.0, 0.0)


def test_the_table_of_expected_photos_is_read_as_one_of_photos_that_were_taken(tmp_path):
    (tmp_path / "field.photos.csv").write_text(f'{HEADER}\np1,46.801,9.85,1575.5,270,-80,5,1,1,"a, b"\n')
    photos = sky.read_photos(tmp_path / "field.photos.csv", HERE)
    assert np.allclose(photos.position, sky.to_local(HERE, [(46.801, 9.85, 1575.5)]), atol=1e-3)
    assert (photos.heading[0], photos.pitch[0], photos.roll[0]) == (270.0, -80.0, 5.0)


def test_a_pitch_that_is_missing_must_be_given(tmp_path):
    path = tmp_path / "flown.csv"
    path.write_text("lat,lon,altitude,yaw\n46.8,9.85,1560,10\n")
    with pytest.raises(sky.InputError, match=r"line 2: expected the camera's pitch, found none; give pitch"):
        sky.read_photos(path, HERE)
    assert sky.read_photos(path, HERE, pitch=-90.0).pitch[0] == -90.0
