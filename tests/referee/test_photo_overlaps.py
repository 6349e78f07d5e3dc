"""Overlaps of neighbours: exact over level ground, whatever the direction, and on a plane that slopes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.asked_ground import asked_ground
from skyverse.model.photos import Photos
from skyverse.referee.ground_cells import grid_of
from skyverse.referee.photo_overlaps import neighbours_of

HEIGHT = 60.0


def shared(along, aside, phase, heading, slope):
    """Return the overlaps of two strips of three photos, side by side over a plane that rises to the right."""
    survey = sky.Survey([(-200, -200), (200, -200), (200, 200), (-200, 200)], "mavic-3e", height=HEIGHT)
    angle = math.radians(heading)
    ahead, right = np.array([math.sin(angle), math.cos(angle)]), np.array([math.cos(angle), -math.sin(angle)])
    x, y = np.meshgrid(np.arange(-300.0, 301.0, 20.0), np.arange(-300.0, 301.0, 20.0), indexing="ij")
    terrain = {"origin": (-300.0, -300.0), "step": (20.0, 20.0), "heights": slope * (x * right[0] + y * right[1])}
    bounds = {"min": (-300.0, -300.0, -400.0), "max": (300.0, 300.0, 500.0)}
    uav = sky.UAV(start=(0.0, 0.0, 450.0), end="home")
    scenario = sky.Scenario(name="plane", clearance=1.0, bounds=bounds, uavs=(uav,), terrain=terrain, surveys=(survey,))
    level = np.array([k * along * ahead for k in (-1, 0, 1)])
    level = np.concatenate([level, level + aside * right + phase * along * ahead])
    z = slope * (level @ right) + HEIGHT
    none, strip = np.zeros(6), np.repeat([0, 1], 3)
    photos = Photos(np.column_stack([level, z]), none + heading, none - 90.0, none, none, np.zeros(6, int), strip)
    along, between = neighbours_of(photos, survey.camera, grid_of(scenario, survey, asked_ground(survey)))
    return survey.camera, along.share, between.share


@settings(max_examples=20, deadline=None)
@given(st.floats(5, 30), st.floats(10, 60), st.floats(0, 0.45), st.floats(0, 360))
def test_over_level_ground_it_is_what_is_left_of_the_picture(along, aside, phase, heading):
    camera, ahead, beside = shared(along, aside, phase, heading, 0.0)
    across, high = camera.half_widths
    assert ahead == pytest.approx(100.0 * (1.0 - along / (2.0 * high * HEIGHT)), abs=0.3)
    assert beside == pytest.approx(100.0 * (1.0 - aside / (2.0 * across * HEIGHT)), abs=0.3)


@pytest.mark.parametrize("slope", [0.2, 0.5])
def test_on_a_slope_pictures_are_wider_by_the_formulas_of_planes(slope):
    camera, ahead, _ = shared(10.0, 0.1, 0.0, 30.0, slope)
    assert ahead == pytest.approx(100.0 * (1.0 - _apart(camera, slope, 10.0)), abs=0.5)


def _apart(camera, slope, along):
    """Return the share of a picture's area that is lost by a step along the contours of a plane.

    It is a trapezoid, whose sides are as far apart as the plane is deep there; the step takes the same off each width.
    """
    across, high = camera.half_widths
    t = across * slope
    up, down = HEIGHT * across / (1.0 + t), HEIGHT * across / (1.0 - t)
    area = (up + down) * high * ((HEIGHT - slope * up) + (HEIGHT + slope * down))
    return along * (up + down) / area


def test_a_strip_that_is_missing_is_noticed_however_wide_the_gap():
    _, _, beside = shared(10.0, 190.0, 0.0, 0.0, 0.0)
    assert len(beside) == 3
    assert (beside == 0.0).all()
