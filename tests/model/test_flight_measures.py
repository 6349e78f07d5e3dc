"""What tables tell of a flight besides its length: climb, steepest slope and heights."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.flight_table import measure_flight


@pytest.fixture
def over_a_hill():
    """Return a flight that climbs 3 m over 4 m, descends 1 m over 4 m, and hovers for a while."""
    legs = np.array([[(0, 0, 1), (4, 0, 3)], [(4, 0, 4), (4, 0, -1)], [(8, 0, 3), (0, 0, 0)]], dtype=float)
    return sky.Trajectory(np.array([0.0, 1, 2, 5]), legs)


def test_climb_slope_and_heights_are_those_of_the_flight(over_a_hill):
    found = measure_flight(over_a_hill)
    assert found.climb == pytest.approx(3)
    assert found.steepest == pytest.approx(np.degrees(np.arctan2(3, 4)))
    assert (found.lowest, found.highest) == pytest.approx((1, 4))


def test_heights_are_counted_from_a_terrain(over_a_hill):
    ramp = sky.Terrain(origin=(-10, -10), step=(20, 20), heights=[[-5, -5], [5, 5]])
    found = measure_flight(over_a_hill, ramp)
    assert (found.lowest, found.highest) == pytest.approx((3 - 8 / 2, 4 - 4 / 2))


def test_a_flight_that_stands_still_has_no_slope():
    found = measure_flight(sky.Trajectory(np.array([0.0, 1.0]), np.array([[(1.0, 2, 3), (0, 0, 0)]])))
    assert (found.climb, found.steepest, found.lowest, found.highest) == (0, 0, 3, 3)
