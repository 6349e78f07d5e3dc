"""What the report of a study says of flights among movers, beside what it says of all runs."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from skyverse.lab import figures
from skyverse.lab.budget_runs import BudgetRuns
from skyverse.lab.report import Block, Cell, Figure, Printed, SectionHeading, Table, bare_p
from skyverse.lab.rows import Rows
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, PairwiseTest, bootstrap, compare_pairs, holm, magnitude

_FLOWN = (
    *("status", "verdict", "contacts", "least_gap", "flown_length", "least_length", "replans", "unproven"),
    *("milliseconds", "milliseconds_99", "milliseconds_worst", "generated_paths"),
)
KEPT, RESTARTED = "KeptPopulation", "FromScratch"
"""The classes of the policies that are compared where all of their settings are the same."""


def flight_table(rows: Rows, runs: BudgetRuns, scenario: str) -> Table:
    """Return how safe, how long and how often replanned the flights of each policy were."""
    records: list[dict[str, Cell]] = []
    for policy in runs.planners:
        found = rows.select(_FLOWN, scenario=scenario, planner=policy, budget=runs.budget)
        flights = len(found["status"])
        if not flights:
            records.append({"policy": policy, "arrived": "no flights"})
            continue
        arrived = found["status"] == "arrived"
        length = np.median(np.where(arrived, found["flown_length"] / found["least_length"], np.inf))
        answers = int(found["replans"].sum())
        records.append(
            {
                "policy": policy,
                "arrived": f"{int(arrived.sum())} of {flights}",
                "safe": f"{int((found['verdict'] == '').sum())} of {flights}",
                "contacts": int(found["contacts"].sum()),
                "least gap, m": f"{found['least_gap'].min():.2f}".replace("-", "\u2212"),
                "length": f"{length:.2f}".replace("inf", "∞"),
                "replans": float(np.round(found["replans"].mean())),
                "without way out": f"{100.0 * found['unproven'].sum() / answers:.1f} %" if answers else None,
                "ms": float(np.median(found["milliseconds"])),
                "99 %": float(np.median(found["milliseconds_99"])),
                "worst": float(np.round(found["milliseconds_worst"].max())),
                "paths": float(np.round(found["generated_paths"].sum() / answers)) if answers else None,
            }
        )
    caption = "Length over its lower bound in hindsight, median; paths generated for an answer, mean."
    return Table.from_records(records, caption)


def answer_times(rows: Rows, runs: BudgetRuns, mark: str) -> Figure:
    """Return the figure of how long answers took."""
    replanned = {p: rows.select(("replans", *_FLOWN[-4:]), planner=p, budget=runs.budget) for p in runs.planners}
    found = {policy: columns for policy, columns in replanned.items() if columns["replans"].any()}
    shown = {
        "ms: median": [float(np.median(columns["milliseconds"])) for columns in found.values()],
        "99 %": [float(np.median(columns["milliseconds_99"])) for columns in found.values()],
        "worst": [float(columns["milliseconds_worst"].max()) for columns in found.values()],
    }
    draw = partial(figures.bars, list(found), shown)
    return Figure(f"milliseconds{mark}", "Milliseconds of one answer for one UAV.", draw)


def kept_population_section(rows: Rows, runs: BudgetRuns) -> Iterator[Block]:
    """Yield whether a population that is kept from replan to replan helps, for each search that was flown both ways."""
    pairs = _kept_pairs(rows)
    costs = [[runs.costs(policy, runs.scenarios) for policy in pair] for pair in pairs]
    tests = [compare_pairs(both, paired=True).get((0, 1)) for both in costs]
    adjusted = iter(holm([test.p for test in tests if test is not None and test.p is not None]).tolist())
    records: list[dict[str, Cell]] = []
    for (kept, restarted), test in zip(pairs, tests, strict=True):
        if test is not None:
            p = None if test.p is None else float(next(adjusted))
            records.append({"kept": kept, "restarted": restarted, **_judgement(runs, kept, restarted, test, p)})
    if records:
        yield SectionHeading("Does a population that is kept help?")
        caption = (
            "Flights are paired by scenario, movers and seed. A difference below 0, an A12 above 0.5 and a correlation "
            "above 0 favour the population that is kept; the mean difference is of pairs that both arrived safely."
        )
        yield Table.from_records(records, caption)


def _kept_pairs(rows: Rows) -> list[tuple[str, str]]:
    """Return the labels of policies that keep a population, each with that of the same search restarted."""
    told = rows.select(("planner", "settings"))
    settings = dict(zip(told["planner"].tolist(), told["settings"].tolist(), strict=True))
    restarted = {text.removeprefix(RESTARTED): label for label, text in settings.items() if text.startswith(RESTARTED)}
    return [
        (label, restarted[text.removeprefix(KEPT)])
        for label, text in settings.items()
        if text.startswith(KEPT) and text.removeprefix(KEPT) in restarted
    ]


def _judgement(runs: BudgetRuns, kept: str, restarted: str, test: PairwiseTest, p: float | None) -> dict[str, Cell]:
    differences = _differences(runs, kept, restarted)
    interval = bootstrap(differences)
    mean = float(differences.mean()) if len(differences) else None
    return {
        "verdict": _verdict(test, p),
        "pairs of flights": test.runs,
        "mean difference of time over bound": mean,
        "95 %": interval
        and Printed(f"{interval.low:+.3f} to {interval.high:+.3f}", {"from": interval.low, "to": interval.high}),
        "A12": Printed(f"{test.chance:.2f}", {"A12": test.chance}),
        "effect": magnitude(test.chance),
        "rank-biserial": None if test.correlation is None else f"{test.correlation:+.2f}",
        "p (Holm)": None if p is None else bare_p(p),
    }


def _verdict(test: PairwiseTest, p: float | None) -> str:
    if p is None:
        return "too few"
    if test.scenarios_disagree:
        return "scenarios disagree"
    if p >= SIGNIFICANCE_LEVEL:
        return "no difference"
    return "helps" if test.correlation is not None and test.correlation > 0 else "harms"


def _differences(runs: BudgetRuns, kept: str, restarted: str) -> np.ndarray:
    """Return time over bound kept less restarted of all pairs of which both arrived safely."""
    found = []
    for scenario in runs.scenarios:
        own, other = (runs.cells[scenario, planner] for planner in (kept, restarted))
        _, first, second = np.intersect1d(own["seed"], other["seed"], return_indices=True)
        found.append(own["gap"][first] - other["gap"][second])
    differences = np.concatenate(found)
    return differences[np.isfinite(differences)]


READ = """\
- A flight *reached* its target if all UAVs came to rest at theirs and the referee proves all of it, among the movers as
  they truly moved. Its cost is the time at which the last UAV arrived, in seconds; else it is infinite. The lower bound
  is the least time in hindsight in which the UAV's limits let it fly so far from rest to rest, so that no policy need
  be able to reach it.
- *Contacts* are pairs of a UAV and a mover that came nearer to one another than the clearance. *Length* is divided by
  the proven least length of a path among what stands still; medians count a flight that did not arrive as endless.
  *Without way out* are the answers after which the UAV's motion was not proven.
- Milliseconds are those of one answer for one UAV, with all that it takes: the median over all flights of their medians
  and of their 99th percentiles, and the worst answer of all.
- Policies differ only in how they find ways. The motions along them are made, limited and proven alike for all, but for
  the replanner itself (`default`), which tries its own, and for policies that say that they prove nothing.
- A seed makes the same movers for all policies, so that flights are paired by it: *p* is Wilcoxon's test, adjusted by
  Holm for all pairs of its table. *A12* is the chance that a flight of the first policy takes less time than one of the
  second in the same scenario; 0.5 is no difference, 0.56 small, 0.64 medium, 0.71 large.
"""
"""How the report of a study of flights is to be read."""
