"""How the thesis's claims on spread and on time are judged."""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, holm
from skyverse.reproduction.cells import LONGEST, Cells, case
from skyverse.reproduction.costs import TITLES
from skyverse.reproduction.fleets import SCENARIOS
from skyverse.reproduction.published import (
    CASES,
    CONVERGENCE_POPULATION,
    FLEET_RUNS,
    FLEETS,
    MAPS,
    METHODS,
    POPULATIONS,
)
from skyverse.reproduction.verdicts import Finding, Verdict

FEWEST = 10
PATHS = "1000 paths"
"""The equal effort at which generated nodes are compared."""
ABOUT_HALF = (0.4, 0.65)
"""The ratios of the thesis's own times, MVO to GSO, lie between."""


def spread_falls(cells: Cells, form: str) -> Finding:
    """Judge by a sign test whether the standard deviation falls from the first case to the second."""
    from scipy.stats import binomtest

    told, falls = [], 0
    for name in MAPS:
        for method in METHODS:
            first, second = (_costs(cells, form, name, method, *which).std(ddof=1) for which in CASES)
            falls += bool(second < first)
            told.append(f"{TITLES[name]} {method} {first:.1f} to {second:.1f}")
    p = binomtest(falls, len(told)).pvalue
    verdict = Verdict.OPEN if p >= SIGNIFICANCE_LEVEL else Verdict.HOLDS if falls > len(told) / 2 else Verdict.FAILS
    return Finding(verdict, f"It falls in {falls} of {len(told)} (sign test, p = {p:.2g}): {'; '.join(told)}.")


def mvo_spreads_least(cells: Cells, form: str) -> Finding:
    """Judge whether MVO's spread is smaller than the others' in the first case on Maps 2 and 3."""
    found = _spreads(cells, form, [("MVO", "GSO"), ("MVO", "BBO")], ("map2", "map3"), CASES[:1])
    return Finding(found.verdict, f"{found.evidence} In Table 4.3 itself GSO has 22.2, MVO 27.8.")


def bbo_spreads_most(cells: Cells, form: str) -> Finding:
    """Judge whether BBO's spread is larger than the others' in both cases on all maps."""
    return _spreads(cells, form, [("GSO", "BBO"), ("MVO", "BBO")], MAPS, CASES)


def gso_settles_faster(cells: Cells, form: str) -> Finding:
    """Judge by a bootstrap whether the spread falls by a larger factor for GSO than for MVO, over the three maps."""
    if cells.runs < FEWEST:
        return Finding(
            Verdict.OPEN, f"Not with {cells.runs} runs, of at least {FEWEST} that a bootstrap of spreads takes."
        )
    rng = np.random.default_rng(0)
    told, resampled = 0.0, np.zeros(2000)
    for name in MAPS:
        for method, sign in (("GSO", 1), ("MVO", -1)):
            for which, side in zip(CASES, (-1, 1), strict=True):
                costs = _costs(cells, form, name, method, *which)
                drawn = rng.choice(costs, (len(resampled), len(costs)))
                told += sign * side * float(_log_deviation(costs)) / len(MAPS)
                resampled += sign * side * _log_deviation(drawn) / len(MAPS)
    low, high = np.quantile(resampled, (SIGNIFICANCE_LEVEL / 2, 1 - SIGNIFICANCE_LEVEL / 2))
    verdict = Verdict.HOLDS if high < 0 else Verdict.FAILS if low > 0 else Verdict.OPEN
    return Finding(
        verdict,
        f"From the first case to the second GSO's standard deviation changes by {np.exp(told):.2f} times the factor "
        f"of MVO's (95 % bootstrap interval {np.exp(low):.2f} to {np.exp(high):.2f}, geometric mean of three maps).",
    )


