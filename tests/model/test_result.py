"""Answers are data that nobody changes afterwards."""

import pickle

import numpy as np
import pytest

import skyverse as sky


@pytest.fixture(scope="module")
def mission():
    return sky.plan_mission(sky.read_scenario("table-4.9-2"), sky.MVO(), stop=sky.MaxIterations(3), rng=1)


def arrays(mission):
    for thing in (*mission.results, *mission.trajectories, *(r.history for r in mission.results)):
        yield from (value for value in vars(thing).values() if isinstance(value, np.ndarray))


def test_the_arrays_of_an_answer_are_read_only_even_after_a_pickle(mission):
    for answer in (mission, pickle.loads(pickle.dumps(mission))):
        assert answer == mission
        assert len(list(arrays(answer))) == 2 * 3 + 2 * 2 + 2 * 4
        for array in arrays(answer):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0


def test_an_answer_does_not_hang_on_the_array_it_was_made_of():
    knots = np.array([0.0, 1.0])
    trajectory = sky.Trajectory(knots, np.zeros((1, 6, 3)))
    knots[1] = 9.0
    assert trajectory.end == 1.0


def test_a_gap_is_told_only_of_a_path_that_arrives(mission):
    for result in mission.results:
        assert (result.gap is not None) == result.status.reached


def test_a_mission_that_leaves_a_pair_out_is_not_complete(mission):
    assert mission.complete
    left_out = sky.Mission(
        mission.scenario,
        (mission.assignment[0], None),
        (mission.results[0], None),
        (mission.trajectories[0], None),
        (),
        mission.provenance,
    )
    assert not left_out.complete
    assert [v.fault for v in sky.check(mission.scenario, left_out)] == [sky.Fault.ASSIGNMENT]
