"""What a study found, as a report made from its rows alone."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from skyverse.errors import InputError
from skyverse.lab import figures
from skyverse.lab.contrast import Contrast, contrasts
from skyverse.lab.curves import Band, band, grid, profile, spread
from skyverse.lab.report import Block, Cell, Figure, Heading, Report, Table, Text, decimals, literal, write
from skyverse.lab.rows import Rows
from skyverse.lab.sheet import Sheet, sheet
from skyverse.lab.statistics import LEVEL, magnitude, ranking, summary, wilson

EQUAL = 1.05
"""Mean efforts within this factor count as equal."""
_PANELS = 6
_EFFORTS = {
    "generated_paths": "generated paths",
    "generated_nodes": "generated nodes",
    "evaluations": "evaluations",
    "seconds": "seconds",
}


def write_report(
    rows: Rows,
    folder: str | Path,
    *,
    title: str = "Comparison",
    formats: Sequence[str] = ("html", "md"),
    figures: Sequence[str] = ("svg",),
) -> list[Path]:
    """Write what `rows` tell into `folder`: success rates, costs, tests, ranks, efforts and figures.

    Parameters
    ----------
    title
        The report's title, in plain text.
    formats, figures
        ``"html"``, ``"md"``; ``"svg"``, ``"png"``, ``"pdf"``.

    Returns
    -------
    list of Path
        All files written: the figures, ``report.md`` and ``report.html``.

    Raises
    ------
    InputError
        If there are no finished runs, or a file cannot be written.
    """
    return write(comparison_report(rows, title=title), folder, formats=formats, figures=figures)


def comparison_report(rows: Rows, *, title: str = "Comparison") -> Report:
    """Return the report on all finished runs; histories are read one at a time, and nothing is left to be read.

    Raises
    ------
    InputError
        If there are none.
    """
    if not len(rows):
        raise InputError(f"{rows.path}: expected finished runs to compare, found none")
    budgets = rows.labels("budget")
    blocks = list(_made(rows))
    for number, budget in enumerate(budgets, 1):
        runs = sheet(rows, budget)
        mark = f"-{number}" if len(budgets) > 1 else ""
        suffix = f", {budget}" if len(budgets) > 1 else ""
        blocks += [Heading(f"Effort{suffix}"), *_effort(runs, mark)]
        blocks += [Heading(f"Costs{suffix}"), *_costs(runs, mark)]
        blocks += [Heading(f"Convergence{suffix}"), *_convergence(rows, runs, mark)]
        blocks += [Heading(f"Differences{suffix}"), *_together(runs, mark)]
    return Report(title, [*blocks, Heading("How to read this"), Text(_READ)])


def _made(rows: Rows) -> Iterator[Block]:
    told = rows.select(("scenario", "planner", "budget", "seed", "settings", "versions", "verdict"))
    counts = [_many(len(rows), "run")]
    counts += [_many(len(rows.labels(kind)), kind) for kind in ("scenario", "planner")]
    lines = [
        f"{', '.join(counts)}. Budget of each UAV's search: {_and(rows.labels('budget'))}. Seeds: "
        f"{_seeds(told['seed'])}. A run is one scenario planned once, with all its UAVs; its cost is their sum."
    ]
    lines += [f"Made with {literal(version)}." for version in sorted(set(told["versions"].tolist()))]
    cells = {tuple(cell) for cell in zip(told["scenario"], told["planner"], told["budget"], strict=True)}
    full = len(cells) * len(set(told["seed"].tolist()))
    if full != len(rows) or len(cells) != len(set(told["scenario"])) * len(set(told["planner"])) * len(
        set(told["budget"])
    ):
        lines.append("> **Not every planner has run everywhere with every seed.** Runs are paired where both have one.")
    wrong = [verdict for verdict in told["verdict"].tolist() if verdict]
    if wrong:
        lines.append(f"> **The referee found fault with {_many(len(wrong), 'run')}**, first: {literal(wrong[0][:300])}")
    yield Text("\n\n".join(lines))
    yield Table(
        ("planner", "settings"),
        [
            (label, "; ".join(sorted(set(told["settings"][told["planner"] == label].tolist()))))
            for label in rows.labels("planner")
        ],
    )


def _effort(runs: Sheet, mark: str) -> Iterator[Block]:
    means = {
        name: [float(runs.all(planner, name).mean()) for planner in runs.planners] for name in (*_EFFORTS, "iterations")
    }
    searching = [k for k, planner in enumerate(runs.planners) if np.any(runs.all(planner, "stopped_by") != "finished")]
    yield Text("\n\n".join(_equality(runs, means, searching)))
    yield Table(
        ("planner", *_EFFORTS.values(), "iterations"),
        [(planner, *(means[name][k] for name in (*_EFFORTS, "iterations"))) for k, planner in enumerate(runs.planners)],
    )
    shown = {title: means[name] for name, title in _EFFORTS.items()}
    yield Figure(f"effort{mark}", "Mean effort of a run.", partial(figures.bars, runs.planners, shown))


def _equality(runs: Sheet, means: dict[str, list[float]], searching: list[int]) -> Iterator[str]:
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
            if factor <= EQUAL:
                within = f", within {100 * (factor - 1):.1f} %" if factor > 1 else ""
                yield f"The effort was equal in {_EFFORTS[name]}{within}."
            else:
                quote, times = ("> " if name == "generated_paths" else ""), f"{factor:.3g}" if factor < np.inf else "∞"
                yield f"{quote}**Not equal in {_EFFORTS[name]}**: {most} had {times} times as many as {least}."
    ended = [literal(planner) for k, planner in enumerate(runs.planners) if k not in searching]
    if ended:
        yield f"Ended by themselves, whatever the budget, and are left out of this: {_and(ended)}."


def _costs(runs: Sheet, mark: str) -> Iterator[Block]:
    for scenario in runs.scenarios:
        yield Heading(scenario, level=3)
        found = contrasts([runs.costs(planner, [scenario]) for planner in runs.planners])
        yield _cost_table(runs, scenario, found)
        if len(found) > 1 and len(runs.scenarios) > 1:
            yield _matrix(runs.planners, found)
    panels = [
        figures.Panel(s, runs.exact(s), costs=[runs.cells[s, planner]["cost"] for planner in runs.planners])
        for s in runs.scenarios
    ]
    for name, some in _split(f"costs{mark}", panels):
        caption = (
            "Costs of all runs: box from first to third quartile with the median, whiskers to the last run within 1.5 "
            "times its length, dots beyond; the rhomb is the mean. Costs far beyond all whiskers are told in words."
        )
        yield Figure(name, caption, partial(figures.boxes, runs.planners, some))


def _cost_table(runs: Sheet, scenario: str, found: dict[tuple[int, int], Contrast]) -> Table:
    cells = [runs.cells[scenario, planner] for planner in runs.planners]
    summaries = [summary(cell["cost"]) for cell in cells]
    digits = decimals([s.mean for s in summaries if np.isfinite(s.mean)])
    errors = max([digits, *(1 for s in summaries if s.standard_error)])

    def cost(value: float) -> str:
        return "∞" if value == np.inf else f"{value:,.{errors}f}"

    rows: list[list[Cell]] = []
    for planner, cell, s in zip(runs.planners, cells, summaries, strict=True):
        if s.runs == 0:
            rows.append([planner, "no runs", *[None] * 9])
            continue
        reached = int(np.count_nonzero(cell["success"]))
        rate = wilson(reached, s.runs)
        gaps = cell["gap"][np.isfinite(cell["gap"])]
        rows.append(
            [
                planner,
                f"{reached} of {s.runs}",
                f"{100 * rate.low:.0f} to {100 * rate.high:.0f} %",
                cost(s.mean) if s.standard_error is None else f"{cost(s.mean)} ± {cost(s.standard_error)}",
                None if s.interval is None else f"{cost(s.interval.low)} to {cost(s.interval.high)}",
                cost(s.median),
                f"{100 * gaps.mean():.1f} %" if len(gaps) else None,
                *(float(np.round(cell[name].mean())) for name in ("generated_paths", "generated_nodes", "evaluations")),
                float(cell["seconds"].mean()),
            ]
        )
    head = ("planner", "reached", "95 % of rate", "mean ± SE", "95 % of mean", "median", "gap")
    exact = runs.exact(scenario)
    return Table(
        (*head, "paths", "nodes", "evaluations", "seconds"),
        rows,
        caption="The exact optimum is not known." if exact is None else f"The exact optimum is {exact:,.6g}.",
        notes=[" ".join(_verdict(runs.planners, [s.mean for s in summaries], found))],
    )


def _verdict(planners: Sequence[str], means: list[float], found: dict[tuple[int, int], Contrast]) -> Iterator[str]:
    """Say who has the lowest mean, and from whom it can be told apart."""
    if not found:
        return
    best = int(np.nanargmin(means))
    if means[best] == np.inf:
        yield "No planner has a finite mean."
        return
    others = {i if j == best else j: contrast for (i, j), contrast in found.items() if best in (i, j)}
    yield f"Lowest mean: {literal(planners[best])}."
    worse = [k for k, contrast in others.items() if contrast.p is not None and contrast.p < LEVEL]
    alike = [k for k, contrast in others.items() if contrast.p is not None and contrast.p >= LEVEL]
    few = [k for k, contrast in others.items() if contrast.p is None]
    if worse:
        yield f"Significantly different from it: {_named(planners, worse)}."
    if alike:
        yield f"Not told apart from it: {_named(planners, alike)}."
    if few:
        runs = _many(max(others[k].runs for k in few), "run")
        yield f"Whether they differ from it cannot be told with {runs}: {_named(planners, few)}."


def _matrix(planners: Sequence[str], found: dict[tuple[int, int], Contrast]) -> Table:
    def cell(row: int, column: int) -> str:
        if row == column:
            return ""
        contrast = found.get((min(row, column), max(row, column)))
        if contrast is None:
            return "no runs"
        return f"{contrast.chance if row < column else 1 - contrast.chance:.2f} ({_p(contrast.p)})"

    everyone = range(len(planners))
    return Table(
        ("cheaper than", *planners),
        [(planners[row], *(cell(row, column) for column in everyone)) for row in everyone],
        caption="How often a run of the row's planner is cheaper than one of the column's (A12), and Holm-adjusted p.",
    )


def _convergence(rows: Rows, runs: Sheet, mark: str) -> Iterator[Block]:
    panels, curves = [], set()
    for scenario in runs.scenarios:
        most = max(runs.cells[scenario, planner]["generated_paths"].max(initial=0) for planner in runs.planners)
        at = grid(float(most))
        bands: list[Band] = []
        for planner in runs.planners:
            histories = rows.histories(scenario=scenario, planner=planner, budget=runs.budget)
            bands.append(band(histories, "generated_paths", at))
            if np.isfinite(bands[-1].low).any():
                curves.add(planner)
        panels.append(figures.Panel(scenario, runs.exact(scenario), bands=bands))
    reached = np.concatenate([runs.all(planner, "success") for planner in runs.planners])
    bare = [planner for planner in runs.planners if planner not in curves]
    if not curves:
        yield Text("No run kept a history with a finite cost, so there is nothing to draw.")
        return
    for name, some in _split(f"convergence{mark}", panels):
        caption = (
            f"Best cost so far of all runs, of which {np.count_nonzero(reached):,} of {len(reached):,} reached their "
            "targets: median (line) and quartiles (band). "
            "What costs more than any band after a quarter of the effort is cut off."
        )
        if bare:
            caption += f" Without a history: {_and([literal(planner) for planner in bare])}."
        draw = partial(figures.convergence, runs.planners, some, "generated paths")
        yield Figure(name, caption, draw)


def _together(runs: Sheet, mark: str) -> Iterator[Block]:
    exact = all(runs.exact(scenario) is not None for scenario in runs.scenarios)
    against = "exact optimum" if exact else "exact optimum or best cost known"
    found = contrasts([runs.costs(planner, runs.scenarios) for planner in runs.planners])
    if found:
        yield _pairs(runs, found, against)
    yield from _ranks(runs, mark)
    curves = [profile(runs.ratios(planner)) for planner in runs.planners]
    yield Figure(
        f"profile{mark}",
        f"Performance profile: the share of all runs whose cost is within a ratio of the {against}. A run that did not "
        "reach its target never is. The axis ends where few runs are left.",
        partial(figures.profiles, runs.planners, curves, against),
    )


def _pairs(runs: Sheet, found: dict[tuple[int, int], Contrast], against: str) -> Table:
    rows: list[list[Cell]] = []
    for (i, j), c in found.items():
        first, second, chance, correlation = i, j, c.chance, c.correlation
        if chance < 0.5:  # name the better one first
            first, second, chance = j, i, 1 - chance
            correlation = None if correlation is None else -correlation
        test = f"Wilcoxon, {c.runs} pairs" if c.paired else f"Mann-Whitney, {c.runs} runs"
        told = f"cannot be told with {_many(c.runs, 'run')}" if c.p is None else _p(c.p).removeprefix("p ")
        r = None if correlation is None else f"{correlation:.2f}".replace("-", "\u2212")
        pair = [runs.planners[first], runs.planners[second]]
        rows.append([*pair, f"{chance:.2f}", magnitude(chance), r, told.removeprefix("= "), test])
    caption = "The planner that is cheaper more often stands first."
    if len(runs.scenarios) > 1:
        caption = f"Costs over the {against}, run by run. {caption}"
    return Table(
        ("planner", "against", "A12", "effect", "rank-biserial", "p (Holm)", "test"),
        rows,
        caption=caption,
    )


def _ranks(runs: Sheet, mark: str) -> Iterator[Block]:
    if len(runs.planners) < 3:
        few = "One planner is" if len(runs.planners) == 1 else "Two planners are"
        yield Text(f"{few} not ranked; that takes three.")
        return
    costs, what = _blocks(runs)
    if len(costs) < 2:
        yield Text(f"Ranks cannot be told with {_many(len(costs), what)} that all planners have run.")
        return
    told = ranking(costs)
    k = len(runs.planners)
    lines = [
        f"Friedman's test of mean ranks over {told.blocks} {what}s: chi-squared = {told.chi2:.2f}, {_p(told.p)}; "
        f"by Iman and Davenport's F, which is less conservative, {_p(told.p_f)}."
    ]
    if _least_p(told.blocks, k) > LEVEL:
        lines.append(f"Whether the planners differ cannot be told with {told.blocks} {what}s, whatever the ranks.")
    elif told.p >= LEVEL:
        lines.append("No difference between the planners can be told from the ranks.")
    elif told.critical_difference >= k - 1:
        lines.append(f"The planners differ, but {told.blocks} {what}s are too few to tell which.")
    else:
        lines.append("The planners differ; those that a bar joins are not told apart.")
    yield Text(" ".join(lines))
    draw = partial(figures.critical_difference, runs.planners, told)
    yield Figure(
        f"ranks{mark}", "Mean ranks, 1 is best; bars join planners that Nemenyi's test cannot tell apart.", draw
    )


def _blocks(runs: Sheet) -> tuple[np.ndarray, str]:
    """Return the costs to rank, a row each scenario (mean cost) or, if there is one only, each seed that all have."""
    cells = [[runs.cells[scenario, planner] for planner in runs.planners] for scenario in runs.scenarios]
    if len(cells) > 1:
        full = [row for row in cells if all(len(cell["cost"]) for cell in row)]
        return np.array([[cell["cost"].mean() for cell in row] for row in full]), "scenario"
    by_seed = [dict(zip(cell["seed"].tolist(), cell["cost"].tolist(), strict=True)) for cell in cells[0]]
    common = sorted(set.intersection(*(set(costs) for costs in by_seed)))
    return np.array([[costs[seed] for costs in by_seed] for seed in common]), "seed"


def _least_p(blocks: int, planners: int) -> float:
    """Return the p of Friedman's test where all blocks rank the planners alike."""
    from scipy.stats import chi2

    return float(chi2.sf(blocks * (planners - 1), planners - 1))


