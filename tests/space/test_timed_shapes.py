"""Movers as arrays, ellipsoids about UAVs among them, and how long flights are too near: by other formulas."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from movers import depth_at, movers, points, timed
from skyverse.model.timed_shapes import TimedShape
from skyverse.space.contact import LEAST_STEP, flown_legs, seconds_in_contact
from skyverse.space.moving_ellipsoids import MovingEllipsoid, with_ellipsoids
from skyverse.space.timed_shapes import mover_gaps, moving_shapes, timed_parts
from timed_flights import flown, seconds_inside

EXACT = sky.TrackingError()


@given(st.lists(movers, min_size=1, max_size=3), points)
@settings(max_examples=100, deadline=None)
def test_gaps_are_the_depths_of_another_formula(given_movers, place):
    instants = np.linspace(0, 30, 301)
    places = np.repeat([place], len(instants), axis=0)
    gaps = mover_gaps(moving_shapes(timed(given_movers), EXACT), instants, places)
    for row, mover in zip(gaps, given_movers, strict=True):
        np.testing.assert_allclose(row, -depth_at(mover, instants, places, 0.5), atol=1e-7)


@given(movers, points)
@settings(max_examples=100, deadline=None)
def test_no_gap_falls_faster_than_the_rate(mover, place):
    instants = np.linspace(0, 30, 3001)
    shapes = moving_shapes(timed([mover]), EXACT)
    gaps = mover_gaps(shapes, instants, np.repeat([place], len(instants), axis=0))[0]
    assert np.diff(gaps).min() >= -shapes.rate[0] * 0.01 - 1e-9


@given(movers, points, st.floats(0, 1), st.floats(0, 1), st.floats(0, 2 * np.pi), st.floats(-1, 1), st.floats(0, 30))
@settings(max_examples=200, deadline=None)
def test_a_gap_with_a_tracking_error_is_kept_wherever_within_it_a_uav_is(mover, place, aside, up, course, z, t):
    error = sky.TrackingError(horizontal=aside, vertical=up)
    instants = np.array([t])
    gap = mover_gaps(moving_shapes(timed([mover]), error), instants, np.array([place]))[0, 0]
    strayed = np.add(place, (aside * np.sin(course), aside * np.cos(course), z * up))[None]
    if gap >= 0:
        assert mover_gaps(moving_shapes(timed([mover]), EXACT), instants, strayed)[0, 0] >= -1e-9


@pytest.mark.parametrize("movers", [0, 3])
def test_they_are_as_near_as_movers_with_the_same_motion(movers):
    mission = sky.plan_mission(sky.circle_swap(4, radius=6.0), assignment="identity")
    scenario = sky.random_movers(mission.scenario, movers, kind="knots", seed=5)
    known, flown = timed_parts(scenario), mission.trajectories[1:]
    given = [MovingEllipsoid(motion, 0.5, 1.0, 5.0) for motion in flown]
    shapes = with_ellipsoids(moving_shapes(known, EXACT), given)
    for motion in flown:
        moves = sky.PolynomialMotion(knots=tuple(motion.knots), coefficients=motion.coefficients.tolist())
        shape = sky.Ellipsoid(centre=(0, 0, 0), semi_axis_xy=0.5, semi_axis_z=1.0)
        known.append(TimedShape(shape, moves, sky.Doubt(), 0.0))
    t = np.linspace(-1.0, 10.0, 400)
    places = mission.trajectories[0].at(t).position
    np.testing.assert_allclose(mover_gaps(shapes, t, places), mover_gaps(moving_shapes(known, EXACT), t, places))


def test_nothing_is_appended_where_there_is_none():
    shapes = moving_shapes(timed_parts(sky.read("map1")), EXACT)
    assert with_ellipsoids(shapes, []) is shapes


def measured(given_movers, corners, speed, acceleration, departs, stays, kept=0.5):
    legs = flown_legs(len(corners))
    legs.corners[:] = corners
    shapes = moving_shapes(timed(given_movers, kept), EXACT)
    return seconds_in_contact(shapes, legs, len(corners), speed, acceleration, departs, stays), legs


@given(
    st.lists(movers, min_size=1, max_size=3),
    st.lists(points, min_size=2, max_size=5, unique=True),
    st.floats(0.3, 4),
    st.floats(0.5, 10),
    st.floats(0, 20),
    st.floats(0, 3),
)
@settings(max_examples=100, deadline=None)
def test_the_seconds_in_contact_are_those_of_dense_samples(given_movers, corners, speed, acceleration, departs, stays):
    corners = np.array(corners)
    seconds, legs = measured(given_movers, corners, speed, acceleration, departs, stays)
    instants, _ = flown(corners, speed, acceleration)
    assert legs.instants[len(corners) - 1] == pytest.approx(instants[-1], rel=0.02, abs=1e-3)
    truth = seconds_inside(given_movers, 0.5, corners, speed, acceleration, departs, stays)
    assert seconds == pytest.approx(truth, rel=0.02, abs=0.02 * (instants[-1] + stays))


def test_a_mover_that_waits_on_the_way_is_met_for_as_long_as_the_flight_is_in_it():
    """At 2 m/s and hardly any time to get there, a ball of 1 m takes 1 s to cross, and half of one from its middle."""
    ball = sky.Mover(
        shape=sky.Sphere(centre=(0, 0, 0), radius=1), motion=sky.WaypointMotion(points=((5, 0, 0),), times=(0,))
    )
    line = np.array([(0.0, 0, 0), (10.0, 0, 0)])
    seconds, _ = measured([ball], line, 2.0, 1e6, 0.0, 0.0, kept=0.0)
    assert seconds == pytest.approx(1.0, abs=3 * LEAST_STEP)
    seconds, _ = measured([ball], line / 2, 2.0, 1e6, 0.0, 3.0, kept=0.0)
    assert seconds == pytest.approx(0.5 + 3.0, abs=3 * LEAST_STEP)


def test_a_mover_that_has_passed_before_the_departure_is_not_met():
    motion = sky.WaypointMotion(points=((5, -5, 0), (5, 5, 0)), times=(0, 5))
    ball = sky.Mover(shape=sky.Sphere(centre=(0, 0, 0), radius=0.5), motion=motion)
    line = np.array([(0.0, 0, 0), (10.0, 0, 0)])
    met, _ = measured([ball], line, 2.0, 1e6, 0.0, 1.0)
    late, _ = measured([ball], line, 2.0, 1e6, 3.0, 1.0)
    assert met > 0.3
    assert late == 0.0


def test_a_ball_that_is_grazed_is_met_and_one_that_is_just_missed_is_not():
    line = np.array([(0.0, 0, 0), (10.0, 0, 0)])
    for aside, hit in ((0.999, True), (1.001, False)):
        motion = sky.WaypointMotion(points=((5, aside, 0),), times=(0,))
        ball = sky.Mover(shape=sky.Sphere(centre=(0, 0, 0), radius=0.5), motion=motion)
        seconds, _ = measured([ball], line, 2.0, 3.0, 0.0, 1.0)
        assert (seconds > 0) == hit
