"""The referee passes what is right, and names what is planted."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skyverse.model.mission import Mission
from skyverse.model.result import Effort, History, Provenance, Result, Status, no_history
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Fault, Violation
from skyverse.referee import check
from skyverse.referee.box_crossings import deepest_in_boxes
from skyverse.referee.boxes import grown_boxes

MADE_BY = Provenance("0", "by hand", "", None, "")


def quintic(start, end, seconds, speed_in=(0, 0, 0), speed_out=(0, 0, 0), bend_in=(0, 0, 0), bend_out=(0, 0, 0)):
    """p0 + (p1 - p0) * (10 s^3 - 15 s^4 + 6 s^5), s = t / T, and what given speeds and accelerations add."""
    start, end, v, w, a, b = (np.array(value, float) for value in (start, end, speed_in, speed_out, bend_in, bend_out))
    d, T = end - start, seconds
    return np.array(
        [
            start,
            v,
            a / 2,
            (10 * d - (6 * v + 4 * w) * T + (b - 3 * a) / 2 * T**2) / T**3,
            (-15 * d + (8 * v + 7 * w) * T + (3 * a - 2 * b) / 2 * T**2) / T**4,
            (6 * d - (3 * v + 3 * w) * T + (b - a) / 2 * T**2) / T**5,
        ]
    )


def stops(waypoints, seconds=3.0, start=0.0):
    """A trajectory that stops at every waypoint."""
    pieces = [quintic(a, b, seconds) for a, b in pairwise(waypoints)]
    return Trajectory(start + seconds * np.arange(len(waypoints)), np.array(pieces))


def row(first, *legs):
    """Lattice nodes from `first` on, a metre apart; a leg is ("x", 3) or ("z", -1)."""
    path = [np.array(first, float)]
    for axis, count in legs:
        step = np.eye(3)["xyz".index(axis)] * np.sign(count)
        path += [path[-1] + step * k for k in range(1, abs(count) + 1)]
    return np.array(path)


def result(path, fuel, divergence=0.0, end=0.0, **other):
    path = np.array(path, float)
    fields = {
        "status": Status.COMPLETE,
        "path": path,
        "cost": fuel + divergence + end,
        "terms": {"fuel": float(fuel), "divergence": divergence, "end": end},
        "bound": None,
        "start": path[0],
        "goal": path[-1],
        "effort": Effort(),
        "seconds": 0.0,
        "history": no_history(),
        "stopped_by": "finished",
        "provenance": MADE_BY,
    }
    return Result(**(fields | other))


def no_result(status=Status.NO_PATH, **other):
    nowhere = np.zeros((1, 3))
    return replace(result(nowhere, 0), status=status, path=np.zeros((0, 3)), cost=np.inf, terms={}, **other)


def history(*cost):
    none = np.zeros(len(cost), np.int64)
    return History(np.array(cost, float), none, none, none)


SCENARIO = Scenario(
    name="two ways past a block",
    bounds=Bounds(min=(0, 0, 0), max=(10, 6, 4)),
    obstacles=(Box(min=(4, 0, 0), max=(5, 3, 3)), Box(min=(0, 0, 3.5), max=(1, 1, 4))),
    clearance=0.25,
    lattice=Lattice(step=(1, 1, 1)),
    objective=Objective(fuel=1, divergence=0.3, end=80, unit="nodes"),
    uavs=(
        UAV(name="alpha", start=(0.2, 4.1, 1.2)),
        UAV(name="bravo", start=(1.1, 5.2, 3.1)),
        UAV(name="charlie", start=(9, 1, 0.5)),
    ),
    targets=(
        Target(position=(8.9, 5.1, 3)),
        Target(position=(9.3, 4.2, 2.4)),
    ),
)
ALPHA, BEND, ALPHA_ENDS = (0.2, 4.1, 1.2), (4.7, 4.15, 1.8), (9.3, 4.2, 2.4)
VALID = Mission(
    scenario=SCENARIO,
    assignment=(1, 0, None),
    results=(
        result(row((0, 4, 1), ("x", 9), ("z", 1)), 11, 0.3, bound=10.0, history=history(90.5, 11.3, 11.3)),
        result(row((1, 5, 3), ("x", 8)), 9, status=Status.OPTIMAL, bound=9.0),
        None,
    ),
    trajectories=(stops([ALPHA, BEND, ALPHA_ENDS]), stops([(1.1, 5.2, 3.1), (5, 5, 3), (8.9, 5.1, 3)]), None),
    violations=(),
    provenance=MADE_BY,
)


def test_a_valid_mission_passes():
    assert check(SCENARIO, VALID) == []


def test_a_mission_for_nobody_passes():
    nobody = SCENARIO.model_copy(update={"uavs": ()})
    assert check(nobody, replace(VALID, scenario=nobody, assignment=(), results=(), trajectories=())) == []


def put(column, uav, value):
    return (*column[:uav], value, *column[uav + 1 :])


def flying(trajectory, uav=0, mission=VALID):
    return replace(mission, trajectories=put(mission.trajectories, uav, trajectory))


def resulting(changed, uav=0, mission=VALID):
    return replace(mission, results=put(mission.results, uav, changed))


def alpha(**changes):
    """Alpha's result with other fields."""
    return resulting(replace(VALID.results[0], **changes))


