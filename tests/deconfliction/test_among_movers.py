"""Flights depart when movers and zones let them pass, as brute force has it, or lead around them; and are proven."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from handmade import hall
from movers import depth_at, movers, points, timed
from skyverse.deconfliction import STAY, TICK, TimedCurve, clear_departure, free_departures, make_curves, meets_movers
from skyverse.model.shapes import active_spans
from skyverse.model.timed_shapes import STANDING, TimedShape
from skyverse.space.timed_shapes import moving_shapes
from temporary_zones import depth_while_active, zones

KEPT, STEP = 0.5, 0.01
LATEST = 25.0
BALL = sky.Sphere(centre=(0, 0, 0), radius=0.5)


def straight(a, b, seconds):
    """From a to b at one speed."""
    return sky.Trajectory(np.array([0.0, seconds]), np.array([[a, np.subtract(b, a) / seconds]]))


def first_departure_is_that_of_samples(flown, shapes, depths, edges, scale):
    """Check the first clear departure against the depths, metres, that a flight has in movers at instants."""
    curves, free = make_curves([flown]), free_departures(LATEST)

    def depth(departure):
        arrival = departure + scale * flown.end
        instants = np.unique([*np.arange(0, arrival + STAY, STEP), *(t for t in edges if 0 <= t <= arrival + STAY)])
        places = flown.at(np.clip((instants - departure) / scale, 0, flown.end)).position
        return max(deep(instants, places).max() for deep in depths)

    first = clear_departure(shapes, curves, 0, scale, 0.0, 0, free)
    if first < len(free) - 1:
        assert depth(first * TICK) <= 1e-9
        assert (meets_movers(shapes, curves, TimedCurve(0, first * TICK, scale), 0.0) == np.inf).all()
    rate = STEP * (shapes.rate.max() + np.linalg.norm(flown.coefficients[0, 1])) + 1e-5
    for k in range(0, min(first, len(free) - 1), 25):  # what was passed over is too near, as far as samples can tell
        assert depth(k * TICK) > -rate


SLOWED = st.sampled_from([1.0, 1.4])


@given(st.lists(movers, min_size=1, max_size=3), points, points, st.floats(2, 8), SLOWED)
@settings(max_examples=25, deadline=None)
def test_the_first_departure_that_movers_leave_clear_is_that_of_dense_samples(all_movers, a, b, seconds, scale):
    shapes = moving_shapes(timed(all_movers, KEPT), sky.TrackingError())
    depths = [lambda t, places, mover=mover: depth_at(mover, t, places, KEPT) for mover in all_movers]
    first_departure_is_that_of_samples(straight(a, np.add(b, (0.5, 0, 0)), seconds), shapes, depths, (), scale)


@given(st.lists(zones(), min_size=1, max_size=3), points, points, st.floats(2, 8), SLOWED)
@settings(max_examples=25, deadline=None)
def test_the_first_departure_that_zones_leave_clear_is_that_of_dense_samples(given_zones, a, b, seconds, scale):
    parts = [(zone, span) for zone in given_zones for span in active_spans(zone.active)]
    shapes = moving_shapes(
        [TimedShape(zone, STANDING, sky.Doubt(), KEPT, span) for zone, span in parts], sky.TrackingError()
    )
    depths = [lambda t, places, zone=zone: depth_while_active(zone, t, places, KEPT) for zone in given_zones]
    edges = [t for zone in given_zones for span in zone.active for t in span if t is not None]
    flown = straight(a, np.add(b, (0.5, 0, 0)), seconds)
    first_departure_is_that_of_samples(flown, shapes, depths, edges, scale)


def crossing(*all_movers, uavs=((1, 5, 1),), targets=((19, 5, 1),)):
    """A hall that UAVs cross among movers."""
    return hall((20, 10, 2), uavs, targets, step=0.5, movers=all_movers, clearance=0.2)


def proven(scenario, **options):
    """A plan that the referee proves."""
    mission = sky.plan_mission(scenario, **options)
    assert mission.violations == ()
    assert all(one.verdict is sky.Verdict.PROVEN for one in mission.certificates)
    return mission


def test_a_uav_waits_for_a_wall_that_passes_or_flies_slower():
    wall = sky.Cylinder(centre=(0, 0), radius=1, low=-5, high=5)
    free = proven(crossing()).makespan
    passes = sky.WaypointMotion(points=[(10, -3, 1), (10, 13, 1)], times=[free / 2 - 4, free / 2 + 4])
    mission = proven(crossing(sky.Mover(shape=wall, motion=passes)))
    assert free < mission.makespan < 2.5 * free
    assert mission.deconfliction.actions


def test_a_uav_gives_way_to_a_ball_in_its_way():
    stands = sky.Mover(shape=BALL, motion=sky.WaypointMotion(points=[(10, 5, 1)], times=[0]))
    mission = proven(crossing(stands))
    (detour,) = (action for action in mission.deconfliction.actions if action.kind == "detour")
    assert " to avoid mover-1: " in detour.sentence


def test_a_fleet_keeps_clear_of_movers_until_the_last_has_arrived():
    uavs = [sky.UAV(start=(1, 3, 1)), sky.UAV(start=(1, 7, 1), max_speed=0.5)]
    targets = [sky.Target(position=(5, 3, 1)), sky.Target(position=(19, 7, 1))]
    circles = sky.CircularMotion(centre=(5, 5, 1), radius=2, period=50, bearing=0)  # over the first target after 25 s
    scenario = crossing(sky.Mover(shape=BALL, motion=circles, doubt=sky.Doubt(radius=0.1)), uavs=uavs, targets=targets)
    mission = sky.plan_mission(scenario, assignment="identity")
    assert mission.violations == ()
    assert 27 < mission.trajectories[0].end < mission.trajectories[1].end  # it comes when the mover has left


def test_a_flight_that_no_departure_saves_is_told():
    fan = sky.Mover(
        shape=sky.Cylinder(centre=(0, 0), radius=9, low=-5, high=5),
        motion=sky.WaypointMotion(points=[(10, 5, 1)], times=[0]),
    )
    mission = sky.plan_mission(crossing(fan))
    (found,) = mission.violations
    assert "mover 'mover-1'" in found.message


@pytest.mark.parametrize("seed", range(3))
def test_among_ten_movers_on_map_3_every_flight_is_proven(seed):
    proven(sky.random_movers(sky.read("map3"), 10, kind="spinners", speed=1.0, seed=seed))


@pytest.mark.parametrize("radius", [2.0, 5.0])
def test_a_detour_leads_around_a_mover_that_stands_in_the_way(radius):
    ball = sky.Sphere(centre=(0, 0, 0), radius=radius)
    stands = sky.Mover(shape=ball, motion=sky.WaypointMotion(points=[(60, 60, 10)], times=[0]))
    scenario = hall((120, 120, 40), [(5, 60, 10)], [(115, 60, 10)], step=4, clearance=1.0, movers=[stands])
    mission = proven(scenario)
    assert mission.makespan < 1.3 * 110 / 5


def test_a_scenario_with_movers_and_without_uavs_is_planned():
    stands = sky.Mover(shape=BALL, motion=sky.WaypointMotion(points=[(5, 5, 1)], times=[0]))
    nobody = crossing(stands).model_copy(update={"uavs": ()})
    assert sky.plan_mission(nobody).violations == ()


def among_zones(*given_zones, uavs=((1, 10, 1),), targets=((39, 10, 1),)):
    """A hall that UAVs cross through zones."""
    return hall((40, 20, 2), uavs, targets, zones=given_zones, clearance=0.2)


def done(mission):
    return [action.sentence for action in mission.deconfliction.actions]


ACROSS = {"min": (18, -5, -5), "max": (22, 25, 5)}
BESIDE = {"min": (18, 5, -5), "max": (22, 20, 5)}


@pytest.mark.parametrize("active", [[[0, 3]], [[7, None]], [[0, 3], [12, 20]], [[-9, 0.5]]])
def test_a_flight_that_passes_while_a_zone_is_not_active_stays_as_it_is(active):
    mission = proven(among_zones(sky.Box(**ACROSS, active=active)))
    assert done(mission) == []
    assert mission.makespan == proven(among_zones()).makespan


@pytest.mark.parametrize("closes", [9.0, 60.0, 1000.0])
def test_a_flight_waits_until_a_zone_closes_and_then_enters_at_once(closes):
    mission = proven(
        among_zones(sky.Prism(vertices=[(18, -5), (22, -5), (22, 25), (18, 25)], low=-9, high=9, active=[[0, closes]]))
    )
    (said,) = done(mission)
    assert "departs" in said
    flown = mission.trajectories[0]
    entered = np.linspace(closes, closes + 0.2, 2001)
    assert flown.at(closes).position[0, 0] <= 17.8
    assert flown.at(entered).position[:, 0].max() > 17.8, "it could have departed earlier"


def test_a_flight_leads_around_a_zone_where_that_is_faster_than_waiting():
    around = proven(among_zones(sky.Box(**BESIDE, active=[[0, 60]])))
    (said,) = done(around)
    assert said.startswith("uav-1 flies around zone 0 (active from 0 s to 60 s): ")
    always = sky.Scenario(**{**dict(among_zones()), "obstacles": [sky.Box(**BESIDE)]})
    assert around.makespan == pytest.approx(sky.plan_mission(always).makespan, rel=1e-6)
    assert around.results[0].path is not None


def test_zones_that_a_flight_around_others_meets_are_led_around_too():
    second = sky.Box(min=(18, 0, -5), max=(22, 5, 5), active=[[2, 30]])
    last = sky.Box(min=(25, 0, -5), max=(28, 12, 5), active=[[2, 30]])
    mission = proven(among_zones(sky.Box(**{**BESIDE, "max": (22, 14, 5)}, active=[[0, 60]]), second, last))
    (around,) = (said for said in done(mission) if said.startswith("uav-1 flies around zone 0 ("))
    assert " and zone 2 (" in around


def test_a_flight_keeps_a_speed_limit_only_while_it_is_active():
    full = proven(among_zones()).makespan
    assert proven(among_zones(sky.Box(**ACROSS, active=[[0, 2]], max_speed=1.0))).makespan == full
    slow = proven(among_zones(sky.Box(**ACROSS, active=[[0, None]], max_speed=1.0)))
    assert done(slow)[0].startswith("uav-1 keeps the speed limit of zone 0 (active from 0 s on): 38 m in ")
    assert slow.makespan == sky.plan_mission(among_zones(sky.Box(**ACROSS, max_speed=1.0))).makespan
    waits = proven(among_zones(sky.Box(**ACROSS, active=[[0, 5.5]], max_speed=0.1)))
    assert full < waits.makespan < full + 2.0


def test_where_nothing_helps_the_mission_says_so():
    mission = sky.plan_mission(among_zones(sky.Box(**ACROSS, active=[[0, None]])))
    assert mission.certificates[0].verdict is sky.Verdict.REFUTED
    assert "inside zone 0 (active from 0 s on)" in mission.certificates[0].sentence


def test_a_fleet_passes_zones_and_one_another():
    uavs = [sky.UAV(start=(x, y, 1), separation=1.0) for x, y in ((1, 8), (1, 10), (1, 12), (39, 9), (39, 11))]
    targets = [{"position": (40 - uav.start[0], uav.start[1], 1)} for uav in uavs]
    zones_given = [
        sky.Box(**BESIDE, active=[[0, 20]]),
        sky.Box(min=(28, 0, -5), max=(30, 11, 5), active=[[3, 6], [9, 12]]),
    ]
    proven(among_zones(*zones_given, uavs=uavs, targets=targets), assignment="identity")


def test_a_uav_with_a_tracking_error_keeps_away_by_that_too():
    error = sky.TrackingError(horizontal=0.5, vertical=0.3)
    uav = sky.UAV(start=(1, 10, 1), tracking_error=error)
    mission = proven(among_zones(sky.Box(**BESIDE, active=[[0, 60]]), uavs=[uav]))
    path = np.array(mission.results[0].path)
    assert path[:, 1].min() <= 5 - 0.2 - 0.5 + 1e-6
