"""Strips of random areas among random zones, judged by shapely."""

import numpy as np
import shapely
from sweep_routes import sweep_route

from skyverse.survey.leg_time import LegTime
from skyverse.survey.sweep import sweep

COST = LegTime(8.0, 2.0)


def blob(rng: np.random.Generator, centre: np.ndarray, size: float, corners: int) -> shapely.Polygon:
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    reach = size * rng.uniform(0.3, 1.0, corners)
    return shapely.Polygon(centre + np.stack([reach * np.cos(angle), reach * np.sin(angle)], 1)).buffer(0)


def zones_planar(runs: int = 1000) -> None:
    """Plan strips of areas with up to 20 zones, and count what leaves free space, and free ground that none sees."""
    planned = strips_out = ways_out = 0
    open_free = []
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        wanted = blob(rng, np.zeros(2), rng.uniform(60, 200), int(rng.integers(5, 20)))
        places = rng.uniform(-150, 150, (seed % 21, 2))
        zones = [blob(rng, place, rng.uniform(3, 50), int(rng.integers(3, 9))) for place in places]
        free = shapely.box(-250, -250, 250, 250).difference(shapely.union_all(zones))
        width = rng.uniform(5, 25)
        if wanted.intersection(free).area < width**2:
            continue
        plan = sweep(wanted, free, width, cost=COST)
        planned += 1
        grown = free.buffer(1e-5)
        strips_out += int((~shapely.covers(grown, shapely.linestrings(plan.strips))).sum())
        for leg in sweep_route(plan.strips, free, COST).legs:
            ways_out += len(leg) > 1 and not grown.covers(shapely.LineString(leg))
        swaths = shapely.union_all(shapely.buffer(shapely.linestrings(plan.strips), width / 2))
        open_free.append(wanted.intersection(free).difference(swaths).area / wanted.intersection(free).area)
    print(
        f"{planned} areas: {strips_out} strips and {ways_out} legs of routes leave free space; of free ground ", end=""
    )
    print(
        f"{np.mean(open_free):.3%} is farther than half a width from strips in the mean, {max(open_free):.2%} at most"
    )
