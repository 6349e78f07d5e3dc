"""Trajectories along paths are proven, by the referee too, and say why where they are not of the shape asked for."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from handmade import hall
from skyverse.summary import turning
from skyverse.trajectory import Proof, blended, needed_waypoints, path_to_trajectory


def flown(scenario, planner=None, shape="minimum-time", uav=0):
    problem = sky.Problem(scenario, uav, uav)
    return sky.fly_along(problem, (planner or sky.Taut()).plan(problem), shape)


@pytest.mark.parametrize("name", ["map1", "map2", "map3"])
@pytest.mark.parametrize("shape", ["minimum-time", "minimum-snap", "minimum-jerk", "stop-and-go"])
def test_flights_through_the_maps_are_what_was_asked_for_and_proven(name, shape):
    scenario = sky.read(name)
    mission = sky.plan_mission(scenario, sky.Taut(), options=sky.MissionOptions(shape=shape))
    trajectory = mission.trajectories[0]
    assert trajectory.form in {"stop-and-go": ("stop-and-go",), "minimum-time": ("blended", "smooth")}.get(
        shape, ("smooth",)
    )
    assert trajectory.note == ""
    assert mission.violations == ()
    assert mission.certificates[0].verdict is sky.Verdict.PROVEN


@settings(max_examples=25)
@given(st.integers(0, 10**6))
def test_every_flight_through_a_random_room_is_proven_by_the_referee(seed):
    mission = sky.plan_mission(sky.random_room(seed=seed), sky.Taut())
    assert [v for v in mission.violations if v.fault is not sky.Fault.ASSIGNMENT] == []


def hall_with_slit(width):
    walls = [
        {"min": (15, 0, 0), "max": (16, 10 - width / 2, 10)},
        {"min": (15, 10 + width / 2, 0), "max": (16, 20, 10)},
    ]
    return hall((30, 20, 10), [(2, 3, 5)], [(28, 12, 5)], obstacles=walls, clearance=0.25)


def test_a_slit_too_narrow_for_a_spline_is_flown_along_straight_legs_and_said_so():
    narrow = flown(hall_with_slit(0.501), shape="minimum-snap")
    assert narrow.form == "blended"
    assert narrow.note == "The passage is too narrow for a spline."
    assert narrow.end < flown(hall_with_slit(0.501), shape="stop-and-go").end
    wide = flown(hall_with_slit(0.6), shape="minimum-snap")
    assert wide.form == "smooth"


SPLINES = ["smooth", "slowed", "straightened"]
LAST = ["blended", "slowed", "stop-and-go", "stop-and-go"]


@pytest.mark.parametrize(
    ("shape", "tried"),
    [("minimum-snap", SPLINES + LAST), ("minimum-time", LAST), ("stop-and-go", LAST[2:])],
)
def test_what_is_not_proven_is_slowed_then_straightened_then_stopped(monkeypatch, shape, tried):
    forms = []

    def refuse(world, uav, trajectory):
        forms.append(trajectory.form)
        return Proof(sky.Verdict.UNDECIDED, "clearance", 0.0)

    monkeypatch.setattr(path_to_trajectory, "prove", refuse)
    assert flown(hall_with_slit(2.0), shape=shape) is None
    assert forms == tried


def test_a_flight_keeps_close_to_a_path_that_was_priced_by_where_it_leads():
    scenario = sky.read("map1")
    objective = scenario.objective.model_copy(update={"altitude": sky.AltitudeBand(low=1, high=2, weight=5)})
    problem = sky.Problem(scenario.model_copy(update={"objective": objective}))
    result = sky.AStar().plan(problem)
    trajectory = sky.fly_along(problem, result)
    path = np.vstack([problem.start, result.path, problem.end])
    shares = np.linspace(0, 1, 11)[:, None, None]
    near = ((1 - shares) * path[:-1] + shares * path[1:]).reshape(-1, 3)
    away = [np.abs(p - near).max(axis=1).min() for p in trajectory.at(np.linspace(0, trajectory.end, 500)).position]
    assert max(away) < 1.0


def test_an_unknown_shape_is_refused(refuses):
    with refuses():
        flown(sky.read("map1"), shape="best")


def test_a_flight_far_from_the_zero_of_the_frame_is_proven_too():
    scenario = hall_with_slit(2.0)
    far = np.array([5e5, -3e6, 100.0])

    def moved(place):
        return tuple(np.add(place, far).tolist())

    data = scenario.model_dump()
    data["bounds"] = {corner: moved(place) for corner, place in data["bounds"].items()}
    data["obstacles"] = [{"min": moved(box.min), "max": moved(box.max)} for box in scenario.obstacles]
    data["uavs"] = [{"start": moved(scenario.uavs[0].start)}]
    data["targets"] = [{"position": moved(scenario.targets[0].position)}]
    mission = sky.plan_mission(sky.Scenario(**data), sky.Taut())
    assert mission.trajectories[0].form in ("blended", "smooth")
    assert mission.violations == ()


def test_a_looser_limit_makes_no_flight_slower():
    scenario = sky.read("map3")
    times = []
    for limit in (3.5, 9.0, 100.0, 1e4):
        uav = scenario.uavs[0].model_copy(update={"max_acceleration": limit})
        times.append(flown(scenario.model_copy(update={"uavs": (uav,)})).end)
    assert all(later <= 1.01 * earlier for earlier, later in itertools.pairwise(times))


@pytest.mark.parametrize("apart", [0.0, 1e-9, 1e-7])
def test_a_flight_over_hardly_any_distance_is_proven(apart):
    scenario = hall_with_slit(2.0)
    target = sky.Target(position=(2 + apart, 3, 5))
    mission = sky.plan_mission(scenario.model_copy(update={"targets": (target,)}), sky.Taut())
    assert mission.violations == ()
    assert mission.trajectories[0].note == ""


def test_a_spline_that_leaves_its_path_says_by_how_much():
    far = flown(sky.random_city(500, seed=1), shape="minimum-snap")
    assert far.form == "smooth"
    assert far.note.startswith("It leaves its path by up to ")


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_a_spline_turns_hardly_more_than_straight_legs_unless_they_take_much_longer(seed):
    rng = np.random.default_rng(seed)
    trunks = [
        sky.Cylinder(centre=tuple(centre), radius=float(radius), low=0, high=20)
        for centre, radius in zip(rng.uniform(5, 55, (40, 2)), rng.uniform(0.3, 1.5, 40), strict=True)
    ]
    problem = sky.Problem(hall((60, 60, 15), [(1, 1, 3)], [(59, 59, 3)], obstacles=trunks, clearance=0.5))
    result = sky.Taut().plan(problem)
    trajectory = sky.fly_along(problem, result)
    if trajectory.form == "smooth":
        straight = blended(problem.airspace.world, needed_waypoints(problem, result), problem.scenario.uavs[0], 2.0)
        assert turning(trajectory) <= turning(straight) + 10 or straight.end >= 1.03 * trajectory.end


def test_a_quarter_of_a_circle_turns_by_ninety_degrees_and_a_stop_by_none():
    angles = np.linspace(0, np.pi / 2, 41)
    rows = [
        [(np.cos(a), np.sin(a), 0), (-np.sin(a), np.cos(a), 0), (-np.cos(a) / 2, -np.sin(a) / 2, 0)] for a in angles
    ]
    assert turning(sky.Trajectory(angles, np.array(rows[:-1]))) == pytest.approx(90, abs=3)
    assert turning(sky.Trajectory(np.array([0.0, 9.0]), np.array([[(1.0, 2, 3), (0, 0, 0)]]))) == 0
