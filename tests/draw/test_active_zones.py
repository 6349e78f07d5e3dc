"""Pages draw the edges of a zone while it is active, and not while it is not; legends say when it is."""

import numpy as np

import skyverse as sky
from browser import opened, until
from skyverse.draw import scene, scene_data


def among_zones():
    corners = {"min": (1, -2, 1), "max": (3, 0, 3)}
    zones = (
        sky.Box(**corners, active=[[0, 2], [4, None]]),
        sky.Cylinder(centre=(2, 4), radius=0.5, low=0, high=2, active=[[None, 3]], max_speed=1.0),
        sky.Voxels(origin=(0, 0, 5), step=(1, 1, 1), occupied=np.ones((2, 1, 1), bool), active=[[100, 200]]),
        sky.Sphere(centre=(4, 4, 4), radius=0.5, risk=2.0),
    )
    return sky.Scenario(**{**dict(sky.read("map3")), "zones": zones})


def test_edges_are_those_of_zones_with_active_times():
    drawn = scene_data(scene(sky.plan_mission(among_zones())))
    assert [zone["spans"] for zone in drawn["active"]] == [((0, 2), (4, None)), ((None, 3),), ((100, 200),)]
    boxes = [((1, -2, 1), (3, 0, 3)), ((1.5, 3.5, 0), (2.5, 4.5, 2)), ((0, 0, 5), (2, 1, 6))]
    for zone, (low, high) in zip(drawn["active"], boxes, strict=True):
        edges = np.array(zone["edges"], dtype=float)
        assert np.allclose(np.nanmin(edges, axis=1), low, atol=1e-2)
        assert np.allclose(np.nanmax(edges, axis=1), high, atol=1e-2)
    assert [trace["meta"]["role"] for trace in drawn["space"]].count("active") == 1
    titles = " ".join(kind["title"] for kind in drawn["kinds"])
    assert "zone, active from 0 s to 2 s and from 4 s on" in titles
    assert "speed limit 1 m/s, active until 3 s" in titles


def test_a_page_without_such_zones_has_none():
    drawn = scene_data(scene(sky.plan_mission(sky.read("map1"))))
    assert drawn["active"] == []
    assert "active" not in {trace["meta"]["role"] for trace in drawn["space"]}


def test_what_is_proven_names_zones(tmp_path):
    sky.write_html(sky.plan_mission(among_zones()), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "clear of zones while they are active" in page
    assert "Zones with active times: edges drawn while they are active." in page


def test_edges_come_and_go_as_the_slider_moves(tmp_path, tab):
    sky.write_html(sky.plan_mission(among_zones()), tmp_path / "page.html")
    opened(tab, tmp_path / "page.html")
    slider = tab.get_by_role("slider", name="Time of flight in seconds")
    for t, low in (("1", 1.0), ("2.5", 1.5), ("3.5", None), ("4.5", 1.0)):
        slider.fill(t)
        x = "document.getElementById('space').data.find((one) => one.meta.role === 'active').x"
        until(tab, x, lambda found: min((value for value in found if value is not None), default=None) == low)  # noqa: B023