def walking(path, fuel, divergence=0.0, end=0.0, **other):
    """Alpha on another path, honestly priced."""
    fields = {"start": VALID.results[0].start, "goal": VALID.results[0].goal} | other
    return resulting(result(path, fuel, divergence, end, **fields))


def grounded(mission):
    """The same without alpha's trajectory."""
    return flying(None, mission=mission)


def to_charlie(target, charlie, trajectory=None):
    return flying(trajectory, 2, resulting(charlie, 2, replace(VALID, assignment=put(VALID.assignment, 2, target))))


def with_a_third_target(mission):
    third = Target(name="target-3", position=(2, 2, 2))
    return replace(mission, scenario=SCENARIO.model_copy(update={"targets": (*SCENARIO.targets, third)}))


def given_uav(uav, **changes):
    """The valid mission for a scenario in which a UAV is another."""
    changed = SCENARIO.uavs[uav].model_copy(update=changes)
    return replace(VALID, scenario=SCENARIO.model_copy(update={"uavs": put(SCENARIO.uavs, uav, changed)}))


def coefficients(index, value, uav=0):
    changed = VALID.trajectories[uav].coefficients.copy()
    changed[index] = value
    return flying(replace(VALID.trajectories[uav], coefficients=changed), uav)


def knots(*values):
    return flying(replace(VALID.trajectories[0], knots=np.array(values, float)))


STRAIGHT = VALID.results[0].path
HOVER = Trajectory(np.array([0.0, 1.0]), np.array([[[9.0, 1.0, 0.5]]]))
SHORT = row((0, 4, 1), ("x", 9))


def jolting(bend):
    """Alpha's flight, with an acceleration that sets in at the bend."""
    pieces = VALID.trajectories[0].coefficients.copy()
    pieces[1] = quintic(BEND, ALPHA_ENDS, 3, bend_in=(0, 0, bend))
    return replace(VALID.trajectories[0], coefficients=pieces)


