"""Paths are led apart in space by the separation and by each tracking error once."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.deconfliction.find_conflicts import semi_axes
from skyverse.deconfliction.paths_apart import PATH_MARGIN, apart_by_timing_only


def crossing(top, error, *, separation=1.0):
    """Two UAVs whose straight paths cross; the first one's reaches from wall to wall, so that one must fly above it."""
    stray = {"separation": separation, "tracking_error": dict(zip(("horizontal", "vertical"), error, strict=True))}
    stray["home"] = -5.0  # far below, so that exported missions climb no higher than these flights
    level = error[1] + 0.2
    return sky.Scenario(
        name="crossing",
        bounds=sky.Bounds(min=(0, 0, 0), max=(40, 8, top)),
        objective=sky.Objective(unit="metres"),
        clearance=0.1,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
        uavs=[
            {"name": "across", "start": (20, 0.6, level), "priority": 1} | stray,
            {"name": "along", "start": (1, 4, level)} | stray,
        ],
        targets=[{"position": (20, 7.4, level)}, {"position": (39, 4, level)}],
    )


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
