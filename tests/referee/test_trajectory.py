"""Trajectories are judged on both sides of each tolerance, at every instant, and violations say what is wrong."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
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


@pytest.mark.parametrize(("share", "faults"), [(1, []), (1 - 5e-7, []), (1 - 3e-6, [sky.Fault.SPEED])])
def test_the_top_speed_is_a_limit_that_may_be_reached(share, faults):
    length = np.linalg.norm(np.subtract(BEND, ALPHA))
    other = np.linalg.norm(np.subtract(ALPHA_ENDS, BEND))
    mission = given_uav(0, max_speed=1.875 * max(length, other) / 3 * share)
    assert [found.fault for found in sky.check(mission.scenario, mission)] == faults


@pytest.mark.parametrize(("miss", "faults"), [(8e-7, []), (1.2e-6, [sky.Fault.TRAJECTORY_ENDS])])
@pytest.mark.parametrize("end", [0, 2])
def test_a_trajectory_starts_and_ends_where_it_should(end, miss, faults):
    waypoints = np.array([ALPHA, BEND, ALPHA_ENDS])
    waypoints[end, 1] += miss
    found = sky.check(SCENARIO, flying(stops(waypoints)))
    assert [one.fault for one in found] == faults
    assert all(one.time == 3.0 * end for one in found)


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
    return flying(sky.Trajectory(np.array([0.0, 2, 3, 5]), np.array([arriving, parabola, going])), mission=agile)


def test_a_curve_round_a_corner_is_not_blamed_for_its_chords():
    # Half a micrometre from the corner (4.7525, 3.25) of a box on its left: chords of 5 ms would cut it.
    corner = sky.Box(min=(4.2, 2.8, 1), max=(4.5025, 3.0, 2))
    mission = curving(3.25 + 5e-7, -2, -3, 0.7525)
    scenario = mission.scenario.model_copy(update={"obstacles": (corner,)})
    assert sky.check(scenario, replace(mission, scenario=scenario)) == []
    corner = sky.Box(min=(4.2, 2.8, 1), max=(4.5025, 3.0 + 5e-6, 2))
    scenario = mission.scenario.model_copy(update={"obstacles": (corner,)})
    (found,) = sky.check(scenario, replace(mission, scenario=scenario))
    assert found.fault is sky.Fault.TRAJECTORY_CLEARANCE


@pytest.mark.parametrize(("short", "faults"), [(-1e-7, []), (5e-6, [sky.Fault.SEPARATION])])
def test_two_uavs_do_not_come_too_close_between_two_ticks(short, faults):
    mission = curving(3.5 - short, 0, 3, 0.505)
    block_gone = mission.scenario.model_copy(
        update={
            "obstacles": (),
            "uavs": put(mission.scenario.uavs, 2, sky.UAV(name="charlie", start=(4.505, 3.0, 1.5))),
        }
    )
    assert [found.fault for found in sky.check(block_gone, replace(mission, scenario=block_gone))] == faults


def test_a_clearance_is_told_with_its_numbers():
    (found,) = sky.check(SCENARIO, flying(stops([ALPHA, (4.5, 3.1, 1.5), ALPHA_ENDS])))
    assert found.message == (
        "alpha comes within 0.1 m of obstacle 0 at t = 3 s, position (4.5, 3.1, 1.5); 0.25 m are required."
    )
    assert found.time == pytest.approx(3)
    assert found.position == pytest.approx((4.5, 3.1, 1.5))


def test_the_worst_instant_is_reported():
    (found,) = sky.check(SCENARIO, flying(stops([ALPHA, (3, 4.1, 4.1), (6, 4.1, 4.2), ALPHA_ENDS], 3.5)))
    assert found.time == pytest.approx(7)
    assert "0.2 m" in found.message


# The second puts the closest approach just before t = 50 s, where two windows of instants meet.
@pytest.mark.parametrize("seconds", [2.0, 99.98])
def test_the_closest_approach_is_found_between_the_ticks(seconds):
    agile = {"max_speed": 20, "max_acceleration": 100, "max_jerk": 1000, "max_tilt": 80, "thrust_to_weight": 9}
    crossing = SCENARIO.model_copy(
        update={
            "obstacles": (),
            "uavs": (
                sky.UAV(name="alpha", start=(0, 3, 1), **agile),
                sky.UAV(name="bravo", start=(5, 0, 1.2), **agile),
            ),
            "targets": (sky.Target(position=(10, 3, 1)), sky.Target(position=(5, 6, 1.2))),
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
    (found,) = sky.check(crossing, sky.Mission(crossing, (0, 1), results, trajectories, (), MADE_BY))
    t = seconds / 2 + np.linspace(-0.1, 0.1, 200_001)
    a, b = (trajectory.at(t).position for trajectory in trajectories)
    nearness = np.linalg.norm((a - b) / [0.5, 0.5, 1], axis=1)
    closest = np.argmin(nearness)
    assert (found.fault, found.uavs) == (sky.Fault.SEPARATION, (0, 1))
    assert found.time == pytest.approx(t[closest], abs=3e-5 * seconds)
    assert f": {nearness[closest]:.6g} of the separation" in found.message
    assert f"within {np.linalg.norm((a - b)[closest]):.6g} m" in found.message
    assert found.position == pytest.approx(tuple((a + b)[closest] / 2), abs=1e-3)
    for more, faults in ((5e-7, []), (2e-6, [sky.Fault.SEPARATION])):
        # the ellipsoid that just reaches the other: half as wide as high
        wide = 0.5 * nearness[closest]
        just = {"separation": wide + more, "vertical_separation": 2 * wide + more}
        uavs = tuple(uav.model_copy(update=just) for uav in crossing.uavs)
        almost = crossing.model_copy(update={"uavs": uavs})
        found = sky.check(almost, sky.Mission(almost, (0, 1), results, trajectories, (), MADE_BY))
        assert [violation.fault for violation in found] == faults


@pytest.mark.parametrize(("first", "second", "seconds"), [(0.3, 0.2, 120), (0.2, 0.3, 40)])
def test_of_two_approaches_the_closer_is_told(first, second, seconds):
    near = given_uav(2, start=(5, 4, 1))
    there_and_back = [ALPHA, (5, 4, 1 + first), (8, 4, 2), (5, 4, 1 + second), ALPHA_ENDS]
    (found,) = sky.check(near.scenario, flying(stops(there_and_back, 40.0), mission=near))
    assert "within 0.2 m" in found.message
    assert found.time == pytest.approx(seconds, abs=0.1)
