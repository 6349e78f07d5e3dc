"""Prisms are sound as another library judges it; what is closed above reaches beyond the bounds."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.polygon import edges_that_meet
from skyverse.model.shape_extent import ABOVE_BOUNDS, extruded
from skyverse.model.shapes import told_spans

rings = st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=3, max_size=9, unique=True)


@settings(max_examples=300, deadline=None)
@given(rings)
def test_an_outline_is_taken_where_others_call_it_simple(corners):
    shapely = pytest.importorskip("shapely", reason="the oracle is shapely")
    line = shapely.LinearRing(corners)
    assert (edges_that_meet([tuple(corners)]) is None) == bool(line.is_simple)


@settings(max_examples=200, deadline=None)
@given(rings, rings)
def test_a_hole_is_taken_where_others_call_the_polygon_sound(corners, hole):
    shapely = pytest.importorskip("shapely", reason="the oracle is shapely")
    outside = [(3 * x - 6, 3 * y - 6) for x, y in corners]
    assume(shapely.LinearRing(outside).is_simple and shapely.LinearRing(hole).is_simple)
    around, within = shapely.Polygon(outside), shapely.Polygon(hole)
    sound = around.contains_properly(within)
    try:
        sky.Prism(vertices=outside, holes=[hole], low=0, high=1)
    except ValueError:
        assert not sound
    else:
        assert sound


def test_an_outline_of_many_thousand_corners_is_checked_at_once():
    turn = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    ring = 1000 * np.column_stack([np.cos(turn), np.sin(turn)])
    tracemalloc.start()
    sky.Prism(vertices=ring, low=0, high=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3e8
    ring[9_000, 0] += 3000  # across the other side
    with pytest.raises(ValueError, match="must not touch or cross itself"):
        sky.Prism(vertices=ring, low=0, high=1)


SQUARE = ((4.0, 4.0), (6.0, 4.0), (6.0, 6.0), (4.0, 6.0))
OVER = {"closed_above": True}


def closed(shape, kind):
    """The shape of one kind that a shape in bounds that end at 10 m becomes when it is closed above."""
    (found,) = (one for one in extruded(shape, 10.0) if type(one) is kind)
    return found


@pytest.mark.parametrize(("top", "end"), [(2.0, 10.0), (12.0, 12.0)])
def test_upper_faces_are_raised_beyond_the_higher_of_shape_and_bounds(top, end):
    assert closed(sky.Box(min=(4, 4, 0), max=(6, 6, top), **OVER), sky.Box).max == (6, 6, end + ABOVE_BOUNDS)
    assert (
        closed(sky.Cylinder(centre=(5, 5), radius=1, low=0, high=top, **OVER), sky.Cylinder).high == end + ABOVE_BOUNDS
    )
    assert closed(sky.Prism(vertices=SQUARE, low=0, high=top, **OVER), sky.Prism).high == end + ABOVE_BOUNDS
    above = closed(sky.Sphere(centre=(5, 5, top - 1), radius=1, **OVER), sky.Cylinder)
    assert (above.centre, above.radius, above.low, above.high) == ((5, 5), 1, top - 1, end + ABOVE_BOUNDS)


@pytest.mark.parametrize("origin", [-8.0, 0.0, 7.0])
def test_each_column_of_voxels_is_filled_from_its_lowest_on(origin):
    occupied = np.zeros((1, 2, 3), dtype=bool)
    occupied[0, 1, 1] = True
    found = closed(sky.Voxels(origin=(4, 4, origin), step=(1, 1, 2), occupied=occupied, **OVER), sky.Voxels)
    end = origin + 2 * found.occupied.shape[2]
    assert 10 + ABOVE_BOUNDS <= end < 10 + ABOVE_BOUNDS + 2
    assert not found.occupied[0, 0].any()
    assert found.occupied[0, 1].tolist() == [False] + [True] * (found.occupied.shape[2] - 1)


def test_a_sentence_tells_the_first_of_many_active_times_and_how_many_more_there_are():
    spans = tuple((2.0 * k, 2.0 * k + 1.0) for k in range(10_000))
    assert told_spans(spans[:3]) == "from 0 s to 1 s and from 2 s to 3 s and from 4 s to 5 s"
    assert told_spans(spans) == "from 0 s to 1 s and from 2 s to 3 s and 9,998 times more"
