"""UAVs that are found where, or at velocities with which, they should not be."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from replanned import field, hall, plane

planned = cache(sky.plan_mission)


@pytest.fixture(scope="module")
def mission():
    """A mission of a UAV with a tracking error of 0.2 m."""
    error = sky.TrackingError(horizontal=0.2, vertical=0.1)
    return sky.plan_mission(hall(uavs=[sky.UAV(start=(1, 5, 1), tracking_error=error)]))


@given(st.integers(0, 10_000), st.sampled_from([0.1, 0.5]))
def test_a_velocity_that_leads_off_the_course_within_the_lead_is_off_the_course(mission, seed, lead):
    rng = np.random.default_rng(seed)
    flight = sky.Replanner(mission, lead=lead)
    now = rng.uniform(0.3, 3.0)
    flight.observe(now)
    place, velocity, _ = (rows[0] for rows in flight.motion(0).at([now]))
    off, slip = rng.normal(size=3) * 0.1, rng.normal(size=3) * rng.choice([0.1, 1.0, 3.0])
    ends = off + lead * slip
    strays = [np.hypot(*way[:2]) > 0.21 or abs(way[2]) > 0.11 for way in (off, ends)]
    flight.observe(now, states={0: (place + off, velocity + slip)})
    found = flight.motion(0).at([now])
    taken = np.allclose(found.position[0], place + off) and np.allclose(found.velocity[0], velocity + slip)
    assert taken == any(strays)


def test_a_uav_found_far_too_fast_before_a_wall_is_not_proven(mission):
    flight = sky.Replanner(mission)
    flight.observe(2.0)
    place = flight.motion(0).at([2.5]).position[0]
    (answer,) = flight.observe(2.5, states={0: (place, (30.0, 0.0, 0.0))})
    assert not answer.proven


OUTSIDE = [(-2, 5, 1), (22, 5, 1), (10, -5, 1), (10, 13, 2), (10, 5, 7), (5, 5, -4), (-2, -2, -2)]


@pytest.mark.parametrize("place", OUTSIDE)
def test_a_uav_that_is_far_out_of_bounds_comes_back_and_says_how_far_out_it_is(mission, place):
    flight = sky.Replanner(mission)
    flight.observe(2.0)
    (answer,) = flight.observe(2.1, states={0: (place, (0, 0, 0))})
    far = np.linalg.norm(place - np.clip(place, (0, 0, 0), (20, 10, 4)))
    assert answer.out_of_bounds == pytest.approx(far)
    assert answer.sentence.endswith("m out of bounds.")
    out = [far]
    for k in range(22, 150):
        (answer,) = flight.observe(k / 10)
        out.append(answer.out_of_bounds)
        assert out[-1] <= out[-2] + 0.02
        if answer.proven:
            break
    assert answer.proven
    assert out[-1] == 0.0
    assert "out of bounds" not in answer.sentence


@pytest.mark.parametrize("place", [(300, -30, 60), (300, 430, 60), (640, 200, 60), (300, 200, 140)])
def test_an_aeroplane_that_is_out_of_bounds_comes_back(place):
    flight = sky.Replanner(sky.plan_mission(field()))
    flight.observe(3.0)
    velocity = flight.motion(0).at([3.1]).velocity[0]
    (answer,) = flight.observe(3.1, states={0: (place, velocity)})
    assert not answer.proven
    assert answer.out_of_bounds > 10.0
    for k in range(4, 60):
        (answer,) = flight.observe(float(k))
        if answer.proven:
            return
    raise AssertionError("it does not come back")


@pytest.mark.parametrize(("speed", "proven"), [(15.0, True), (15.05, True), (25.0, False), (8.0, False)])
def test_an_aeroplane_found_at_a_speed_at_which_it_cannot_fly_is_not_proven_until_it_is_seen_to(speed, proven):
    flight = sky.Replanner(sky.plan_mission(field()))
    flight.observe(3.0)
    place, velocity = (rows[0] for rows in flight.motion(0).at([3.1])[:2])
    (answer,) = flight.observe(3.1, states={0: (place + np.array((0, 5, 0)), velocity * speed / 15.0)})
    assert answer.proven == proven
    assert flight.observe(3.2)[0].proven == proven
    place, velocity = (rows[0] for rows in flight.motion(0).at([3.3])[:2])
    assert flight.observe(3.3, states={0: (place, velocity)})[0].proven


@pytest.fixture(scope="module")
def ended():
    """A mission of an aeroplane whose target lies where it has no room to loiter."""
    street = sky.Box(min=(100, 0, 0), max=(600, 170, 120)), sky.Box(min=(100, 230, 0), max=(600, 400, 120))
    return sky.plan_mission(field(*street, uavs=[plane()]))


def flown_to_its_end(mission):
    flight = sky.Replanner(mission)
    for t in np.arange(0.0, mission.trajectories[0].end + 2.0, 1.0):
        flight.observe(t)
    assert flight.arrival(0) <= flight.now
    return flight


def test_an_aeroplane_that_has_ended_its_mission_in_the_air_does_not_depart_from_standstill(ended, refuses):
    flight = flown_to_its_end(ended)
    before = flight.now, flight.motion(0), flight.scenario
    with refuses() as refused:
        flight.observe(flight.now + 1.0, targets={0: (40, 100, 60)})
    assert refused.value.sentence.field == "targets[0]"
    assert (flight.now, flight.motion(0), flight.scenario) == before


def test_an_aeroplane_that_is_seen_to_fly_after_its_mission_flies_on_from_there(ended):
    flight = flown_to_its_end(ended)
    now = flight.now + 1.0
    flight.observe(now, states={0: ((50, 200, 60), (0, 15, 0))}, targets={0: (50, 330, 60)})
    begins = flight.motion(0).at([now])
    assert begins.position[0] == pytest.approx((50, 200, 60))
    assert np.linalg.norm(begins.velocity[0]) == pytest.approx(15.0)
    assert (
        np.linalg.norm(flight.motion(0).at(np.linspace(now, flight.motion(0).end, 500)).velocity, axis=1).min() > 14.9
    )
    assert len(flight.flown(0).knots) > 2


@given(st.integers(0, 10_000))
def test_a_uav_found_anywhere_in_a_forest_gets_to_its_target(seed):
    scenario = sky.forest_swap(2, seed=seed % 5)
    flight = sky.Replanner(planned(scenario))
    rng, world = np.random.default_rng(seed), sky.World(scenario)
    low, high = scenario.bounds.min, scenario.bounds.max
    places = rng.uniform(low, high, (1000, 3))
    place = places[world.distance(places) > scenario.clearance + 0.01][0]
    now = rng.uniform(0.2, 4.9)
    flight.observe(now)
    flight.observe(now, states={0: (place, (0.0, 0.0, 0.0))})
    for k in range(600):
        flight.observe(now + 0.1 * k)
    assert (flight.arrival(0) or np.inf) <= flight.now
