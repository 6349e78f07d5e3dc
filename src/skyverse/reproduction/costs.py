"""Tables 4.2 to 4.4 and Figures 4.10 to 4.13: best costs and times of two cases on three maps."""

from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from skyverse.lab.report import Block, Figure, Table, Text
from skyverse.lab.run_job import Job
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, holm
from skyverse.reproduction.cell_runs import FORMS, CellRuns, ThesisPart, all_methods, case, mean, optimum, restarts
from skyverse.reproduction.charts import ChartSeries, bars
from skyverse.reproduction.published import CASES, CELL_RUNS, COSTS, METHODS, THESIS_MAPS

MAP_TITLES = {"map1": "Map 1", "map2": "Map 2", "map3": "Map 3"}


def parts() -> list[ThesisPart]:
    """Return the tables and figures of this page of the thesis."""
    found = [
        ThesisPart(
            f"table-4.{2 + k}", partial(_jobs, (name,), CASES), partial(_table, name, k), partial(_times, name, k)
        )
        for k, name in enumerate(THESIS_MAPS)
    ]
    found.append(ThesisPart("cells", partial(_jobs, THESIS_MAPS, CASES), _agreement))
    for k, which in enumerate(CASES):
        found.append(
            ThesisPart(f"fig-4.{10 + k}", partial(_jobs, THESIS_MAPS, (which,)), partial(_cost_bars, k, which))
        )
    for k, which in enumerate(CASES):
        shown, timed = partial(_bars, k, which), partial(_bars_s, k, which)
        found.append(ThesisPart(f"fig-4.{12 + k}", partial(_jobs, THESIS_MAPS, (which,)), shown, timed))
    return found


def _agreement(cells: CellRuns) -> list[Block]:
    """Say which of the 18 cells agree with the thesis by Welch's t-test, adjusted by Holm's method, at 5 %."""
    from scipy.stats import ttest_ind_from_stats

    where, raw, away = [], [], []
    for name in THESIS_MAPS:
        for population, iterations in CASES:
            for method in METHODS:
                ours = cells.values("cost", case(name), method, FORMS[0], population, iterations)
                theirs = COSTS[name, method, population, iterations]
                stats = (ours.mean(), ours.std(ddof=1), len(ours), theirs.mean, theirs.deviation, CELL_RUNS)
                raw.append(float(ttest_ind_from_stats(*stats, equal_var=False).pvalue))
                away.append(difference(cells, name, method, population, iterations))
                where.append(f"{MAP_TITLES[name]}, {method}, {population} x {iterations}")
    p = holm(raw)
    differ = [
        f"{place} ({z:+.1f})" for place, z, chance in zip(where, away, p, strict=True) if chance < SIGNIFICANCE_LEVEL
    ]
    near = [
        f"{place} ({z:+.1f})"
        for place, z, chance in zip(where, away, p, strict=True)
        if chance >= SIGNIFICANCE_LEVEL and abs(z) > 2
    ]
    text = (
        f"**{len(where) - len(differ)} of the {len(where)} cells of Tables 4.2 to 4.4 come out** with the operators "
        "as run; the others differ significantly (Welch's t-test, adjusted for 18 tests by Holm's method, 5 %): "
        f"{', '.join(differ) or 'none'}; in brackets the difference in standard errors of both."
    )
    if near:
        text += f" Beyond two standard errors, as one of eighteen may well be by chance: {', '.join(near)}."
    if any("Map 3, MVO" in place for place in differ):
        text += (
            " The published cells of MVO on Map 3 contradict the thesis's own Table 4.5 (298 after 25 iterations, "
            "287 after 40, with 25 universes), and come out on no version of the map. Nothing was tuned to reach "
            "them."
        )
    return [Text(text)]


def difference(cells: CellRuns, name: str, method: str, population: int, iterations: int) -> float:
    """Return the difference of our mean, as run, from the published one, in standard errors of the difference."""
    ours = cells.values("cost", case(name), method, FORMS[0], population, iterations)
    published = COSTS[name, method, population, iterations]
    error = np.hypot(ours.std(ddof=1) / np.sqrt(len(ours)), published.deviation / np.sqrt(CELL_RUNS))
    return float((ours.mean() - published.mean) / error)


def _jobs(maps: Sequence[str], cases: Sequence[tuple[int, int]], seeds: Sequence[int]) -> Iterable[Job]:
    for name in maps:
        yield from all_methods([case(name)], cases, seeds)
        yield from restarts(case(name), seeds)


