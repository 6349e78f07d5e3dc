"""Missions of UAVs that stray from their nominal flights: planned, proven, and clear wherever they stray to."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from handmade import hall

ERROR = sky.TrackingError(horizontal=1.0, vertical=1.5)
WALL = sky.Box(min=(9, 0, 0), max=(10, 8, 9))


def scenario(error=ERROR, **changes):
    given = {
        "obstacles": (WALL, sky.Cylinder(centre=(14, 4), radius=1, low=0, high=4)),
        "uavs": ({"start": (3, 4, 0.5), "tracking_error": error},),
        "targets": ({"position": (14, 4, 4.6)},),
        "clearance": 0.5,
    }
    return hall((20, 12, 12), **(given | changes))


PLANNERS = {
    "astar": (sky.AStar(), None),
    "theta-star": (sky.ThetaStar(), None),
    "taut": (sky.Taut(), None),
    "mvo": (sky.MVO(universes=4), sky.MaxIterations(3)),
}


@pytest.mark.parametrize("name", PLANNERS)
def test_every_planner_plans_for_the_tube_and_every_flight_within_it_is_clear(name):
    given = scenario()
    planner, stop = PLANNERS[name]
    mission = sky.plan_mission(given, planner, stop=stop, rng=1)
    assert mission.violations == ()
    certificate, flight = mission.certificates[0], mission.trajectories[0]
    assert certificate.verdict is sky.Verdict.PROVEN
    assert certificate.sentence.endswith(
        ", for every flight within 1 m horizontally and 1.5 m vertically of it; only on the pad at its start up to "
        "z = 2.01 m and on that at its target up to z = 6.11 m that error does not count for the ground and roofs "
        "below."
    )
    nominal = flight.at(np.linspace(flight.start, flight.end, 300)).position
    np.testing.assert_allclose(nominal[[0, -1]], [(3, 4, 0.5), (14, 4, 4.6)], atol=1e-9)
    (start, top), (end, down) = ((3, 4), 1.5), ((14, 4), 6.0)
    on_pad = ((nominal[:, :2] == start).all(axis=1) & (nominal[:, 2] < top + 2e-3)) | (
        (np.abs(nominal[:, :2] - end) < 1e-6).all(axis=1) & (nominal[:, 2] < down + 2e-3)
    )
    assert on_pad.any()
    free, turn = nominal[~on_pad], np.linspace(0, 2 * np.pi, 12)
    world = sky.World(given.model_copy(update={"clearance": 0.499}))
    for up in (-1.4999, 0.0, 1.4999):
        for aside, across in zip(0.9999 * np.cos(turn), 0.9999 * np.sin(turn), strict=True):
            assert world.free(free + np.array([aside, across, up])).all()


def test_beside_its_pad_a_uav_keeps_its_error_from_everything():
    given = scenario()
    mission = sky.plan_mission(given, sky.Taut())
    flight = mission.trajectories[0]
    rows = flight.coefficients.copy()
    rows[0, 3, 0] += 0.6 / (flight.knots[1] - flight.knots[0]) ** 3  # leaves the pad
    strayed = replace(mission, trajectories=(replace(flight, coefficients=rows),))
    assert sky.Fault.TRAJECTORY_BOUNDS in {violation.fault for violation in sky.check(given, strayed)}


def test_uavs_with_the_same_error_share_one_airspace_and_those_without_have_that_of_the_scenario():
    uavs = tuple({"start": (3, 4, 0.5), "tracking_error": error} for error in (ERROR, sky.TrackingError(), ERROR))
    airspace = sky.Airspace(scenario(uavs=uavs))
    assert airspace.of(1) is airspace
    assert airspace.of(0) is airspace.of(2) is not airspace


def test_a_start_without_room_for_a_pad_is_unsafe():
    roof = sky.Box(min=(1, 2, 3), max=(5, 6, 12))
    shut = scenario(obstacles=(roof,))
    mission = sky.plan_mission(shut, sky.Taut())
    assert mission.results[0].status is sky.Status.START_UNSAFE
    aeroplane = {"fixed_wing": {"speed": 3, "turn_radius": 3, "climb": 30}}
    wing = scenario(uavs=({"start": (3, 4, 0.5), "tracking_error": ERROR} | aeroplane,))
    assert sky.Taut().plan(sky.Problem(wing)).status is sky.Status.START_UNSAFE


@pytest.mark.parametrize(("errors", "apart"), [((0.0, 0.0), True), ((0.7, 0.7), False), ((1.5, 0.0), False)])
def test_uavs_keep_their_separation_and_both_errors(errors, apart):
    uavs = tuple(
        {"start": (2, y, 6), "separation": 1.0, "tracking_error": {"horizontal": error, "vertical": 0.0}}
        for y, error in zip((4, 6), errors, strict=True)
    )
    targets = tuple({"position": (18, y, 6)} for y in (4, 6))
    given = scenario(obstacles=(), uavs=uavs, targets=targets)
    mission = sky.plan_mission(given, sky.Taut(), assignment="identity", options=sky.MissionOptions(keep_apart=False))
    assert (not sky.find_conflicts(given, mission.trajectories)) == apart
    assert (mission.apart.verdict is sky.Verdict.PROVEN) == apart
