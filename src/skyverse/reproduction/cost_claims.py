"""How the thesis's claims on costs are judged: what is compared, and by which test."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, holm, mann_whitney
from skyverse.reproduction import fleets
from skyverse.reproduction.cell_runs import EQUAL_EFFORTS, LAST_ITERATION, CellRuns, case, optimum
from skyverse.reproduction.claim_verdict import ClaimVerdict, Finding, at_both_efforts
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.published import CASES, CONVERGENCE_POPULATION, FLEET_RUNS, METHODS, THESIS_MAPS

ALIKE_WITHIN = 0.02
"""Means that differ by at most this share count as alike."""


Pairs = Sequence[tuple[str, str]]


@dataclass(frozen=True)
class _Contest:
    """Costs of two methods, the first of which is claimed to have the lower mean."""

    where: str
    names: tuple[str, str]
    first: Floats
    second: Floats

    def said(self, p: float) -> str:
        """Return the means and the adjusted p in words."""
        (a, b), chance = self.names, f"p = {p:.2g}" if p >= 0.001 else "p < 0.001"
        return f"{self.where}: {a} {self.first.mean():.1f}, {b} {self.second.mean():.1f} ({chance})"


def order(pairs: Pairs, maps: Sequence[str], cells: CellRuns, form: str) -> Finding:
    """Judge whether the first method of each pair has the lower costs in both cases, and at equal effort."""
    published = [
        _contest(cells, form, pair, name, population, iterations)
        for name in maps
        for population, iterations in CASES
        for pair in pairs
    ]
    return _judged(published, _at_equal_effort(cells, form, pairs, maps))


def order_after(pairs: Pairs, iterations: Sequence[int], maps: Sequence[str], cells: CellRuns, form: str) -> Finding:
    """Judge the same as `order` after each of these numbers of iterations, with a population of 25."""
    published = [
        _contest(cells, form, pair, name, CONVERGENCE_POPULATION, t)
        for name in maps
        for t in iterations
        for pair in pairs
    ]
    return _judged(published, _at_equal_effort(cells, form, pairs, maps))


def munkres_lowers(cells: CellRuns, form: str) -> Finding:
    """Judge whether coordination lowers MVO's total cost; the number of iterations is the same with and without."""
    population, iterations = CASES[1]
    cells = cells.first(FLEET_RUNS)
    without, straight = (fleets.coordinated(how) for how in ("identity", "euclidean"))
    totals = [cells.values("cost", given, "MVO", form, population, iterations) for given in (straight, without)]
    found = _judged([_Contest("five UAVs", ("with Munkres", "without"), totals[0], totals[1])], [])
    exact = f" Exact paths: {optimum(straight):g} with it, {optimum(without):g} without."
    return Finding(found.verdict, found.evidence + exact)


