"""The section of a report that says which planners differ: tests of pairs, mean ranks, performance profiles."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from skyverse.lab import figures
from skyverse.lab.budget_runs import BudgetRuns
from skyverse.lab.curves import profile
from skyverse.lab.report import Block, Cell, Figure, Printed, Table, Text, bare_p, literal, named, p_value
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, PairwiseTest, compare_pairs, magnitude, ranking
from skyverse.model.short_lines import counted


def best_mean(planners: Sequence[str], means: list[float], found: dict[tuple[int, int], PairwiseTest]) -> Iterator[str]:
    """Yield sentences on which planner has the lowest mean, and from which others it differs significantly."""
    if not found:
        return
    best = int(np.nanargmin(means))
    if means[best] == np.inf:
        yield "No planner has a finite mean."
        return
    others = {i if j == best else j: contrast for (i, j), contrast in found.items() if best in (i, j)}
    yield f"Lowest mean: {literal(planners[best])}."
    tested = {k: contrast.p for k, contrast in others.items() if contrast.p is not None}
    worse = [k for k, p in tested.items() if p < SIGNIFICANCE_LEVEL]
    alike = [k for k in tested if k not in worse]
    few = [k for k in others if k not in tested]
    if worse:
        yield f"Significantly different from it: {named(planners, worse)}."
    if alike:
        yield f"Not significantly different from it: {named(planners, alike)}."
    if few:
        runs = counted(max(others[k].runs for k in few), "run")
        yield f"Too few runs to test whether they differ from it ({runs} of both): {named(planners, few)}."


def winner(runs: BudgetRuns) -> str:
    """Say which planner is better than each other over all scenarios, or that none is; nothing of fewer than two."""
    found = compare_pairs([runs.costs(planner, runs.scenarios) for planner in runs.contestants], paired=runs.flown)
    if not found:
        return ""
    wins = [0] * len(runs.contestants)
    for (i, j), one in found.items():
        if one.p is not None and one.p < SIGNIFICANCE_LEVEL and not one.scenarios_disagree:
            wins[i if one.chance > 0.5 else j] += 1
    best = int(np.argmax(wins))
    if wins[best] < len(wins) - 1:
        return "**No planner is significantly better than each of the others.**"
    reached = runs.all(runs.contestants[best], "success")
    return (
        f"**Best: {literal(runs.contestants[best])}**, over all scenarios significantly better than every other. "
        f"It reached its targets in {np.count_nonzero(reached):,} of {counted(len(reached), 'run')}."
    )


def matrix(planners: Sequence[str], found: dict[tuple[int, int], PairwiseTest]) -> Table:
    """Return a table of how often each planner is cheaper than each other."""

    def cell(row: int, column: int) -> Cell:
        if row == column:
            return ""
        contrast = found.get((min(row, column), max(row, column)))
        if contrast is None:
            return "no runs"
        told = "scenarios disagree" if contrast.scenarios_disagree else p_value(contrast.p)
        chance, versus = contrast.chance if row < column else 1 - contrast.chance, planners[column]
        return Printed(f"{chance:.2f} ({told})", {f"A12: {versus}": chance, f"p: {versus}": contrast.p})

    everyone = range(len(planners))
    return Table(
        ("cheaper than", *planners),
        [(planners[row], *(cell(row, column) for column in everyone)) for row in everyone],
        caption="How often a run of the row's planner is cheaper than one of the column's (A12), and Holm-adjusted p.",
    )


def difference_section(runs: BudgetRuns, mark: str) -> Iterator[Block]:
    """Yield the comparison of the planners over all scenarios: pair by pair, by mean ranks, by performance profiles."""
    known = all(runs.bound(scenario) is not None for scenario in runs.scenarios)
    against = "lower bound" if known else "lower bound or best cost known"
    found = compare_pairs([runs.costs(planner, runs.scenarios) for planner in runs.contestants], paired=runs.flown)
    if found:
        yield _pairs(runs, found)
    yield from _ranks(runs, mark)
    curves = [profile(runs.ratios(planner)) for planner in runs.contestants]
    yield Figure(
        f"profile{mark}",
        f"Performance profile: the share of all runs whose cost is within a ratio of the {against}. A run that did not "
        "reach its target never is. The axis ends where few runs are left.",
        partial(figures.profiles, runs.contestants, curves, against),
    )


def _pairs(runs: BudgetRuns, found: dict[tuple[int, int], PairwiseTest]) -> Table:
    failed = [int(np.count_nonzero(~runs.all(planner, "success"))) for planner in runs.contestants]
    rows: list[dict[str, Cell]] = []
    for (i, j), c in found.items():
        (i, j), chance = ((i, j), c.chance) if c.chance >= 0.5 else ((j, i), 1 - c.chance)  # the better one first
        told = f"too few: {counted(c.runs, 'run')}" if c.p is None else bare_p(c.p)
        row: dict[str, Cell] = {"planner": runs.contestants[i], "against": runs.contestants[j]}
        row |= {"A12": Printed(f"{chance:.2f}", {"A12": chance}), "effect": magnitude(chance)}
        lost = {"failed": failed[i], "failed against": failed[j]}
        row["failed"] = Printed(f"{failed[i]}, {failed[j]}", lost)
        row["p (Holm)"] = Printed("scenarios disagree" if c.scenarios_disagree else told, {"p (Holm)": c.p})
        if (agree := c.heterogeneity) is not None:
            row["p that scenarios agree"] = Printed(bare_p(agree), {"p that scenarios agree": agree})
        rows.append(row)
    caption = "The planner that is cheaper more often stands first. *Failed* are the runs of each that did not reach."
    if len(runs.scenarios) > 1:
        caption += (
            " The tests of the scenarios are combined. Where scenarios disagree, no difference holds for all of them; "
            "each is told above."
        )
    return Table.from_records(rows, caption)


def _ranks(runs: BudgetRuns, mark: str) -> Iterator[Block]:
    if len(runs.contestants) < 3:
        yield Text(
            f"There are no ranks, which take three planners that are not exact; here {len(runs.contestants)} are."
        )
        return
    cells = [[runs.cells[scenario, planner]["cost"] for planner in runs.contestants] for scenario in runs.scenarios]
    costs = np.array([[cost.mean() for cost in row] for row in cells if all(map(len, row))])
    if len(costs) < 2:
        yield Text(f"There are no ranks: all planners have run only {counted(len(costs), 'scenario')}.")
        return
    told = ranking(costs)
    k = len(runs.contestants)
    lines = [
        f"Friedman's test of mean ranks over {told.blocks} scenarios: chi-squared = {told.chi2:.2f}, "
        f"{p_value(told.p)}; by Iman and Davenport's F, which is less conservative, {p_value(told.p_f)}."
    ]
    if _least_p(told.blocks, k) > SIGNIFICANCE_LEVEL:
        lines.append(f"{told.blocks} scenarios are too few to test whether the planners differ, whatever the ranks.")
    elif told.p >= SIGNIFICANCE_LEVEL:
        lines.append("The ranks show no significant difference between the planners.")
    elif told.critical_difference >= k - 1:
        lines.append(f"The planners differ, but {told.blocks} scenarios are too few to say which.")
    else:
        lines.append("The planners differ; those that a bar joins do not differ significantly.")
    yield Text(" ".join(lines))
    caption = "Mean ranks, 1 is best; bars join planners that do not differ in Nemenyi's test."
    yield Figure(f"ranks{mark}", caption, partial(figures.critical_difference, runs.contestants, told))


def _least_p(blocks: int, planners: int) -> float:
    """Return the p-value of Friedman's test if all blocks ranked the planners alike, the least that it can give."""
    from scipy.stats import chi2

    return float(chi2.sf(blocks * (planners - 1), planners - 1))
