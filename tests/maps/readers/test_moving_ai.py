"""MovingAI's voxel maps."""

import os
from pathlib import Path

import numpy as np
import pytest

import skyverse as sky
from skyverse.maps.readers.local_worlds import read_voxels

DATA = Path(os.environ.get("SKYVERSE_DATA", Path(__file__).parents[4] / "shared" / "data")) / "voxels"


def written(tmp_path, text):
    (tmp_path / "a.3dmap").write_text(text)
    return tmp_path / "a.3dmap"


def test_a_map_gives_a_scenario_of_its_size_without_uavs(tmp_path):
    scenario = sky.read(written(tmp_path, "voxel 3 4 2\n0 0 0\n2 3 1\n2 3 1\n"))
    assert scenario.bounds == sky.Bounds(min=(0, 0, 0), max=(3, 4, 2))
    (voxels,) = scenario.obstacles
    assert np.argwhere(voxels.occupied).tolist() == [[0, 0, 0], [2, 3, 1]]
    assert (scenario.clearance, scenario.lattice.step, scenario.uavs) == (0.25, (1, 1, 1), ())


def test_a_map_has_voxels_of_the_size_that_is_asked_for(tmp_path):
    voxels = read_voxels(written(tmp_path, "voxel 3 4 2\n"), size=2.5)
    assert voxels.step == (2.5, 2.5, 2.5)
    assert not voxels.occupied.any()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "octile 3 4 2\n",
        "voxel 3 4\n",
        "voxel 3 -4 2\n",
        "voxel 0 4 2\n",
        "voxel 1000000 1000000 1000000\n0 0 0\n",
        "voxel 3 4 2\n0 0\n",
        "voxel 3 4 2\n0 0 0\n0 0\n",
        "voxel 3 4 2\n0 0 x\n",
        "voxel 3 4 2\n0 0 1.5\n",
        "voxel 3 4 2\n0 0 99999999999999999999\n",
        "voxel 3 4 2\n0 0 2\n",
        "voxel 3 4 2\n-1 0 0\n",
    ],
)
def test_a_map_that_is_wrong_is_refused(text, tmp_path, refuses):
    path = written(tmp_path, text)
    with refuses():
        sky.read(path)


@pytest.mark.skipif(not (DATA / "Simple.3dmap").is_file(), reason="needs MovingAI's Simple.3dmap")
def test_the_benchmarks_map_is_read_whole():
    (voxels,) = sky.read(DATA / "Simple.3dmap").obstacles
    lines = (DATA / "Simple.3dmap").read_text().splitlines()
    assert voxels.occupied.shape == (105, 132, 105)
    assert {tuple(cell) for cell in np.argwhere(voxels.occupied).tolist()} == {
        tuple(map(int, line.split())) for line in lines[1:]
    }
