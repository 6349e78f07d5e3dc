"""How each claim of the thesis is judged: what is compared, by which test, and what that says."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.statistics import SIGNIFICANCE_LEVEL, holm, mann_whitney
from skyverse.reproduction import fleets
from skyverse.reproduction.cells import EQUAL, LONGEST, Cells, case, optimum
from skyverse.reproduction.costs import TITLES
from skyverse.reproduction.published import CASES, CONVERGENCE_POPULATION, FLEET_RUNS, MAPS, METHODS

ALIKE = 0.02
"""Means that differ by no larger share are called alike."""


class Verdict(Enum):
    """What becomes of a claim."""

    HOLDS = "holds"
    UNEQUAL = "holds only at unequal effort"
    FAILS = "does not hold"
    OPEN = "cannot be told"


@dataclass(frozen=True)
class Finding:
    """A verdict on one form of the methods, and the numbers behind it."""

    verdict: Verdict
    evidence: str


Pairs = Sequence[tuple[str, str]]


@dataclass(frozen=True)
class _Contest:
    """Whether the mean of the first, better method is lower than the second's."""

    where: str
    names: tuple[str, str]
    first: Floats
    second: Floats

    def said(self, p: float) -> str:
        """Say the means and the adjusted p."""
        (a, b), chance = self.names, f"p = {p:.2g}" if p >= 0.001 else "p < 0.001"
        return f"{self.where}: {a} {self.first.mean():.1f}, {b} {self.second.mean():.1f} ({chance})"


def order(pairs: Pairs, maps: Sequence[str], cells: Cells, form: str) -> Finding:
    """Judge whether the first method of each pair has the lower costs in both cases, and at equal effort."""
    published = [
        _contest(cells, form, pair, name, population, iterations)
        for name in maps
        for population, iterations in CASES
        for pair in pairs
    ]
    return _judged(published, _at_equal_effort(cells, form, pairs, maps))


def order_after(pairs: Pairs, iterations: Sequence[int], maps: Sequence[str], cells: Cells, form: str) -> Finding:
    """Judge the same after these iterations of a population of 25."""
    published = [
        _contest(cells, form, pair, name, CONVERGENCE_POPULATION, t)
        for name in maps
        for t in iterations
        for pair in pairs
    ]
    return _judged(published, _at_equal_effort(cells, form, pairs, maps))


def munkres_lowers(cells: Cells, form: str) -> Finding:
    """Judge whether coordination lowers MVO's total cost; the effort is that of as many iterations either way."""
    population, iterations = CASES[1]
    cells = cells.first(FLEET_RUNS)
    without, straight = (fleets.coordinated(how) for how in ("identity", "euclidean"))
    totals = [cells.values("cost", given, "MVO", form, population, iterations) for given in (straight, without)]
    found = _judged([_Contest("five UAVs", ("with Munkres", "without"), totals[0], totals[1])], [])
    exact = f" Exact paths: {optimum(straight):g} with it, {optimum(without):g} without."
    return Finding(found.verdict, found.evidence + exact)


def mvo_catches_up(cells: Cells, form: str) -> Finding:
    """Judge whether MVO is worse than GSO after one and two iterations, and at most `ALIKE` worse after fifty."""
    early = [_contest(cells, form, ("GSO", "MVO"), name, CONVERGENCE_POPULATION, t) for name in MAPS for t in (1, 2)]
    p = _adjusted(early)
    starts = _outcomes(early, p)
    verdicts, told = [], []
    for effort in (None, *EQUAL):
        ends = [_relative(*_pair(cells, form, name, effort)) for name in MAPS]
        caught, behind = all(high <= ALIKE for _, high in ends), any(low > 0 for low, _ in ends)
        verdicts.append(Verdict.HOLDS if caught else Verdict.FAILS if behind else Verdict.OPEN)
        said = ", ".join(
            f"{TITLES[name]} {low:+.1%} to {high:+.1%}" for name, (low, high) in zip(MAPS, ends, strict=True)
        )
        told.append(f"{_after(effort)}: {said}")
    verdict = verdicts[0]
    if -1 in starts:
        verdict = Verdict.FAILS
    elif 0 in starts and verdict is not Verdict.FAILS:
        verdict = Verdict.OPEN
    elif verdict is Verdict.HOLDS and any(one is not Verdict.HOLDS for one in verdicts[1:]):
        verdict = Verdict.UNEQUAL
    return Finding(
        verdict,
        f"{_said(early, p)} MVO's mean against GSO's, 95 % intervals (asked: at most {ALIKE:.0%} above), "
        f"{'; '.join(told)}.",
    )


def alike_in_the_end(cells: Cells, form: str) -> Finding:
    """Judge whether the means of MVO and GSO after fifty iterations differ by at most `ALIKE`."""
    verdicts, told = [], []
    for effort in (None, *EQUAL):
        inside, outside, said = True, False, []
        for name in MAPS:
            low, high = _relative(*_pair(cells, form, name, effort))
            inside &= -ALIKE <= low <= high <= ALIKE
            outside |= bool(low > ALIKE or high < -ALIKE)
            said.append(f"{TITLES[name]} {low:+.1%} to {high:+.1%}")
        verdicts.append(Verdict.HOLDS if inside else Verdict.FAILS if outside else Verdict.OPEN)
        told.append(f"{_after(effort)}: {', '.join(said)}")
    verdict = verdicts[0]
    if verdict is Verdict.HOLDS and any(one is not Verdict.HOLDS for one in verdicts[1:]):
        verdict = Verdict.UNEQUAL
    return Finding(
        verdict,
        f"Alike is taken to mean within {ALIKE:.0%}. MVO's mean against GSO's, 95 % intervals, {'; '.join(told)}.",
    )


