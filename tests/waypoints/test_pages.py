"""The page of judged missions shows the items' numbers, what is wrong, and the fences of files."""

import json
import re

import pytest

import skyverse as sky
from skyverse.waypoints.page import check_page

MISSION = """QGC WPL 110
0\t1\t0\t16\t0\t0\t0\t0\t46.81\t9.85\t1560\t1
1\t0\t3\t22\t0\t0\t0\t0\t46.81\t9.85\t40\t1
2\t0\t3\t16\t0\t0\t0\t0\t46.812\t9.85\t{high}\t1
3\t0\t3\t16\t0\t0\t0\t0\t46.812\t9.852\t40\t1
4\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1
"""


def drawn(tmp_path, high, **settings):
    """Return the data that the page of a mission over level ground draws, and its words."""
    (tmp_path / "<b>.waypoints").write_text(MISSION.format(high=high))
    where = sky.BuildOptions("flat", max_height=sky.AboveGround(120), clearance=2, ground_clearance=2)
    page = check_page(
        sky.check_waypoints([sky.read_waypoints(tmp_path / "<b>.waypoints")], where, sky.FlightSettings(**settings))
    )
    return json.loads(re.search(r'id="mission">(.*?)</script>', page, re.DOTALL)[1]), page


def numbers(traces, role):
    """Return the words that are written on a picture in a role, as the dots that keep them apart are not seen."""
    marks = [one for one in traces if one["meta"]["role"] == role and "text" in one.get("mode", "").split("+")]
    assert all(one["marker"]["opacity"] == 0 for one in marks)
    return [text for one in marks for text in one["text"]]


def test_numbers_of_items_are_marked_where_something_is_wrong(tmp_path):
    data, page = drawn(tmp_path, 200)
    for traces in (data["map"]["traces"], data["profiles"][0]["traces"]):
        assert numbers(traces, "finding") == ["<b>1</b>", "<b>2</b>", "<b>3</b>"]
        assert sum(one.get("mode") == "markers" and one["meta"]["role"] == "finding" for one in traces) == 1
    assert "Go: " not in page
    assert "<b>.waypoints" not in page.partition("<script")[0]


def test_legs_that_fail_are_drawn_from_end_to_end(tmp_path):
    data, _ = drawn(tmp_path, 200)
    for traces, across in ((data["space"], "y"), (data["map"]["traces"], "y"), (data["profiles"][0]["traces"], "x")):
        (legs,) = [one for one in traces if one["meta"]["role"] == "finding" and one.get("mode") == "lines"]
        along = [value for value in legs[across] if value is not None]
        assert max(along) - min(along) == pytest.approx(222.4 if across == "y" else 222.4 + 152.4, abs=2.0)


def test_stretches_without_a_return_show_beside_legs_that_fail(tmp_path):
    data, page = drawn(tmp_path, 1, return_altitude=2.0)
    for traces in (data["space"], data["map"]["traces"], data["profiles"][0]["traces"]):
        amber, red = [one for one in traces if one["meta"]["role"] == "finding" and one.get("mode") == "lines"]
        assert amber["line"]["color"] != red["line"]["color"]
        assert amber["line"]["width"] >= 2 * red["line"]["width"]
    times = re.findall(r'data-time="([0-9.]+)">show t = [0-9.]+ s(?: \(([0-9]+):([0-9]+) min\))?<', page)
    assert times
    assert all(not minutes or abs(60 * int(minutes) + int(rest) - float(at)) <= 0.5 for at, minutes, rest in times)


def test_the_page_says_what_is_left_out_of_a_proof(tmp_path):
    _, page = drawn(tmp_path, 40, autopilot="dji")
    assert "Go: proven, but for returns within 50 m of home." in page


def test_a_proven_mission_has_no_mark(tmp_path):
    data, page = drawn(tmp_path, 40)
    assert numbers(data["map"]["traces"], "names") == ["1", "2", "3"]
    assert numbers(data["map"]["traces"], "finding") == []
    assert "Go: proven." in page
