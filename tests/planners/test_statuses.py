"""Where there is nothing to plan, every planner says why, in the same words, and never gives a wrong path."""

import math

import numpy as np
import pytest
from hypothesis import given
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

import skyverse as sky
from judged_missions import mission_of
from skyverse.errors import Sentence
from worlds import exits_of, indices_of, neighbours, scenarios, shape_of

PLANNERS = [
    sky.MVO(universes=4),
    sky.MVO(universes=4, as_run=True),
    sky.MVO(universes=4, generator="uniform"),
    sky.RandomRestart(samples=4),
    sky.AStar(),
]
every_planner = pytest.mark.parametrize("planner", PLANNERS, ids=repr)
STOP = sky.MaxIterations(3)

CELL = [  # closes the cell of lattice nodes (3, 3, 3) off from all others
    sky.Box(min=(2.4, 2.4, 2.4), max=(2.5, 3, 3)),
    sky.Box(min=(2.4, 2.4, 2.4), max=(3, 2.5, 3)),
    sky.Box(min=(2.4, 2.4, 2.4), max=(3, 3, 2.5)),
]
WALL = sky.Box(min=(1.4, 0, 0), max=(1.6, 3, 3))
BLOCK = sky.Box(min=(0.8, 0.8, 0.8), max=(1.3, 1.3, 1.3))


def hall(start, target, *obstacles, **changes):
    return sky.Scenario(
        name="hall",
        bounds=sky.Bounds(min=(0, 0, 0), max=(3, 3, 3)),
        obstacles=obstacles,
        lattice=changes.pop("lattice", sky.Lattice(step=(1, 1, 1))),
        clearance=0.001,
        uavs=(sky.UAV(start=start),),
        targets=(sky.Target(position=target),),
        **changes,
    )


@every_planner
@pytest.mark.parametrize(
    ("scenario", "status"),
    [
        (hall((1.1, 1.1, 1.1), (3, 0, 0), BLOCK), sky.Status.START_UNSAFE),
        (hall((3, 0, 0), (1.1, 1.1, 1.1), BLOCK), sky.Status.TARGET_UNSAFE),
        (hall((1.1, 1.1, 1.1), (1.1, 1.1, 1.1), BLOCK), sky.Status.START_UNSAFE),
        (hall((-0.1, 0, 0), (3, 0, 0)), sky.Status.START_OUT_OF_BOUNDS),
        (hall((0, 0, 0), (3, 0, 3.001)), sky.Status.TARGET_OUT_OF_BOUNDS),
        (hall((2.9, 2.9, 2.9), (0, 0, 0), *CELL), sky.Status.START_SHUT_IN),
        (hall((0, 0, 0), (2.9, 2.9, 2.9), *CELL), sky.Status.NO_PATH),
        (hall((0, 0, 0), (3, 3, 3), WALL), sky.Status.NO_PATH),
        (hall((0, 0, 0), (3, 3, 3), WALL, objective="turns"), sky.Status.NO_PATH),
        (hall((0, 0, 0), (3, 3, 3), WALL, lattice=sky.Lattice(step=(1, 1, 1), connectivity=26)), sky.Status.NO_PATH),
    ],
    ids=lambda value: value.value if isinstance(value, sky.Status) else "",
)
def test_a_problem_without_an_answer_gets_the_status_that_says_why(planner, scenario, status):
    problem = sky.Problem(scenario)
    result = planner.plan(problem, stop=STOP, rng=0)
    assert result.status is status
    assert result.path.shape == (0, 3)
    assert math.isinf(result.cost)
    assert result.terms == {}
    assert result.gap is None
    assert result.effort == sky.Effort()
    assert sky.fly_along(problem, result) is None
    assert sky.check(scenario, mission_of(problem, result)) == []


def test_every_status_has_a_sentence_of_its_own():
    sentences = [status.sentence for status in sky.Status]
    assert len(set(sentences)) == len(sentences)
    assert all((s.endswith(".") or isinstance(s, Sentence)) and len(s) > 20 for s in sentences)
    assert {status for status in sky.Status if status.reached} == {sky.Status.OPTIMAL, sky.Status.COMPLETE}


@every_planner
@pytest.mark.parametrize("unit", ["nodes", "metres"])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_start_that_is_the_target_is_reached_by_staying(planner, unit, turn):
    objective = sky.Objective(unit=unit, divergence=turn)
    problem = sky.Problem(hall((1.2, 2.3, 0.1), (1.2, 2.3, 0.1), objective=objective))
    result = planner.plan(problem, stop=STOP, rng=0)
    assert result.status is sky.Status.OPTIMAL
    np.testing.assert_array_equal(result.path, [(1, 2, 0)])
    assert result.cost == (1 if unit == "nodes" else 0)
    assert result.gap == 0
    trajectory = sky.fly_along(problem, result)
    np.testing.assert_allclose(trajectory.at([0, 1e6]).position, [(1.2, 2.3, 0.1)] * 2)


@given(scenarios(most_nodes=5))
def test_on_every_lattice_all_planners_agree_on_whether_there_is_a_path(scenario):
    """The truth: whether brute force joins the two nodes."""
    problem = sky.Problem(scenario)
    statuses = {p: p.plan(problem, stop=STOP, rng=0).status for p in PLANNERS}
    if problem.refusal is not None:
        assert set(statuses.values()) == {problem.refusal}
        return
    steps = neighbours(scenario.lattice.connectivity)
    a, m = np.nonzero(exits_of(scenario, steps))
    indices = indices_of(scenario)
    b = np.ravel_multi_index(tuple((indices[a] + steps[m]).T), shape_of(scenario))
    n = len(indices)
    _, part = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(n, n)).tocsr())
    joined = part[problem.source] == part[problem.goal]
    assert (statuses[sky.AStar()] is sky.Status.OPTIMAL) == joined
    for status in statuses.values():
        assert (status is sky.Status.NO_PATH) == (not joined)


@pytest.mark.parametrize(("uav", "target", "field"), [(1, 0, "uav"), (-1, 0, "uav"), (0, 5, "target")])
def test_a_uav_or_target_that_is_not_there_is_named(uav, target, field):
    with pytest.raises(sky.InputError) as refused:
        sky.Problem(hall((0, 0, 0), (1, 1, 1)), uav=uav, target=target)
    assert refused.value.sentence.field == field
