"""Tables 4.6, 4.7 and 4.10, Figures 4.20 to 4.25: the time of a run against the population and the number of UAVs."""

from functools import partial
from itertools import product

from skyverse.lab import Figure, Table
from skyverse.lab.report import Block
from skyverse.reproduction.cells import FORM_HEADS, CellRuns, ThesisPart, grid
from skyverse.reproduction.charts import lines, method_series
from skyverse.reproduction.published import (
    CASES,
    FLEET_TIMES,
    FLEETS,
    MAP_TITLES,
    METHODS,
    POPULATIONS,
    THESIS_MAPS,
    TIMES,
)

ITERATIONS = tuple(iterations for _, iterations in CASES)
FLEET_SCENARIOS = dict(zip(FLEETS, ("table-4.9-2", "table-4.9-3", "table-4.9-4", "table-4.12"), strict=True))
"""The fleets of Table 4.10; the thesis does not give the five-UAV one, and Table 4.12 is the likely set."""
NODES, SECONDS = "generated_nodes", "milliseconds"


def parts() -> list[ThesisPart]:
    """Return the tables and figures of this page of the thesis."""
    made = []
    for k, t in enumerate(ITERATIONS, 6):
        wanted = grid(THESIS_MAPS, _sizes(t))
        made.append(
            ThesisPart(f"table-4.{k}", partial(_table, k, t, NODES), wanted, (), partial(_table, k, t, SECONDS))
        )
    for k, (t, name) in enumerate(product(ITERATIONS, THESIS_MAPS), 20):
        counted, timed = (partial(_lines, k, name, t, column) for column in (NODES, "seconds"))
        made.append(ThesisPart(f"fig-4.{k}", counted, grid([name], _sizes(t)), (), timed))
    fleets = grid(FLEET_SCENARIOS.values(), assignment="euclidean")
    made.append(ThesisPart("table-4.10", partial(_fleets, NODES), (), fleets, partial(_fleets, SECONDS)))
    return made


def _sizes(iterations: int) -> list[tuple[int, int]]:
    return [(population, iterations) for population in POPULATIONS]


def _cells(
    cells: CellRuns, column: str, scenario: str, size: tuple[int, int], published: dict[str, float], form_of: str
) -> list[str]:
    """Return the cells of a row: the thesis's time and our medians of each method."""
    row, how = [], {"assignment": "euclidean"} if scenario in FLEET_SCENARIOS.values() else {}
    for method in METHODS:
        medians = cells.medians(column, grid([scenario], [size], [method], **how))
        scale = 0.001 if column == NODES else 1.0
        row += [f"{published[method]:g}", *(form_of.format(scale * median) for median in medians)]
    return row


def _table(k: int, iterations: int, column: str, cells: CellRuns) -> list[Block]:
    caption = (
        f"**Table 4.{k}**, counted: thousands of generated nodes of a run, {iterations} iterations, beside the "
        "thesis's seconds; measured times stand on their own page."
        if column == NODES
        else f"**Table 4.{k}**: median time of a run, {iterations} iterations; thesis in s, ours in ms."
    )
    rows = []
    for name, (place, size) in product(THESIS_MAPS, enumerate(_sizes(iterations))):
        published = {method: TIMES[name, method, iterations][place] for method in METHODS}
        rows.append([MAP_TITLES[name], str(size[0]), *_cells(cells, column, name, size, published, "{:,.1f}")])
    return [Table(["map", "population", *FORM_HEADS], rows, caption)]


def _fleets(column: str, cells: CellRuns) -> list[Block]:
    few, rows = cells.first(), []
    form_of = "{:,.0f}" if column == NODES else "{:.1f}"
    for size, (place, uavs) in product(CASES, enumerate(FLEETS)):
        published = {method: FLEET_TIMES[method, *size][place] for method in METHODS}
        row = _cells(few, column, FLEET_SCENARIOS[uavs], size, published, form_of)
        rows.append(["{} x {}".format(*size), str(uavs), *row])
    caption = (
        "**Table 4.10**, counted: thousands of generated nodes of a fleet's runs on Map 2 with Munkres, beside the "
        "thesis's seconds."
        if column == NODES
        else "**Table 4.10**: median time of a fleet's runs on Map 2 with Munkres; thesis in s, ours in ms."
    )
    note = (
        f"The thesis does not give the coordinates of its five UAVs; those of Table 4.12 are taken. {few.runs} runs "
        "a cell."
    )
    return [Table(["population x iterations", "UAVs", *FORM_HEADS], rows, caption, [note])]


def _lines(k: int, name: str, iterations: int, column: str, cells: CellRuns) -> list[Block]:
    series = method_series(cells, [name], _sizes(iterations), POPULATIONS, column=column)
    counted = column == NODES
    y, what = ("generated nodes of a run", "generated nodes") if counted else ("seconds", "median time")
    text = f"**Figure 4.{k}**{', counted' * counted}: {what} of a run against the population, {MAP_TITLES[name]}, "
    text += f"{iterations} iterations."
    if iterations == ITERATIONS[1]:
        text += (
            " The caption in the thesis repeats that of Figures 4.14 to 4.16; the section is on time against "
            "population, in two cases, of which this is the second."
        )
    return [Figure(f"fig-4.{k}{'' if counted else '-seconds'}", text, lambda: lines(series, "population", y))]
