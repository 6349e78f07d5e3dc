"""Flights depart when movers let them pass: at the first such instant, as brute force has it; and are proven."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from movers import depth_at, movers, points, timed
from skyverse.deconfliction.among_movers import STAY, clear_departure, meets_movers
from skyverse.deconfliction.curves import TimedCurve, make_curves
from skyverse.deconfliction.forbidden_departures import TICK, free_departures
from skyverse.model.mover import Doubt, Mover
from skyverse.model.mover_motions import CircularMotion, WaypointMotion
from skyverse.model.shapes import Cylinder, Sphere
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Verdict
from skyverse.space.moving_shapes import moving_shapes

KEPT, STEP = 0.5, 0.01
LATEST = 20.0
BALL = Sphere(centre=(0, 0, 0), radius=0.5)


def straight(a, b, seconds):
    """From a to b at one speed."""
    return Trajectory(np.array([0.0, seconds]), np.array([[a, np.subtract(b, a) / seconds]]))


def depth_of(flown, all_movers, departure, scale):
    """How deep in a mover a flight gets that departs at an instant, by dense samples; metres."""
    arrival = departure + scale * flown.end
    instants = np.arange(0, arrival + STAY, STEP)
    places = flown.at(np.clip((instants - departure) / scale, 0, flown.end)).position
    return max(depth_at(mover, instants, places, KEPT).max() for mover in all_movers)


@given(st.lists(movers, min_size=1, max_size=3), points, points, st.floats(2, 8), st.sampled_from([1.0, 1.4]))
@settings(max_examples=25, deadline=None)
def test_the_first_clear_departure_is_that_of_dense_samples(all_movers, a, b, seconds, scale):
    flown = straight(a, np.add(b, (0.5, 0, 0)), seconds)
    curves, free = make_curves([flown]), free_departures(LATEST)
    shapes = moving_shapes(timed(all_movers, KEPT), TrackingError())
    first = clear_departure(shapes, curves, 0, scale, 0.0, 0, free)
    if first < len(free) - 1:
        assert depth_of(flown, all_movers, first * TICK, scale) <= 0
        assert (meets_movers(shapes, curves, TimedCurve(0, first * TICK, scale), 0.0) == np.inf).all()
    rate = STEP * (shapes.rate.max() + np.linalg.norm(np.subtract(flown.at(seconds).position[0], a)) / seconds)
    for k in range(0, min(first, 1000), 25):  # what was passed over is too near, as far as samples can tell
        assert depth_of(flown, all_movers, k * TICK, scale) > -rate


def crossing(*all_movers, clearance=0.2, uavs=None, targets=None):
    """A hall that UAVs cross among movers."""
    return sky.Scenario(
        name="crossing",
        bounds=sky.Bounds(min=(0, 0, 0), max=(20, 10, 2)),
        clearance=clearance,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=26),
        objective=sky.Objective(unit="metres"),
        movers=all_movers,
        uavs=uavs or [sky.UAV(start=(1, 5, 1))],
        targets=targets or [sky.Target(position=(19, 5, 1))],
    )


def proven(scenario):
    """A plan that the referee proves."""
    mission = sky.plan_mission(scenario)
    assert mission.violations == ()
    assert all(one.verdict is Verdict.PROVEN for one in mission.certificates)
    return mission


def test_a_uav_waits_for_a_wall_that_passes_or_flies_slower():
    wall = Cylinder(centre=(0, 0), radius=1, low=-5, high=5)
    free = proven(crossing()).makespan
    passes = WaypointMotion(points=[(10, -3, 1), (10, 13, 1)], times=[free / 2 - 4, free / 2 + 4])
    mission = proven(crossing(Mover(shape=wall, motion=passes)))
    assert free < mission.makespan < 2.5 * free
    assert mission.deconfliction.actions


def test_a_uav_gives_way_to_a_ball_in_its_way():
    stands = Mover(shape=BALL, motion=WaypointMotion(points=[(10, 5, 1)], times=[0]))
    mission = proven(crossing(stands))
    (detour,) = (action for action in mission.deconfliction.actions if action.kind == "detour")
    assert " to avoid mover-1: " in detour.sentence


def test_a_fleet_keeps_clear_of_movers_until_the_last_has_arrived():
    uavs = [sky.UAV(start=(1, 3, 1)), sky.UAV(start=(1, 7, 1), max_speed=0.5)]
    targets = [sky.Target(position=(5, 3, 1)), sky.Target(position=(19, 7, 1))]
    circles = CircularMotion(centre=(5, 5, 1), radius=2, period=50, bearing=0)  # over the first target after 25 s
    scenario = crossing(Mover(shape=BALL, motion=circles, doubt=Doubt(radius=0.1)), uavs=uavs, targets=targets)
    mission = sky.plan_mission(scenario, assignment="identity")
    assert mission.violations == ()
    assert 27 < mission.trajectories[0].end < mission.trajectories[1].end  # it comes when the mover has left


def test_a_flight_that_no_departure_saves_is_told():
    fan = Mover(
        shape=Cylinder(centre=(0, 0), radius=9, low=-5, high=5), motion=WaypointMotion(points=[(10, 5, 1)], times=[0])
    )
    mission = sky.plan_mission(crossing(fan))
    (found,) = mission.violations
    assert "mover 'mover-1'" in found.message


@pytest.mark.parametrize("seed", range(5))
def test_among_ten_movers_on_map_3_every_flight_is_proven(seed):
    rng = np.random.default_rng(seed)
    scenario = sky.read("map3")
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    ten = [
        Mover(
            shape=Sphere(centre=(0, 0, 0), radius=0.4),
            motion=CircularMotion(
                centre=tuple(rng.uniform(low + 3, high - (3, 3, 0))),
                radius=float(rng.uniform(1, 3)),
                period=float(rng.uniform(6, 20)),
                bearing=float(rng.uniform(0, 360)),
            ),
        )
        for _ in range(10)
    ]
    proven(sky.Scenario(**{**dict(scenario), "movers": ten}))


@pytest.mark.parametrize("radius", [2.0, 5.0])
def test_a_detour_leads_around_a_mover_that_stands_in_the_way(radius):
    ball = Sphere(centre=(0, 0, 0), radius=radius)
    stands = Mover(shape=ball, motion=WaypointMotion(points=[(60, 60, 10)], times=[0]))
    scenario = sky.Scenario(
        name="open",
        bounds=sky.Bounds(min=(0, 0, 0), max=(120, 120, 40)),
        clearance=1.0,
        lattice=sky.Lattice(step=(4, 4, 4), connectivity=26),
        objective=sky.Objective(unit="metres"),
        movers=(stands,),
        uavs=(sky.UAV(start=(5, 60, 10)),),
        targets=(sky.Target(position=(115, 60, 10)),),
    )
    mission = proven(scenario)
    assert mission.makespan < 1.3 * 110 / 5


def test_a_scenario_with_movers_and_without_uavs_is_planned():
    stands = Mover(shape=BALL, motion=WaypointMotion(points=[(5, 5, 1)], times=[0]))
    nobody = crossing(stands).model_copy(update={"uavs": ()})
    assert sky.plan_mission(nobody).violations == ()
