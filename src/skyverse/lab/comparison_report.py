"""The report of a study, made from its rows alone."""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import TypeVar

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.lab import figures
from skyverse.lab.budget_runs import BudgetRuns, runs_at_budget
from skyverse.lab.curves import band, expected_run_length, grid, run_lengths, spread
from skyverse.lab.flight_report import READ, answer_times, flight_table, kept_population_section
from skyverse.lab.planner_differences import best_mean, difference_section, matrix, winner
from skyverse.lab.report import (
    Block,
    Cell,
    Figure,
    Printed,
    Report,
    SectionHeading,
    Table,
    Text,
    decimals,
    literal,
    whole_numbers,
)
from skyverse.lab.report_files import write_report_files
from skyverse.lab.rows import Rows
from skyverse.lab.statistics import PairwiseTest, bootstrap, compare_pairs, quantile, sample, wilson
from skyverse.model.short_lines import counted, listed
from skyverse.numerics.tolerances import OPTIMALITY_GAP

T = TypeVar("T")
EQUAL_EFFORT_FACTOR = 1.05
"""Mean efforts within this factor count as equal."""
_MAX_PANELS = 6
"""The number of panels in one figure; more are split over several figures."""
_TARGETS = (0.1, 0.05, 0.02, 0.01)
"""How far above the lower bound, or the best cost known, the targets of run lengths lie."""
_EFFORTS = ("generated_paths", "generated_nodes", "evaluations", "seconds")


def write_report(
    rows: Rows,
    folder: str | Path,
    *,
    title: str = "Comparison",
    formats: Sequence[str] = ("html", "md"),
    figures: Sequence[str] = ("svg",),
) -> list[Path]:
    """Write a report on `rows` into `folder`: success rates, costs, tests, ranks, efforts and figures.

    Parameters
    ----------
    title
        The report's title, in plain text.
    formats, figures
        ``"html"``, ``"md"``, and each table as ``"csv"``, ``"tex"``; ``"svg"``, ``"png"``, ``"pdf"``.

    Returns
    -------
    list of Path
        All files written: the figures, ``report.md`` and ``report.html``.

    Raises
    ------
    InputError
        If there are no finished runs, or a file cannot be written.
    """
    return write_report_files(comparison_report(rows, title=title), folder, formats=formats, figures=figures)


def comparison_report(rows: Rows, *, title: str = "Comparison") -> Report:
    """Return the report on all finished runs; it needs `rows` no more once it is returned.

    Raises
    ------
    InputError
        If there are no finished runs.
    """
    if not len(rows):
        raise InputError(f"{rows.path}: expected finished runs to compare, found none")
    budgets = rows.labels("budget")
    blocks: list[Block] = [Text(_run(rows))]
    for number, budget in enumerate(budgets, 1):
        runs = runs_at_budget(rows, budget)
        mark, suffix = (f"-{number}", f", {budget}") if len(budgets) > 1 else ("", "")
        if said := winner(runs):
            blocks.insert(number - 1, Text(f"{literal(budget)}: {said}" if suffix else said))
        if runs.flown:
            blocks += kept_population_section(rows, runs)
        blocks += [SectionHeading(f"Effort{suffix}"), *_effort(runs, mark)]
        if runs.flown:
            blocks += [answer_times(rows, runs, mark)]
        blocks += [SectionHeading(f"Costs{suffix}"), *_costs(rows, runs, mark)]
        if not runs.flown:
            blocks += [SectionHeading(f"Convergence{suffix}"), *_convergence(rows, runs, mark)]
        blocks += [SectionHeading(f"Differences{suffix}"), *difference_section(runs, mark)]
    if not runs.flown:
        blocks += [SectionHeading("Methods"), Text(_methods(rows, blocks))]
    blocks += [SectionHeading("How to read this"), Text(READ if runs.flown else _READ)]
    return Report(title, [*blocks, SectionHeading("Settings"), *_settings(rows)])


def _run(rows: Rows) -> str:
    """Return what was run, and what is wrong with the runs."""
    told = rows.select(("scenario", "planner", "budget", "seed", "verdict"))
    counts = [counted(len(rows), "run"), counted(len(rows.labels("scenario")), "scenario")]
    counts.append(counted(len(rows.labels("planner")), "planner"))
    budgets = [literal(budget) for budget in rows.labels("budget")]
    lines = [
        f"{', '.join(counts)}. Budget of each UAV: {listed(budgets)}. Seeds: {whole_numbers(told['seed'].tolist())}. "
        "A run is one scenario planned, or flown, once, with all its UAVs."
    ]
    if len(rows) < math.prod(len(set(told[name].tolist())) for name in ("scenario", "planner", "budget", "seed")):
        lines.append("> **Not every planner has run everywhere with every seed.**")
    wrong = [verdict for verdict in told["verdict"].tolist() if verdict]
    if wrong:
        lines.append(
            f"> **The referee found fault with {counted(len(wrong), 'run')}**, first: {literal(wrong[0][:300])}"
        )
    return "\n\n".join(lines)


