"""The tiles and tables of a mission's page: the same numbers as on the command line, those of a pilot first."""

import dataclasses
import math
import re

import numpy as np
import pytest

import skyverse as sky
from browser import opened
from skyverse.cli.report import report
from skyverse.draw import flight_table, mission_tiles, page, scene, search_table, total_cost_sentence
from skyverse.model.flight_table import flight_columns, search_columns
from skyverse.space.mission_cautions import nearest_obstacle


def cells(columns):
    """The cells of a table by the head of their column."""
    return {column.head: column.cells for column in columns}


def words(text):
    """The words of a piece of HTML, one cell after the other."""
    return [word for word in re.split(r"<[^>]*>", text) if word.strip()]


def test_a_pilots_table_tells_what_is_flown(mission):
    told = cells(flight_columns(mission))
    assert told["UAV"] == ("ada", "ben")
    assert told["target"] == ("north", "south")
    assert told["status"] == ("complete", "optimal")
    assert told["cost"] == ("44 nodes", "17 nodes")
    assert told["gap at most"] == ("10 %", "0 %")  # 44 of 40 nodes, and 17 of 17
    assert told["flown"] == ("14.32 m", "7.071 m")  # straight from (5, -4, 3) by (2, 2.5, 3) to (5, 9, 3)
    assert told["time"] == ("8 s", "4 s + 1 s wait")
    assert told["climb"] == ("0 m", "1 m")
    assert told["steepest"] == ("0°", "8°")
    assert told["altitude"] == ("3.0 to 3.0 m", "3.0 to 4.0 m")
    assert not {"generated paths", "divergence"} & told.keys()


def test_what_students_of_planners_read_is_in_a_table_of_its_own(mission):
    told = cells(search_columns(mission))
    assert told["exact optimum"] == ("40", "17")
    assert told["fuel"] == ("44", "17")
    assert told["generated paths"] == ("100", "25")
    assert told["search"] == ("0.25 s", "0.25 s")
    assert told["departs at"] == ("0 s", "1 s")
    assert "risk" not in told
    first, *others = mission.results
    riskier = dataclasses.replace(first, terms=first.terms | {"risk": 2.0})
    told = cells(search_columns(dataclasses.replace(mission, results=(riskier, *others))))
    assert told["risk"] == ("2", "-")
    assert told["lower bound"] == ("40", "17")


def test_what_is_missing_is_told_as_missing(troubled):
    told = cells(flight_columns(troubled))
    assert told["status"] == ("complete", "no path", "not planned", "stays at its start")
    assert told["cost"] == ("27 nodes", "-", "-", "-")
    assert told["flown"] == ("13 m", "-", "-", "-")
    assert told["target"][3] == "-"
    drawn = scene(troubled)
    assert words(mission_tiles(drawn))[1] == "1 of 3"
    assert total_cost_sentence(drawn) == ""
    assert "27" in search_table(drawn)


def test_no_column_is_empty_or_says_what_another_says(troubled):
    mission = sky.plan_mission(sky.read("table-4.9-2"), sky.Taut())
    unbounded = tuple(dataclasses.replace(one, bound=None) for one in mission.results)
    for one in (troubled, dataclasses.replace(mission, results=unbounded)):
        assert all(set(cells) - {"-"} for cells in cells(flight_columns(one)).values())
    pairs = zip(mission.results, mission.flights, strict=True)
    lengths = (dataclasses.replace(one, cost=own.length) for one, own in pairs)
    assert "cost" not in cells(flight_columns(dataclasses.replace(mission, results=tuple(lengths))))


def test_pages_and_plan_tell_the_distance_to_the_nearest_obstacle(mission, capsys):
    flown = np.concatenate([one.at(np.linspace(one.start, one.end, 5000)).position for one in mission.trajectories])
    box = sky.Box(min=(6, 0, 0), max=(7, 1, 2))
    away = np.linalg.norm(flown - np.clip(flown, box.min, box.max), axis=1).min()
    near = dataclasses.replace(mission, scenario=mission.scenario.model_copy(update={"obstacles": (box,)}))
    shown = words(mission_tiles(scene(near)))
    assert shown[shown.index("Nearest obstacle") + 1] == f"{math.floor(100 * away) / 100:.2f} m"
    report(near, [], as_json=False)
    assert f"nearest obstacle: about {math.floor(100 * away) / 100:.2f} m\n" in capsys.readouterr().out
    assert nearest_obstacle(near) == pytest.approx(away, abs=0.01)
    assert nearest_obstacle(dataclasses.replace(near, trajectories=(None, None))) is None
    clear = dataclasses.replace(mission, scenario=mission.scenario.model_copy(update={"obstacles": ()}))
    assert "Nearest obstacle" not in mission_tiles(scene(clear))


