"""Movers as arrays are where their models have them, and no point comes nearer to them faster than they say."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from movers import depth_at, movers, points, timed
from skyverse.space.moving_shapes import mover_gaps, moving_shapes

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
