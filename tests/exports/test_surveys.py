"""Exports of planned surveys, judged by the referee: a replay of each file takes the photos where they are planned."""

from functools import lru_cache

import pytest

import skyverse as sky
from flown_surveys import differences
from planned_surveys import KINDS, home_of, planned_survey

FORMATS = ("plan", "waypoints", "wpml.kmz", "litchi.csv")
BESIDE = {"plan": "params", "waypoints": "param"}
LATE = {"waypoints": (0.0, 1.0)}
"""How much of its acceptance radius an autopilot may yet fly: ArduPilot turns somewhere in it."""
survey = lru_cache(planned_survey)


def flown(mission, folder, suffix, **how):
    """Export, and return what the replay of each file finds."""
    options = sky.ExportOptions(altitude="home" if suffix == "litchi.csv" else "amsl", **how)
    files = sky.export(mission, folder / f"m.{suffix}", options)
    found = []
    for uav, file in enumerate(files):
        beside = file.with_name(file.name.removesuffix(suffix) + BESIDE.get(suffix, ""))
        text = beside.read_text() if beside.is_file() else ""
        found += [differences(file, home_of(mission, uav), text, late=late) for late in LATE.get(suffix, (0.0,))]
    return found


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("oblique", "time")])
def test_photos_are_where_they_are_planned(tmp_path, kind, suffix):
    found = flown(survey(kind), tmp_path, suffix)
    assert len(found) >= (2 if kind == "two" else 1)
    for off, count, stray, turned in found:
        assert off <= 1.0
        assert (count, stray, turned) == (0, 0, 0)


@pytest.mark.parametrize("suffix", FORMATS[:3])
def test_photos_by_time_are_as_many_as_planned(tmp_path, suffix):
    for off, count, stray, _ in flown(survey("time"), tmp_path, suffix):
        assert off <= 1.0
        assert (count, stray) == (0, 0)


def test_litchi_stops_at_waypoints_and_takes_no_photos_by_time(tmp_path):
    with pytest.raises(sky.InputError, match="stops at every waypoint"):
        flown(survey("time"), tmp_path, "litchi.csv")


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_aeroplanes_circle_where_they_have_started(tmp_path, suffix):
    mission, seen, notes = survey("wing"), [], []
    options = sky.ExportOptions(altitude="amsl", end="loiter")
    sky.export(mission, tmp_path / f"m.{suffix}", options, on_certificate=seen.append, on_note=notes.append)
    assert "of its start" in seen[0].flights[0].at_end
    assert any("switches its camera where it turns" in note for note in notes) == (suffix == "plan")


def test_heights_above_a_launch_place_of_unknown_height_are_refused(tmp_path):
    uavs = [{"name": "uav-1", "start": (-20.0, -40.0, 30.0), "end": "home", "max_speed": 10.0, "max_acceleration": 3.0}]
    mission = planned_survey("flat", uavs=uavs)
    with pytest.raises(sky.InputError, match="a known height of the ground where it is launched"):
        flown(mission, tmp_path, "litchi.csv")
    assert flown(mission, tmp_path, "wpml.kmz")[0][1] == 0
