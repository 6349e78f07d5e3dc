import dataclasses
import struct

import numpy as np
import pytest

import skyverse as sky
from skyverse.draw import convergence, instant, paths, scene, trajectories

ALL = ["paths", "trajectories", "flight-start", "flight-middle", "flight-end", "convergence"]


def lines(figure):
    """All lines and dots of the map, as (n, 3) points with their colours."""
    return [(np.array(line.get_data_3d(), dtype=float).T, line) for line in figure.axes[0].get_lines()]


def test_all_figures_are_written_as_png(mission, tmp_path):
    written = sky.write_figures(mission, tmp_path)
    assert [path.name for path in written] == [f"{name}.png" for name in ALL]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in written)
    for path in written:
        head = path.read_bytes()[:24]
        width, height = struct.unpack(">II", head[16:24])
        assert head.startswith(b"\x89PNG")
        assert width >= 1500
        assert height >= 600


def test_a_mission_without_flight_and_history_has_one_figure(grounded, tmp_path):
    assert [path.name for path in sky.write_figures(grounded, tmp_path, suffix=".svg")] == ["paths.svg"]
    assert "<svg" in (tmp_path / "paths.svg").read_text()


def test_names_that_bite_and_findings_are_drawn(troubled, tmp_path):
    written = sky.write_figures(troubled, tmp_path)
    assert [path.stem for path in written] == ALL
    rings = [line for points, line in lines(trajectories(scene(troubled))) if line.get_markersize() == 15]
    assert len(rings) == 1


def test_other_suffixes_are_refused(mission, tmp_path):
    with pytest.raises(ValueError, match=r"\.png"):
        sky.write_figures(mission, tmp_path, suffix=".bmp")


def test_a_missing_folder_is_an_error(mission, tmp_path, refuses):
    with refuses():
        sky.write_figures(mission, tmp_path / "nowhere")


def test_the_map_is_in_true_proportions_and_labelled(mission):
    axes = paths(scene(mission)).axes[0]
    sides = np.array(axes._box_aspect)
    np.testing.assert_allclose(sides / sides.max(), np.array([10, 25, 6]) / 25)
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == ["x (m)", "y (m)", "z (m)"]
    np.testing.assert_allclose(axes.get_ylim(), (-5, 20))


def test_paths_are_drawn_in_their_uavs_colours(mission):
    drawn = scene(mission)
    shown = lines(paths(drawn))
    for track in drawn.tracks:
        assert any(line.get_color() == track.colour and np.array_equal(points, track.path) for points, line in shown)


def test_an_instant_shows_each_uav_where_it_is_and_its_trail(mission):
    figure = instant(scene(mission), 4.0)
    ends = {tuple(np.round(points[-1], 6)) for points, _ in lines(figure)}
    for trajectory in mission.trajectories:
        place = np.round(trajectory.at(4.0).position[0], 2)
        assert any(np.allclose(place, end, atol=0.02) for end in ends)
    assert "t = 4.0 s of 8.0 s" in figure.get_suptitle()


def test_convergence_shows_cost_and_optimum_over_both_efforts(mission):
    left, right = convergence(scene(mission)).axes
    np.testing.assert_array_equal(left.get_lines()[0].get_xdata(), [0, 1, 2, 3])
    np.testing.assert_array_equal(right.get_lines()[0].get_xdata(), [25, 50, 75, 100])
    np.testing.assert_allclose(left.collections[0].get_segments()[0], [(0, 40), (3, 40)])


def test_thirty_uavs_and_a_wide_map_fit(swarm):
    drawn = scene(swarm)
    figure = trajectories(drawn)
    assert len(figure.legends[0].get_texts()) == 32
    bounds = drawn.scenario.bounds.model_copy(update={"max": (60.0, 20.0, 6.0)})
    wide = dataclasses.replace(drawn, scenario=drawn.scenario.model_copy(update={"bounds": bounds}))
    figure = paths(wide)
    assert figure.get_figwidth() > figure.get_figheight()
