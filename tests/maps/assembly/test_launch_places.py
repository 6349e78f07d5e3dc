"""Where UAVs of surveys start by default: on level ground beside the area where there is some near."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.maps.assembly.launch_places import with_launches
from skyverse.maps.assembly.options import BuildOptions

STEP = 5.0
SIDE = 121


def chosen(terrain, uavs=2, places=()):
    """Starts (n, 2) beside a field of 200 m about the zero, and what was said."""
    bounds = {"min": (-300, -300, -200), "max": (300, 300, 400)}
    origin = sky.Origin(latitude=47.0, longitude=8.0, altitude=0.0)
    world = sky.Scenario(name="field", bounds=bounds, clearance=2.0, terrain=terrain, frame=sky.Frame(origin=origin))
    notes = []
    options = BuildOptions("field", vehicle="camera", on_note=notes.append)
    field = sky.Survey([(-100, -100), (100, -100), (100, 100), (-100, 100)], "mavic-3e", gsd="3 cm")
    made = with_launches(world, options, [field], places, uavs)
    return np.array([uav.start[:2] for uav in made.uavs]), [note.text for note in notes if "steeper" in note.text]


def ground(height):
    """Terrain of a height that is a function of x and y."""
    x, y = np.meshgrid(*[STEP * np.arange(SIDE) - 300.0] * 2, indexing="ij")
    return sky.Terrain(origin=(-300.0, -300.0), step=(STEP, STEP), heights=height(x, y) + 0.0 * x, clearance=2.0)


def steepest(height, place):
    """The steepest of the chords of 1 m about a place, degrees, on the exact ground."""
    angles = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
    rises = [height(place[0] + math.cos(a), place[1] + math.sin(a)) - height(*place) for a in angles]
    return math.degrees(math.atan(max(map(abs, rises))))


@settings(max_examples=20, deadline=None)
@given(where=st.floats(0.0, 2.0 * math.pi), slope=st.floats(0.4, 0.8))
def test_uavs_start_on_level_ground_where_some_is_near(where, slope):
    def height(x, y):  # a slope up to a terrace across the border of the field
        along = x * math.cos(where) + y * math.sin(where)
        return slope * np.minimum(along, 80.0)

    starts, said = chosen(ground(height))
    if said:
        side = np.linspace(-95.0, 95.0, 39)
        border = [(sign * 110.0, at)[::way] for at in side for sign in (-1, 1) for way in (-1, 1)]
        near = [place for place in border if math.dist(place, starts[0]) < 90.0]
        assert min(steepest(height, place) for place in near) > 15.0
    else:
        for start in starts:
            assert steepest(height, start) <= 15.0


def test_a_terrace_beside_the_nearest_place_is_taken():
    def height(x, y):
        return 0.6 * np.maximum(np.abs(y - 40.0) - 25.0, 0.0)

    starts, said = chosen(ground(height))
    assert said == []
    assert (np.abs(starts[:, 1] - 40.0) < 25.0).all()
    assert np.hypot(*(starts[0] - starts[1])) < 40.0


def test_level_fields_are_left_from_the_place_nearest_to_their_middle():
    starts, said = chosen(ground(lambda x, y: 0.0 * x))
    assert said == []
    assert np.hypot(*starts[0]) == pytest.approx(110.0, abs=5.0)


def test_it_is_said_that_no_level_place_is_near():
    starts, (said,) = chosen(ground(lambda x, y: 0.5 * x), uavs=3)
    assert len(starts) == 3
    assert "uav-1, uav-2 and uav-3" in said
    assert "15 degrees" in said


def test_places_that_are_given_are_kept_but_told_if_they_are_steep():
    steep = ground(lambda x, y: 0.5 * np.maximum(x, 0.0))
    starts, said = chosen(steep, uavs=2, places=[(47.0, 8.002)])
    assert starts[0, 0] > 140.0
    assert "uav-1" in said[0]
