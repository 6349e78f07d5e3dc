"""Strips that cover areas: in free space, all of the area seen or told, and no route faster than its bound."""

import itertools

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from skyverse.errors import InputError
from skyverse.survey.leg_time import LegTime
from skyverse.survey.lower_bound import any_strips_bound, these_strips_bound
from skyverse.survey.sweep import sweep
from skyverse.survey.visibility import shortest_ways

COST = LegTime(3.0, 1.0)
SQUARE = shapely.box(0, 0, 100, 100)


def blob(rng, centre, size, corners):
    """Return a random star-shaped polygon."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    reach = size * rng.uniform(0.3, 1.0, corners)
    return shapely.Polygon(centre + np.stack([reach * np.cos(angle), reach * np.sin(angle)], 1)).buffer(0)


def random_area(seed):
    rng = np.random.default_rng(seed)
    wanted = blob(rng, np.zeros(2), rng.uniform(60, 150), rng.integers(5, 15))
    zones = [blob(rng, rng.uniform(-120, 120, 2), rng.uniform(5, 40), rng.integers(3, 8)) for _ in range(seed % 21)]
    return wanted, shapely.box(-200, -200, 200, 200).difference(shapely.union_all(zones)), rng.uniform(4, 20)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["line", "swath"]))
def test_strips_and_ways_stay_free_and_what_they_do_not_see_is_told(seed, ends):
    wanted, free, width = random_area(seed)
    if wanted.intersection(free).area < width**2:
        return
    plan = sweep(wanted, free, width, cost=COST, ends=ends)
    grown = free.buffer(1e-5)
    assert shapely.covers(grown, shapely.linestrings(plan.strips)).all()
    ways = shortest_ways(free, plan.strips.reshape(-1, 2))
    for i in range(0, len(ways.price) - 1, 3):
        if np.isfinite(ways.price[i, i + 1]):
            assert grown.covers(shapely.LineString(ways.points(i, i + 1)))
    points = shapely.points(np.random.default_rng(seed).uniform(-150, 150, (1000, 2)))
    points = points[shapely.contains(wanted, points)]
    off = shapely.distance(points, shapely.multilinestrings(list(plan.strips)))
    assert (off[~shapely.dwithin(points, plan.unreached, 1e-5)] <= width / 2 + 1e-5).all()
    over = shapely.get_parts(plan.unreached.intersection(free))
    assert max(shapely.area(over), default=0.0) < 0.4 * width**2
    assert plan.bound.these_strips <= plan.route.cost * (1 + 1e-12)


def test_a_square_takes_as_many_strips_as_it_must():
    plan = sweep(SQUARE, SQUARE, 3.0, cost=COST, ends="line", start=np.zeros(2))
    assert len(plan.strips) == 34
    hops = 32 * 2 * np.sqrt(3.0) + 2 * np.sqrt(1.0) + 2 * np.sqrt(1.5)
    assert plan.route.cost == pytest.approx(34 * (100 / 3 + 3) + hops + 98.5 / 3 + 3, abs=1e-3)
    assert plan.bound.any_strips < plan.bound.these_strips <= plan.route.cost
    assert plan.unreached.area < 1e-3


def test_a_corner_of_the_area_that_a_hole_cuts_off_costs_no_line_across_it():
    """A line at the tip of a hole sees past it on both sides: 3 lines for what lines 3 m apart would take 4 for."""
    hole = shapely.Polygon([(4.4, 10), (6, 5), (7.6, 10), (6, 15)])
    plan = sweep(shapely.box(0, 0, 12, 20).difference(hole), None, 3.0, cost=COST, directions=np.array([[0.0, 1.0]]))
    assert len(plan.strips) <= 6


def test_swaths_reach_over_slanted_borders_and_lines_do_not():
    triangle = shapely.Polygon([(0, 0), (60, 0), (30, 50)])
    up = np.array([[0.0, 1.0]])
    lines = sweep(triangle, None, 6.0, cost=COST, ends="line", directions=up)
    swaths = sweep(triangle, None, 6.0, cost=COST, ends="swath", directions=up)
    along = [one.strips[one.cell >= 0] for one in (lines, swaths)]
    assert np.ptp(along[1][..., 1]) > np.ptp(along[0][..., 1]) + 1
    assert swaths.unreached.area < 0.1


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.5, 15.0))
def test_strips_end_as_much_earlier_as_is_seen_beyond_their_ends_and_see_no_less(seed, reach):
    wanted, free, width = random_area(seed)
    if wanted.intersection(free).area < width**2:
        return
    up = np.array([[0.0, 1.0]])
    full, short = (sweep(wanted, free, width, cost=COST, directions=up, reach=far) for far in (0.0, reach))
    long, ends = (np.sort(plan.strips[plan.cell >= 0][..., 1], axis=1) for plan in (full, short))
    assert (ends[:, 0] < ends[:, 1]).all()
    assert (ends[:, 0] >= long[:, 0] - 1e-9).all()
    assert (ends[:, 1] <= long[:, 1] + 1e-9).all()
    assert (ends[:, 0] - reach <= long[:, 0] + 1e-9).all()
    assert (ends[:, 1] + reach >= long[:, 1] - 1e-9).all()


def test_strips_over_a_square_end_half_a_photo_before_its_border():
    plan = sweep(SQUARE, SQUARE, 10.0, cost=COST, directions=np.array([[0.0, 1.0]]), reach=4.0)
    assert np.sort(plan.strips[..., 1], axis=1) == pytest.approx(np.tile([4.0, 96.0], (10, 1)))
    assert plan.unreached.area < 1e-3


def test_a_zone_that_cuts_an_area_in_two_leaves_strips_on_both_sides():
    free = shapely.union(shapely.box(0, 0, 45, 100), shapely.box(55, 0, 100, 100))
    plan = sweep(SQUARE, free, 10.0, cost=COST, start=np.zeros(2))
    assert {True, False} == set(plan.strips[:, 0, 0] < 50)
    assert plan.route.cost == np.inf
    assert 0 < plan.unreached.area < 1000


def test_offsets_may_be_given():
    asked = []

    def offsets(way, area, low, high):
        asked.append((tuple(way), area.area, low, high))
        return np.array([low + 10, high - 30, high + 5])

    plan = sweep(SQUARE, None, offsets, cost=COST, directions=np.array([[0.0, 2.0]]))
    assert len(plan.strips) == 2
    assert {area for _, area, _, _ in asked} == {10000.0}
    assert set(np.round(plan.strips[..., 0].ravel())) in ({10.0, 70.0}, {90.0, 30.0})


def test_wind_along_strips_makes_lines_across_it_faster():
    def ground_speed(units):  # 4 m/s of wind from the west, at 5 m/s through the air
        return units[..., 0] * 4 + np.sqrt(25 - (units[..., 1] * 4) ** 2)

    windy = LegTime(5.0, 1.0, ground_speed=ground_speed)
    plan = sweep(SQUARE, None, 10.0, cost=windy, directions=np.eye(2))
    assert abs(plan.directions[0, 1]) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("width", "free", "field"), [(0.0, None, "width"), (np.nan, None, "width"), (0.01, None, "width")]
)
def test_widths_that_cannot_be_are_refused(width, free, field):
    with pytest.raises(InputError) as refused:
        sweep(SQUARE, free, width, cost=COST)
    assert refused.value.sentence.field == field


def test_an_area_inside_a_zone_is_refused():
    with pytest.raises(InputError) as refused:
        sweep(SQUARE, shapely.box(200, 0, 300, 100), 3.0, cost=COST)
    assert refused.value.sentence.field == "free"


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_no_order_of_strips_is_below_the_bound(seed, count):
    rng = np.random.default_rng(seed)
    places = rng.random((2 * count + 2, 2))
    costs = np.hypot(*np.moveaxis(places[None] - places[:, None], -1, 0)) * rng.uniform(1, 1.2, (2 * count + 2,) * 2)
    strips = np.arange(2 * count).reshape(-1, 2)
    best = np.inf
    for order in itertools.permutations(range(count)):
        for flipped in itertools.product((0, 1), repeat=count):
            at, total = 2 * count, 0.0
            for strip, back in zip(order, flipped, strict=True):
                total += costs[at, 2 * strip + back] + costs[2 * strip + back, 2 * strip + 1 - back]
                at = 2 * strip + 1 - back
            best = min(best, total + costs[at, 2 * count + 1])
    bound = these_strips_bound(costs, strips, 2 * count, 2 * count + 1)
    assert bound <= best + 1e-9
    assert bound > 0.5 * best


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(0.1, 50.0), min_size=1, max_size=8))
def test_no_strips_of_a_length_in_all_are_faster_than_the_bound(lengths):
    legs = np.array([[length, 0.0] for length in lengths])
    bound = any_strips_bound(sum(lengths), 50.0, COST)
    assert bound <= COST(legs).sum() + 1e-9
    assert any_strips_bound(100.0, 50.0, COST) == pytest.approx(2 * (50 / 3 + 3))
