"""Tours as they are seen: numbers at targets, batteries over time, tables, and a UAV that stands while it stays."""

import dataclasses
import json
import re

import numpy as np
import pytest

import skyverse as sky
from browser import opened, until
from rounds import rounds
from skyverse.draw import page, scene


@pytest.fixture(scope="module")
def html():
    return page(scene(rounds()))


def data_of(text):
    return json.loads(re.search(r'<script type="application/json" id="mission">(.*?)</script>', text, re.DOTALL)[1])


def traces(data, part, role):
    return [one for one in data[part] if one["meta"]["role"] == role]


def test_targets_have_the_numbers_of_their_visits_in_space_and_home_is_named(html):
    for track, ends in zip(scene(rounds()).tracks, traces(data_of(html), "space", "ends"), strict=True):
        assert ends["text"] == ["", *(str(k) for k in range(1, len(track.visits) + 1))]
        assert ends["hovertext"][0].endswith(": home")
        for one, words, *place in zip(track.visits, ends["hovertext"][1:], *(ends[k][1:] for k in "xyz"), strict=True):
            assert tuple(place) == one.target.position
            assert one.target.name in words
            assert "stays 3 s" in words


def test_only_what_nobody_visits_is_a_spare_target(html):
    (spare,) = traces(data_of(html), "space", "spare")
    assert spare["x"] == [10]
    assert "<shut>" not in html
    assert "no UAV flies to &lt;shut&gt;" in html


def test_batteries_empty_to_no_less_than_the_reserve_and_are_full_after_a_swap(html):
    data, mission = data_of(html), rounds()
    courses = traces(data, "battery", "battery")
    flown = [(uav, one) for uav, own in enumerate(mission.sorties) for one in own]
    for (uav, sortie), course in zip(flown, courses, strict=True):
        assert course["meta"]["uav"] == uav
        assert (course["x"][0], course["x"][-1]) == pytest.approx((sortie.begin, sortie.end), abs=1e-3)
        assert course["y"][0] == pytest.approx(90)
        assert np.all(np.diff(course["y"]) < 0)
        assert course["y"][-1] >= 20
    (swap,) = traces(data, "battery", "swap")
    assert swap["x"] == pytest.approx([mission.sorties[1][0].end, mission.sorties[1][1].begin], abs=1e-3)
    (reserve,) = traces(data, "battery", "reserve")
    assert reserve["y"][:2] == [20, 20]
    for mark, (_, sortie) in zip(traces(data, "battery", "no return"), flown, strict=True):
        assert sortie.begin < mark["x"][0] < sortie.end


def test_a_mission_without_batteries_has_no_chart_of_them(mission):
    assert data_of(page(scene(mission)))["battery"] == []


def test_a_page_of_a_tour_draws_its_batteries_and_plays_through_stands(tmp_path, html, tab):
    (tmp_path / "page.html").write_text(html, encoding="utf-8")
    opened(tab, tmp_path / "page.html")
    assert tab.evaluate("document.getElementById('battery').data.length") == len(data_of(html)["battery"])
    fleet = next(k for k, one in enumerate(data_of(html)["space"]) if one["meta"]["role"] == "fleet")
    (visit, *_) = rounds().sorties[0][0].visits
    stood = rounds().scenario.targets[visit.target].position
    for share in (0.1, 0.9):
        t = visit.arrival + share * (visit.departure - visit.arrival)
        slide = f"const s = document.getElementById('time'); s.step = 'any'; s.value = {t};"
        tab.evaluate(f"(() => {{ {slide} s.dispatchEvent(new Event('input')); }})()")
        seen = until(tab, f"(({{ x, y, z }}) => [x[0], y[0], z[0]])(document.getElementById('space').data[{fleet}])")
        assert seen == pytest.approx(stood, abs=1e-3)
    assert tab.errors == []


def test_a_figure_of_a_tour_shows_the_numbers_of_its_visits():
    (axes,) = [one for one in sky.plot(rounds()).axes if hasattr(one, "zaxis")]
    numbers = [text.get_text() for text in axes.texts]
    assert sorted(number for number in numbers if number.isdigit()) == ["1", "1", "2", "2", "3", "4"]


def test_a_tour_that_was_not_judged_is_drawn_all_the_same():
    unjudged = dataclasses.replace(rounds(), certificates=(), apart=None)
    assert traces(data_of(page(scene(unjudged))), "battery", "battery")
