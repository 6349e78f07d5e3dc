"""The order of strips beside all orders, and what it says beside its own sum."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skyverse.survey.strip_order import order_strips


def price_of(costs, strips, order, flipped, start, end):
    at, total = start, 0.0
    for strip, back in zip(order, flipped, strict=True):
        first, last = strips[strip][::-1] if back else strips[strip]
        total, at = total + costs[at, first] + costs[first, last], last
    return total + (0.0 if end is None else costs[at, end])


def plane_costs(rng, count, *, slower_back=1.0):
    """Return costs of places in the plane, of which strips are pairs; going west costs more."""
    places = rng.random((2 * count + 2, 2))
    gap = places[None] - places[:, None]
    return np.hypot(gap[..., 0], gap[..., 1]) * np.where(gap[..., 0] < 0, slower_back, 1.0)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.booleans(), st.booleans())
def test_five_strips_are_ordered_as_the_best_of_all_orders(seed, count, windy, closed):
    costs = plane_costs(np.random.default_rng(seed), count, slower_back=1.3 if windy else 1.0)
    strips = np.arange(2 * count).reshape(-1, 2)
    end = 2 * count + 1 if closed else None
    found = order_strips(costs, strips, 2 * count, end, rounds=300)
    assert found.cost == pytest.approx(price_of(costs, strips, found.order, found.flipped, 2 * count, end), rel=1e-12)
    best = min(
        price_of(costs, strips, order, flipped, 2 * count, end)
        for order in itertools.permutations(range(count))
        for flipped in itertools.product((False, True), repeat=count)
    )
    assert found.cost == pytest.approx(best, rel=1e-9)


def test_a_hundred_strips_side_by_side_are_flown_to_and_fro():
    count = 100
    ends = np.array([[(3.0 * i, 0.0), (3.0 * i, 50.0)] for i in range(count)])
    ends = ends[np.random.default_rng(1).permutation(count)].reshape(-1, 2)
    places = np.concatenate([ends, [(0.0, 0.0), (297.0, 0.0)]])
    costs = np.hypot(*np.moveaxis(places[None] - places[:, None], -1, 0))
    found = order_strips(costs, np.arange(2 * count).reshape(-1, 2), 2 * count, 2 * count + 1)
    assert found.cost == pytest.approx(count * 50 + 99 * 3)


def test_where_there_is_no_way_the_cost_is_infinite():
    costs = np.full((4, 4), np.inf)
    costs[0, 1] = costs[1, 0] = 1.0
    assert order_strips(costs, np.array([[0, 1]]), 2, 3).cost == np.inf


def test_no_strips_are_a_leg_home():
    assert order_strips(np.array([[0.0, 2.0], [2.0, 0.0]]), np.empty((0, 2), int), 0, 1).cost == 2.0
