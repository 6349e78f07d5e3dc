"""What is kept around flights is drawn: tracking errors, pads, separations, the ceiling, and the time of a place."""

import dataclasses
import re
from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from browser import opened, until
from skyverse.draw import duct, from_above, from_the_side, in_space, page, scene, scene_data, told
from towns import hills
from traces import columns, enclosed, numbers, of_role

ERROR = {"horizontal": 1.0, "vertical": 2.0}


@pytest.fixture(scope="module")
def planned():
    """Two UAVs over hills below a ceiling; the first one starts and ends near the ground."""
    ground = hills(300, clearance=1.0)

    def above(x, y, height):
        return x, y, float(ground.height((x, y))) + height

    uavs = [
        {"name": "ada", "start": above(60, 60, 1.5), "tracking_error": ERROR, "separation": 5.0},
        {"name": "ben", "start": above(60, 200, 20), "separation": 5.0},
    ]
    scenario = sky.Scenario(
        name="hills",
        bounds={"min": (0, 0, -50), "max": (300, 300, 200)},
        terrain=ground,
        clearance=1.0,
        max_height=60.0,
        lattice={"step": (10, 10, 10)},
        uavs=uavs,
        targets=[{"position": above(200, 80, 1.5)}, {"position": above(200, 220, 20)}],
        frame={"origin": {"latitude": 46.8, "longitude": 9.8, "altitude": 1500}},
    )
    return sky.plan_mission(scenario, sky.Taut(), rng=1, assignment="identity")


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ([(0, 0, 5), (10, 0, 5), (30, 0, 5)], 30 * 2 * 4),
        ([(0, 0, 5), (0, 0, 25)], 20 * 2 * 2),
        ([(0, 0, 0), (3, 4, 0), (6, 8, 0)], 10 * 2 * 4),
    ],
)
def test_a_duct_is_as_wide_and_high_as_the_error_on_both_sides(line, expected):
    points, triangles = duct(np.array(line, dtype=float), 1.0, 2.0)
    assert abs(enclosed(points, triangles)) == pytest.approx(expected)


def test_a_duct_holds_what_strays_by_the_error_and_little_more():
    line = np.column_stack([np.linspace(0, 40, 30), 5 * np.sin(np.linspace(0, 3, 30)), np.linspace(0, 10, 30)])
    points, _ = duct(line, 1.0, 2.0)
    rings = points.reshape(-1, 4, 3)
    np.testing.assert_allclose(rings.mean(axis=1), line, atol=1e-9)
    reach = np.linalg.norm(rings - line[:, None], axis=2)
    assert reach.min() >= np.hypot(1, 2) * 0.9
    assert reach.max() <= np.hypot(1, 2) * 1.2


def test_only_uavs_that_may_stray_have_tubes(planned):
    drawn = scene(planned)
    (tube,) = of_role(in_space(drawn), "tube")
    assert (tube["meta"]["uav"], tube["name"]) == (0, "ada: tracking error")
    points = columns(tube, "xyz")
    nominal = drawn.tracks[0].positions
    away = np.abs(points[:, None] - nominal).max(axis=2).min(axis=1)
    assert away.max() < 6
    (strip,) = of_role(from_above(drawn)["traces"], "tube")
    assert strip["meta"]["uav"] == 0
    bands = {side["uav"]: [trace["name"] for trace in side["traces"]] for side in from_the_side(drawn)}
    assert "Tracking error, 2 m" in bands[0]
    assert not any(name.startswith("Tracking") for name in bands[1])


def test_pads_are_drawn_and_told_where_there_are_any(planned):
    drawn = scene(planned)
    assert {(one.uav, one.end) for one in drawn.pads} == {(0, "its start"), (0, "its target")}
    traces = of_role(in_space(drawn), "pad")
    assert [trace["name"] for trace in traces] == ["ada: pad at its start", "ada: pad at its target"]
    for trace, one in zip(traces, drawn.pads, strict=True):
        points = columns(trace, "xyz")
        assert points[:, 2].min() == pytest.approx(one.pad.place[2], abs=1e-3)
        assert points[:, 2].max() == pytest.approx(one.pad.top, abs=1e-3)
    assert "of ada at its start up to z = " in page(drawn)