PLANTED = {
    "a target that does not exist": (Fault.ASSIGNMENT, 2, to_charlie(3, no_result())),
    "a negative target": (Fault.ASSIGNMENT, 2, to_charlie(-1, no_result())),
    "a target that is no number": (Fault.ASSIGNMENT, 2, to_charlie("target-3", no_result())),
    "a yes for a target": (Fault.ASSIGNMENT, 0, replace(VALID, assignment=(True, 0, None))),
    "a target taken twice": (Fault.ASSIGNMENT, 2, to_charlie(0, no_result())),
    "a target without a result": (Fault.ASSIGNMENT, 2, with_a_third_target(to_charlie(2, None))),
    "a result without a target": (Fault.ASSIGNMENT, 2, to_charlie(None, no_result())),
    "a trajectory without a target": (Fault.ASSIGNMENT, 2, to_charlie(None, None, HOVER)),
    "a result that is none": (Fault.ASSIGNMENT, 2, with_a_third_target(to_charlie(2, {"status": "complete"}))),
    "a trajectory that is none": (Fault.ASSIGNMENT, 2, with_a_third_target(to_charlie(2, no_result(), [1, 2]))),
    "a start in bounds said to be out": (Fault.STATUS, 0, grounded(resulting(no_result(Status.START_OUT_OF_BOUNDS)))),
    "a target in bounds said to be out": (Fault.STATUS, 0, grounded(resulting(no_result(Status.TARGET_OUT_OF_BOUNDS)))),
    "left out without an interruption": (Fault.STATUS, 0, grounded(resulting(no_result(Status.NOT_PLANNED)))),
    "a complete path that ends short": (Fault.STATUS, 0, walking(SHORT, 10, 0.0, 80.0)),
    "an incomplete path that arrives": (Fault.STATUS, 0, grounded(alpha(status=Status.INCOMPLETE))),
    "no path, and yet one": (Fault.STATUS, 0, grounded(resulting(replace(no_result(), path=STRAIGHT)))),
    "a status that is none": (Fault.STATUS, 0, alpha(status="complete")),
    "an empty path": (Fault.PATH_SHAPE, 0, alpha(path=np.zeros((0, 3)))),
    "a flat path": (Fault.PATH_SHAPE, 0, alpha(path=STRAIGHT[:, :2])),
    "a path with a hole": (Fault.PATH_SHAPE, 0, alpha(path=np.where(STRAIGHT == 5, np.nan, STRAIGHT))),
    "a path out of bounds": (
        Fault.PATH_BOUNDS,
        0,
        walking(row((0, 4, 1), ("x", -1), ("x", 10), ("z", 1)), 13, 0.3),
    ),
    "a path into a grown box": (
        Fault.PATH_CLEARANCE,
        0,
        walking(row((0, 4, 1), ("x", 4), ("y", -1), ("y", 1), ("x", 5), ("z", 1)), 13, 0.3 * 3),
    ),
    "a path from another node": (Fault.PATH_ENDS, 0, alpha(start=np.array([1.0, 4, 1]))),
    "a start node beyond the cell": (
        Fault.PATH_ENDS,
        0,
        walking(row((2, 4, 1), ("x", 7), ("z", 1)), 9, 0.3, start=np.array([2.0, 4, 1])),
    ),
    "a goal node beyond the cell": (
        Fault.PATH_ENDS,
        0,
        walking(row((0, 4, 1), ("x", 9), ("z", 3)), 13, 0.3, goal=np.array([9.0, 4, 4])),
    ),
    "a start node that is none": (Fault.PATH_ENDS, 0, alpha(start=np.array([np.nan, 4, 1]))),
    "a node off the lattice": (
        Fault.PATH_STEP,
        0,
        walking(STRAIGHT + np.eye(11)[3][:, None] * [0, 0, 0.3], 11, 0.3 * 4),
    ),
    "a node left out": (Fault.PATH_STEP, 0, walking(np.delete(STRAIGHT, 3, axis=0), 10, 0.3)),
    "a node twice": (Fault.PATH_STEP, 0, walking(STRAIGHT[[0, 1, 2, 3, 3, *range(4, 11)]], 12, 0.0 + 0.3)),
    "a diagonal": (Fault.PATH_STEP, 0, walking(np.delete(STRAIGHT, 9, axis=0), 10, 0.3)),
    "a wrong cost": (Fault.COST, 0, alpha(cost=11.2, history=no_history())),
    "a cost that is no number": (Fault.COST, 0, alpha(cost=np.nan, history=no_history())),
    "a wrong term": (Fault.COST, 0, alpha(terms={"fuel": 11.3, "divergence": 0.0, "end": 0.0})),
    "a term left out": (Fault.COST, 0, alpha(terms={"fuel": 11.0, "divergence": 0.3})),
    "a term too many": (
        Fault.COST,
        0,
        alpha(terms={"fuel": 11.0, "divergence": 0.3, "end": 0.0, "climb": 0.0}),
    ),
    "a price for no path": (Fault.COST, 0, grounded(resulting(replace(no_result(), cost=12.0)))),
    "a history that rises": (Fault.COST, 0, alpha(history=history(12, 10, 11.3))),
    "a history that ends elsewhere": (Fault.COST, 0, alpha(history=history(13, 12))),
    "a history with a hole": (Fault.COST, 0, alpha(history=history(13, np.nan, 11.3))),
    "a cost below its bound": (Fault.BOUND, 0, alpha(bound=11.31)),
    "an optimum without a bound": (Fault.BOUND, 0, alpha(status=Status.OPTIMAL, bound=None)),
    "an optimum above its bound": (Fault.BOUND, 0, alpha(status=Status.OPTIMAL, bound=11.0)),
    "no trajectory": (Fault.TRAJECTORY_SHAPE, 0, flying(None)),
    "a trajectory without a complete path": (
        Fault.TRAJECTORY_SHAPE,
        0,
        walking(SHORT, 10, 0.0, 80.0, status=Status.INCOMPLETE),
    ),
    "knots that stand still": (Fault.TRAJECTORY_SHAPE, 0, knots(0, 3, 3)),
    "a knot too many": (Fault.TRAJECTORY_SHAPE, 0, knots(0, 3, 6, 9)),
    "a start before the mission's": (Fault.TRAJECTORY_SHAPE, 0, knots(-1, 2, 5)),
    "a polynomial of degree 31": (
        Fault.TRAJECTORY_SHAPE,
        0,
        flying(Trajectory(np.array([0.0, 1]), np.zeros((1, 32, 3)))),
    ),
    "a start in a century": (Fault.TRAJECTORY_SHAPE, 0, knots(3e9, 3e9 + 3, 3e9 + 6)),
    "a coefficient that is no number": (Fault.TRAJECTORY_SHAPE, 0, coefficients((1, 2, 0), np.nan)),
    "a trajectory out of bounds": (
        Fault.TRAJECTORY_BOUNDS,
        0,
        flying(stops([ALPHA, (4, 4.1, 4.2), ALPHA_ENDS], 3.5)),
    ),
    "a trajectory into a grown box": (
        Fault.TRAJECTORY_CLEARANCE,
        0,
        flying(stops([ALPHA, (4.5, 3.2, 1.5), ALPHA_ENDS])),
    ),
    "a trajectory from elsewhere": (
        Fault.TRAJECTORY_ENDS,
        0,
        flying(stops([(0.21, 4.1, 1.2), BEND, ALPHA_ENDS])),
    ),
    "a trajectory to elsewhere": (Fault.TRAJECTORY_ENDS, 0, flying(stops([ALPHA, BEND, (9.29, 4.2, 2.4)]))),
    "a flying start": (
        Fault.TRAJECTORY_ENDS,
        0,
        coefficients(0, quintic(ALPHA, BEND, 3, speed_in=(0.01, 0, 0))),
    ),
    "a rough landing": (
        Fault.TRAJECTORY_ENDS,
        0,
        coefficients(1, quintic(BEND, ALPHA_ENDS, 3, speed_out=(0, 0, -0.01))),
    ),
    "a leap": (Fault.CONTINUITY, 0, coefficients(1, quintic((4.7, 4.16, 1.8), ALPHA_ENDS, 3))),
    "a kick": (Fault.CONTINUITY, 0, coefficients(1, quintic(BEND, ALPHA_ENDS, 3, speed_in=(0.01, 0, 0)))),
    "too fast": (Fault.SPEED, 0, given_uav(0, max_speed=2.8)),
    "too hard": (Fault.ACCELERATION, 0, given_uav(0, max_acceleration=2.5)),
    "a parked UAV in the way": (Fault.SEPARATION, (0, 2), given_uav(2, start=(4.7, 4.15, 2.0))),
    "a larger separation": (Fault.SEPARATION, (0, 2), given_uav(2, separation=8, vertical_separation=2.1)),
    "another above": (Fault.SEPARATION, (0, 2), given_uav(2, start=(4.7, 4.15, 2.75))),
    "starts too close": (Fault.GIVEN, (0, 2), given_uav(2, start=(0.2, 4.1, 0.9))),
    "jerks": (Fault.JERK, 0, given_uav(0, max_jerk=10)),
    "tilts": (Fault.TILT, 0, given_uav(0, max_tilt=10)),
    "too little thrust": (Fault.THRUST, 0, given_uav(0, thrust_to_weight=1.05)),
    "a jolt": (Fault.CONTINUITY, 0, flying(jolting(0.01))),
}
AEROPLANES = {Fault.TURN, Fault.CLIMB, Fault.AIRSPEED}  # and UNDECIDED: in tests/referee/test_certificate.py


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_fault_is_found_alone_and_named(name):
    fault, uavs, mission = PLANTED[name]
    uavs = uavs if isinstance(uavs, tuple) else (uavs,)
    found = check(mission.scenario, mission)
    assert [(violation.fault, violation.uavs) for violation in found] == [(fault, uavs)], found
    message = found[0].message
    assert all(SCENARIO.uavs[uav].name in message for uav in uavs)
    assert message.endswith(".")
    assert "\n" not in message


