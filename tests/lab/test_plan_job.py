"""One run."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from skyverse.lab import plan_job
from studies import ROOM, Instant, Liar, job


def test_a_row_of_one_uav_says_what_planning_it_says():
    stop = sky.MaxPaths(200)
    row = plan_job(job(sky.MVO(), seed=7, scenario=sky.read("map1"), stop=stop))
    result = sky.MVO().plan(sky.Problem(sky.read("map1")), stop=stop, rng=7)
    assert (row.cost, row.bound, row.gap, row.status) == (result.cost, result.bound, result.gap, result.status.value)
    assert (row.fuel, row.divergence, row.end) == tuple(result.terms[t] for t in ("fuel", "divergence", "end"))
    assert row.generated_paths == result.effort.generated_paths == 200
    assert (row.generated_nodes, row.evaluations) == (result.effort.generated_nodes, result.effort.evaluations)
    assert row.iterations == result.history.iteration[-1]
    assert row.history == result.history
    assert (row.success, row.verdict, row.stopped_by, row.settings) == (True, "", "MaxPaths", repr(sky.MVO()))
    for version in (sky.__version__, np.__version__, "Python", "numba"):
        assert version in row.versions


@pytest.mark.parametrize("assignment", ["identity", "path-cost"])
def test_a_row_of_a_fleet_sums_the_mission_up(assignment):
    fleet = sky.read("table-4.8")
    asked = job(sky.MVO(), seed=3, scenario=fleet, stop=sky.MaxPaths(60))
    asked = replace(asked, case=replace(asked.case, assignment=assignment))
    row = plan_job(asked)
    mission = sky.plan_mission(
        fleet,
        sky.MVO(),
        stop=sky.MaxPaths(60),
        rng=3,
        assignment=assignment,
        options=sky.MissionOptions(keep_apart=False),
    )
    results = mission.results
    histories = [result.history.by_iteration() for result in results]
    assert row.cost == mission.cost
    assert row.bound == sum(result.bound for result in results) == {"identity": 732, "path-cost": 538}[assignment]
    assert row.gap == pytest.approx(mission.cost / row.bound - 1)
    assert row.generated_paths == sum(result.effort.generated_paths for result in results)
    assert row.history.cost[0] == sum(history.cost[0] for history in histories)
    assert row.history.cost[-1] == mission.cost
    assert row.history.generated_paths[-1] == row.generated_paths
    assert len(row.history.cost) == max(len(history.cost) for history in histories)
    middle = min(len(history.cost) for history in histories)  # a UAV that is done keeps its last row
    at = [history.evaluations[min(middle, len(history.cost) - 1)] for history in histories]
    assert row.history.evaluations[min(middle, len(row.history.cost) - 1)] == sum(at)


def test_a_run_that_reaches_nothing_is_no_success_and_has_no_gap():
    walled = ROOM.model_copy(update={"obstacles": (sky.Box(min=(1.8, 0, 0), max=(2.2, 4, 4)),)})
    row = plan_job(job(scenario=walled))
    assert (row.success, row.status, row.cost, row.gap, row.bound) == (False, "no path", np.inf, None, None)
    assert len(row.history.cost) == 0
    assert row.verdict == ""


def test_the_worst_status_of_a_fleet_counts_and_uavs_without_a_target_do_not():
    uavs = (sky.UAV(start=(0, 0, 0)), sky.UAV(start=(9, 0, 0)), sky.UAV(start=(1, 0, 0)))
    targets = (sky.Target(position=(4, 4, 4)), sky.Target(position=(4, 4, 0)))
    fleet = ROOM.model_copy(update={"uavs": uavs, "targets": targets})
    asked = job(sky.AStar(), scenario=fleet)
    row = plan_job(replace(asked, case=replace(asked.case, assignment="identity")))
    assert (row.status, row.success) == ("start out of bounds", False)
    assert row.cost == np.inf
    assert row.fuel == 13.0
    row = plan_job(asked)  # by path costs the one that can goes
    assert (row.status, row.success, row.cost) == ("optimal", True, 13.0 + 8.0)


def test_the_referee_judges_every_run():
    row = plan_job(job(Liar()))
    assert "but its path makes" in row.verdict
    assert plan_job(job(Instant())).verdict == ""


def test_seconds_become_paths_and_stay_near_the_clock(monkeypatch):
    ticks = itertools.count()
    monkeypatch.setattr("time.perf_counter", lambda: next(ticks) * 1e-3)  # a clock that no other process delays
    seconds = 0.1
    for planner in (sky.MVO(), sky.RandomRestart()):
        asked = job(planner, scenario=sky.read("map1"), stop=sky.MaxSeconds(seconds), budget="0.1 seconds")
        row = plan_job(asked)
        assert row.generated_paths > 100
        assert row.seconds < 2 * seconds  # an iteration may go on after the clock
        assert row.iterations > 1
        assert "MaxPaths" in row.stopped_by or "MaxSeconds" in row.stopped_by


def test_an_exact_planner_needs_no_budget():
    row = plan_job(job(sky.AStar(), scenario=sky.read("map1"), stop=sky.MaxSeconds(0.1)))
    assert (row.cost, row.gap, row.stopped_by) == (265, 0, "finished")


def test_check_result_judges_one_result_alone(refuses):
    scenario = sky.read("map1")
    result = sky.AStar().plan(sky.Problem(scenario))
    assert sky.check_result(scenario, 0, 0, result) == []
    moved = result.path.copy()
    moved[9, 0] += 0.05
    faults = {v.fault for v in sky.check_result(scenario, 0, 0, replace(result, path=moved))}
    assert sky.Fault.PATH_STEP in faults
    assert sky.Fault.TRAJECTORY_SHAPE not in faults
    unfinished = replace(result, status=sky.Status.NO_PATH)
    assert sky.Fault.STATUS in {v.fault for v in sky.check_result(scenario, 0, 0, unfinished)}
    with refuses():
        sky.check_result(scenario, 0, 3, result)


def test_a_planner_that_returns_no_result_is_refused(refuses):
    class Silent(sky.Taut):
        def plan(self, problem, *, stop=None, rng=None):
            return None

    with refuses():
        plan_job(job(Silent(), seed=0))
