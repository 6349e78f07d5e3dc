"""How the thesis's claims on the spread of the best cost are judged."""

import math
from collections.abc import Sequence
from itertools import product

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL
from skyverse.reproduction.cell_runs import CellRuns
from skyverse.reproduction.claim_verdict import ClaimVerdict, Evidence, Finding, verdict
from skyverse.reproduction.cost_claims import costs
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.published import CASES, COSTS, METHODS, THESIS_MAPS

MIN_BOOTSTRAP_RUNS = 10
"""The least number of runs from which spreads are bootstrapped."""
RESAMPLES = 2000


def spread_falls(cells: CellRuns, form: str) -> Finding:
    """Judge whether each method's standard deviation falls from the first case to the second, over the three maps."""
    rises = [
        f"{MAP_TITLES[name]} {method} {first:g} to {second:g}"
        for name, method in product(THESIS_MAPS, METHODS)
        if (first := COSTS[name, method, *CASES[0]].deviation) < (second := COSTS[name, method, *CASES[1]].deviation)
    ]
    asked = [((method, 1),) for method in METHODS]
    return _changes(
        cells, form, asked, f"In the thesis's own tables it rises in {len(rises)} of 9: {', '.join(rises)}."
    )


def gso_settles_faster(rivals: Sequence[str], cells: CellRuns, form: str) -> Finding:
    """Judge whether the spread falls by a larger factor for GSO than for each of its rivals, over the three maps."""
    first, second = ({(n, m): COSTS[n, m, *size].deviation for n in THESIS_MAPS for m in METHODS} for size in CASES)
    own = [f"{m} {math.prod(second[n, m] / first[n, m] for n in THESIS_MAPS) ** (1 / 3):.2f}" for m in METHODS]
    told = f"In the thesis's own tables the factors are {', '.join(own)}."
    return _changes(cells, form, [(("GSO", 1), (rival, -1)) for rival in rivals], told)


def mvo_spreads_least(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO's spread is smaller than the others' in the first case on Maps 2 and 3."""
    pairs = [("MVO", "GSO"), ("MVO", "BBO")]
    return _spreads(cells, form, pairs, ("map2", "map3"), CASES[:1], " In Table 4.3 itself GSO has 22.2, MVO 27.8.")


def bbo_spreads_most(cells: CellRuns, form: str) -> Finding:
    """Judge whether BBO's spread is larger than the others' in both cases on all maps."""
    return _spreads(cells, form, [("GSO", "BBO"), ("MVO", "BBO")], THESIS_MAPS, CASES)


def _changes(cells: CellRuns, form: str, asked: Sequence[Sequence[tuple[str, int]]], told: str = "") -> Finding:
    """Judge by a bootstrap whether products of factors of change, each to a power of 1 or -1, are below 1.

    The factor of a method is that of its standard deviation from the first case to the second, as a geometric mean over
    the maps.
    """
    if cells.runs < MIN_BOOTSTRAP_RUNS:
        few = f"Not with {cells.runs} runs, of at least {MIN_BOOTSTRAP_RUNS} that a bootstrap of spreads takes."
        return Finding(ClaimVerdict.OPEN, few)
    rng, change = np.random.default_rng(0), dict[str, Floats]()
    for method in METHODS:  # each row 0 is of the runs themselves
        change[method] = np.zeros(RESAMPLES + 1)
        for name, (sign, which) in product(THESIS_MAPS, zip((-1, 1), CASES, strict=True)):
            found = costs(cells, form, name, method, which)
            drawn = np.vstack([found, rng.choice(found, (RESAMPLES, len(found)))])
            change[method] += sign * _log_deviation(drawn) / len(THESIS_MAPS)
    evidence, said = [], []
    for factors in asked:
        logs = np.sum([power * change[method] for method, power in factors], axis=0)
        low, high = np.exp(np.quantile(logs[1:], (SIGNIFICANCE_LEVEL / 2, 1 - SIGNIFICANCE_LEVEL / 2)))
        shown, refuted = 2 * (logs[1:] >= 0).mean(), 2 * (logs[1:] <= 0).mean()
        evidence.append(Evidence(float(shown), min(1.0, float(refuted))))
        names = " over ".join(method for method, _ in factors)
        said.append(f"{names} {np.exp(logs[0]):.2f} ({low:.2f} to {high:.2f})")
    text = (
        "Factors of change of the standard deviation from the first case to the second, geometric mean of three maps, "
        f"with 95 % bootstrap intervals: {'; '.join(said)}. {told}"
    )
    return Finding(verdict(evidence), text.strip())


def _spreads(
    cells: CellRuns,
    form: str,
    pairs: Sequence[tuple[str, str]],
    maps: Sequence[str],
    sizes: Sequence[tuple[int, int]],
    told: str = "",
) -> Finding:
    """Compare standard deviations by Levene's test about the median (Brown and Forsythe)."""
    from scipy.stats import levene

    evidence, said = [], []
    for name, size, (less, more) in product(maps, sizes, pairs):
        a, b = (costs(cells, form, name, method, size) for method in (less, more))
        p = float(levene(a, b, center="median").pvalue) if np.ptp(a) + np.ptp(b) else 1.0
        first, second = (float(values.std(ddof=1)) for values in (a, b))
        evidence.append(Evidence(p, 1.0) if first < second else Evidence(1.0, p))
        where = "{}, {} x {}".format(MAP_TITLES[name], *size)
        said.append(f"{where}: {less} {first:.1f}, {more} {second:.1f} (p = {p:.2g})")
    seen = math.exp(2.8 / math.sqrt(max(cells.runs - 1, 1)))
    return Finding(
        verdict(evidence),
        f"Standard deviations (Brown-Forsythe tests; of normal costs, a ratio of {seen:.2f} would have been seen with "
        f"{cells.runs} runs at a power of 80 %): {'; '.join(said)}.{told}",
    )


def _log_deviation(costs: Floats) -> Floats:
    return np.log(np.maximum(costs.std(axis=-1, ddof=1), 1e-9))
