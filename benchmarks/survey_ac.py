"""AC maps of the ETH group and of Agarwal and Akella: our strips beside their published costs, and our bounds.

Maps are those of https://github.com/UNCCharlotte-CS-Robotics/AreaCoverage-dataset (AC300), indices 0000 to 0011.
"""

import csv
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from machine import table
from scipy.optimize import linprog
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from strip_bounds import any_strips_bound, these_strips_bound
from sweep_routes import SweepRoute, sweep_route

from skyverse.survey.leg_time import LegTime
from skyverse.survey.sweep import sweep
from skyverse.survey.visibility import way_prices

COST = LegTime(3.0, 1.0)
SPACING = 3.0


class Map(NamedTuple):
    """A map, what is published of it, and the strips and the start of the route of Agarwal and Akella."""

    name: str
    holes: int
    area: Any
    eth: float
    agarwal: float
    strips: np.ndarray
    start: np.ndarray


def maps(folder: Path, costs: Path, holes: set[int] | None = None) -> list[Map]:
    found = []
    for row in csv.DictReader(costs.open(encoding="utf-8")):
        if holes is not None and int(row["holes"]) not in holes:
            continue
        area, strips, start = shapely.box(0, 0, 100, 100), np.empty((0, 2, 2)), np.zeros(2)
        if int(row["holes"]):
            place = folder / row["map"]
            blocks = (place / "holes").read_text(encoding="utf-8").strip().split("\n\n")
            rings = [np.array(block.split(), float).reshape(-1, 2) for block in blocks]
            area = shapely.Polygon(np.loadtxt(place / "outer_polygon"), rings)
            route = np.loadtxt(place / "mem_inf" / "mem_inf_route_data0")  # x, y, is it a strip
            strips, start = np.stack([route[:-1, :2], route[1:, :2]], 1)[route[:-1, 2] == 1], route[0, :2]
        terms = float(row["eth_our_bcd_s"]), float(row["agarwal_inf_cost_s"])
        found.append(Map(row["map"], int(row["holes"]), area, *terms, strips, start))
    return found


def covered(area: Any, strips: np.ndarray) -> float:
    """Return the share of an area that is abreast of a strip, within half the spacing."""
    swaths = shapely.buffer(shapely.linestrings(strips), SPACING / 2, cap_style="flat")
    return float(shapely.union_all(swaths, grid_size=1e-6).intersection(area).area / area.area)


def planned(one: Map, start: np.ndarray) -> tuple[SweepRoute, float]:
    """Return a route from a place and back, of which it is made sure that it is free, and how long it took to plan."""
    begun = time.perf_counter()
    plan = sweep(one.area, one.area, SPACING, cost=COST, ends="line", start=start)
    route = sweep_route(plan.strips, one.area, COST, start)
    seconds = time.perf_counter() - begun
    assert one.area.buffer(1e-5).covers(shapely.LineString(route.points))
    assert np.isclose(COST(np.diff(route.points, axis=0)).sum(), route.cost)
    return route, seconds


def compare(folder: Path, costs: Path, eth: bool) -> None:
    rows, ratios, times = [], [], []
    every = maps(folder, costs)
    planned(every[0], np.zeros(2))  # compiles
    for holes in sorted({one.holes for one in every}):
        part = []
        for one in (one for one in every if one.holes == holes):
            route, seconds = planned(one, np.zeros(2) if eth else one.start)
            ratio = route.cost / (one.eth if eth else one.agarwal)
            theirs = covered(one.area, one.strips) if holes else 1.0
            part.append((ratio, seconds, covered(one.area, route.strips), theirs))
        part = np.array(part)
        ratios += part[:, 0].tolist()
        times += part[:, 1].tolist()
        ratio = f"{np.median(part[:, 0]):.3f}", f"{part[:, 0].max():.3f}"
        share = f"{part[:, 2].mean():.4f}", f"{part[:, 3].mean():.4f}"
        rows.append([str(holes), *ratio, f"{part[:, 1].mean():.2f}", *share])
    table(["holes", "ratio, median", "most", "s", "covered", "by Agarwal"], rows)
    print(f"all {len(ratios)}: median {np.median(ratios):.4f}, most {max(ratios):.4f}; ", end="")
    print(f"{np.mean(times):.2f} s in the mean, {max(times):.2f} s at most")


def ac_eth(folder: Path, costs: Path) -> None:
    """Compare with the ETH group's best: from (0, 0) and back."""
    compare(folder, costs, eth=True)


def ac_agarwal(folder: Path, costs: Path) -> None:
    """Compare with Agarwal and Akella: from a corner of a hole and back."""
    compare(folder, costs, eth=False)


def bound(folder: Path, costs: Path) -> None:
    """Print the gaps of routes on maps with 15 holes to our bounds, and to a linear programme that checks them."""
    gaps = []
    for one in maps(folder, costs, {15}):
        route, _ = planned(one, one.start)
        ends = 2 * len(route.strips)
        swaths = shapely.union_all(shapely.buffer(shapely.linestrings(route.strips), SPACING / 2), grid_size=1e-6)
        seen, longest = one.area.intersection(swaths).area, 2 * shapely.minimum_bounding_radius(one.area)
        prices = way_prices(one.area, np.concatenate([route.strips.reshape(-1, 2), one.start[None]]), COST)
        these = these_strips_bound(prices, np.arange(ends).reshape(-1, 2), ends, ends)
        twice = np.r_[: ends + 1, ends]
        checked = relaxed(prices[np.ix_(twice, twice)])
        assert these <= checked + 1e-6
        assert checked <= route.cost + 1e-6
        lows = any_strips_bound(seen / SPACING, longest, COST), these, checked
        gaps.append([route.cost / low - 1 for low in lows])
    for name, gap in zip(("any strips", "these strips", "these strips, by LP"), np.array(gaps).T, strict=True):
        print(f"gap to the bound of {name}: median {np.median(gap):.2%}, most {gap.max():.2%}")


def relaxed(price: np.ndarray) -> float:
    """Return a bound of routes along strips by a linear programme with cuts.

    Rows 2 i and 2 i + 1 are the ends of strip i; the last two are the start and the end. Hops pair them, and whatever
    strips hang together by more than 0.5 of hops are left by two hops at least.
    """
    m = len(price) - 2
    price = np.minimum(price, price.T)
    i, j = np.triu_indices(m + 2, 1)
    kept = (i // 2 != j // 2) & np.isfinite(price[i, j])
    i, j = i[kept], j[kept]
    each = csr_array((np.ones(2 * len(i)), (np.r_[i, j], np.tile(np.arange(len(i)), 2))))
    cuts: list[np.ndarray] = []
    while True:
        found = linprog(
            price[i, j],
            A_ub=-np.array(cuts) if cuts else None,
            b_ub=-2.0 * np.ones(len(cuts)) if cuts else None,
            A_eq=each,
            b_eq=np.ones(m + 2),
            method="highs",
        )
        new = 0
        for least in (1e-6, 0.5):
            strong = found.x > least
            graph = csr_array((np.ones(strong.sum()), (i[strong] // 2, j[strong] // 2)), shape=(m // 2 + 1,) * 2)
            count, part = connected_components(graph, directed=False)
            for k in range(count if count > 1 else 0):
                across = ((part[i // 2] == k) != (part[j // 2] == k)).astype(float)
                if across @ found.x < 2 - 1e-6:
                    cuts.append(across)
                    new += 1
        if not new:
            ends = np.arange(0, m, 2)
            return float(found.fun + price[ends, ends + 1].sum())
