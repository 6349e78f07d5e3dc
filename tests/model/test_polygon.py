"""Polygons of prisms: which of them are sound, as another library judges it."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.polygon import edges_that_meet

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