def test_every_kind_of_fault_is_planted():
    elsewhere = {Fault.SCENARIO, Fault.UNDECIDED, *AEROPLANES}
    assert {fault for fault, _, _ in PLANTED.values()} == set(Fault) - elsewhere


def test_another_scenario_inside_is_a_fault_of_the_mission():
    other = SCENARIO.model_copy(update={"name": "another"})
    (found,) = check(other, VALID)
    assert (found.fault, found.uavs) == (Fault.SCENARIO, ())


@pytest.mark.parametrize("column", ["assignment", "results", "trajectories"])
@pytest.mark.parametrize("change", [lambda values: values[:-1], lambda values: (*values, None)])
def test_a_column_of_wrong_length_is_a_fault_of_the_mission(column, change):
    (found,) = check(SCENARIO, replace(VALID, **{column: change(getattr(VALID, column))}))
    assert (found.fault, found.uavs) == (Fault.ASSIGNMENT, ())
    assert column in found.message


def test_what_is_left_of_a_short_mission_is_still_judged():
    short = replace(VALID, assignment=(1, 0), results=VALID.results[:1], trajectories=())
    faults = [(violation.fault, violation.uavs) for violation in check(SCENARIO, short)]
    assert faults == [(Fault.ASSIGNMENT, ())] * 3 + [(Fault.TRAJECTORY_SHAPE, (0,))]


