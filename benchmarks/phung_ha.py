"""The scenario of Phung and Ha (2021): their swarm, other optimisers, and a proven bound, at equal evaluations.

``python benchmarks/phung_ha.py TERRAIN [--runs 10] [--evaluations 100000] [--output out/phung-ha]``

TERRAIN is ``ChrismasTerrain.tif`` of the repository duongpm/SPSO, which is not part of this one. The objective, the
spherical vectors, the scenario and the swarm's settings are those of the paper and its published code; the code here is
our own. All contenders minimise the same objective, a `PathObjective`, in a study. Each has as many candidates as its
paper or its package gives it; nothing is tuned. `TenCorners` is no optimiser of vectors: it takes the path of
`Cheapest`, which is sought at 150 m above ground and proven clear, and keeps ten of its corners.

The paper checks the ground at nodes alone; the referee judges each path as it would be flown. The rows, a report, and
the picture of docs/showcase.md stand in the output.

M. D. Phung, Q. P. Ha, "Safety-enhanced UAV path planning with spherical vector-based particle swarm optimization",
Applied Soft Computing 107 (2021), 107376.
"""

import argparse
import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from machine import describe, table
from phung_ha_figure import draw

import skyverse as sky
from skyverse import PathObjective, WaypointSearch
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.base import DirectPlanner

NODES = 10
START, END = (200.0, 100.0, 150.0), (800.0, 800.0, 150.0)  # z above ground
THREATS = tuple(
    (float(x), float(y), float(radius))
    for x, y, radius in ((400, 500, 80), (600, 200, 70), (500, 350, 80), (350, 200, 70), (700, 550, 70), (650, 750, 80))
)
DRONE, DANGER = 1.0, 10.0
LOWEST, MIDDLE, HIGHEST = 100.0, 150.0, 200.0
LONGEST = 2 * math.dist(START, END) / NODES
TOWARDS, ANGLE = math.atan2(END[1] - START[1], END[0] - START[0]), math.pi / 4
LENGTH, HEIGHT = 5.0, 10.0
"""The weights of a metre, and of a metre off the middle height at a node; those of threats and turns are 1."""
CHEAPER_WAY = 5000.0
"""Ways between the threats in the middle cost less, and those around them more."""
PUBLISHED = ("the paper's code, ported by others", "4,766.6", "5,003.9", "209.8", "3.2 %", "8.4 %", "")


@cache
def ground(file: str) -> np.ndarray:
    """Return the heights (x, y) of the terrain, on a grid of 1 m from (1, 1) on."""
    import rasterio

    with rasterio.open(file) as raster:
        return np.maximum(raster.read(1).T, 0.0).astype(np.float64)


@dataclass(frozen=True, kw_only=True)
class Safety(PathObjective):
    """Length, threats, height above ground and turns of a path of twelve nodes; candidates are spherical vectors."""

    terrain: str

    def first(self, problem, rng, candidates, waypoints):
        """Return uniform vectors, drawn anew, as the paper's code does, until one of them has a path that may be."""
        while True:
            X = rng.random((candidates, 3 * NODES))
            if np.isfinite(self.prices(problem, self.paths(problem, X))).any():
                return X

    def paths(self, problem, X):
        """Return the paths of vectors (r, psi, phi) from node to node, kept within the map and between two heights."""
        return from_spherical(ground(self.terrain), X)

    def prices(self, problem, paths):
        """Return the weighted sum of the four terms; see equations 2 to 11 of the paper."""
        nodes = np.array([divided(path) for path in paths]) if paths.shape[1] < NODES + 2 else paths
        return weighted(ground(self.terrain), np.ascontiguousarray(nodes))

    def bound(self, problem):
        """Return the price of the straight line's length: no path is shorter, and no other term is below 0."""
        return LENGTH * math.dist(problem.start, problem.end)


def divided(path):
    """Return a path (k, 3) with as many nodes as the paper's, if it has fewer: its longest legs are halved."""
    while len(path) < NODES + 2:
        k = int(np.linalg.norm(np.diff(path, axis=0), axis=1).argmax())
        path = np.insert(path, k + 1, (path[k] + path[k + 1]) / 2, axis=0)
    return path


@inner
def height(heights, x, y):
    """Return the ground's height at the nearest point of the grid."""
    return heights[int(x + 0.5) - 1, int(y + 0.5) - 1]


@kernel
def from_spherical(heights, X):
    """Return the paths (m, 12, 3), heights above sea level, of vectors (m, 30) in [0, 1]."""
    nodes = np.empty((len(X), NODES + 2, 3))
    for i in range(len(X)):
        x, y, z = START
        for k in range(NODES + 2):
            if k == NODES + 1:
                x, y, z = END
            elif k:
                r = LONGEST * X[i, 3 * k - 3]
                psi = (2 * X[i, 3 * k - 2] - 1) * ANGLE
                phi = TOWARDS + (2 * X[i, 3 * k - 1] - 1) * ANGLE
                x = min(max(x + r * math.cos(psi) * math.sin(phi), 1.0), float(heights.shape[0]))
                y = min(max(y + r * math.cos(psi) * math.cos(phi), 1.0), float(heights.shape[1]))
                z = min(max(z + r * math.sin(psi), LOWEST), HIGHEST)
            nodes[i, k] = x, y, z + height(heights, x, y)
    return nodes


