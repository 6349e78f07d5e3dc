"""The scenario of Phung and Ha (2021): their swarm, other optimisers, and a proven bound, at equal evaluations.

``python benchmarks/phung_ha.py TERRAIN [--runs 10] [--evaluations 100000] [--output out/phung-ha]``

TERRAIN is ``ChrismasTerrain.tif`` of the repository duongpm/SPSO, which is not part of this one. The objective, the
spherical vectors, the scenario and the swarm's settings are those of the paper and its published code; the code here is
our own. All contenders minimise the same objective by an own `PathObjective` in a study; `Cheapest`, which seeks the
shortest path that is proven free of collisions, is priced by it too, at twelve nodes or more.

The paper checks the ground at nodes alone; the referee judges each path as it would be flown, and the last column
counts the paths that it finds to fly into the ground or into a threat.

M. D. Phung, Q. P. Ha, "Safety-enhanced UAV path planning with spherical vector-based particle swarm optimization",
Applied Soft Computing 107 (2021), 107376.
"""

import argparse
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse import PathObjective, WaypointSearch
from skyverse.lab.statistics import summary

NODES = 10
START, END = np.array((200.0, 100.0, 150.0)), np.array((800.0, 800.0, 150.0))  # z above ground
THREATS = np.array(
    [(400, 500, 80), (600, 200, 70), (500, 350, 80), (350, 200, 70), (700, 550, 70), (650, 750, 80)], float
)
DRONE, DANGER = 1.0, 10.0
LOWEST, HIGHEST = 100.0, 200.0
ANGLE = math.pi / 4
WEIGHTS = (5.0, 1.0, 10.0, 1.0)
PUBLISHED = ("paper's code, ported by others", "4,766.6", "5,003.9", "209.8", "3.4 %", "unknown")


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
        """Return uniform vectors, but for those whose paths are forbidden, which are drawn anew."""
        X = rng.random((candidates, 3 * NODES))
        for _ in range(1000):
            shut = ~np.isfinite(self.prices(problem, self.paths(problem, X)))
            if not shut.all():
                break
            X = rng.random((candidates, 3 * NODES))
        return X

    def paths(self, problem, X):
        """Return the paths of vectors (r, psi, phi) from node to node, kept within the map and between two heights."""
        r, psi, phi = np.moveaxis(X.reshape(len(X), NODES, 3), 2, 0)
        r = r * 2 * math.dist(START, END) / NODES
        psi = (2 * psi - 1) * ANGLE
        phi = math.atan2(END[1] - START[1], END[0] - START[0]) + (2 * phi - 1) * ANGLE
        steps = np.stack([r * np.cos(psi) * np.sin(phi), r * np.cos(psi) * np.cos(phi), r * np.sin(psi)], axis=2)
        least = np.array((1.0, 1.0, LOWEST))
        most = np.array((*ground(self.terrain).shape, HIGHEST))
        nodes = np.empty((len(X), NODES + 2, 3))
        nodes[:, 0], nodes[:, -1] = START, END
        for k in range(NODES):
            nodes[:, k + 1] = np.clip(nodes[:, k] + steps[:, k], least, most)
        nodes[:, :, 2] += self._ground(nodes)
        return nodes

    def _ground(self, nodes):
        i, j = (np.rint(nodes[:, :, axis]).astype(np.int64) - 1 for axis in (0, 1))
        return ground(self.terrain)[i, j]

    def prices(self, problem, paths):
        """Return the weighted sum of the four terms; see equations 2 to 11 of the paper."""
        nodes = np.array([divided(path) for path in paths]) if paths.shape[1] < NODES + 2 else paths
        legs = np.diff(nodes, axis=1)
        length = np.linalg.norm(legs, axis=2).sum(axis=1)
        threat = np.zeros(len(nodes))
        for x, y, radius in THREATS:
            far = distance(np.array((x, y)), nodes[:, :-1, :2], nodes[:, 1:, :2])
            edge = radius + DRONE
            threat += np.where(far < edge, np.inf, np.maximum(0.0, edge + DANGER - far)).sum(axis=1)
        above = (nodes[:, :, 2] - self._ground(nodes))[:, 1:-1]
        height = np.where(above < 0, np.inf, np.abs(above - (LOWEST + HIGHEST) / 2)).sum(axis=1)
        return np.stack([length, threat, height, turns(legs)]).T @ np.array(WEIGHTS)

    def bound(self, problem):
        """Return the price of the straight line's length: no path is shorter, and no other term is below 0."""
        return WEIGHTS[0] * math.dist(problem.start, problem.end)


def divided(path):
    """Return a path (k, 3) with as many nodes as the paper's, if it has fewer: its longest legs are halved."""
    while len(path) < NODES + 2:
        k = int(np.linalg.norm(np.diff(path, axis=0), axis=1).argmax())
        path = np.insert(path, k + 1, (path[k] + path[k + 1]) / 2, axis=0)
    return path


def distance(place, a, b):
    """Return the distances of a place from segments (m, k) on the map."""
    along = b - a
    share = ((place - a) * along).sum(axis=2) / np.maximum((along**2).sum(axis=2), 1e-300)
    return np.linalg.norm(a + np.clip(share, 0, 1)[:, :, None] * along - place, axis=2)


