"""Strips that cover areas: in free space, all of the area seen but corners, and not more of them than it takes."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from skyverse.survey.leg_time import LegTime
from skyverse.survey.sweep import sweep

COST = LegTime(3.0, 1.0)
SQUARE = shapely.box(0, 0, 100, 100)
AROUND = shapely.box(-500, -500, 500, 500)


def unseen(area, plan, width, beyond=0.0):
    """Return what of an area is farther than half a width from strips that see so many metres beyond their ends."""
    legs = plan.strips[:, 1] - plan.strips[:, 0]
    on = beyond * legs / np.hypot(*legs.T)[:, None]
    seen = shapely.buffer(shapely.linestrings(np.stack([plan.strips[:, 0] - on, plan.strips[:, 1] + on], 1)), width / 2)
    return area.difference(shapely.union_all(seen, grid_size=1e-6))


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
def test_strips_stay_free_and_leave_small_corners_open(seed, ends):
    wanted, free, width = random_area(seed)
    if wanted.intersection(free).area < width**2:
        return
    plan = sweep(wanted, free, width, cost=COST, ends=ends)
    grown = free.buffer(1e-5)
    assert shapely.covers(grown, shapely.linestrings(plan.strips)).all()
    over = shapely.get_parts(unseen(wanted.intersection(free), plan, width))
    assert max(shapely.area(over), default=0.0) < 0.4 * width**2


def test_a_square_takes_as_many_strips_as_it_must():
    plan = sweep(SQUARE, SQUARE, 3.0, cost=COST, ends="line", start=np.zeros(2))
    assert len(plan.strips) == 34
    assert unseen(SQUARE, plan, 3.0).area < 1e-3


def test_a_corner_of_the_area_that_a_hole_cuts_off_costs_no_line_across_it():
    """A line at the tip of a hole sees past it on both sides: 3 lines for what lines 3 m apart would take 4 for."""
    hole = shapely.Polygon([(4.4, 10), (6, 5), (7.6, 10), (6, 15)])
    plan = sweep(shapely.box(0, 0, 12, 20).difference(hole), AROUND, 3.0, cost=COST, directions=np.array([[0.0, 1.0]]))
    assert len(plan.strips) <= 6


def test_swaths_reach_over_slanted_borders_and_lines_do_not():
    triangle = shapely.Polygon([(0, 0), (60, 0), (30, 50)])
    up = np.array([[0.0, 1.0]])
    lines = sweep(triangle, AROUND, 6.0, cost=COST, ends="line", directions=up)
    swaths = sweep(triangle, AROUND, 6.0, cost=COST, ends="swath", directions=up)
    along = [one.strips[one.cell >= 0] for one in (lines, swaths)]
    assert np.ptp(along[1][..., 1]) > np.ptp(along[0][..., 1]) + 1
    assert unseen(triangle, swaths, 6.0).area < 0.1


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
    assert unseen(SQUARE, plan, 10.0, beyond=4.0).area < 1e-3


def test_a_zone_that_cuts_an_area_in_two_leaves_strips_on_both_sides():
    free = shapely.union(shapely.box(0, 0, 45, 100), shapely.box(55, 0, 100, 100))
    plan = sweep(SQUARE, free, 10.0, cost=COST, start=np.zeros(2))
    assert {True, False} == set(plan.strips[:, 0, 0] < 50)
    assert unseen(free.intersection(SQUARE), plan, 10.0).area < 1e-3


def test_offsets_may_be_given():
    asked = []

    def offsets(way, area, low, high):
        asked.append((tuple(way), area.area, low, high))
        return np.array([low + 10, high - 30, high + 5])

    plan = sweep(SQUARE, AROUND, offsets, cost=COST, directions=np.array([[0.0, 2.0]]))
    assert len(plan.strips) == 2
    assert {area for _, area, _, _ in asked} == {10000.0}
    assert set(np.round(plan.strips[..., 0].ravel())) in ({10.0, 70.0}, {90.0, 30.0})
