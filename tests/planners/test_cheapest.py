"""Cheap any-angle paths: exact answers, other planners' answers, and what must hold of every answer."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize, minimize_scalar

import skyverse as sky


def field(start, target, *, size=(20, 20, 10), **changes):
    return sky.Scenario(
        **{
            "name": "field",
            "bounds": sky.Bounds(min=(0, 0, 0), max=size),
            "clearance": 0.001,
            "lattice": sky.Lattice(step=(1, 1, 1), connectivity=26),
            "objective": sky.Objective(unit="metres"),
            "uavs": (sky.UAV(start=start),),
            "targets": (sky.Target(position=target),),
            **changes,
        }
    )


def planned(scenario, **given_settings):
    result = sky.Cheapest(**given_settings).plan(sky.Problem(scenario))
    assert sky.check_result(scenario, 0, 0, result) == []
    assert result.status.reached
    return result


@pytest.mark.parametrize("risk", [0.3, 1.0, 4.0])
def test_at_the_edge_of_a_zone_a_path_is_refracted_as_light_is(risk):
    zone = sky.Box(min=(10, -1, -1), max=(21, 21, 11), risk=risk)
    scenario = field((2, 3, 5), (16, 17, 5), zones=(zone,), objective=sky.Objective(unit="metres", risk=1.0))

    def price(y):
        return math.hypot(8, y - 3) + (1 + risk) * math.hypot(6, 17 - y)

    exact = minimize_scalar(price, bounds=(3, 17), method="bounded", options={"xatol": 1e-9}).fun
    assert exact <= planned(scenario).cost <= exact * 1.00001


@pytest.mark.parametrize("weight", [0.05, 0.5])
def test_a_path_climbs_into_the_band_as_far_as_that_pays(weight):
    band = sky.AltitudeBand(low=6, high=8, weight=weight)
    objective = sky.Objective(unit="metres", altitude=band)
    scenario = field((1, 10, 1), (59, 10, 1), size=(60, 20, 10), objective=objective)

    def price(at):  # up to the band and down from it in straight legs, symmetric
        x, z = at
        climb = math.hypot(x, z - 1)
        mean_below = 5 - (z - 1) / 2 if z <= 6 else 2.5 * 5 / (z - 1)
        return 2 * climb * (1 + weight * mean_below) + (58 - 2 * x) * (1 + weight * max(0.0, 6 - z))

    exact = min(minimize(price, (8, z), method="Nelder-Mead", options={"xatol": 1e-8}).fun for z in (1.5, 4, 6))
    cost = planned(scenario).cost
    assert cost <= exact * 1.0001  # more joints, in curves, may be a little cheaper
    assert cost >= 58


def corners(boxes, gap=1e-6):
    for box in boxes:
        (x, y, _), (u, v, _) = box.min, box.max
        yield from itertools.product((x - gap, u + gap), (y - gap, v + gap))


def cheapest_over_corners(scenario, turn):
    """Return the price of the cheapest path over the corners of boxes that reach from floor to ceiling (Dijkstra)."""
    world = sky.Airspace(scenario).world
    z = scenario.uavs[0].start[2]
    places = np.array([scenario.uavs[0].start, *((x, y, z) for x, y in corners(scenario.obstacles))])
    places = np.vstack([places, scenario.targets[0].position])
    inside = ((places >= scenario.bounds.min) & (places <= scenario.bounds.max)).all(axis=1)
    places = places[inside]
    count = len(places)
    pairs = np.array(list(itertools.product(range(count), repeat=2)))
    free = world.segments_free(places[pairs[:, 0]], places[pairs[:, 1]]).reshape(count, count)
    length = np.linalg.norm(places[:, None] - places[None], axis=2)
    price = np.where(free, length + turn, np.inf)  # each joint but the last is a turn
    least = np.full(count, np.inf)
    least[0] = -turn
    for _ in range(count):
        least = np.minimum(least, (least[:, None] + price).min(axis=0))
    return least[-1]


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 8), turn=st.sampled_from([0.0, 0.5, 3.0]))
def test_among_high_boxes_no_path_over_their_corners_is_cheaper(seed, count, turn):
    rng = np.random.default_rng(seed)
    boxes = []
    for x, y in rng.uniform(4, 16, (count, 2)):
        wide, deep = rng.uniform(0.5, 3, 2)
        boxes.append(sky.Box(min=(x - wide, y - deep, -1), max=(x + wide, y + deep, 11)))
    scenario = field(
        (0.5, float(rng.uniform(1, 19)), 5),
        (19.5, float(rng.uniform(1, 19)), 5),
        obstacles=tuple(boxes),
        objective=sky.Objective(unit="metres", divergence=turn),
    )
    exact = cheapest_over_corners(scenario, turn)
    if not math.isfinite(exact):
        return
    assert planned(scenario, legs=200_000).cost <= exact * 1.001


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 10**6), threats=st.sampled_from([5, 15, 30]))
def test_it_is_never_dearer_than_the_paths_that_it_begins_with(seed, threats):
    scenario = sky.random_threats(threats, seed=seed)
    problem = sky.Problem(scenario)
    others = [planner.plan(problem) for planner in (sky.Taut(), sky.AStar())]
    cost = planned(scenario, legs=20_000).cost
    assert cost <= min(other.cost for other in others if other.status.reached)
    assert cost >= max(other.bound for other in others[:1] if other.bound is not None) * 0.999999


def test_more_legs_find_no_dearer_path_on_a_field_of_threats():
    scenario = sky.random_threats(30, seed=7005)
    costs = [planned(scenario, legs=legs).cost for legs in (0, 500_000)]
    assert costs[1] < 0.97 * costs[0]


def test_over_the_ridges_of_jacksboro_it_saves_six_percent_of_the_lattices_path():
    scenario = sky.jacksboro()
    problem = sky.Problem(scenario)
    result = sky.Cheapest(legs=0).plan(problem)
    assert sky.check_result(scenario, 0, 0, result) == []
    assert result.cost < 0.94 * sky.AStar().plan(problem).cost
    assert result.cost < 9753 * 1.002  # a random descent of 25 seconds found 9,753


def test_the_proof_raises_the_bound_above_the_straight_line_and_none_below_0_is_accepted():
    problem = sky.Problem(sky.random_threats(15, seed=0))
    straight, proven = (sky.Cheapest(legs=50_000, proof=proof).plan(problem) for proof in (0, 20_000))
    assert straight.bound <= math.dist(problem.start, problem.end) + problem.scenario.objective.divergence
    assert not proven.straight_bound
    assert straight.cost == proven.cost
    assert straight.bound + 80 < proven.bound < proven.cost
