"""Soft terms over zones of every shape and above ground, against dense sampling and an oracle."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from depths import above, inside
from skyverse import cost
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Terrain, Voxels
from soft_terms import climb_term, risk_term

SQUARE = ((2.0, 2.0), (7.0, 2.0), (7.0, 7.0), (2.0, 7.0))
HOLE = ((3.0, 3.0), (6.0, 3.5), (5.0, 6.0), (3.5, 5.5))
ZONES = [
    Box(min=(1, 2, 3), max=(8, 7, 6), risk=2.0),
    Cylinder(centre=(4, 5), radius=3, low=1, high=8, risk=0.5),
    Sphere(centre=(5, 4, 5), radius=3.5, risk=1.0),
    Prism(vertices=SQUARE, holes=(HOLE,), low=1, high=9, risk=3.0),
    Voxels(
        origin=(0.5, -0.5, 1), step=(2, 2.5, 2), occupied=np.random.default_rng(0).random((5, 4, 5)) < 0.4, risk=1.5
    ),
]
COUNT = 8_000
anywhere = st.lists(st.tuples(*[st.floats(0, 10)] * 3), min_size=2, max_size=4)


def world(*zones, terrain=None, band=None):
    return sky.Scenario(
        name="soft",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 10)),
        zones=zones,
        clearance=0.5,
        lattice=sky.Lattice(step=(1, 1, 1)),
        terrain=terrain,
        objective=sky.Objective(unit="metres", altitude=band),
    )


def terms(scenario, path):
    return cost.terms_of_legs(scenario, cost.make_rates(scenario), path, path[-1])


def middles(a, b):
    return a + ((np.arange(COUNT) + 0.5) / COUNT)[:, None] * (b - a)


@pytest.mark.parametrize("zone", ZONES, ids=lambda zone: zone.shape)
@given(points=anywhere)
def test_metres_inside_a_zone_are_what_sampling_says(zone, points):
    path = np.array(points)
    with np.errstate(all="ignore"):
        stands, least, most = risk_term(world(zone), path)
    seen = sum(
        zone.risk * np.linalg.norm(b - a) * np.mean(inside(zone, 0.0, middles(a, b)) > 0) for a, b in pairwise(path)
    )
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    room = 40 * zone.risk * length / COUNT  # a sample at each crossing
    assert least - room <= seen <= most + room
    assert least <= stands <= most
    assert least - 1e-6 <= terms(world(zone), path)["risk"] <= most + 1e-6


def test_a_chord_of_a_sphere_and_a_leg_across_a_courtyard_are_known():
    path = np.array([(0, 4, 8), (10, 4, 8)], float)
    assert risk_term(world(ZONES[2]), path)[0] == pytest.approx(2 * np.sqrt(3.5**2 - 3**2))
    courtyard = Prism(vertices=SQUARE, holes=(((3, 3), (6, 3), (6, 6), (3, 6)),), low=0, high=9, risk=1.0)
    assert risk_term(world(courtyard), np.array([(0, 4, 5), (10, 4, 5)], float))[0] == pytest.approx(2)


def test_a_leg_along_the_face_between_two_voxels_is_counted_once():
    solid = Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=np.ones((4, 4, 4)), risk=1.0)
    assert risk_term(world(solid), np.array([(0, 2, 2), (10, 2, 2)], float)) == pytest.approx((4, 4, 4))
    _, least, most = risk_term(world(solid), np.array([(0, 4, 2), (10, 4, 2)], float))
    assert (least, most) == pytest.approx((0, 4))


@given(anywhere, st.integers(0, 999), st.floats(0, 3), st.floats(0, 4))
def test_metres_outside_a_band_above_ground_are_what_sampling_says(points, seed, low, wide):
    rng = np.random.default_rng(seed)
    shape = rng.integers(2, 9, 2)
    terrain = Terrain(origin=(0, 0), step=tuple(10 / (shape - 1)), heights=rng.uniform(0, 4, shape), clearance=0.001)
    band = sky.AltitudeBand(low=low, high=low + wide, weight=1.0, above="ground")
    scenario, path = world(terrain=terrain, band=band), np.array(points)
    seen = 0.0
    for a, b in pairwise(path):
        at = middles(a, b)
        height = at[:, 2] - above(terrain, at[:, :2])
        outside = np.maximum(0, np.maximum(band.low - height, height - band.high))
        seen += float(np.linalg.norm(b - a) * outside.mean())
    assert terms(scenario, path)["altitude"] == pytest.approx(seen, abs=1e-4)


@pytest.mark.parametrize("ground", [False, True])
def test_a_climb_through_a_band_above_sea_pays_a_triangle_below_it_and_one_above_it(ground):
    band = sky.AltitudeBand(low=2, high=6, weight=1, above="zero" if ground else None)
    terrain = Terrain(origin=(0, 0), step=(10, 10), heights=np.full((2, 2), 1.0)) if ground else None
    scenario = world(terrain=terrain, band=band)
    climb = np.array([(0, 0, 0), (6, 0, 8)], float)  # 10 m of way, of which 2.5 m are below and 2.5 m above the band
    assert terms(scenario, climb)["altitude"] == pytest.approx(2.5 * 2 / 2 + 2.5 * 2 / 2)
    level = np.array([(0, 0, 9), (4, 0, 9), (4, 0, 5), (0, 0, 5)], float)
    assert terms(scenario, level)["altitude"] == pytest.approx(4 * 3 + 3 * 3 / 2)


def test_a_level_leg_over_a_slope_pays_a_triangle():
    terrain = Terrain(origin=(0, 0), step=(5, 10), heights=[[0, 0], [5, 5], [10, 10]])
    scenario = world(terrain=terrain, band=sky.AltitudeBand(low=2, high=100, weight=1, above="ground"))
    leg = np.array([(0, 3, 10), (10, 3, 10)], float)  # above ground 10 at first, 0 at last: below 2 over the last 2 m
    assert terms(scenario, leg)["altitude"] == pytest.approx(2.0)
    assert terms(scenario, leg[::-1])["altitude"] == pytest.approx(2.0)


def test_of_a_climb_what_is_steeper_than_the_limit_is_paid_upwards_and_downwards():
    path = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 1], [2, 0, 3.0]])  # level, at rest, diagonal, upright
    due = np.sqrt(2) * np.radians(25) + 2 * np.radians(70)
    for way in (path, path[::-1]):
        assert climb_term(sky.ClimbLimit(angle=20, weight=3.0), way) == pytest.approx(due)


def test_the_risk_as_it_is_is_that_of_the_path_as_it_is():
    box = Box(min=(1, 2, 3), max=(8, 7, 6), risk=2.0)
    as_it_is, least, most = risk_term(world(box), np.array([[0.0, 3.0, 3.5], [5.0, 6.0, 5.0]]))
    length = np.linalg.norm([5.0, 3.0, 1.5])
    assert as_it_is == pytest.approx(2 * length * 4 / 5, abs=1e-12)
    assert least < as_it_is - 1e-8
    assert most > as_it_is + 1e-8


def test_zones_of_which_there_are_none_have_no_risk():
    assert risk_term(world(), np.array([[0.0, 3.0, 3.5], [9.0, 6.0, 5.0]])) == (0.0, 0.0, 0.0)
