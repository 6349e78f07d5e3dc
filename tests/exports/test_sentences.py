"""What exports say of legs and of pairs of UAVs can be read in one way only."""

from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin, Terrain

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=46.8, longitude=9.8, altitude=1500.0, geoid=52.0)
LEVEL = Terrain(origin=(-340.0, -340.0), step=(20.0, 20.0), heights=np.zeros((35, 35)), clearance=2.0)
TOWER = ((-10.0, 200.0, 0.0), (10.0, 220.0, 40.0))
STRAIGHT = handmade.along([(-100, 0, 50), (100, 0, 50)], 40)
BENT = handmade.along([(-300, 0, 50), (0, 0, 50), (200, 200, 50)], 40)


def test_legs_tell_what_they_keep_and_what_they_do_not_exceed(says):
    mission = handmade.mission([STRAIGHT], origin=ORIGIN, terrain=LEVEL, boxes=[TOWER])
    straying = handmade.with_uavs(mission, tracking_error=sky.TrackingError(horizontal=1.6, vertical=3.0))
    open_air = handmade.mission([STRAIGHT], origin=ORIGIN)
    for one in (handmade.changed(mission, max_height=120.0), straying, open_air):
        (route,) = sky.routes(one)
        says(route.sentence(one.scenario))


def test_one_line_names_all_that_have_no_way_home_at_every_instant(tmp_path):
    wall = ((0.0, -300.0, 0.0), (1.0, 300.0, 300.0))
    corners = [(-100, 0, 50), (-100, 310, 50), (100, 310, 50), (100, 0, 50)]
    flights = [handmade.along(corners, 60), handmade.along([(-100, -100, 50), (-50, -100, 50)], 40)]
    bounds = {"low": (-400, -400, 0), "high": (400, 400, 290)}
    mission = handmade.mission(flights, origin=ORIGIN, boxes=[wall], **bounds, from_home=True)
    notes = handmade.exported(mission, tmp_path, page=tmp_path / "m.html").notes
    assert any(note.startswith("uav-1: no way home is proven from t = ") for note in notes)
    warning = "WARNING: the way home of uav-1 is not proven at every instant: the table says when not."
    assert [note for note in notes if "WARNING" in note] == [warning]
    listed = (tmp_path / "m.html").read_text().split("What is exported", 1)[1]
    assert listed.index("<li>") == listed.index(f"<li>{warning}</li>")  # in a list of which a page shows a few lines
    assert (
        "WARNING" not in handmade.exported(handmade.mission([STRAIGHT], origin=ORIGIN, from_home=True), tmp_path).said
    )


def test_a_uav_that_stops_at_each_waypoint_stops_at_none_besides():
    (flown,) = sky.routes(handmade.mission([BENT], origin=ORIGIN), stops=True)
    held = replace(flown, holds=np.full(len(flown.points), 2.0))
    assert flown.corners == held.corners == "stopping at each"
    assert replace(held, radii=np.full(len(held.points), 2.0)).corners.startswith("corners cut within 2 m but at ")


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_of_aeroplanes_no_take_off_is_told(tmp_path, suffix):
    wing = sky.FixedWing(speed=15.0, turn_radius=30.0, climb=15.0)
    for one, words in ((wing, "begin when they do in the mission."), (None, "when all take-offs have ended.")):
        notes = []
        mission = handmade.mission([STRAIGHT], origin=ORIGIN, wing=one)
        sky.export(mission, tmp_path / f"m.{suffix}", on_note=notes.append)
        (told,) = [note for note in notes if note.startswith("All times are of the exported schedule")]
        assert told.endswith(words)


@pytest.mark.parametrize("suffix", ["plan", "waypoints", "wpml.kmz"])
def test_an_altitude_that_rounds_to_zero_has_no_sign(tmp_path, suffix):
    origin, notes = ORIGIN.model_copy(update={"altitude": -50.03}), []
    mission = handmade.mission([STRAIGHT], origin=origin)
    sky.export(
        mission, tmp_path / f"m.{suffix}", sky.ExportOptions(end="rtl"), on_note=notes.append, page=tmp_path / "m.html"
    )
    (told,) = [note for note in notes if "it returns at" in note]
    assert " 0.0 m above mean sea level" in told
    said = (tmp_path / "m.html").read_text(encoding="utf-8")
    assert "0.0 m above mean sea level" in said
    assert "-0.0 m" not in said + told


@pytest.mark.parametrize(
    ("suffix", "takeoff", "told"), [("plan", 1e9, "1e+09"), ("waypoints", 40.0, "40"), ("plan", 3.0, None)]
)
def test_it_is_told_where_a_take_off_is_lower_than_asked_for(tmp_path, suffix, takeoff, told):
    """A slab is 20 m above the starts."""
    slab = ((-300, -300, 70), (300, 300, 71))
    mission = handmade.mission([STRAIGHT], origin=ORIGIN, boxes=[slab])
    seen, notes = [], []
    asked = sky.ExportOptions(takeoff=takeoff)
    sky.export(mission, tmp_path / f"m.{suffix}", asked, on_note=notes.append, on_certificate=seen.append)
    plan = seen[0].returns[0].plan
    rise = float(plan.waypoints[0][2] - plan.home[2])
    said = f"uav-1: its take-off ends {rise:.4g} m above where it stands, as there is no room to rise by {told} m."
    assert [note for note in notes if "take-off ends" in note] == ([said] if told else [])
    assert rise < 20
