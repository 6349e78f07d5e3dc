"""How the thesis's claims are judged: what is compared, and what is asked of it.

Claims on time are judged by generated nodes, and once more by milliseconds; both are the runs' ``"work"``.
"""

import math
from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from skyverse._typing import Floats
from skyverse.lab import SIGNIFICANCE_LEVEL, wilson
from skyverse.reproduction.cells import EQUAL_EFFORTS, Cell, CellRuns, Size, grid
from skyverse.reproduction.claim_verdict import (
    LOWER,
    ClaimVerdict,
    Comparison,
    Evidence,
    Finding,
    judged,
    verdict,
)
from skyverse.reproduction.convergence import LAST
from skyverse.reproduction.flights import fly_as_in_thesis
from skyverse.reproduction.published import (
    CASES,
    CONVERGENCE_POPULATION,
    COSTS,
    MAP_TITLES,
    METHODS,
    THESIS_MAPS,
)

ALIKE_WITHIN = 0.02
"""Means that differ by at most this share count as alike."""
OPTIMAL_SHARE = 0.95
"""The share of runs that have to be optimal."""
NEAR = 0.05
"""A cost is near the optimum if it lies at most this share above it."""
TURN_RUNS = 10
"""Flights on each map whose turns are counted."""
MIN_BOOTSTRAP_RUNS = 10
"""The least number of runs from which spreads are bootstrapped."""
RESAMPLES = 2000
EQUAL: list[Size] = [(CONVERGENCE_POPULATION, effort) for effort in EQUAL_EFFORTS]
SWEPT_POPULATIONS = (5, 10, 20, 40, 80, 160)
SWEPT_ITERATIONS = 25

Judge = Callable[[CellRuns, str], Finding]
Range = tuple[float, float]
Pairs = Sequence[tuple[str, str]]


def contrast(
    cells: CellRuns,
    where: str,
    names: tuple[str, str],
    pair: Sequence[Cell],
    asked: Range = LOWER,
    column: str = "cost",
) -> Comparison:
    """Return the comparison of two cells by a column of their runs."""
    first, second = (cells.values(column, cell) for cell in pair)
    return Comparison(where, names, first, second, asked)


def compared(
    cells: CellRuns, form: str, pair: tuple[str, str], name: str, size: Size, asked: Range = LOWER, column: str = "cost"
) -> Comparison:
    """Return the comparison of two methods on a map."""
    said = "{} x {}".format(*size) if isinstance(size[1], int) else size[1]
    both = grid([name], [size], pair, [form])
    return contrast(cells, f"{MAP_TITLES[name]}, {said}", pair, both, asked, column)


def order(
    pairs: Pairs,
    maps: Sequence[str] = THESIS_MAPS,
    sizes: Sequence[Size] = CASES,
    equal: Sequence[Size] = EQUAL,
    *,
    asked: Range = LOWER,
    column: str = "cost",
    few: bool = False,
    told: str = "",
) -> Judge:
    """Judge whether the first method of each pair has the lower mean on these maps, in both cases and at equal effort.

    `asked` is the range of the difference, `column` what is compared; `few` takes fewer runs at equal iterations, and
    `told` is said beside.
    """

    def judge(cells: CellRuns, form: str) -> Finding:
        some = cells.first() if few else cells
        published = [
            compared(some, form, pair, name, size, asked, column) for name, size, pair in product(maps, sizes, pairs)
        ]
        at_equal = [
            compared(cells, form, pair, name, size, asked, column) for size, name, pair in product(equal, maps, pairs)
        ]
        said = told.format(unit=cells.unit, runs=some.runs)
        return judged(published, at_equal, said, same_refutes=asked == LOWER and column == "cost")

    return judge


def after(*iterations: int) -> list[Size]:
    """Return the sizes of runs of 25 candidates with these numbers of iterations."""
    return [(CONVERGENCE_POPULATION, t) for t in iterations]


def munkres_lowers(*methods: str) -> Judge:
    """Judge whether coordination lowers the total cost; the number of iterations is the same with and without."""

    def judge(cells: CellRuns, form: str) -> Finding:
        found = [
            contrast(
                cells.first(),
                f"five UAVs, {method}",
                ("with Munkres", "without"),
                [Cell("table-4.8", method, form, *CASES[1], how) for how in ("euclidean", "identity")],
            )
            for method in methods
        ]
        straight, without = (cells.optimum("table-4.8", how) for how in ("euclidean", "identity"))
        return judged(found, text=f"Exact paths: {straight:g} with it, {without:g} without.")

    return judge


