"""No flight takes more energy than the referee's bound, which is tight; a battery that does not suffice is refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.trajectory import Trajectory
from skyverse.referee.energy import energy_bounds, judge_battery, turning_back
from skyverse.trajectory import rest_to_rest

CAMERA = {"hover_power": 121.6, "power": ((9, 102.7), (14, 121.3)), "mass": 0.915, "battery": 77.0}
KINDS = {
    "hover alone": {"hover_power": 121.6, "mass": 0.915},
    "momentum": CAMERA,
    "laden": CAMERA | {"payload": 0.4},
    "measured": CAMERA | {"power": None, "power_curve": ((4, 115), (9, 102.7), (14, 121.3))},
}


def world(**fields):
    uav = sky.UAV(start=(0, 0, 20), max_speed=15, max_acceleration=4, **fields)
    box = {"min": (-2000, -2000, 0), "max": (2000, 2000, 200)}
    return sky.Scenario(name="air", bounds=box, clearance=1, obstacles=[], uavs=[uav], targets=[])


def flight(seed, uav, corners=8):
    steps = np.random.default_rng(seed).normal(size=(corners, 3)) * [50, 50, 8]
    return rest_to_rest(np.array(uav.start) + np.r_[np.zeros((1, 3)), np.cumsum(steps, axis=0)], uav)


def line(*pieces):
    """Return a trajectory at constant velocities: pieces of seconds and (3,) m/s."""
    seconds, velocities = zip(*pieces, strict=True)
    knots, velocities = np.r_[0.0, np.cumsum(seconds)], np.array(velocities, dtype=float)
    ways = np.cumsum(np.diff(knots)[:, None] * velocities, axis=0)[:-1]
    places = np.array([0.0, 0.0, 20.0]) + np.concatenate([np.zeros((1, 3)), ways])
    return Trajectory(knots, np.stack([places, velocities], axis=1))


def simulated(scenario, trajectory, begin, end, way=1.0):
    """Return joules by the midpoint rule at steps of a millisecond or so, without what the referee computes."""
    edges = np.linspace(begin, end, max(2, int((end - begin) / 1e-3)))
    motion = trajectory.at((edges[1:] + edges[:-1]) / 2)
    velocity = way * motion.velocity
    load = np.sqrt(np.sum((motion.acceleration + np.array([0, 0, 9.81])) ** 2, axis=1)) / 9.81
    power = scenario.uavs[0].power_model.at(np.hypot(velocity[:, 0], velocity[:, 1]), velocity[:, 2], load)
    return float(np.sum(power * np.diff(edges)))


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 10**6), shares=st.tuples(st.floats(0, 1), st.floats(0, 1)))
@settings(max_examples=15, deadline=None)
def test_no_flight_takes_more_than_the_bound_and_none_one_percent_less(kind, seed, shares):
    scenario = world(**KINDS[kind])
    trajectory = flight(seed, scenario.uavs[0])
    begin, end = sorted(share * trajectory.end for share in shares)
    for first, last in ((0.0, trajectory.end), (begin, end + 1e-3)):
        instants, joules = energy_bounds(scenario, 0, trajectory, first, last)
        true = simulated(scenario, trajectory, first, min(last, trajectory.end))
        assert true <= joules[-1] * (1 + 1e-6)  # what the sum over steps is off
        assert joules[-1] <= true * 1.01 + 1.0
        assert (np.diff(instants) > 0).all()
        assert (np.diff(joules) >= 0).all()


def test_hovering_and_flying_straight_and_climbing_take_what_the_power_says():
    scenario = world(**CAMERA)
    power = scenario.uavs[0].power_model
    for velocity, watts in (
        ((0, 0, 0), 121.6),
        ((9, 0, 0), 102.7),
        ((0, -14, 0), 121.3),
        ((0, 0, 2), 121.6 + 0.915 * 9.81 * 2),
        ((0, 0, -2), 121.6),
    ):
        _, joules = energy_bounds(scenario, 0, line((60, velocity)), 0, 60)
        assert joules[-1] == pytest.approx(60 * watts, rel=1e-6)
    instants, joules = energy_bounds(scenario, 0, line((10, (9, 0, 0)), (10, (0, 0, 0))), 5, 12)
    assert (instants[0], instants[-1]) == (5, 12)
    assert joules[-1] == pytest.approx(5 * 102.7 + 2 * 121.6, rel=1e-6)
    assert power.induced > 0


def test_on_the_ground_before_and_after_a_flight_nothing_is_taken():
    scenario = world(**CAMERA)
    _, joules = energy_bounds(scenario, 0, line((60, (0, 0, 0))), -50, 1e6)
    assert joules[-1] == pytest.approx(60 * 121.6, rel=1e-6)
    assert energy_bounds(scenario, 0, line((60, (0, 0, 0))), 70, 80)[1][-1] == 0


def test_flying_back_takes_the_climb_that_was_sunk_and_the_turn():
    scenario = world(**CAMERA)
    instants, joules, last = turning_back(scenario, 0, line((10, (9, 0, 0)), (10, (0, 0, -2))), 0, 20)
    back = 10 * 102.7 + 10 * (121.6 + 0.915 * 9.81 * 2)
    assert joules[-1] - back == pytest.approx(2 * 2 / 4 * 121.6 * math.hypot(1, 4 / 9.81) ** 1.5, rel=0.25)
    assert last == instants[-1] == 20


@given(seed=st.integers(0, 10**6), share=st.floats(0.01, 1))
@settings(max_examples=15, deadline=None)
def test_the_way_back_takes_no_more_than_its_bound(seed, share):
    scenario = world(**CAMERA)
    trajectory = flight(seed, scenario.uavs[0])
    instants, joules, _ = turning_back(scenario, 0, trajectory, 0.0, trajectory.end)
    k = int(share * (len(instants) - 1))
    assert simulated(scenario, trajectory, 0.0, instants[k], way=-1.0) <= joules[k] * (1 + 1e-6)


def test_the_point_of_no_return_is_where_the_way_back_takes_what_is_left():
    scenario = world(**CAMERA | {"reserve": 0.7})
    usable = scenario.uavs[0].usable_energy
    instants, joules, last = turning_back(scenario, 0, line(*[(10, (9, 0, 0))] * 100), 0, 1000)
    turn = joules[0]
    assert 102.7 * 2 * last + turn == pytest.approx(usable, rel=1e-6)
    assert last < 1000 == instants[-1]


@pytest.mark.parametrize(("seconds", "fits"), [(1595, True), (1596.5, False)])
def test_a_battery_is_enough_to_the_second_or_refused_with_what_is_missing(seconds, fits):
    scenario = world(**CAMERA)  # 0.7 * 77 Wh last 1595.7 s of hovering
    hover = line((seconds, (0, 0, 0)))
    found = judge_battery(scenario, 0, hover, np.array([[0.0, seconds]]))
    assert (not found) == fits
    for violation in found:
        assert violation.fault is sky.Fault.BATTERY
        assert violation.time == pytest.approx(0.7 * 77 * 3600 / 121.6, rel=1e-6)
    halves = np.array([[0.0, seconds / 2], [seconds / 2 + 10, seconds]])
    assert not judge_battery(scenario, 0, hover, halves)


def test_a_plan_that_the_battery_does_not_give_is_refuted_and_one_that_it_gives_is_proven():
    start, far = {"start": (0, 0, 20), "max_speed": 10, **CAMERA}, [{"position": (900, 0, 20)}]
    box = {"min": (-10, -10, 0), "max": (1000, 10, 40)}
    air = sky.Scenario(name="air", bounds=box, clearance=1, obstacles=[], uavs=[start], targets=far)
    mission = sky.plan_mission(air, sky.Taut(), rng=1)
    assert mission.violations == ()
    assert mission.flights[0].left == pytest.approx(0.9 - mission.flights[0].energy_bound / (77 * 3600))
    bound = energy_bounds(air, 0, mission.trajectories[0], 0, 1e6)[1][-1]
    assert mission.flights[0].energy <= bound <= 1.01 * mission.flights[0].energy
    poor = air.model_copy(update={"uavs": (air.uavs[0].model_copy(update={"battery": 3.0}),)})
    (violation,) = sky.check(poor, sky.plan_mission(poor, sky.Taut(), rng=1))
    assert violation.fault is sky.Fault.BATTERY
