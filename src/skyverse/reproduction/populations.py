"""Tables 4.6 and 4.7, Figures 4.20 to 4.25: the time of a run against the population."""

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import product

from skyverse.lab.job import Job
from skyverse.lab.report import Block, Figure, Table
from skyverse.reproduction.cell_runs import FORM_HEADS, FORMS, CellRuns, ThesisPart, all_methods, case
from skyverse.reproduction.charts import ChartSeries, lines
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.published import CASES, METHODS, POPULATIONS, THESIS_MAPS, TIMES

ITERATIONS = tuple(iterations for _, iterations in CASES)


def parts() -> list[ThesisPart]:
    """Return the tables and figures of this page of the thesis."""
    tables = [
        ThesisPart(f"table-4.{k}", partial(_jobs, THESIS_MAPS, t), partial(_table, k, t), partial(_seconds, k, t))
        for k, t in enumerate(ITERATIONS, 6)
    ]
    figures = []
    for k, (t, name) in enumerate(product(ITERATIONS, THESIS_MAPS), 20):
        counted, timed = (partial(_lines, k, name, t, column) for column in ("generated_nodes", "seconds"))
        figures.append(ThesisPart(f"fig-4.{k}", partial(_jobs, (name,), t), counted, timed))
    return [*tables, *figures]


def _jobs(maps: Sequence[str], iterations: int, seeds: Sequence[int]) -> Iterable[Job]:
    sizes = [(population, iterations) for population in POPULATIONS]
    yield from all_methods([case(name) for name in maps], sizes, seeds)


def _table(k: int, iterations: int, cells: CellRuns) -> list[Block]:
    caption = (
        f"**Table 4.{k}**, counted: thousands of generated nodes of a run, {iterations} iterations, beside the "
        "thesis's seconds; measured times stand on their own page."
    )
    return _tabled(caption, "generated_nodes", 0.001, "{:,.1f}", iterations, cells)


def _seconds(k: int, iterations: int, cells: CellRuns) -> list[Block]:
    caption = f"**Table 4.{k}**: median time of a run, {iterations} iterations; thesis in s, ours in ms."
    return _tabled(caption, "seconds", 1000, "{:.1f}", iterations, cells)


def _tabled(caption: str, column: str, factor: float, form_of: str, iterations: int, cells: CellRuns) -> list[Block]:
    rows = []
    for name, (place, population) in product(THESIS_MAPS, enumerate(POPULATIONS)):
        row = [MAP_TITLES[name], str(population)]
        for method in METHODS:
            row.append(f"{TIMES[name, method, iterations][place]:g}")
            for form in FORMS:
                (median,) = cells.medians(column, [case(name)], method, form, [(population, iterations)])
                row.append(form_of.format(factor * median))
        rows.append(row)
    return [Table(["map", "population", *FORM_HEADS], rows, caption)]


def _lines(k: int, name: str, iterations: int, column: str, cells: CellRuns) -> list[Block]:
    sizes = [(population, iterations) for population in POPULATIONS]
    series = [
        ChartSeries(method, form, POPULATIONS, cells.medians(column, [case(name)], method, form, sizes))
        for method, form in product(METHODS, FORMS)
    ]
    counted = column == "generated_nodes"
    y, what = ("generated nodes of a run", "generated nodes") if counted else ("seconds", "median time")
    text = f"**Figure 4.{k}**{', counted' * counted}: {what} of a run against the population, {MAP_TITLES[name]}, "
    text += f"{iterations} iterations."
    if iterations == ITERATIONS[1]:
        text += (
            " The caption in the thesis repeats that of Figures 4.14 to 4.16; the section is on time against "
            "population, in two cases, of which this is the second."
        )
    return [Figure(f"fig-4.{k}{'' if counted else '-seconds'}", text, lambda: lines(series, "population", y))]
