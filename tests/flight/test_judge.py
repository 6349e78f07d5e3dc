"""Pairs judged as planned: what is not flown is where its trajectory says."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from handmade import mission, straight
from skyverse.flight import passings, strayed


def judged(made, margin=0.05):
    """Return the nearness of the first two, and whether they are apart: 0.5 m, in height 1 m, less twice the margin."""
    found, wrong = passings(made, (None,) * len(made.scenario.uavs), margin)
    assert all(v.fault is sky.Fault.SEPARATION and v.uavs == (0, 1) for v in wrong)
    return found[0].nearness, not wrong


def standing(*flights):
    """Return a mission in which only the first UAV flies."""
    made = mission(*flights)
    return replace(made, trajectories=(flights[0], None), assignment=(0, None))


AWAY = straight((0, 0, 2), (-0.5, 0, 2), 1.0), straight((0.2, 0, 2), (0.6, 0, 2), 1.0)
HOME = straight((-0.5, 0, 2), (0, 0, 2), 1.0), straight((0.6, 0, 2), (0.2, 0, 2), 1.0)


@pytest.mark.parametrize("flights", [AWAY, HOME])
@pytest.mark.parametrize("margin", [0.0, 0.125])
def test_starts_or_targets_given_too_close_are_excused_while_no_nearer_than_given(flights, margin):
    nearness, apart = judged(mission(*flights), margin)
    assert nearness == pytest.approx(0.4)
    assert apart


@pytest.mark.parametrize("margin", [0.0, 0.05, 0.125])
@pytest.mark.parametrize("given", ["starts", "targets"])
def test_a_collision_is_not_excused_by_starts_or_targets_given_too_close(given, margin):
    ends = ((0, 0, 2), (3, 0, 2)), ((0.2, 0, 2), (-3, 0, 2))
    swapped = [straight(*(pair if given == "starts" else pair[::-1]), 1.0) for pair in ends]
    nearness, apart = judged(mission(*swapped), margin)
    assert nearness < 0.05
    assert not apart


@pytest.mark.parametrize(("nearest", "apart"), [(0.38, True), (0.34, True), (0.3, False)])
def test_of_the_nearness_given_the_same_share_may_be_strayed_as_of_the_separation(nearest, apart):
    # 0.4 m are given; of 0.5 m, 2 * 0.05 m may be strayed, a fifth: 0.32 m must be left
    behind = straight((0, 0, 2), (3, 0, 2), 2.0)
    first = straight((0.4, 0, 2), (nearest, 0, 2), 0.001)
    assert judged(standing(first, behind))[1] == apart


def test_starts_given_at_one_place_are_excused():
    assert judged(mission(straight((0, 0, 2), (2, 0, 2), 1.0), straight((0, 0, 2), (-2, 0, 2), 1.0)), 0.0)[1]


def test_starts_given_too_close_excuse_nothing_once_they_were_apart():
    forth, back = straight((0, 0, 2), (3, 0, 2), 1.0), straight((3, 0, 2), (0, 0, 2), 1.0, begin=1.0)
    rows = np.concatenate([forth.coefficients, back.coefficients])
    there_and_back, other = sky.Trajectory(np.arange(3.0), rows), straight((-0.2, 0, 2), (-3, 0, 2), 1.0)
    assert judged(standing(forth, other))[1]
    assert not judged(standing(there_and_back, other))[1]


def test_who_stands_at_anothers_target_is_not_excused():
    nearness, apart = judged(standing(straight((2, 0, 2), (0, 0, 2), 1.0), straight((-0.02, 0, 2), (3, 0, 2), 1.0)))
    assert nearness == pytest.approx(0.04)
    assert not apart


def test_a_uav_that_is_lost_before_it_is_due_is_not_safe():
    mission = sky.plan_mission(sky.read("map1"), sky.Taut())
    trajectory = mission.trajectories[0]
    times = np.array([0.0, 0.01])
    place = trajectory.at(times).position
    flown = sky.Flown(0, times, place, place * 0, place, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.4, 0.0, 0.0)
    assert "is lost at 0.01 s: it is more" in strayed(mission.scenario, flown, 0.1, trajectory.end, "")[0].message
    hovering = sky.Flown(0, times - 2.0, place, place * 0, place, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.4, 0.0, 0.0)
    (lost,) = strayed(mission.scenario, hovering, 0.1, trajectory.end, "")
    assert "is lost 1.99 s before the mission begins, in the hover at the start: it is more" in lost.message


@pytest.mark.parametrize(
    ("low", "says"), [(10.0, "is 10.000 m above ground"), (-1.0, "touches the ground"), (26.0, None)]
)
def test_over_terrain_the_grounds_own_clearance_is_kept_less_the_margin(low, says):
    terrain = sky.Terrain(origin=(0, 0), step=(50, 50), heights=[[0, 40], [20, 60]], clearance=30)
    scenario = sky.Scenario(
        name="slope",
        bounds=sky.Bounds(min=(0, 0, 0), max=(50, 50, 200)),
        terrain=terrain,
        clearance=10,
        lattice=sky.Lattice(step=(5, 5, 5)),
        uavs=[sky.UAV(start=(5, 5, 100))],
    )
    times = np.arange(3) / 100
    place = np.array([(5, 5, 100), (20, 30, terrain.height((20, 30)) + low), (5, 5, 100)])
    flown = sky.Flown(0, times, place, place * 0, place, 0.0, 0.0, np.inf, 0.0, 0.0, 0.5, 0.4, 0.0, 0.0, low)
    wrong = strayed(scenario, flown, 5.0, 0.02, "")
    if says is None:
        assert wrong == []
    else:
        assert wrong[0].message == f"uav-1 {says} at 0.01 s; 25 m must be left"
        assert wrong[0].position == pytest.approx(place[1])
