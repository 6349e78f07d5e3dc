"""Trajectories, and where noses point: a sum of turns, each averaged over two windows."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.trajectory import Pointing, spread_turns

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


@st.composite
def pointings(draw):
    turns = draw(st.lists(st.tuples(st.floats(-5, 15), st.floats(-3, 3)), max_size=8).map(sorted))
    spread = draw(st.floats(0.05, 4.0))
    instants, sizes = np.array(turns).reshape(-1, 2).T
    return Pointing(draw(st.floats(-3, 3)), instants, sizes, spread, spread * draw(st.sampled_from([0.1, 0.7, 1.0])))


def averaged(pointing, t):
    """The yaw at instants: each turn is the area below a trapezoid up to there."""
    half, flat = 0.5 * (pointing.spread + pointing.rise), 0.5 * (pointing.spread - pointing.rise)
    x = np.clip(t[:, None] - pointing.instants, -half, half)
    ends = [np.clip(x + at, 0.0, None) for at in (half, flat, -flat, -half)]
    area = (ends[0] ** 2 - ends[1] ** 2 - ends[2] ** 2 + ends[3] ** 2) / (2 * pointing.spread * pointing.rise)
    return pointing.yaw + area @ pointing.turns


@settings(max_examples=50)
@given(pointings(), st.floats(-10, 20))
def test_the_yaw_is_the_sum_of_averaged_turns(pointing, cut):
    t, nowhere = np.linspace(-10.0, 20.0, 1001), np.zeros((1001, 3))
    yaw, rate, _ = pointing.at(t, nowhere)
    np.testing.assert_allclose(yaw, averaged(pointing, t), rtol=0, atol=1e-8)
    smooth = np.abs(t[:, None] - pointing.corners[0]).min(axis=1, initial=1.0) > 1e-4
    slope = (averaged(pointing, t + 1e-5) - averaged(pointing, t - 1e-5)) / 2e-5
    np.testing.assert_allclose(rate[smooth], slope[smooth], rtol=1e-5, atol=1e-5)
    past, later = pointing.parted(cut)
    assert np.array_equal(np.r_[past.turns, later.turns], pointing.turns)
    ahead = t >= cut
    np.testing.assert_allclose(later.at(t, nowhere).yaw[ahead], yaw[ahead], rtol=0, atol=1e-9)
    assert len(later.turns) == np.count_nonzero(pointing.instants + 0.5 * (pointing.spread + pointing.rise) > cut)


def test_an_hour_of_turns_takes_no_memory_to_speak_of():
    ticks = np.arange(0.0, 3600.0, 1 / 32)
    nose = Pointing(0.0, ticks, np.where(ticks % 2 < 1, 0.01, -0.01), 1 / 32, 1 / 32)
    t = np.linspace(0.0, 3600.0, 100_000)
    yaw, rate, _ = nose.at(t, np.zeros((len(t), 3)))
    assert np.abs(yaw).max() < 0.5
    assert np.abs(rate).max() < 0.33


TURNS = st.lists(st.tuples(st.floats(0.01, 2.0), st.floats(-3.0, 3.0)), min_size=1, max_size=12)


@settings(max_examples=50)
@given(TURNS)
@example([(0.5, 1.0), (1.9, -3.0), (1.9, 1.0)])
def test_no_window_of_time_holds_more_of_the_turns_than_the_rate_allows(drawn):
    pauses, turns = np.array(drawn).T
    instants = np.cumsum(pauses)
    spread, _ = spread_turns(instants, turns, 1.0, 2.0, 0.2)
    slid = np.linspace(instants[0] - spread, instants[-1], 20_001)
    held = (instants >= slid[:, None]) & (instants <= slid[:, None] + spread)
    assert np.abs(held @ turns).max() <= spread * (1.0 + 1e-9)