def turns(legs):
    """Return the sum of the angles, degrees, by which paths turn or change their climb by more than 45 degrees."""
    flat = legs[:, :, :2].copy()
    still = np.all(flat == 0, axis=2)
    for k in range(1, flat.shape[1]):  # a leg straight up keeps the heading of the one before
        flat[still[:, k], k] = flat[still[:, k], k - 1]
    one, other = flat[:, :-1], flat[:, 1:]
    cross = one[:, :, 0] * other[:, :, 1] - one[:, :, 1] * other[:, :, 0]
    turn = np.degrees(np.arctan2(np.abs(cross), (one * other).sum(axis=2)))
    climb = np.degrees(np.arctan2(legs[:, :, 2], np.linalg.norm(flat, axis=2)))
    change = np.abs(np.diff(climb, axis=1))
    return np.where(turn > 45, turn, 0).sum(axis=1) + np.where(change > 45, change, 0).sum(axis=1)


@dataclass(frozen=True, kw_only=True)
class SPSO(WaypointSearch):
    """The paper's particle swarm, with its settings."""

    candidates: int = 500
    damping: float = 0.98
    attraction: float = 1.5
    fastest: float = 0.5

    def optimise(self, evaluate, first, rng):
        """Let particles fly, and come back where they leave [0, 1]."""
        X, V, cost = first.copy(), np.zeros_like(first), evaluate(first)
        own, least, w = X.copy(), cost.copy(), 1.0
        while True:
            yield
            leader = own[least.argmin()]
            pull = rng.random(X.shape) * (own - X) + rng.random(X.shape) * (leader - X)
            V = np.clip(w * V + self.attraction * pull, -self.fastest, self.fastest)
            X = X + V
            V[(X < 0) | (X > 1)] *= -1
            X = np.clip(X, 0, 1)
            cost = evaluate(X)
            better = cost < least
            own[better], least[better] = X[better], cost[better]
            w *= self.damping


def scenario(terrain: str) -> sky.Scenario:
    """Return the paper's scenario, heights above sea level."""
    heights = ground(terrain)
    ends = [(x, y, z + heights[int(x) - 1, int(y) - 1]) for x, y, z in (START, END)]
    return sky.Scenario(
        name="Phung and Ha",
        bounds=sky.Bounds(min=(1, 1, 0), max=(*map(float, heights.shape), 600)),
        obstacles=[
            sky.Cylinder(centre=(x, y), radius=radius, low=0, high=600, name=f"threat {k}")
            for k, (x, y, radius) in enumerate(THREATS.tolist(), 1)
        ],
        terrain=sky.Terrain(origin=(1, 1), step=(1, 1), heights=heights, clearance=LOWEST),
        max_height=HIGHEST,
        clearance=DRONE,
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=ends[0])],
        targets=[sky.Target(position=ends[1])],
    )


def main() -> None:
    """Run the study, and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("terrain")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--evaluations", type=int, default=100_000)
    parser.add_argument("--output", type=Path, default=Path("out/phung-ha"))
    asked = parser.parse_args()
    file = str(Path(asked.terrain).resolve())
    asked.output.mkdir(parents=True, exist_ok=True)
    sky.write(scenario(file), asked.output / "scenario.json")
    others = [sky.PSO, sky.DE, sky.GA, sky.CMAES, sky.LSHADE, sky.WaypointMVO]
    planners = [SPSO(), *(kind(candidates=100, waypoints=NODES) for kind in others), sky.Cheapest()]
    objective = Safety(terrain=file)
    bound = objective.bound(sky.Problem(sky.read(asked.output / "scenario.json")))
    study = sky.Study(
        name="Phung and Ha (2021)",
        scenarios=[str(asked.output / "scenario.json")],
        planners=planners,
        seeds=asked.runs,
        budget={"evaluations": asked.evaluations},
        objective=objective,
    )
    print(describe("cma", "pymoo", "NiaPy"))
    with sky.run_study(study, asked.output / "rows.sqlite", workers=2) as rows:
        lines = [PUBLISHED]
        for label in rows.labels("planner"):
            found = rows.select(("cost", "bound", "verdict", "seconds"), planner=label)
            costs = summary(found["cost"])
            gap = found["cost"].min() / bound - 1
            spread = f"{found['cost'].std(ddof=1):,.1f}" if len(found["cost"]) > 1 else "0"
            wrong = f"{np.count_nonzero(found['verdict'] != '')} of {costs.runs}"
            lines.append(
                (label, f"{found['cost'].min():,.1f}", f"{costs.mean:,.1f}", spread, f"{100 * gap:.1f} %", wrong)
            )
        table(("", "best", "mean", "SD", "best above the bound", "fly into something"), lines)
        print(f"Proven bound: {bound:,.1f}; best known: 4,672.4.")
        sky.write_report(
            rows, asked.output, title=study.name, figures=("svg", "pdf"), formats=("html", "md", "csv", "tex")
        )


if __name__ == "__main__":
    main()
