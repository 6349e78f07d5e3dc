"""Safe places near one that is not, and safe ways from place to place: straight seen from above, or around."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.leg_space import grown
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Lattice, Scenario, Target
from skyverse.model.uav import TrackingError
from skyverse.planners.auto import Auto
from skyverse.problem import Problem
from skyverse.space.world import World
from skyverse.waypoints.taut_line import taut_line, with_fewer_bends

SPARE = 0.1
"""Metres that are kept beyond what is required, as files round."""
SAMPLE = 1.0
"""Metres between the places of a leg at which it is asked how high is safe; more of them on long legs are sparser."""
MIN_SAMPLES, MAX_SAMPLES = 20, 1500
LONGER = 0.005
"""The share by which a leg may be longer over the ground so that it has fewer bends."""
CUT = 0.15
"""Metres that a bend of some 17 degrees is cut lower for each metre of its radius: the sine of half its angle."""
DIRECTIONS = 72
FARTHEST = 500.0
"""Metres by which a place is moved to the side at most."""
AROUND = 150.0
"""Metres about a leg in which a way around is sought at least."""
SLACK, LEAST_SLACK = 1.0, 0.25
"""Metres that ways around are sought farther off than they must be, so that they can have fewer bends."""


def above(world: World, place: Floats) -> Floats | None:
    """Return the lowest safe place above one, (3,) metres, or ``None``."""
    found = place.copy()
    for _ in range(100):
        up = world.way_out_above(found)
        if up is None:
            return None
        found[2] = max(up, found[2]) + SPARE
        if world.free(found)[0]:
            return found
    return None


def below(world: World, place: Floats) -> Floats | None:
    """Return a safe place not far below one that is too high, or ``None``."""
    low, high = place.copy(), place.copy()
    low[2] = max(world.least_height(place), float(world.space.low[2])) + SPARE
    if low[2] >= place[2] or not world.free(low)[0]:
        return None
    while high[2] - low[2] > SPARE:
        middle = (low + high) / 2
        low, high = (middle, high) if world.free(middle)[0] else (low, middle)
    return low


def beside(world: World, place: Floats) -> Floats | None:
    """Return the nearest safe place at the same height, or ``None``."""
    angles = np.linspace(0.0, 2 * math.pi, DIRECTIONS, endpoint=False)
    around = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(DIRECTIONS)])
    away, before = 0.5, 0.0
    while away <= FARTHEST:
        free = np.flatnonzero(world.free(place + away * around))
        if len(free):
            near, far = before, away
            while far - near > SPARE:
                middle = (near + far) / 2
                some = np.flatnonzero(world.free(place + middle * around))
                near, far, free = (near, middle, some) if len(some) else (middle, far, free)
            return np.asarray(place + far * around[free[0]])
        before, away = away, away * 1.3
    return None


def way_over(scenario: Scenario, world: World, ends: Floats, radius: float) -> Floats | None:
    """Return the shortest safe way between two places, (n, 3) metres, that is straight as seen from above.

    Parameters
    ----------
    scenario, world
        What has the ceiling, and what must be kept clear of.
    ends
        (2, 3) metres.
    radius
        Metres within which its bends are cut.
    """
    a, b = ends
    length = float(math.dist(a[:2], b[:2]))
    count = min(max(math.ceil(length / SAMPLE), MIN_SAMPLES), MAX_SAMPLES)
    shares = np.linspace(0.0, 1.0, count + 1)
    places = a + shares[:, None] * (b - a)
    low, high = np.empty(count + 1), np.full(count + 1, float(world.space.high[2]))
    for k, place in enumerate(places):
        least = place.copy()
        least[2] = max(world.least_height(place), float(world.space.low[2]))
        safe = least if world.free(least)[0] else above(world, least)
        if safe is None:
            return None
        low[k] = safe[2]
    if scenario.max_height is not None and scenario.terrain is not None:
        ceiling = scenario.terrain.lowest_ground.height(places[:, :2]) + scenario.max_height
        high = np.minimum(high, ceiling - world.error.vertical - 2 * SPARE)
    # between two places it may be as high as at either
    low[1:-1] = SPARE + np.maximum(np.maximum(low[:-2], low[2:]), low[1:-1])
    low[0], low[-1] = min(low[0], a[2]), min(low[-1], b[2])
    high[0], high[-1] = max(high[0], a[2]), max(high[-1], b[2])
    along, cut, bends = shares * length, CUT, [(0.0, float(a[2])), (length, float(b[2]))]
    for _ in range(2):
        kept = low + np.r_[0.0, np.full(count - 1, cut * radius), 0.0]
        if (kept > high).any():
            return None
        taut = taut_line(along, kept, high, float(a[2]), float(b[2]))
        bends = with_fewer_bends(taut, along, high, LONGER * math.dist(a, b))
        cut = _sharpest(bends)
        if cut <= CUT:
            break
    way = np.array([[*(a + s / max(length, 1e-9) * (b - a))[:2], z] for s, z in bends])
    way[0], way[-1] = a, b
    return way


def way_around(scenario: Scenario, uav: int, error: TrackingError, ends: Floats, radius: float) -> Floats | None:
    """Return the way between two places that the planners find, (n, 3) metres, with room for corners to be cut.

    Parameters
    ----------
    scenario, uav
        Where, and for whom.
    error
        How far the vehicle may be off it.
    ends
        (2, 3) metres.
    radius
        Metres within which corners are cut; where there is less room, that is left to be mended.
    """
    (a, b), vehicle, bounds = ends, scenario.uavs[uav], scenario.bounds
    wide = max(AROUND, math.dist(a, b) / 2)
    low, high = np.maximum(ends.min(axis=0) - wide, bounds.min), np.minimum(ends.max(axis=0) + wide, bounds.max)
    low[2], high[2] = bounds.min[2], bounds.max[2]
    step = float(max((high - low)[:2])) / 60
    for room, slack in ((radius, SLACK), (radius / 2, SLACK), (SPARE, SLACK), (SPARE, LEAST_SLACK)):
        inside = derived(
            grown(scenario, room + slack + SPARE),
            bounds=Bounds(min=tuple(low.tolist()), max=tuple(high.tolist())),
            uavs=(derived(vehicle, start=tuple(a.tolist()), home=None, tracking_error=error),),
            targets=(Target(name="end", position=tuple(b.tolist())),),
            lattice=Lattice(step=(step, step, max(min(step, (high - low)[2] / 4), 1.0))),
        )
        result = Auto().plan(Problem(inside))
        if result.status.reached and len(result.path) >= 2:
            way = np.asarray(result.path, dtype=np.float64).copy()
            way[0], way[-1] = a, b
            return _straightened(World(grown(scenario, room + SPARE), error), way)
    return None


def _sharpest(bends: Sequence[tuple[float, float]]) -> float:
    """Return the sine of half the angle of the sharpest bend downwards of a line, (distance, height) each."""
    legs = np.diff(np.array(bends), axis=0)
    legs /= np.linalg.norm(legs, axis=1)[:, None]
    downwards = legs[:-1, 0] * legs[1:, 1] < legs[:-1, 1] * legs[1:, 0]
    cosines = np.sum(legs[:-1] * legs[1:], axis=1)
    return float(np.sqrt(np.maximum((1 - cosines[downwards]) / 2, 0.0)).max(initial=0.0))


def length_of(way: Floats) -> float:
    """Return the length of a way, (n, 3) metres."""
    return sum(math.dist(a, b) for a, b in pairwise(way))


def _straightened(world: World, way: Floats) -> Floats:
    """Return a way with as few of its bends as a greedy search leaves in a world."""
    kept = [0]
    while kept[-1] < len(way) - 1:
        ahead = np.arange(kept[-1] + 1, len(way))
        seen = world.segments_free(np.repeat(way[kept[-1]][None], len(ahead), axis=0), way[ahead])
        kept.append(int(ahead[seen][-1]) if seen.any() else kept[-1] + 1)
    return way[kept]
