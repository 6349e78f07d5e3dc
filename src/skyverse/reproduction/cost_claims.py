"""How the thesis's claims on costs are judged: what is compared, and by which test."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product

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
Ends = Sequence[tuple[float, float]]
"""The ends of an interval for each map."""
Effort = tuple[int, int] | str
"""Population and iterations, or one of `EQUAL_EFFORTS`."""


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


def order(
    pairs: Pairs, maps: Sequence[str], cells: CellRuns, form: str, sizes: Iterable[tuple[int, int]] = CASES
) -> Finding:
    """Judge whether the first method of each pair has the lower costs in both cases, and at equal effort.

    Instead of the two cases, `sizes` may give other populations and numbers of iterations.
    """
    published = [_contest(cells, form, pair, name, size) for name, size, pair in product(maps, sizes, pairs)]
    equal = [_contest(cells, form, pair, name, effort) for effort, name, pair in product(EQUAL_EFFORTS, maps, pairs)]
    return _judged(published, equal)


def order_after(pairs: Pairs, iterations: Sequence[int], maps: Sequence[str], cells: CellRuns, form: str) -> Finding:
    """Judge the same as `order` after each of these numbers of iterations, with a population of 25."""
    return order(pairs, maps, cells, form, [(CONVERGENCE_POPULATION, t) for t in iterations])


def munkres_lowers(cells: CellRuns, form: str) -> Finding:
    """Judge whether coordination lowers MVO's total cost; the number of iterations is the same with and without."""
    cells = cells.first(FLEET_RUNS)
    without, straight = (fleets.coordinated(how) for how in ("identity", "euclidean"))
    totals = [cells.values("cost", given, "MVO", form, *CASES[1]) for given in (straight, without)]
    found = _judged([_Contest("five UAVs", ("with Munkres", "without"), totals[0], totals[1])], [])
    exact = f" Exact paths: {optimum(straight):g} with it, {optimum(without):g} without."
    return Finding(found.verdict, found.evidence + exact)


