"""Strips of random areas among random zones, judged by shapely."""

import numpy as np
import shapely

from skyverse.survey.leg_time import LegTime
from skyverse.survey.sweep import sweep
from skyverse.survey.visibility import shortest_ways

COST = LegTime(8.0, 2.0)


def blob(rng: np.random.Generator, centre: np.ndarray, size: float, corners: int) -> shapely.Polygon:
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    reach = size * rng.uniform(0.3, 1.0, corners)
    return shapely.Polygon(centre + np.stack([reach * np.cos(angle), reach * np.sin(angle)], 1)).buffer(0)


def zones_planar(runs: int = 1000) -> None:
    """Plan strips of areas with up to 20 zones, and count what leaves free space or is neither seen nor told."""
    planned = strips_out = ways_out = unseen = 0
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
        order = plan.strips[plan.route.order]
        order[plan.route.flipped] = order[plan.route.flipped, ::-1]
        ways = shortest_ways(free, order.reshape(-1, 2), COST)
        for i in range(1, len(ways.price) - 1, 2):
            if np.isfinite(ways.price[i, i + 1]):
                ways_out += not grown.covers(shapely.LineString(ways.points(i, i + 1)))
        points = shapely.points(rng.uniform(-200, 200, (3000, 2)))
        points = points[shapely.contains(wanted, points)]
        off = shapely.distance(points, shapely.multilinestrings(list(plan.strips)))
        unseen += int((~shapely.dwithin(points, plan.unreached, 1e-5) & (off > width / 2 + 1e-5)).sum())
        open_free.append(plan.unreached.intersection(free).area / wanted.intersection(free).area)
    print(f"{planned} areas: {strips_out} strips and {ways_out} ways leave free space; ", end="")
    print(f"{unseen} places are neither seen nor told; of free ground ", end="")
    print(f"{np.mean(open_free):.3%} is told as open in the mean, {max(open_free):.2%} at most")
