"""The verb ``check`` of photos that were taken: exit codes, the reflight that it writes, and what it refuses."""

import json
import re

import pytest

import skyverse as sky
from planned_surveys import planned_survey


@pytest.fixture
def flown(tmp_path, monkeypatch):
    """A mission, and the tables of its expected photos, in the working folder."""
    monkeypatch.chdir(tmp_path)
    mission = planned_survey("flat", 1)
    sky.write(mission, "field.json")
    sky.export(mission, "field.plan", sky.ExportOptions(altitude="home"))
    return (tmp_path / "field.photos.csv").read_text().splitlines()


def test_expected_photos_are_proven_and_missing_ones_are_flown_again(flown, skyverse, tmp_path):
    for file in ("field.photos.csv", "field.geo.txt"):
        code, out, _ = skyverse("check", file, "--survey", "field.json")
        assert (code, "proven" in out) == (0, True)
    (tmp_path / "part.csv").write_text("\n".join(flown[:6] + flown[14:]) + "\n")
    code, out, _ = skyverse("check", "part.csv", "--survey", "field.json", "--reflight", "again.json")
    assert code == 1
    latitude, longitude = map(float, re.search(r"(47\.\d{6}), (8\.\d{6})", out).groups())
    assert 47.0 < latitude < 47.0015
    assert 8.0 < longitude < 8.002
    assert (tmp_path / "again.html").exists()
    again = sky.read_mission("again.json")
    assert again.violations == ()
    sky.export(again, "again.plan", sky.ExportOptions(altitude="home"))
    code, out, _ = skyverse("check", "part.csv", "again.photos.csv", "--survey", "field.json", "--json")
    assert code == 0
    assert json.loads(out)[0]["verdict"] == "proven"


def test_photos_without_an_altitude_are_named_and_stand_in_for_none(flown, skyverse, tmp_path):
    names = [row.split(",")[0] for row in flown]
    zero = [",".join([*row.split(",")[:3], "0", *row.split(",")[4:]]) for row in flown[6:14]]
    (tmp_path / "zero.csv").write_text("\n".join([*flown[:6], *zero, *flown[14:]]))
    (tmp_path / "without.csv").write_text("\n".join([*flown[:6], *flown[14:]]))
    code, out, error = skyverse("check", "zero.csv", "--survey", "field.json")
    assert (code, out) == skyverse("check", "without.csv", "--survey", "field.json")[:2]
    assert code == 1
    assert re.search(rf"8 photos left out, taken below the ground: {names[6]}, .* and {names[13]}", error)


@pytest.mark.parametrize(
    ("rows", "words", "told"),
    [
        (["lat,lon,altitude,pitch", "47,8,450,-90"], (), r"flown.csv: line 2: expected the camera's heading"),
        (["lat,lon,altitude,yaw,pitch", "47,8,nan,1,-90"], (), r"line 2: altitude: expected a number, found 'nan'"),
        (["lat,lon,altitude,yaw,pitch", "-,-,-,-,-"], (), r"line 2: lat: expected a number"),
        (["lat,lon,yaw,pitch", "47,8,1,-90"], (), r"flown.csv: altitude: expected a column"),
        (["lat,lon,altitude,yaw,pitch,RtkFlag", "47,8,450,1,-90,50"], (), r"what altitudes are counted from"),
        (["lat,lon,altitude,yaw,pitch", "47,8,450,1,-90"], ("--ground", "0 m amsl"), r"--survey: expected"),
        (["lat,lon,altitude,yaw,pitch", "47,8,450,1,-90"], ("--position-error", "-1"), r"expected metres from 0 on"),
    ],
)
def test_bad_photos_are_refused_in_one_sentence(flown, skyverse, tmp_path, rows, words, told):
    (tmp_path / "flown.csv").write_text("\n".join(rows) + "\n")
    code, out, error = skyverse("check", "flown.csv", "--survey", "field.json", *words)
    assert (code, out) == (2, "")
    assert re.search(told, error), error
    assert len(error.strip().splitlines()) == 1
