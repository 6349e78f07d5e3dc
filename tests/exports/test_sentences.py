"""What exports say of legs and of pairs of UAVs can be read in one way only."""

import re

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse.exports.routes import routes
from skyverse.model.frame import Origin
from skyverse.model.shapes import Terrain

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=46.8, longitude=9.8, altitude=1500.0, geoid=52.0)
LEVEL = Terrain(origin=(-340.0, -340.0), step=(20.0, 20.0), heights=np.zeros((35, 35)), clearance=2.0)
TOWER = ((-10.0, 200.0, 0.0), (10.0, 220.0, 40.0))
STRAIGHT = handmade.along([(-100, 0, 50), (100, 0, 50)], 40)
BENT = handmade.along([(-300, 0, 50), (0, 0, 50), (200, 200, 50)], 40)


def legs_sentence(mission, **changes):
    scenario = mission.scenario.model_copy(update=changes)
    moved = sky.Mission(scenario, mission.assignment, mission.results, mission.trajectories, (), mission.provenance)
    (route,) = routes(moved)
    return route.sentence(scenario)


def test_legs_tell_what_they_keep_and_what_they_do_not_exceed():
    mission = handmade.mission([STRAIGHT], origin=ORIGIN, terrain=LEVEL, boxes=[TOWER])
    said = legs_sentence(mission, max_height=120.0)
    assert re.search(
        r"straight legs proven: it stays inside the bounds, keeps at least 0\.48 m from every obstacle and 1\.98\d* m "
        r"above ground and stays at most 120 m above ground\.$",
        said,
    ), said
    (uav,) = mission.scenario.uavs
    straying = uav.model_copy(update={"tracking_error": sky.TrackingError(horizontal=1.6, vertical=3.0)})
    said = legs_sentence(mission, max_height=120.0, uavs=(straying,))
    assert "proven: with its tracking error it stays inside the bounds, keeps" in said


def test_legs_say_nothing_of_obstacles_where_there_are_none():
    said = legs_sentence(handmade.mission([STRAIGHT], origin=ORIGIN))
    assert said.endswith("straight legs proven: it stays inside the bounds; the scenario has no obstacles.")


def test_pairs_that_depend_on_the_schedule_are_said_to_keep_their_separation_only_then(tmp_path):
    across = handmade.along([(0, -100, 50), (0, 100, 50)], 40, 40.0)
    crossing = handmade.mission([STRAIGHT, across], origin=ORIGIN, terrain=LEVEL)
    for end, told in (("loiter", False), ("rtl", True)):
        notes = []
        sky.export(crossing, tmp_path / f"{end}.plan", end=end, on_note=notes.append)
        (pair,) = [note for note in notes if "only on schedule" in note or "by timing" in note]
        assert pair.startswith("uav-1 and uav-2 keep their separation ")
        assert told == any(note.startswith("These paths contain the returns that end the mission") for note in notes)


def test_a_last_line_names_all_that_have_no_way_home_at_every_instant(tmp_path):
    wall = ((0.0, -300.0, 0.0), (1.0, 300.0, 300.0))
    corners = [(-100, 0, 50), (-100, 310, 50), (100, 310, 50), (100, 0, 50)]
    flights = [handmade.along(corners, 60), handmade.along([(-100, -100, 50), (-50, -100, 50)], 40)]
    bounds = {"low": (-400, -400, 0), "high": (400, 400, 290)}
    mission = handmade.mission(flights, origin=ORIGIN, boxes=[wall], **bounds, from_home=True)
    notes = []
    sky.export(mission, tmp_path / "m.plan", on_note=notes.append, page=tmp_path / "m.html")
    assert any(note.startswith("uav-1: no way home is proven from t = ") for note in notes)
    warning = "WARNING: no way home is proven at every instant of the flight of uav-1: the table says when."
    assert notes[-1] == warning
    listed = (tmp_path / "m.html").read_text().split("What is exported", 1)[1]
    assert listed.index("<li>") == listed.index(f"<li>{warning}</li>")  # in a list of which a page shows a few lines
    notes = []
    sky.export(handmade.mission([STRAIGHT], origin=ORIGIN, from_home=True), tmp_path / "m.plan", on_note=notes.append)
    assert not any("WARNING" in note for note in notes)


@pytest.mark.parametrize(
    ("suffix", "radius", "known"),
    [("plan", 2.0, False), ("waypoints", 2.0, True), ("waypoints", 1.0, True), ("waypoints", 0.5, False)],
)
def test_of_an_aeroplane_it_is_told_where_its_autopilot_does_not_turn_at_the_radius(tmp_path, suffix, radius, known):
    wing = sky.FixedWing(speed=15.0, turn_radius=30.0, climb=15.0)
    for one, told in ((wing, not known), (None, False)):
        notes = []
        mission = handmade.mission([BENT], origin=ORIGIN, wing=one)
        sky.export(mission, tmp_path / f"m.{suffix}", radius=radius, on_note=notes.append)
        assert any("what its corners keep is NOT proven" in note for note in notes) == told


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
    sky.export(mission, tmp_path / f"m.{suffix}", end="rtl", on_note=notes.append, page=tmp_path / "m.html")
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
    how = {"takeoff": takeoff, "on_note": notes.append, "on_certificate": seen.append}
    sky.export(mission, tmp_path / f"m.{suffix}", **how)
    plan = seen[0].returns[0].plan
    rise = float(plan.waypoints[0][2] - plan.home[2])
    said = f"uav-1: its take-off ends {rise:.4g} m above where it stands, as there is no room to rise by {told} m."
    assert [note for note in notes if "take-off ends" in note] == ([said] if told else [])
    assert rise < 20
