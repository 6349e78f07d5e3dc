"""Pages draw each mover where it is, as large as it is with its doubt."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.draw import grown, scene, scene_data, span


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


def test_a_page_without_movers_has_none():
    drawn = scene_data(scene(sky.plan_mission(sky.read("map1"))))
    assert drawn["movers"] == []
    assert not {"mover", "way"} & {trace["meta"]["role"] for trace in drawn["space"]}


def test_what_is_proven_names_movers(tmp_path):
    sky.write_html(sky.plan_mission(among_movers()), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "clear of obstacles, clear of movers, in bounds and within limits" in page
    assert "Movers: their edges, with their doubt, and dotted lines for their ways." in page