@kernel
def weighted(heights, paths):
    """Return the prices of paths (m, k, 3)."""
    prices = np.zeros(len(paths))
    for i in range(len(paths)):
        path = paths[i]
        for k in range(1, len(path)):
            prices[i] += LENGTH * math.sqrt(((path[k] - path[k - 1]) ** 2).sum()) + danger(path[k - 1], path[k])
        for k in range(1, len(path) - 1):
            above = path[k, 2] - height(heights, path[k, 0], path[k, 1])
            prices[i] += HEIGHT * abs(above - MIDDLE) if above >= 0 else math.inf
        prices[i] += turns(path)
    return prices


@inner
def danger(a, b):
    """Return what a leg pays for the threats that it comes near to; infinity if it meets one."""
    price = 0.0
    for x, y, radius in THREATS:
        dx, dy = b[0] - a[0], b[1] - a[1]
        share = min(max(((x - a[0]) * dx + (y - a[1]) * dy) / max(dx * dx + dy * dy, 1e-300), 0.0), 1.0)
        room = math.hypot(a[0] + share * dx - x, a[1] + share * dy - y) - radius - DRONE
        price += max(0.0, DANGER - room) if room >= 0 else math.inf
    return price


@inner
def turns(path):
    """Return the sum of the angles, degrees, by which a path turns or changes its climb by more than 45 degrees.

    As in the paper's code, a leg straight up has the heading, and the length on the map, of the one before, or of the
    one behind, whichever it is compared with.
    """
    total = 0.0
    for k in range(1, len(path) - 1):
        before, behind = k - 1, k
        while before > 0 and path[before, 0] == path[before + 1, 0] and path[before, 1] == path[before + 1, 1]:
            before -= 1
        while (
            behind < len(path) - 2 and path[behind, 0] == path[behind + 1, 0] and path[behind, 1] == path[behind + 1, 1]
        ):
            behind += 1
        ax, ay = path[before + 1, 0] - path[before, 0], path[before + 1, 1] - path[before, 1]
        bx, by = path[behind + 1, 0] - path[behind, 0], path[behind + 1, 1] - path[behind, 1]
        turn = math.degrees(math.atan2(abs(ax * by - ay * bx), ax * bx + ay * by))
        climb = math.degrees(math.atan2(path[k, 2] - path[k - 1, 2], math.hypot(ax, ay)))
        change = abs(math.degrees(math.atan2(path[k + 1, 2] - path[k, 2], math.hypot(bx, by))) - climb)
        total += (turn if turn > 45 else 0.0) + (change if change > 45 else 0.0)
    return total


@dataclass(frozen=True, kw_only=True)
class SPSO(WaypointSearch):
    """The paper's particle swarm, with its settings; the leader may change from particle to particle."""

    candidates: int = 500
    damping: float = 0.98
    attraction: float = 1.5
    fastest: float = 0.5

    def optimise(self, evaluate, first, rng):
        """Let particles fly, and come back where they leave [0, 1]."""
        X, V, least, w = first.copy(), np.zeros_like(first), evaluate(first), 1.0
        own, lead = X.copy(), int(least.argmin())
        while True:
            yield
            for i, (one, two) in enumerate(rng.random((len(X), 2, X.shape[1]))):
                pull = one * (own[i] - X[i]) + two * (own[lead] - X[i])
                V[i] = np.clip(w * V[i] + self.attraction * pull, -self.fastest, self.fastest)
                X[i] += V[i]
                V[i, (X[i] < 0) | (X[i] > 1)] *= -1
                X[i] = np.clip(X[i], 0, 1)
                cost = evaluate(X[i : i + 1])[0]
                if cost < least[i]:
                    own[i], least[i] = X[i], cost
                    lead = i if cost < least[lead] else lead
            w *= self.damping


