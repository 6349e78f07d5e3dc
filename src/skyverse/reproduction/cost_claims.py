"""How the thesis's claims on costs and on their spread are judged: what is compared, and what is asked of it."""

import math
from collections.abc import Iterable, Sequence
from itertools import product

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, wilson
from skyverse.reproduction import fleets
from skyverse.reproduction.cell_runs import EQUAL_EFFORTS, LAST_ITERATION, CellRuns, Length, case, optimum
from skyverse.reproduction.claim_verdict import LOWER, ClaimVerdict, Comparison, Evidence, Finding, judged, verdict
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.published import CASES, CONVERGENCE_POPULATION, COSTS, FLEET_RUNS, METHODS, THESIS_MAPS

ALIKE_WITHIN = 0.02
"""Means that differ by at most this share count as alike."""
OPTIMAL_SHARE = 0.95
"""The share of runs that have to be optimal."""

Pairs = Sequence[tuple[str, str]]
Size = tuple[int, Length]
"""The population, and how long runs are."""
LAST = (CONVERGENCE_POPULATION, LAST_ITERATION)
EQUAL: list[Size] = [(CONVERGENCE_POPULATION, effort) for effort in EQUAL_EFFORTS]


def order(
    pairs: Pairs, maps: Sequence[str], cells: CellRuns, form: str, sizes: Iterable[tuple[int, int]] = CASES
) -> Finding:
    """Judge whether the first method of each pair has the lower mean cost in both cases, and at equal effort.

    Instead of the two cases, `sizes` may give other populations and numbers of iterations.
    """
    published = [compared(cells, form, pair, name, size) for name, size, pair in product(maps, sizes, pairs)]
    equal = [compared(cells, form, pair, name, size) for size, name, pair in product(EQUAL, maps, pairs)]
    return judged(published, equal, same_refutes=True)


def order_after(pairs: Pairs, iterations: Sequence[int], maps: Sequence[str], cells: CellRuns, form: str) -> Finding:
    """Judge the same as `order` after each of these numbers of iterations, with a population of 25."""
    return order(pairs, maps, cells, form, [(CONVERGENCE_POPULATION, t) for t in iterations])


def munkres_lowers(methods: Sequence[str], cells: CellRuns, form: str) -> Finding:
    """Judge whether coordination lowers the total cost; the number of iterations is the same with and without."""
    few = cells.first(FLEET_RUNS)
    straight, without = fleets.coordinated("euclidean"), fleets.coordinated("identity")
    found = [
        Comparison(
            f"five UAVs, {method}",
            ("with Munkres", "without"),
            few.values("cost", straight, method, form, *CASES[1]),
            few.values("cost", without, method, form, *CASES[1]),
        )
        for method in methods
    ]
    return judged(found, text=f"Exact paths: {optimum(straight):g} with it, {optimum(without):g} without.")


def mvo_catches_up(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO is worse than GSO after 1 and 2 iterations, but at most `ALIKE_WITHIN` worse after 50."""
    sizes, pair, within = [(CONVERGENCE_POPULATION, t) for t in (1, 2)], ("MVO", "GSO"), (-math.inf, ALIKE_WITHIN)
    maps, excepted = ("map1", "map3"), "map2"
    early = [compared(cells, form, ("GSO", "MVO"), name, size) for name, size in product(maps, sizes)]
    late = [compared(cells, form, pair, name, LAST, within) for name in maps]
    equal = [compared(cells, form, pair, name, size, within) for size, name in product(EQUAL, maps)]
    left_out = compared(cells, form, pair, excepted, LAST, within).difference
    low, high = left_out.interval
    return judged(
        [*early, *late],
        equal,
        f"Asked after 50 iterations and at equal effort: at most {ALIKE_WITHIN:.0%} above GSO. Map 2 is left out, as "
        f'the thesis does ("in some cases of map 2 GSO perform better"); there MVO lies {left_out.value:+.1%} from '
        f"GSO after 50 iterations ({low:+.1%} to {high:+.1%}).",
    )


def alike_in_the_end(cells: CellRuns, form: str) -> Finding:
    """Judge whether the means of MVO and GSO after 50 iterations differ by at most `ALIKE_WITHIN`."""
    published, equal = (
        [
            compared(cells, form, ("MVO", "GSO"), name, size, (-ALIKE_WITHIN, ALIKE_WITHIN))
            for size, name in product(sizes, THESIS_MAPS)
        ]
        for sizes in ([LAST], EQUAL)
    )
    return judged(published, equal, f"Alike is taken to mean within {ALIKE_WITHIN:.0%}.")


def flattens(cells: CellRuns, form: str) -> Finding:
    """Judge whether most of the decrease happens by the tenth of 50 iterations, and little after the fortieth."""
    early, late = [], []
    for name, method in product(THESIS_MAPS, METHODS):
        first, tenth, fortieth, last = (
            costs(cells, form, name, method, (CONVERGENCE_POPULATION, t)).mean() for t in (1, 10, 40, 50)
        )
        early.append((first - tenth) / (first - last))
        late.append((fortieth - last) / (first - last))
    holds = min(early) > 0.5 and max(late) < 0.1
    return Finding(
        ClaimVerdict.AS_PUBLISHED if holds else ClaimVerdict.FAILS,
        f"Of the fall of the mean best cost from 1 to 50 iterations, {min(early):.0%} to {max(early):.0%} is made by "
        f"the tenth, and {min(late):.0%} to {max(late):.0%} after the fortieth (three methods on three maps; asked: "
        "above 50 % and below 10 %).",
    )


def optimal(cells: CellRuns, form: str) -> Finding:
    """Judge by Wilson's intervals whether MVO's best path is optimal in `OPTIMAL_SHARE` of the runs on each map."""
    told, ends = [], []
    for name in THESIS_MAPS:
        found, bound = costs(cells, form, name, "MVO", CASES[1]), optimum(case(name))
        successes = int((found <= bound * (1 + 1e-9)).sum())
        ends.append(wilson(successes, len(found)))
        share, gap = successes / len(found), found.mean() / bound - 1
        told.append(
            f"{MAP_TITLES[name]} {share:.0%} of the runs ({ends[-1].low:.0%} to {ends[-1].high:.0%}), "
            f"mean gap {gap:.1%}"
        )
    verdict = ClaimVerdict.OPEN
    if all(low >= OPTIMAL_SHARE for low, _ in ends):
        verdict = ClaimVerdict.AS_PUBLISHED
    elif any(high < OPTIMAL_SHARE for _, high in ends):
        verdict = ClaimVerdict.FAILS
    return Finding(verdict, f"Optimal, 25 x 40 (asked: {OPTIMAL_SHARE:.0%} on each map): {'; '.join(told)}.")


def costs(cells: CellRuns, form: str, name: str, method: str, size: Size) -> Floats:
    """Return the costs of a method on a map, (n,)."""
    return cells.values("cost", case(name), method, form, *size)


def compared(
    cells: CellRuns,
    form: str,
    pair: tuple[str, str],
    name: str,
    size: Size,
    asked: tuple[float, float] = LOWER,
    column: str = "cost",
) -> Comparison:
    """Return the comparison of two methods on a map by a column of their runs."""
    first, second = (cells.values(column, case(name), method, form, *size) for method in pair)
    said = "{} x {}".format(*size) if isinstance(size[1], int) else size[1]
    return Comparison(f"{MAP_TITLES[name]}, {said}", pair, first, second, asked)


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
