"""`skyverse check` of missions that people have: exit codes, JSON, pages, and what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
import rasterio

from written_missions import item, plan

HEIGHTS = ("--ground", "400 m amsl", "--vehicle", "camera", "--tracking-error", "1.6,3")


def flight(*places, home=(47.0, 8.0, 400.0), end=20):
    items = [item(22, 0, 0, 0, None, *home[:2], 30)]
    items += [item(16, 0, 0, 0, None, *place, number=k) for k, place in enumerate(places, 2)]
    items.append(item(end, 0, 0, 0, None, 0, 0, 0, frame=2, number=len(items) + 1))
    data = json.loads(plan(items))
    data["mission"]["plannedHomePosition"] = list(home)
    return data


def write(name, data):
    Path(name).write_text(json.dumps(data))
    return name


GOOD = [(47.001, 8.0, 30), (47.001, 8.001, 40)]


def test_a_proven_mission_exits_with_0(skyverse):
    code, out, _ = skyverse("check", write("a.plan", flight(*GOOD)), *HEIGHTS)
    assert code == 0
    assert "proven" in out


def test_a_mission_that_is_wrong_exits_with_1_and_names_the_items(skyverse):
    code, out, _ = skyverse("check", write("a.plan", flight(GOOD[0], (47.001, 8.001, 140))), *HEIGHTS, "--json")
    (found,) = json.loads(out)
    assert code == 1
    assert not found["proven"]
    assert {"legs"} <= {one["subject"] for one in found["findings"] if one["wrong"]}
    assert [2, 3] in [one["items"] for one in found["findings"]]


def test_a_page_is_written(skyverse):
    code, out, _ = skyverse("check", write("a.plan", flight(*GOOD)), *HEIGHTS, "--page", "check.html")
    assert code == 0
    assert out.rstrip().endswith("check.html")
    assert Path("check.html").read_text().startswith("<!DOCTYPE html>")


def write_terrain(name, cells):
    profile = {"driver": "GTiff", "height": cells, "width": cells, "count": 1, "dtype": "float32", "crs": "EPSG:4326"}
    corner = rasterio.Affine(1e-4, 0, 7.999, 0, -1e-4, 46.999 + cells * 1e-4)
    with rasterio.open(name, "w", transform=corner, **profile) as file:
        file.write(np.full((cells, cells), 400.0, dtype="float32"), 1)
        file.units = ("metre",)


def test_a_terrain_that_does_not_cover_the_mission_is_refused_with_what_is_missing(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_terrain("dem.tif", 20)
    refused("check", write("a.plan", flight((47.0, 8.0005, 30), (47.0, 8.003, 30))), "--terrain", "dem.tif")


def no_home(data):
    del data["mission"]["plannedHomePosition"]
    data["mission"]["items"] = data["mission"]["items"][-1:]


def zero(data):
    data["mission"]["items"][1]["params"][4:6] = [0, 0]


def negative_hold(data):
    data["mission"]["items"][1]["params"][0] = -3


def swapped(data):
    params = data["mission"]["items"][1]["params"]
    params[4], params[5] = 147.0, 8.0


def circle(data):
    data["mission"]["items"][2:2] = [item(177, 2, 60000, 0, 0, 0, 0, 0, frame=2, number=9)]


def round_without_a_place(data):
    data["mission"]["items"][2:2] = [
        item(115, 90, 0, 0, 0, 0, 0, 0, frame=2, number=8),
        item(177, 8, 1_000_000_000, 0, 0, 0, 0, 0, frame=2, number=9),
    ]


def many_places(data):
    data["mission"]["items"][2:2] = [item(16, 0, 0, 0, None, *GOOD[k % 2], number=k + 9) for k in range(20_001)]


def unknown_frame(data):
    data["mission"]["items"][1]["frame"] = 1


@pytest.mark.parametrize(
    "change", [no_home, zero, negative_hold, swapped, circle, round_without_a_place, many_places, unknown_frame]
)
def test_a_mission_that_cannot_be_followed_is_refused(refused, tmp_path, monkeypatch, change):
    monkeypatch.chdir(tmp_path)
    data = flight(*GOOD)
    change(data)
    refused("check", write("a.plan", data), *HEIGHTS)


def test_what_is_wrong_with_a_mission_is_told_without_notes_on_maps(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_terrain("dem.tif", 40)
    data = flight(*GOOD)
    zero(data)
    refused("check", write("a.plan", data), "--terrain", "dem.tif", "--vehicle", "camera")


def test_a_mission_without_terrain_nor_altitude_of_home_is_refused(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    data = flight(*GOOD)
    data["mission"]["plannedHomePosition"] = [47.0, 8.0, None]
    refused("check", write("a.plan", data))


def test_a_mission_of_skyverse_takes_no_options_of_maps(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused("check", write("mission.json", {}), "--terrain", "dem.tif")


def test_a_mission_of_skyverse_must_be_there_whatever_the_options(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused("check", "nosuch", "--terrain", "dem.tif")
    Path("round.plan").symlink_to("round.plan")
    refused("check", "round.plan", *HEIGHTS)


def test_a_mission_across_the_antimeridian_is_proven(skyverse):
    places = [(10.001, 179.9995, 30), (10.001, -179.9995, 30)]
    code, out, _ = skyverse("check", write("a.plan", flight(*places, home=(10.0, 179.9995, 400.0))), *HEIGHTS)
    assert code == 0, out


def test_jumps_in_circles_for_ever_are_judged_once_and_said(skyverse):
    data = flight(*GOOD)
    data["mission"]["items"].insert(3, item(177, 2, -1, 0, 0, 0, 0, 0, frame=2, number=9))
    code, out, _ = skyverse("check", write("a.plan", data), *HEIGHTS, "--json")
    (found,) = json.loads(out)
    assert code == 0
    assert any("jump 4" in said for said in found["assumed"])


def test_ten_thousand_items_are_judged(skyverse):
    places = [(47.0 + 0.00002 * (k % 100), 8.0 + 0.00002 * (k // 100), 30 + k % 2) for k in range(10_000)]
    code, out, _ = skyverse("check", write("a.plan", flight(*places)), *HEIGHTS, "--json", "--battery", "500")
    assert code == 0, out[:500]


def test_a_zone_with_times_is_closed_to_missions_that_may_last_until_then(skyverse):
    ring = [[8.002, 46.99], [8.004, 46.99], [8.004, 47.01], [8.002, 47.01], [8.002, 46.99]]
    said = {"startDateTime": "2026-11-26T08:00:00Z", "endDateTime": "2026-11-26T10:00:00Z"}
    zone = {"type": "Feature", "properties": said, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    words = ["check", write("a.plan", flight((47.0, 8.0005, 30), (47.0, 8.006, 30))), *HEIGHTS]
    words += ["--zones", write("zones.geojson", zone), "--json", "--date"]
    for date, wrong in (
        ("2026-11-26T10:00+01:00", True),
        ("2026-11-26T08:30+01:00", False),
        ("2026-11-26T08:50+01:00", True),
        ("2026-11-27T10:00+01:00", False),
    ):
        code, out, err = skyverse(*words, date)
        (found,) = json.loads(out)
        assert (code, found["proven"]) == (int(wrong), not wrong), err
        assert any("active times" in one for one in found["assumed"]) == ("26T" in date)