def mvo_catches_up(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO is worse than GSO after 1 and 2 iterations, but at most `ALIKE_WITHIN` worse after 50."""
    pair, within, maps, excepted = ("MVO", "GSO"), (-math.inf, ALIKE_WITHIN), ("map1", "map3"), "map2"
    early = [compared(cells, form, ("GSO", "MVO"), name, size) for name, size in product(maps, after(1, 2))]
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


def flattens(cells: CellRuns, form: str) -> Finding:
    """Judge whether most of the decrease happens by the tenth of 50 iterations, and little after the fortieth."""
    early, late = [], []
    for name, method in product(THESIS_MAPS, METHODS):
        (first, tenth, fortieth, last), _ = cells.means(grid([name], after(1, 10, 40, 50), [method], [form]))
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
        found, bound = cells.values("cost", Cell(name, "MVO", form, *CASES[1])), cells.optimum(name)
        successes = int((found <= bound * (1 + 1e-9)).sum())
        ends.append(wilson(successes, len(found)))
        share, gap = successes / len(found), found.mean() / bound - 1
        told.append(
            f"{MAP_TITLES[name]} {share:.0%} of the runs ({ends[-1].low:.0%} to {ends[-1].high:.0%}), "
            f"mean gap {gap:.1%}"
        )
    judgement = ClaimVerdict.OPEN
    if all(low >= OPTIMAL_SHARE for low, _ in ends):
        judgement = ClaimVerdict.AS_PUBLISHED
    elif any(high < OPTIMAL_SHARE for _, high in ends):
        judgement = ClaimVerdict.FAILS
    return Finding(judgement, f"Optimal, 25 x 40 (asked: {OPTIMAL_SHARE:.0%} on each map): {'; '.join(told)}.")


# ---- spreads ----
def spread_falls(cells: CellRuns, form: str) -> Finding:
    """Judge whether each method's standard deviation falls from the first case to the second, over the three maps."""
    rises = [
        f"{MAP_TITLES[name]} {method} {first:g} to {second:g}"
        for name, method in product(THESIS_MAPS, METHODS)
        if (first := COSTS[name, method, *CASES[0]].deviation) < (second := COSTS[name, method, *CASES[1]].deviation)
    ]
    told = f"In the thesis's own tables it rises in {len(rises)} of 9: {', '.join(rises)}."
    return _changes(cells, form, [((method, 1),) for method in METHODS], told)


def gso_settles_faster(*rivals: str) -> Judge:
    """Judge whether the spread falls by a larger factor for GSO than for each of its rivals, over the three maps."""
    first, second = ({(n, m): COSTS[n, m, *size].deviation for n in THESIS_MAPS for m in METHODS} for size in CASES)
    own = [f"{m} {math.prod(second[n, m] / first[n, m] for n in THESIS_MAPS) ** (1 / 3):.2f}" for m in METHODS]
    told = f"In the thesis's own tables the factors are {', '.join(own)}."
    return lambda cells, form: _changes(cells, form, [(("GSO", 1), (rival, -1)) for rival in rivals], told)


def _changes(cells: CellRuns, form: str, asked: Sequence[Sequence[tuple[str, int]]], told: str) -> Finding:
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
            found = cells.values("cost", Cell(name, method, form, *which))
            drawn = np.vstack([found, rng.choice(found, (RESAMPLES, len(found)))])
            change[method] += sign * np.log(np.maximum(drawn.std(axis=-1, ddof=1), 1e-9)) / len(THESIS_MAPS)
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


def spreads(pairs: Pairs, maps: Sequence[str], sizes: Sequence[tuple[int, int]], told: str = "") -> Judge:
    """Judge by Levene's test about the median (Brown, Forsythe) whether the first of each pair spreads less."""
    from scipy.stats import levene

    def judge(cells: CellRuns, form: str) -> Finding:
        evidence, said = [], []
        for name, size, (less, more) in product(maps, sizes, pairs):
            a, b = (cells.values("cost", cell) for cell in grid([name], [size], (less, more), [form]))
            p = float(levene(a, b, center="median").pvalue) if np.ptp(a) + np.ptp(b) else 1.0
            first, second = (float(values.std(ddof=1)) for values in (a, b))
            evidence.append(Evidence(p, 1.0) if first < second else Evidence(1.0, p))
            where = "{}, {} x {}".format(MAP_TITLES[name], *size)
            said.append(f"{where}: {less} {first:.1f}, {more} {second:.1f} (p = {p:.2g})")
        seen = math.exp(2.8 / math.sqrt(max(cells.runs - 1, 1)))
        return Finding(
            verdict(evidence),
            f"Standard deviations (Brown-Forsythe tests; of normal costs, a ratio of {seen:.2f} would have been seen "
            f"with {cells.runs} runs at a power of 80 %): {'; '.join(said)}.{told}",
        )

    return judge


# ---- what the thesis claims without an experiment ----
def guided_paths_are_better(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO's costs are lower with paths of Algorithm 2 than with those of Algorithm 1."""
    few, names = cells.first(), ("Algorithm 2", "Algorithm 1")
    found = [
        contrast(few, f"{MAP_TITLES[name]}, 20 x 25", names, grid([name], CASES[:1], ("MVO", "MVO uniform"), [form]))
        for name in THESIS_MAPS
    ]
    return judged(found, text=f"MVO, {few.runs} runs a cell. A path that ends short of the goal costs 100 a metre.")


def populations(pair: tuple[int, int], asked: Range) -> Judge:
    """Judge whether MVO's cost with one population lies in a range above that with another, as a share of it."""

    def judge(cells: CellRuns, form: str) -> Finding:
        few, names = cells.first(), (f"{pair[0]} universes", f"{pair[1]} universes")
        found, swept = [], []
        for name in THESIS_MAPS:
            at = {n: Cell(name, "MVO", form, n, SWEPT_ITERATIONS) for n in SWEPT_POPULATIONS}
            where, both = f"{MAP_TITLES[name]}, {SWEPT_ITERATIONS} iterations", [at[n] for n in pair]
            found.append(contrast(few, where, names, both, asked))
            swept.append(f"{MAP_TITLES[name]} {', '.join(f'{mean:.1f}' for mean in few.means(at.values())[0])}")
        told = (
            f"Asked: at least {asked[0]:+.0%}. Mean costs with {', '.join(map(str, SWEPT_POPULATIONS))} universes: "
            f"{'; '.join(swept)}. {few.runs} runs a cell."
        )
        return judged(found, text=told)

    return judge


def obstacles_take_iterations(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO comes near the optimum in fewer iterations where the obstacles are taken away."""
    few, found = cells.first(), []
    for name in THESIS_MAPS:
        without, among = (
            few.iterations_until((1 + NEAR) * few.optimum(name, bare=bare), Cell(name, "MVO", form, *LAST, bare=bare))
            for bare in (True, False)
        )
        found.append(Comparison(f"{MAP_TITLES[name]}, iterations", ("without", "with obstacles"), without, among))
    told = (
        f"Iterations until the best cost is within {NEAR:.0%} of the optimum, 25 universes; {LAST[1] + 1} where it is "
        f"not after {LAST[1]}. {few.runs} runs a cell."
    )
    return judged(found, text=told)


def turns_are_removed(cells: CellRuns, form: str) -> Finding:
    """Judge whether a trajectory has at most half the turns of its path, which MVO found."""
    found = []
    for name in THESIS_MAPS:
        cell = Cell(name, "MVO", form, *CASES[1])
        counts = np.array([_turns(cell, seed) for seed in cells.seeds[:TURN_RUNS]], dtype=np.float64)
        names = ("trajectory", "path")
        found.append(Comparison(f"{MAP_TITLES[name]}, turns", names, counts[:, 0], counts[:, 1], (-math.inf, -0.5)))
    told = f"Asked: at most half of the path's turns. {len(found[0].first)} flights on each map, MVO, 25 x 40."
    return judged(found, text=told)


def _turns(cell: Cell, seed: int) -> tuple[int, int]:
    """Return how many turns a trajectory that stops at each has, and how many its path has."""
    mission = fly_as_in_thesis(cell, seed)
    flown, steps = mission.trajectory(0), np.diff(mission.result(0).path, axis=0)
    directions = steps / np.linalg.norm(steps, axis=1)[:, None]
    rests = np.linalg.norm(flown.at(flown.knots).velocity, axis=1) < 1e-6
    return int(rests.sum()) - 2, int((np.abs(np.diff(directions, axis=0)).max(axis=1) > 1e-9).sum())
