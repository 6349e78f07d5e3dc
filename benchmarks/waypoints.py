"""The optimisers of waypoints beside random restart on lattice paths: prints their table in docs/planners.md.

``python benchmarks/waypoints.py [--runs 30] [--paths 1000] [--maps map1 map2 map3]``

All planners have their default settings, and L-SHADE once more as many candidates as its paper gives it. A cell holds
how many runs reach the goal, the median cost of all runs, in which a path that ends short pays 100 for each metre, and
the probability that a run is cheaper than one of random restart with as many paths (A12, ties count half). A star says
that the two differ (Mann-Whitney, adjusted by Holm for all cells of a budget, p < 0.05).
"""

import argparse
from pathlib import Path

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.lab import SIGNIFICANCE_LEVEL, a12, holm, mann_whitney
from skyverse.planners import PLANNER_NAMES, make_planner

BASELINE = "random-restart"
OPTIMISERS = [name for name in PLANNER_NAMES if isinstance(make_planner(name), sky.WaypointSearch)]
OWN = {"planner": "l-shade", "candidates": 18 * 18, "label": "l-shade, 324 candidates"}


def main() -> None:
    """Run the study, and print a table for each budget."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--paths", type=int, nargs="+", default=[1000])
    parser.add_argument("--maps", nargs="+", default=["map1", "map2", "map3"])
    parser.add_argument("--planners", nargs="+", default=OPTIMISERS)
    parser.add_argument("--output", type=Path, default=Path("out/waypoints"))
    asked = parser.parse_args()
    study = sky.Study(
        name="Optimisers of waypoints",
        scenarios=asked.maps,
        planners=[*asked.planners, OWN, BASELINE],
        seeds=asked.runs,
        budget=[{"paths": paths} for paths in asked.paths],
    )
    print(describe("cma", "pymoo", "NiaPy"), end="\n\n")
    asked.output.mkdir(parents=True, exist_ok=True)
    with sky.run_study(study, asked.output / "rows.sqlite", workers=2) as rows:
        for budget in rows.labels("budget"):
            print(f"{budget}, {asked.runs} runs\n")
            table(("", *asked.maps), compared(rows, budget))


def compared(rows: sky.Rows, budget: str) -> list[list[str]]:
    """Return a line for each planner, those with the least mean of medians first."""
    labels, maps = rows.labels("planner"), rows.labels("scenario")
    runs = {
        (label, name): rows.select(("cost", "success"), planner=label, scenario=name, budget=budget)
        for label in labels
        for name in maps
    }
    cells = [(label, name) for label in labels for name in maps if label != BASELINE]
    p = holm([mann_whitney(runs[cell]["cost"], runs[BASELINE, cell[1]]["cost"]) for cell in cells])
    differs = {cell for cell, each in zip(cells, p, strict=True) if each < SIGNIFICANCE_LEVEL}

    def cell(label: str, name: str) -> str:
        found, baseline = runs[label, name], runs[BASELINE, name]["cost"]
        told = f"{np.count_nonzero(found['success'])}, {np.median(found['cost']):,.0f}"
        star = "*" if (label, name) in differs else ""
        return told if label == BASELINE else f"{told}, {a12(baseline, found['cost']):.2f}{star}"

    by_median = sorted(labels, key=lambda label: sum(np.median(runs[label, name]["cost"]) for name in maps))
    return [[label, *(cell(label, name) for name in maps)] for label in by_median]


if __name__ == "__main__":
    main()
