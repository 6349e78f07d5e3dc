"""Figures 4.1 to 4.9 and 4.26 to 4.31: flights that MVO plans again, and fleets with and without coordination."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from typing import TYPE_CHECKING

from skyverse.draw import MissionScene, instant, paths, scene, trajectories
from skyverse.lab import Figure, Table
from skyverse.lab.report import Block
from skyverse.mission.assignment import Assignment
from skyverse.mission.plan_mission import MissionOptions, plan_mission
from skyverse.model.mission import Mission
from skyverse.reproduction.cells import FORMS, Cell, CellRuns, ThesisPart
from skyverse.reproduction.charts import ChartSeries, bars, lines, method_series
from skyverse.reproduction.convergence import up_to
from skyverse.reproduction.published import CASES, CONVERGENCE_POPULATION, MAP_TITLES, THESIS_MAPS

if TYPE_CHECKING:
    from matplotlib import figure

Draw = Callable[[MissionScene], "figure.Figure"]
POPULATION, ITERATIONS = CASES[1]
INSTANTS = (("initial", 0.0), ("middle", 0.5), ("final", 1.0))
FIVE_UAV_FLEETS = ("table-4.11", "table-4.12", "table-4.13")
TOTAL_ITERATIONS = (1, 2, 5, 10, 25, 50)
COORDINATED: dict[Assignment, str] = {
    "identity": "without coordination",
    "euclidean": "Munkres, straight lines",
    "path-cost": "Munkres, exact path costs",
}


def parts() -> list[ThesisPart]:
    """Return the figures of these pages of the thesis."""
    alone: list[tuple[str, str, Draw]] = [
        *((f"path on Map {k}", name, paths) for k, name in enumerate(THESIS_MAPS, 1)),
        *((f"trajectory on Map {k}", name, trajectories) for k, name in enumerate(THESIS_MAPS, 1)),
        *((f"{when} instant of the flight on Map 2", "map2", partial(_at, share)) for when, share in INSTANTS),
    ]
    totals = [Cell("table-4.8", "MVO", form, *CASES[1], how) for how, form in product(COORDINATED, FORMS)]
    return [
        *(ThesisPart(f"fig-4.{k}", partial(_flight, f"fig-4.{k}", *flown)) for k, flown in enumerate(alone, 1)),
        ThesisPart("fig-4.26", partial(_fleet, "fig-4.26", "euclidean")),
        ThesisPart("fig-4.27", partial(_fleet, "fig-4.27", "identity")),
        ThesisPart("fig-4.28", _totals, (), totals),
        *(
            ThesisPart(f"fig-4.{k}", partial(_lines, name, k), (), up_to([name], TOTAL_ITERATIONS, "euclidean"))
            for k, name in enumerate(FIVE_UAV_FLEETS, 29)
        ),
    ]


def _fleet(name: str, assignment: Assignment, _: CellRuns) -> Sequence[Block]:
    mission = fly_as_in_thesis(Cell("table-4.8", "MVO", FORMS[1], *CASES[1], assignment))
    how = "without coordination" if assignment == "identity" else "with Munkres"
    text = (
        f"**Figure {name.removeprefix('fig-')}**: trajectories of five UAVs on Map 3, {how}: total cost "
        f"{mission.cost:g}, makespan {mission.makespan:.1f} s (MVO as described, seed 0)."
    )
    return [Figure(name, text, lambda: trajectories(scene(mission)))]


def _flight(name: str, what: str, scenario: str, draw: Draw, _: CellRuns) -> Sequence[Block]:
    mission = fly_as_in_thesis(Cell(scenario, "MVO", FORMS[1], *CASES[1]))
    result = mission.result(0)
    text = (
        f"**Figure {name.removeprefix('fig-')}**: {what}: MVO as described, {POPULATION} x {ITERATIONS}, "
        f"seed 0; cost {result.cost:g}, optimum {result.bound:g}."
    )
    return [Figure(name, text, lambda: draw(scene(mission)))]


def _at(share: float, drawn: MissionScene) -> "figure.Figure":
    return instant(drawn, share * (drawn.makespan or 0.0))


def fly_as_in_thesis(cell: Cell, seed: int = 0) -> Mission:
    """Return the mission that a run of a cell leads to: stop-and-go, as in the thesis, which kept no UAVs apart."""
    return plan_mission(
        cell.make_case().scenario,
        cell.make_planner(),
        stop=cell.stop,
        rng=seed,
        assignment=cell.assignment,
        options=MissionOptions(shape="stop-and-go", keep_apart=False),
    )


def _totals(cells: CellRuns) -> list[Block]:
    few, rows, series = cells.first(), [], []
    for form in FORMS:
        found = few.means(Cell("table-4.8", "MVO", form, *CASES[1], how) for how in COORDINATED)
        series.append(ChartSeries("MVO", form, [], *found))
        rows.append([f"MVO {form}", *(f"{mean:.1f} ± {error:.1f}" for mean, error in zip(*found, strict=True))])
    bounds = [few.optimum("table-4.8", how) for how in COORDINATED]
    rows.append(["exact optimum", *(f"{bound:g}" for bound in bounds)])
    names = list(COORDINATED.values())
    text = (
        f"**Figure 4.28**: mean total best cost of five UAVs on Map 3 (Table 4.8), MVO, {POPULATION} x {ITERATIONS}, "
        f"{few.runs} runs, as in the thesis."
    )
    caption = "**Figure 4.28** in numbers: mean total best cost with its standard error."
    return [
        Figure("fig-4.28", text, lambda: bars(names, series, "mean total best cost", bounds=bounds)),
        Table(["", *names], rows, caption),
    ]


def _lines(name: str, k: int, cells: CellRuns) -> list[Block]:
    few, x = cells.first(), TOTAL_ITERATIONS
    sizes = [(CONVERGENCE_POPULATION, t) for t in x]
    series = method_series(few, [name], sizes, x, assignment="euclidean")
    text = (
        f"**Figure 4.{k}**: mean total best cost of five UAVs against iterations, {list(MAP_TITLES.values())[k - 29]} "
        f"({name.replace('table-', 'Table ')}), with Munkres; bands are standard errors of {few.runs} runs."
    )
    bound, y = few.optimum(name, "euclidean"), "mean total best cost"
    return [Figure(f"fig-4.{k}", text, lambda: lines(series, "iterations", y, bound=bound, log=True))]
