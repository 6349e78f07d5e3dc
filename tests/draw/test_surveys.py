"""Surveys as they are seen: footprints, maps of what photos show, and the card of a page that plays through them."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from shapely import Polygon, contains_xy

import skyverse as sky
from browser import opened, until
from skyverse.draw import page, scenario_page, scenario_scene, scene
from surveyed import EAST, LEVEL, NORTH, surveyed


def data_of(text):
    return json.loads(re.search(r'<script type="application/json" id="mission">(.*?)</script>', text, re.DOTALL)[1])


def numbers(packed):
    return np.frombuffer(base64.b64decode(packed["bdata"]), "<f4")


@pytest.mark.parametrize("pitch", [-90.0, -60.0])
def test_footprints_on_a_slope_are_where_rays_meet_its_plane(pitch):
    (drawn,) = scene(surveyed(gimbal=pitch)).surveys
    assert len(drawn.photos) == 21
    down = np.radians(pitch)
    ahead, up = np.array([np.cos(down), 0, np.sin(down)]), np.array([-np.sin(down), 0, np.cos(down)])
    for k, (right, above) in enumerate([(-1, 1), (1, 1), (1, -1), (-1, -1), (0, 0)]):
        ray = ahead + 0.6 * right * np.array([0, -1, 0]) + 0.45 * above * up
        over = drawn.photos.position @ (-EAST, -NORTH, 1) - LEVEL
        times = over / -(ray @ (-EAST, -NORTH, 1))
        assert drawn.footprints[:, k] == pytest.approx(drawn.photos.position + times[:, None] * ray, abs=1e-3)
        if k == 4:
            assert drawn.gsd[0] == pytest.approx(3e-4 * times, rel=1e-6)


def test_each_sampled_place_is_shown_by_the_photos_in_whose_footprints_it_lies():
    (drawn,) = scene(surveyed()).surveys
    views = drawn.views
    x, y = (grid.ravel() for grid in np.meshgrid(views.x, views.y, indexing="ij"))
    outlines = [Polygon(one[:4, :2]) for one in drawn.footprints]
    depth = drawn.photos.position[:, 2] - (LEVEL + EAST * x + NORTH * y)[:, None]
    shown = np.stack([contains_xy(one, x, y) for one in outlines], axis=1)
    on_edges = np.stack([contains_xy(one.boundary.buffer(1e-3), x, y) for one in outlines], axis=1).any(axis=1)
    count, fine = (shown & (3e-4 * depth <= 0.03)).sum(axis=1), np.where(shown, 3e-4 * depth, np.inf).min(axis=1)
    assert np.array_equal(views.count.ravel()[~on_edges], count[~on_edges])
    assert count.max() > 5
    seen = np.isfinite(fine) & ~on_edges
    assert np.nanmax(np.abs(views.gsd.ravel()[seen] - fine[seen])) < 1e-9
    assert np.isnan(views.gsd.ravel()[~shown.any(axis=1) & ~on_edges]).all()


def test_what_a_ridge_hides_is_not_seen():
    ridge = np.zeros((25, 25))
    ridge[13] = 60.0  # at x = 25
    (drawn,) = scene(
        surveyed(heights=ridge, gimbal=-30.0, gsd=0.5, area=[(30, -10), (90, -10), (90, 10), (30, 10)])
    ).surveys
    i, j = np.abs(drawn.views.x - 80).argmin(), len(drawn.views.y) // 2
    place, least, most = np.array([drawn.views.x[i], drawn.views.y[j], 0.0]), 0, 0
    for eye in drawn.photos.position:
        sight = eye + (place - eye) * np.linspace(0, 1, 2001)[:, None]
        above = np.min((sight[:, 2] - np.interp(sight[:, 0], [0, 25, 50], [0, 60, 0]))[sight[:, 0] < 50], initial=99)
        deep, high = (place - eye) @ (np.sqrt(0.75), 0, -0.5), (place - eye) @ (0.5, 0, np.sqrt(0.75))
        if abs(high) <= 0.45 * deep:
            least, most = least + (above > 6), most + (above > -6)  # the line of sight is only sampled
    assert 0 < least <= drawn.views.count[i, j] <= most == 7


def test_holes_and_margins_count_as_they_are_asked_for():
    part = {"vertices": [(-40, -30), (40, -30), (40, 30), (-40, 30)], "holes": [[(-5, -5), (5, -5), (5, 5), (-5, 5)]]}
    (drawn,) = scene(surveyed(area=part, margin=10.0)).surveys
    (outer,) = drawn.outlines
    assert np.abs(outer[:, :2]).max(axis=0) == pytest.approx((50, 40))
    assert outer[:, 2] == pytest.approx(LEVEL + outer[:, :2] @ (EAST, NORTH))
    views = drawn.views
    assert views.count[np.abs(views.x).argmin(), np.abs(views.y).argmin()] > 0  # the margin fills the hole
    (bare,) = scene(surveyed(area=part)).surveys
    assert len(bare.outlines) == 2
    assert bare.views.count[np.abs(bare.views.x).argmin(), np.abs(bare.views.y).argmin()] == -1


def test_a_page_holds_all_photos_and_what_is_proven():
    mission = surveyed()
    text = page(scene(mission))
    (survey,) = data_of(text)["surveys"]
    photos = sky.photos_of(mission)
    assert survey["photos"]["count"] == len(photos) == 21
    assert numbers(survey["photos"]["position"]).reshape(-1, 3) == pytest.approx(photos.position, abs=1e-3)
    assert numbers(survey["photos"]["corners"]).size == 12 * 21
    gap = "50 m² about (16.7, 13.3): behind &lt;b&gt;a&lt;/b&gt; wall"
    shares = ("98.76 %", "1.91 cm", "2.23 cm", "71.2 %", "3 of 20", "1.23 ha")
    for told in ("Survey &lt;field&gt;: 98.7 % is seen.", *shares, gap):
        assert told in text, told
    assert "<b>a</b>" not in text
    (count, gsd) = survey["maps"]
    assert np.nanmax(numbers(count["z"])) == count["zmax"] == scene(mission).surveys[0].views.count.max()
    assert np.nanmax(numbers(gsd["z"])) == pytest.approx(100 * np.nanmax(scene(mission).surveys[0].views.gsd), rel=1e-6)
    assert gsd["zmax"] == pytest.approx(3.0)


def test_pages_of_thousands_of_photos_stay_small():
    mission = surveyed()
    (sortie,) = mission.sorties[0]
    dense = replace(sortie, strips=(replace(sortie.strips[0], every=0.02),))
    text = page(scene(replace(mission, sorties=((dense,),))))
    (survey,) = data_of(text)["surveys"]
    assert survey["photos"]["count"] == 5001
    assert len(text) - len(page(scene(mission))) < 1_500_000


def test_sorties_tell_how_many_photos_they_take():
    shown = re.search(r'aria-label="Sorties">.*?</table>', page(scene(surveyed())), re.DOTALL)[0]
    assert re.findall(r">(Strips|Photos|Visits)<", shown) == ["Strips", "Photos"]
    assert shown.count("<td>21</td>") == 1


def test_what_is_not_judged_is_not_called_proven():
    text = page(scene(replace(surveyed(), coverage=())))
    assert "not judged" in text
    assert "Proven to be seen" not in text


def test_pages_without_surveys_have_nothing_of_them(mission):
    text = page(scene(mission))
    assert "surveys" not in data_of(text)
    assert "data-shade" not in text
    assert "surveyed" not in text


def test_the_page_of_a_scenario_shows_what_is_to_be_seen():
    data = data_of(scenario_page(scenario_scene(surveyed().scenario)))
    for part in (data["space"], data["map"]["traces"]):
        (outline,) = [one for one in part if one["meta"]["role"] == "survey"]
        assert np.nanmax(numbers(outline["x"])) == 40


def test_figures_show_the_survey_and_a_dot_for_each_photo():
    mission = surveyed()
    photos = sky.photos_of(mission).position
    (axes,) = sky.plot(mission).axes
    drawn = [np.column_stack(line.get_data_3d()) for line in axes.get_lines() if line.get_marker() == "."]
    assert [dots.tolist() for dots in drawn] == [photos.tolist()]
    (axes,) = sky.plot(mission.scenario).axes
    assert max(len(line.get_data_3d()[0]) for line in axes.get_lines()) == len(scene(mission).surveys[0].outlines[0])


def test_a_walk_through_photos_shows_each_and_moves_the_flight(tmp_path, tab):
    mission = surveyed()
    (tmp_path / "page.html").write_text(page(scene(mission)), encoding="utf-8")
    opened(tab, tmp_path / "page.html")
    assert until(tab, "document.getElementById('taken').textContent").startswith("Photo 1 of 21 · ada, sortie 1")
    tab.click("#after")
    tab.click("#after")
    said = until(tab, "document.getElementById('taken').textContent", lambda text: text.startswith("Photo 3 "))
    (drawn,) = scene(mission).surveys
    assert f"t = {drawn.photos.time[2]:.1f} s" in said
    assert f"{100 * drawn.gsd[0][2]:.2f} cm in its middle" in said
    assert float(tab.evaluate("document.getElementById('clock').textContent").split()[0]) == drawn.photos.time[2]
    for shade in ("gsd", "sorties", "count"):
        tab.click(f"[data-shade={shade}]")
        pressed = f"document.querySelector('[data-shade={shade}]').getAttribute('aria-pressed') === 'true'"
        assert until(tab, pressed)
    slide = (
        "const s = document.getElementById('time'); s.step = 'any'; s.value = 7.4; s.dispatchEvent(new Event('input'))"
    )
    tab.evaluate(f"(() => {{ {slide} }})()")
    until(tab, "document.getElementById('taken').textContent", lambda text: text.startswith("Photo 15 "))
    assert tab.errors == []
