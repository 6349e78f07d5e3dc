"""Trajectories are judged on both sides of each tolerance, at every instant, and violations say what is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from judged_missions import (
    ALPHA,
    ALPHA_ENDS,
    BEND,
    MADE_BY,
    SCENARIO,
    flying,
    given_uav,
    put,
    quintic,
    result,
    row,
    stops,
)
from skyverse.model.mission import Mission
from skyverse.model.scenario import Target
from skyverse.model.shapes import Box
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Fault
from skyverse.referee import check


def through(y):
    """Alpha along the block's grown face, y = 3.25 m."""
    return stops([ALPHA, (2.5, y, 1.5), (6.5, y, 1.5), ALPHA_ENDS])


@pytest.mark.parametrize(("inside", "faults"), [(0, []), (8e-7, []), (1.2e-6, [Fault.TRAJECTORY_CLEARANCE])])
def test_a_trajectory_may_touch_a_grown_box_but_not_enter_it(inside, faults):
    assert [found.fault for found in check(SCENARIO, flying(through(3.25 - inside)))] == faults


@pytest.mark.parametrize(("outside", "faults"), [(0, []), (8e-7, []), (1.2e-6, [Fault.TRAJECTORY_BOUNDS])])
def test_a_trajectory_may_touch_the_bounds_but_not_leave_them(outside, faults):
    mission = flying(stops([ALPHA, (4, 4.1, 4 + outside), ALPHA_ENDS], 3.5))
    assert [found.fault for found in check(SCENARIO, mission)] == faults


@pytest.mark.parametrize(("share", "faults"), [(1, []), (1 - 5e-7, []), (1 - 3e-6, [Fault.SPEED])])
def test_the_top_speed_is_a_limit_that_may_be_reached(share, faults):
    length = np.linalg.norm(np.subtract(BEND, ALPHA))
    other = np.linalg.norm(np.subtract(ALPHA_ENDS, BEND))
    mission = given_uav(0, max_speed=1.875 * max(length, other) / 3 * share)
    assert [found.fault for found in check(mission.scenario, mission)] == faults


@pytest.mark.parametrize(("miss", "faults"), [(8e-7, []), (1.2e-6, [Fault.TRAJECTORY_ENDS])])
@pytest.mark.parametrize("end", [0, 2])
def test_a_trajectory_starts_and_ends_where_it_should(end, miss, faults):
    waypoints = np.array([ALPHA, BEND, ALPHA_ENDS])
    waypoints[end, 1] += miss
    found = check(SCENARIO, flying(stops(waypoints)))
    assert [one.fault for one in found] == faults
    assert all(one.time == 3.0 * end for one in found)


@pytest.mark.parametrize(("apart", "faults"), [(0.5, []), (0.5 - 8e-7, []), (0.5 - 1.2e-6, [Fault.SEPARATION])])
def test_two_uavs_may_be_exactly_the_separation_apart(apart, faults):
    mission = given_uav(2, start=(9.3, 4.2 + apart, 2.4))
    assert [found.fault for found in check(mission.scenario, mission)] == faults


def curving(y, speed, bend, apex):
    """Alpha, agile, flies a second of x = 4 + t, y(t) = y + speed (t - apex) + bend / 2 (t - apex)^2."""
    agile = given_uav(0, max_speed=100, max_acceleration=1000, max_jerk=1000, max_tilt=89, thrust_to_weight=9)
    parabola = np.zeros((6, 3))
    parabola[:3, 0] = 4, 1, 0
    parabola[:3, 1] = y - speed * apex + bend / 2 * apex**2, speed - bend * apex, bend / 2
    parabola[0, 2] = 1.5
    enters, leaves = parabola[0], parabola.sum(axis=0)
    speed_in, speed_out = parabola[1], parabola[1] + 2 * parabola[2]
    arriving = quintic(ALPHA, enters, 2.0, speed_out=speed_in, bend_out=2 * parabola[2])
    going = quintic(leaves, ALPHA_ENDS, 2.0, speed_in=speed_out, bend_in=2 * parabola[2])
    return flying(Trajectory(np.array([0.0, 2, 3, 5]), np.array([arriving, parabola, going])), mission=agile)


