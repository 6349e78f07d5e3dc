"""The roadmap: what priced paths show of legs, and the cheapest way over them."""

import itertools

import numpy as np
import pytest

import skyverse as sky
from skyverse import cost
from skyverse.planners.base import provenance
from skyverse.planners.roadmap import _cheapest_path, explore_roadmap, make_roadmap
from skyverse.planners.straight_legs import open_straight_run

FIELD = sky.Problem(sky.random_threats(15, seed=300))


@pytest.fixture
def run():
    rng = np.random.default_rng(1)
    origin = provenance("", None, 1)
    opened = open_straight_run(FIELD, sky.MaxEvaluations(60), rng, origin, population=6, joints=6, collision=0.0)
    return opened, make_roadmap(opened.task, opened.paths, rng, 8)


def test_what_is_known_of_a_leg_is_its_price(run):
    opened, roadmap = run
    course, rates = opened.task, opened.task.rates
    assert explore_roadmap(course, opened.workspace, opened.paths, opened.best, opened.rng, roadmap)
    known = np.argwhere(roadmap.known)
    assert len(known)
    for a, b in known:
        fuel, turns, _, *soft = cost.legs(rates, roadmap.points[[a, b]], course.goal)
        assert turns == 0
        assert roadmap.price[a, b] == pytest.approx(fuel + sum(soft))
    assert opened.workspace.spent[2] <= 60
    assert opened.best.cost[0] < np.inf


def test_the_cheapest_way_is_that_of_brute_force(run):
    opened, roadmap = run
    turn = opened.task.rates.turn
    rng = np.random.default_rng(7)
    for _ in range(20):
        price = rng.uniform(1, 100, (8, 8))
        price[rng.random((8, 8)) < 0.4] = np.inf
        price = np.minimum(price, price.T)
        np.fill_diagonal(price, np.inf)
        roadmap.price[:] = price
        way = np.empty(8, np.int64)
        n = _cheapest_path(opened.task, roadmap, way)
        least = np.inf
        for count in range(7):
            for between in itertools.permutations(range(2, 8), count):
                legs = [price[a, b] for a, b in itertools.pairwise((0, *between, 1))]
                least = min(least, sum(legs) + turn * count)
        if n == 0:
            assert least == np.inf
        else:
            assert (way[0], way[n - 1]) == (0, 1)
            found = sum(price[a, b] for a, b in itertools.pairwise(way[:n])) + turn * (n - 2)
            assert found == pytest.approx(least)


def test_it_ends_when_nothing_is_worth_pricing(run):
    opened, roadmap = run
    roadmap.price[:] = np.inf  # no way at all: fresh places are drawn, and then it gives up or finds one
    before = opened.workspace.spent.copy()
    while explore_roadmap(opened.task, opened.workspace, opened.paths, opened.best, opened.rng, roadmap):
        if opened.workspace.spent[2] >= 60:
            break
    assert (opened.workspace.spent >= before).all()