@pytest.mark.parametrize("status", [s for s in Status if not s.reached and "bounds" not in s.value])
def test_an_unreached_target_is_honest(status):
    if status is Status.INCOMPLETE:
        honest = walking(SHORT, 10, 0.0, 80.0, status=status)
    else:
        honest = replace(resulting(no_result(status)), interrupted=status is Status.NOT_PLANNED)
    assert check(SCENARIO, grounded(honest)) == []


def test_costs_may_be_infinite_before_a_path_is_found():
    never = no_result(history=history(np.inf, np.inf))
    assert check(SCENARIO, grounded(resulting(never))) == []
    assert check(SCENARIO, alpha(history=history(np.inf, 11.3))) == []


def test_a_goal_between_the_nodes_is_none():
    goal = np.array([9.0, 4.5, 2])
    path = [(0, 4, 1), (9, 4, 1), goal]
    mission = in_metres(result(path, 2 * (9 + 1.25**0.5), 1.0))
    assert [(found.fault, found.uavs) for found in check(METRES, mission)] == [(Fault.PATH_ENDS, (0,))]


def test_a_goal_node_out_of_bounds_is_none():
    at_the_ceiling = Target(position=(9.3, 4.2, 4.0))
    scenario = SCENARIO.model_copy(update={"targets": put(SCENARIO.targets, 1, at_the_ceiling)})
    goal = {"goal": np.array([9.0, 4, 5]), "status": Status.INCOMPLETE}
    mission = grounded(walking(STRAIGHT, 11, 0.3, 80.0 * 3, **goal))
    found = check(scenario, replace(mission, scenario=scenario))
    assert [(violation.fault, violation.uavs) for violation in found] == [(Fault.PATH_ENDS, (0,))]