def test_half_the_separation_is_drawn_around_each_of_several_uavs(planned, grounded):
    data = scene_data(scene(planned))
    assert data["separations"][1] == [2.5, 5.0]
    assert data["separations"][0][0] > 2.5  # it may stray
    assert len(of_role(data["space"], "separation")) == 1
    alone = scene_data(scene(grounded))
    assert alone["separations"] == [[0.0, 0.0]]
    assert of_role(alone["space"], "separation") == []
    assert "Rings" in told(scene(planned))
    assert told(scene(grounded)) == ""


def test_the_ceiling_above_ground_is_in_the_picture(planned, grounded):
    drawn = scene(planned)
    (ceiling,) = of_role(in_space(drawn), "ceiling")
    assert ceiling["meta"]["above"] == 60.0
    assert drawn.world.high[2] >= drawn.world.relief.z.max() + 60
    assert of_role(in_space(scene(grounded)), "ceiling") == []
    assert "base" not in ceiling["meta"]


def test_the_ceiling_in_the_picture_stands_on_the_lowest_ground(planned):
    ground = planned.scenario.terrain.model_copy(update={"lowest": planned.scenario.terrain.heights - 3})
    below = replace(planned, scenario=planned.scenario.model_copy(update={"terrain": ground}))
    drawn = scene(below)
    (ceiling,) = of_role(in_space(drawn), "ceiling")
    base = numbers(ceiling["meta"]["base"])
    places = np.stack(np.meshgrid(drawn.world.relief.x, drawn.world.relief.y, indexing="ij"), axis=-1)
    np.testing.assert_allclose(base, ground.height(places).T - 3, atol=1e-4)


def test_a_profile_tells_the_time_at_each_place(planned):
    drawn = scene(planned)
    profile, side = drawn.profiles[1], from_the_side(drawn)[1]
    trajectory = planned.trajectories[1]
    np.testing.assert_allclose(trajectory.at(profile.times).position, profile.points, atol=0.2)
    for instant, place in side["seconds"]:
        k = np.searchsorted(profile.times, instant)
        assert profile.distance[min(k, len(profile.distance) - 1)] == pytest.approx(place, abs=2)
    instants = [instant for instant, _ in side["seconds"]]
    assert instants == sorted(set(instants))
    assert 3 <= len(instants) <= 8
    (flight,) = of_role(side["traces"], "flight")
    assert re.search(r"m above ground<br>t = %\{customdata\[1\]:,\.1f\} s", flight["hovertemplate"])


def test_a_flight_is_drawn_beside_its_plan_and_the_error_around_the_plan(planned):
    drawn = scene(planned)
    track = drawn.tracks[0]
    strayed = dataclasses.replace(track, positions=track.positions + np.array((0.0, 0.0, 0.7)))
    flown = dataclasses.replace(drawn, tracks=(strayed, drawn.tracks[1]))
    side, beside = from_the_side(flown)
    (plan,), (band,) = of_role(side["traces"], "planned"), of_role(side["traces"], "tube")
    np.testing.assert_allclose(columns(plan, "y")[:, 0], track.nominal[:, 2], atol=1e-3)
    heights = columns(band, "y")[:, 0]
    assert np.nanmax(heights) == pytest.approx(track.nominal[:, 2].max() + 2, abs=0.1)
    assert of_role(beside["traces"], "planned") == []


def test_a_path_without_a_trajectory_has_no_time(planned, grounded):
    assert scene(grounded).profiles[0].times is None
    assert from_the_side(scene(grounded))[0]["seconds"] == []


# ---- in a browser ----
ROLE = "document.getElementById('space').data.find((trace) => trace.meta.role === '{}')"


def test_margins_are_drawn_and_switched_off_in_a_browser(planned, tmp_path, tab):
    target = tmp_path / "page.html"
    sky.write_html(planned, target)
    opened(tab, target)
    ceiling, separation = ROLE.format("ceiling"), ROLE.format("separation")
    assert tab.evaluate(f"Math.min(...{ceiling}.z.map((z, k) => z))") > 0
    before = tab.evaluate(f"{separation}.x[0]")
    tab.get_by_role("slider", name="Time of flight in seconds").fill("20")
    until(tab, f"{separation}.x[0]", lambda found: found != before)
    tab.get_by_label("ceiling, 60 m above ground").click()
    tab.get_by_label("Tracking error").click()
    tab.get_by_label("Separation").click()
    for role in ("ceiling", "rim", "tube", "pad", "separation"):
        until(tab, f"{ROLE.format(role)}.visible === false")
    seconds = "document.querySelectorAll('#profile .x2tick').length"
    assert tab.evaluate(seconds) >= 3
    assert tab.errors == []