def half_the_time(cells: Cells, form: str) -> Finding:
    """Judge whether MVO's nodes are about half of GSO's, at equal iterations and at equal paths."""
    ratios = {
        f"{TITLES[name]}, {n} x {t}": _nodes(cells, form, name, "MVO", n, t) / _nodes(cells, form, name, "GSO", n, t)
        for name in MAPS
        for n, t in CASES
    }
    equal = [_equal_nodes(cells, form, name, "MVO") / _equal_nodes(cells, form, name, "GSO") for name in MAPS]
    low, high = ABOUT_HALF
    if not all(low <= ratio <= high for ratio in ratios.values()):
        verdict = Verdict.FAILS
    else:
        verdict = Verdict.HOLDS if all(low <= ratio <= high for ratio in equal) else Verdict.UNEQUAL
    told = "; ".join(f"{where} {ratio:.2f}" for where, ratio in ratios.items())
    return Finding(
        verdict,
        f"MVO's generated nodes over GSO's: {told} (asked: {low} to {high}, as the ratios of the published times). At "
        f"{PATHS} each: {_range(equal)}.",
    )


def bbo_is_fastest(cells: Cells, form: str) -> Finding:
    """Judge whether BBO generates the fewest nodes, at equal iterations and at equal paths."""
    published, equal = [], []
    for name in MAPS:
        for rival in ("GSO", "MVO"):
            published += [
                _nodes(cells, form, name, "BBO", n, t) / _nodes(cells, form, name, rival, n, t) for n, t in CASES
            ]
            equal.append(_equal_nodes(cells, form, name, "BBO") / _equal_nodes(cells, form, name, rival))
    verdict = Verdict.FAILS
    if max(published) < 1:
        verdict = Verdict.HOLDS if max(equal) < 1 else Verdict.UNEQUAL
    return Finding(
        verdict,
        f"BBO's generated nodes over GSO's and MVO's: {_range(published)} at equal iterations, {_range(equal)} at "
        f"{PATHS} each.",
    )


def best_and_fastest(cells: Cells, form: str) -> Finding:
    """Judge on how many maps MVO has both the lowest cost and the fewest nodes after fifty iterations."""
    cheapest = quickest = both = 0
    for name in MAPS:
        cost = {m: _costs(cells, form, name, m, CONVERGENCE_POPULATION, LONGEST).mean() for m in METHODS}
        nodes = {m: _nodes(cells, form, name, m, CONVERGENCE_POPULATION, LONGEST) for m in METHODS}
        first, second = min(cost, key=cost.__getitem__) == "MVO", min(nodes, key=nodes.__getitem__) == "MVO"
        cheapest, quickest, both = cheapest + first, quickest + second, both + (first and second)
    return Finding(
        Verdict.HOLDS if both >= 2 else Verdict.FAILS,
        f"MVO has the lowest mean cost on {cheapest} of 3 maps, the fewest generated nodes on {quickest}, both on "
        f"{both}. In the thesis's own Tables 4.2 to 4.7 BBO takes less time than MVO in 28 of 30 cells.",
    )


def less_time_than_gso(cells: Cells, form: str) -> Finding:
    """Judge whether MVO generates fewer nodes than GSO with every population."""
    ratios = [
        _nodes(cells, form, name, "MVO", n, t) / _nodes(cells, form, name, "GSO", n, t)
        for name in MAPS
        for n in POPULATIONS
        for _, t in CASES
    ]
    equal = [_equal_nodes(cells, form, name, "MVO") / _equal_nodes(cells, form, name, "GSO") for name in MAPS]
    verdict = Verdict.FAILS
    if max(ratios) < 0.8:
        verdict = Verdict.HOLDS if max(equal) < 0.8 else Verdict.UNEQUAL
    return Finding(
        verdict,
        f"MVO's generated nodes over GSO's, populations {POPULATIONS[0]} to {POPULATIONS[-1]}: {_range(ratios)} "
        f"(asked: below 0.8); at {PATHS} each: {_range(equal)}.",
    )


def lead_grows(cells: Cells, form: str) -> Finding:
    """Judge whether MVO's nodes over GSO's are fewer on Map 3, of most obstacles, than on Map 1, by a twentieth."""
    told, ratios = [], []
    for n, t in CASES:
        first, third = (
            _nodes(cells, form, name, "MVO", n, t) / _nodes(cells, form, name, "GSO", n, t) for name in ("map1", "map3")
        )
        ratios.append(third / first)
        told.append(f"{n} x {t}: {first:.2f} on Map 1 (8 obstacles), {third:.2f} on Map 3 (14)")
    verdict = Verdict.UNEQUAL if max(ratios) < 0.95 else Verdict.FAILS
    return Finding(
        verdict,
        f"MVO's generated nodes over GSO's, {'; '.join(told)}. The published times give 0.62 and 0.63, 0.60 and 0.63.",
    )