def _table(name: str, k: int, cells: CellRuns) -> list[Block]:
    given = case(name)
    costs, efforts = [], []
    for population, iterations in CASES:
        for method in METHODS:
            published = COSTS[name, method, population, iterations]
            which = f"{method}, {population} x {iterations}"
            run, told = (cells.values("cost", given, method, form, population, iterations) for form in FORMS)
            paths = [cells.values("generated_paths", given, method, form, population, iterations) for form in FORMS]
            nodes = [cells.values("generated_nodes", given, method, form, population, iterations) for form in FORMS]
            reached = [cells.values("success", given, method, form, population, iterations) for form in FORMS]
            costs.append(
                [
                    which,
                    f"{published.mean:g} ± {published.deviation / np.sqrt(CELL_RUNS):.1f}",
                    str(mean(run)),
                    f"{difference(cells, name, method, population, iterations):+.1f}",
                    str(mean(cells.restart(given, float(paths[0].mean())))),
                    str(mean(told)),
                    str(mean(cells.restart(given, float(paths[1].mean())))),
                    f"{optimum(given):g}",
                ]
            )
            spreads = [f"{costs.std(ddof=1):.1f}" for costs in (run, told)]
            shares = [f"{success.mean():.0%}" for success in reached]
            counts = [f"{count.mean():,.0f}" for count in paths] + [f"{n.mean() / 1000:,.1f}" for n in nodes]
            efforts.append([which, f"{published.deviation:g}", *spreads, *shares, *counts])
    number = f"4.{2 + k}"
    return [
        Table(
            [
                "method, population x iterations",
                "thesis",
                "as run",
                "difference",
                "restart, effort as run",
                "as described",
                "restart, effort as described",
                "exact",
            ],
            costs,
            f"**Table {number}**: mean best cost on {MAP_TITLES[name]}, with its standard error.",
            [
                f"Thesis: {CELL_RUNS} runs a cell; ours: {cells.runs}. The difference is that of *as run* to the "
                "thesis, in standard errors of both. *Restart* is the memoryless baseline after as many generated "
                "paths."
            ],
        ),
        Table(
            [
                "method, population x iterations",
                "deviation, thesis",
                "as run",
                "as described",
                "goal reached, as run",
                "as described",
                "paths, as run",
                "as described",
                "1,000 nodes, as run",
                "as described",
            ],
            efforts,
            f"**Table {number}**, spread and effort: standard deviation of the best cost, share of runs that reached "
            "the goal, generated paths and nodes of a run.",
        ),
    ]


def _times(name: str, k: int, cells: CellRuns) -> list[Block]:
    rows = []
    for population, iterations in CASES:
        for method in METHODS:
            ours = [cells.values("seconds", case(name), method, form, population, iterations) for form in FORMS]
            published = COSTS[name, method, population, iterations].seconds
            millis = [f"{1000 * np.median(values):.1f}" for values in ours]
            rows.append([f"{method}, {population} x {iterations}", f"{published:g}", *millis])
    head = ["method, population x iterations", "thesis, s", "as run, ms", "as described, ms"]
    return [Table(head, rows, f"**Table 4.{2 + k}**: time of a run on {MAP_TITLES[name]} (ours: the median).")]


def _cost_bars(k: int, which: tuple[int, int], cells: CellRuns) -> list[Block]:
    series = []
    for method in METHODS:
        published = [COSTS[name, method, *which] for name in THESIS_MAPS]
        errors = [p.deviation / float(np.sqrt(CELL_RUNS)) for p in published]
        series.append(ChartSeries(method, "thesis", [], [p.mean for p in published], errors))
        for form in FORMS:
            found = [mean(cells.values("cost", case(name), method, form, *which)) for name in THESIS_MAPS]
            series.append(ChartSeries(method, form, [], *zip(*found, strict=True)))
    bounds = [optimum(case(name)) for name in THESIS_MAPS]
    text = f"**Figure 4.{10 + k}**: mean best cost, {which[0]} x {which[1]}, with its standard error."
    names = list(MAP_TITLES.values())
    return [Figure(f"fig-4.{10 + k}", text, lambda: bars(names, series, "mean best cost", bounds=bounds))]


def _bars(k: int, which: tuple[int, int], cells: CellRuns) -> list[Block]:
    text = (
        f"**Figure 4.{12 + k}**, counted: generated nodes of a run, {which[0]} x {which[1]}. Time follows them; "
        "measured times stand on their own page."
    )
    return [_effort_bars(f"fig-4.{12 + k}", text, which, cells, "generated_nodes", "generated nodes of a run")]


def _bars_s(k: int, which: tuple[int, int], cells: CellRuns) -> list[Block]:
    text = f"**Figure 4.{12 + k}**: median time of a run, {which[0]} x {which[1]} (the thesis took 4 to 28 s)."
    return [_effort_bars(f"fig-4.{12 + k}-seconds", text, which, cells, "seconds", "seconds")]


def _effort_bars(name: str, text: str, which: tuple[int, int], cells: CellRuns, column: str, y: str) -> Figure:
    series = [
        ChartSeries(
            method,
            form,
            [],
            [float(np.median(cells.values(column, case(place), method, form, *which))) for place in THESIS_MAPS],
        )
        for method in METHODS
        for form in FORMS
    ]
    return Figure(name, text, lambda: bars(list(MAP_TITLES.values()), series, y))
