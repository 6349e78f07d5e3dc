"""Footprints with fewer corners: never smaller, hardly larger, and such that a prism can be made of them."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky

shapely = pytest.importorskip("shapely")

from skyverse.maps.assembly.footprints import merge, simplify  # noqa: E402


@st.composite
def footprints(draw):
    """Draw a valid polygon, often with bays, spikes, small notches, and holes that touch."""
    n = draw(st.integers(3, 14))
    angles = np.sort(draw(st.lists(st.floats(0, 6.28), min_size=n, max_size=n)))
    radii = draw(st.lists(st.floats(1, 30), min_size=n, max_size=n))
    corners = np.round(np.column_stack([radii * np.cos(angles), radii * np.sin(angles)]), 3)
    shape = shapely.make_valid(shapely.Polygon(corners))
    for _ in range(draw(st.integers(0, 4))):
        x, y = draw(st.integers(-12, 12)), draw(st.integers(-12, 12))
        box = shapely.box(x, y, x + draw(st.sampled_from([0.1, 1, 5])), y + draw(st.sampled_from([0.2, 2, 6])))
        shape = shape.difference(box) if draw(st.booleans()) else shape.union(box)
    parts = [
        part
        for part in shapely.get_parts(shapely.set_precision(shapely.set_precision(shape, 0.001), 0))
        if part.geom_type == "Polygon" and part.area > 0
    ]
    return max(parts, key=lambda part: part.area) if parts else shapely.box(0, 0, 1, 1)


def prism(polygon):
    return sky.Prism(
        vertices=np.array(polygon.exterior.coords)[:-1],
        holes=tuple(np.array(ring.coords)[:-1] for ring in polygon.interiors),
        low=0.0,
        high=1.0,
    )


@given(footprints(), st.sampled_from([0.0, 0.05, 0.5, 3.0]))
def test_a_simpler_footprint_covers_the_given_one_and_reaches_no_further_than_allowed(polygon, tolerance):
    (simpler,) = simplify([polygon], tolerance)
    assert simpler.covers(polygon)
    assert shapely.get_num_coordinates(simpler) <= shapely.get_num_coordinates(polygon)
    courts = [shapely.Polygon(ring) for ring in polygon.interiors]
    near = 2 * tolerance + 0.01
    free = [
        court
        for court in courts
        if court.area < 3 * tolerance * court.length
        or court.distance(polygon.exterior) < near
        or any(court.distance(other) < near for other in courts if other is not court)
    ]
    assert shapely.union_all([polygon.buffer(1.01 * tolerance + 1e-9), *free]).covers(simpler)
    prism(simpler)


def test_jagged_walls_become_straight_ones():
    x = np.linspace(0, 50, 500)
    ring = np.concatenate([np.column_stack([x, 0.1 * np.sin(9 * x)]), [[50, 20], [0, 20]]])
    (simpler,) = simplify([shapely.Polygon(ring)], 0.5)
    assert len(simpler.exterior.coords) < 12
    assert simpler.area < 1.04 * 1000


def test_boxes_stay_as_they_are():
    box = shapely.box(0, 0, 10, 20)
    (same,) = simplify([box], 1.0)
    assert same.equals(box)


def test_courtyards_that_touch_the_wall_are_filled():
    outer = [(0, 0), (40, 0), (40, 40), (0, 40)]
    large, small = shapely.box(10, 10, 20, 20), shapely.box(30, 30, 31, 31)
    touching = shapely.Polygon([(0, 20), (5, 18), (5, 22)])
    court = shapely.Polygon(outer, [hole.exterior.coords for hole in (large, small, touching)])
    assert court.is_valid
    (filled,) = simplify([court], 0.0)
    assert filled.equals(shapely.Polygon(outer, [large.exterior.coords, small.exterior.coords]))
    prism(filled)


@given(st.lists(st.tuples(*[st.integers(0, 12)] * 4, *[st.integers(0, 3)] * 2), min_size=0, max_size=12))
def test_neighbours_of_like_ends_become_one_and_nothing_is_lost(rows):
    shapes = [shapely.box(x, y, x + w / 4 + 1, y + h / 4 + 1) for x, y, w, h, *_ in rows]
    low = np.array([float(row[4]) for row in rows])
    high = low + 5 + np.array([float(row[5]) for row in rows])
    merged = merge(shapes, low, high, 1.0)
    assert len(merged.polygons) <= len(shapes)
    assert sorted(int(k) for one in merged.members for k in one) == list(range(len(shapes)))
    for polygon, a, b, members in zip(merged.polygons, merged.low, merged.high, merged.members, strict=True):
        assert a == low[members].min()
        assert b == high[members].max()
        assert np.ptp(low[members]) <= 1
        assert np.ptp(high[members]) <= 1
        assert all(polygon.buffer(1e-9).covers(shapes[k]) for k in members)
        prism(polygon)
    area = shapely.union_all(shapes).area
    filled = shapely.union_all([shapely.Polygon(p.exterior) for p in merged.polygons]) if shapes else shapely.Polygon()
    assert area <= shapely.union_all(list(merged.polygons)).area + 1e-9
    assert filled.area + 1e-9 >= area


def test_touching_houses_of_one_height_are_one_and_a_tower_between_stays():
    row = [shapely.box(10 * k, 0, 10 * k + 10, 10) for k in range(4)]
    merged = merge(row, np.zeros(4), np.array([9.0, 9.2, 30.0, 9.0]), 0.5)
    assert sorted(polygon.area for polygon in merged.polygons) == [100, 100, 200]
    assert sorted(merged.high) == [9.0, 9.2, 30.0]


def test_twenty_thousand_footprints_take_seconds():
    rng = np.random.default_rng(1)
    angles = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    rings = np.stack([np.cos(angles), np.sin(angles)], axis=1)[None] * rng.uniform(4, 9, (20_000, 16, 1))
    rings += rng.uniform(0, 10_000, (20_000, 1, 2))
    shapes = shapely.polygons(rings)
    start = time.process_time()
    simpler = simplify(shapes, 0.5)
    merge(simpler, np.zeros(20_000), rng.uniform(5, 20, 20_000), 1.0)
    assert time.process_time() - start < 20
