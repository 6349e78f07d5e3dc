"""How the thesis's claims on spread and on time are judged; time is measured by generated nodes."""

from collections.abc import Iterable, Sequence
from itertools import product

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, holm
from skyverse.reproduction.cell_runs import LAST_ITERATION, CellRuns, case
from skyverse.reproduction.claim_verdict import ClaimVerdict, Finding, at_both_efforts
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.fleets import FLEET_SCENARIOS
from skyverse.reproduction.published import (
    CASES,
    CONVERGENCE_POPULATION,
    FLEET_RUNS,
    FLEETS,
    METHODS,
    POPULATIONS,
    THESIS_MAPS,
)

MIN_BOOTSTRAP_RUNS = 10
"""The least number of runs from which spreads are bootstrapped."""
EQUAL_PATHS = "1000 paths"
"""The equal effort at which generated nodes are compared."""
ABOUT_HALF = (0.4, 0.65)
"""The range of the thesis's own ratios of times, MVO to GSO."""
_ALL_SIZES = tuple((population, iterations) for population in POPULATIONS for _, iterations in CASES)


def spread_falls(cells: CellRuns, form: str) -> Finding:
    """Judge by a sign test whether the standard deviation falls from the first case to the second."""
    from scipy.stats import binomtest

    told, falls = [], 0
    for name, method in product(THESIS_MAPS, METHODS):
        first, second = (_costs(cells, form, name, method, *which).std(ddof=1) for which in CASES)
        falls += bool(second < first)
        told.append(f"{MAP_TITLES[name]} {method} {first:.1f} to {second:.1f}")
    p = binomtest(falls, len(told)).pvalue
    verdict = ClaimVerdict.HOLDS if falls > len(told) / 2 else ClaimVerdict.FAILS
    if p >= SIGNIFICANCE_LEVEL:
        verdict = ClaimVerdict.OPEN
    return Finding(verdict, f"It falls in {falls} of {len(told)} (sign test, p = {p:.2g}): {'; '.join(told)}.")


