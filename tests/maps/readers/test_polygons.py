"""Outlines that cross themselves, leave their holes, or have no area or width."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")
pytest.importorskip("pyogrio")

from zones import COURT, SQUARE, ZONE, collection, feature, outcome, polygon  # noqa: E402

GEOD = pyproj.Geod(ellps="WGS84")


def test_a_zone_is_its_outline_its_holes_and_its_limits(read):
    (zone,) = read(collection(feature([SQUARE, COURT], name="Lake", kind="Polygon")))
    assert zone.outline.tolist() == SQUARE[:-1]
    assert [hole.tolist() for hole in zone.holes] == [COURT[:-1]]
    assert (zone.low, zone.high, zone.kind, zone.name, zone.risk) == (None, None, "no-fly zone", "Lake", None)
    assert zone.where.endswith("zones.geojson: feature 1")


@given(st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), min_size=3, max_size=9))
def test_a_repaired_outline_loses_nothing_that_it_winds_around(tmp_path_factory, corners):
    path = tmp_path_factory.mktemp("zones") / "zones.geojson"
    ring = [[7 + x / 1024, 47 + y / 1024] for x, y in corners]
    path.write_text(json.dumps(collection(feature([ring]))))
    meant = shapely.Polygon(ring)
    odd_even = shapely.make_valid(meant, method="linework")
    told = []
    found, message = outcome(path, tell=told.append)
    if found is None:
        assert "without an area" in message
        assert odd_even.area < 1e-12
        return
    whole = shapely.union_all([polygon(one) for one in found])
    assert whole.buffer(1e-9).covers(odd_even.buffer(0))
    assert whole.difference(meant.convex_hull.buffer(1e-9)).area < 1e-15
    assert all(polygon(one).is_valid for one in found)
    assert bool(told) == (not meant.is_valid)


def test_an_outline_that_goes_around_twice_has_no_hole(read):
    twice = [[7, 47], [7.003, 47], [7.003, 47.003], [7, 47.003], [7, 47.001], [7.001, 47.001]]
    twice += [[7.002, 47.001], [7.002, 47.002], [7.001, 47.002], [7.001, 47]]
    (zone,) = read(collection(feature([twice])))
    assert not zone.holes
    assert polygon(zone).covers(shapely.Point(7.0015, 47.0015))


def test_holes_that_leave_the_outline_are_filled_rather_than_cutting_it(read):
    outside = [[x + 0.0005, y] for x, y in SQUARE]
    told = []
    (zone,) = read(collection(feature([SQUARE, outside])), tell=told.append)
    assert polygon(zone).equals(shapely.Polygon(SQUARE))
    assert "repaired" in told[0]


def test_unclosed_rings_repeated_corners_and_altitudes_of_zero_change_nothing(read):
    ring = [[*place, 0.0] for place in [SQUARE[0], *SQUARE[:-1]]]
    (zone,) = read(collection(feature([ring])))
    assert polygon(zone).equals(shapely.Polygon(SQUARE))
    assert len(zone.outline) == 4


def test_lines_and_points_get_a_width_or_are_refused(read, refuses):
    line = feature([[7.0, 47.0], [7.01, 47.0]], "LineString")
    with refuses():
        read(collection(line))
    with refuses():
        read(collection(feature([7.0, 47.0], "Point")))
    (disc,) = read(collection(feature([7.0, 47.0], "Point", radius="50 m", **ZONE)))
    assert abs(GEOD.geometry_area_perimeter(polygon(disc))[0]) == pytest.approx(math.pi * 50**2, rel=0.01)
    (strip,) = read(collection(line), buffer=20.0)
    length = GEOD.inv(7.0, 47.0, 7.01, 47.0)[2]
    area = abs(GEOD.geometry_area_perimeter(polygon(strip))[0])
    assert length * 40 + math.pi * 400 <= area <= (length * 40 + math.pi * 400) * 1.02


def test_long_edges_have_corners_between_and_lose_nothing(read):
    (zone,) = read(collection(feature([[[7, 47], [7.5, 47], [7.25, 47.5]]])))
    steps = np.hypot(*(zone.outline - np.roll(zone.outline, 1, axis=0)).T)
    assert steps.max() <= 0.005 + 1e-12
    assert polygon(zone).area == pytest.approx(0.125, rel=1e-12)