def _split(name: str, panels: list[figures.Panel]) -> Iterator[tuple[str, list[figures.Panel]]]:
    if len(panels) <= _PANELS:
        yield name, panels
        return
    for part, start in enumerate(range(0, len(panels), _PANELS)):
        yield f"{name}-{chr(ord('a') + part)}" if part < 26 else f"{name}-{part}", panels[start : start + _PANELS]


def _p(p: float | None) -> str:
    if p is None:
        return "p unknown"
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}" if p < 0.1 else f"p = {p:.2f}"


def _seeds(seeds: np.ndarray) -> str:
    found = sorted(set(seeds.tolist()))
    if len(found) > 2 and found[-1] - found[0] == len(found) - 1:
        return f"{found[0]} to {found[-1]}"
    return _and([str(seed) for seed in found]) if len(found) <= 12 else f"{len(found)} of them"


def _named(planners: Sequence[str], indices: Sequence[int]) -> str:
    return ", ".join(literal(planners[index]) for index in indices)


def _and(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _many(count: int, noun: str) -> str:
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


_READ = """\
- *Reached* comes first: a planner that fails is not better for the cheap runs that it has left. Its failures stay in
  every mean, at what their paths cost with the penalty for ending short of the target.
- *± SE* is the standard error of the mean. *95 % of rate* is Wilson's interval of the success rate, *95 % of mean* a
  bootstrap interval (BCa, from 5 runs on). *Gap* is the mean of cost / exact optimum - 1 over the runs that reached.
- *p* is Wilcoxon's signed-rank test on runs paired by scenario and seed, or the Mann-Whitney test where less than half
  of the runs can be paired; adjusted by Holm for all pairs of its table. Differences count from p < 0.05 on.
- *A12* is the chance that a run of the first planner is cheaper than one of the second; 0.5 is no difference, 0.56
  small, 0.64 medium, 0.71 large. *Rank-biserial* goes from -1 to 1, where every pair speaks for the first.
- Tests over runs speak about these scenarios. Only the ranks over scenarios speak, with care, about others like them.
"""