@dataclass(frozen=True, kw_only=True)
class TenCorners(DirectPlanner):
    """The path of `Cheapest`, and of its corners those ten that make it cheapest, by legs that are free."""

    terrain: str

    def find(self, problem, origin):
        """Return the path; Bellman's equation over the corners, turns left out."""
        found = sky.Cheapest().plan(problem)
        corners = found.path
        prices = np.full((len(corners), len(corners)), np.inf)
        i, j = np.triu_indices(len(corners), 1)
        free = problem.airspace.world.segments_free(corners[i], corners[j])
        legs = corners[np.stack([i, j, j], axis=1)[free]]  # the second node pays for its height
        prices[i[free], j[free]] = weighted(ground(self.terrain), legs)
        least, before = prices[0], []
        for _ in range(NODES):
            ways = least[:, None] + prices
            before.append(ways.argmin(axis=0))
            least = ways.min(axis=0)
        if not np.isfinite(least[-1]):  # it has fewer corners, or cannot do with ten
            return found
        kept = [len(corners) - 1]
        for step in reversed(before):
            kept.append(int(step[kept[-1]]))
        made = sky.result_of_path(problem, corners[[0, *reversed(kept)]])
        return replace(made, effort=found.effort, seconds=found.seconds)


def scenario(terrain: str) -> sky.Scenario:
    """Return the paper's scenario, heights above sea level; the price of height is the paper's, along the path."""
    heights = ground(terrain)
    ends = [(x, y, z + heights[int(x) - 1, int(y) - 1]) for x, y, z in (START, END)]
    weight = HEIGHT * (NODES + 1) / (LENGTH * math.dist(*ends))
    band = sky.AltitudeBand(low=MIDDLE, high=MIDDLE, weight=weight, above="ground")
    return sky.Scenario(
        name="Phung and Ha",
        bounds=sky.Bounds(min=(1, 1, 0), max=(*map(float, heights.shape), 600)),
        obstacles=[
            sky.Cylinder(centre=(x, y), radius=radius, low=0, high=600, name=f"threat {k}")
            for k, (x, y, radius) in enumerate(THREATS, 1)
        ],
        terrain=sky.Terrain(origin=(1, 1), step=(1, 1), heights=heights, clearance=LOWEST),
        max_height=HIGHEST,
        clearance=DRONE,
        objective=sky.Objective(unit="metres", altitude=band),
        uavs=[sky.UAV(start=ends[0])],
        targets=[sky.Target(position=ends[1])],
    )


PLANNERS = (
    {"label": "SPSO", "planner": f"{__name__}:SPSO"},
    {"label": "PSO", "planner": "pso", "candidates": 25},
    {"label": "DE", "planner": "de", "candidates": 100},
    {"label": "GA", "planner": "ga", "candidates": 100},
    {"label": "CMA-ES", "planner": "cma-es", "candidates": 14},
    {"label": "L-SHADE", "planner": "l-shade", "candidates": 18 * 3 * NODES},
    {"label": "MVO", "planner": "waypoint-mvo", "candidates": 60},
)
"""Candidates as in the paper, in pymoo (PSO, DE, GA), by the papers' rules (CMA-ES, L-SHADE), in the author's code."""


def main() -> None:
    """Run the study, and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("terrain")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--evaluations", type=int, default=100_000)
    parser.add_argument("--output", type=Path, default=Path("out/phung-ha"))
    parser.add_argument("--picture", type=Path, help="a PNG file; by default in the output")
    asked = parser.parse_args()
    file = str(Path(asked.terrain).resolve())
    asked.output.mkdir(parents=True, exist_ok=True)
    sky.write(scenario(file), asked.output / "scenario.json")
    corners = {"label": "Cheapest, ten corners", "planner": f"{__name__}:TenCorners", "terrain": file}
    study = sky.Study(
        name="Phung and Ha (2021)",
        scenarios=[str(asked.output / "scenario.json")],
        planners=[*PLANNERS, corners],
        seeds=asked.runs,
        budget={"evaluations": asked.evaluations},
        objective=Safety(terrain=file),
    )
    print(describe("cma", "pymoo", "NiaPy"))
    with sky.run_study(study, asked.output / "rows.sqlite", workers=2) as rows:
        report(rows, Safety(terrain=file).bound(sky.Problem(sky.read(asked.output / "scenario.json"))))
        draw(study, rows, asked.picture or asked.output / "phung-ha.png")
        sky.write_report(
            rows, asked.output, title=study.name, figures=("svg", "pdf"), formats=("html", "md", "csv", "tex")
        )


def report(rows, bound: float) -> None:
    """Print the table."""
    lines = [PUBLISHED]
    for label in rows.labels("planner"):
        costs = rows.select(("cost",), planner=label)["cost"]
        figures = (costs.min(), costs.mean(), costs.std(ddof=1) if len(costs) > 1 else 0.0)
        cheap = f"{np.count_nonzero(costs < CHEAPER_WAY)} of {len(costs)}"
        gaps = (f"{100 * (figure / bound - 1):.1f} %" for figure in figures[:2])
        lines.append((label, *(f"{figure:,.1f}" for figure in figures), *gaps, cheap))
    table(("", "best", "mean", "SD", "best above the bound", "mean", "cheaper way"), lines)
    wrong = np.count_nonzero(rows.select(("verdict",))["verdict"] != "")
    print(f"Proven bound: {bound:,.1f}. The referee finds fault with {wrong} paths.")


if __name__ == "__main__":
    main()