# ---------------------------------------------------------------- costs in metres, any-angle paths

METRES = SCENARIO.model_copy(update={"objective": Objective(fuel=2, divergence=1, end=10, unit="metres")})


def in_metres(alphas):
    bravos = result(VALID.results[1].path, 16, status=Status.OPTIMAL, bound=16)
    return replace(VALID, scenario=METRES, results=(alphas, bravos, None))


def test_an_any_angle_path_in_metres_passes():
    path = [(0, 4, 1), (6, 4, 1), (9, 4, 2)]
    assert check(METRES, in_metres(result(path, 2 * (6 + 10**0.5), 1.0))) == []


def test_an_any_angle_path_cannot_be_called_the_lattices_optimum():
    cost = 2 * (6 + 10**0.5) + 1.0
    path = [(0, 4, 1), (6, 4, 1), (9, 4, 2)]
    named = result(path, cost - 1.0, 1.0, status=Status.OPTIMAL, bound=cost)
    assert [found.fault for found in check(METRES, in_metres(named))] == [Fault.PATH_STEP]


def test_going_straight_on_and_turning_back_are_no_turns():
    path = [(0, 4, 1), (0.1, 4, 1), (0.3, 4, 1), (8.9, 4, 1), (8, 4, 1), (9, 4, 1), (9, 4, 2)]
    assert check(METRES, in_metres(result(path, 2 * (8.9 + 0.9 + 1 + 1), 1.0))) == []


def test_a_diagonal_passes_where_the_lattice_has_26_neighbours():
    free = SCENARIO.model_copy(update={"lattice": Lattice(step=(1, 1, 1), connectivity=26)})
    mission = replace(PLANTED["a diagonal"][2], scenario=free)
    assert check(free, mission) == []


def test_a_path_of_one_node_is_judged_as_a_point():
    at_home = UAV(name="alpha", start=(4, 4, 1))
    scenario = SCENARIO.model_copy(
        update={"uavs": (at_home,), "targets": (Target(position=(4, 4, 1)),), "obstacles": SCENARIO.obstacles}
    )
    stay = Trajectory(np.array([0.0, 1.0]), np.array([[[4.0, 4, 1]]]))
    mission = Mission(scenario, (0,), (result([(4, 4, 1)], 1),), (stay,), (), MADE_BY)
    assert check(scenario, mission) == []
    shut = scenario.model_copy(update={"clearance": 1.1})
    faults = [found.fault for found in check(shut, replace(mission, scenario=shut))]
    assert faults == [Fault.PATH_CLEARANCE, Fault.TRAJECTORY_CLEARANCE]


# ---------------------------------------------------------------- both sides of the tolerance


def through(y):
    """Alpha along the block's grown face, y = 3.25 m."""
    return stops([ALPHA, (2.5, y, 1.5), (6.5, y, 1.5), ALPHA_ENDS])


@pytest.mark.parametrize(("inside", "faults"), [(0, []), (8e-7, []), (1.2e-6, [Fault.TRAJECTORY_CLEARANCE])])
def test_a_trajectory_may_touch_a_grown_box_but_not_enter_it(inside, faults):
    assert [found.fault for found in check(SCENARIO, flying(through(3.25 - inside)))] == faults


