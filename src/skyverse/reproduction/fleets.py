"""Table 4.10 and Figures 4.26 to 4.31: fleets, with and without coordination."""

from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from skyverse.lab.report import Block, Figure, Table
from skyverse.lab.run_job import Case, Job
from skyverse.mission.plan_mission import Assignment
from skyverse.reproduction.cell_runs import (
    FORM_HEADS,
    FORMS,
    CellRuns,
    ThesisPart,
    all_methods,
    case,
    cell,
    mean,
    no_jobs,
    optimum,
)
from skyverse.reproduction.charts import ChartSeries, bars, lines
from skyverse.reproduction.convergence import up_to
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.flight_figures import fleet_trajectories
from skyverse.reproduction.published import CASES, CONVERGENCE_POPULATION, FLEET_RUNS, FLEET_TIMES, FLEETS, METHODS

FLEET_SCENARIOS = dict(zip(FLEETS, ("table-4.9-2", "table-4.9-3", "table-4.9-4", "table-4.12"), strict=True))
"""The fleets of Table 4.10; the thesis does not give the five-UAV one, and Table 4.12 is the likely set."""
FIVE_UAV_FLEETS = ("table-4.11", "table-4.12", "table-4.13")
TOTAL_ITERATIONS = (1, 2, 5, 10, 25)
COORDINATION_WAYS: tuple[Assignment, ...] = ("identity", "euclidean", "path-cost")
_WITH = {
    "identity": "without coordination",
    "euclidean": "Munkres, straight lines",
    "path-cost": "Munkres, exact path costs",
}


def parts() -> list[ThesisPart]:
    """Return the table and figures of this page of the thesis."""
    return [
        ThesisPart("table-4.10", _table_jobs, partial(_table, "generated_nodes"), partial(_table, "seconds")),
        ThesisPart("fig-4.26", no_jobs, lambda _: [fleet_trajectories("fig-4.26", "euclidean")]),
        ThesisPart("fig-4.27", no_jobs, lambda _: [fleet_trajectories("fig-4.27", "identity")]),
        ThesisPart("fig-4.28", _total_jobs, _totals),
        *(
            ThesisPart(f"fig-4.{29 + k}", partial(_line_jobs, name), partial(_lines, name, k))
            for k, name in enumerate(FIVE_UAV_FLEETS)
        ),
    ]


def coordinated(how: Assignment) -> Case:
    """Return Table 4.8's fleet on Map 3 with targets given out in one of the ways of `COORDINATION_WAYS`."""
    return case("table-4.8", how)


def _table_jobs(seeds: Sequence[int]) -> Iterable[Job]:
    fleets = [case(name, "euclidean") for name in FLEET_SCENARIOS.values()]
    yield from all_methods(fleets, CASES, seeds[:FLEET_RUNS])


def _table(column: str, cells: CellRuns) -> list[Block]:
    cells = cells.first(FLEET_RUNS)
    rows = []
    scale, form_of = (0.001, "{:,.0f}") if column == "generated_nodes" else (1000, "{:.1f}")
    for population, iterations in CASES:
        for place, uavs in enumerate(FLEETS):
            row = [f"{population} x {iterations}", str(uavs)]
            for method in METHODS:
                given = case(FLEET_SCENARIOS[uavs], "euclidean")
                ours = [cells.values(column, given, method, form, population, iterations) for form in FORMS]
                row.append(f"{FLEET_TIMES[method, population, iterations][place]:g}")
                row += [form_of.format(scale * float(np.median(values))) for values in ours]
            rows.append(row)
    caption = (
        "**Table 4.10**, counted: thousands of generated nodes of a fleet's runs on Map 2 with Munkres, beside the "
        "thesis's seconds."
        if column == "generated_nodes"
        else "**Table 4.10**: median time of a fleet's runs on Map 2 with Munkres; thesis in s, ours in ms."
    )
    note = (
        f"The thesis does not give the coordinates of its five UAVs; those of Table 4.12 are taken. {cells.runs} runs "
        "a cell."
    )
    return [Table(["population x iterations", "UAVs", *FORM_HEADS], rows, caption, [note])]


def _total_jobs(seeds: Sequence[int]) -> Iterable[Job]:
    for how in COORDINATION_WAYS:
        for form in FORMS:
            yield from cell(coordinated(how), "MVO", form, *CASES[1], seeds[:FLEET_RUNS])


def _totals(cells: CellRuns) -> list[Block]:
    cells = cells.first(FLEET_RUNS)
    population, iterations = CASES[1]
    rows, series = [], []
    for form in FORMS:
        found = [
            cells.values("cost", coordinated(how), "MVO", form, population, iterations) for how in COORDINATION_WAYS
        ]
        series.append(ChartSeries("MVO", form, [], *zip(*map(mean, found), strict=True)))
        rows.append([f"MVO {form}", *(str(mean(values)) for values in found)])
    bounds = [optimum(coordinated(how)) for how in COORDINATION_WAYS]
    rows.append(["exact optimum", *(f"{bound:g}" for bound in bounds)])
    names = [_WITH[how] for how in COORDINATION_WAYS]
    text = (
        f"**Figure 4.28**: mean total best cost of five UAVs on Map 3 (Table 4.8), MVO, {population} x {iterations}, "
        f"{cells.runs} runs, as in the thesis."
    )
    caption = "**Figure 4.28** in numbers: mean total best cost with its standard error."
    return [
        Figure("fig-4.28", text, lambda: bars(names, series, "mean total best cost", bounds=bounds)),
        Table(["", *names], rows, caption),
    ]


def _line_jobs(name: str, seeds: Sequence[int]) -> Iterable[Job]:
    yield from up_to(case(name, "euclidean"), TOTAL_ITERATIONS, seeds[:FLEET_RUNS])


def _lines(name: str, k: int, cells: CellRuns) -> list[Block]:
    cells = cells.first(FLEET_RUNS)
    given = case(name, "euclidean")
    series = []
    for method in METHODS:
        for form in FORMS:
            found = [
                mean(cells.values("cost", given, method, form, CONVERGENCE_POPULATION, t)) for t in TOTAL_ITERATIONS
            ]
            series.append(ChartSeries(method, form, TOTAL_ITERATIONS, *zip(*found, strict=True)))
    title = list(MAP_TITLES.values())[k]
    text = (
        f"**Figure 4.{29 + k}**: mean total best cost of five UAVs against iterations, {title} "
        f"({name.replace('table-', 'Table ')}), with Munkres; bands are standard errors of {cells.runs} runs."
    )
    bound = optimum(given)
    return [
        Figure(
            f"fig-4.{29 + k}", text, lambda: lines(series, "iterations", "mean total best cost", bound=bound, log=True)
        )
    ]
