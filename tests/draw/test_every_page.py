"""Every kind of page, on a desk and on a phone: the verdict first, the picture on the first screen, and nothing cut."""

import dataclasses

import pytest

import skyverse as sky
from browser import MISFITS, SIZES, fits, new_tab
from skyverse.draw import page, scenario_page, scenario_scene, scene
from skyverse.lab import Report, Table, html
from skyverse.waypoints.page import check_page
from surveyed import surveyed

ITEMS = """QGC WPL 110
0\t1\t0\t16\t0\t0\t0\t0\t46.81\t9.85\t1560\t1
1\t0\t3\t22\t0\t0\t0\t0\t46.81\t9.85\t40\t1
2\t0\t3\t16\t0\t0\t0\t0\t46.812\t9.85\t200\t1
3\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1
"""
HEADS = ("flight", "load, in this order", "home", "returns at", "starts", "battery")
ROW = (
    "ada",
    "field-ada-part-1-of-2.wpml.kmz, field-ada-part-2-of-2.wpml.kmz",
    "46.812345, 9.832412, 1760.4 m above mean",
)
TOUR = {
    "uavs": [{"start": (0, 1, 2), "end": "home"}, {"start": (9, 1, 2), "end": "home"}],
    "targets": [{"name": name, "position": place} for name, place in (("valve", (2, 14, 1)), ("a lamp", (1, 8, 5)))]
    + [{"name": "a gauge with a long name of many words", "position": (5, 10, 4), "stay": 2, "window": (0, 60)}],
}


def exported(mission):
    """The page of an export with much to heed."""
    notes = tuple(f"BEFORE flight {k}, look at all that stands around the place where it begins." for k in range(40))
    verdicts = (("UAV", *["apart in flight"] * 6), ("uav-1", *["NOT at every instant of the flight"] * 6))
    told = {
        "export_notes": notes,
        "export_verdicts": verdicts,
        "sheet": (HEADS, (*ROW, "30 m above home", "t = 0 s", "takes 9 Wh and leaves 61 % of its battery")),
    }
    return page(dataclasses.replace(scene(mission), **told))


def tour():
    room = sky.read("map1").model_dump() | TOUR
    return page(scene(sky.plan_mission(sky.Scenario.model_validate(room), "taut")))


def checked(folder):
    (folder / "high.waypoints").write_text(ITEMS)
    where = sky.BuildOptions("flat", max_height=sky.AboveGround(120), clearance=2, ground_clearance=2)
    return check_page(sky.check_waypoints([sky.read_waypoints(folder / "high.waypoints")], where))


@pytest.mark.parametrize("kind", ["mission", "troubled", "swarm", "export", "tour", "survey", "scenario", "check"])
def test_a_page_says_go_or_no_go_first_and_hides_and_cuts_nothing(kind, request, browser, tmp_path):
    made = {
        "export": lambda: exported(request.getfixturevalue("mission")),
        "tour": lambda: tour(),
        "survey": lambda: page(scene(surveyed())),
        "scenario": lambda: scenario_page(scenario_scene(request.getfixturevalue("mission").scenario)),
        "check": lambda: checked(tmp_path),
    }
    text = made.get(kind, lambda: page(scene(request.getfixturevalue(kind))))()
    (tmp_path / "page.html").write_text(text, "utf-8")
    with new_tab(browser) as tab:
        fits(tab, tmp_path / "page.html")


def test_a_page_prints_as_a_sheet_of_what_a_pilot_prepares(mission, browser, tmp_path):
    (tmp_path / "page.html").write_text(exported(mission), "utf-8")
    with new_tab(browser) as tab:
        fits(tab, tmp_path / "page.html")
        tab.emulate_media(media="print")
        tab.set_viewport_size({"width": 720, "height": 1000})  # A4 within margins
        assert tab.get_by_text("field-ada-part-2-of-2.wpml.kmz").is_visible()
        assert tab.get_by_text("46.812345, 9.832412").is_visible()
        assert not tab.locator("#space").is_visible()
        assert tab.evaluate("document.documentElement.scrollWidth") <= 720


def test_the_wide_tables_of_a_study_are_cut_nowhere(browser, tmp_path):
    heads = ("planner", *(f"95 % of column {k}" for k in range(11)))
    rows = [(f"planner {k}", *[123456.5] * 11) for k in range(3)]
    settings = Table(("planner", "settings"), [("mvo", "MVO(" + "a_setting=0.1, " * 20)])
    report = Report("a study", [settings, Table(heads, rows)])
    (tmp_path / "report.html").write_text(html(report, {}), "utf-8")
    for width, height in SIZES:
        with new_tab(browser, width, height) as tab:
            tab.goto((tmp_path / "report.html").as_uri())
            assert tab.evaluate(MISFITS) == []