def _settings(rows: Rows) -> Iterator[Block]:
    told, planners = rows.select(("planner", "settings", "versions")), rows.labels("planner")
    settings = ["; ".join(sorted(set(told["settings"][told["planner"] == label].tolist()))) for label in planners]
    yield Table(("planner", "settings"), list(zip(planners, settings, strict=True)))
    versions = literal("; ".join(sorted(set(told["versions"].tolist()))))
    yield Text(f"Made with {versions}. What stands in brackets behind a version is a digest of its source.")


def _methods(rows: Rows, blocks: Sequence[Block]) -> str:
    """Return the paragraph that a paper says of the runs, and of those statistics that the report has."""
    told = rows.select(("seed", "success"))
    tables = [block for block in blocks if isinstance(block, Table)]
    cells = [cell for table in tables for row in table.rows for cell in row if isinstance(cell, Printed)]
    made = {name for cell in cells for name, number in cell.numbers.items() if number is not None}
    made |= {block.name.split("-")[0] for block in blocks if isinstance(block, Figure)}
    return "".join(said for needed, said in _METHODS.items() if not needed or needed in made).format(
        planners=counted(len(rows.labels("planner")), "planner"),
        scenarios=counted(len(rows.labels("scenario")), "scenario"),
        seeds=f"{counted(len(set(told['seed'].tolist())), 'seed')} ({whole_numbers(told['seed'].tolist())})",
        budgets=listed([literal(budget) for budget in rows.labels("budget")]),
        runs=counted(len(rows), "run"),
        failed=f"{len(rows) - int(told['success'].sum()):,}",
    )


def _effort(runs: BudgetRuns, mark: str) -> Iterator[Block]:
    names = (*_EFFORTS, "iterations")
    means = {name: [float(runs.all(planner, name).mean()) for planner in runs.planners] for name in names}
    searching = [k for k, planner in enumerate(runs.planners) if np.any(runs.all(planner, "stopped_by") != "finished")]
    if not runs.flown:
        yield Text("\n\n".join(_equality(runs, means, searching)))
    yield Table(("planner", *map(_title, names)), list(zip(runs.planners, *means.values(), strict=True)))
    shown = {_title(name): means[name] for name in _EFFORTS}
    yield Figure(f"effort{mark}", "Mean effort of a run.", partial(figures.bars, runs.planners, shown))


def _title(name: str) -> str:
    return name.replace("_", " ")


def _equality(runs: BudgetRuns, means: dict[str, list[float]], searching: list[int]) -> Iterator[str]:
    unit = runs.budget.split()[-1]
    if unit in ("iterations", "seconds"):
        reason = "an iteration is not the same work" if unit == "iterations" else "seconds depend on machine and load"
        yield (
            f"> **The budget is in {unit}: this does not compare planners at equal effort.** "
            f"To every planner {reason}; give a budget of paths for that."
        )
    if len(searching) > 1:
        for name in ("generated_paths", "generated_nodes"):
            found = np.array([means[name][k] for k in searching])
            factor = spread(found)
            least, most = (literal(runs.planners[searching[k]]) for k in (int(found.argmin()), int(found.argmax())))
            if factor <= EQUAL_EFFORT_FACTOR:
                within = f", within {100 * (factor - 1):.1f} %" if factor > 1 else ""
                yield f"The effort was equal in {_title(name)}{within}."
            else:
                quote, times = ("> " if name == "generated_paths" else ""), f"{factor:.3g}" if factor < np.inf else "∞"
                yield f"{quote}**Not equal in {_title(name)}**: {most} had {times} times as many as {least}."
    ended = [literal(planner) for k, planner in enumerate(runs.planners) if k not in searching]
    if ended:
        yield f"Effort is not compared where planners end by themselves, whatever the budget: {listed(ended)}."


def _costs(rows: Rows, runs: BudgetRuns, mark: str) -> Iterator[Block]:
    for scenario in runs.scenarios:
        yield SectionHeading(scenario, level=3)
        found = compare_pairs([runs.costs(planner, [scenario]) for planner in runs.contestants], paired=runs.flown)
        if runs.flown:
            yield flight_table(rows, runs, scenario)
        yield _cost_table(runs, scenario, found)
        if len(found) > 1 and len(runs.scenarios) > 1:
            yield matrix(runs.contestants, found)
    panels = [(s, runs.bound(s), [runs.cells[s, planner]["cost"] for planner in runs.planners]) for s in runs.scenarios]
    for name, some in _split(f"costs{mark}", panels):
        caption = (
            "Costs of all runs: box from first to third quartile with the median, whiskers to the last run within 1.5 "
            "times its length, dots beyond; the diamond is the mean. Costs far beyond all whiskers are stated in "
            "words; a mean that far out is not drawn."
        )
        words = {"quantity": "seconds", "lost": "not safely there"} if runs.flown else {}
        yield Figure(name, caption, partial(figures.boxes, runs.planners, some, **words))


