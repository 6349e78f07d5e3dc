"""No flight takes more energy than the referee's bound, which is tight; a battery that does not suffice is refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.sortie import Sortie
from skyverse.model.trajectory import Trajectory
from skyverse.referee.energy import energy_bounds, judge_battery, turning_back
from skyverse.summary import battery_course, flight_summary
from skyverse.trajectory import rest_to_rest

CAMERA = {"hover_power": 121.6, "power": ((9, 102.7), (14, 121.3)), "mass": 0.915, "battery": 77.0}
KINDS = {
    "hover alone": {"hover_power": 121.6, "mass": 0.915},
    "momentum": CAMERA,
    "laden": CAMERA | {"payload": 0.4},
    "measured": CAMERA | {"power": None, "power_curve": ((4, 115), (9, 102.7), (14, 121.3))},
}


def world(wind=None, **fields):
    uav = sky.UAV(start=(0, 0, 20), max_speed=15, max_acceleration=4, **fields)
    box = {"min": (-2000, -2000, 0), "max": (2000, 2000, 200)}
    return sky.Scenario(name="air", bounds=box, clearance=1, obstacles=[], uavs=[uav], targets=[], wind=wind)


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


def simulated(scenario, trajectory, begin, end, way=1.0, gusts=None):
    """Return joules by the midpoint rule at steps of a millisecond or so, without what the referee computes.

    Gusts (k, 3), shares of the margin, follow each other at equal times, with straight lines between them.
    """
    edges = np.linspace(begin, end, max(2, int((end - begin) / 1e-3)))
    motion = trajectory.at((edges[1:] + edges[:-1]) / 2)
    velocity = way * motion.velocity
    if scenario.wind is not None:
        velocity = velocity - scenario.wind.at(motion.position[:, 2])
    if gusts is not None:
        at = np.linspace(0, len(gusts) - 1, len(velocity))
        blown = np.stack([np.interp(at, np.arange(len(gusts)), axis) for axis in np.asarray(gusts).T], axis=1)
        velocity = velocity - scenario.wind.gust * blown
    load = np.sqrt(np.sum((motion.acceleration + np.array([0, 0, 9.81])) ** 2, axis=1)) / 9.81
    power = scenario.uavs[0].power_model.at(np.hypot(velocity[:, 0], velocity[:, 1]), velocity[:, 2], load)
    return float(np.sum(power * np.diff(edges)))


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 10**6), shares=st.tuples(st.floats(0, 1), st.floats(0, 1)))
@settings(max_examples=20, deadline=None)
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
    load = 1 + 4 / 9.81
    turning = 121.6 * load**1.5 + load * 0.915 * 9.81 * 2  # for the second that braking and gathering speed take
    assert joules[-1] - back == pytest.approx(turning, rel=1e-3)
    assert last == instants[-1] == 20


@given(seed=st.integers(0, 10**6), share=st.floats(0.01, 1))
@settings(max_examples=20, deadline=None)
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
    halves = np.array([[0.0, seconds / 2], [seconds / 2 + 120, seconds]])
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


@pytest.mark.parametrize("wind", [None, {"velocity": (6, 2, 0)}, {"velocity": (6, 2, 0), "gust": 2}])
def test_what_is_told_of_a_battery_over_time_is_what_is_bounded(wind):
    scenario = world(wind=wind, **CAMERA | {"battery": 6.0, "max_airspeed": 40.0})
    trajectory = flight(5, scenario.uavs[0], corners=12)
    told = battery_course(scenario, 0, trajectory, Sortie(0, trajectory.end, ()))
    used = np.interp(told.instants, *energy_bounds(scenario, 0, trajectory, 0, trajectory.end)) / (6 * 3600)
    instants, back, last = turning_back(scenario, 0, trajectory, 0, trajectory.end)
    assert told.left == pytest.approx(0.9 - used, abs=0.01)
    assert told.back == pytest.approx(np.interp(told.instants, instants, back) / (6 * 3600), abs=0.06)
    assert 0 < last < trajectory.end
    assert told.no_return == pytest.approx(last, rel=0.1)
    assert battery_course(world(hover_power=100.0), 0, trajectory, Sortie(0, 1, ())) is None


def test_between_sorties_nothing_is_taken_and_the_longest_one_says_what_is_left():
    scenario = world(**CAMERA)
    out_and_back = [(10, (9, 0, 0)), (10, (-9, 0, 0)), (200, (0, 0, 0)), (20, (9, 0, 0)), (20, (-9, 0, 0))]
    trajectory, spans = line(*out_and_back), [(0, 20), (220, 260)]
    told = flight_summary(
        scenario.uavs[0], trajectory.at(trajectory.knots).position, trajectory, None, spans, [0.0, 0.0]
    )
    assert (told.energy, told.length) == pytest.approx((60 * 102.7, 60 * 9))
    assert told.left == pytest.approx(0.9 - 40 * 102.7 / (77 * 3600))


def test_take_off_and_landing_count_where_a_uav_starts_above_its_home():
    """By hand: 40 m up at 1.5 m/s, and down at 1.5 m/s but for the last 10 m, at 0.5 m/s; 100 W hover, 1 kg rises."""
    own = {"hover_power": 100.0, "mass": 1.0, "battery": 10.0, "end": "home"}
    scenario = world(**own).model_copy(update={"targets": (sky.Target(name="t", position=(30, 20, 40)),)})
    (uav,) = scenario.uavs
    scenario = scenario.model_copy(update={"uavs": (uav.model_copy(update={"start": (10, 20, 40), "home": 0.0}),)})
    mission = sky.plan_mission(scenario, "taut")
    assert mission.violations == ()
    (sortie,) = mission.sorties[0]
    in_the_air = energy_bounds(scenario, 0, mission.trajectories[0], sortie.begin, sortie.end)[1][-1]
    ground = 40 / 1.5 * (100 + 9.81 * 1.5) + (30 / 1.5 + 10 / 0.5) * 100
    assert mission.flights[0].energy_bound == pytest.approx(in_the_air + ground, rel=0.01)
    assert mission.flights[0].left == pytest.approx(0.9 - (in_the_air + ground) / 36000, rel=0.01)
    enough = (in_the_air + ground) / 3600 / 0.7
    for battery, faults in ((1.01 * enough, []), (0.99 * enough, [sky.Fault.BATTERY])):
        poorer = scenario.model_copy(update={"uavs": (scenario.uavs[0].model_copy(update={"battery": battery}),)})
        assert [one.fault for one in sky.check(poorer, replace(mission, scenario=poorer))] == faults


LAYERS = [{"altitude": 10, "velocity": (3, -2, 0.5)}, {"altitude": 22, "velocity": (7, 1, -0.5)}]
WINDS = [
    {"velocity": (6, 2, 0)},
    {"layers": LAYERS},
    {"velocity": (-4, 5, 0.3), "gust": 2.5},
    {"layers": LAYERS, "gust": 1},
]


@pytest.mark.parametrize("kind", ["momentum", "measured"])
@given(seed=st.integers(0, 10**6), wind=st.sampled_from(WINDS), way=st.sampled_from([1.0, -1.0]))
@example(seed=4015, wind=WINDS[0], way=1.0)  # whose power is largest in the middle of parts
@settings(max_examples=25, deadline=None)
def test_in_no_wind_and_no_gusts_a_flight_takes_more_than_its_bound(kind, seed, wind, way):
    strong = {} if "fixed_wing" in KINDS[kind] else {"max_airspeed": 60.0}  # it flies back in the same time
    scenario = world(wind=wind, **KINDS[kind] | strong)
    trajectory = flight(seed, scenario.uavs[0], corners=4)
    bounded = energy_bounds if way > 0 else turning_back
    most = bounded(scenario, 0, trajectory, 0, trajectory.end)[1][-1]
    rng = np.random.default_rng(seed)
    gusts = rng.normal(size=(40, 3))
    gusts = [gusts / np.linalg.norm(gusts, axis=1)[:, None], np.zeros((2, 3)), np.full((2, 3), (0, 0, -1.0))]
    true = [simulated(scenario, trajectory, 0, trajectory.end, way, one) for one in gusts]
    assert max(true) <= most * (1 + 1e-6)
    if scenario.wind.gust == 0 and way > 0:
        assert most <= 1.01 * true[0]


def test_hovering_in_a_wind_is_flying_and_a_gust_from_above_is_a_climb():
    for wind, watts in (
        ({"velocity": (9, 0, 0)}, 102.7),
        ({"layers": [{"altitude": 0, "velocity": (0, 0, 0)}, {"altitude": 40, "velocity": (0, 28, 0)}]}, 121.3),
        ({"velocity": (0, 0, -2)}, 121.6 + 0.915 * 9.81 * 2),
    ):
        scenario = world(wind=wind, **CAMERA)
        assert energy_bounds(scenario, 0, line((60, (0, 0, 0))), 0, 60)[1][-1] == pytest.approx(60 * watts, rel=1e-6)
    scenario = world(wind={"velocity": (0, 0, 0), "gust": 2}, **CAMERA)
    joules = energy_bounds(scenario, 0, line((60, (0, 0, 0))), 0, 60)[1][-1]
    assert joules == pytest.approx(60 * (121.6 + 0.915 * 9.81 * 2), rel=1e-6)


def test_with_the_wind_the_way_out_takes_less_than_the_way_back():
    scenario = world(wind={"velocity": (8, 0, 0)}, **CAMERA | {"max_airspeed": 30.0})
    power = scenario.uavs[0].power_model
    out = line((100, (8, 0, 0)))
    assert energy_bounds(scenario, 0, out, 0, 100)[1][-1] == pytest.approx(100 * 121.6, rel=1e-6)
    instants, joules, last = turning_back(scenario, 0, out, 0, 100)
    against = float(power.at(np.array([16.0]), np.zeros(1), np.ones(1))[0])
    assert joules[-1] - joules[0] == pytest.approx(100 * against, rel=1e-6)
    assert last == instants[-1]
    slow = world(wind={"velocity": (8, 0, 0), "gust": 2}, **CAMERA | {"max_airspeed": 15.0})
    _, joules, _ = turning_back(slow, 0, out, 0, 100)
    against = float(power.most(np.array([13.0]), np.array([13.0]), np.zeros(1), np.ones(1), 2.0)[0])
    assert joules[-1] - joules[0] == pytest.approx(800 / 5 * against, rel=1e-6)  # 15 m/s less wind and gust make 5 good


def test_what_is_stated_of_a_flight_in_wind_and_gusts_is_what_the_referee_bounds():
    scenario = world(wind={"layers": LAYERS, "gust": 2}, **CAMERA)
    trajectory = flight(3, scenario.uavs[0])
    told = flight_summary(scenario.uavs[0], trajectory.at(trajectory.knots).position, trajectory, scenario.wind)
    assert told.energy == pytest.approx(simulated(scenario, trajectory, 0, trajectory.end), rel=1e-5)
    most = energy_bounds(scenario, 0, trajectory, 0, trajectory.end)[1][-1]
    assert told.energy < told.energy_bound <= most <= 1.01 * told.energy_bound
    assert told.left == pytest.approx(0.9 - told.energy_bound / (77 * 3600))