@pytest.mark.parametrize(("depth", "faults"), [(-1e-7, []), (5e-6, [Fault.TRAJECTORY_CLEARANCE])])
def test_a_box_is_not_entered_between_two_instants(depth, faults):
    # At 3.25 - depth for 3 ms: chords of 5 ms from t = 2 s would pass over it.
    mission = curving(3.25 - depth, 0, 3, 0.5025)
    found = check(mission.scenario, mission)
    assert [violation.fault for violation in found] == faults
    assert all(violation.time == pytest.approx(2.5025, abs=0.002) for violation in found)


def test_a_curve_round_a_corner_is_not_blamed_for_its_chords():
    # Half a micrometre from the corner (4.7525, 3.25) of a box on its left: chords of 5 ms would cut it.
    corner = Box(min=(4.2, 2.8, 1), max=(4.5025, 3.0, 2))
    mission = curving(3.25 + 5e-7, -2, -3, 0.7525)
    scenario = mission.scenario.model_copy(update={"obstacles": (corner,)})
    assert check(scenario, replace(mission, scenario=scenario)) == []
    corner = Box(min=(4.2, 2.8, 1), max=(4.5025, 3.0 + 5e-6, 2))
    scenario = mission.scenario.model_copy(update={"obstacles": (corner,)})
    (found,) = check(scenario, replace(mission, scenario=scenario))
    assert found.fault is Fault.TRAJECTORY_CLEARANCE


@pytest.mark.parametrize(("short", "faults"), [(-1e-7, []), (5e-6, [Fault.SEPARATION])])
def test_two_uavs_do_not_come_too_close_between_two_ticks(short, faults):
    mission = curving(3.5 - short, 0, 3, 0.505)
    block_gone = mission.scenario.model_copy(
        update={
            "obstacles": (),
            "uavs": put(mission.scenario.uavs, 2, UAV(name="charlie", start=(4.505, 3.0, 1.5))),
        }
    )
    assert [found.fault for found in check(block_gone, replace(mission, scenario=block_gone))] == faults


def test_a_clearance_is_told_with_its_numbers():
    (found,) = check(SCENARIO, flying(stops([ALPHA, (4.5, 3.1, 1.5), ALPHA_ENDS])))
    assert found.message == (
        "alpha comes within 0.1 m of obstacle 0 at t = 3 s, position (4.5, 3.1, 1.5); 0.25 m are required."
    )
    assert found.time == pytest.approx(3)
    assert found.position == pytest.approx((4.5, 3.1, 1.5))


def test_the_worst_instant_is_reported():
    (found,) = check(SCENARIO, flying(stops([ALPHA, (3, 4.1, 4.1), (6, 4.1, 4.2), ALPHA_ENDS], 3.5)))
    assert found.time == pytest.approx(7)
    assert "0.2 m" in found.message


