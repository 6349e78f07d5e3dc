"""Motions of movers that go on for ever."""

import numpy as np
import pytest

from skyverse import CircularMotion, PeriodicMotion, WaypointMotion
from skyverse.model.mover_motions import LEAST_PERIOD

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
