"""Table 4.10 and Figures 4.26 to 4.31: fleets, with and without coordination."""

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import product

from skyverse.lab.job import Case, Job
from skyverse.lab.report import Block, Figure, Table
from skyverse.mission.plan_mission import Assignment
from skyverse.reproduction.cell_runs import (
    FORM_HEADS,
    FORMS,
    CellRuns,
    Mean,
    ThesisPart,
    all_methods,
    case,
    cell,
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
TOTAL_ITERATIONS = (1, 2, 5, 10, 25, 50)
COORDINATION_WAYS: tuple[Assignment, ...] = ("identity", "euclidean", "path-cost")
_WITH = {
    "identity": "without coordination",
    "euclidean": "Munkres, straight lines",
    "path-cost": "Munkres, exact path costs",
}


def parts() -> list[ThesisPart]:
    """Return the table and figures of this page of the thesis."""
    totals = [
        ThesisPart(f"fig-4.{k}", partial(_line_jobs, name), partial(_lines, name, k))
        for k, name in enumerate(FIVE_UAV_FLEETS, 29)
    ]
    return [
        ThesisPart("table-4.10", _table_jobs, partial(_table, "generated_nodes"), partial(_table, "seconds")),
        ThesisPart("fig-4.26", no_jobs, lambda _: [fleet_trajectories("fig-4.26", "euclidean")]),
        ThesisPart("fig-4.27", no_jobs, lambda _: [fleet_trajectories("fig-4.27", "identity")]),
        ThesisPart("fig-4.28", _total_jobs, _totals),
        *totals,
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
    for which, (place, uavs) in product(CASES, enumerate(FLEETS)):
        row = ["{} x {}".format(*which), str(uavs)]
        given = case(FLEET_SCENARIOS[uavs], "euclidean")
        for method in METHODS:
            row.append(f"{FLEET_TIMES[method, *which][place]:g}")
            for form in FORMS:
                (median,) = cells.medians(column, [given], method, form, [which])
                row.append(form_of.format(scale * median))
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
    cases = [coordinated(how) for how in COORDINATION_WAYS]
    rows, series = [], []
    for form in FORMS:
        found = cells.means(cases, "MVO", form, CASES[1:])
        series.append(ChartSeries("MVO", form, [], *found))
        rows.append([f"MVO {form}", *(str(Mean(*each)) for each in zip(*found, strict=True))])
    bounds = [optimum(given) for given in cases]
    rows.append(["exact optimum", *(f"{bound:g}" for bound in bounds)])
    names = [_WITH[how] for how in COORDINATION_WAYS]
    text = (
        f"**Figure 4.28**: mean total best cost of five UAVs on Map 3 (Table 4.8), MVO, {CASES[1][0]} x {CASES[1][1]}, "
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
    given, x = case(name, "euclidean"), TOTAL_ITERATIONS
    sizes = [(CONVERGENCE_POPULATION, t) for t in x]
    series = [
        ChartSeries(method, form, x, *cells.means([given], method, form, sizes))
        for method, form in product(METHODS, FORMS)
    ]
    title = list(MAP_TITLES.values())[k - 29]
    text = (
        f"**Figure 4.{k}**: mean total best cost of five UAVs against iterations, {title} "
        f"({name.replace('table-', 'Table ')}), with Munkres; bands are standard errors of {cells.runs} runs."
    )
    bound, y = optimum(given), "mean total best cost"
    return [Figure(f"fig-4.{k}", text, lambda: lines(series, "iterations", y, bound=bound, log=True))]
