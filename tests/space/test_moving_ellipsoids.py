"""Ellipsoids about UAVs, appended as arrays, are what the model's movers with the same motion are."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.temporary_zones import TimedShape
from skyverse.space.moving_ellipsoids import MovingEllipsoid, with_ellipsoids
from skyverse.space.moving_shapes import mover_gaps, moving_shapes, timed_parts

NONE = sky.TrackingError()


@pytest.mark.parametrize("movers", [0, 3])
def test_they_are_as_near_as_movers_with_the_same_motion(movers):
    mission = sky.plan_mission(sky.circle_swap(4, radius=6.0), assignment="identity")
    scenario = sky.random_movers(mission.scenario, movers, kind="knots", seed=5)
    known, flown = timed_parts(scenario), mission.trajectories[1:]
    given = [MovingEllipsoid(motion, 0.5, 1.0, 5.0) for motion in flown]
    shapes = with_ellipsoids(moving_shapes(known, NONE), given)
    for motion in flown:
        moves = sky.PolynomialMotion(knots=tuple(motion.knots), coefficients=motion.coefficients.tolist())
        shape = sky.Ellipsoid(centre=(0, 0, 0), semi_axis_xy=0.5, semi_axis_z=1.0)
        known.append(TimedShape(shape, moves, sky.Doubt(), 0.0))
    t = np.linspace(-1.0, 10.0, 400)
    places = mission.trajectories[0].at(t).position
    np.testing.assert_allclose(mover_gaps(shapes, t, places), mover_gaps(moving_shapes(known, NONE), t, places))


def test_nothing_is_appended_where_there_is_none():
    shapes = moving_shapes(timed_parts(sky.read("map1")), NONE)
    assert with_ellipsoids(shapes, []) is shapes
