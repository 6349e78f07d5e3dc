"""Planners of lengths among the voxels of the MovingAI benchmark, against its published optima."""

import math
import os
from pathlib import Path

import pytest

import skyverse as sky

DATA = Path(os.environ.get("SKYVERSE_DATA", Path(__file__).parents[3] / "shared" / "data")) / "voxels"


@pytest.fixture(scope="module")
def problems():
    """Every 99th problem, and the published optimal length of each on the lattice."""
    if not (DATA / "Simple.3dmap.3dscen").is_file():
        pytest.skip(f"the MovingAI benchmark is not at {DATA}; set SKYVERSE_DATA to where it is")
    header, *rows = (DATA / "Simple.3dmap").read_text().splitlines()
    voxels = [[int(n) for n in row.split()] for row in rows if row.strip()]
    asked = [row.split() for row in (DATA / "Simple.3dmap.3dscen").read_text().splitlines()[2:]][::99]
    assert len(asked) >= 100
    ways = [[tuple(float(n) for n in row[i : i + 3]) for i in (0, 3)] for row in asked]
    scenario = sky.Scenario(
        name="Simple",
        bounds=sky.Bounds(min=(0, 0, 0), max=[int(n) - 1 for n in header.split()[1:]]),
        obstacles=[{"min": [n - 0.5 for n in v], "max": [n + 0.5 for n in v]} for v in voxels],
        clearance=0.001,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[{"start": a} for a, _ in ways],
        targets=[{"position": b} for _, b in ways],
    )
    airspace = sky.Airspace(scenario)
    assert tuple(airspace.grid.shape) == (105, 132, 105)
    return [(sky.Problem(airspace, i, i), float(row[6])) for i, row in enumerate(asked)]


@pytest.mark.parametrize("planner", [sky.AStar(), sky.ThetaStar()], ids=repr)
def test_on_the_movingai_benchmark_paths_have_the_published_optimal_length_or_less(problems, planner):
    for problem, published in problems:
        result = planner.plan(problem)
        assert sky.check_result(problem.scenario, problem.uav, problem.target, result) == []
        assert math.dist(problem.start, problem.end) * (1 - 1e-12) <= result.cost <= published * (1 + 1e-7)
        if isinstance(planner, sky.AStar):
            assert result.cost == pytest.approx(published, rel=1e-5)
