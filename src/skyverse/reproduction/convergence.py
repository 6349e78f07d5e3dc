"""Table 4.5 and Figures 4.14 to 4.19: the best cost against iterations, and its distribution after fifty."""

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import product

from skyverse.lab import Figure, Sample, Table, Text, sample
from skyverse.lab.figures import boxes
from skyverse.lab.report import Block
from skyverse.mission.assignment import Assignment
from skyverse.reproduction.cells import (
    FORM_HEADS,
    FORMS,
    LAST_ITERATION,
    SCHEDULED,
    Cell,
    CellRuns,
    ThesisPart,
    grid,
    restart,
)
from skyverse.reproduction.charts import lines, method_series
from skyverse.reproduction.claim_verdict import mean_difference
from skyverse.reproduction.published import (
    CONVERGENCE,
    CONVERGENCE_ITERATIONS,
    CONVERGENCE_POPULATION,
    CONVERGENCE_RUNS,
    MAP_TITLES,
    METHODS,
    THESIS_MAPS,
)

LAST = (CONVERGENCE_POPULATION, LAST_ITERATION)


def parts() -> list[ThesisPart]:
    """Return the table and figures of this page of the thesis."""
    cells = {name: [*up_to([name], CONVERGENCE_ITERATIONS), restart(name)] for name in THESIS_MAPS}
    return [
        ThesisPart("table-4.5", _table, [cell for some in cells.values() for cell in some]),
        *(ThesisPart(f"fig-4.{k}", partial(_lines, name, k), cells[name]) for k, name in enumerate(THESIS_MAPS, 14)),
        *(
            ThesisPart(f"fig-4.{k}", partial(_boxes, name, k), [*grid([name], [LAST]), restart(name)])
            for k, name in enumerate(THESIS_MAPS, 17)
        ),
    ]


def up_to(scenarios: Iterable[str], iterations: Sequence[int], assignment: Assignment = "path-cost") -> list[Cell]:
    """Return cells of all methods and forms from which the best cost after each of these iterations can be told."""
    return [
        Cell(name, method, form, CONVERGENCE_POPULATION, t, assignment)
        for name, method, form in product(scenarios, METHODS, FORMS)
        for t in (iterations if method in SCHEDULED else (max(iterations),))
    ]


def _table(cells: CellRuns) -> list[Block]:
    blocks: list[Block] = [Text(_agreement(cells))]
    for name in THESIS_MAPS:
        rows = []
        for place, t in enumerate(CONVERGENCE_ITERATIONS):
            row = [str(t)]
            for method in METHODS:
                ours, _ = cells.means(grid([name], [(CONVERGENCE_POPULATION, t)], [method]))
                row += [f"{CONVERGENCE[name, method][place]}", *(f"{mean:.0f}" for mean in ours)]
            paths = cells.values("generated_paths", Cell(name, "MVO", FORMS[1], CONVERGENCE_POPULATION, t))
            row.append(f"{cells.restart(name, float(paths.mean())).mean():.0f}")
            rows.append(row)
        blocks.append(
            Table(
                ["iterations", *FORM_HEADS, "random restart"],
                rows,
                f"**Table 4.5**, {MAP_TITLES[name]}: mean best cost, population {CONVERGENCE_POPULATION}. The exact "
                f"optimum is {cells.optimum(name):g}.",
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
            ours = sample(cells.values("cost", Cell(name, method, FORMS[0], CONVERGENCE_POPULATION, t)))
            theirs = Sample(CONVERGENCE[name, method][place], ours.deviation, CONVERGENCE_RUNS)
            found = mean_difference(ours, theirs)
            away.append(abs(found.value) > 2 * found.error)
        off[name] = sum(away)
        last = cells.values("cost", Cell(name, "MVO", FORMS[1], *LAST))
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
    thesis = {method: (CONVERGENCE[name, method], None) for method in METHODS}
    series = method_series(cells, [name], sizes, x, thesis=thesis)
    text = f"**Figure 4.{k}**: mean best cost against iterations on {MAP_TITLES[name]}; bands are standard errors."
    bound = cells.optimum(name)
    return [Figure(f"fig-4.{k}", text, lambda: lines(series, "iterations", "mean best cost", bound=bound, log=True))]


def _boxes(name: str, k: int, cells: CellRuns) -> list[Block]:
    drawn = {f"{m} {form}": cells.values("cost", Cell(name, m, form, *LAST)) for form in FORMS for m in METHODS}
    paths = cells.values("generated_paths", Cell(name, "MVO", FORMS[1], *LAST))
    drawn["random restart"] = cells.restart(name, float(paths.mean()))
    panel = (MAP_TITLES[name], cells.optimum(name), list(drawn.values()))
    text = (
        f"**Figure 4.{k}**: distribution of the best cost on {MAP_TITLES[name]} after {LAST_ITERATION} "
        f"iterations, population {CONVERGENCE_POPULATION}, {cells.runs} runs; random restart "
        f"({sample(drawn['random restart'])}) after as many generated paths as MVO as described."
    )
    return [Figure(f"fig-4.{k}", text, lambda: boxes(list(drawn), [panel]))]
