"""What is stated of a flight is what many samples of it say."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.summary import flight_summary, largest_distance
from skyverse.trajectory import rest_to_rest

CORNERS = np.array([(0.0, 0, 1), (4, 0, 1), (4, 3, 1), (4, 3, 5)])
ALPHA = UAV(start=(0, 0, 1))


def test_a_flight_along_its_path_has_the_paths_length_and_no_deviation():
    flight = rest_to_rest(CORNERS, ALPHA)
    told = flight_summary(ALPHA, CORNERS, flight)
    assert told.length == pytest.approx(11, rel=1e-9)
    assert told.time == pytest.approx(flight.end)
    assert 0 <= told.deviation <= 2e-8


@pytest.mark.parametrize("seed", range(4))
def test_a_curve_is_as_long_and_as_far_off_as_its_samples(seed):
    rng = np.random.default_rng(seed)
    flight = Trajectory(np.cumsum(np.r_[0, rng.uniform(0.5, 2, 5)]), rng.normal(size=(5, 6, 3)))
    path = rng.normal(size=(7, 3)) * 3
    told = flight_summary(ALPHA, path, flight)
    between = [np.linspace(a, b, 20_001)[:-1] for a, b in zip(flight.knots[:-1], flight.knots[1:], strict=True)]
    length, worst = 0.0, 0.0
    for k, times in enumerate(between):
        local = times - flight.knots[k]
        places = sum(flight.coefficients[k, j] * local[:, None] ** j for j in range(6))
        length += np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
        a, way = path[:-1], np.diff(path, axis=0)
        share = np.clip(np.einsum("nmk,mk->nm", places[::10, None] - a, way) / np.sum(way**2, axis=1), 0, 1)
        nearest = np.linalg.norm(places[::10, None] - a - share[..., None] * way, axis=2).min(axis=1)
        worst = max(worst, nearest.max())
    assert told.length == pytest.approx(length, rel=1e-3)
    assert worst <= told.deviation
    assert told.deviation == pytest.approx(worst, rel=1e-2)


def test_a_hover_takes_its_power_times_its_time_and_twice_the_thrust_nearly_three_times_as_much():
    camera = UAV(start=(0, 0, 1), hover_power=122.0)
    minute = np.array([0.0, 60.0])
    hover = Trajectory(minute, np.array([[(0.0, 0, 1), (0, 0, 0), (0, 0, 0)]]))
    assert flight_summary(camera, CORNERS[:1], hover).energy == pytest.approx(122 * 60)
    rising = Trajectory(minute, np.array([[(0.0, 0, 1), (0, 0, 0), (0, 0, 9.81 / 2)]]))  # at one g
    assert flight_summary(camera, CORNERS[:1], rising).energy == pytest.approx(122 * 60 * 2**1.5)


def test_a_flight_on_a_battery_leaves_what_it_does_not_take_of_the_trusted_share():
    camera = UAV(start=(0, 0, 1), vehicle="camera")
    rising = Trajectory(np.array([0.0, 60.0]), np.array([[(0.0, 0, 1), (0, 0, 2)]]))
    told = flight_summary(camera, CORNERS[:1], rising)
    assert told.energy == pytest.approx(60 * (122 + 0.915 * 9.81 * 2))
    assert told.left == pytest.approx(0.9 - told.energy_bound / (77 * 3600))
    assert flight_summary(camera.model_copy(update={"battery": None}), CORNERS[:1], rising).left is None


def test_no_energy_is_told_where_the_power_is_not_known():
    flight = rest_to_rest(CORNERS, ALPHA)
    assert flight_summary(ALPHA, CORNERS, flight).energy is None
    assert flight_summary(UAV(start=(0, 0, 1), vehicle="thesis"), CORNERS, flight).energy is None


def test_the_distance_from_a_single_place_is_known():
    flight = rest_to_rest(np.array([(0.0, 0, 0), (3, 0, 0)]), ALPHA)
    assert largest_distance(flight, np.array([(0.0, 4, 0)])) == pytest.approx(5, abs=1e-7)


def test_every_planned_mission_states_what_is_flown():
    mission = sky.plan_mission(sky.read_scenario("table-4.9-2"), sky.AStar(), rng=1)
    assert mission.violations == ()
    assert len(mission.flights) == 2
    for flight, trajectory in zip(mission.flights, mission.trajectories, strict=True):
        assert flight.time == trajectory.end - trajectory.start
        assert 0 < flight.deviation < 5
