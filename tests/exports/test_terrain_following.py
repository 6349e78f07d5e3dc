"""Legs and corners with altitudes above ground are clear as they are flown, over every ground that may be known."""

import numpy as np
import pytest

import skyverse as sky
import terrain_follower as follower
from skyverse import Terrain, to_local, to_wgs84
from skyverse.exports import LegChecker, LegSpace, refused

ORIGIN = sky.Origin(latitude=46.8, longitude=9.85, altitude=1500.0)
ALLOWANCE = 0.02
EXACT, GNSS = sky.TrackingError(), sky.TrackingError(horizontal=1.5, vertical=1.0)


def rough(rng, gap):
    """Rough ground, and one below it that is lower by up to some metres."""
    step = float(rng.choice([4.0, 10.0, 40.0]))
    count = int(400 / step) + 1
    x = np.linspace(0, 400, count)
    heights = rng.uniform(0, 0.5 * step, (count, count)) + 0.2 * x[:, None] * rng.uniform(-1, 1)
    heights += np.where(x > rng.uniform(100, 300), rng.uniform(0, 15), 0.0)[:, None]  # a cliff
    lowest = heights - rng.uniform(0, gap, heights.shape) if gap else None
    return Terrain(origin=(-200, -200), step=(step, step), heights=heights, clearance=2.0, lowest=lowest)


def random_case(seed):
    """A scenario, the heights above ground of a polyline in it, an acceptance radius, and stops."""
    rng = np.random.default_rng(seed)
    terrain = rough(rng, float(rng.choice([0.0, 1.5])))
    boxes = []
    for _ in range(12):
        middle, half = rng.uniform(-130, 130, 2), rng.uniform(2, 15, 2)
        base = float(terrain.height(middle))
        boxes.append(sky.Box(min=(*(middle - half), base - 40), max=(*(middle + half), base + rng.uniform(5, 20))))
    places = rng.uniform(-120, 120, (5, 2))
    above = np.column_stack([places, rng.uniform(0, 12, 5)])
    scenario = sky.Scenario(
        name="rough",
        bounds=sky.Bounds(min=(-200, -200, -300), max=(200, 200, 400)),
        clearance=1.0,
        terrain=terrain,
        obstacles=boxes,
        max_height=300.0,
        lattice=sky.Lattice(step=(20, 20, 20)),
        uavs=[{"start": (0, 0, 350)}],
        targets=[{"position": (10, 0, 350)}],
        frame=sky.Frame(origin=ORIGIN),
    )
    return scenario, above, float(rng.choice([0.5, 2.0, 6.0])), (rng.random(5) < 0.2).astype(float), rng


def proven(scenario, error, above, radius, stops, lift=0.0):
    """Whether a polyline, given by heights above ground that are raised by some metres, is proven."""
    points = above.copy()
    points[:, 2] += lift + follower.height(scenario.terrain, scenario.terrain.heights, above[:, :2])
    legs = LegChecker(LegSpace(scenario, "agl"), error)
    line = points, radius, stops
    return legs.trouble(*line) is None and not refused([legs], [line])


def least_lift(scenario, error, above, radius, stops):
    """The least metres, to a centimetre, by which a polyline can be raised so that it is proven."""
    low, high = -12.0, 120.0
    assert proven(scenario, error, above, radius, stops, high)
    while high - low > 0.01:
        middle = (low + high) / 2
        if proven(scenario, error, above, radius, stops, middle):
            high = middle
        else:
            low = middle
    return high


def assert_clear_as_flown(seed, error):
    scenario, above, radius, stops, rng = random_case(seed)
    above[:, 2] += least_lift(scenario, error, above, radius, stops)
    nominal = follower.ways(above, radius, stops, rng, steps=400, count=8)
    high = []
    for _ in range(6):
        points = follower.flown(scenario, nominal, error, rng)
        obstacle, ground, ceiling = follower.rooms(scenario, points)
        assert obstacle >= -ALLOWANCE
        assert ground >= -ALLOWANCE
        high.append(scenario.max_height - ceiling)
    # the lowest ceiling below which it is proven is not below what is flown
    limit = max(high) - 0.01
    assert not proven(scenario.model_copy(update={"max_height": limit}), error, above, radius, stops)
    higher = scenario.model_copy(update={"max_height": limit + 40.0})
    assert proven(higher, error, above, radius, stops)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_proven_with_altitudes_above_ground_is_clear_as_flown(seed):
    assert_clear_as_flown(seed, (EXACT, GNSS)[seed % 2])


@pytest.mark.parametrize("seed", [*range(4, 20), *range(100, 140)])
def test_what_is_proven_of_many_more_is_clear_as_flown(seed):
    assert_clear_as_flown(seed, (EXACT, GNSS)[seed % 2])


def test_a_leg_that_bends_sideways_over_a_slope_follows_the_ground_there():
    slope, length = 2.0, 5_000.0
    plane = [[12e3, -12e3], [12e3, -12e3]]
    ground = Terrain(origin=(-6e3, -6e3), step=(12e3, 12e3), heights=plane, clearance=5.0)
    a, b = np.array([0.0, 0.0, 100.0]), np.array([length, 0.0, 100.0])
    origin = sky.Origin(latitude=60, longitude=10, altitude=0)
    scenario, *_ = random_case(0)
    changes = {"terrain": ground, "frame": sky.Frame(origin=origin), "obstacles": ()}
    legs = LegChecker(LegSpace(scenario.model_copy(update=changes), "agl"))
    globe = to_wgs84(origin, np.stack([a, b]))
    flown = to_local(origin, globe[0] + np.linspace(0, 1, 101)[:, None] * (globe[1] - globe[0]))
    flown[:, 2] = follower.height(ground, ground.heights, flown[:, :2]) + 100.0
    aside, off = np.abs(flown[:, 1]).max(), np.linalg.norm(flown[:, 1:] - a[1:], axis=1).max()
    assert off > 2 * aside > 1.0
    assert off <= legs.deviations(np.stack([a, b]), 0.0, np.ones(2))[0] <= 3 * off * (1 + 1 / slope)
