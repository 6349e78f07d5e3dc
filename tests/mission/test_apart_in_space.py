"""Missions whose paths are to be apart in space are judged again after what resolves the conflicts that are left."""

from dataclasses import replace

import pytest

import skyverse as sky
from skyverse.deconfliction.find_conflicts import find_conflicts
from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.mission.plan_mission import _apart_in_space
from skyverse.model.verdict import Action
from skyverse.problem import Airspace
from skyverse.trajectory import fly_along

DELAY = Action(1, "delay", "uav-2 departs 30 s later.")


@pytest.fixture(scope="module")
def crossing():
    """A mission of two UAVs whose paths cross, in a room that is high enough for one to fly over the other."""
    scenario = sky.Scenario(
        name="crossing",
        bounds=sky.Bounds(min=(0, 0, 0), max=(40, 40, 12)),
        objective=sky.Objective(unit="metres"),
        clearance=0.1,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
        uavs=[{"start": (20, 1, 2), "separation": 1.0}, {"start": (1, 20, 2), "separation": 1.0}],
        targets=[{"position": (20, 39, 2)}, {"position": (39, 20, 2)}],
    )
    return sky.plan_mission(scenario, sky.Taut(), assignment="identity", options=sky.MissionOptions(keep_apart=False))


def leads_back(asked):
    """Return a function that resolves conflicts as asked, but for the first time by the path that crosses, later."""
    called = []

    def resolve(mission):
        called.append(mission)
        if len(called) > 1:
            return mission
        flight = asked.trajectories[1]
        later = flight.retimed(flight.start + 30.0, 1.0)
        back = replace(
            mission,
            results=(mission.results[0], replace(asked.results[1])),
            trajectories=(mission.trajectories[0], later),
        )
        record = sky.plan_mission(asked.scenario, sky.Taut(), assignment="identity").deconfliction
        return replace(back, deconfliction=replace(record, actions=(DELAY,)))

    return resolve


def test_a_path_that_a_resolved_conflict_leads_near_another_is_led_around_again(crossing):
    mission = _apart_in_space(Airspace(crossing.scenario), crossing, fly_along, leads_back(crossing))
    assert apart_by_timing_only(mission) == []
    assert find_conflicts(mission.scenario, mission.trajectories) == ()


def test_what_was_done_to_a_flight_that_is_planned_anew_is_not_told(crossing):
    mission = _apart_in_space(Airspace(crossing.scenario), crossing, fly_along, leads_back(crossing))
    record = mission.deconfliction
    assert DELAY not in record.actions
    assert {(action.uav, action.kind) for action in record.actions} == {(1, "detour")}
    assert record.found == find_conflicts(crossing.scenario, crossing.trajectories) != ()
    assert record.left == ()
    assert (record.total_before, record.makespan_before) == (crossing.total_time, crossing.makespan)
    assert (record.total_after, record.makespan_after) == (mission.total_time, mission.makespan)


def test_what_was_changed_is_told_also_where_resolving_leaves_no_record(crossing):
    mission = _apart_in_space(Airspace(crossing.scenario), crossing, fly_along, lambda mission: mission)
    assert [action.kind for action in mission.deconfliction.actions] == ["detour"]
    assert mission.deconfliction.found
