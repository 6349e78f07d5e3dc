"""Straight legs with blends at the bends: along the path, within a tolerance, at the limits, proven."""

from importlib import import_module

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.summary import flight_summary, largest_distance
from skyverse.trajectory import blended, least_seconds, needed_waypoints, prove
from woods import woods

TOLERANCE = 2.0
PLACE = st.tuples(st.floats(-2000, 2000), st.floats(-2000, 2000), st.floats(0, 300))
PATHS = st.lists(PLACE, min_size=2, max_size=8).map(np.array)
UAVS = st.builds(
    sky.UAV,
    start=st.just((0, 0, 0)),
    max_speed=st.floats(1, 25),
    max_acceleration=st.floats(1, 12),
    max_jerk=st.floats(1, 1e4),
    max_tilt=st.floats(5, 60),
    thrust_to_weight=st.floats(1.1, 3),
    max_climb=st.none() | st.floats(0.5, 6),
)


def world_of(*obstacles, low=(-3000, -3000, -100), high=(3000, 3000, 500), clearance=0.001):
    return sky.World(
        sky.Scenario(
            name="open",
            bounds=sky.Bounds(min=low, max=high),
            obstacles=obstacles,
            clearance=clearance,
            lattice=sky.Lattice(step=(100, 100, 100)),
        )
    )


OPEN = world_of()


def turning(ways):
    """Degrees between successive directions, in all."""
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(np.diff(ways, axis=0), axis=1) / 2, 0, 1)).sum())


@settings(max_examples=40)
@given(PATHS, UAVS)
def test_in_the_open_a_flight_keeps_to_limits_and_tolerance_and_nothing_jumps(path, uav):
    if np.linalg.norm(np.diff(path, axis=0), axis=1).min() < 1e-3:
        return
    flown = blended(OPEN, path, uav, TOLERANCE)
    assert prove(OPEN, uav, flown).verdict is sky.Verdict.PROVEN
    assert largest_distance(flown, path) <= TOLERANCE * (1 + 1e-6)
    assert flown.end >= least_seconds(path, uav) * (1 - 0.02)  # less only by cutting corners
    ends = flown.at([flown.start, flown.end])
    np.testing.assert_allclose(ends.position, path[[0, -1]], atol=1e-9)
    np.testing.assert_allclose(ends.velocity, 0, atol=1e-7)
    np.testing.assert_allclose(ends.acceleration, 0, atol=1e-6)
    before, after = flown.at(np.nextafter(flown.knots[1:-1], 0)), flown.at(flown.knots[1:-1])
    for kind, most in enumerate((1e-8, 1e-6, 1e-4)):
        np.testing.assert_allclose(before[kind], after[kind], atol=most)


QUICK = st.builds(
    sky.UAV,
    start=st.just((0, 0, 0)),
    max_speed=st.floats(2, 15),
    max_acceleration=st.floats(3, 12),
    max_jerk=st.floats(5, 1e4),
    max_tilt=st.floats(20, 60),
)


@settings(max_examples=40)
@given(st.lists(st.floats(-12, 12), min_size=1, max_size=4), st.floats(-180, 180), QUICK)
def test_gentle_bends_in_the_open_cost_no_length_no_turning_and_hardly_any_time(bends, course, uav):
    courses = np.radians(course + np.cumsum([0.0, *bends]))
    steps = 400 * np.column_stack([np.cos(courses), np.sin(courses), 0.1 * np.sin(3 * courses)])
    path = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)]) + np.array([0, 0, 250])
    flown = blended(OPEN, path, uav, TOLERANCE)
    length = np.linalg.norm(steps, axis=1).sum()
    assert flight_summary(uav, path, flown).length <= 1.003 * length
    velocity = flown.at(np.linspace(0, flown.end, 4001)[1:-1]).velocity
    velocity = velocity[np.linalg.norm(velocity, axis=1) > 1e-3]
    assert turning(velocity) <= turning(steps) + 10
    assert flown.end <= 1.03 * least_seconds(path, uav)


