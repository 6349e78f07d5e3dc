"""Detours lead through gates in free space, past walls that block the path, among the true obstacles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from handmade import hall
from skyverse.deconfliction import Candidate
from skyverse.deconfliction.detours import _wall, gates_beside, plan_detour


def planned(seed, planner, *, vertical=False):
    """A flight past a random building, planned on the lattice or off it."""
    rng = np.random.default_rng(seed)
    corner = rng.uniform((6, 2, 0), (10, 6, 0))
    start, target = rng.uniform((1, 1, 2), (3, 11, 6)), rng.uniform((15, 1, 2), (17, 11, 6))
    if vertical:
        start, target = np.array([3.0, 3.0, 1.0]), np.array([3.0, 3.0, 7.0])
    building = sky.Box(min=tuple(corner), max=tuple(corner + rng.uniform((1, 1, 4), (4, 4, 8))))
    given = {"obstacles": [building], "clearance": 0.1, "objective": {"unit": "nodes"}}
    scenario = hall((18, 12, 8), [tuple(start)], [tuple(target)], 0.5, **given)
    airspace = sky.Airspace(scenario)
    problem = sky.Problem(airspace, 0, 0)
    result = planner.plan(problem)
    trajectory = sky.fly_along(problem, result)
    return airspace, Candidate(0, 0, 0, trajectory.end - trajectory.start, result, trajectory)


def inside(boxes, points):
    """Which points lie inside one of some boxes."""
    return np.any([(np.array(b.min) < points).all(axis=-1) & (points < np.array(b.max)).all(axis=-1) for b in boxes], 0)


PLANNERS = pytest.mark.parametrize("planner", [sky.Taut(), sky.AStar()], ids=["any angle", "lattice"])


@PLANNERS
@pytest.mark.parametrize("vertical", [False, True])
@given(seed=st.integers(0, 2**32), share=st.floats(0.1, 0.9))
def test_gates_are_in_free_space_beside_the_path_the_shortest_detour_first(seed, share, vertical, planner):
    airspace, candidate = planned(seed, planner, vertical=vertical)
    gates, offsets, ratios = gates_beside(airspace, candidate, share)
    assert len(gates) == len(offsets) == len(ratios) > 0
    assert airspace.world.free(np.array([gate.centre for gate in gates])).all()
    assert (np.diff(ratios) >= 0).all()
    assert ratios[0] >= 1
    passed = candidate.trajectory.at(candidate.trajectory.start + share * candidate.seconds).position
    for gate, offset in zip(gates, offsets, strict=True):
        np.testing.assert_allclose(gate.passed, passed[0], atol=1e-9)
        np.testing.assert_allclose(gate.centre, gate.passed + offset, atol=1e-9)


@PLANNERS
@given(seed=st.integers(0, 2**32), share=st.floats(0.2, 0.8), data=st.data())
def test_a_detour_passes_the_gate_and_not_its_wall_and_its_result_is_one_of_the_true_problem(
    seed, share, data, planner
):
    airspace, candidate = planned(seed, planner)
    gate = data.draw(st.sampled_from(gates_beside(airspace, candidate, share)[0][:30]))
    scenario = airspace.scenario
    wall = _wall(scenario.uavs[0], scenario.clearance, gate)
    blocked = np.array(gate.passed)
    blocked[gate.axis] = gate.centre[gate.axis]
    assert inside(wall, blocked)
    assert not inside(wall, np.array(gate.centre))
    any_angle = candidate.result.any_angle
    found = plan_detour(sky.Problem(airspace, 0, 0), scenario, (gate,), sky.fly_along, any_angle=any_angle)
    if found is None:
        return
    result, trajectory = found
    assert result.any_angle == any_angle
    assert sky.check_result(scenario, 0, 0, result) == []
    positions = trajectory.at(np.linspace(trajectory.start, trajectory.end, 5000)).position
    assert not inside(wall, positions).any()
    assert airspace.world.free(positions).all()