def _cost_table(runs: BudgetRuns, scenario: str, found: dict[tuple[int, int], PairwiseTest]) -> Table:
    cells = [runs.cells[scenario, planner] for planner in runs.planners]
    samples = [sample(cell["cost"]) if len(cell["cost"]) else None for cell in cells]
    means = [np.nan if s is None else s.mean for s in samples]
    digits = decimals([mean for mean in means if np.isfinite(mean)])
    errors = max([digits, *(1 for s in samples if s is not None and s.error > 0)])

    def cost(value: float) -> str:
        return "∞" if value == np.inf else f"{value:,.{errors}f}"

    rows: list[dict[str, Cell]] = []
    for planner, cell, s in zip(runs.planners, cells, samples, strict=True):
        if s is None:
            rows.append({"planner": planner, "reached": Printed("no runs", {"reached": 0, "runs": 0})})
            continue
        reached = int(np.count_nonzero(cell["success"]))
        rate = wilson(reached, s.runs)
        gaps = cell["gap"][np.isfinite(cell["gap"])]
        error = s.error if np.isfinite(s.error) else None
        interval, median = bootstrap(cell["cost"]), float(quantile(cell["cost"], 0.5))
        rows.append(
            {
                "planner": planner,
                "reached": Printed(f"{reached} of {s.runs}", {"reached": reached, "runs": s.runs}),
                "95 % of rate": Printed(
                    f"{100 * rate.low:.0f} to {100 * rate.high:.0f} %", {"rate from": rate.low, "rate to": rate.high}
                ),
                "mean ± SE": Printed(
                    cost(s.mean) + ("" if error is None else f" ± {cost(error)}"),
                    {"mean": s.mean, "standard error": error},
                ),
                "95 % of mean": interval
                and Printed(
                    f"{cost(interval.low)} to {cost(interval.high)}",
                    {"mean from": interval.low, "mean to": interval.high},
                ),
                "median": Printed(cost(median), {"median": median}),
                "gap": Printed(f"{100 * gaps.mean():.1f} %", {"gap": float(gaps.mean())}) if len(gaps) else None,
                "paths": float(np.round(cell["generated_paths"].mean())),
                "nodes": float(np.round(cell["generated_nodes"].mean())),
                "evaluations": float(np.round(cell["evaluations"].mean())),
                "seconds": float(cell["seconds"].mean()),
            }
        )
    bound, gaps = runs.bound(scenario), [runs.cells[scenario, planner]["gap"] for planner in runs.planners]
    attained = np.any(np.concatenate(gaps) <= OPTIMALITY_GAP)
    least = "No flight takes less than" if runs.flown else "No path costs less than"
    said = "The exact optimum is" if attained else least
    caption = "No lower bound is known." if bound is None else f"{said} {bound:,.6g}."
    compared = runs.contestants
    theirs = [mean for planner, mean in zip(runs.planners, means, strict=True) if planner in compared]
    best = " ".join(best_mean(compared, theirs, found))
    return Table.from_records(rows, caption, [best])


def _convergence(rows: Rows, runs: BudgetRuns, mark: str) -> Iterator[Block]:
    panels = []
    compared = runs.contestants
    for scenario in runs.scenarios:
        most = max((runs.cells[scenario, planner]["evaluations"].max(initial=0) for planner in compared), default=0)
        at = grid(float(most))
        where = {"scenario": scenario, "budget": runs.budget}
        bands = [band(rows.histories(planner=planner, **where), at) for planner in compared]
        panels.append((scenario, runs.bound(scenario), bands))
    reached = np.concatenate([[], *(runs.all(planner, "success") for planner in compared)])
    drawn = [any(np.isfinite(bands[k][1]).any() for _, _, bands in panels) for k in range(len(compared))]
    bare = [planner for planner, shown in zip(compared, drawn, strict=True) if not shown]
    if not any(drawn):
        yield Text("No run kept a history with a finite cost, so there is nothing to draw.")
        return
    for name, some in _split(f"convergence{mark}", panels):
        caption = (
            f"Best cost so far of all runs, of which {np.count_nonzero(reached):,} of {len(reached):,} reached their "
            "targets: median (line) and quartiles (band). "
            "What costs more than any band after a quarter of the effort is cut off."
        )
        if bare:
            caption += f" Without a history: {listed([literal(planner) for planner in bare])}."
        yield Figure(name, caption, partial(figures.convergence, compared, some))
    yield from _run_lengths(rows, runs, mark)