def flattens(cells: Cells, form: str) -> Finding:
    """Judge whether most of the fall is made by the tenth of 50 iterations, and little after the fortieth."""
    early, late = [], []
    for name in MAPS:
        for method in METHODS:
            first, tenth, fortieth, last = (
                cells.values("cost", case(name), method, form, CONVERGENCE_POPULATION, t).mean()
                for t in (1, 10, 40, 50)
            )
            early.append((first - tenth) / (first - last))
            late.append((fortieth - last) / (first - last))
    holds = min(early) > 0.5 and max(late) < 0.1
    return Finding(
        Verdict.HOLDS if holds else Verdict.FAILS,
        f"Of the fall of the mean best cost from 1 to 50 iterations, {min(early):.0%} to {max(early):.0%} is made by "
        f"the tenth, and {min(late):.0%} to {max(late):.0%} after the fortieth (three methods on three maps; asked: "
        "above 50 % and below 10 %).",
    )


def optimal(cells: Cells, form: str) -> Finding:
    """Judge how often MVO's best path is an optimal one."""
    population, iterations = CASES[1]
    told, shares = [], []
    for name in MAPS:
        costs = cells.values("cost", case(name), "MVO", form, population, iterations)
        bound = optimum(case(name))
        shares.append(float((costs <= bound * (1 + 1e-9)).mean()))
        told.append(f"{TITLES[name]} {shares[-1]:.0%} of the runs, mean gap {costs.mean() / bound - 1:.1%}")
    verdict = Verdict.HOLDS if min(shares) >= 0.95 else Verdict.FAILS if min(shares) <= 0.5 else Verdict.OPEN
    return Finding(verdict, f"Optimal, {population} x {iterations}: {'; '.join(told)}.")


def _pair(cells: Cells, form: str, name: str, effort: str | None) -> tuple[Floats, Floats]:
    """Return the costs of MVO and GSO after fifty iterations, or at an equal effort."""
    found = [
        cells.values("cost", case(name), method, form, CONVERGENCE_POPULATION, LONGEST)
        if effort is None
        else cells.equal("cost", case(name), method, form, CONVERGENCE_POPULATION, effort)
        for method in ("MVO", "GSO")
    ]
    return found[0], found[1]


def _after(effort: str | None) -> str:
    return f"after {LONGEST} iterations" if effort is None else f"after {effort}"


def _relative(a: Floats, b: Floats) -> tuple[float, float]:
    """Return the 95 % interval of how far the mean of `a` lies above that of `b`, as a share of it (Welch)."""
    from scipy.stats import ttest_ind

    if not np.ptp(a) and not np.ptp(b):
        return (float(a[0] / b[0] - 1),) * 2
    low, high = ttest_ind(a, b, equal_var=False).confidence_interval(1 - SIGNIFICANCE_LEVEL)
    return float(low / b.mean()), float(high / b.mean())


def _contest(cells: Cells, form: str, pair: tuple[str, str], name: str, population: int, iterations: int) -> _Contest:
    first, second = (cells.values("cost", case(name), m, form, population, iterations) for m in pair)
    return _Contest(f"{TITLES[name]}, {population} x {iterations}", pair, first, second)


def _at_equal_effort(cells: Cells, form: str, pairs: Pairs, maps: Sequence[str]) -> list[_Contest]:
    found = []
    for effort in EQUAL:
        for name in maps:
            for pair in pairs:
                first, second = (
                    cells.equal("cost", case(name), method, form, CONVERGENCE_POPULATION, effort) for method in pair
                )
                found.append(_Contest(f"{TITLES[name]}, {effort}", pair, first, second))
    return found


def _judged(published: Sequence[_Contest], equal: Sequence[_Contest]) -> Finding:
    p = _adjusted([*published, *equal])
    outcomes = _outcomes(published, p[: len(published)])
    at_equal = _outcomes(equal, p[len(published) :])
    if -1 in outcomes:
        verdict = Verdict.FAILS
    elif 0 in outcomes:
        verdict = Verdict.OPEN
    else:
        verdict = Verdict.HOLDS if all(outcome == 1 for outcome in at_equal) else Verdict.UNEQUAL
    return Finding(verdict, _said(published, p) + _said_equal(equal, p[len(published) :]))


def _adjusted(contests: Sequence[_Contest]) -> list[float]:
    return [float(p) for p in holm([mann_whitney(contest.first, contest.second) for contest in contests])]


def _outcomes(contests: Sequence[_Contest], p: Sequence[float]) -> list[int]:
    """Return 1 where the first is significantly lower, -1 where it is higher, 0 where neither can be told."""
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
