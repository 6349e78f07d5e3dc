"""Zones with a speed limit: no faster inside, as fast as allowed elsewhere, slowed before and sped up after."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.space.speed_zones import first_too_fast
from skyverse.trajectory import blended, prove, rest_to_rest
from speed_zones import BOX, SPHERE, ZONES, holds, too_fast, world_of

PLACE = st.tuples(st.floats(-60, 60), st.floats(-60, 60), st.floats(1, 60))
PATHS = st.lists(PLACE, min_size=2, max_size=5).map(np.array)
UAVS = st.builds(
    sky.UAV,
    start=st.just((0, 0, 0)),
    max_speed=st.floats(1, 20),
    max_acceleration=st.floats(1, 9),
    max_jerk=st.floats(1, 1e3),
    max_climb=st.none() | st.floats(0.5, 6),
)


@settings(max_examples=60)
@given(st.lists(st.sampled_from(ZONES), min_size=1, max_size=3), PATHS, UAVS)
def test_no_flight_is_faster_than_the_limit_of_a_zone_inside_it(zones, path, uav):
    if np.linalg.norm(np.diff(path, axis=0), axis=1).min() < 1e-3:
        return
    world = sky.World(world_of(*zones))
    for flown in (blended(world, path, uav, 2.0), rest_to_rest(path, uav, zones=world.speed_zones)):
        assert too_fast(zones, flown) <= 1e-6
        assert prove(world, uav, flown).verdict is sky.Verdict.PROVEN
        before, after = flown.at(np.nextafter(flown.knots[1:-1], 0)), flown.at(flown.knots[1:-1])
        for kind, most in enumerate((1e-8, 1e-6, 1e-4)):
            np.testing.assert_allclose(before[kind], after[kind], atol=most)


@settings(max_examples=30)
@given(st.sampled_from(ZONES), PATHS, UAVS)
def test_the_proof_finds_what_is_too_fast_in_a_zone(zone, path, uav):
    if np.linalg.norm(np.diff(path, axis=0), axis=1).min() < 1e-3:
        return
    slow, free = sky.World(world_of(zone)), sky.World(world_of())
    flown = blended(free, path, uav, 2.0)
    excess = too_fast([zone], flown)
    found = first_too_fast(slow.speed_zones, flown)
    assert found is not None or excess <= 1e-6
    if found is not None:
        motion = flown.at(found)
        assert np.linalg.norm(motion.velocity) > zone.max_speed
        assert holds(zone, motion.position).all() or excess == -np.inf or excess > -0.1


def test_the_speed_is_lowered_before_a_zone_and_raised_after_it():
    """A long straight flight through a box takes what its ramps and constant speeds take."""
    uav = sky.UAV(start=(0, 0, 0), max_speed=10, max_acceleration=4, max_jerk=1e6, max_tilt=60)
    world = sky.World(world_of(BOX))
    flown = blended(world, np.array([(-90.0, 0, 10), (90, 0, 10)]), uav, 2.0)
    fast, slow, a = 10.0, 2.0, 4.0
    ramp, inside = (fast - slow) / a, BOX.max[0] - BOX.min[0]
    rising, change = fast**2 / a / 2, (fast**2 - slow**2) / a / 2
    expected = 2 * fast / a + 2 * ramp + inside / slow + (180 - inside - 2 * rising - 2 * change) / fast
    assert flown.end == pytest.approx(expected, abs=0.02)
    motion = flown.at(np.linspace(0, flown.end, 5000))
    np.testing.assert_allclose(np.linalg.norm(motion.velocity, axis=1)[holds(BOX, motion.position)], slow, atol=1e-5)


@pytest.mark.parametrize("shape", ["minimum-time", "minimum-snap", "stop-and-go"])
@pytest.mark.parametrize("error", [{}, {"horizontal": 3, "vertical": 2}])
def test_missions_keep_the_limits_of_zones_also_where_a_uav_may_stray(shape, error):
    uav = sky.UAV(start=(-70, -20, 12), max_speed=12, tracking_error=error)
    wall = sky.Box(min=(20, -60, 0), max=(25, 15, 80))
    scenario = world_of(BOX, SPHERE, obstacles=(wall,), uavs=(uav,), targets=(sky.Target(position=(70, 0, 12)),))
    mission = sky.plan_mission(scenario, sky.Taut(), options=sky.MissionOptions(shape=shape))
    assert mission.complete
    assert not mission.violations
    motion = mission.trajectories[0].at(np.linspace(0, mission.makespan, 4000))
    speed, aside = np.linalg.norm(motion.velocity, axis=1), error.get("horizontal", 0)
    for turn in np.linspace(0, 2 * np.pi, 16):
        for up in (-error.get("vertical", 0), error.get("vertical", 0)):
            strayed = motion.position + np.array([aside * np.cos(turn), aside * np.sin(turn), up])
            for zone in scenario.zones:
                assert speed[holds(zone, strayed)].max(initial=0) <= zone.max_speed + 1e-6


@settings(max_examples=40, deadline=None)
@given(st.lists(st.sampled_from(ZONES), min_size=1, max_size=3), PATHS, UAVS, st.floats(0, 30))
def test_beside_zones_the_least_time_is_never_more_than_that_with_stops(zones, path, uav, gap):
    start, end = path[0] - (gap, 0, 0), path[-1] + (gap, 0, 0)
    if np.linalg.norm(end - start) < 1:
        return
    wall = sky.Box(min=(20, -70, 0), max=(25, 15, 70))
    if any(wall.min[0] - 2 < x < wall.max[0] + 2 for x in (start[0], end[0])):
        return
    uav = uav.model_copy(update={"start": tuple(start)})
    target = sky.Target(position=tuple(end))
    problem = sky.Problem(world_of(*zones, obstacles=(wall,), uavs=(uav,), targets=(target,)))
    result = sky.Taut().plan(problem)
    least, stopping = sky.fly_along(problem, result), sky.fly_along(problem, result, "stop-and-go")
    assert least.end <= stopping.end


def test_an_aeroplane_that_cannot_fly_so_slowly_has_no_trajectory_through_a_zone():
    wing = sky.FixedWing(speed=10, turn_radius=30, climb=10)
    uav = sky.UAV(start=(-90, 0, 10), max_speed=12, fixed_wing=wing)
    scenario = world_of(BOX, uavs=(uav,), targets=(sky.Target(position=(90, 0, 10)),))
    mission = sky.plan_mission(scenario, sky.Taut())
    assert mission.trajectories == (None,)
    (violation,) = mission.violations
    assert "at its 10 m/s it cannot keep the speed limit of zone 0" in violation.message
