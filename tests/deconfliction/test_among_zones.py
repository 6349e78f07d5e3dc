"""Flights pass zones before they open or after they close, lead around them, or keep their limits; and are proven."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from movers import points
from skyverse.deconfliction.among_movers import STAY, clear_departure, meets_movers
from skyverse.deconfliction.curves import TimedCurve, make_curves
from skyverse.deconfliction.forbidden_departures import TICK, free_departures
from skyverse.model.mover import Doubt
from skyverse.model.shapes import active_spans
from skyverse.model.temporary_zones import STANDING, TimedShape
from skyverse.model.verdict import Verdict
from skyverse.space.moving_shapes import moving_shapes
from temporary_zones import depth_while_active, zones

KEPT, STEP = 0.5, 0.01
LATEST = 25.0


def straight(a, b, seconds):
    """From a to b at one speed."""
    return sky.Trajectory(np.array([0.0, seconds]), np.array([[a, np.subtract(b, a) / seconds]]))


def depth_of(flown, given_zones, departure, scale):
    """How deep in an active zone a flight gets that departs at an instant, by dense samples; metres."""
    arrival = departure + scale * flown.end
    edges = [t for zone in given_zones for span in zone.active for t in span if t is not None]
    instants = np.unique([*np.arange(0, arrival + STAY, STEP), *(t for t in edges if 0 <= t <= arrival + STAY)])
    places = flown.at(np.clip((instants - departure) / scale, 0, flown.end)).position
    return max(depth_while_active(zone, instants, places, KEPT).max() for zone in given_zones)


@given(st.lists(zones(), min_size=1, max_size=3), points, points, st.floats(2, 8), st.sampled_from([1.0, 1.4]))
@settings(max_examples=25, deadline=None)
def test_the_first_clear_departure_is_that_of_dense_samples(given_zones, a, b, seconds, scale):
    flown = straight(a, np.add(b, (0.5, 0, 0)), seconds)
    curves, free = make_curves([flown]), free_departures(LATEST)
    timed = [
        TimedShape(zone, STANDING, Doubt(), KEPT, span) for zone in given_zones for span in active_spans(zone.active)
    ]
    shapes = moving_shapes(timed, sky.TrackingError())
    first = clear_departure(shapes, curves, 0, scale, 0.0, 0, free)
    if first < len(free) - 1:
        assert depth_of(flown, given_zones, first * TICK, scale) <= 1e-9
        assert (meets_movers(shapes, curves, TimedCurve(0, first * TICK, scale), 0.0) == np.inf).all()
    rate = STEP * np.linalg.norm(np.subtract(flown.at(seconds).position[0], a)) / seconds + 1e-5
    for k in range(
        0, min(first, int(LATEST / TICK)), 25
    ):  # what was passed over is too near, as far as samples can tell
        assert depth_of(flown, given_zones, k * TICK, scale) > -rate


def hall(*given_zones, **fields):
    """A hall that UAVs cross through zones."""
    return sky.Scenario(
        name="hall",
        bounds={"min": (0, 0, 0), "max": (40, 20, 2)},
        clearance=0.2,
        lattice={"step": (1, 1, 1), "connectivity": 26},
        objective={"unit": "metres"},
        zones=given_zones,
        **({"uavs": [sky.UAV(start=(1, 10, 1))], "targets": [{"position": (39, 10, 1)}]} | fields),
    )


def proven(scenario, **options):
    """A plan that the referee proves."""
    mission = sky.plan_mission(scenario, **options)
    assert mission.violations == ()
    assert all(one.verdict is Verdict.PROVEN for one in mission.certificates)
    return mission


def done(mission):
    return [action.sentence for action in mission.deconfliction.actions]


ACROSS = {"min": (18, -5, -5), "max": (22, 25, 5)}
BESIDE = {"min": (18, 5, -5), "max": (22, 20, 5)}


@pytest.mark.parametrize("active", [[[0, 3]], [[7, None]], [[0, 3], [12, 20]], [[-9, 0.5]]])
def test_a_flight_that_passes_while_a_zone_is_not_active_stays_as_it_is(active):
    mission = proven(hall(sky.Box(**ACROSS, active=active)))
    assert done(mission) == []
    assert mission.makespan == proven(hall()).makespan


@pytest.mark.parametrize("closes", [9.0, 60.0, 1000.0])
def test_a_flight_waits_until_a_zone_closes_and_then_enters_at_once(closes):
    mission = proven(
        hall(sky.Prism(vertices=[(18, -5), (22, -5), (22, 25), (18, 25)], low=-9, high=9, active=[[0, closes]]))
    )
    (said,) = done(mission)
    assert "departs" in said
    flown = mission.trajectories[0]
    entered = np.linspace(closes, closes + 0.2, 2001)
    assert flown.at(closes).position[0, 0] <= 17.8
    assert flown.at(entered).position[:, 0].max() > 17.8, "it could have departed earlier"


def test_a_flight_leads_around_a_zone_where_that_is_faster_than_waiting():
    around = proven(hall(sky.Box(**BESIDE, active=[[0, 60]])))
    (said,) = done(around)
    assert said.startswith("uav-1 flies around zone 0 (active from 0 s to 60 s): ")
    always = sky.Scenario(**{**dict(hall()), "obstacles": [sky.Box(**BESIDE)]})
    assert around.makespan == pytest.approx(sky.plan_mission(always).makespan, rel=1e-6)
    assert around.results[0].path is not None


def test_zones_that_a_flight_around_others_meets_are_led_around_too():
    second = sky.Box(min=(18, 0, -5), max=(22, 5, 5), active=[[2, 30]])
    last = sky.Box(min=(25, 0, -5), max=(28, 12, 5), active=[[2, 30]])
    mission = proven(hall(sky.Box(**{**BESIDE, "max": (22, 14, 5)}, active=[[0, 60]]), second, last))
    (around,) = (said for said in done(mission) if said.startswith("uav-1 flies around zone 0 ("))
    assert " and zone 2 (" in around


def test_a_flight_keeps_a_speed_limit_only_while_it_is_active():
    full = proven(hall()).makespan
    assert proven(hall(sky.Box(**ACROSS, active=[[0, 2]], max_speed=1.0))).makespan == full
    slow = proven(hall(sky.Box(**ACROSS, active=[[0, None]], max_speed=1.0)))
    assert done(slow)[0].startswith("uav-1 keeps the speed limit of zone 0 (active from 0 s on): 38 m in ")
    assert slow.makespan == sky.plan_mission(hall(sky.Box(**ACROSS, max_speed=1.0))).makespan
    waits = proven(hall(sky.Box(**ACROSS, active=[[0, 5.5]], max_speed=0.1)))
    assert full < waits.makespan < full + 2.0


def test_where_nothing_helps_the_mission_says_so():
    mission = sky.plan_mission(hall(sky.Box(**ACROSS, active=[[0, None]])))
    assert mission.certificates[0].verdict is Verdict.REFUTED
    assert "inside zone 0 (active from 0 s on)" in mission.certificates[0].sentence


def test_a_fleet_passes_zones_and_one_another():
    uavs = [sky.UAV(start=(x, y, 1), separation=1.0) for x, y in ((1, 8), (1, 10), (1, 12), (39, 9), (39, 11))]
    targets = [{"position": (40 - uav.start[0], uav.start[1], 1)} for uav in uavs]
    zones_given = [
        sky.Box(**BESIDE, active=[[0, 20]]),
        sky.Box(min=(28, 0, -5), max=(30, 11, 5), active=[[3, 6], [9, 12]]),
    ]
    proven(hall(*zones_given, uavs=uavs, targets=targets), assignment="identity")


def test_a_uav_with_a_tracking_error_keeps_away_by_that_too():
    error = sky.TrackingError(horizontal=0.5, vertical=0.3)
    uav = sky.UAV(start=(1, 10, 1), tracking_error=error)
    mission = proven(hall(sky.Box(**BESIDE, active=[[0, 60]]), uavs=[uav]))
    path = np.array(mission.results[0].path)
    assert path[:, 1].min() <= 5 - 0.2 - 0.5 + 1e-6
