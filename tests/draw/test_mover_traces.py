"""Pages draw each mover where it is, as large as it is with its doubt."""

import numpy as np

import skyverse as sky
from skyverse.draw.page import scene_data
from skyverse.draw.scene import scene


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


def test_a_page_without_movers_has_none():
    drawn = scene_data(scene(sky.plan_mission(sky.read("map1"))))
    assert drawn["movers"] == []
    assert not {"mover", "way"} & {trace["meta"]["role"] for trace in drawn["space"]}


def test_what_is_proven_names_movers(tmp_path):
    sky.write_html(sky.plan_mission(among_movers()), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "clear of obstacles, clear of movers, in bounds and within limits" in page
    assert "Movers: their edges, with their doubt, and thin lines for their ways." in page
