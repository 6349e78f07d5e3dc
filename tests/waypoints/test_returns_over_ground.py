"""Returns from legs that follow the ground: proven where samples of what is flown clear a wall, and found where not."""

from typing import NamedTuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
import terrain_follower as follower

ORIGIN = sky.Origin(latitude=46.8, longitude=9.8, altitude=1500.0)
KEPT, UPRIGHT = 1.0, 1.5
"""Metres: what returns keep clear by, half of the clearance; and the tracking error upright."""
NEED = KEPT + 2 * UPRIGHT
"""Metres that a flight is above what it passes: above the return altitude it keeps the height that it believes."""
RADIUS = 2.0


class Hills(NamedTuple):
    """Ground, what flies over it with places as heights above it, (n, 3), and a wall between it and home."""

    scenario: sky.Scenario
    places: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def tops(self, flown, wide):
        """Heights of the places, (n, 3), from which the line home comes within some metres of the wall."""
        lines = np.linspace(0, 1, 80)[:, None, None] * flown[:, :2]
        return flown[((lines > self.low - wide) & (lines < self.high + wide)).all(axis=2).any(axis=0), 2]

    def gaps(self, folder, top, radius=0.0):
        """The times without a way home if the wall is as high as z = `top`; without a radius it stops at each place."""
        wall = sky.Box(min=(*self.low, -15.0), max=(*self.high, float(top)))
        scenario = sky.Scenario(**{**dict(self.scenario), "obstacles": (wall,)})
        at = sky.to_wgs84(ORIGIN, self.places * [1.0, 1.0, 0.0])
        rows = [[0, 1, 0, 16, 0, 0, 0, 0, ORIGIN.latitude, ORIGIN.longitude, ORIGIN.altitude, 1]]
        rows.append([1, 0, 3, 22, 0, 0, 0, 0, 0, 0, 25, 1])
        rows += [
            [k, 0, 10, 16, 0 if radius else 1, 0, 0, 0, f"{latitude:.10f}", f"{longitude:.10f}", above, 1]
            for k, ((latitude, longitude, _), above) in enumerate(zip(at, self.places[:, 2], strict=True), 2)
        ]
        path = folder / "m.waypoints"
        path.write_text("\n".join(["QGC WPL 110", *("\t".join(map(str, row)) for row in rows)]) + "\n")
        settings = sky.FlightSettings(radius=radius, return_altitude=10.0)
        return sky.check_waypoints([sky.read_waypoints(path)], scenario, settings).missions[0].back.gaps


def hills(rng, steep, count, error, lower=0.0, *, around=False):
    """Random ground of some slope at most, level at home, known to `lower` metres, and what flies there.

    What flies `around` home nearly keeps to a contour of the ground there, which falls to one side.
    """
    step, n = rng.uniform(4, 15), 62
    x, y = np.meshgrid(*2 * [(np.arange(n) - n / 2) * step], indexing="ij")
    waves = [(*rng.uniform(-1, 1, 2) * 2 * np.pi / rng.uniform(60, 400), rng.uniform(0, 7)) for _ in range(6)]
    away = np.hypot(x, y)
    heights = sum(np.sin(a * x + b * y + c) for a, b, c in waves) * np.clip(away / 60 - 0.4, 0, 1)
    heights = np.sin(away / 12 + rng.uniform(0, 7)) if around else heights
    most = max(np.abs(np.diff(heights, axis=axis)).max() for axis in (0, 1)) / step
    heights *= min(steep / most, 9 / np.ptp(heights))
    lowest = heights - lower * rng.uniform(size=heights.shape) if lower else None
    corner = (-step * n / 2, -step * n / 2)
    scenario = sky.Scenario(
        name="hills",
        frame=sky.Frame(origin=ORIGIN),
        bounds=sky.Bounds(min=(-115, -115, -20), max=(115, 115, 150)),
        clearance=2 * KEPT,
        terrain=sky.Terrain(origin=corner, step=(step, step), heights=heights, lowest=lowest, clearance=2.0),
        uavs=(sky.UAV(start=(0, 0, 4), home=0.0, tracking_error=error),),
    )
    turns = rng.uniform(0, 7) + np.cumsum(rng.uniform(0.3, 0.9, count)) / (3 if around else 1)
    radii, above = rng.uniform(60, 100, count), np.round(rng.uniform(25, 45, count), 1)
    radii, above = (radii[0] + 0 * radii, above[0] + 0 * above) if around else (radii, above)
    places = np.column_stack([radii * np.cos(turns), radii * np.sin(turns), above])
    k = int(rng.integers(1, count))
    middle = rng.uniform(0.3, 0.6) * (places[k - 1] + rng.uniform(0.2, 0.8) * (places[k] - places[k - 1]))[:2]
    sizes = rng.uniform(1, 4, 2)
    return Hills(scenario, places, middle - sizes, middle + sizes)


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 0.7), st.floats(0.3, 2.0), st.booleans())
def test_a_return_is_proven_just_where_it_clears_a_wall(tmp_path_factory, seed, steep, off, clears):
    world = hills(np.random.default_rng(seed), steep, 2, sky.TrackingError(vertical=UPRIGHT))
    terrain, (a, b) = world.scenario.terrain, world.places
    flown = a + np.linspace(0, 1, 1000)[:, None] * (b - a)
    flown[:, 2] += follower.height(terrain, terrain.heights, flown[:, :2])
    lowest = world.tops(flown, KEPT + 0.3 if clears else -0.05).min()  # perhaps beside the wall, or surely over it
    found = world.gaps(tmp_path_factory.mktemp("hills"), lowest - NEED + (-off if clears else off))
    assert bool(found) == (not clears)


@given(st.integers(0, 2**32 - 1), st.floats(0.3, 0.9), st.sampled_from([0.0, 3.0]), st.booleans(), st.booleans())
def test_a_return_that_may_come_too_near_to_a_wall_is_found(tmp_path_factory, seed, steep, lower, cuts, around):
    """A UAV that strays, cuts corners, and knows the ground within some metres."""
    rng, error = np.random.default_rng(seed), sky.TrackingError(horizontal=1.0, vertical=UPRIGHT)
    world, radius = hills(rng, steep, 3, error, lower, around=around), RADIUS * cuts
    above = follower.ways(world.places, radius, np.full(3, float(not radius)), rng, 100, 6)
    flown = np.concatenate([follower.flown(world.scenario, above, error, rng) for _ in range(4)])
    lowest = world.tops(flown, 0.0).min()  # its error upright counted once
    assert world.gaps(tmp_path_factory.mktemp("hills"), lowest - KEPT - UPRIGHT + 0.02, radius)
