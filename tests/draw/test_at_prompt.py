"""What the prompt and notebooks show: ``plot`` returns a figure, and a notebook shows a picture with the words."""

import base64
import re
import subprocess
import sys
from io import BytesIO

import numpy as np
import pytest
from matplotlib.image import imread

import skyverse as sky


def pictured(html):
    """Return the picture inside HTML as an array of pixels."""
    (inside,) = re.findall(r'src="data:image/png;base64,([^"]+)"', html)
    return imread(BytesIO(base64.b64decode(inside)), format="png")


def curve(axes):
    """Return the first line of a panel, (n, 2)."""
    return axes.get_lines()[0].get_xydata()


def test_a_mission_has_the_figures_that_are_written_of_it(mission, tmp_path):
    for path in sky.write_figures(mission, tmp_path):
        assert mission.plot(path.stem).get_suptitle()
    assert mission.plot().get_suptitle() == "walls: trajectories"
    with pytest.raises(sky.InputError, match=r"^this mission has no figure 'profile'; it has paths, trajectories, "):
        mission.plot("profile")


def test_a_mission_in_which_nobody_flies_shows_its_path(grounded):
    assert grounded.plot().get_suptitle() == "walls: path"
    with pytest.raises(sky.InputError, match=r"it has paths$"):
        grounded.plot("trajectories")


def test_a_scenario_shows_starts_and_targets(mission):
    assert mission.scenario.plot().get_suptitle() == "walls: before planning"


def test_a_result_shows_its_path_from_above_and_from_the_side_and_its_search(mission):
    result = mission.results[0]
    above, side, search = result.plot().axes
    np.testing.assert_array_equal(curve(above), result.path[:, :2])
    np.testing.assert_array_equal(curve(side), [(0, 3), (3, 3), (16, 3), (19, 3)])
    np.testing.assert_array_equal(curve(search), [(25, 90), (50, 60), (75, 50), (100, 44)])
    assert search.get_lines()[1].get_ydata()[0] == result.bound


def test_a_result_without_history_or_path_is_drawn_all_the_same(grounded, troubled):
    assert len(grounded.results[0].plot().axes) == 2
    lost = troubled.results[1].plot()
    assert len(curve(lost.axes[0])) == 0
    assert lost._repr_png_().startswith(b"\x89PNG")


def test_a_result_is_drawn_among_the_obstacles_of_a_scenario(mission):
    result = mission.results[0]
    axes = result.plot(mission.scenario).axes[0]
    lines = [np.array(line.get_data_3d()).T for line in axes.get_lines()]
    assert any(np.array_equal(points, result.path) for points in lines)
    assert axes.get_title() == ""
    assert len(axes.collections) > 0


@pytest.mark.parametrize("shape", ["minimum-time", "stop-and-go"])
def test_a_trajectory_shows_height_speed_climb_and_acceleration_at_their_extremes(shape):
    scenario = sky.read("map2")
    trajectory = sky.plan_mission(scenario, shape=shape).trajectories[0]
    t = np.linspace(trajectory.start, trajectory.end, 20_001)
    motion = trajectory.at(t)
    speed, acceleration = (np.linalg.norm(v, axis=1) for v in (motion.velocity, motion.acceleration))
    expected = (motion.position[:, 2], speed, motion.velocity[:, 2], acceleration)
    for axes, values in zip(trajectory.plot().axes, expected, strict=True):
        drawn = curve(axes)
        np.testing.assert_allclose(np.interp(t, *drawn.T), values, atol=0.02 * np.ptp(values) + 1e-9)
        assert drawn[:, 1].max() >= values.max() - 0.002 * np.ptp(values)


def test_a_trajectory_is_drawn_with_the_limits_of_its_uav(mission):
    uav = sky.UAV(start=(0, 0, 1), max_speed=6, max_acceleration=4, max_climb=2, max_descent=1)
    panels = mission.trajectories[0].plot(uav).axes
    limits = [[line.get_ydata()[0] for line in axes.get_lines()[1:]] for axes in panels]
    assert limits == [[], [6], [2, -1], [4]]
    free = uav.model_copy(update={"max_climb": None, "max_descent": None})
    assert len(mission.trajectories[0].plot(free).axes[2].get_lines()) == 1


def test_a_result_without_such_a_figure_says_how_it_is_drawn(mission, grounded):
    with pytest.raises(sky.InputError, match=r"plot\(\), its path and its search, or by plot\(scenario\).*'paths'$"):
        mission.results[0].plot("paths")
    with pytest.raises(sky.InputError, match=r"its search has no history to draw, or by plot.* found 'convergence'$"):
        grounded.results[0].plot("convergence")


def test_a_trajectory_has_no_named_figures_and_says_how_it_is_drawn(mission):
    with pytest.raises(sky.InputError, match=r"plot\(uav\), with the limits of a UAV such .* found 'x'$"):
        mission.trajectories[0].plot("x")


def test_the_figure_of_a_trajectory_is_titled(mission):
    trajectory = mission.trajectories[0]
    title = trajectory.plot().get_suptitle()
    assert title.startswith(f"{trajectory.form} trajectory, ")
    assert title.endswith(" s long")
    assert trajectory.plot(mission.scenario.uavs[0]).get_suptitle() == f"{mission.scenario.uavs[0].name}: {title}"


def test_a_notebook_shows_each_with_a_picture_and_words(mission):
    for shown in (mission, mission.scenario, mission.results[0], mission.trajectories[0]):
        html = shown._repr_html_()
        assert pictured(html).std() > 0.02
        first, *_ = repr(shown).replace("'", "&#x27;").splitlines()
        assert f"<pre>{first}" in html
        assert len(html) < 500_000


def test_a_notebook_shows_a_mission_in_a_browser_without_fetching_anything(mission, tab):
    tab.set_content(f"<body>{mission._repr_html_()}</body>")
    assert tab.evaluate("document.querySelector('img').naturalWidth") > 600
    cells = tab.evaluate("[...document.querySelectorAll('tbody tr')].map(row => row.cells[0].innerText)")
    assert cells == ["ada", "ben"]
    assert tab.errors == []
    assert not [address for address in tab.requests if not address.startswith("data:")]


def test_no_name_can_run_a_script_in_a_notebook(troubled, tab):
    tab.on("dialog", lambda dialog: (tab.errors.append(dialog.message), dialog.dismiss()))
    tab.set_content(f"<body>{troubled._repr_html_()}</body>")
    assert tab.evaluate("document.scripts.length") == 0
    assert tab.errors == []


def test_nothing_is_drawn_before_it_is_wanted_and_pyplot_keeps_no_figure():
    code = """
import sys
import skyverse as sky
scenario = sky.read("map1")
assert "matplotlib" not in sys.modules
assert scenario.plot()._repr_png_()
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)
