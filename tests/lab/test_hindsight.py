"""Lower bounds in hindsight: no flight is faster, and the straight one is hardly slower."""

import numpy as np
import pytest

import skyverse as sky
from replanned import hall
from skyverse.lab import Case, least_lengths, least_seconds
from skyverse.trajectory import rest_to_rest


@pytest.mark.parametrize("length", [0.001, 0.05, 1.0, 7.3, 400.0])
@pytest.mark.parametrize(("speed", "acceleration", "jerk"), [(5.0, 3.5, 50.0), (1.0, 3.0, 4.0), (20.0, 2.0, 1.0)])
def test_the_fastest_straight_flight_takes_no_less_and_not_much_more(length, speed, acceleration, jerk):
    uav = sky.UAV(start=(0, 0, 0), max_speed=speed, max_acceleration=acceleration, max_jerk=jerk, max_tilt=60)
    straight = rest_to_rest(np.array([[0.0, 0, 0], [length, 0, 0]]), uav)
    bound = least_seconds(length, uav)
    assert bound <= straight.end <= 1.3 * bound


def test_the_bound_is_where_the_fastest_speeds_cover_the_length():
    uav = sky.UAV(start=(0, 0, 0), max_speed=3.0, max_acceleration=2.0, max_jerk=5.0)
    bound = least_seconds(9.0, uav)
    t = np.linspace(0.0, bound, 200_001)
    acceleration = np.minimum(2.0, 5.0 * t)
    reached = np.concatenate([[0.0], np.cumsum(0.5 * (acceleration[1:] + acceleration[:-1]) * np.diff(t))])
    speed = np.minimum(np.minimum(reached, reached[::-1]), 3.0)
    assert np.trapezoid(speed, t) == pytest.approx(9.0, abs=1e-6)


def test_lengths_are_those_of_shortest_paths_and_nothing_for_a_uav_without_a_target():
    assert least_lengths(Case("", hall()), (0,)) == pytest.approx([18.0])
    assert least_lengths(Case("", hall()), (None,)) == [0.0]
    wall = sky.Box(min=(9, 2, 0), max=(10, 8, 4))
    (bound,) = least_lengths(Case("", hall(wall)), (0,))
    flown = sky.Taut().plan(sky.Problem(hall(wall))).path
    length = np.linalg.norm(np.diff(flown, axis=0), axis=1).sum()
    assert 18.0 < bound <= length


def test_no_length_takes_no_time():
    assert least_seconds(0.0, sky.UAV(start=(0, 0, 0))) == 0.0