def _run_lengths(rows: Rows, runs: BudgetRuns, mark: str) -> Iterator[Block]:
    """Yield how many evaluations it takes to come within each of `_TARGETS` of the reference."""
    records: list[dict[str, Cell]] = []
    lengths: dict[str, list[Floats]] = {planner: [] for planner in runs.contestants}
    for scenario, planner in product(runs.scenarios, runs.contestants):
        targets = [runs.reference(scenario) * (1 + within) for within in _TARGETS]
        histories = rows.histories(scenario=scenario, planner=planner, budget=runs.budget)
        cell = runs.cells[scenario, planner]
        ended = np.where(cell["cost"][:, None] <= targets, cell["evaluations"][:, None], np.inf)
        found = np.minimum(run_lengths(histories, targets), ended)
        lengths[planner].append(found.ravel())
        record: dict[str, Cell] = {"scenario": scenario, "planner": planner}
        for k, within in enumerate(_TARGETS):
            target, hits = f"{100 * within:g} %", int(np.count_nonzero(np.isfinite(found[:, k])))
            ert = expected_run_length(found[:, k], cell["evaluations"])
            numbers: dict[str, float | None] = {f"evaluations to {target}": ert, f"runs within {target}": hits}
            record[target] = Printed(f"{ert:,.0f} ({hits})" if hits else "∞ (0)", numbers)
        records.append(record)
    yield Table.from_records(
        records,
        "Expected run lengths: the evaluations that restarts take in the mean to come within so much of the lower "
        "bound or, where there is none, of the best cost known; in brackets how many runs did. Of a run without a "
        "history all evaluations count.",
    )
    caption = f"The share of runs and of {len(_TARGETS)} targets that were reached after so many evaluations."
    each = [np.concatenate(found) for found in lengths.values()]
    yield Figure(f"run-lengths{mark}", caption, partial(figures.run_lengths, runs.contestants, each))


def _split(name: str, panels: Sequence[figures.Panel[T]]) -> Iterator[tuple[str, Sequence[figures.Panel[T]]]]:
    for part, start in enumerate(range(0, len(panels), _MAX_PANELS)):
        mark = f"-{chr(ord('a') + part)}" if part < 26 else f"-{part}"
        yield name + mark * (len(panels) > _MAX_PANELS), panels[start : start + _MAX_PANELS]


_METHODS = {
    "": """\
Each of {planners} was run on each of {scenarios} with {seeds}; each UAV's search had a budget of {budgets}. The
settings stand in the last table; what it does not say of another package's method is that package's default. Of {runs}
{failed} did not reach their targets; their costs count with the penalty for ending short, or as infinite without any
path. Success rates have Wilson's confidence intervals, at 95 %. Every result was checked by an independent referee.""",
    "p (Holm)": """ Planners were
compared by two-sided Mann-Whitney tests, scenario by scenario, adjusted by Holm's method.""",
    "p that scenarios agree": """ Over several scenarios these
were combined by Stouffer's method, unless Gail and Simon's test found that they disagree on the better one.""",
    "A12": """ Effect sizes
are Vargha and Delaney's A12.""",
    "ranks": """ Mean ranks were tested by Friedman's and Nemenyi's tests with scenarios as blocks.""",
    "mean from": """
Confidence intervals of means are bootstrapped (BCa, 2,000 resamples), at 95 %.""",
    "runs within 1 %": """ Run lengths and convergence count
evaluations of the objective, noted at each improvement; of several UAVs, whose numbers are added up, after each
iteration.""",
}
"""What is said in any case, and where the report has such a number or figure."""
_READ = """\
- *Reached* comes first: a planner that fails is not better for the cheap runs that it has left. Its failures stay in
  every mean, at what their paths cost with the penalty for ending short of the target.
- *± SE* is the standard error of the mean. *95 % of rate* is Wilson's interval of the success rate, *95 % of mean* a
  bootstrap interval (BCa, from 5 runs on). *Gap* is the mean of cost / lower bound - 1 over the runs that reached.
- *p* is the Mann-Whitney test, since a seed means nothing from one planner to another; adjusted by Holm for all pairs
  of its table. Differences count from p < 0.05 on. Over several scenarios the tests are combined by Stouffer's method,
  and Gail and Simon's test tells whether they agree on the better one; where not, neither is better in general.
- *A12* is the chance that a run of the first planner is cheaper than one of the second in the same scenario; 0.5 is no
  difference, 0.56 small, 0.64 medium, 0.71 large.
- Exact planners, which end by themselves at the optimum in every run, are the reference, outside of tests and ranks.
- Tests over runs speak about these scenarios. Only the ranks over scenarios speak, with care, about others like them.
"""