@pytest.mark.parametrize(("inside", "faults"), [(0, []), (8e-7, []), (1.2e-6, [Fault.PATH_CLEARANCE])])
def test_a_path_may_touch_a_grown_box_but_not_enter_it(inside, faults):
    y = 3.25 - inside
    path = np.array([(0, 4, 1), (2.5, y, 1), (6.5, y, 1), (9, 4, 2)])
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert [found.fault for found in check(METRES, in_metres(result(path, 2 * length, 2.0)))] == faults


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
    assert [found.fault for found in check(SCENARIO, flying(stops(waypoints)))] == faults


@pytest.mark.parametrize(("apart", "faults"), [(0.5, []), (0.5 - 8e-7, []), (0.5 - 1.2e-6, [Fault.SEPARATION])])
def test_two_uavs_may_be_exactly_the_separation_apart(apart, faults):
    mission = given_uav(2, start=(9.3, 4.2 + apart, 2.4))
    assert [found.fault for found in check(mission.scenario, mission)] == faults


@pytest.mark.parametrize("thickness", [0.01, 1e-5, 1e-7])
def test_a_wall_between_two_nodes_is_seen_however_thin(thickness):
    wall = Box(min=(7.5, 0, 0), max=(7.5 + thickness, 6, 4))
    scenario = SCENARIO.model_copy(update={"obstacles": (*SCENARIO.obstacles, wall), "clearance": 0.0})
    found = check(scenario, replace(VALID, scenario=scenario))
    faults = {(violation.fault, violation.uavs) for violation in found}
    assert faults == {(fault, (uav,)) for fault in (Fault.PATH_CLEARANCE, Fault.TRAJECTORY_CLEARANCE) for uav in (0, 1)}
    assert all("obstacle 2" in violation.message for violation in found)


def test_a_path_may_end_just_before_the_thinnest_wall():
    wall = Box(min=(5, 0, 0), max=(5 + 1e-7, 6, 4))
    boxes = grown_boxes(SCENARIO.model_copy(update={"obstacles": (wall,), "clearance": 0.0}))
    start = np.array([[4.0, 3, 2]])
    assert deepest_in_boxes(boxes, start, np.array([[5 - 2e-7, 3, 2.5]])) is None
    assert deepest_in_boxes(boxes, start, np.array([[5 + 2e-7, 3, 2.5]])) is not None


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


# ---------------------------------------------------------------- what the sentences say


def test_a_clearance_is_told_with_its_numbers():
    (found,) = check(SCENARIO, flying(stops([ALPHA, (4.5, 3.1, 1.5), ALPHA_ENDS])))
    assert found.message == (
        "alpha comes within 0.1 m of obstacle 0 at t = 3 s, position (4.5, 3.1, 1.5); 0.25 m are required."
    )
    assert found.time == pytest.approx(3)
    assert found.position == pytest.approx((4.5, 3.1, 1.5))


def test_a_path_inside_an_obstacle_is_told_its_depth():
    legs = ("x", 4), ("y", -2), ("x", 2), ("y", 2), ("x", 3), ("z", 1)
    (found,) = check(SCENARIO, walking(row((0, 4, 1), *legs), 15, 0.3 * 5))
    assert found.message == (
        "alpha's path is 0.5 m inside obstacle 0 after node 6, position (4.5, 2, 1); 0.25 m are required."
    )
    assert found.position == pytest.approx((4.5, 2, 1))


def test_of_two_obstacles_the_one_entered_deeper_is_told():
    legs = ("x", 4), ("y", -2), ("x", 2), ("y", 2), ("x", 3), ("z", 1)
    for more in (Box(min=(6.9, 3.9, 0), max=(7.1, 4.1, 2)), Box(min=(1.9, 3.9, 0), max=(2.1, 4.1, 2))):
        for boxes in ((more, *SCENARIO.obstacles), (*SCENARIO.obstacles, more)):
            scenario = SCENARIO.model_copy(update={"obstacles": boxes})
            mission = grounded(walking(row((0, 4, 1), *legs), 15, 0.3 * 5))
            found = check(scenario, replace(mission, scenario=scenario))
            assert f"0.5 m inside obstacle {boxes.index(SCENARIO.obstacles[0])} " in found[1].message


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


