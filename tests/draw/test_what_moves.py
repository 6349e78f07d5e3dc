"""Pages draw each mover where it is, as large as it is with its doubt, and a zone's edges while it is active."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from browser import opened, until
from skyverse.draw import grown, page, scene, scene_data, span


def among_movers():
    ends = {"points": [(2, -2, 2), (2, 6, 2)], "times": [0, 8]}
    shapes = (
        sky.Box(min=(-1, -0.5, -0.2), max=(1, 0.5, 0.2)),
        sky.Cylinder(centre=(0, 0), radius=0.5, low=-1, high=1),
        sky.Sphere(centre=(0, 0, 0), radius=0.5),
        sky.Ellipsoid(centre=(0, 0, 0), semi_axis_xy=0.5, semi_axis_z=1.0),
    )
    doubt = sky.Doubt(radius=0.1, growth=0.05)
    movers = [sky.Mover(shape=shape, motion=sky.WaypointMotion(**ends), doubt=doubt) for shape in shapes]
    return sky.Scenario(**{**dict(sky.read("map3")), "movers": movers})


def test_edges_are_those_of_the_shape_with_its_doubt():
    drawn = scene_data(scene(sky.plan_mission(among_movers())))
    half_sizes = [(1, 0.5, 0.2), (0.5, 0.5, 1), (0.5, 0.5, 0.5), (0.5, 0.5, 1.0)]
    grown = [(1, 1, 1), (1, 1, 1), (1, 1, 1), (1, 1, 2)]  # an ellipsoid grows in proportion
    for mover, half, more in zip(drawn["movers"], half_sizes, grown, strict=True):
        edges, outwards = (np.array(mover[name], dtype=float) for name in ("edges", "outwards"))
        assert np.allclose(np.nanmax(edges, axis=1), half, atol=1e-3)
        assert np.allclose(np.nanmax(outwards, axis=1), more, atol=1e-3)
        assert mover["doubt"][0] == 0.1
        assert np.isclose(mover["doubt"][-1], 0.1 + 0.05 * drawn["makespan"], atol=1e-3)
        assert np.allclose(np.array(mover["positions"])[:, 0], (2, -2, 2))
    roles = [trace["meta"]["role"] for trace in drawn["space"]]
    assert roles.count("mover") == roles.count("way") == 1


def test_rings_on_the_map_are_those_of_the_shape_with_its_doubt():
    drawn = scene_data(scene(sky.plan_mission(among_movers())))
    half_sizes = [(1, 0.5), (0.5, 0.5), (0.5, 0.5), (0.5, 0.5)]
    for mover, half in zip(drawn["movers"], half_sizes, strict=True):
        ring, outwards = np.array(mover["ring"]), np.array(mover["ring_outwards"])
        assert np.allclose(ring.max(axis=1), half, atol=0.01)
        assert np.allclose((ring + 0.3 * outwards).max(axis=1), np.array(half) + 0.3, atol=0.01)
        assert mover["name"].startswith("mover-")
    roles = [trace["meta"]["role"] for trace in drawn["map"]["traces"]]
    assert roles.count("way") == 1
    (named,) = (trace for trace in drawn["space"] if trace["meta"]["role"] == "mover-name")
    assert named["text"] == [mover["name"] for mover in drawn["movers"]]


def test_many_movers_have_no_names():
    scenario = among_movers()
    many = sky.Scenario(**{**dict(scenario), "movers": sky.random_movers(scenario, 9, seed=1).movers})
    drawn = scene_data(scene(sky.plan_mission(many)))
    assert {mover["name"] for mover in drawn["movers"]} == {""}
    assert "mover-name" not in {trace["meta"]["role"] for trace in drawn["space"]}


@given(st.sampled_from(range(4)), st.floats(0, 0.5), st.floats(0, 2 * np.pi), st.floats(0, 1.5))
@settings(max_examples=60)
def test_the_side_of_a_mover_is_where_its_shape_is(which, more, bearing, aside):
    """Levels over a place are where a vertical line enters and leaves the shape, found from the shape's definition."""
    mover = among_movers().movers[which]
    shape, east, north = grown(mover, more), aside * np.cos(bearing), aside * np.sin(bearing)
    low, high = span(shape, np.array([(east, north)]))[0]
    z = np.linspace(-3, 3, 4001)
    if which == 0:
        inside = (abs(east) <= 1 + more) & (abs(north) <= 0.5 + more) & (abs(z) <= 0.2 + more)
    elif which == 1:
        inside = (aside <= 0.5 + more) & (abs(z) <= 1 + more)
    else:
        wide, tall = (0.5 + more, 0.5 + more) if which == 2 else (0.5 + more, 1 + 2 * more)
        inside = (aside / wide) ** 2 + (z / tall) ** 2 <= 1
    if inside.any():
        assert (low, high) == pytest.approx((z[inside].min(), z[inside].max()), abs=0.06)
    elif not np.isnan(low):
        assert high - low < 0.1  # between two samples of z, at the rim


def test_a_profile_shows_a_mover_where_the_uav_passes_below_it():
    ball = sky.Sphere(centre=(0, 0, 0), radius=1.0)
    stands = sky.Mover(name="balloon", shape=ball, motion=sky.WaypointMotion(points=[(5, 5, 8)], times=[0]))
    scenario = sky.Scenario(
        name="meadow",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 10)),
        clearance=0.5,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5)),
        objective=sky.Objective(unit="metres"),
        movers=[stands],
        uavs=[sky.UAV(start=(1, 5, 2))],
        targets=[sky.Target(position=(9, 5, 2))],
    )
    drawn = scene(sky.plan_mission(scenario))
    (passed,) = drawn.profiles[0].movers
    assert passed.name == "balloon"
    assert passed.distance[[0, -1]] == pytest.approx((3, 5), abs=0.1)
    assert (passed.levels.min(), passed.levels.max()) == pytest.approx((7, 9), abs=0.01)
    roles = [trace["meta"]["role"] for trace in scene_data(drawn)["profiles"][0]["traces"]]
    assert roles.count("mover") == 1


def test_a_page_without_movers_and_active_zones_has_none(mission):
    drawn = scene_data(scene(mission))
    assert drawn["movers"] == drawn["active"] == []
    assert not {"mover", "way", "active"} & {trace["meta"]["role"] for trace in drawn["space"]}


# ---- zones with active times ----
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


def test_edges_come_and_go_as_the_slider_moves(tmp_path, tab):
    sky.write_html(sky.plan_mission(among_zones()), tmp_path / "page.html")
    opened(tab, tmp_path / "page.html")
    slider = tab.get_by_role("slider", name="Time of flight in seconds")
    for t, low in (("1", 1.0), ("2.5", 1.5), ("3.5", None), ("4.5", 1.0)):
        slider.fill(t)
        x = "document.getElementById('space').data.find((one) => one.meta.role === 'active').x"
        until(tab, x, lambda found: min((value for value in found if value is not None), default=None) == low)  # noqa: B023


def test_what_is_proven_names_movers_and_zones():
    movers, zones = (page(scene(sky.plan_mission(one))) for one in (among_movers(), among_zones()))
    assert "clear of obstacles, clear of movers, in bounds and within limits" in movers
    assert "Movers: their edges, with their doubt, and dotted lines for their ways." in movers
    assert "clear of zones while they are active" in zones
    assert "Zones with active times: edges drawn while they are active." in zones
