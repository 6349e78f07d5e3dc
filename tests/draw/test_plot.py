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
from skyverse.draw import as_html


def pictured(html):
    """Return the picture inside HTML as an array of pixels."""
    (inside,) = re.findall(r'src="data:image/png;base64,([^"]+)"', html)
    return imread(BytesIO(base64.b64decode(inside)), format="png")


def curve(axes):
    """Return the first line of a panel, (n, 2)."""
    return axes.get_lines()[0].get_xydata()


def test_a_mission_has_the_figures_that_are_written_of_it(mission, tmp_path):
    for path in sky.write_figures(mission, tmp_path):
        assert sky.plot(mission, path.stem).get_suptitle()
    assert sky.plot(mission).get_suptitle() == "walls: trajectories"


def test_a_mission_in_which_nobody_flies_shows_its_path(grounded):
    assert sky.plot(grounded).get_suptitle() == "walls: path"


def test_a_scenario_shows_starts_and_targets(mission):
    assert sky.plot(mission.scenario).get_suptitle() == "walls: before planning"


def test_a_result_shows_its_path_from_above_and_from_the_side_and_its_search(mission):
    result = mission.results[0]
    above, side, search = sky.plot(result).axes
    np.testing.assert_array_equal(curve(above), result.path[:, :2])
    np.testing.assert_array_equal(curve(side), [(0, 3), (3, 3), (16, 3), (19, 3)])
    np.testing.assert_array_equal(curve(search), [(25, 90), (50, 60), (75, 50), (100, 44)])
    assert search.get_lines()[1].get_ydata()[0] == result.bound


def test_a_result_without_history_or_path_is_drawn_all_the_same(grounded, troubled):
    assert len(sky.plot(grounded.results[0]).axes) == 2
    lost = sky.plot(troubled.results[1])
    assert len(curve(lost.axes[0])) == 0
    assert lost._repr_png_().startswith(b"\x89PNG")


def test_a_result_is_drawn_among_the_obstacles_of_a_scenario(mission):
    result = mission.results[0]
    axes = sky.plot(result, mission.scenario).axes[0]
    lines = [np.array(line.get_data_3d()).T for line in axes.get_lines()]
    assert any(np.array_equal(points, result.path) for points in lines)
    assert axes.get_title() == ""
    assert len(axes.collections) > 0


@pytest.mark.parametrize("shape", ["minimum-time", "stop-and-go"])
def test_a_trajectory_shows_height_speed_climb_and_acceleration_at_their_extremes(shape):
    scenario = sky.read("map2")
    trajectory = sky.plan_mission(scenario, options=sky.MissionOptions(shape=shape)).trajectories[0]
    t = np.linspace(trajectory.start, trajectory.end, 20_001)
    motion = trajectory.at(t)
    speed, acceleration = (np.linalg.norm(v, axis=1) for v in (motion.velocity, motion.acceleration))
    expected = (motion.position[:, 2], speed, motion.velocity[:, 2], acceleration)
    for axes, values in zip(sky.plot(trajectory).axes, expected, strict=True):
        drawn = curve(axes)
        np.testing.assert_allclose(np.interp(t, *drawn.T), values, atol=0.02 * np.ptp(values) + 1e-9)
        assert drawn[:, 1].max() >= values.max() - 0.002 * np.ptp(values)


def test_a_trajectory_is_drawn_with_the_limits_of_its_uav(mission):
    uav = sky.UAV(start=(0, 0, 1), max_speed=6, max_acceleration=4, max_climb=2, max_descent=1)
    panels = sky.plot(mission.trajectories[0], uav).axes
    limits = [[line.get_ydata()[0] for line in axes.get_lines()[1:]] for axes in panels]
    assert limits == [[], [6], [2, -1], [4]]
    free = uav.model_copy(update={"max_climb": None, "max_descent": None})
    assert len(sky.plot(mission.trajectories[0], free).axes[2].get_lines()) == 1


def test_the_figure_of_a_trajectory_is_titled(mission):
    trajectory = mission.trajectories[0]
    title = sky.plot(trajectory).get_suptitle()
    assert title.startswith(f"{trajectory.form} trajectory, ")
    assert title.endswith(" s long")
    assert sky.plot(trajectory, mission.scenario.uavs[0]).get_suptitle() == f"{mission.scenario.uavs[0].name}: {title}"


def test_a_notebook_shows_each_with_a_picture_and_words(mission):
    for shown in (mission, mission.scenario, mission.results[0], mission.trajectories[0]):
        html = as_html(shown)
        assert pictured(html).std() > 0.02
        first, *_ = repr(shown).replace("'", "&#x27;").splitlines()
        assert f"<pre>{first}" in html
        assert len(html) < 500_000


def test_a_notebook_shows_a_mission_in_a_browser_without_fetching_anything(mission, tab):
    tab.set_content(f"<body>{as_html(mission)}</body>")
    assert tab.evaluate("document.querySelector('img').naturalWidth") > 600
    cells = tab.evaluate("[...document.querySelectorAll('tbody tr')].map(row => row.cells[0].innerText)")
    assert cells == ["ada", "ben"]
    assert tab.errors == []
    assert not [address for address in tab.requests if not address.startswith("data:")]


def test_no_name_can_run_a_script_in_a_notebook(troubled, tab):
    tab.on("dialog", lambda dialog: (tab.errors.append(dialog.message), dialog.dismiss()))
    tab.set_content(f"<body>{as_html(troubled)}</body>")
    assert tab.evaluate("document.scripts.length") == 0
    assert tab.errors == []


def test_nothing_is_drawn_before_it_is_wanted_and_pyplot_keeps_no_figure():
    code = """
import sys
import skyverse as sky
from skyverse.draw import as_html
scenario = sky.read("map1")
assert "matplotlib" not in sys.modules
assert sky.plot(scenario)._repr_png_()
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_ipython_is_told_what_to_show_before_anything_is_drawn():
    code = """
import sys, types
class Formatter(dict):
    def for_type_by_name(self, module, name, shown):
        self[module, name] = shown
html = Formatter()
display = types.SimpleNamespace(formatters={"text/html": html})
sys.modules["IPython"] = types.SimpleNamespace(
    version_info=(9, 0), get_ipython=lambda: types.SimpleNamespace(display_formatter=display)
)
import skyverse as sky
scenario = sky.read("map1")
assert "matplotlib" not in sys.modules
kind = type(scenario)
assert len(html) == 4
assert "<img" in html[kind.__module__, kind.__name__](scenario)
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_cannot_be_drawn_is_refused(mission, grounded, refuses):
    refused = ((mission, "profile"), (grounded, "trajectories"), (mission.results[0], "paths"), (mission, 3), (3, None))
    refused += ((grounded.results[0], "convergence"), (mission.trajectories[0], "x"), (mission.scenario, "paths"))
    for drawn, detail in refused:
        with refuses():
            sky.plot(drawn, detail)
