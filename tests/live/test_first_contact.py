"""What a motion is clear of, of all that movers may do: the least share of their doubts at any instant."""

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL
from skyverse.model.timed_shapes import TimedShape
from skyverse.space.contact import first_contact, share_avoided
from skyverse.space.timed_shapes import LEAST_DOUBT, moving_shapes

KEPT, APART = 0.5, 3.0
KNOTS = np.array([0.0, 4.0])


def beside(doubt, apart=APART):
    """A ball that flies beside a UAV, which flies 4 m along x in 4 s; and the coefficients of the UAV's motion."""
    motion = sky.WaypointMotion(points=[(0, apart, 0), (4, apart, 0)], times=[0, 4])
    shapes = moving_shapes([TimedShape(BALL, motion, doubt, KEPT)], sky.TrackingError())
    return shapes, KNOTS, np.array([[(0, 0, 0), (1, 0, 0)]], dtype=float)


@pytest.mark.parametrize(
    ("doubt", "spread"),
    [
        (sky.Doubt(radius=4.0), 4.0),
        (sky.Doubt(radius=1.0, growth=1.0), 5.0),
        (sky.Doubt(radius=1.0, acceleration=0.5, top_speed=3.0), 5.0),
        (sky.Doubt(radius=1.0, acceleration=9.0, top_speed=1.0), 9.0 * (4.0 * 2 / 9 - 0.5 * (2 / 9) ** 2) + 1.0),
    ],
)
def test_a_motion_beside_a_mover_is_clear_of_a_share_of_its_doubt(doubt, spread):
    share, missing = share_avoided(*beside(doubt), 0.0, 4.0)
    instants = np.linspace(0.0, 4.0, 4001)
    shares = (APART - BALL.radius - KEPT) / (LEAST_DOUBT + doubt.at(instants))
    assert shares[-1] == pytest.approx((APART - BALL.radius - KEPT) / (LEAST_DOUBT + spread))
    if doubt.top_speed:  # how far the mover can have come from where it was at 0 s
        far = np.hypot(instants, APART) - BALL.radius - KEPT
        shares = np.maximum(shares, far / (LEAST_DOUBT + doubt.radius + doubt.top_speed * instants))
    assert share == pytest.approx(shares.min(), rel=1e-3)
    assert missing == pytest.approx(np.trapezoid(np.maximum(1.0 - shares, 0.0), instants), rel=0.05)


def test_a_motion_that_meets_no_doubt_is_clear_of_all_of_it_and_one_through_a_mover_of_none():
    shapes = beside(sky.Doubt(radius=1.0))
    assert share_avoided(*shapes, 0.0, 4.0) == (1.0, 0.0)
    assert first_contact(*shapes, 1.0, 0.0, 4.0)[0] == -1
    assert share_avoided(*beside(sky.Doubt(radius=1.0), apart=0.4), 0.0, 4.0)[0] < 0.0


def test_a_mover_that_comes_head_on_and_may_do_nothing_else_is_not_avoided():
    comes = sky.WaypointMotion(points=[(-4, 0, 0), (4, 0, 0)], times=[0, 4])
    shapes = moving_shapes([TimedShape(BALL, comes, sky.Doubt(growth=0.05), KEPT)], sky.TrackingError())
    assert share_avoided(shapes, KNOTS, np.array([[(0, 0, 0)]], dtype=float), 0.0, 4.0)[0] < 0.0
