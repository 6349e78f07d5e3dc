"""The arrays of an answer are read-only, and compared element by element."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.arrays import frozen


def arrays(mission):
    for thing in (*mission.results, *mission.trajectories, *(r.history for r in mission.results)):
        yield from (value for value in vars(thing).values() if isinstance(value, np.ndarray))


def test_the_arrays_of_an_answer_are_read_only_even_after_a_pickle(mission):
    for answer in (mission, pickle.loads(pickle.dumps(mission))):
        assert answer == mission
        assert len(list(arrays(answer))) == 2 * 3 + 2 * 2 + 2 * 5
        for array in arrays(answer):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0


def test_an_answer_does_not_change_with_the_array_it_was_made_from():
    knots = np.array([0.0, 1.0])
    trajectory = sky.Trajectory(knots, np.zeros((1, 6, 3)))
    knots[1] = 9.0
    assert trajectory.end == 1.0


def test_answers_differ_where_one_element_differs():
    one = sky.Trajectory(np.array([0.0, 1.0]), np.zeros((1, 6, 3)))
    other = np.zeros((1, 6, 3))
    other[0, 5, 2] = 1e-300
    assert one == replace(one)
    assert one != replace(one, coefficients=other)


def test_a_read_only_array_is_shared_and_a_view_is_copied():
    whole = frozen(np.arange(4.0))
    assert frozen(whole) is whole
    view = whole[1:]
    assert frozen(view) is not view
    assert not frozen(view).flags.writeable