def mvo_catches_up(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO is worse than GSO after 1 and 2 iterations, but at most `ALIKE_WITHIN` worse after 50."""
    pair, wheres = ("GSO", "MVO"), [(name, t) for name in THESIS_MAPS for t in (1, 2)]
    early = [_contest(cells, form, pair, name, CONVERGENCE_POPULATION, t) for name, t in wheres]
    p = _adjusted(early)
    starts = _outcomes(early, p)
    verdicts, told = [], []
    for when, ends in _intervals(cells, form):
        caught, behind = all(high <= ALIKE_WITHIN for _, high in ends), any(low > 0 for low, _ in ends)
        verdicts.append(ClaimVerdict.HOLDS if caught else ClaimVerdict.FAILS if behind else ClaimVerdict.OPEN)
        told.append(_said_intervals(when, ends))
    verdict = _combined(verdicts)
    if -1 in starts:
        verdict = ClaimVerdict.FAILS
    elif 0 in starts and verdict is not ClaimVerdict.FAILS:
        verdict = ClaimVerdict.OPEN
    return Finding(
        verdict,
        f"{_said(early, p)} MVO's mean against GSO's, 95 % intervals (asked: at most {ALIKE_WITHIN:.0%} above), "
        f"{'; '.join(told)}.",
    )


def alike_in_the_end(cells: CellRuns, form: str) -> Finding:
    """Judge whether the means of MVO and GSO after 50 iterations differ by at most `ALIKE_WITHIN`."""
    verdicts, told = [], []
    for when, ends in _intervals(cells, form):
        inside = all(-ALIKE_WITHIN <= low <= high <= ALIKE_WITHIN for low, high in ends)
        outside = any(low > ALIKE_WITHIN or high < -ALIKE_WITHIN for low, high in ends)
        verdicts.append(ClaimVerdict.HOLDS if inside else ClaimVerdict.FAILS if outside else ClaimVerdict.OPEN)
        told.append(_said_intervals(when, ends))
    return Finding(
        _combined(verdicts),
        f"Alike is taken to mean within {ALIKE_WITHIN:.0%}. MVO's mean against GSO's, 95 % intervals, "
        f"{'; '.join(told)}.",
    )


def flattens(cells: CellRuns, form: str) -> Finding:
    """Judge whether most of the decrease happens by the tenth of 50 iterations, and little after the fortieth."""
    early, late = [], []
    for name in THESIS_MAPS:
        for method in METHODS:
            first, tenth, fortieth, last = (
                cells.values("cost", case(name), method, form, CONVERGENCE_POPULATION, t).mean()
                for t in (1, 10, 40, 50)
            )
            early.append((first - tenth) / (first - last))
            late.append((fortieth - last) / (first - last))
    holds = min(early) > 0.5 and max(late) < 0.1
    return Finding(
        ClaimVerdict.HOLDS if holds else ClaimVerdict.FAILS,
        f"Of the fall of the mean best cost from 1 to 50 iterations, {min(early):.0%} to {max(early):.0%} is made by "
        f"the tenth, and {min(late):.0%} to {max(late):.0%} after the fortieth (three methods on three maps; asked: "
        "above 50 % and below 10 %).",
    )


def optimal(cells: CellRuns, form: str) -> Finding:
    """Judge in which share of the runs MVO's best path is optimal."""
    population, iterations = CASES[1]
    told, shares = [], []
    for name in THESIS_MAPS:
        costs = cells.values("cost", case(name), "MVO", form, population, iterations)
        bound = optimum(case(name))
        shares.append(float((costs <= bound * (1 + 1e-9)).mean()))
        told.append(f"{MAP_TITLES[name]} {shares[-1]:.0%} of the runs, mean gap {costs.mean() / bound - 1:.1%}")
    verdict = (
        ClaimVerdict.HOLDS if min(shares) >= 0.95 else ClaimVerdict.FAILS if min(shares) <= 0.5 else ClaimVerdict.OPEN
    )
    return Finding(verdict, f"Optimal, {population} x {iterations}: {'; '.join(told)}.")


def _intervals(cells: CellRuns, form: str) -> Iterator[tuple[str, list[tuple[float, float]]]]:
    """Yield when costs are compared, first after fifty iterations, then at each equal effort, and the intervals.

    There is a 95 % interval for each map: by which share MVO's mean lies above GSO's.
    """
    for effort in (None, *EQUAL_EFFORTS):
        found = []
        for name in THESIS_MAPS:
            mvo, gso = (
                cells.values("cost", case(name), method, form, CONVERGENCE_POPULATION, LAST_ITERATION)
                if effort is None
                else cells.equal("cost", case(name), method, form, CONVERGENCE_POPULATION, effort)
                for method in ("MVO", "GSO")
            )
            found.append(_relative(mvo, gso))
        yield f"after {LAST_ITERATION} iterations" if effort is None else f"after {effort}", found


def _said_intervals(when: str, ends: Sequence[tuple[float, float]]) -> str:
    said = [
        f"{MAP_TITLES[name]} {low:+.1%} to {high:+.1%}" for name, (low, high) in zip(THESIS_MAPS, ends, strict=True)
    ]
    return f"{when}: {', '.join(said)}"


def _combined(verdicts: Sequence[ClaimVerdict]) -> ClaimVerdict:
    """Return the first verdict, that at the published effort; it holds as a whole only if the others hold as well."""
    first, *others = verdicts
    if first is ClaimVerdict.HOLDS and any(other is not ClaimVerdict.HOLDS for other in others):
        return ClaimVerdict.UNEQUAL
    return first


def _relative(a: Floats, b: Floats) -> tuple[float, float]:
    """Return the 95 % interval of how far the mean of `a` lies above that of `b`, as a share of the latter (Welch)."""
    from scipy.stats import ttest_ind

    if not np.ptp(a) and not np.ptp(b):
        return (float(a[0] / b[0] - 1),) * 2
    low, high = ttest_ind(a, b, equal_var=False).confidence_interval(1 - SIGNIFICANCE_LEVEL)
    return float(low / b.mean()), float(high / b.mean())


def _contest(
    cells: CellRuns, form: str, pair: tuple[str, str], name: str, population: int, iterations: int
) -> _Contest:
    first, second = (cells.values("cost", case(name), m, form, population, iterations) for m in pair)
    return _Contest(f"{MAP_TITLES[name]}, {population} x {iterations}", pair, first, second)


def _at_equal_effort(cells: CellRuns, form: str, pairs: Pairs, maps: Sequence[str]) -> list[_Contest]:
    found = []
    for effort in EQUAL_EFFORTS:
        for name in maps:
            for pair in pairs:
                first, second = (
                    cells.equal("cost", case(name), method, form, CONVERGENCE_POPULATION, effort) for method in pair
                )
                found.append(_Contest(f"{MAP_TITLES[name]}, {effort}", pair, first, second))
    return found


def _judged(published: Sequence[_Contest], equal: Sequence[_Contest]) -> Finding:
    p = _adjusted([*published, *equal])
    outcomes = _outcomes(published, p[: len(published)])
    at_equal = _outcomes(equal, p[len(published) :])
    verdict = at_both_efforts(-1 not in outcomes, all(outcome == 1 for outcome in at_equal))
    if 0 in outcomes and verdict is not ClaimVerdict.FAILS:
        verdict = ClaimVerdict.OPEN
    return Finding(verdict, _said(published, p) + _said_equal(equal, p[len(published) :]))


def _adjusted(contests: Sequence[_Contest]) -> list[float]:
    return [float(p) for p in holm([mann_whitney(contest.first, contest.second) for contest in contests])]


def _outcomes(contests: Sequence[_Contest], p: Sequence[float]) -> list[int]:
    """Return 1 where the first mean is significantly lower, -1 where it is higher, 0 where they do not differ."""
    return [
        0 if chance >= SIGNIFICANCE_LEVEL else 1 if contest.first.mean() < contest.second.mean() else -1
        for contest, chance in zip(contests, p, strict=True)
    ]


def _said(contests: Sequence[_Contest], p: Sequence[float]) -> str:
    told = "; ".join(contest.said(chance) for contest, chance in zip(contests, p, strict=False))
    return f"At equal iterations: {told}."


def _said_equal(contests: Sequence[_Contest], p: Sequence[float]) -> str:
    told = "; ".join(contest.said(chance) for contest, chance in zip(contests, p, strict=True))
    return f" At equal effort: {told}." if told else ""