def test_at_the_bend_of_a_shortest_path_a_flight_passes_on_the_outside():
    world = world_of(sky.Box(min=(-50, -50, -100), max=(0, 0, 500)))
    path = np.array([(-40.0, 1e-3, 10), (1e-3, 1e-3, 10), (1e-3, -40, 10)])
    uav = sky.UAV(start=(0, 0, 0))
    flown = blended(world, path, uav, TOLERANCE)
    assert prove(world, uav, flown).verdict is sky.Verdict.PROVEN
    speeds = np.linalg.norm(flown.at(np.linspace(1, flown.end - 1, 400)).velocity, axis=1)
    assert speeds.min() > 3
    assert 1 < largest_distance(flown, path) <= TOLERANCE


def test_two_bends_close_together_do_not_slow_a_flight_down():
    slab = sky.Prism(vertices=((0, 0), (-200, -8), (-200, -100), (200, -100), (200, -8), (1, 0)), low=-100, high=500)
    world = world_of(slab)
    path = np.array([(-200.0, -7.9, 10), (0, 0.01, 10), (1, 0.01, 10), (200, -7.9, 10)])
    uav = sky.UAV(start=(0, 0, 0), max_speed=15)
    flown = blended(world, path, uav, TOLERANCE)
    assert prove(world, uav, flown).verdict is sky.Verdict.PROVEN
    assert flown.end < 1.002 * least_seconds(path, uav)
    assert largest_distance(flown, path) < 1.0


def round_a_trunk(radius, turn, count):
    """A world with a trunk at the origin, and a path that turns round it by `turn` degrees at so many bends."""
    angles = np.radians(np.linspace(-turn / 2, turn / 2, count + 1))
    reach = radius / np.cos(angles[1] - angles[0]) + 1e-3
    bends = reach * np.column_stack([np.sin(angles), np.cos(angles), np.zeros(count + 1)])
    step = np.radians(turn / count)
    ends = [40 * np.array([-np.cos(step / 2 - angles[0]), -np.sin(step / 2 - angles[0]), 0])]
    path = np.vstack([bends[0] + ends[0], bends, bends[-1] + ends[0] * (-1, 1, 1)])
    return world_of(sky.Cylinder(centre=(0, 0), radius=radius, low=-100, high=500)), path + np.array([0, 0, 10])


@pytest.mark.parametrize(("radius", "turn", "count"), [(5, 1, 1), (3, 2, 1), (5, 3, 3)])
def test_gentle_bends_round_a_trunk_cost_hardly_any_time(radius, turn, count):
    world, path = round_a_trunk(radius, turn, count)
    uav = sky.UAV(start=(0, 0, 0), max_speed=10)
    flown = blended(world, path, uav, TOLERANCE)
    assert prove(world, uav, flown).verdict is sky.Verdict.PROVEN
    assert largest_distance(flown, path) <= 0.6
    assert flown.end <= 1.01 * least_seconds(path, uav)


@pytest.mark.parametrize(("radius", "turn", "count"), [(2, 40, 12), (1, 60, 20), (1, 90, 12)])
def test_many_bends_round_a_trunk_take_as_long_as_the_one_in_their_place(radius, turn, count):
    world, path = round_a_trunk(radius, turn, count)
    uav = sky.UAV(start=(0, 0, 0), max_speed=10)
    flown = blended(world, path, uav, TOLERANCE)
    assert prove(world, uav, flown).verdict is sky.Verdict.PROVEN
    assert largest_distance(flown, path) <= TOLERANCE
    way = path[1] - path[0]
    meeting = path[0] - way * path[0, 0] / way[0]
    assert flown.end <= 1.01 * blended(world, np.vstack([path[0], meeting, path[-1]]), uav, TOLERANCE).end