def test_energy_is_told_only_where_the_power_of_a_vehicle_is_known():
    scenario = sky.read("table-4.9-2")
    assert "energy" not in cells(flight_columns(sky.plan_mission(scenario, sky.Taut())))
    first, second = scenario.uavs
    known = scenario.model_copy(update={"uavs": (first.model_copy(update={"hover_power": 120.0}), second)})
    mission = sky.plan_mission(known, sky.Taut())
    told, nothing = cells(flight_columns(mission))["energy"]
    assert nothing == "-"
    assert told.endswith(" Wh")
    time = mission.trajectories[0].end - mission.trajectories[0].start
    shown = words(mission_tiles(scene(mission)))
    assert shown[shown.index("Energy") + 1] == told
    assert 1 <= float(told.removesuffix(" Wh")) / (120 * time / 3600) < 1.3  # a hover, and some acceleration


def test_the_page_and_the_command_line_tell_the_same(capsys):
    mission = sky.plan_mission(sky.read("table-4.9-2"), sky.Taut())
    report(mission, [], as_json=False)
    lines = capsys.readouterr().out.splitlines()
    shown = words(flight_table(scene(mission)))
    rows = len(mission.scenario.uavs) + 1
    columns = len(shown) // rows
    for k, line in enumerate(lines[:rows]):
        there = [cell.strip().casefold() for cell in re.split(r" {2,}", line.strip())]
        assert there == [cell.casefold() for cell in shown[k * columns : (k + 1) * columns]]


def test_tiles_sum_the_fleet(mission):
    assert mission.gap == pytest.approx(4 / 57)
    shown = words(mission_tiles(scene(mission)))
    assert shown[shown.index("Altitude") + 1] == "3.0 to 4.0 m"
    assert shown[shown.index("Last arrival") + 1] == "8 s"
    assert shown[shown.index("Paths found") + 1] == "2 of 2"
    assert total_cost_sentence(scene(mission)) == "Total cost: 61 nodes, at most 7.1 % above the exact optimum."


def test_nodes_and_metres_are_told_apart_and_have_no_gap_in_common(mission):
    nodes, metres = mission.results
    mixed = dataclasses.replace(mission, results=(nodes, dataclasses.replace(metres, any_angle=True)))
    assert mixed.gap is None
    drawn = scene(mixed)
    assert total_cost_sentence(drawn) == "Total cost: 44 nodes and 17.00 m."
    assert "fuel (nodes or metres)" in search_table(drawn)


def test_a_page_opens_with_the_flights_and_hides_the_searches_until_asked(tmp_path, tab):
    mission = sky.plan_mission(sky.read("jacksboro"))
    sky.write_html(mission, tmp_path / "page.html")
    opened(tab, tmp_path / "page.html")
    assert tab.get_by_role("columnheader", name="Above ground").is_visible()
    assert "straight line" in tab.locator(".numbers .hint").text_content()
    assert "+" not in tab.locator(".numbers table").first.text_content()
    searches = tab.locator("details th", has_text="Generated paths")
    assert not searches.is_visible()
    tab.locator("details summary").click()
    assert searches.is_visible()
    assert tab.errors == []


def test_an_export_shows_what_to_heed_folds_the_rest_and_fits_a_phone(mission, tmp_path, tab):
    verdicts = (("UAV", *["apart in flight"] * 6), ("uav-1", *["NOT at every instant of the flight"] * 6))
    notes = ("uav-1 lands at home.", "BEFORE each flight, look at home.")
    drawn = dataclasses.replace(scene(mission), export_verdicts=verdicts, export_notes=notes)
    (tmp_path / "page.html").write_text(page(drawn))
    tab.set_viewport_size({"width": 390, "height": 844})
    opened(tab, tmp_path / "page.html")
    proven, heeded = (tab.get_by_text(note, exact=True) for note in notes)
    assert heeded.is_visible()
    assert not proven.is_visible()
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    tab.emulate_media(media="print")
    assert proven.is_visible()  # nobody can open it on paper
    tab.set_viewport_size({"width": 720, "height": 1000})  # A4 within margins
    assert tab.evaluate("document.documentElement.scrollWidth") <= 720
