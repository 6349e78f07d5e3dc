"""A valid mission passes, every planted fault is found alone and named, and nothing malformed raises."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from judged_missions import (
    ALPHA,
    ALPHA_ENDS,
    BEND,
    HOVER,
    SCENARIO,
    SHORT,
    STRAIGHT,
    VALID,
    alpha,
    coefficients,
    flying,
    given_uav,
    grounded,
    knots,
    no_result,
    put,
    quintic,
    resulting,
    row,
    stops,
    walking,
)
from skyverse.model.result import no_history
from skyverse.model.trajectory import Pointing

Fault, Status = sky.Fault, sky.Status


def test_a_valid_mission_passes():
    assert sky.check(SCENARIO, VALID) == []


def test_a_mission_for_nobody_passes():
    nobody = SCENARIO.model_copy(update={"uavs": ()})
    assert sky.check(nobody, replace(VALID, scenario=nobody, assignment=(), results=(), trajectories=())) == []


def to_charlie(target, charlie, trajectory=None):
    return flying(trajectory, 2, resulting(charlie, 2, replace(VALID, assignment=put(VALID.assignment, 2, target))))


def with_a_third_target(mission):
    third = sky.Target(name="target-3", position=(2, 2, 2))
    return replace(mission, scenario=SCENARIO.model_copy(update={"targets": (*SCENARIO.targets, third)}))


def jolting(bend):
    """Alpha's flight, with an acceleration that sets in at the bend."""
    pieces = VALID.trajectories[0].coefficients.copy()
    pieces[1] = quintic(BEND, ALPHA_ENDS, 3, bend_in=(0, 0, bend))
    return replace(VALID.trajectories[0], coefficients=pieces)


WHIRL = Pointing(0.0, np.array([3.0]), np.array([50.0]), 0.01, 0.01)
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
        flying(sky.Trajectory(np.array([0.0, 1]), np.zeros((1, 32, 3)))),
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
    "climbs": (Fault.CLIMB_RATE, 0, given_uav(0, max_climb=0.2)),
    "a whirl": (Fault.YAW, 0, flying(replace(VALID.trajectories[0], pointing=WHIRL))),
    "a jolt": (Fault.CONTINUITY, 0, flying(jolting(0.01))),
}


AEROPLANES = {
    Fault.TURN,
    Fault.CLIMB,
    Fault.AIRSPEED,
}  # and UNDECIDED and DESCENT_RATE: in tests/referee/test_certificate.py


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_fault_is_found_alone_and_named(name):
    fault, uavs, mission = PLANTED[name]
    uavs = uavs if isinstance(uavs, tuple) else (uavs,)
    found = sky.check(mission.scenario, mission)
    assert [(violation.fault, violation.uavs) for violation in found] == [(fault, uavs)], found
    message = found[0].message
    assert all(SCENARIO.uavs[uav].name in message for uav in uavs)
    assert message.endswith(".")
    assert "\n" not in message


def test_every_kind_of_fault_is_planted():
    elsewhere = {Fault.SCENARIO, Fault.UNDECIDED, Fault.DESCENT_RATE, Fault.ZONE_SPEED, *AEROPLANES}
    elsewhere |= {
        Fault.MOVER,
        Fault.ACTIVE_ZONE,
        Fault.BATTERY,
        Fault.VISIT,
        Fault.WIND,
        Fault.STRIP,
    }  # in tests of their own
    assert {fault for fault, _, _ in PLANTED.values()} == set(Fault) - elsewhere


def test_another_scenario_inside_is_a_fault_of_the_mission():
    other = SCENARIO.model_copy(update={"name": "another"})
    (found,) = sky.check(other, VALID)
    assert (found.fault, found.uavs) == (Fault.SCENARIO, ())


@pytest.mark.parametrize("column", ["assignment", "results", "trajectories"])
@pytest.mark.parametrize("change", [lambda values: values[:-1], lambda values: (*values, None)])
def test_a_column_of_wrong_length_is_a_fault_of_the_mission(column, change):
    (found,) = sky.check(SCENARIO, replace(VALID, **{column: change(getattr(VALID, column))}))
    assert (found.fault, found.uavs) == (Fault.ASSIGNMENT, ())
    assert column in found.message


def test_what_is_left_of_a_short_mission_is_still_judged():
    short = replace(VALID, assignment=(1, 0), results=VALID.results[:1], trajectories=())
    faults = [(violation.fault, violation.uavs) for violation in sky.check(SCENARIO, short)]
    assert faults == [(Fault.ASSIGNMENT, ())] * 3 + [(Fault.TRAJECTORY_SHAPE, (0,))]


@pytest.mark.parametrize("status", [s for s in Status if not s.reached and "bounds" not in s.value])
def test_a_result_that_says_it_did_not_arrive_is_no_fault(status):
    if status is Status.INCOMPLETE:
        honest = walking(SHORT, 10, 0.0, 80.0, status=status)
    else:
        honest = replace(resulting(no_result(status)), interrupted=status is Status.NOT_PLANNED)
    assert sky.check(SCENARIO, grounded(honest)) == []


def test_a_diagonal_passes_where_the_lattice_has_26_neighbours():
    free = SCENARIO.model_copy(update={"lattice": sky.Lattice(step=(1, 1, 1), connectivity=26)})
    mission = replace(PLANTED["a diagonal"][2], scenario=free)
    assert sky.check(free, mission) == []


@pytest.mark.parametrize("thickness", [0.01, 1e-5, 1e-7])
def test_a_wall_between_two_nodes_is_seen_however_thin(thickness):
    wall = sky.Box(min=(7.5, 0, 0), max=(7.5 + thickness, 6, 4))
    scenario = SCENARIO.model_copy(update={"obstacles": (*SCENARIO.obstacles, wall), "clearance": 0.001})
    found = sky.check(scenario, replace(VALID, scenario=scenario))
    faults = {(violation.fault, violation.uavs) for violation in found}
    assert faults == {(fault, (uav,)) for fault in (Fault.PATH_CLEARANCE, Fault.TRAJECTORY_CLEARANCE) for uav in (0, 1)}
    assert all("obstacle 2" in violation.message for violation in found)


def test_a_misshapen_trajectory_is_not_held_against_others():
    mission = replace(given_uav(2, start=(0.2, 4.1, 0.9)), trajectories=PLANTED["a knot too many"][2].trajectories)
    assert [found.fault for found in sky.check(mission.scenario, mission)] == [Fault.TRAJECTORY_SHAPE]


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


result_field = st.sampled_from(["status", "path", "start", "goal"])


@settings(max_examples=60, deadline=None)
@given(
    of_result=st.dictionaries(result_field, junk),
    of_trajectory=st.dictionaries(st.sampled_from(["knots", "coefficients", "form", "pointing"]), junk),
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
    found = sky.check(SCENARIO, mission)
    assert found
    assert all(isinstance(violation, sky.Violation) and violation.message for violation in found)


@settings(max_examples=80, deadline=None)
@given(field=result_field, value=junk)
def test_junk_in_one_field_of_a_result_is_noticed(field, value):
    assert sky.check(SCENARIO, alpha(**{field: value}))
