"""The effect of HybridMVO's repairs: ``python benchmarks/hybrid.py`` prints its tables in docs/planners.md."""

import time
from collections.abc import Sequence
from dataclasses import replace
from statistics import fmean, median, stdev

import numpy as np
from machine import describe, table

import skyverse as sky

MAPS = ("map1", "map2", "map3")
SEEDS = 50
HYBRID = sky.HybridMVO(universes=25)
OFF = {
    "none": {},
    "straight flights": {"straighten": 0},
    "more than one via-point": {"tries": 1},
    "return to a later point": {"rejoin": False},
    "white holes for segments": {"segments": False},
    "wormholes to the best": {"wormholes": False},
    "roaming": {"roam": 0.0},
    "all": {"straighten": 0, "tries": 1, "rejoin": False, "segments": False, "wormholes": False, "roam": 0.0},
}


def main() -> None:
    problems = {name: sky.Problem(sky.read_scenario(name)) for name in MAPS}
    fine = {"lattice": sky.Lattice(step=(0.1, 0.1, 0.1))}
    problems["map2, 0.1 m"] = sky.Problem(sky.read_scenario("map2").model_copy(update=fine))
    print(f"{describe()}\n")
    for name in MAPS:
        contest(problems[name], name)
    two_zones()
    for iterations in (10, 40):
        print(f"Each repair switched off alone, {SEEDS} seeds, {iterations} iterations: mean / optimum, paths, time")
        ablation(problems, sky.MaxIterations(iterations))


def contest(problem: sky.Problem, name: str) -> None:
    """Compare planners at 40 iterations, and random restart at as many paths as HybridMVO generates."""
    stop = sky.MaxIterations(40)
    contenders = {
        "HybridMVO": (HYBRID, stop),
        "MVO, as described": (sky.MVO(universes=25), stop),
        "MVO, as run": (sky.MVO(universes=25, as_run=True), stop),
    }
    results = interleaved(problem, contenders)
    paths = round(fmean(result.effort.generated_paths for result in results["HybridMVO"]))
    results |= interleaved(problem, {f"random restart, {paths:,} paths": (sky.RandomRestart(), sky.MaxPaths(paths))})
    print(f"{name}, optimum {problem.route.price:g}, 25 universes x 40 iterations, {SEEDS} seeds")
    head = ["", "mean", "std", "worst", "incomplete", "paths", "nodes", "evaluations", "median processor time"]
    table(head, [[label, *judged(runs)] for label, runs in results.items()])


def interleaved(
    problem: sky.Problem, contenders: dict[str, tuple[sky.Planner, sky.Stop]]
) -> dict[str, list[sky.Result]]:
    """Run all by turns, so that a machine that slows down slows all of them; results say processor seconds."""
    results: dict[str, list[sky.Result]] = {label: [] for label in contenders}
    for seed in (0, *range(SEEDS)):
        for label, (planner, stop) in contenders.items():
            began = time.process_time()
            result = planner.plan(problem, stop=stop, rng=seed)
            results[label].append(replace(result, seconds=time.process_time() - began))
    return {label: runs[1:] for label, runs in results.items()}


def judged(results: Sequence[sky.Result]) -> list[str]:
    costs = [result.cost for result in results]
    efforts = [result.effort for result in results]
    return [
        f"{fmean(costs):.2f}",
        f"{stdev(costs):.2f}",
        f"{max(costs):g}",
        f"{sum(not result.status.reached for result in results)}",
        f"{fmean(effort.generated_paths for effort in efforts):,.0f}",
        f"{fmean(effort.generated_nodes for effort in efforts):,.0f}",
        f"{fmean(effort.evaluations for effort in efforts):,.0f}",
        f"{median(result.seconds for result in results) * 1e3:.1f} ms",
    ]


def two_zones() -> None:
    """Plan whole missions of one UAV through two zones of risk over a lattice of a million nodes, turns priced."""
    ring = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    zones = [
        sky.Prism(
            vertices=[(x + 200 * np.cos(t) * (1 + 0.1 * np.cos(9 * t)), 500 + 480 * np.sin(t)) for t in ring],
            low=0,
            high=120,
            risk=risk,
        )
        for x, risk in ((280, 2.0), (740, 3.0))
    ]
    rows = []
    for unit in ("nodes", "metres"):
        scenario = sky.Scenario(
            name="two zones",
            bounds=sky.Bounds(min=(0, 0, 0), max=(1000, 1000, 120)),
            zones=zones,
            clearance=2,
            lattice=sky.Lattice(step=(5, 5, 5), connectivity=26),
            objective=sky.Objective(unit=unit, divergence=0.3, end=100),
            uavs=[sky.UAV(start=(5, 450, 10))],
            targets=[sky.Target(position=(995, 480, 20))],
        )
        began = time.process_time()
        mission = sky.plan_mission(scenario, HYBRID, rng=1)
        [result] = mission.results
        rows.append([unit, f"{result.cost:.1f}", f"{result.seconds:.2f} s", f"{time.process_time() - began:.1f} s"])
    print("A mission through two zones of risk with 200 corners each, 1,010,025 nodes, 26-connected, turns priced")
    table(["unit", "cost", "HybridMVO, clock", "whole mission, processor"], rows)


def ablation(problems: dict[str, sky.Problem], stop: sky.Stop) -> None:
    contenders: dict[str, tuple[sky.Planner, sky.Stop]] = {
        label: (replace(HYBRID, **changed), stop) for label, changed in OFF.items()
    }
    columns = {name: interleaved(problem, contenders) for name, problem in problems.items()}
    rows = [[label, *(cell(columns[name][label], problems[name]) for name in problems)] for label in OFF]
    table(["off", *problems], rows)


def cell(results: Sequence[sky.Result], problem: sky.Problem) -> str:
    reached = [result.cost for result in results if result.status.reached]
    lost = len(results) - len(reached)
    ratio = f"{fmean(reached) / problem.route.price:.4f}" if reached else "-"
    paths = fmean(result.effort.generated_paths for result in results)
    seconds = median(result.seconds for result in results)
    return f"{ratio}{f' ({lost} lost)' if lost else ''}, {paths:,.0f}, {seconds * 1e3:.1f} ms"


if __name__ == "__main__":
    main()
