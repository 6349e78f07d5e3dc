"""Missions of fleets, against the thesis's totals and the referee."""

import dataclasses
import itertools
import multiprocessing
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.mission.assignment import assign_targets, cost_matrix
from worlds import ROOM, scenarios

TOTALS = {  # nodes without coordination, with Munkres on straight lines, and on exact path costs
    "table-4.8": (732, 540, 538),
    "table-4.9-4": (469, 377, 377),
    "table-4.9-3": (328, 312, 310),
    "table-4.9-2": (240, 240, 238),
    "table-4.11": (967, 967, 967),
    "table-4.12": (533, 465, 463),
    "table-4.13": (1041, 1037, 1037),
}
ASSIGNMENTS = ("identity", "euclidean", "path-cost")
PATHS = sky.MissionOptions(shape="stop-and-go", keep_apart=False)  # where it is about paths


@pytest.mark.parametrize("fleet", TOTALS)
@pytest.mark.parametrize(("which", "assignment"), list(enumerate(ASSIGNMENTS)))
def test_every_fleet_of_the_thesis_has_its_known_total(fleet, which, assignment):
    mission = sky.plan_mission(sky.read(fleet), sky.AStar(), assignment=assignment, options=PATHS)
    assert mission.cost == TOTALS[fleet][which]
    assert mission.complete
    assert {v.fault for v in mission.violations} <= {sky.Fault.SEPARATION}
    if fleet == "table-4.8":
        assert max(result.cost for result in mission.results) == (201, 168, 244)[which]
    if assignment == "identity":
        assert mission.assignment == tuple(range(len(mission.scenario.uavs)))


def test_the_smallest_longest_path_of_table_4_8_is_146():
    scenario = sky.read("table-4.8")
    mission = sky.plan_mission(scenario, sky.AStar(), options=dataclasses.replace(PATHS, criterion="min-max"))
    assert max(result.cost for result in mission.results) == 146
    # of all assignments with that maximum it has the smallest sum
    costs = cost_matrix(sky.Airspace(scenario), "path-cost")
    by_hand = [[costs[i, j] for i, j in enumerate(p)] for p in itertools.permutations(range(5))]
    assert min(map(max, by_hand)) == 146
    assert mission.cost == min(sum(row) for row in by_hand if max(row) == 146)


SIDE = [(0.6, 0.6, 1.1), (0.6, 2.1, 1.1), (0.6, 3.6, 1.1), (0.6, 0.6, 3.1)]
OTHER = [(5.7, 4.4, 1.0), (5.7, 2.9, 1.0), (5.7, 1.4, 1.0), (5.7, 4.4, 3.0)]


def fleet(starts, targets, **changes):
    return ROOM.model_copy(
        update={
            "uavs": tuple(sky.UAV(name=f"u{i}", start=p) for i, p in enumerate(starts)),
            "targets": tuple(sky.Target(name=f"t{i}", position=p) for i, p in enumerate(targets)),
            **changes,
        }
    )


@pytest.mark.parametrize("assignment", ASSIGNMENTS)
@pytest.mark.parametrize(("uavs", "targets"), [(4, 2), (2, 4), (1, 3), (3, 1), (0, 2), (2, 0)])
def test_more_uavs_than_targets_and_the_reverse_leave_some_without(assignment, uavs, targets):
    scenario = fleet(SIDE[:uavs], OTHER[:targets])
    mission = sky.plan_mission(scenario, sky.AStar(), assignment=assignment, options=PATHS)
    sent = [j for j in mission.assignment if j is not None]
    if assignment == "path-cost" and 0 < uavs < targets:
        assert sorted(visit.target for own in mission.sorties for one in own for visit in one.visits) == [
            *range(targets)
        ]
        assert mission.complete
        return
    assert len(mission.assignment) == len(mission.results) == len(mission.trajectories) == uavs
    assert len(set(sent)) == len(sent) == min(uavs, targets)
    for target, result, trajectory in zip(mission.assignment, mission.results, mission.trajectories, strict=True):
        assert (target is None) == (result is None) == (trajectory is None)
    assert mission.complete
    if assignment == "path-cost" and sent:
        costs = cost_matrix(sky.Airspace(scenario), "path-cost")
        small = costs if uavs <= targets else costs.T
        choices = itertools.permutations(range(max(uavs, targets)), min(uavs, targets))
        assert mission.cost == min(sum(small[i, j] for i, j in enumerate(p)) for p in choices)


