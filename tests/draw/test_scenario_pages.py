"""Scenarios drawn before anything is planned."""

import json
import re
from html import unescape

import pytest

import skyverse as sky
from browser import opened
from skyverse.draw import in_space, scenario_page, scenario_scene, scene_data, told_frame
from towns import town

ROOM = sky.Scenario(
    name="<room>",
    bounds=sky.Bounds(min=(0, 0, 0), max=(20, 20, 10)),
    obstacles=(sky.Box(min=(4, 4, 0), max=(8, 8, 6), name="Tower", kind="building"),),
    clearance=0.5,
    lattice=sky.Lattice(step=(1, 1, 2)),
    uavs=(sky.UAV(name="a", start=(6, 6, 2)), sky.UAV(name="b", start=(1, 1, 1))),
    targets=(sky.Target(name="a", position=(18, 18, 5)), sky.Target(name="c", position=(25, 5, 5))),
)


def test_points_that_are_not_safe_are_findings_with_their_places():
    drawn = scenario_scene(ROOM)
    assert [(one.kind, one.uavs, one.position) for one in drawn.findings] == [
        ("start", ("a",), (6, 6, 2)),
        ("target", ("c",), (25, 5, 5)),
    ]
    assert (
        "the roof is at z = 6 m there; the nearest free place is (8.5, 6, 2), 2.5 m away." in drawn.findings[0].message
    )
    marks = next(trace for trace in in_space(drawn) if trace["meta"]["role"] == "finding")
    assert marks["x"] == [6, 25]


def test_the_page_says_what_there_is_and_what_is_not_safe():
    page = scenario_page(scenario_scene(ROOM))
    body, data = page[page.index("<body>") :].split('<script type="application/json" id="mission">')
    text = unescape(" ".join(re.sub(r"<[^>]*>", " ", body).split()))
    for words in (
        "2 of 4 starts and targets are not safe.",
        "Nothing is planned yet.",
        "Lattice 2,646 nodes, 1 \N{MULTIPLICATION SIGN} 1 \N{MULTIPLICATION SIGN} 2 m apart",
        "Bounds 20 \N{MULTIPLICATION SIGN} 20 \N{MULTIPLICATION SIGN} 10 metres, no terrain",
        "Obstacles 1 kept away from by 0.5 m",
        "<room>",
    ):
        assert words in text
    assert text.count("not safe") == 4  # heading, hint, two rows of the table
    data = json.loads(data[: data.index("</script>")])
    assert [track["name"] for track in data["tracks"]] == ["a", "b"]
    assert data["makespan"] == 0


def test_a_safe_scenario_and_a_bare_map_have_pages():
    assert "All starts and targets are safe." in scenario_page(scenario_scene(sky.read("map1")))
    bare = ROOM.model_copy(update={"uavs": (), "targets": ()})
    assert "There are no UAVs and no targets." in scenario_page(scenario_scene(bare))


def test_places_on_earth_have_latitude_longitude_and_height_above_ground():
    drawn = scenario_scene(town(3).scenario)
    text = scenario_page(drawn)
    assert all(word in text for word in ("Above ground", "Latitude, longitude", "Altitude"))


@pytest.mark.parametrize("uavs", [0, 2])
def test_the_page_is_drawn_in_a_browser(tmp_path, tab, uavs):
    scenario = ROOM.model_copy(update={"uavs": ROOM.uavs[:uavs], "targets": ROOM.targets[:uavs]})
    sky.write_html(scenario, tmp_path / "room.html")
    opened(tab, tmp_path / "room.html")
    assert tab.errors == []
    assert tab.locator("#space .gl-container canvas").count() > 0
    assert tab.locator("#map").is_visible()
    assert not tab.locator("#transport").is_visible()
    assert not tab.locator("#profile").is_visible()
    assert not tab.locator("#search").is_visible()
    assert tab.locator("#grounded").text_content() == "Nothing is planned yet."


def test_the_figure_of_a_scenario_is_written(tmp_path):
    assert sky.write_figures(ROOM, tmp_path) == [tmp_path / "scenario.png"]
    assert (tmp_path / "scenario.png").read_bytes()[:4] == b"\x89PNG"


def test_a_page_says_above_what_heights_are_counted():
    jacksboro = sky.read("jacksboro")
    origin = jacksboro.frame.origin
    said = told_frame(origin)
    assert said.startswith(
        f"x is east, y north, z up from {origin.latitude:.5f}&deg; N, {-origin.longitude:.5f}&deg; W"
    )
    assert said.endswith(f"where z = 0 is {origin.altitude:.5g} m above mean sea level.")
    south = sky.Origin(latitude=-33.5, longitude=151, altitude=-12.5)
    assert "from 33.50000&deg; S, 151.00000&deg; E, where z = 0 is -12.5 m above" in told_frame(south)
    assert told_frame(None) == "x is east, y north, z up from the scenario's own zero."
    assert scene_data(scenario_scene(jacksboro))["frame"] == said
