"""Smooth trajectories: within limits, C3, near known optima; and the equations, by differences."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from handmade import hall
from skyverse.trajectory import smooth
from skyverse.trajectory.interior_point import objective
from skyverse.trajectory.newton_equations import FIXED, SplineProblem, assemble
from skyverse.trajectory.newton_step import BAND, NewtonSystem
from skyverse.trajectory.smooth import binding_limits, control_point_bounds, energy_weight, first_guess


def world_of(*obstacles):
    return sky.World(hall((40, 40, 20), obstacles=obstacles))


def quickest(length, uav):
    """The least time from rest to rest in a straight line, with speed and acceleration limited."""
    v, a = uav.max_speed, uav.max_acceleration
    return 2 * math.sqrt(length / a) if length < v * v / a else length / v + v / a


def assert_within_limits(uav, trajectory):
    t = np.linspace(0, trajectory.end, 20_001)
    motion = trajectory.at(t)
    jerk = np.diff(motion.acceleration, axis=0) / np.diff(t)[:, None]
    assert np.linalg.norm(motion.velocity, axis=1).max() <= uav.max_speed * (1 + 1e-9)
    assert np.linalg.norm(motion.acceleration, axis=1).max() <= uav.max_acceleration * (1 + 1e-9)
    assert np.linalg.norm(jerk, axis=1).max() <= uav.max_jerk * (1 + 1e-6)
    thrust = motion.acceleration + np.array([0, 0, 9.81])
    assert np.linalg.norm(thrust, axis=1).max() <= uav.thrust_to_weight * 9.81 * (1 + 1e-9)
    tilt = np.degrees(np.arctan2(np.hypot(thrust[:, 0], thrust[:, 1]), thrust[:, 2]))
    assert tilt.max() <= uav.max_tilt + 1e-6


@pytest.mark.parametrize("order", [3, 4])
@pytest.mark.parametrize("length", [2.0, 12.0, 35.0])
def test_a_straight_flight_takes_hardly_longer_than_the_quickest_there_is(order, length):
    uav = sky.UAV(start=(1, 20, 10))
    trajectory = smooth(world_of(), np.array([(1, 20, 10), (1 + length, 20, 10)]), uav, order)
    assert_within_limits(uav, trajectory)
    # with max_jerk, acceleration takes a / j = 0.07 s to set in, three times
    assert quickest(length, uav) < trajectory.end < 1.04 * quickest(length, uav) + 0.25


@pytest.mark.parametrize(
    "limits",
    [
        {"max_acceleration": 9.0, "max_tilt": 15.0},
        {"max_acceleration": 6.0, "thrust_to_weight": 1.05},
        {"max_acceleration": 30.0, "max_speed": 20.0, "max_jerk": 500.0, "max_tilt": 60.0, "thrust_to_weight": 2.0},
    ],
)
def test_tilt_and_thrust_limit_what_acceleration_would_allow(limits):
    uav = sky.UAV(start=(1, 1, 1), **limits)
    trajectory = smooth(world_of(), np.array([(1, 1, 1), (30, 20, 1), (30, 20, 18.0)]), uav, 4)
    assert_within_limits(uav, trajectory)
    free = sky.UAV(**{**uav.model_dump(), "max_tilt": 89.0, "thrust_to_weight": 50.0})
    assert trajectory.end > smooth(world_of(), np.array([(1, 1, 1), (30, 20, 1), (30, 20, 18.0)]), free, 4).end


def test_all_derivatives_up_to_jerk_are_continuous_and_zero_at_the_ends():
    uav = sky.UAV(start=(1, 1, 1))
    wall = sky.Box(min=(15, 0, 0), max=(16, 30, 20))
    trajectory = smooth(
        world_of(wall), np.array([(1, 1, 1), (14.999, 30.001, 5), (16.001, 30.001, 5), (30, 1, 1.0)]), uav, 4
    )
    rows = trajectory.coefficients
    h = np.diff(trajectory.knots)
    for order in range(4):
        factors = np.array([math.perm(j, order) for j in range(rows.shape[1])])
        powers = h[:, None] ** np.maximum(np.arange(rows.shape[1]) - order, 0)
        at_end = np.einsum("kjx,j,kj->kx", rows, factors, powers * (factors > 0))
        at_begin = rows[:, order] * math.factorial(order)
        assert np.abs(at_end[:-1] - at_begin[1:]).max() < 1e-7
        if order:
            assert np.abs(at_begin[0]).max() < 1e-7
            assert np.abs(at_end[-1]).max() < 1e-7


def test_each_shape_is_the_better_one_by_its_own_measure():
    uav = sky.UAV(start=(1, 1, 1))
    path = np.array([(1, 1, 1), (14.999, 30.001, 5), (16.001, 30.001, 5), (30, 1, 1.0)])
    world = world_of(sky.Box(min=(15, 0, 0), max=(16, 30, 20)))
    prices = []
    for order in (3, 4):
        trajectory = smooth(world, path, uav, order)
        h, rows = np.diff(trajectory.knots), trajectory.coefficients
        begin, end = 6 * rows[:, 3], 6 * rows[:, 3] + 24 * rows[:, 4] * h[:, None]
        jerk = float(np.sum(h[:, None] / 3 * (begin**2 + begin * end + end**2)))
        snap = float(np.sum(h[:, None] * (24 * rows[:, 4]) ** 2))
        prices.append([trajectory.end + energy_weight(binding_limits(uav), k) * e for k, e in ((3, jerk), (4, snap))])
    assert prices[0][0] < prices[1][0]
    assert prices[1][1] < prices[0][1]


def test_a_uav_at_its_target_has_nowhere_to_fly():
    uav = sky.UAV(start=(1, 20, 10))
    assert smooth(world_of(), np.array([(1, 20, 10), (1, 20, 10.0)]), uav, 4) is None


@given(st.integers(0, 2**32), st.sampled_from([3, 4]), st.booleans())
def test_the_equations_hold_the_gradient_and_the_hessian_of_objective_and_barriers(seed, order, tilting):
    rng = np.random.default_rng(seed)
    boxes = np.array([[0, 0, 0, 10, 10, 10], [8, 3, 2, 20, 8, 9], [15, 5, -5, 25, 30, 8.0]])
    box_of = np.repeat([0, 1, 2], 6)
    low, high = control_point_bounds(boxes, box_of)
    points, spans = first_guess(np.array([(1, 1, 1), (12, 5, 5), (20, 20, 2.0)]), low, high, box_of)
    uav = sky.UAV(
        start=(0, 0, 0), **({"max_acceleration": 9.0, "max_tilt": 20, "thrust_to_weight": 1.5} if tilting else {})
    )
    problem = SplineProblem(low, high, box_of, binding_limits(uav), 1e-3, order)
    points[FIXED:-FIXED] += rng.uniform(-0.01, 0.01, points[FIXED:-FIXED].shape)
    spans *= rng.uniform(0.8, 1.2, 3)[box_of]
    while not np.isfinite(objective(problem, spans, points, 1.0)):
        spans *= 1.3
    spans *= 1.2
    mu, boxes_n, free = 0.37, 3, 3 * (len(points) - 2 * FIXED)
    system = NewtonSystem(
        np.empty((free, BAND)),
        np.empty(free),
        np.empty((boxes_n, free)),
        np.empty((boxes_n, boxes_n)),
        np.empty(boxes_n),
    )
    assemble(problem, spans, points, mu, system, np.empty((2, 5, 5, 6)), np.empty((6, 6)), np.empty((6, 6)))
    by_points, by_times = rng.normal(size=free), rng.normal(size=3)

    def along(s):
        moved = points.copy()
        moved[FIXED:-FIXED] += s * by_points.reshape(-1, 3)
        return objective(problem, spans * np.exp(s * by_times[box_of]), moved, mu)

    h = 1e-5
    slope = (along(h) - along(-h)) / (2 * h)
    assert np.isclose(slope, system.by_points @ by_points + system.by_durations @ by_times, rtol=1e-4, atol=1e-4)
    h = 1e-4
    bend = (along(h) - 2 * along(0.0) + along(-h)) / h**2
    whole = np.zeros((free, free))
    for i in range(free):
        for j in range(min(BAND, free - i)):
            whole[i, i + j] = whole[i + j, i] = system.band[i, j]
    expected = (
        by_points @ whole @ by_points + 2 * by_times @ system.cross @ by_points + by_times @ system.small @ by_times
    )
    assert np.isclose(bend, expected, rtol=1e-3, atol=1e-2)