def mvo_spreads_least(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO's spread is smaller than the others' in the first case on Maps 2 and 3."""
    found = _spreads(cells, form, [("MVO", "GSO"), ("MVO", "BBO")], ("map2", "map3"), CASES[:1])
    return Finding(found.verdict, f"{found.evidence} In Table 4.3 itself GSO has 22.2, MVO 27.8.")


def bbo_spreads_most(cells: CellRuns, form: str) -> Finding:
    """Judge whether BBO's spread is larger than the others' in both cases on all maps."""
    return _spreads(cells, form, [("GSO", "BBO"), ("MVO", "BBO")], THESIS_MAPS, CASES)


def gso_settles_faster(cells: CellRuns, form: str) -> Finding:
    """Judge by a bootstrap whether the spread falls by a larger factor for GSO than for MVO, over the three maps."""
    if cells.runs < MIN_BOOTSTRAP_RUNS:
        told = f"Not with {cells.runs} runs, of at least {MIN_BOOTSTRAP_RUNS} that a bootstrap of spreads takes."
        return Finding(ClaimVerdict.OPEN, told)
    rng = np.random.default_rng(0)
    found, resampled = 0.0, np.zeros(2000)
    signs = (("GSO", CASES[0], -1), ("GSO", CASES[1], 1), ("MVO", CASES[0], 1), ("MVO", CASES[1], -1))
    for name, (method, which, sign) in product(THESIS_MAPS, signs):
        costs = _costs(cells, form, name, method, *which)
        drawn = rng.choice(costs, (len(resampled), len(costs)))
        found += sign * float(_log_deviation(costs)) / len(THESIS_MAPS)
        resampled += sign * _log_deviation(drawn) / len(THESIS_MAPS)
    low, high = np.quantile(resampled, (SIGNIFICANCE_LEVEL / 2, 1 - SIGNIFICANCE_LEVEL / 2))
    verdict = ClaimVerdict.HOLDS if high < 0 else ClaimVerdict.FAILS if low > 0 else ClaimVerdict.OPEN
    return Finding(
        verdict,
        f"From the first case to the second GSO's standard deviation changes by {np.exp(found):.2f} times the factor "
        f"of MVO's (95 % bootstrap interval {np.exp(low):.2f} to {np.exp(high):.2f}, geometric mean of three maps).",
    )


def half_the_time(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO's nodes are about half of GSO's, at equal iterations and at equal paths."""
    ratios = _node_ratios(cells, form, "MVO", "GSO", THESIS_MAPS, CASES)
    equal = _equal_node_ratios(cells, form, "MVO", "GSO")
    low, high = ABOUT_HALF
    wheres = [f"{MAP_TITLES[name]}, {n} x {t}" for name in THESIS_MAPS for n, t in CASES]
    told = "; ".join(f"{where} {ratio:.2f}" for where, ratio in zip(wheres, ratios, strict=True))
    return Finding(
        at_both_efforts(*(all(low <= ratio <= high for ratio in found) for found in (ratios, equal))),
        f"MVO's generated nodes over GSO's: {told} (asked: {low} to {high}, as the ratios of the published times). At "
        f"{EQUAL_PATHS} each: {_range(equal)}.",
    )


def bbo_is_fastest(cells: CellRuns, form: str) -> Finding:
    """Judge whether BBO generates the fewest nodes, at equal iterations and at equal paths."""
    rivals = ("GSO", "MVO")
    ratios = [ratio for rival in rivals for ratio in _node_ratios(cells, form, "BBO", rival, THESIS_MAPS, CASES)]
    equal = [ratio for rival in rivals for ratio in _equal_node_ratios(cells, form, "BBO", rival)]
    return Finding(
        at_both_efforts(max(ratios) < 1, max(equal) < 1),
        f"BBO's generated nodes over GSO's and MVO's: {_range(ratios)} at equal iterations, {_range(equal)} at "
        f"{EQUAL_PATHS} each.",
    )


def best_and_fastest(cells: CellRuns, form: str) -> Finding:
    """Judge on how many maps MVO has both the lowest cost and the fewest nodes after fifty iterations."""
    cheapest = quickest = both = 0
    for name in THESIS_MAPS:
        cost = {m: _costs(cells, form, name, m, CONVERGENCE_POPULATION, LAST_ITERATION).mean() for m in METHODS}
        nodes = {m: _nodes(cells, form, name, m, CONVERGENCE_POPULATION, LAST_ITERATION) for m in METHODS}
        first, second = min(cost, key=cost.__getitem__) == "MVO", min(nodes, key=nodes.__getitem__) == "MVO"
        cheapest, quickest, both = cheapest + first, quickest + second, both + (first and second)
    return Finding(
        ClaimVerdict.HOLDS if both >= 2 else ClaimVerdict.FAILS,
        f"MVO has the lowest mean cost on {cheapest} of 3 maps, the fewest generated nodes on {quickest}, both on "
        f"{both}. In the thesis's own Tables 4.2 to 4.7 BBO takes less time than MVO in 28 of 30 cells.",
    )


def less_time_than_gso(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO generates fewer nodes than GSO with every population."""
    ratios = _node_ratios(cells, form, "MVO", "GSO", THESIS_MAPS, _ALL_SIZES)
    equal = _equal_node_ratios(cells, form, "MVO", "GSO")
    return Finding(
        at_both_efforts(max(ratios) < 0.8, max(equal) < 0.8),
        f"MVO's generated nodes over GSO's, populations {POPULATIONS[0]} to {POPULATIONS[-1]}: {_range(ratios)} "
        f"(asked: below 0.8); at {EQUAL_PATHS} each: {_range(equal)}.",
    )


def lead_grows(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO's share of GSO's nodes is at least 5 % lower on Map 3, with most obstacles, than on Map 1."""
    ratios = [_node_ratios(cells, form, "MVO", "GSO", (name,), CASES) for name in ("map1", "map3")]
    told = [
        f"{n} x {t}: {first:.2f} on Map 1 (8 obstacles), {third:.2f} on Map 3 (14)"
        for (n, t), first, third in zip(CASES, *ratios, strict=True)
    ]
    grows = max(third / first for first, third in zip(*ratios, strict=True)) < 0.95
    return Finding(
        ClaimVerdict.UNEQUAL if grows else ClaimVerdict.FAILS,
        f"MVO's generated nodes over GSO's, {'; '.join(told)}. The published times give 0.62 and 0.63, 0.60 and 0.63.",
    )


def linear_in_fleet(cells: CellRuns, form: str) -> Finding:
    """Judge whether a straight line explains at least 95 % of the variation of nodes with the number of UAVs."""
    cells = cells.first(FLEET_RUNS)
    fits = []
    given = [case(FLEET_SCENARIOS[uavs], "euclidean") for uavs in FLEETS]
    for which, method in product(CASES, METHODS):
        nodes = [cells.values("generated_nodes", fleet, method, form, *which).mean() for fleet in given]
        fits.append(_explained(FLEETS, nodes))
    return Finding(
        ClaimVerdict.HOLDS if min(fits) >= 0.95 else ClaimVerdict.FAILS,
        f"R² of a straight line through the generated nodes of {FLEETS[0]} to {FLEETS[-1]} UAVs: {_range(fits)} "
        "(three methods, two cases; asked: 0.95). UAVs are planned one after another, and the fleets of Table 4.9 "
        "have ways of their own, which is what deviates from the line.",
    )


def polynomial(cells: CellRuns, form: str) -> Finding:
    """Say what the runs show of complexity: the work is linear in population times iterations."""
    sizes = [n * t for n, t in _ALL_SIZES]
    fits = [_explained(sizes, [_nodes(cells, form, name, "MVO", n, t) for n, t in _ALL_SIZES]) for name in THESIS_MAPS]
    return Finding(
        ClaimVerdict.OPEN,
        "No experiment of the thesis varies the size of the problem. What can be told: MVO's generated nodes are "
        f"linear in population times iterations (R² {_range(fits)} on the three maps).",
    )


def _spreads(
    cells: CellRuns, form: str, pairs: Sequence[tuple[str, str]], maps: Sequence[str], sizes: Sequence[tuple[int, int]]
) -> Finding:
    """Compare standard deviations by Levene's test about the median (Brown and Forsythe), adjusted by Holm's method."""
    from scipy.stats import levene

    raw, falls, told = [], [], []
    for name, (n, t), (less, more) in product(maps, sizes, pairs):
        a, b = (_costs(cells, form, name, method, n, t) for method in (less, more))
        raw.append(float(levene(a, b, center="median").pvalue) if np.ptp(a) + np.ptp(b) else 1.0)
        falls.append(a.std(ddof=1) < b.std(ddof=1))
        told.append(f"{MAP_TITLES[name]}, {n} x {t}: {less} {a.std(ddof=1):.1f}, {more} {b.std(ddof=1):.1f}")
    p = holm(raw)
    verdict = ClaimVerdict.HOLDS if all(p < SIGNIFICANCE_LEVEL) else ClaimVerdict.OPEN
    if np.any((p < SIGNIFICANCE_LEVEL) & ~np.array(falls)):
        verdict = ClaimVerdict.FAILS
    ends = "; ".join(f"{said} (p = {chance:.2g})" for said, chance in zip(told, p, strict=True))
    return Finding(verdict, f"Standard deviations (Brown-Forsythe tests): {ends}.")


def _log_deviation(costs: Floats) -> Floats:
    return np.log(np.maximum(costs.std(axis=-1, ddof=1), 1e-9))


def _explained(x: Sequence[float], y: Sequence[float]) -> float:
    """Return R², the share of the variance of `y` that a straight line over `x` explains."""
    return float(np.corrcoef(x, y)[0, 1] ** 2)


def _costs(cells: CellRuns, form: str, name: str, method: str, population: int, iterations: int) -> Floats:
    return cells.values("cost", case(name), method, form, population, iterations)


def _nodes(cells: CellRuns, form: str, name: str, method: str, population: int, iterations: int) -> float:
    return float(cells.values("generated_nodes", case(name), method, form, population, iterations).mean())


def _node_ratios(
    cells: CellRuns, form: str, method: str, rival: str, maps: Iterable[str], sizes: Iterable[tuple[int, int]]
) -> list[float]:
    """Return a method's mean nodes divided by a rival's, on each map with each population and number of iterations."""
    where = [(name, n, t) for name in maps for n, t in sizes]
    return [_nodes(cells, form, name, method, n, t) / _nodes(cells, form, name, rival, n, t) for name, n, t in where]


def _equal_node_ratios(cells: CellRuns, form: str, method: str, rival: str) -> list[float]:
    """Return a method's mean nodes divided by a rival's on each map, at an equal number of generated paths."""

    def nodes(name: str, method: str) -> float:
        found = cells.equal("generated_nodes", case(name), method, form, CONVERGENCE_POPULATION, EQUAL_PATHS)
        return float(found.mean())

    return [nodes(name, method) / nodes(name, rival) for name in THESIS_MAPS]


def _range(values: Sequence[float]) -> str:
    return f"{min(values):.2f} to {max(values):.2f}"
