"""Exports of planned surveys, judged by the referee: a replay of each file takes the photos where they are planned."""

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from flown_surveys import differences
from planned_surveys import KINDS, home_of, planned_survey
from skyverse.exports.camera_items import CameraOrders
from skyverse.exports.photo_strips import PhotoRun
from skyverse.exports.verdicts import verdict_table
from skyverse.orders.mavlink_items import Command

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


def run(on, off, stands=False, **more):
    given = {"strip": 0, "survey": 0, "count": 3, "every": 20.0, "pitch": -90.0, "heading": None, "fastest": 20.0}
    return PhotoRun(on=on, off=off, stands=stands, trigger=more.pop("trigger", "distance"), **(given | more))


@settings(max_examples=50, deadline=None)
@given(
    lengths=st.lists(st.integers(0, 3), min_size=1, max_size=6),
    joined=st.lists(st.booleans(), min_size=6, max_size=6),
    stops=st.lists(st.booleans(), min_size=6, max_size=6),
)
def test_the_trigger_is_on_along_runs_and_nowhere_else(lengths, joined, stops):
    runs, at = [], 1
    for length, follows, stands in zip(lengths, joined, stops, strict=False):
        runs.append(run(at, at + length, stands or not length))
        at += length + (0 if follows and length else 1)
    plan = SimpleNamespace(route=SimpleNamespace(runs=runs), autopilot=SimpleNamespace(name="px4"))
    orders, on = CameraOrders(plan), False
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skyverse.exports.camera_items.spacing", lambda plan, one: one.every)
        for k in range(1, at + 2):
            for item in orders.after(k):
                on = item.numbers[0] > 0 if item.command == Command.PHOTO_DISTANCE else on
            assert on is any(one.on <= k < one.off for one in runs), k


def test_one_uav_with_several_sorties_is_exported(tmp_path):
    uav = {
        "start": (-30, -30, 30),
        "home": 0.0,
        "end": "home",
        "mass": 1.0,
        "hover_power": 250.0,
        "max_speed": 10,
        "battery": 14.0,
    }
    given = {"bounds": {"min": (-150, -150, 0), "max": (450, 450, 120)}, "clearance": 1.0, "uavs": [uav]}
    field = sky.Survey([(0, 0), (300, 0), (300, 250), (0, 250)], "mavic-3e", gsd="2 cm", overlap=(70, 60))
    mission = sky.plan_mission(sky.Scenario(name="one", surveys=[field], **given))
    (sorties,) = mission.sorties
    assert len(sorties) > 1
    for suffix in FORMATS:
        options = sky.ExportOptions(altitude="home", origin=sky.Origin(latitude=47, longitude=8, altitude=400))
        seen = []
        files = sky.export(mission, tmp_path / f"m.{suffix}", options, on_certificate=seen.append)
        assert len(files) == len(sorties)
        assert len({len(row) for row in verdict_table(seen[0].flights)[1]}) == 1


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("kind", ["point", "viewpoints"])
def test_files_of_photos_taken_standing_last_about_as_long_as_they_are_planned(tmp_path, kind, suffix):
    mission = survey(kind)
    photos, seen = sky.photos_of(mission), []
    options = sky.ExportOptions(altitude="home" if suffix == "litchi.csv" else "amsl")
    sky.export(mission, tmp_path / f"m.{suffix}", options, on_certificate=seen.append)
    (flight,) = seen[0].flights
    planned = mission.trajectories[0].duration
    assert planned > 3.0 * len(photos)
    assert flight.duration - flight.begin == pytest.approx(planned, rel=0.35)  # landings are slower than planned


@lru_cache
def beside_a_zone(seed):
    """Return a mission of strips, up to 1.7 km long, that end at a zone within their area."""
    rng = np.random.default_rng([seed, 38])
    wide, high = (1700.0, 80.0) if seed == 0 else rng.uniform((300, 80), (450, 160))
    (x, y), (a, b) = rng.uniform(-8, 8, 2) + np.array([wide, high]) / 2, rng.uniform(12, 25, 2)
    area = [(0.0, 0.0), (wide, 0.0), (wide, high), (0.0, high)]
    corners = [(x - a, y - b), (x + a, y - b + 0.1), (x + a - 0.1, y + b), (x - a, y + b)]
    zone = sky.Prism(name="hospital", vertices=corners, low=-100, high=210, solid=False, kind="no-fly zone")
    fields = {"surveys": [sky.Survey(area, "mavic-3e", gsd="3 cm", overlap=(70, 60), direction=90.0)]}
    if seed == 0:
        fields["bounds"] = {"min": (-100, -100, 0), "max": (1800, 200, 200)}
    more = {"tracking_error": {"horizontal": 1.6, "vertical": 3.0}} if seed % 2 else {}
    uav = {
        "name": "uav-1",
        "start": (-20.0, -40.0, 60.0),
        "end": "home",
        "max_speed": 12.0,
        "max_acceleration": 3.0,
    } | {"home": 0.0}
    kind = "hills" if seed == 1 else "flat"
    frame = sky.Frame(origin=sky.Origin(latitude=63.0, longitude=10.0, altitude=100.0, geoid=40.0))
    return planned_survey(kind, uavs=[uav | more], obstacles=(zone,), clearance=5.0, frame=frame, **fields)


@pytest.mark.parametrize("suffix", FORMATS[1:])
@pytest.mark.parametrize("seed", range(3))
def test_strips_that_end_at_zones_are_exported(tmp_path, seed, suffix):
    mission = beside_a_zone(seed)
    assert len(mission.sorties[0][0].strips) >= 3
    how = sky.ExportOptions(altitude="home" if suffix == "litchi.csv" else "amsl", allow_close=True)
    assert sky.export(mission, tmp_path / f"m.{suffix}", how)


SQUARE, OTHER = ([(x, 0), (x + 60, 0), (x + 60, 60), (x, 60)] for x in (0, 90))
HOLED = {"vertices": SQUARE, "holes": [[(20, 20), (40, 20), (40, 40), (20, 40)]]}


@pytest.mark.parametrize(
    ("area", "suffix", "said"),
    [
        ([{"vertices": SQUARE}, {"vertices": OTHER}], "plan", "found 2 parts and no holes"),
        (HOLED, "plan", "found 1 part and 1 hole"),
        (SQUARE, "waypoints", "expected a .plan, which alone has survey items, found .waypoints"),
        (SQUARE, "csv", "expected a .plan"),
    ],
)
def test_survey_items_are_refused_that_a_file_cannot_hold(tmp_path, area, suffix, said):
    asked = sky.Survey(area, "mavic-3e", gsd="2 cm", overlap=(60, 40))
    mission = planned_survey("flat", surveys=[asked])
    with pytest.raises(sky.InputError, match=said) as caught:
        sky.export(mission, tmp_path / f"m.{suffix}", sky.ExportOptions(survey_item=True))
    assert caught.value.sentence.field == "survey_item"
    assert not [*tmp_path.iterdir()]