def linear_in_fleet(cells: Cells, form: str) -> Finding:
    """Judge whether a straight line explains at least 95 % of how the nodes vary with the number of UAVs."""
    fits, cells = [], cells.first(FLEET_RUNS)
    for n, t in CASES:
        for method in METHODS:
            y = [
                cells.values("generated_nodes", case(SCENARIOS[k], "euclidean"), method, form, n, t).mean()
                for k in FLEETS
            ]
            fits.append(float(np.corrcoef(FLEETS, y)[0, 1] ** 2))
    return Finding(
        Verdict.HOLDS if min(fits) >= 0.95 else Verdict.FAILS,
        f"R² of a straight line through the generated nodes of {FLEETS[0]} to {FLEETS[-1]} UAVs: {_range(fits)} "
        "(three methods, two cases; asked: 0.95). UAVs are planned one after another, and the fleets of Table 4.9 "
        "have ways of their own, which is what deviates from the line.",
    )


def polynomial(cells: Cells, form: str) -> Finding:
    """Say what the runs tell of complexity: that the work is linear in population times iterations."""
    x = [n * t for n in POPULATIONS for _, t in CASES]
    fits = [
        float(
            np.corrcoef(x, [_nodes(cells, form, name, "MVO", n, t) for n in POPULATIONS for _, t in CASES])[0, 1] ** 2
        )
        for name in MAPS
    ]
    return Finding(
        Verdict.OPEN,
        "No experiment of the thesis varies the size of the problem. What can be told: MVO's generated nodes are "
        f"linear in population times iterations (R² {_range(fits)} on the three maps).",
    )


def _spreads(
    cells: Cells, form: str, pairs: Sequence[tuple[str, str]], maps: Sequence[str], which: Sequence[tuple[int, int]]
) -> Finding:
    """Compare standard deviations by Levene's test about the median (Brown and Forsythe), adjusted by Holm's method."""
    from scipy.stats import levene

    raw, falls, told = [], [], []
    for name in maps:
        for n, t in which:
            for less, more in pairs:
                a, b = (_costs(cells, form, name, method, n, t) for method in (less, more))
                raw.append(float(levene(a, b, center="median").pvalue) if np.ptp(a) + np.ptp(b) else 1.0)
                falls.append(a.std(ddof=1) < b.std(ddof=1))
                told.append(f"{TITLES[name]}, {n} x {t}: {less} {a.std(ddof=1):.1f}, {more} {b.std(ddof=1):.1f}")
    p = holm(raw)
    if any(chance < SIGNIFICANCE_LEVEL and not fall for chance, fall in zip(p, falls, strict=True)):
        verdict = Verdict.FAILS
    else:
        verdict = Verdict.HOLDS if all(p < SIGNIFICANCE_LEVEL) else Verdict.OPEN
    ends = "; ".join(f"{said} (p = {chance:.2g})" for said, chance in zip(told, p, strict=True))
    return Finding(verdict, f"Standard deviations (Brown-Forsythe tests): {ends}.")


def _log_deviation(costs: Floats) -> Floats:
    found: Floats = np.log(np.maximum(costs.std(axis=-1, ddof=1), 1e-9))
    return found


def _costs(cells: Cells, form: str, name: str, method: str, population: int, iterations: int) -> Floats:
    return cells.values("cost", case(name), method, form, population, iterations)


def _nodes(cells: Cells, form: str, name: str, method: str, population: int, iterations: int) -> float:
    return float(cells.values("generated_nodes", case(name), method, form, population, iterations).mean())


def _equal_nodes(cells: Cells, form: str, name: str, method: str) -> float:
    return float(cells.equal("generated_nodes", case(name), method, form, CONVERGENCE_POPULATION, PATHS).mean())


def _range(values: Sequence[float]) -> str:
    return f"{min(values):.2f} to {max(values):.2f}"