# The second puts the closest approach just before t = 50 s, where two windows of instants meet.
@pytest.mark.parametrize("seconds", [2.0, 99.98])
def test_the_closest_approach_is_found_between_the_ticks(seconds):
    agile = {"max_speed": 20, "max_acceleration": 100, "max_jerk": 1000, "max_tilt": 80, "thrust_to_weight": 9}
    crossing = SCENARIO.model_copy(
        update={
            "obstacles": (),
            "uavs": (UAV(name="alpha", start=(0, 3, 1), **agile), UAV(name="bravo", start=(5, 0, 1.2), **agile)),
            "targets": (Target(position=(10, 3, 1)), Target(position=(5, 6, 1.2))),
        }
    )
    trajectories = (
        stops([(0, 3, 1), (10, 3, 1)], seconds),
        stops([(5, 0, 1.2), (5, 6, 1.2)], seconds, start=0.0123),
    )
    results = (
        result(row((0, 3, 1), ("x", 10)), 11),
        result(row((5, 0, 1), ("y", 6)), 7),
    )
    (found,) = check(crossing, Mission(crossing, (0, 1), results, trajectories, (), MADE_BY))
    t = seconds / 2 + np.linspace(-0.1, 0.1, 200_001)
    a, b = (trajectory.at(t).position for trajectory in trajectories)
    nearness = np.linalg.norm((a - b) / [0.5, 0.5, 1], axis=1)
    closest = np.argmin(nearness)
    assert (found.fault, found.uavs) == (Fault.SEPARATION, (0, 1))
    assert found.time == pytest.approx(t[closest], abs=3e-5 * seconds)
    assert f": {nearness[closest]:.6g} of the separation" in found.message
    assert f"within {np.linalg.norm((a - b)[closest]):.6g} m" in found.message
    assert found.position == pytest.approx(tuple((a + b)[closest] / 2), abs=1e-3)
    for more, faults in ((5e-7, []), (2e-6, [Fault.SEPARATION])):
        # the ellipsoid that just reaches the other: half as wide as high
        wide = 0.5 * nearness[closest]
        just = {"separation": wide + more, "vertical_separation": 2 * wide + more}
        uavs = tuple(uav.model_copy(update=just) for uav in crossing.uavs)
        almost = crossing.model_copy(update={"uavs": uavs})
        found = check(almost, Mission(almost, (0, 1), results, trajectories, (), MADE_BY))
        assert [violation.fault for violation in found] == faults


@pytest.mark.parametrize(("first", "second", "seconds"), [(0.3, 0.2, 120), (0.2, 0.3, 40)])
def test_of_two_approaches_the_closer_is_told(first, second, seconds):
    near = given_uav(2, start=(5, 4, 1))
    there_and_back = [ALPHA, (5, 4, 1 + first), (8, 4, 2), (5, 4, 1 + second), ALPHA_ENDS]
    (found,) = check(near.scenario, flying(stops(there_and_back, 40.0), mission=near))
    assert "within 0.2 m" in found.message
    assert found.time == pytest.approx(seconds, abs=0.1)


def test_starts_that_are_too_close_are_told_so():
    mission = given_uav(2, start=(0.2, 4.1, 0.9))
    (found,) = check(mission.scenario, mission)
    assert found.uavs == (0, 2)
    assert found.time == 0
    assert "already at the start" in found.message
    assert "0.3 m" in found.message


def test_a_uav_waits_at_its_start_until_its_trajectory_begins():
    in_alphas_way = given_uav(1, start=(4.7, 4.15, 2.2))
    late = stops([(4.7, 4.15, 2.2), (5, 5, 3), (8.9, 5.1, 3)], start=20.0)
    found = check(in_alphas_way.scenario, flying(late, 1, in_alphas_way))
    assert [(violation.fault, violation.uavs) for violation in found] == [
        (Fault.PATH_ENDS, (1,)),
        (Fault.SEPARATION, (0, 1)),
    ]
    assert found[1].time == pytest.approx(3, abs=0.5)


def test_a_uav_holds_its_last_place_when_its_trajectory_ends():
    parked_at_alphas_end = given_uav(2, start=(9.3, 4.2, 2.8))
    assert [found.time for found in check(parked_at_alphas_end.scenario, parked_at_alphas_end)] == [6]
    # Alpha has long arrived when bravo comes by.
    by = flying(stops([(1.1, 5.2, 3.1), (9.3, 4.5, 2.5), (8.9, 5.1, 3)], 6.0, start=60.0), 1)
    (found,) = check(SCENARIO, by)
    assert (found.fault, found.uavs) == (Fault.SEPARATION, (0, 1))
    assert found.time == pytest.approx(66, abs=0.5)


def test_a_late_start_does_not_take_longer_to_judge():
    assert check(SCENARIO, flying(stops([ALPHA, BEND, ALPHA_ENDS], start=5e8))) == []
