"""Flights from rest to rest against closed forms, dense sampling and finite differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.trajectory import rest_to_rest

COORDINATE = st.one_of(st.floats(-50, 50), st.integers(-5, 5).map(float))
WAYPOINTS = st.lists(st.tuples(COORDINATE, COORDINATE, COORDINATE), min_size=2, max_size=6).map(np.array)
UAVS = st.builds(sky.UAV, start=st.just((0, 0, 0)), max_speed=st.floats(0.1, 30), max_acceleration=st.floats(0.1, 30))


@given(WAYPOINTS, UAVS, st.floats(0, 100))
def test_speed_and_acceleration_stay_within_the_limits_at_every_instant(waypoints, uav, start):
    trajectory = rest_to_rest(waypoints, uav, start)
    motion = trajectory.at(dense(trajectory))
    assert np.linalg.norm(motion.velocity, axis=1).max() <= uav.max_speed * (1 + 1e-8)
    assert np.linalg.norm(motion.acceleration, axis=1).max() <= uav.max_acceleration * (1 + 1e-8)


def dense(trajectory, count=400):
    return np.concatenate(
        [np.linspace(a, b, count) for a, b in zip(trajectory.knots[:-1], trajectory.knots[1:], strict=True)]
    )


@pytest.mark.parametrize("length", [1e-3, 0.01, 0.5, 4.0, 8.0, 300.0])
@pytest.mark.parametrize("jerk", [0.5, 50.0, 1e6])
def test_no_segment_takes_longer_than_the_profile_of_seven_segments(length, jerk):
    uav = sky.UAV(start=(0, 0, 0), max_speed=5, max_acceleration=3.5, max_jerk=jerk)
    trajectory = rest_to_rest(np.array([(0, 0, 0), (0, length, 0)]), uav)
    assert trajectory.end == pytest.approx(least_seconds(length, 5, 3.5, jerk), rel=1e-5, abs=4e-6)
    assert len(trajectory.coefficients) <= 7


def least_seconds(length, speed, acceleration, jerk):
    """The least time from rest to rest with speed, acceleration and jerk limited, case by case."""
    if length >= speed * (speed / acceleration + acceleration / jerk) and speed >= acceleration**2 / jerk:
        return length / speed + speed / acceleration + acceleration / jerk
    if speed < acceleration**2 / jerk and length >= 2 * speed * np.sqrt(speed / jerk):
        return length / speed + 2 * np.sqrt(speed / jerk)
    if length >= 2 * acceleration**3 / jerk**2:
        rise = acceleration / jerk
        return rise + np.sqrt(rise**2 + 4 * length / acceleration)
    return 4 * np.cbrt(length / (2 * jerk))


def test_a_climb_brakes_harder_than_it_accelerates_where_thrust_is_scarce():
    uav = sky.UAV(start=(0, 0, 0), max_speed=8, max_acceleration=5, max_jerk=100, thrust_to_weight=1.2)
    flown = rest_to_rest(np.array([(0, 0, 0), (0, 0, 100)]), uav)
    rates = flown.at(dense(flown, 2000)).acceleration[:, 2]
    assert rates.max() == pytest.approx(0.2 * 9.81, rel=1e-6)
    assert rates.min() == pytest.approx(-5, rel=1e-6)


@given(WAYPOINTS, UAVS)
def test_the_uav_stands_still_at_every_waypoint_and_nothing_jumps(waypoints, uav):
    trajectory = rest_to_rest(waypoints, uav)
    lengths = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
    at_knots = trajectory.at(trajectory.knots)
    if lengths.min() > 1e-3:
        stops = at_knots.position[np.linalg.norm(at_knots.velocity, axis=1) < 1e-9]
        np.testing.assert_allclose(stops, waypoints, atol=1e-9)
    np.testing.assert_allclose(at_knots.position[[0, -1]], waypoints[[0, -1]], atol=1e-8)
    np.testing.assert_allclose(at_knots.velocity[[0, -1]], 0, atol=1e-6)
    np.testing.assert_allclose(at_knots.acceleration[[0, -1]], 0, atol=1e-5 * uav.max_acceleration)
    inner = trajectory.knots[1:-1]
    before, after = trajectory.at(np.nextafter(inner, -np.inf)), trajectory.at(inner)
    for kind in range(3):
        np.testing.assert_allclose(before[kind], after[kind], atol=1e-9 * (1 + kind**9))


@given(WAYPOINTS, UAVS)
def test_the_way_between_two_waypoints_is_straight_and_never_back(waypoints, uav):
    trajectory = rest_to_rest(waypoints[:2], uav)
    begin, chord = waypoints[0], waypoints[1] - waypoints[0]
    length = np.linalg.norm(chord)
    if length < 1e-6:
        return
    moved = trajectory.at(dense(trajectory)).position - begin
    along = moved @ chord / length
    assert np.linalg.norm(moved - along[:, None] * chord / length, axis=1).max() < 1e-9 * (1 + length)
    assert np.diff(along).min() > -1e-9
    assert along.min() > -1e-9
    assert along.max() < length + 1e-9


@pytest.mark.parametrize("tiny", [5e-324, 1e-300, 1e-100, 1e-17, 1e-13])
def test_a_step_too_small_to_matter_breaks_nothing(tiny):
    waypoints = np.array([(0, 0, 0), (tiny, 0, 0), (3, 0, 0), (3, tiny, 0), (3, 1, 0)])
    for points in (waypoints, waypoints[:2], waypoints[2:4]):
        trajectory = rest_to_rest(points, sky.UAV(start=(0, 0, 0)), start=50)
        assert (np.diff(trajectory.knots) > 0).all()
        assert np.isfinite(trajectory.coefficients).all()
        np.testing.assert_allclose(trajectory.at([0, 1e9]).position, points[[0, -1]], atol=1e-9)
