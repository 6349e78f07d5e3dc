"""Objectives that no exact search prices: ``python benchmarks/threats.py`` prints the contest of docs/planners.md.

Twenty seeds x 15 and 30 threats (`skyverse.random_threats`), all at the same number of objective values, at 500, 1,000,
3,000 and 10,000 of them; ``--evaluations``, ``--fields`` and ``--seeds`` ask for less, or for other fields. Every cost
is the referee's: `check_result` computes it anew, and an answer that it finds wrong ends the program.
"""

import argparse
import itertools
import statistics
from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np
from machine import describe, table

import skyverse as sky

STRAIGHT = (sky.DE, sky.CMAES, sky.LSHADE, sky.PSO, sky.GWO)


@dataclass(frozen=True, kw_only=True)
class SeededPSO(sky.PSO):
    """PSO whose first population holds `way`, Taut's path, its joints spread over the free waypoints."""

    way: tuple[tuple[float, float, float], ...] = ()

    def optimise(self, evaluate: object, first: np.ndarray, rng: np.random.Generator) -> Generator[None, float, None]:
        """Run PSO from there."""
        if self.way:
            first[0] = np.ravel(self.way)
        return super().optimise(evaluate, first, rng)  # type: ignore[arg-type]


def shares(scenario: sky.Scenario, path: np.ndarray, joints: int) -> tuple[tuple[float, ...], ...]:
    """Return so many waypoints of a path as shares of the bounds: its own joints, then middles of its longest legs."""
    points = [np.array(point) for point in path]
    while len(points) < joints + 2:
        k = int(np.argmax([np.linalg.norm(b - a) for a, b in itertools.pairwise(points)]))
        points.insert(k + 1, (points[k] + points[k + 1]) / 2)
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    return tuple(tuple((point - low) / (high - low)) for point in points[1 : joints + 1])


def run(planner: sky.Planner, problem: sky.Problem, budget: int, seed: int) -> float:
    result = planner.plan(problem, stop=sky.MaxEvaluations(budget), rng=seed)
    wrong = sky.check_result(problem.scenario, 0, 0, result)
    assert not wrong, wrong
    return result.cost if result.status.reached else np.inf


def contest(budget: int, fields: Sequence[tuple[int, int]], joints: int) -> list[dict[str, float]]:
    rows = []
    for threats, seed in fields:
        problem = sky.Problem(sky.random_threats(threats, seed=seed))
        way = shares(problem.scenario, sky.Taut().plan(problem).path, joints)
        peers = [*(kind(legs="straight", waypoints=joints) for kind in STRAIGHT), sky.MVO()]
        costs = {type(peer).__name__: run(peer, problem, budget, seed) for peer in peers}
        ours = {
            "Cheapest, its own effort": sky.Cheapest().plan(problem).cost,
            "PSO, given Taut's path": run(SeededPSO(legs="straight", waypoints=joints, way=way), problem, budget, seed),
        }
        rows.append({"threats": threats, **costs, **ours})
        best = min(costs, key=costs.__getitem__)
        cheapest = ours["Cheapest, its own effort"]
        print(f"{threats} threats, seed {seed}: {best} {costs[best]:.1f}, Cheapest {cheapest:.1f}", flush=True)
    return rows


def report(rows: list[dict[str, float]]) -> None:
    peers = [*(kind.__name__ for kind in STRAIGHT), "MVO"]
    names = [name for name in rows[0] if name != "threats"]
    lines = []
    for name in names:
        line = [name]
        for threats in (15, 30):
            some = [row for row in rows if row["threats"] == threats]
            ratios = [row[name] / min(row[peer] for peer in peers) for row in some]
            arrived = [ratio for ratio in ratios if np.isfinite(ratio)]
            line += [
                f"{sum(ratio < 1 for ratio in ratios)} of {len(ratios)}"
                if name not in peers
                else f"best {sum(ratio == 1 for ratio in ratios)} times",
                f"{statistics.fmean(arrived):.3f}"
                + (f" ({len(arrived)} arrive)" if len(arrived) < len(ratios) else ""),
            ]
        lines.append(line)
    table(["", "15 threats: beats the best peer", "mean ratio to it", "30 threats", "mean ratio"], lines)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--evaluations", type=int, nargs="+", default=[500, 1000, 3000, 10000])
    arguments.add_argument("--fields", type=int, default=20, help="seeds for each number of threats")
    arguments.add_argument("--seeds", type=int, default=0, metavar="FROM", help="the first seed")
    arguments.add_argument("--joints", type=int, default=6, help="waypoints of the peers")
    given = arguments.parse_args()
    print(f"{describe('cma', 'pymoo', 'NiaPy')}\n")
    seeds = range(given.seeds, given.seeds + given.fields)
    fields = [(threats, seed) for threats in (15, 30) for seed in seeds]
    for budget in given.evaluations:
        rows = contest(budget, fields, given.joints)
        print(f"\n{budget:,} evaluations each, peers with {given.joints} waypoints and 25 candidates\n")
        report(rows)


if __name__ == "__main__":
    main()
