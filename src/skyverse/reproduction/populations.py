"""Tables 4.6 and 4.7, Figures 4.20 to 4.25: the time of a run against the population."""

from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from skyverse.lab.report import Block, Figure, Table
from skyverse.lab.run_job import Job
from skyverse.reproduction.cell_runs import FORM_HEADS, FORMS, CellRuns, ThesisPart, all_methods, case
from skyverse.reproduction.charts import ChartSeries, lines
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.published import CASES, METHODS, POPULATIONS, THESIS_MAPS, TIMES

ITERATIONS = tuple(iterations for _, iterations in CASES)


def parts() -> list[ThesisPart]:
    """Return the tables and figures of this page of the thesis."""
    found = []
    for k, iterations in enumerate(ITERATIONS):
        found.append(
            ThesisPart(
                f"table-4.{6 + k}",
                partial(_jobs, THESIS_MAPS, iterations),
                partial(_table, k, iterations),
                partial(_seconds, k, iterations),
            )
        )
    for k, iterations in enumerate(ITERATIONS):
        for j, name in enumerate(THESIS_MAPS):
            number = f"4.{20 + 3 * k + j}"
            found.append(
                ThesisPart(
                    f"fig-{number}",
                    partial(_jobs, (name,), iterations),
                    partial(_lines, number, name, iterations, "generated_nodes"),
                    partial(_lines, number, name, iterations, "seconds"),
                )
            )
    return found


def _jobs(maps: Sequence[str], iterations: int, seeds: Sequence[int]) -> Iterable[Job]:
    sizes = [(population, iterations) for population in POPULATIONS]
    yield from all_methods([case(name) for name in maps], sizes, seeds)


def _table(k: int, iterations: int, cells: CellRuns) -> list[Block]:
    caption = (
        f"**Table 4.{6 + k}**, counted: thousands of generated nodes of a run, {iterations} iterations, beside the "
        "thesis's seconds. Time follows the nodes; measured times stand on their own page."
    )
    return _tabled(caption, "generated_nodes", 0.001, "{:,.1f}", iterations, cells)


def _seconds(k: int, iterations: int, cells: CellRuns) -> list[Block]:
    caption = f"**Table 4.{6 + k}**: median time of a run, {iterations} iterations; thesis in s, ours in ms."
    return _tabled(caption, "seconds", 1000, "{:.1f}", iterations, cells)


def _tabled(caption: str, column: str, factor: float, form_of: str, iterations: int, cells: CellRuns) -> list[Block]:
    rows = []
    for name in THESIS_MAPS:
        for place, population in enumerate(POPULATIONS):
            row = [MAP_TITLES[name], str(population)]
            for method in METHODS:
                ours = [cells.values(column, case(name), method, form, population, iterations) for form in FORMS]
                row.append(f"{TIMES[name, method, iterations][place]:g}")
                row += [form_of.format(factor * float(np.median(values))) for values in ours]
            rows.append(row)
    return [Table(["map", "population", *FORM_HEADS], rows, caption)]


def _lines(number: str, name: str, iterations: int, column: str, cells: CellRuns) -> list[Block]:
    series = [
        ChartSeries(
            method,
            form,
            POPULATIONS,
            [float(np.median(cells.values(column, case(name), method, form, n, iterations))) for n in POPULATIONS],
        )
        for method in METHODS
        for form in FORMS
    ]
    counted = column == "generated_nodes"
    y = "generated nodes of a run" if counted else "seconds"
    what = "generated nodes" if counted else "median time"
    text = f"**Figure {number}**{', counted' * counted}: {what} of a run against the population, {MAP_TITLES[name]}, "
    text += f"{iterations} iterations."
    if iterations == ITERATIONS[1]:
        text += (
            " The caption in the thesis repeats that of Figures 4.14 to 4.16; the section is on time against "
            "population, in two cases, of which this is the second."
        )
    stem = f"fig-{number}" if counted else f"fig-{number}-seconds"
    return [Figure(stem, text, lambda: lines(series, "population", y))]