@settings(max_examples=40, deadline=None)
@given(
    reach=st.floats(2.0, 18.0),
    part=st.floats(0.5, 0.8),
    cut=st.floats(0.01, 0.1),
    dips=st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
)
@example(reach=16.5, part=0.735, cut=0.01, dips=(-1.03, 1.03))
def test_bends_that_are_merged_stay_near_a_path_whose_legs_are_not_in_one_plane(reach, part, cut, dips):
    bends = [
        (0, 0, 0),
        (part, -0.2 * cut, dips[0]),
        (1 - cut, -cut, 0),
        (1 - 0.2 * cut, part - 1, dips[1]),
        (1, -1, 0),
    ]
    bends = reach * np.array(bends) + [0, 0, 50]
    path = np.vstack([[-300, 0, 50], bends, [bends[-1, 0], -300, 50]])
    flown = blended(OPEN, path, sky.UAV(start=(0, 0, 0), max_speed=20), TOLERANCE)
    assert largest_distance(flown, path) <= TOLERANCE


def test_in_woods_flights_are_near_their_paths_and_hardly_slower_than_without_bends():
    times = []
    for seed in range(20):
        problem = sky.Problem(woods(seed))
        result = sky.Taut().plan(problem)
        flown = sky.fly_along(problem, result)
        uav = problem.scenario.uavs[0]
        assert prove(problem.airspace.world, uav, flown).verdict is sky.Verdict.PROVEN
        path = np.vstack([problem.start, result.path, problem.end])
        steps = np.diff(path, axis=0)
        profile = least_seconds(path, uav)
        times.append(flown.end / profile)
        assert flight_summary(uav, path, flown).length <= 1.003 * np.linalg.norm(steps, axis=1).sum(), seed
        velocity = flown.at(np.linspace(0, flown.end, 8001)[1:-1]).velocity
        velocity = velocity[np.linalg.norm(velocity, axis=1) > 1e-2]
        assert turning(velocity) <= turning(steps[np.linalg.norm(steps, axis=1) > 0]) + 10, seed
    assert np.median(times) <= 1.005
    assert max(times) <= 1.04


def test_where_no_blend_is_clear_the_uav_stops():
    walls = [sky.Box(min=(-50, -50, -100), max=(0, 0, 500)), sky.Box(min=(1e-5, -50, -100), max=(50, 50, 500))]
    world = world_of(
        *walls, sky.Box(min=(-50, 1e-5, -100), max=(0, 50, 500)), sky.Box(min=(0, 1e-5, -100), max=(1, 9, 99))
    )
    path = np.array([(-40.0, 5e-6, 10), (5e-6, 5e-6, 10), (5e-6, -40, 10)])
    flown = blended(world, path, sky.UAV(start=(0, 0, 0)), TOLERANCE)
    bend = flown.at(flown.knots).velocity
    assert np.linalg.norm(bend[1:-1], axis=1).min() < 0.3


def test_over_the_ridges_what_is_flown_is_the_path():
    mission = sky.plan_mission(sky.read("jacksboro"), sky.Taut(), assignment="identity")
    assert mission.violations == ()
    for uav, result, flown in zip(mission.scenario.uavs, mission.results, mission.trajectories, strict=True):
        path = np.vstack([uav.start, result.path, flown.at(flown.end).position])
        length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        summary = flight_summary(uav, path, flown)
        assert flown.form == "blended"
        assert summary.length <= 1.003 * length
        assert summary.deviation <= TOLERANCE
        assert flown.end - flown.start <= 1.03 * least_seconds(path, uav)


def test_both_corners_of_a_leg_are_moved_outwards_where_that_is_faster(monkeypatch):
    module = import_module("skyverse.trajectory.blended")
    fit, seconds = module._fit, []
    for in_pairs in (True, False):
        if not in_pairs:
            monkeypatch.setattr(
                module, "_fit", lambda *args, in_pairs=False, **more: None if in_pairs else fit(*args, **more)
            )
        problem = sky.Problem(woods(34))
        waypoints = needed_waypoints(problem, sky.Taut(proof=0).plan(problem))
        flown = blended(problem.airspace.world, waypoints, problem.scenario.uavs[0], 2.0)
        assert largest_distance(flown, waypoints) <= 2.0 + 1e-6
        seconds.append(flown.end)
    assert seconds[0] < 0.95 * seconds[1]
