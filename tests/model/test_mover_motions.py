"""Motions, and bounds of their speed and acceleration: they hold at dense samples, and are tight for circles."""

import math

import numpy as np
import pytest

import skyverse as sky
from skyverse import CircularMotion, PeriodicMotion, WaypointMotion
from skyverse.model.mover_motions import LEAST_PERIOD, motion_bounds

AWAY, BACK = (0.0, 0.0, 5.0), (1.0, 0.0, 5.0)


def circle(period):
    return CircularMotion(centre=AWAY, radius=1.0, period=period)


def curve(period):
    return PeriodicMotion(centre=AWAY, period=period, cosine=[BACK], sine=[AWAY])


def to_and_fro(period):
    return WaypointMotion(points=[AWAY, BACK], times=[3.0, 3.0 + period], then="returns")


def round_trip(period):
    return WaypointMotion(points=[AWAY, BACK, AWAY], times=[-1.0, -1.0 + period / 2, -1.0 + period], then="repeats")


@pytest.mark.parametrize("period", [1e-3, 1e-9])
@pytest.mark.parametrize("motion", [circle, curve, to_and_fro, round_trip])
def test_what_repeats_sooner_than_a_planner_can_follow_is_refused(motion, period, refuses):
    assert np.isfinite(motion(1.01 * LEAST_PERIOD).at([0.0, 7.0])).all()
    with refuses():
        motion(period)


def test_a_motion_that_ends_may_be_as_short_as_its_instants_are():
    assert WaypointMotion(points=[AWAY, BACK], times=[0.0, 1e-6]).at([1.0]) == pytest.approx(np.array([BACK]))


BOX = sky.Scenario(
    name="box", bounds=sky.Bounds(min=(0, 0, 0), max=(30, 30, 10)), clearance=0.1,
    lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
)  # fmt: skip


def fastest_and_hardest(motion, until):
    t = np.linspace(0.0, until, 400_001)
    velocity = np.gradient(motion.at(t), t, axis=0)
    acceleration = np.gradient(velocity, t, axis=0)[2:-2]
    return np.linalg.norm(velocity, axis=1).max(), np.linalg.norm(acceleration, axis=1).max()


@pytest.mark.parametrize("kind", ["spinners", "knots"])
def test_a_closed_curve_is_nowhere_faster_nor_accelerates_more(kind):
    for mover in sky.random_movers(BOX, 5, kind=kind, speed=1.0, seed=4).movers:
        speed, acceleration = motion_bounds(mover.motion)
        fastest, hardest = fastest_and_hardest(mover.motion, mover.motion.period)
        assert fastest <= speed * (1 + 1e-9)
        assert hardest <= acceleration * (1 + 1e-4)
        assert (speed, acceleration) == pytest.approx((fastest, hardest), rel=1e-4 if kind == "spinners" else 0.02)


def test_a_circle_of_radius_2_in_4_pi_seconds_is_flown_at_1_and_a_half():
    circle = sky.CircularMotion(centre=(0, 0, 0), radius=2, period=4 * math.pi)
    assert motion_bounds(circle) == pytest.approx((1.0, 0.5))


def test_waypoints_have_the_speed_of_the_fastest_leg_and_turn_in_an_instant():
    motion = sky.WaypointMotion(points=[(0, 0, 0), (3, 4, 0), (3, 4, 1)], times=[0, 2, 3])
    assert motion_bounds(motion) == (2.5, None)


def test_what_stands_still_has_neither():
    assert motion_bounds(sky.WaypointMotion(points=[(1, 2, 3)], times=[0])) == (0.0, 0.0)


def test_polynomials_that_begin_and_end_at_rest_have_an_acceleration():
    smooth = sky.PolynomialMotion(knots=[0, 2], coefficients=[[(0, 0, 0), (0, 0, 0), (3, 0, 0), (-1, 0, 0)]])
    speed, acceleration = motion_bounds(smooth)
    fastest, hardest = fastest_and_hardest(smooth, 2.0)
    assert speed >= fastest
    assert acceleration >= hardest


def test_polynomials_that_set_off_in_an_instant_have_none():
    jerky = sky.PolynomialMotion(knots=[0, 2], coefficients=[[(0, 0, 0), (1, 0, 0)]])
    assert motion_bounds(jerky) == (1.0, None)


def test_a_doubt_whose_top_speed_contradicts_the_motion_is_refused():
    fast = sky.WaypointMotion(points=[(0, 0, 0), (9, 0, 0)], times=[0, 3])
    ball = sky.Sphere(centre=(0, 0, 0), radius=1)
    with pytest.raises(ValueError, match="as fast as 3 m/s"):
        sky.Mover(shape=ball, motion=fast, doubt=sky.Doubt(radius=0.1, growth=0.05, top_speed=1.0))
    fits = sky.Mover(shape=ball, motion=fast, doubt=sky.Doubt(radius=0.1, growth=0.05, top_speed=3.0))
    assert fits.at([1.0])[0, 0] == 3


@pytest.mark.parametrize("field", ["radius", "growth", "acceleration"])
def test_a_doubt_that_no_map_could_hold_is_refused(field):
    with pytest.raises(ValueError, match="at most 1000000"):
        sky.Doubt(**{field: 1e7, "top_speed": 1e6})
