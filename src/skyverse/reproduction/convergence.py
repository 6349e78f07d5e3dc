"""Table 4.5 and Figures 4.14 to 4.19: the best cost against iterations, and its distribution after fifty."""

from collections.abc import Iterable, Sequence
from functools import partial

from skyverse.lab.figures import Panel, boxes
from skyverse.lab.report import Block, Figure, Table
from skyverse.lab.run_job import Case, Job
from skyverse.reproduction.cells import FORMS, LONGEST, SCHEDULED, Cells, Part, case, cell, mean, optimum, restarts
from skyverse.reproduction.charts import Series, lines
from skyverse.reproduction.costs import TITLES
from skyverse.reproduction.published import (
    CONVERGENCE,
    CONVERGENCE_ITERATIONS,
    CONVERGENCE_POPULATION,
    CONVERGENCE_RUNS,
    MAPS,
    METHODS,
)


def parts() -> list[Part]:
    """Return the table and figures of this page of the thesis."""
    return [
        Part("table-4.5", partial(_jobs, MAPS, CONVERGENCE_ITERATIONS), _table),
        *(
            Part(f"fig-4.{14 + k}", partial(_jobs, (name,), CONVERGENCE_ITERATIONS), partial(_lines, name, k))
            for k, name in enumerate(MAPS)
        ),
        *(
            Part(f"fig-4.{17 + k}", partial(_jobs, (name,), (LONGEST,)), partial(_boxes, name, k))
            for k, name in enumerate(MAPS)
        ),
    ]


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


def _table(cells: Cells) -> list[Block]:
    blocks: list[Block] = []
    for name in MAPS:
        given, rows = case(name), []
        for place, t in enumerate(CONVERGENCE_ITERATIONS):
            row = [str(t)]
            for method in METHODS:
                ours = [cells.values("cost", given, method, form, CONVERGENCE_POPULATION, t) for form in FORMS]
                row += [f"{CONVERGENCE[name, method][place]}", *(f"{values.mean():.0f}" for values in ours)]
            paths = cells.values("generated_paths", given, "MVO", FORMS[1], CONVERGENCE_POPULATION, t)
            row.append(f"{cells.restart(given, float(paths.mean())).mean():.0f}")
            rows.append(row)
        head = ["iterations", *(f"{m} {form}" for m in METHODS for form in ("thesis", "as run", "as described"))]
        blocks.append(
            Table(
                [*head, "random restart"],
                rows,
                f"**Table 4.5**, {TITLES[name]}: mean best cost, population {CONVERGENCE_POPULATION}. The exact "
                f"optimum is {optimum(given):g}.",
                [
                    f"Thesis: {CONVERGENCE_RUNS} runs; ours: {cells.runs}. Random restart after as many generated "
                    "paths as MVO as described."
                ],
            )
        )
    return blocks


def _lines(name: str, k: int, cells: Cells) -> list[Block]:
    x = CONVERGENCE_ITERATIONS
    series = []
    for method in METHODS:
        series.append(Series(method, "thesis", x, CONVERGENCE[name, method]))
        for form in FORMS:
            found = [mean(cells.values("cost", case(name), method, form, CONVERGENCE_POPULATION, t)) for t in x]
            series.append(Series(method, form, x, *zip(*found, strict=True)))
    text = f"**Figure 4.{14 + k}**: mean best cost against iterations on {TITLES[name]}; bands are standard errors."
    bound = optimum(case(name))
    return [
        Figure(f"fig-4.{14 + k}", text, lambda: lines(series, "iterations", "mean best cost", bound=bound, log=True))
    ]


def _boxes(name: str, k: int, cells: Cells) -> list[Block]:
    given = case(name)
    labels, costs = [], []
    for form in FORMS:
        for method in METHODS:
            labels.append(f"{method} {form}")
            costs.append(cells.values("cost", given, method, form, CONVERGENCE_POPULATION, LONGEST))
    paths = cells.values("generated_paths", given, "MVO", FORMS[1], CONVERGENCE_POPULATION, LONGEST)
    labels.append("random restart")
    costs.append(cells.restart(given, float(paths.mean())))
    panel = Panel(TITLES[name], optimum(given), costs=costs)
    text = (
        f"**Figure 4.{17 + k}**: distribution of the best cost on {TITLES[name]} after {LONGEST} iterations, "
        f"population {CONVERGENCE_POPULATION}, {cells.runs} runs; random restart ({mean(costs[-1])}) after as many "
        "generated paths as MVO as described."
    )
    return [Figure(f"fig-4.{17 + k}", text, lambda: boxes(labels, [panel]))]
