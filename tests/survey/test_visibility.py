"""Shortest ways in the plane beside what shapely sees and what scipy's shortest paths over a graph of it are."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import shortest_path

from skyverse.survey.visibility import reflex_corners, way_prices


def lengths(legs):
    return np.hypot(legs[..., 0], legs[..., 1])


def random_free(seed, zones=6):
    """Return a square of 100 m with random zones, and places inside it and on the zones' borders."""
    rng = np.random.default_rng(seed)
    shapes = [
        shapely.MultiPoint(rng.uniform(10, 90, 2) + rng.uniform(-12, 12, (5, 2))).convex_hull for _ in range(zones)
    ]
    free = shapely.box(0, 0, 100, 100).difference(shapely.union_all(shapes))
    parts = [free] if free.geom_type == "Polygon" else list(free.geoms)
    free = max(parts, key=lambda part: part.area)
    inside = [p for p in rng.uniform(0, 100, (12, 2)) if free.contains(shapely.Point(p))]
    border = [ring.interpolate(rng.random(), normalized=True).coords[0] for ring in free.interiors]
    return free, np.array([*inside, *border, (0.0, 0.0)])


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_ways_are_as_short_as_a_graph_of_what_shapely_sees(seed):
    free, places = random_free(seed)
    prices = way_prices(free, places, lengths)
    nodes = np.concatenate([places, reflex_corners(free)])
    legs = np.stack(np.broadcast_arrays(nodes[:, None], nodes[None]), axis=2)
    grown = shapely.buffer(free, 1e-7, join_style="mitre")
    seen = shapely.covers(grown, shapely.linestrings(legs.reshape(-1, 2, 2))).reshape(len(nodes), -1)
    length = np.hypot(*np.moveaxis(nodes[:, None] - nodes[None], -1, 0))
    truth = shortest_path(np.where(seen, length, np.inf))[: len(places), : len(places)]
    np.testing.assert_allclose(prices, truth, rtol=1e-6, atol=1e-5)


def test_a_way_round_a_square_bends_at_its_corners():
    free = shapely.box(0, 0, 10, 10).difference(shapely.box(4, 4, 6, 6))
    prices = way_prices(free, np.array([(5.0, 4.0), (5.0, 6.0), (5.0, 5.0)]), lengths)
    assert prices[0, 1] == pytest.approx(4.0)
    assert np.isinf(prices[0, 2])


def test_where_every_corner_costs_the_fewest_are_turned_at():
    free = shapely.box(0, 0, 10, 10).difference(shapely.box(4, 4, 6, 6))
    prices = way_prices(free, np.array([(5.0, 3.9), (5.0, 6.1)]), lambda legs: lengths(legs) + 5)
    assert prices[0, 1] == pytest.approx(15 + 2 * np.hypot(1, 0.1) + 2)


def test_everywhere_free_ways_are_straight():
    places = np.random.default_rng(0).random((5, 2))
    np.testing.assert_allclose(way_prices(shapely.box(0, 0, 1, 1), places, lengths), lengths(places[:, None] - places))
