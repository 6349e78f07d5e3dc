"""How long a flight is too near to movers, against dense samples of it by formulas of the tests' own."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from movers import movers, points, timed
from skyverse.space.contact import LEAST_STEP, flown_legs, seconds_in_contact
from skyverse.space.moving_shapes import moving_shapes
from timed_flights import flown, seconds_inside

EXACT = sky.TrackingError()


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
