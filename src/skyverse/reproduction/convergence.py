"""Table 4.5 and Figures 4.14 to 4.19: the best cost against iterations, and its distribution after fifty."""

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import product

from skyverse.lab.figures import boxes
from skyverse.lab.job import Case, Job
from skyverse.lab.report import Block, Figure, Table, Text
from skyverse.lab.statistics import Sample, sample
from skyverse.reproduction.cell_runs import (
    FORM_HEADS,
    FORMS,
    LAST_ITERATION,
    SCHEDULED,
    CellRuns,
    ThesisPart,
    case,
    cell,
    mean,
    optimum,
    restarts,
)
from skyverse.reproduction.charts import ChartSeries, lines
from skyverse.reproduction.claim_verdict import mean_difference
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.published import (
    CONVERGENCE,
    CONVERGENCE_ITERATIONS,
    CONVERGENCE_POPULATION,
    CONVERGENCE_RUNS,
    METHODS,
    THESIS_MAPS,
)


def parts() -> list[ThesisPart]:
    """Return the table and figures of this page of the thesis."""
    table = ThesisPart("table-4.5", partial(_jobs, THESIS_MAPS, CONVERGENCE_ITERATIONS), _table)
    curves = [
        ThesisPart(f"fig-4.{k}", partial(_jobs, (name,), CONVERGENCE_ITERATIONS), partial(_lines, name, k))
        for k, name in enumerate(THESIS_MAPS, 14)
    ]
    spreads = [
        ThesisPart(f"fig-4.{k}", partial(_jobs, (name,), (LAST_ITERATION,)), partial(_boxes, name, k))
        for k, name in enumerate(THESIS_MAPS, 17)
    ]
    return [table, *curves, *spreads]


def up_to(given: Case, iterations: Sequence[int], seeds: Sequence[int]) -> Iterable[Job]:
    """Yield runs of all methods and forms from which the best cost after each of these iterations can be told."""
    for method in METHODS:
        for form in FORMS:
            for t in iterations if method in SCHEDULED else (max(iterations),):
                yield from cell(given, method, form, CONVERGENCE_POPULATION, t, seeds)


def _jobs(maps: Sequence[str], iterations: Sequence[int], seeds: Sequence[int]) -> Iterable[Job]:
    for name in maps:
        yield from up_to(case(name), iterations, seeds)
        yield from restarts(case(name), seeds)


def _table(cells: CellRuns) -> list[Block]:
    blocks: list[Block] = [Text(_agreement(cells))]
    for name in THESIS_MAPS:
        given, rows = case(name), []
        for place, t in enumerate(CONVERGENCE_ITERATIONS):
            row = [str(t)]
            for method in METHODS:
                ours = [cells.values("cost", given, method, form, CONVERGENCE_POPULATION, t) for form in FORMS]
                row += [f"{CONVERGENCE[name, method][place]}", *(f"{values.mean():.0f}" for values in ours)]
            paths = cells.values("generated_paths", given, "MVO", FORMS[1], CONVERGENCE_POPULATION, t)
            row.append(f"{cells.restart(given, float(paths.mean())).mean():.0f}")
            rows.append(row)
        blocks.append(
            Table(
                ["iterations", *FORM_HEADS, "random restart"],
                rows,
                f"**Table 4.5**, {MAP_TITLES[name]}: mean best cost, population {CONVERGENCE_POPULATION}. The exact "
                f"optimum is {optimum(given):g}.",
                [
                    f"Thesis: {CONVERGENCE_RUNS} runs; ours: {cells.runs}. Random restart after as many generated "
                    "paths as MVO as described."
                ],
            )
        )
    return blocks


def _agreement(cells: CellRuns) -> str:
    """Say how many cells of the table differ by more than two standard errors, map by map."""
    off, ends = {}, {}
    for name in THESIS_MAPS:
        away = []
        for method, (place, t) in product(METHODS, enumerate(CONVERGENCE_ITERATIONS)):
            ours = sample(cells.values("cost", case(name), method, FORMS[0], CONVERGENCE_POPULATION, t))
            theirs = Sample(CONVERGENCE[name, method][place], ours.deviation, CONVERGENCE_RUNS)
            found = mean_difference(ours, theirs)
            away.append(abs(found.value) > 2 * found.error)
        off[name] = sum(away)
        last = cells.values("cost", case(name), "MVO", FORMS[1], CONVERGENCE_POPULATION, LAST_ITERATION)
        ends[name] = f"{CONVERGENCE[name, 'MVO'][-1]} and {last.mean():.1f}"
    count = len(METHODS) * len(CONVERGENCE_ITERATIONS)
    return (
        f"**{sum(off.values())} of the {count * len(THESIS_MAPS)} cells of Table 4.5 differ by more than two standard "
        f"errors** from ours as run: {', '.join(f'{n} of {count} on {MAP_TITLES[name]}' for name, n in off.items())}. "
        "The thesis gives no deviations here; ours are taken for its runs. On Map 3 the last row agrees with MVO as "
        f"described ({ends['map3']}), unlike those of the other maps ({ends['map1']}; {ends['map2']})."
    )


def _lines(name: str, k: int, cells: CellRuns) -> list[Block]:
    x = CONVERGENCE_ITERATIONS
    sizes = [(CONVERGENCE_POPULATION, t) for t in x]
    series = []
    for method in METHODS:
        series.append(ChartSeries(method, "thesis", x, CONVERGENCE[name, method]))
        series += [ChartSeries(method, form, x, *cells.means([case(name)], method, form, sizes)) for form in FORMS]
    text = f"**Figure 4.{k}**: mean best cost against iterations on {MAP_TITLES[name]}; bands are standard errors."
    bound = optimum(case(name))
    return [Figure(f"fig-4.{k}", text, lambda: lines(series, "iterations", "mean best cost", bound=bound, log=True))]


def _boxes(name: str, k: int, cells: CellRuns) -> list[Block]:
    given, cell_size = case(name), (CONVERGENCE_POPULATION, LAST_ITERATION)
    labels = [f"{method} {form}" for form in FORMS for method in METHODS]
    costs = [cells.values("cost", given, method, form, *cell_size) for form in FORMS for method in METHODS]
    paths = cells.values("generated_paths", given, "MVO", FORMS[1], *cell_size)
    labels.append("random restart")
    costs.append(cells.restart(given, float(paths.mean())))
    panel = (MAP_TITLES[name], optimum(given), costs)
    text = (
        f"**Figure 4.{k}**: distribution of the best cost on {MAP_TITLES[name]} after {LAST_ITERATION} "
        f"iterations, population {CONVERGENCE_POPULATION}, {cells.runs} runs; random restart ({mean(costs[-1])}) after "
        "as many generated paths as MVO as described."
    )
    return [Figure(f"fig-4.{k}", text, lambda: boxes(labels, [panel]))]
