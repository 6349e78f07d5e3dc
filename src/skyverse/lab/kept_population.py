"""The judgement on whether a population that is kept from replan to replan helps, as the thesis hopes."""

from collections.abc import Iterator

import numpy as np

from skyverse.lab.flight_costs import flight_costs
from skyverse.lab.formatting import literal, p_value
from skyverse.lab.moving_row import MovingRows
from skyverse.lab.pairwise_tests import PairwiseTest, compare_pairs
from skyverse.lab.report import Block, Cell, Table, Text
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, bootstrap, holm, magnitude
from skyverse.model.short_lines import counted

KEPT, RESTARTED = "KeptPopulation", "FromScratch"
"""The classes of the policies that are compared where all of their settings are the same."""


def kept_pairs(rows: MovingRows) -> list[tuple[str, str]]:
    """Return the labels of policies that keep a population, each with that of the same search restarted."""
    told = rows.select(("policy", "settings"))
    settings = dict(zip(told["policy"].tolist(), told["settings"].tolist(), strict=True))
    restarted = {text.removeprefix(RESTARTED): label for label, text in settings.items() if text.startswith(RESTARTED)}
    return [
        (label, restarted[text.removeprefix(KEPT)])
        for label, text in settings.items()
        if text.startswith(KEPT) and text.removeprefix(KEPT) in restarted
    ]


def kept_population_section(rows: MovingRows) -> Iterator[Block]:
    """Yield the judgement: a sentence for each search that was flown both ways, and the tests behind it."""
    pairs = kept_pairs(rows)
    if not pairs:
        yield Text("No search was flown both with its population kept and restarted, so this study does not tell.")
        return
    costs = [[flight_costs(rows, label) for label in pair] for pair in pairs]
    tests = [compare_pairs(both, paired=True).get((0, 1)) for both in costs]
    adjusted = iter(holm([test.p for test in tests if test is not None and test.p is not None]).tolist())
    records: list[dict[str, Cell]] = []
    for (kept, restarted), both, test in zip(pairs, costs, tests, strict=True):
        if test is None:
            continue
        p = None if test.p is None else next(adjusted)
        differences = _differences(*both)
        yield Text(_sentence(kept, restarted, test, p, differences))
        interval = bootstrap(differences)
        records.append(
            {
                "kept": kept,
                "restarted": restarted,
                "flights": _flights(test),
                "mean difference of time over bound": float(differences.mean()) if len(differences) else None,
                "95 %": None if interval is None else f"{interval.low:+.3f} to {interval.high:+.3f}",
                "A12": f"{test.chance:.2f}",
                "effect": magnitude(test.chance),
                "rank-biserial": None if test.correlation is None else f"{test.correlation:+.2f}",
                "p (Holm)": None if p is None else p_value(p).removeprefix("p ").removeprefix("= "),
            }
        )
    if records:
        caption = (
            "Flights are paired by scenario, movers and seed. A difference below 0, an A12 above 0.5 and a correlation "
            "above 0 favour the population that is kept; the mean difference is of pairs that both arrived safely."
        )
        yield Table.from_records(records, caption)


def _differences(kept: dict[str, dict[int, float]], restarted: dict[str, dict[int, float]]) -> np.ndarray:
    """Return kept less restarted of all pairs of which both are finite."""
    pairs = [
        (own[seed], restarted[cell][seed]) for cell, own in kept.items() for seed in own if seed in restarted[cell]
    ]
    table = np.array(pairs).reshape(-1, 2)
    table = table[np.isfinite(table).all(axis=1)]
    return np.asarray(table[:, 0] - table[:, 1])


def _flights(test: PairwiseTest) -> str:
    return f"{counted(test.runs, 'pair')} of flights" if test.paired else f"{counted(test.runs, 'unpaired flight')}"


def _sentence(kept: str, restarted: str, test: PairwiseTest, p: float | None, differences: np.ndarray) -> str:
    """Return the verdict on one search in words."""
    if p is None:
        return f"**Cannot be told** for {literal(kept)}: {_flights(test)} are too few to test."
    if test.scenarios_disagree:
        return f"**Scenarios disagree**: {literal(kept)} is faster in some and slower in others, over {_flights(test)}."
    mean = f"{abs(float(differences.mean())):.3f}" if len(differences) else "an unknown share"
    over = f"over {_flights(test)} ({p_value(p)})"
    if p >= SIGNIFICANCE_LEVEL:
        return (
            f"**No difference was found**: {literal(kept)} is neither faster nor slower than {literal(restarted)}, "
            f"{over}."
        )
    helps = test.correlation is not None and test.correlation > 0
    word = "helps" if helps else "harms"
    return (
        f"**It {word}**: {literal(kept)} takes {'less' if helps else 'more'} time than {literal(restarted)}, by {mean} "
        f"of the bound in the mean of the pairs that both arrived safely, {over}; "
        f"the effect is {magnitude(test.chance)}."
    )
