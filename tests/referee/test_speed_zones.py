"""The referee finds flights that are too fast in a zone, on both sides of the tolerance."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.referee.curve import curve_of
from skyverse.referee.speed_zones import judge_zone_speed
from speed_zones import BOX, ZONES, too_fast, world_of


def judged(trajectory, *zones, error=None):
    uav = sky.UAV(start=(0, 0, 0), tracking_error=error or {})
    return next(iter(judge_zone_speed(world_of(*zones, uavs=(uav,)), 0, curve_of(trajectory)).violations), None)


def steady(speed, y=0.0, z=10.0):
    """From x = -50 m to 50 m at constant speed."""
    rows = np.array([[(-50.0, y, z), (speed, 0, 0)]])
    return sky.Trajectory(np.array([0.0, 100.0 / speed]), rows)


@pytest.mark.parametrize(("share", "wrong"), [(1.0, False), (1 + 5e-7, False), (1 + 3e-6, True), (2.0, True)])
@pytest.mark.parametrize("zone", ZONES, ids=lambda zone: zone.shape)
def test_the_limit_of_a_zone_may_be_reached_but_not_exceeded(zone, share, wrong):
    found = judged(steady(share * zone.max_speed), zone)
    assert (found is not None and found.fault is sky.Fault.ZONE_SPEED) == wrong


@pytest.mark.parametrize(("y", "wrong"), [(9.0, False), (9.1, False), (9 - 3e-6, True)])
def test_a_flight_along_the_face_of_a_zone_may_be_fast(y, wrong):
    found = judged(steady(10.0, y), BOX)
    assert (found is not None) == wrong
    if wrong:
        assert "flies 10 m/s in zone 0 ('school') (of 2) at t = " in found.message


@pytest.mark.parametrize(("z", "wrong"), [(42.1, False), (41.9, True)])
def test_the_tracking_error_takes_a_uav_into_a_zone(z, wrong):
    found = judged(steady(10.0, 0.0, z), BOX, error=sky.TrackingError(horizontal=1, vertical=2))
    assert (found is not None) == wrong


@settings(max_examples=60)
@given(
    st.sampled_from(ZONES),
    st.lists(st.tuples(*[st.floats(-30, 30)] * 2, st.floats(0, 40)), min_size=4, max_size=6),
    st.floats(2, 60),
)
def test_what_samples_find_too_fast_the_referee_refutes_and_nothing_else(zone, points, seconds):
    """Random polynomials against samples."""
    share = np.linspace(0, 1, len(points))
    rows = np.linalg.solve(np.vander(share, increasing=True), np.array(points))
    rows /= seconds ** np.arange(len(points))[:, None]
    flown = sky.Trajectory(np.array([0.0, seconds]), rows[None])
    excess, found = too_fast([zone], flown, seconds / 4000, depth=1e-5), judged(flown, zone)  # along a face is outside
    if excess > 1e-5:
        assert found.fault is sky.Fault.ZONE_SPEED
    if found is not None and found.fault is sky.Fault.ZONE_SPEED:
        motion = flown.at(found.time)
        assert np.linalg.norm(motion.velocity) > zone.max_speed
        np.testing.assert_allclose(found.position, motion.position[0], atol=1e-6)
    assert found is None or found.fault is sky.Fault.ZONE_SPEED


def test_a_mission_planned_without_the_zone_is_refuted_with_it():
    uav, target = sky.UAV(start=(-70, 0, 12)), sky.Target(position=(70, 0, 12))
    free = world_of(uavs=(uav,), targets=(target,))
    mission = sky.plan_mission(free, sky.Taut())
    slow = free.model_copy(update={"zones": (BOX,)})
    faults = {found.fault for found in sky.check(slow, replace(mission, scenario=slow))}
    assert sky.Fault.ZONE_SPEED in faults
    kept = sky.plan_mission(slow, sky.Taut())
    assert not sky.check(slow, kept)
    assert "the speed limits of zones" in kept.certificates[0].sentence