def test_a_misshapen_trajectory_is_not_held_against_others():
    mission = replace(given_uav(2, start=(0.2, 4.1, 0.9)), trajectories=PLANTED["a knot too many"][2].trajectories)
    assert [found.fault for found in check(mission.scenario, mission)] == [Fault.TRAJECTORY_SHAPE]


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


# ---------------------------------------------------------------- properties

coordinate = st.floats(-1, 5, allow_nan=False).map(lambda value: round(value, 3))
point = st.tuples(coordinate, coordinate, coordinate)
side = st.sampled_from([1e-7, 1e-3, 0.2, 1.0, 3.0])


@settings(max_examples=150, deadline=None)
@given(
    start=point,
    end=point,
    corner=point,
    sides=st.tuples(side, side, side),
    clearance=st.sampled_from([0.0, 0.25]),
)
def test_the_segment_test_agrees_with_dense_sampling(start, end, corner, sides, clearance):
    box = Box(min=corner, max=tuple(np.add(corner, sides)))
    scenario = SCENARIO.model_copy(update={"obstacles": (box,), "clearance": clearance})
    start, end = np.array([start]), np.array([end])
    met = deepest_in_boxes(grown_boxes(scenario), start, end)
    low, high = np.array(box.min) - clearance, np.array(box.max) + clearance
    points = start + np.linspace(0, 1, 4001)[:, None] * (end - start)
    depth = np.minimum(points - low, high - points).min(axis=1).max()
    if depth > 1.001e-6:
        assert met is not None
        assert clearance - met.gap >= depth - 0.05
    if met is not None:
        on_segment = start[0] + met.fraction * (end - start)[0]
        np.testing.assert_allclose(met.position, on_segment, atol=1e-12)
        assert (met.position > low).all()
        assert (met.position < high).all()


junk = st.sampled_from(
    [
        None,
        np.nan,
        -1,
        "x",
        (),
        np.zeros(0),
        np.zeros((0, 3)),
        np.zeros((2, 2)),
        np.full((3, 3), np.nan),
        np.full((2, 3), 1e308),
        np.array([np.inf, 0, 0]),
        np.array([0.0, 1e300]),
        np.array([0.0, np.nan]),
        np.full((1, 6, 3), 1e200),
        np.zeros((1, 0, 3)),
        {"fuel": None},
        ["a", [1]],
    ]
)
result_field = st.sampled_from(["status", "path", "cost", "terms", "bound", "start", "goal", "history"])


@settings(max_examples=60, deadline=None)
@given(
    of_result=st.dictionaries(result_field, junk),
    of_trajectory=st.dictionaries(st.sampled_from(["knots", "coefficients", "form"]), junk),
    history_cost=junk,
    status=st.sampled_from(Status),
    assignment=st.lists(st.one_of(junk, st.integers(-2, 4)), max_size=4),
    whole=st.tuples(junk, junk),
    keep=st.integers(0, 3),
    claims=st.tuples(junk, junk),
)
def test_a_malformed_mission_is_judged_and_never_raises(
    of_result, of_trajectory, history_cost, status, assignment, whole, keep, claims
):
    broken = replace(VALID.results[0], status=status, history=replace(no_history(), cost=history_cost))
    mission = replace(
        VALID,
        assignment=tuple(assignment),
        results=(replace(broken, **of_result), VALID.results[1], whole[0])[:keep],
        trajectories=(replace(VALID.trajectories[0], **of_trajectory), whole[1], VALID.trajectories[1]),
        certificates=claims[0],
        apart=claims[1],
    )
    found = check(SCENARIO, mission)
    assert found
    assert all(isinstance(violation, Violation) and violation.message for violation in found)


@settings(max_examples=80, deadline=None)
@given(field=result_field, value=junk)
def test_junk_in_one_field_of_a_result_is_noticed(field, value):
    if field == "bound" and (value is None or isinstance(value, int)):
        value = 11.31
    assert check(SCENARIO, alpha(**{field: value}))
