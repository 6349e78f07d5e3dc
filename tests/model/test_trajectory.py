"""A trajectory is evaluated, and begun and flown at other times."""

import numpy as np
import pytest

import skyverse as sky

LIFT = sky.Trajectory(np.array([1.0, 3.0]), np.array([[[0, 0, 5.0], [0, 0, 1.0], [0, 0, 0.5]]]), "smooth")
"""From z = 5 m at t = 1 s: z = 5 + t' + t'^2 / 2, where t' is t - 1."""


def test_position_velocity_and_acceleration_are_those_of_the_polynomial():
    motion = LIFT.at([1.0, 2.0, 3.0])
    assert motion.position[:, 2] == pytest.approx([5, 6.5, 9])
    assert motion.velocity[:, 2] == pytest.approx([1, 2, 3])
    assert motion.acceleration[:, 2] == pytest.approx([1, 1, 1])


def test_a_uav_stands_still_before_its_trajectory_and_after_it():
    motion = LIFT.at([0.0, 9.0])
    assert motion.position[:, 2] == pytest.approx([5, 9])
    assert not motion.velocity.any()
    assert not motion.acceleration.any()


def test_a_slowed_trajectory_passes_the_same_places_later():
    slow = LIFT.retimed(10.0, 2.0)
    assert (slow.start, slow.end, slow.form) == (10.0, 14.0, "slowed")
    t = np.linspace(0, 2, 9)
    np.testing.assert_allclose(slow.at(10 + 2 * t).position, LIFT.at(1 + t).position)
    np.testing.assert_allclose(slow.at(10 + 2 * t).velocity, LIFT.at(1 + t).velocity / 2)
    assert LIFT.retimed(1.0) is LIFT
