"""How claims are judged that the thesis makes without an experiment: on generators, populations, obstacles, turns."""

import math
from functools import cache
from itertools import product

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.job import Case
from skyverse.mission.plan_mission import MissionOptions, plan_mission
from skyverse.reproduction.cell_runs import EXACT, CellRuns, case, optimum, planner, without_obstacles
from skyverse.reproduction.claim_verdict import Comparison, Finding, judged
from skyverse.reproduction.cost_claims import ALIKE_WITHIN, LAST, costs
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.published import CASES, FLEET_RUNS, METHODS, THESIS_MAPS
from skyverse.stop import MaxIterations

SWEPT_POPULATIONS = (5, 10, 20, 40, 80, 160)
SWEPT_ITERATIONS = 25
NEAR = 0.05
"""A cost is near the optimum if it lies at most this share above it."""
TURN_RUNS = 10
"""Flights on each map whose turns are counted."""


def beat_exact_search(cells: CellRuns, form: str) -> Finding:
    """Judge whether the three methods come within `ALIKE_WITHIN` of A*'s paths with fewer nodes than A* generates."""
    compared = []
    for name, method in product(THESIS_MAPS, METHODS):
        given = case(name)
        for what, unit, most in (("cost", "cost", ALIKE_WITHIN), (cells.work, cells.unit, 0.0)):
            where = f"{MAP_TITLES[name]}, 25 x 40, {unit}"
            ours = cells.values(what, given, method, form, *CASES[1])
            compared.append(Comparison(where, (method, EXACT), ours, cells.exact(what, given), (-math.inf, most)))
    told = f"Asked: a mean cost at most {ALIKE_WITHIN:.0%} above A*'s, whose path is optimal, with fewer {cells.unit}."
    return judged(compared, text=told)


def guided_paths_are_better(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO's costs are lower with paths of Algorithm 2 than with those of Algorithm 1."""
    few = cells.first(FLEET_RUNS)
    compared = [
        Comparison(
            f"{MAP_TITLES[name]}, 20 x 25",
            ("Algorithm 2", "Algorithm 1"),
            costs(few, form, name, "MVO", CASES[0]),
            costs(few, form, name, "MVO uniform", CASES[0]),
        )
        for name in THESIS_MAPS
    ]
    return judged(compared, text=f"MVO, {few.runs} runs a cell. A path that ends short of the goal costs 100 a metre.")


def populations(compared: tuple[int, int], asked: tuple[float, float], cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO's cost with one population lies in a range above that with another, as a share of it."""
    few = cells.first(FLEET_RUNS)
    costs_of = {
        (name, n): costs(few, form, name, "MVO", (n, SWEPT_ITERATIONS))
        for name, n in product(THESIS_MAPS, SWEPT_POPULATIONS)
    }
    found = [
        Comparison(
            f"{MAP_TITLES[name]}, {SWEPT_ITERATIONS} iterations",
            (f"{compared[0]} universes", f"{compared[1]} universes"),
            costs_of[name, compared[0]],
            costs_of[name, compared[1]],
            asked,
        )
        for name in THESIS_MAPS
    ]
    swept = [
        f"{MAP_TITLES[name]} {', '.join(f'{costs_of[name, n].mean():.1f}' for n in SWEPT_POPULATIONS)}"
        for name in THESIS_MAPS
    ]
    return judged(
        found,
        text=f"Asked: at least {asked[0]:+.0%}. Mean costs with {', '.join(map(str, SWEPT_POPULATIONS))} universes: "
        f"{'; '.join(swept)}. {few.runs} runs a cell.",
    )


def obstacles_take_iterations(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO comes near the optimum in fewer iterations where the obstacles are taken away."""
    few = cells.first(FLEET_RUNS)
    compared = [
        Comparison(
            f"{MAP_TITLES[name]}, iterations",
            ("without", "with obstacles"),
            _until_near(few, form, without_obstacles(name)),
            _until_near(few, form, case(name)),
        )
        for name in THESIS_MAPS
    ]
    told = (
        f"Iterations until the best cost is within {NEAR:.0%} of the optimum, 25 universes; {LAST[1] + 1} where it is "
        f"not after {LAST[1]}. {few.runs} runs a cell."
    )
    return judged(compared, text=told)


def _until_near(cells: CellRuns, form: str, given: Case) -> Floats:
    return cells.iterations_until((1 + NEAR) * optimum(given), given, "MVO", form, *LAST)


def turns_are_removed(cells: CellRuns, form: str) -> Finding:
    """Judge whether a trajectory has at most half the turns of its path, which MVO found."""
    compared = []
    for name in THESIS_MAPS:
        counts = np.array([_turns(name, form, seed) for seed in cells.seeds[:TURN_RUNS]], dtype=np.float64)
        names = ("trajectory", "path")
        compared.append(Comparison(f"{MAP_TITLES[name]}, turns", names, counts[:, 0], counts[:, 1], (-math.inf, -0.5)))
    told = f"Asked: at most half of the path's turns. {len(compared[0].first)} flights on each map, MVO, 25 x 40."
    return judged(compared, text=told)


@cache
def _turns(name: str, form: str, seed: int) -> tuple[int, int]:
    """Return how many turns a trajectory that stops at each has, and how many its path has."""
    mission = plan_mission(
        case(name).scenario,
        planner("MVO", form, CASES[1][0]),
        stop=MaxIterations(CASES[1][1]),
        rng=seed,
        options=MissionOptions(shape="stop-and-go", keep_apart=False),
    )
    flown, steps = mission.trajectory(0), np.diff(mission.result(0).path, axis=0)
    directions = steps / np.linalg.norm(steps, axis=1)[:, None]
    rests = np.linalg.norm(flown.at(flown.knots).velocity, axis=1) < 1e-6
    return int(rests.sum()) - 2, int((np.abs(np.diff(directions, axis=0)).max(axis=1) > 1e-9).sum())
