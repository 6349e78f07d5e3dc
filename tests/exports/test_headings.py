"""Exports tell autopilots and robots where noses point."""

import json
import re
import zipfile

import numpy as np
import pytest
from exported_fleets import ORIGIN
from handmade_exports import local

import skyverse as sky
from speed_zones import world_of

PLACE = (10.0, 40.0, 5.0)


def mission(look_at=None, heading=None):
    uav = sky.UAV(start=(-60, 0, 12), home=0, look_at=look_at, heading=heading)
    target = sky.Target(position=(60, 30, 20))
    return sky.plan_mission(world_of(uavs=(uav,), targets=(target,), frame=sky.Frame(origin=ORIGIN)), sky.Taut())


def rows_of(file):
    """The commands of a file, each with its seven numbers."""
    if file.suffix == ".plan":
        return [(item["command"], *item["params"]) for item in json.loads(file.read_text())["mission"]["items"]]
    return [tuple(map(float, line.split("\t")[3:11])) for line in file.read_text().splitlines()[2:]]


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
@pytest.mark.parametrize("altitude", ["amsl", "home"])
@pytest.mark.parametrize(("autopilot", "command", "kind"), [("px4", 195, 0), ("ardupilot", 201, 3)])
def test_missions_of_mavlink_look_at_the_place(tmp_path, suffix, altitude, autopilot, command, kind):
    (file,) = sky.export(
        mission(PLACE), tmp_path / f"m.{suffix}", sky.ExportOptions(altitude=altitude, autopilot=autopilot)
    )
    rows = rows_of(file)
    commands = [row[0] for row in rows]
    assert [one for one in commands if one in (195, 201)] == [command]
    told = rows[commands.index(command)]
    assert told[1] == kind
    assert commands.index(command) < commands.index(16)
    place = local(ORIGIN, *([value] for value in told[5:]))[0]
    np.testing.assert_allclose(place, PLACE, atol=0.01)
    (plain,) = sky.export(
        mission(None), tmp_path / f"n.{suffix}", sky.ExportOptions(altitude=altitude, autopilot=autopilot)
    )
    assert not {row[0] for row in rows_of(plain)} & {195, 201}


@pytest.mark.parametrize("end", ["loiter", "land", "rtl"])
@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
def test_missions_of_mavlink_keep_a_fixed_heading(tmp_path, suffix, autopilot, end):
    options = sky.ExportOptions(altitude="home", autopilot=autopilot, end=end)
    (file,) = sky.export(mission(heading=225.5), tmp_path / f"m.{suffix}", options)
    rows = rows_of(file)
    assert {row[4] for row in rows if row[0] in (16, 17, 21)} == {225.5}  # waypoint, loiter, land
    assert not {row[0] for row in rows} & {195, 201}
    commands = [row[0] for row in rows]
    turns = [row[1:5] for row in rows if row[0] == 115]
    assert turns == ([(225.5, 60.0, 0.0, 0.0)] if autopilot == "ardupilot" else [])  # MAV_CMD_CONDITION_YAW
    if autopilot == "ardupilot":  # commands after a condition wait for it
        assert commands.index(178) < commands.index(115) == commands.index(16) - 1
    (plain,) = sky.export(mission(), tmp_path / f"n.{suffix}", options)
    assert all(row[4] is None or np.isnan(row[4]) for row in rows_of(plain) if row[0] == 16)
    for name, kept in (("m", 0), ("n", 2)):
        told = (tmp_path / f"{name}.{'params' if autopilot == 'px4' else 'param'}").read_text()
        assert (f"WP_YAW_BEHAVIOR,{kept}\n" in told) == (autopilot == "ardupilot")


def test_dji_aircraft_keep_a_fixed_heading_at_every_waypoint(tmp_path):
    (file,) = sky.export(mission(heading=225.5), tmp_path / "m.wpml.kmz")
    with zipfile.ZipFile(file) as archive:
        texts = [archive.read(f"wpmz/{name}").decode() for name in ("template.kml", "waylines.wpml")]
    for text, count in zip(texts, (1, texts[1].count("<Placemark>")), strict=True):
        modes = re.findall(r"<wpml:waypointHeadingMode>(.*?)<", text)
        angles = re.findall(r"<wpml:waypointHeadingAngle>(.*?)<", text)
        assert (modes, angles) == (["smoothTransition"] * count, ["-134.5"] * count)  # between -180 and 180


def test_dji_aircraft_turn_their_noses_to_the_place(tmp_path):
    (file,) = sky.export(mission(PLACE), tmp_path / "m.wpml.kmz")
    with zipfile.ZipFile(file) as archive:
        text = archive.read("wpmz/waylines.wpml").decode()
    points = re.findall(r"<wpml:waypointPoiPoint>(.*?)<", text)
    assert len(points) == text.count("<Placemark>") == text.count("towardPOI")
    latitude, longitude, _ = map(float, points[0].split(","))
    np.testing.assert_allclose(local(ORIGIN, [latitude], [longitude], [0.0])[0][:2], PLACE[:2], atol=0.02)


def test_robots_are_told_the_yaw_as_a_rotation(tmp_path):
    flown = mission(None)
    (file,) = sky.export(flown, tmp_path / "m.trajectory.json")
    points = json.loads(file.read_text())["points"]
    turns = [2 * np.arctan2(p["transforms"][0]["rotation"]["z"], p["transforms"][0]["rotation"]["w"]) for p in points]
    np.testing.assert_allclose(turns, np.arctan2(30, 120), atol=1e-6)
    assert all(p["velocities"][0]["angular"]["z"] == 0 for p in points)