def test_no_pair_is_priced_where_there_is_nothing_to_choose(monkeypatch, refuses):
    monkeypatch.setattr("skyverse.mission.assignment.prices_to", lambda *_: pytest.fail("a pair was priced"))
    assert assign_targets(sky.Airspace(fleet(SIDE[:1], OTHER[:1]))) == (0,)
    with refuses():
        assign_targets(sky.Airspace(fleet(SIDE[:1], OTHER[:1])), criterion="least")


def test_the_matrix_holds_what_each_pair_of_problems_costs():
    scenario = fleet([*SIDE[:3], (2.5, 1, 1)], [*OTHER[:2], (4.5, 3, 1), (9, 9, 9)])
    costs = cost_matrix(sky.Airspace(scenario), "path-cost")
    for i, j in itertools.product(range(4), range(4)):
        route = sky.Problem(scenario, i, j).route
        assert costs[i, j] == (np.inf if route is None else route.price)
    straight = cost_matrix(sky.Airspace(scenario), "euclidean")
    assert straight[0, 0] == pytest.approx(np.sqrt(5.1**2 + 3.8**2 + 0.1**2))


def test_a_uav_that_reaches_nothing_still_gets_a_result_that_says_why():
    mission = sky.plan_mission(fleet([(2.5, 1, 1), SIDE[0]], OTHER[:2]), sky.AStar())
    assert sorted(mission.assignment) == [0, 1]
    assert mission.results[0].status is sky.Status.START_UNSAFE
    assert mission.results[1].status is sky.Status.OPTIMAL
    assert not mission.complete
    assert mission.trajectories[0] is None


SMALL = [sky.MVO(universes=4), sky.MVO(universes=4, as_run=True), sky.RandomRestart(samples=4), sky.AStar()]


@given(
    st.integers(0, 4).flatmap(lambda u: st.integers(0, 4).flatmap(lambda t: scenarios(uavs=u, targets=t))),
    st.sampled_from(SMALL),
    st.sampled_from(ASSIGNMENTS),
    st.sampled_from(["min-sum", "min-max"]),
    st.integers(0, 2**32),
)
@settings(max_examples=25)
def test_nothing_that_is_planned_is_ever_refused_by_the_referee(scenario, planner, assignment, criterion, seed):
    stop = sky.MaxIterations(4)
    mission = sky.plan_mission(
        scenario, planner, stop=stop, rng=seed, assignment=assignment, options=sky.MissionOptions(criterion=criterion)
    )
    close = {sky.Fault.SEPARATION, sky.Fault.GIVEN}  # in such little rooms not all can be kept apart, nor hidden
    assert {v.fault for v in mission.violations} <= close
    left, at_fault = mission.deconfliction.left, {v.uavs for v in mission.violations if v.fault is sky.Fault.SEPARATION}
    assert {conflict.uavs for conflict in left} == {v.uavs for v in mission.violations}
    assert {conflict.uavs for conflict in left if not conflict.given} == at_fault
    assert list(mission.violations) == sky.check(scenario, mission)
    for result, trajectory in zip(mission.results, mission.trajectories, strict=True):
        assert (trajectory is not None) == (result is not None and result.status.reached)


@given(scenarios(uavs=3, targets=3, most_nodes=6), st.integers(0, 2**32))
@settings(max_examples=20)
def test_a_seed_gives_one_mission(scenario, seed):
    how = {"stop": sky.MaxIterations(4), "rng": seed, "options": PATHS}
    first, again = (sky.plan_mission(scenario, sky.MVO(universes=4), **how) for _ in range(2))
    assert timeless(first) == timeless(again)


def timeless(mission):
    """The mission without its clock's readings."""
    results = tuple(None if r is None else dataclasses.replace(r, seconds=0.0) for r in mission.results)
    return dataclasses.replace(mission, results=results)


