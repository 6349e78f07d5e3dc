"""Paths are led apart in space by the separation and by each tracking error once."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from handmade import hall
from skyverse.deconfliction import apart_by_timing_only
from skyverse.deconfliction.find_conflicts import semi_axes
from skyverse.deconfliction.paths_apart import PATH_MARGIN
from skyverse.mission.plan_mission import _apart_in_space


def crossing(top, error, *, separation=1.0):
    """Two UAVs whose straight paths cross; the first one's reaches from wall to wall, so that one must fly above it."""
    stray = {"separation": separation, "tracking_error": dict(zip(("horizontal", "vertical"), error, strict=True))}
    stray["home"] = -5.0  # far below, so that exported missions climb no higher than these flights
    level = error[1] + 0.2
    uavs = [
        {"name": "across", "start": (20, 0.6, level), "priority": 1} | stray,
        {"name": "along", "start": (1, 4, level)} | stray,
    ]
    return hall((40, 8, top), uavs, [(20, 7.4, level), (39, 4, level)], clearance=0.1)


def nearness(scenario, mission):
    """How near any place of one flight is to any of the other, as a share of what the two must keep."""
    curves = [flight.at(np.linspace(flight.start, flight.end, 1500)).position for flight in mission.trajectories]
    gap = curves[0][:, None] - curves[1]
    xy, z = semi_axes(scenario)
    return float(np.sqrt((gap[..., 0] ** 2 + gap[..., 1] ** 2) / xy[0, 1] ** 2 + gap[..., 2] ** 2 / z[0, 1] ** 2).min())


def planned(scenario):
    return sky.plan_mission(
        scenario, sky.Taut(), assignment="identity", options=sky.MissionOptions(apart_in_space=True)
    )


@pytest.mark.parametrize("error", [(0.0, 0.0), (0.5, 1.0)])
def test_a_uav_is_led_over_another_where_separation_and_both_errors_fit(error):
    # the other one's level, what both keep over it, a margin, and below the top the UAV's own error
    kept = 2.0 * (1 + np.hypot(2 * error[0] / 1.0, 2 * error[1] / 2.0))
    top = error[1] + 0.2 + kept + 2.2 * PATH_MARGIN + error[1]
    scenario = crossing(top, error)
    mission = planned(scenario)
    assert [action.uav for action in mission.deconfliction.actions] == [1]
    assert mission.violations == ()
    assert nearness(scenario, mission) >= 1.0


def test_a_detour_with_errors_is_that_of_a_separation_that_is_larger_by_both():
    error = (0.5, 1.0)
    astray, wider = crossing(20, error), crossing(20, (0.0, 0.0), separation=1 + np.hypot(1, 1))
    start = [(uav.start[0], uav.start[1], 3.0) for uav in astray.uavs]
    targets = [sky.Target(position=(*target.position[:2], 3.0)) for target in astray.targets]
    heights = []
    for scenario in (astray, wider):
        uavs = [uav.model_copy(update={"start": place}) for uav, place in zip(scenario.uavs, start, strict=True)]
        level = scenario.model_copy(update={"uavs": tuple(uavs), "targets": tuple(targets)})
        heights.append(planned(level).trajectories[1].at(np.linspace(0, 100, 3000)).position[:, 2].max())
    assert heights[0] == pytest.approx(heights[1], abs=0.2)


def test_pairs_that_are_apart_by_timing_only_are_named():
    scenario = crossing(20, (0.5, 1.0))
    timed = sky.plan_mission(scenario, sky.Taut(), assignment="identity")
    assert timed.violations == ()
    assert apart_by_timing_only(timed) == [(0, 1)]
    assert apart_by_timing_only(planned(scenario)) == []


def test_the_price_of_a_detour_and_its_history_contain_the_columns_once():
    stray = {"separation": 2.0, "tracking_error": {"horizontal": 1.0, "vertical": 2.0}}
    scenario = sky.Scenario(
        name="on the ground",
        bounds=sky.Bounds(min=(0, 0, 0), max=(60, 60, 50)),
        objective=sky.Objective(unit="metres"),
        clearance=0.5,
        lattice=sky.Lattice(step=(2, 2, 2), connectivity=26),
        uavs=[{"start": (30, 5, 0.5)} | stray, {"start": (5, 30, 0.5)} | stray],
        targets=[{"position": (30, 55, 0.5)}, {"position": (55, 30, 0.5)}],
    )
    mission = planned(scenario)
    assert [action.kind for action in mission.deconfliction.actions] == ["detour"]
    assert mission.violations == ()
    assert mission.results[1].history.cost[-1] == pytest.approx(mission.results[1].cost)


DELAY = sky.Action(1, "delay", "uav-2 departs 30 s later.")


@pytest.fixture(scope="module")
def crossed():
    """A mission of two UAVs whose paths cross, in a room that is high enough for one to fly over the other."""
    uavs = [{"start": start, "separation": 1.0} for start in ((20, 1, 2), (1, 20, 2))]
    scenario = hall((40, 40, 12), uavs, [(20, 39, 2), (39, 20, 2)], clearance=0.1)
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


def test_a_path_that_a_resolved_conflict_leads_near_another_is_led_around_again(crossed):
    mission = _apart_in_space(sky.Airspace(crossed.scenario), crossed, sky.fly_along, leads_back(crossed))
    assert apart_by_timing_only(mission) == []
    assert sky.find_conflicts(mission.scenario, mission.trajectories) == ()


def test_what_was_done_to_a_flight_that_is_planned_anew_is_not_told(crossed):
    mission = _apart_in_space(sky.Airspace(crossed.scenario), crossed, sky.fly_along, leads_back(crossed))
    record = mission.deconfliction
    assert DELAY not in record.actions
    assert {(action.uav, action.kind) for action in record.actions} == {(1, "detour")}
    assert record.found == sky.find_conflicts(crossed.scenario, crossed.trajectories) != ()
    assert record.left == ()
    assert (record.total_before, record.makespan_before) == (crossed.total_time, crossed.makespan)
    assert (record.total_after, record.makespan_after) == (mission.total_time, mission.makespan)


def test_what_was_changed_is_told_also_where_resolving_leaves_no_record(crossed):
    mission = _apart_in_space(sky.Airspace(crossed.scenario), crossed, sky.fly_along, lambda mission: mission)
    assert [action.kind for action in mission.deconfliction.actions] == ["detour"]
    assert mission.deconfliction.found
