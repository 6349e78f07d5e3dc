"""Proven lower bounds for whole objectives, beside exact optima and beside the best paths that are known."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize, minimize_scalar

import skyverse as sky
from skyverse.search.cheapest.lower_bound import lower_bound

CELLS = 20_000


def field(start, target, *, size=(100, 100, 40), **changes):
    return sky.Scenario(
        **{
            "name": "field",
            "bounds": sky.Bounds(min=(0, 0, 0), max=size),
            "clearance": 0.001,
            "lattice": sky.Lattice(step=(5, 5, 5), connectivity=26),
            "objective": sky.Objective(unit="metres", risk=1.0),
            "uavs": (sky.UAV(start=start),),
            "targets": (sky.Target(position=target),),
            **changes,
        }
    )


def bound_of(scenario, known, cells=CELLS):
    """Return the bound, turns not counted, where a path of price `known` is known; it is not above that price."""
    problem = sky.Problem(scenario)
    airspace = problem.airspace
    return lower_bound(airspace.world.space, airspace.rates, problem.start, problem.end, float(known), cells)


def test_without_anything_in_the_way_it_is_the_straight_way_over_the_map():
    assert bound_of(field((10, 20, 10), (90, 80, 30)), 200.0) == pytest.approx(100.0)


@pytest.mark.parametrize("risk", [0.3, 1.0, 4.0])
def test_at_the_edge_of_a_zone_it_is_just_below_the_price_of_the_refracted_path(risk):
    zone = sky.Box(min=(50, -10, -10), max=(110, 110, 50), risk=risk)
    scenario = field((10, 15, 20), (80, 85, 20), zones=(zone,))

    def price(y):
        return math.hypot(40, y - 15) + (1 + risk) * math.hypot(30, 85 - y)

    exact = minimize_scalar(price, bounds=(15, 85), method="bounded", options={"xatol": 1e-9}).fun
    assert 0.95 * exact <= bound_of(scenario, 1.2 * exact) <= exact


@pytest.mark.parametrize("risk", [0.2, 1.0, 50.0])
def test_beside_a_round_zone_it_is_just_below_the_cheapest_of_all_ways_around_and_through_it(risk):
    start, target, centre, radius = (10, 50), (90, 52), (50, 50), 25.0
    zone = sky.Cylinder(centre=centre, radius=radius, low=-10, high=50, risk=risk)
    scenario = field((*start, 20), (*target, 20), zones=(zone,))

    def on_circle(angle):
        return np.add(centre, radius * np.array([math.cos(angle), math.sin(angle)]))

    def leg(a, b):
        a, b = np.subtract(a, centre), np.subtract(b, centre)
        way = b - a
        shares = np.roots([way @ way, 2 * (a @ way), a @ a - radius**2]) if way @ way > 0 else np.zeros(2)
        inside = 0.0 if np.iscomplexobj(shares) else np.ptp(np.clip(shares, 0, 1))
        return math.hypot(*way) * (1 + risk * inside)

    def through(angles):
        a, b = on_circle(angles[0]), on_circle(angles[1])
        return leg(start, a) + leg(a, b) + leg(b, target)

    ways = [minimize(through, (math.pi - turn, turn), method="Nelder-Mead").fun for turn in (-1.0, 0.0, 1.0)]
    far, near = math.dist(start, centre), math.dist(target, centre)
    apart = math.acos(np.dot(np.subtract(start, centre), np.subtract(target, centre)) / far / near)
    arc = apart - math.acos(radius / far) - math.acos(radius / near)
    around = math.sqrt(far**2 - radius**2) + math.sqrt(near**2 - radius**2) + radius * arc
    exact = min(*ways, around)
    assert 0.95 * exact <= bound_of(scenario, 1.2 * exact) <= exact


def test_over_a_low_obstacle_and_under_a_high_zone_ways_are_no_dearer():
    low = sky.Box(min=(40, -10, -10), max=(60, 110, 20))
    high = sky.Box(min=(65, -10, 20), max=(80, 110, 50), risk=3.0)
    scenario = field((10, 50, 20), (90, 50, 20), obstacles=(low,), zones=(high,))
    assert bound_of(scenario, 100.0) == pytest.approx(80.0)


def layered_optimum(start, target, band, climb):
    """Return the price of the best of many paths over up to 16 altitudes, found by a general optimiser."""
    (x, y, z), (u, v, w) = start, target
    across = math.hypot(u - x, v - y)
    least = math.inf
    for turn in np.linspace(max(z, w), band.low, 3):
        heights = np.concatenate([np.linspace(z, turn, 9), np.linspace(turn, w, 9)])
        rises = np.abs(np.diff(heights))
        outside = np.maximum(0.0, band.low - (heights[1:] + heights[:-1]) / 2)

        def price(ways, rises=rises, outside=outside):
            ways = np.abs(ways) * across / np.abs(ways).sum()
            angles = np.arctan2(rises, ways)
            steep = 0.0 if climb is None else climb.weight * np.maximum(0.0, angles - math.radians(climb.angle))
            return float((np.hypot(ways, rises) * (1.0 + band.weight * outside + steep)).sum())

        first = np.ones(len(rises))
        first[8] = 16.0
        least = min(least, minimize(price, first, method="L-BFGS-B", options={"maxfun": 20000}).fun)
    return least


@pytest.mark.parametrize("climb", [None, sky.ClimbLimit(angle=5, weight=4), sky.ClimbLimit(angle=30, weight=0.5)])
@pytest.mark.parametrize(("start_z", "target_z"), [(2, 4), (2, 25), (10, 18)])
def test_below_the_altitude_band_it_counts_the_climbs(climb, start_z, target_z):
    band = sky.AltitudeBand(low=20, high=30, weight=0.05)
    objective = sky.Objective(unit="metres", altitude=band, climb=climb)
    start, target = (5, 50, start_z), (295, 50, target_z)
    scenario = field(start, target, size=(300, 100, 40), objective=objective)
    best = layered_optimum(start, target, band, climb)
    bound = bound_of(scenario, 1.3 * best)
    assert 290.0 + 0.6 * (best - 290.0) <= bound <= best
    upside_down = objective.model_copy(update={"altitude": sky.AltitudeBand(low=10, high=20, weight=0.05)})
    ends = {
        "uavs": (sky.UAV(start=(5, 50, 40 - start_z)),),
        "targets": (sky.Target(position=(295, 50, 40 - target_z)),),
    }
    mirrored = scenario.model_copy(update={"objective": upside_down, **ends})
    assert bound_of(mirrored, 1.3 * best) == pytest.approx(bound)


def corners(boxes, gap=1e-6):
    for box in boxes:
        (x, y, _), (u, v, _) = box.min, box.max
        yield from itertools.product((x - gap, u + gap), (y - gap, v + gap))


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 8), cells=st.sampled_from([500, 5_000]))
def test_among_high_boxes_it_is_at_most_the_shortest_path_over_their_corners(seed, count, cells):
    rng = np.random.default_rng(seed)
    boxes = []
    for x, y in rng.uniform(20, 80, (count, 2)):
        wide, deep = rng.uniform(2, 20, 2)
        boxes.append(sky.Box(min=(x - wide, y - deep, -1), max=(x + wide, y + deep, 41)))
    start, target = (1.0, float(rng.uniform(1, 99)), 20.0), (99.0, float(rng.uniform(1, 99)), 20.0)
    scenario = field(start, target, obstacles=tuple(boxes))
    world = sky.Airspace(scenario).world
    places = np.array([start, target, *((x, y, 20.0) for x, y in corners(boxes))])
    places = places[((places >= 0.0) & (places <= (100, 100, 40))).all(axis=1)]
    count = len(places)
    pairs = np.array(list(itertools.product(range(count), repeat=2)))
    free = world.segments_free(places[pairs[:, 0]], places[pairs[:, 1]]).reshape(count, count)
    price = np.where(free, np.linalg.norm(places[:, None] - places[None], axis=2), np.inf)
    least = np.full(count, np.inf)
    least[0] = 0.0
    for _ in range(count):
        least = np.minimum(least, (least[:, None] + price).min(axis=0))
    if math.isfinite(least[1]):
        assert bound_of(scenario, 1.2 * least[1], cells) <= least[1] + 1e-4  # paths pass the corners at a micrometre


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 10**6), threats=st.sampled_from([3, 10, 25]), cells=st.sampled_from([300, 3_000, 30_000]))
def test_no_path_among_random_threats_is_cheaper(seed, threats, cells):
    scenario = sky.random_threats(threats, seed=seed)
    rng = np.random.default_rng(seed)
    band = sky.AltitudeBand(low=50, high=70, weight=float(rng.choice([0.002, 0.02, 0.2])))
    climb = sky.ClimbLimit(angle=float(rng.uniform(0, 30)), weight=float(rng.choice([0.0001, 1.0, 10.0])))
    objective = scenario.objective.model_copy(update={"divergence": 0.0, "altitude": band, "climb": climb})
    ends = [
        (*position[:2], round(float(rng.uniform(10, 190)), 1))
        for position in (scenario.uavs[0].start, scenario.targets[0].position)
    ]
    scenario = scenario.model_copy(
        update={
            "objective": objective,
            "uavs": (scenario.uavs[0].model_copy(update={"start": ends[0]}),),
            "targets": (sky.Target(position=ends[1]),),
        }
    )
    planners = (sky.Taut(proof=0), sky.Cheapest(legs=50_000, proof=0))
    found = [planner.plan(sky.Problem(scenario)) for planner in planners]
    least = min((result.cost for result in found if result.status.reached and result.any_angle), default=math.inf)
    if math.isfinite(least):
        assert bound_of(scenario, 1.3 * least, cells) <= least