def test_a_seed_gives_the_same_mission_in_a_spawned_process():
    args, kwargs = (
        (fleet(SIDE, OTHER), sky.MVO(universes=5)),
        {"stop": sky.MaxIterations(5), "rng": 11, "options": PATHS},
    )
    here = sky.plan_mission(*args, **kwargs)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = pool.apply(sky.plan_mission, args, kwargs)
    assert timeless(here) == timeless(there)
    assert here.provenance.seed == 11


def test_a_uav_draws_the_same_numbers_whatever_the_others_do():
    """Every UAV has a stream of its own, so a longer plan of the first does not change the second."""
    short, long_ = (
        sky.plan_mission(
            fleet([start, SIDE[1]], OTHER[:2]),
            sky.MVO(universes=5),
            stop=sky.MaxIterations(5),
            rng=3,
            assignment="identity",
            options=PATHS,
        )
        for start in (SIDE[0], SIDE[3])
    )
    assert timeless(short).results[1] == timeless(long_).results[1]
    assert short.results[0] != long_.results[0]


def test_an_interruption_keeps_what_there_is_and_names_the_rest_unplanned():
    event, calls = threading.Event(), []

    def watch(uav, progress):
        calls.append((uav, None if progress is None else progress.iterations))
        if uav == 1 and progress is not None and progress.iterations == 2:
            event.set()

    stop = sky.MaxIterations(5) | sky.Cancelled(event)
    mission = sky.plan_mission(fleet(SIDE, OTHER), sky.MVO(universes=6), stop=stop, rng=2, on_progress=watch)
    assert mission.interrupted
    assert not mission.complete
    assert [r.stopped_by for r in mission.results] == ["MaxIterations", "Cancelled", "refused", "refused"]
    assert [r.status for r in mission.results[2:]] == [sky.Status.NOT_PLANNED] * 2
    assert len(mission.results[1].path)
    assert mission.trajectories[2:] == (None, None)
    assert {v.fault for v in mission.violations} <= {sky.Fault.SEPARATION}
    assert calls == [(0, 1), (0, 2), (0, 3), (0, 4), (0, 5), (0, None), (1, 1), (1, 2), (1, None), (2, None), (3, None)]


def test_an_exact_fleet_can_be_interrupted_between_two_uavs():
    event = threading.Event()

    def watch(uav, progress):
        if uav == 1:
            event.set()

    stop = sky.Cancelled(event)
    mission = sky.plan_mission(fleet(SIDE, OTHER), sky.AStar(), stop=stop, workers=1, on_progress=watch)
    assert mission.interrupted
    assert [r.status.reached for r in mission.results] == [True, True, False, False]


@pytest.mark.parametrize("assignment", ["identity", "path-cost"])
def test_a_fleet_that_is_interrupted_before_it_is_planned_stays_where_it_is(assignment):
    event = threading.Event()
    event.set()
    more = {"stop": sky.Cancelled(event), "workers": 3, "assignment": assignment}
    mission = sky.plan_mission(fleet(SIDE, OTHER), sky.AStar(), **more)
    assert mission.interrupted
    assert mission.trajectories == (None,) * 4
    assert all(r is None or r.status is sky.Status.NOT_PLANNED for r in mission.results)


@pytest.mark.parametrize("planner", [sky.AStar(), sky.Taut(), sky.Cheapest(legs=10_000)])
def test_a_mission_does_not_depend_on_the_number_of_threads(planner):
    scenario, calls = fleet(SIDE, OTHER), []
    alone, many = (
        sky.plan_mission(scenario, planner, workers=workers, on_progress=lambda uav, _: calls.append(uav))
        for workers in (1, 3)
    )
    assert calls == [0, 1, 2, 3] * 2
    assert alone.assignment == many.assignment
    assert timeless(alone).results == timeless(many).results
    for one, other in zip(alone.trajectories, many.trajectories, strict=True):
        np.testing.assert_array_equal(one.coefficients, other.coefficients)


@pytest.mark.parametrize(
    "changes",
    [
        {"assignment": "greedy"},
        {"stop": sky.MaxSeconds(1)},
        {"rng": -3},
        {"workers": 0},
    ],
)
def test_what_cannot_be_asked_of_a_mission_is_refused(refuses, changes):
    with refuses():
        sky.plan_mission(fleet(SIDE, OTHER), sky.MVO(universes=4), **changes)
