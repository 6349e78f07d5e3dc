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
    ("text", "says"),
    [
        ("", "line 1: expected 'voxel'"),
        ("octile 3 4 2\n", "line 1: expected 'voxel'"),
        ("voxel 3 4\n", "line 1: expected 'voxel'"),
        ("voxel 3 -4 2\n", "line 1: expected 'voxel'"),
        ("voxel 0 4 2\n", "line 1: expected voxels along every axis"),
        ("voxel 1000000 1000000 1000000\n0 0 0\n", "expected at most 8,388,608 voxels, found 1000000 x"),
        ("voxel 3 4 2\n0 0\n", "every line after the first, found 2"),
        ("voxel 3 4 2\n0 0 0\n0 0\n", "every line after the first"),
        ("voxel 3 4 2\n0 0 x\n", "could not convert string 'x'"),
        ("voxel 3 4 2\n0 0 1.5\n", "could not convert string '1.5'"),
        ("voxel 3 4 2\n0 0 99999999999999999999\n", "every line after the first"),
        ("voxel 3 4 2\n0 0 2\n", "voxel [0, 0, 2] is outside of the [3, 4, 2] there are"),
        ("voxel 3 4 2\n-1 0 0\n", "voxel [-1, 0, 0] is outside"),
    ],
)
def test_a_map_that_is_wrong_is_refused(text, says, tmp_path):
    path = written(tmp_path, text)
    with pytest.raises(sky.InputError) as error:
        sky.read(path)
    assert str(error.value).startswith(str(path))
    assert says in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.skipif(not (DATA / "Simple.3dmap").is_file(), reason="needs MovingAI's Simple.3dmap")
def test_the_benchmarks_map_is_read_whole():
    (voxels,) = sky.read(DATA / "Simple.3dmap").obstacles
    lines = (DATA / "Simple.3dmap").read_text().splitlines()
    assert voxels.occupied.shape == (105, 132, 105)
    assert {tuple(cell) for cell in np.argwhere(voxels.occupied).tolist()} == {
        tuple(map(int, line.split())) for line in lines[1:]
    }
