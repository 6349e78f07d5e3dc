"""Worlds of rotorpy's, as rotorpy reads them."""

import json

import numpy as np
import pytest

import skyverse as sky

WORLD = {
    "bounds": {"extents": [-2.0, 3.0, -1, 4.0, 0.0, 2.5]},
    "blocks": [
        {"extents": [0.0, 1.0, 0.0, 2.0, 0.0, 2.0], "color": [1, 0, 0]},
        {"extents": [2, 2.5, 3, 3.5, 1, 1.5], "color": "blue"},
    ],
}


def written(tmp_path, data):
    (tmp_path / "maze.json").write_text(json.dumps(data))
    return tmp_path / "maze.json"


def test_a_world_gives_its_bounds_and_boxes(tmp_path):
    scenario = sky.read(written(tmp_path, WORLD))
    assert scenario.name == "maze"
    assert scenario.bounds == sky.Bounds(min=(-2, -1, 0), max=(3, 4, 2.5))
    assert scenario.obstacles == (sky.Box(min=(0, 0, 0), max=(1, 2, 2)), sky.Box(min=(2, 3, 1), max=(2.5, 3.5, 1.5)))
    assert (scenario.clearance, scenario.lattice.step, scenario.uavs) == (0.25, (0.25, 0.25, 0.25), ())


def test_the_boxes_are_as_far_away_as_rotorpy_says(tmp_path):
    pytest.importorskip("rotorpy")
    from rotorpy.world import World

    path = written(tmp_path, WORLD)
    points = np.random.default_rng(1).uniform((-2, -1, 0), (3, 4, 2.5), (200, 3))
    _, theirs = World.from_file(path).closest_points(points)
    boxes = sky.read(path).obstacles
    ours = [min(np.linalg.norm(p - np.clip(p, b.min, b.max)) for b in boxes) for p in points]
    np.testing.assert_allclose(ours, theirs, atol=1e-12)


@pytest.mark.parametrize(
    "change",
    [
        {"bounds": {"extents": [0, 1, 0, 1, 0]}},
        {"bounds": {"extents": [0, 1, 0, 1, 1, 0]}},
        {"bounds": {"extents": [0, 1, 0, 1, 0, float("nan")]}},
        {"bounds": {"extents": [0, 1, 0, 1, 0, 1e300]}},
        {"blocks": 3},
        {"blocks": [{}]},
        {"blocks": [{"extents": [0, 1, 0, 1, 0, "1"]}]},
    ],
)
def test_a_world_that_is_wrong_is_refused(change, tmp_path, refuses):
    path = written(tmp_path, {**WORLD, **change})
    with refuses():
        sky.read(path)
