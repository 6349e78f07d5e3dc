"""The page of an export shows where UAVs may land, and says what the export says."""

import json
import re
from dataclasses import replace
from html import unescape

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin, Terrain
from skyverse.draw import found
from skyverse.exports import report

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)


def up_a_slope():
    """Two flights up a slope, below a ceiling that keeps them from returning at some instants."""
    heights = np.interp(np.linspace(-320, 320, 33), [-200, 200], [0.0, 90.0])[:, None] * np.ones((1, 33))
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=heights, clearance=2.0)
    flights = [handmade.along([(-200, y, 25.0), (200, y, 115.0)], 60) for y in (-100, 100)]
    made = handmade.mission(flights, terrain=ground, clearance=1.0, origin=ORIGIN)
    scenario = made.scenario.model_copy(update={"max_height": 50.0})
    return sky.Mission(scenario, made.assignment, made.results, made.trajectories, (), made.provenance)


def test_the_page_shows_every_home_and_all_that_is_said(tmp_path, monkeypatch):
    drawn, notes, seen = [], [], []
    page = report.page
    monkeypatch.setattr(report, "page", lambda scene: drawn.append(scene) or page(scene))
    files = sky.export(
        up_a_slope(), tmp_path / "m.plan", page=tmp_path / "m.html", on_note=notes.append, on_certificate=seen.append
    )
    assert files == [tmp_path / "m-uav-1.plan", tmp_path / "m-uav-2.plan", tmp_path / "m.html"]
    (scene,) = drawn
    for uav, back in enumerate(seen[0].returns):
        (own,) = [place for place in scene.landings if place.uav == uav]
        np.testing.assert_allclose(own.position, back.plan.home, atol=1e-9)
        home = json.loads((tmp_path / f"m-uav-{uav + 1}.plan").read_text())["mission"]["plannedHomePosition"]
        said = re.search(r": home, ([-\d.]+), ([-\d.]+), ", own.words)
        assert (float(said[1]), float(said[2])) == pytest.approx(home[:2], abs=2e-6)
        sheet = dict(zip(scene.sheet[0], scene.sheet[uav + 1], strict=True))
        assert sheet["load, in this order"].split(", ")[0] == f"m-uav-{uav + 1}.plan"
        assert [float(word) for word in sheet["home"].split(", ")[:2]] == pytest.approx(home[:2], abs=2e-6)
        assert sheet["returns at"] == f"{back.altitude:.4g} m above home"
    text = (tmp_path / "m.html").read_text("utf-8")
    words = unescape("".join(found(scene).values()))
    assert notes
    assert all(f"<li>{note}</li>" in words for note in notes)
    assert text.count('"role":"landing"') == 4  # of two UAVs, in space and on the map


def test_a_flight_in_parts_says_why_and_what_to_do_between_them(tmp_path, monkeypatch):
    drawn, notes = [], []
    page = report.page
    monkeypatch.setattr(report, "page", lambda scene: drawn.append(scene) or page(scene))
    corners = [(4.0 * k - 240.0, 20.0 * (k % 2), 30.0) for k in range(120)]
    made = handmade.mission([handmade.along(corners, 600)], clearance=1.0, origin=ORIGIN)
    sky.export(made, tmp_path / "m.wpml.kmz", page=tmp_path / "m.html", on_note=notes.append)
    (said,) = [note for note in notes if "parts" in note]
    assert said.startswith("BEFORE each flight, load all its parts: uav-1 in 2, as DJI takes 99 waypoints in a file")
    assert drawn[0].sheet[1][1] == "m-part-1-of-2.wpml.kmz, m-part-2-of-2.wpml.kmz"


def test_the_name_of_a_uav_is_no_warning(tmp_path, monkeypatch):
    made = handmade.mission([handmade.along([(0, 0, 10), (50, 0, 10)], 20)], clearance=1.0, origin=ORIGIN)
    uavs = tuple(uav.model_copy(update={"name": "NOTUS"}) for uav in made.scenario.uavs)
    made = replace(made, scenario=made.scenario.model_copy(update={"uavs": uavs}))
    drawn = []
    page = report.page
    monkeypatch.setattr(report, "page", lambda scene: drawn.append(scene) or page(scene))
    sky.export(made, tmp_path / "m.plan", page=tmp_path / "m.html")
    (scene,) = (replace(one, export_notes=("It flies.",)) for one in drawn)
    assert any("NOTUS" in row for row in scene.export_verdicts)
    assert 'class="verdict note"' in "".join(found(scene).values())


def test_only_waypoints_have_a_page(tmp_path, refuses):
    with refuses():
        sky.export(up_a_slope(), tmp_path / "m.kml", page=tmp_path / "m.html")
    assert not list(tmp_path.iterdir())