def mvo_catches_up(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO is worse than GSO after 1 and 2 iterations, but at most `ALIKE_WITHIN` worse after 50."""
    sizes = [(CONVERGENCE_POPULATION, t) for t in (1, 2)]
    early = [_contest(cells, form, ("GSO", "MVO"), name, size) for name, size in product(THESIS_MAPS, sizes)]
    p = _adjusted(early)
    starts = _outcomes(early, p)
    verdict, told = _against_gso(
        cells,
        form,
        lambda ends: all(high <= ALIKE_WITHIN for _, high in ends),
        lambda ends: any(low > 0 for low, _ in ends),
    )
    if -1 in starts:
        verdict = ClaimVerdict.FAILS
    elif 0 in starts and verdict is not ClaimVerdict.FAILS:
        verdict = ClaimVerdict.OPEN
    return Finding(
        verdict,
        f"At equal iterations: {_said(early, p)}. MVO's mean against GSO's, 95 % intervals (asked: at most "
        f"{ALIKE_WITHIN:.0%} above), {told}.",
    )


def alike_in_the_end(cells: CellRuns, form: str) -> Finding:
    """Judge whether the means of MVO and GSO after 50 iterations differ by at most `ALIKE_WITHIN`."""
    verdict, told = _against_gso(
        cells,
        form,
        lambda ends: all(-ALIKE_WITHIN <= low <= high <= ALIKE_WITHIN for low, high in ends),
        lambda ends: any(low > ALIKE_WITHIN or high < -ALIKE_WITHIN for low, high in ends),
    )
    return Finding(
        verdict, f"Alike is taken to mean within {ALIKE_WITHIN:.0%}. MVO's mean against GSO's, 95 % intervals, {told}."
    )


def flattens(cells: CellRuns, form: str) -> Finding:
    """Judge whether most of the decrease happens by the tenth of 50 iterations, and little after the fortieth."""
    early, late = [], []
    for name, method in product(THESIS_MAPS, METHODS):
        first, tenth, fortieth, last = (
            _costs(cells, form, name, method, (CONVERGENCE_POPULATION, t)).mean() for t in (1, 10, 40, 50)
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
    told, shares = [], []
    for name in THESIS_MAPS:
        costs, bound = _costs(cells, form, name, "MVO", CASES[1]), optimum(case(name))
        shares.append(float((costs <= bound * (1 + 1e-9)).mean()))
        told.append(f"{MAP_TITLES[name]} {shares[-1]:.0%} of the runs, mean gap {costs.mean() / bound - 1:.1%}")
    verdict = (
        ClaimVerdict.HOLDS if min(shares) >= 0.95 else ClaimVerdict.FAILS if min(shares) <= 0.5 else ClaimVerdict.OPEN
    )
    return Finding(verdict, f"Optimal, {_said_effort(CASES[1])}: {'; '.join(told)}.")


def _against_gso(
    cells: CellRuns, form: str, holds: Callable[[Ends], bool], fails: Callable[[Ends], bool]
) -> tuple[ClaimVerdict, str]:
    """Judge by how much MVO's mean lies above GSO's after fifty iterations, and then at each equal effort.

    `holds` and `fails` judge the 95 % intervals, one for each map. The claim holds as a whole only if it holds at
    every effort; otherwise the verdict is that after fifty iterations. The intervals are returned in words.
    """
    verdicts, told = [], []
    efforts: list[Effort] = [(CONVERGENCE_POPULATION, LAST_ITERATION), *EQUAL_EFFORTS]
    for effort in efforts:
        ends = [
            _relative(*(_costs(cells, form, name, method, effort) for method in ("MVO", "GSO"))) for name in THESIS_MAPS
        ]
        verdicts.append(ClaimVerdict.HOLDS if holds(ends) else ClaimVerdict.FAILS if fails(ends) else ClaimVerdict.OPEN)
        said = [f"{MAP_TITLES[name]} {a:+.1%} to {b:+.1%}" for name, (a, b) in zip(THESIS_MAPS, ends, strict=True)]
        when = effort if isinstance(effort, str) else f"{LAST_ITERATION} iterations"
        told.append(f"after {when}: {', '.join(said)}")
    only_first = verdicts[0] is ClaimVerdict.HOLDS and set(verdicts) != {ClaimVerdict.HOLDS}
    return ClaimVerdict.UNEQUAL if only_first else verdicts[0], "; ".join(told)


def _relative(a: Floats, b: Floats) -> tuple[float, float]:
    """Return the 95 % interval of how far the mean of `a` lies above that of `b`, as a share of the latter (Welch)."""
    from scipy.stats import ttest_ind

    if not np.ptp(a) and not np.ptp(b):
        return (float(a[0] / b[0] - 1),) * 2
    low, high = ttest_ind(a, b, equal_var=False).confidence_interval(1 - SIGNIFICANCE_LEVEL)
    return float(low / b.mean()), float(high / b.mean())


def _costs(cells: CellRuns, form: str, name: str, method: str, effort: Effort) -> Floats:
    if isinstance(effort, str):
        return cells.equal("cost", case(name), method, form, CONVERGENCE_POPULATION, effort)
    return cells.values("cost", case(name), method, form, *effort)


def _said_effort(effort: Effort) -> str:
    return effort if isinstance(effort, str) else "{} x {}".format(*effort)


def _contest(cells: CellRuns, form: str, pair: tuple[str, str], name: str, effort: Effort) -> _Contest:
    first, second = (_costs(cells, form, name, method, effort) for method in pair)
    return _Contest(f"{MAP_TITLES[name]}, {_said_effort(effort)}", pair, first, second)


def _judged(published: Sequence[_Contest], equal: Sequence[_Contest]) -> Finding:
    p = _adjusted([*published, *equal])
    p_equal = p[len(published) :]
    outcomes, at_equal = _outcomes(published, p), _outcomes(equal, p_equal)
    verdict = at_both_efforts(-1 not in outcomes, all(outcome == 1 for outcome in at_equal))
    if 0 in outcomes and verdict is not ClaimVerdict.FAILS:
        verdict = ClaimVerdict.OPEN
    told = f"At equal iterations: {_said(published, p)}."
    return Finding(verdict, f"{told} At equal effort: {_said(equal, p_equal)}." if equal else told)


def _adjusted(contests: Sequence[_Contest]) -> list[float]:
    return [float(p) for p in holm([mann_whitney(contest.first, contest.second) for contest in contests])]


def _outcomes(contests: Sequence[_Contest], p: Sequence[float]) -> list[int]:
    """Return 1 where the first mean is significantly lower, -1 where it is higher, 0 where they do not differ."""
    return [
        0 if chance >= SIGNIFICANCE_LEVEL else 1 if contest.first.mean() < contest.second.mean() else -1
        for contest, chance in zip(contests, p, strict=False)
    ]


def _said(contests: Sequence[_Contest], p: Sequence[float]) -> str:
    return "; ".join(contest.said(chance) for contest, chance in zip(contests, p, strict=False))
