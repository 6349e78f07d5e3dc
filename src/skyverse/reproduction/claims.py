"""The claims of the thesis, and the page that judges them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from skyverse.lab import SectionHeading, Table, Text
from skyverse.lab.report import Block
from skyverse.reproduction import judges, work_claims
from skyverse.reproduction.cells import EQUAL_EFFORTS, FORMS, CellRuns, ThesisPart, exact, grid
from skyverse.reproduction.claim_verdict import SAME_WITHIN, ClaimVerdict, Finding
from skyverse.reproduction.convergence import LAST
from skyverse.reproduction.judges import (
    ALIKE_WITHIN,
    EQUAL,
    SWEPT_ITERATIONS,
    SWEPT_POPULATIONS,
    Judge,
    after,
    gso_settles_faster,
    munkres_lowers,
    order,
    populations,
    spreads,
)
from skyverse.reproduction.published import CASES, FLEET_RUNS, THESIS_MAPS
from skyverse.reproduction.work import FLEET_SCENARIOS
from skyverse.reproduction.work_claims import ABOUT_HALF, EQUAL_PATHS, MUCH_LESS, WORK_SIZES


@dataclass(frozen=True)
class Claim:
    """A claim of the thesis, the section that makes it, how it is judged for one form of the methods, and by what."""

    text: str
    where: str
    judge: Judge
    measure: str = "cost"


_MVO_FIRST = (("MVO", "GSO"), ("MVO", "BBO"))
_GSO_FIRST = (("GSO", "MVO"), ("GSO", "BBO"))
_BBO_FIRST = (("BBO", "GSO"), ("BBO", "MVO"))
_BBO_LAST = (("MVO", "BBO"), ("GSO", "BBO"))
_MVO_THEN_BBO, _MVO_THEN_GSO = (("MVO", "BBO"),), (("MVO", "GSO"),)
_FEW = "On the most complex map MVO is best already after few iterations (the text says Map 2; Map 3 is judged)."
_HALF = f"Asked: {1 + ABOUT_HALF[0]:.2f} to {1 + ABOUT_HALF[1]:.2f} of GSO's {{unit}}, as the published times."
_MUCH = "Much less is taken to mean at least 20 % less. {runs} runs a cell at equal iterations."
_half = order(_MVO_THEN_GSO, equal=EQUAL_PATHS, column="work", asked=ABOUT_HALF, told=_HALF)
_bbo_fastest = order(_BBO_FIRST, equal=EQUAL_PATHS, column="work")
_much_less = order(
    _MVO_THEN_GSO, sizes=WORK_SIZES, equal=EQUAL_PATHS, column="work", asked=MUCH_LESS, few=True, told=_MUCH
)
_alike = order(
    _MVO_THEN_GSO,
    sizes=[LAST],
    asked=(-ALIKE_WITHIN, ALIKE_WITHIN),
    told=f"Alike is taken to mean within {ALIKE_WITHIN:.0%}.",
)
_mvo_spreads_least = spreads(_MVO_FIRST, ("map2", "map3"), CASES[:1], " In Table 4.3 itself GSO has 22.2, MVO 27.8.")
_bbo_spreads_most = spreads((("GSO", "BBO"), ("MVO", "BBO")), THESIS_MAPS, CASES)

CLAIMS = (
    Claim("On Map 1 MVO finds the lowest mean best cost.", "4.1.1.1", order(_MVO_FIRST, ["map1"])),
    Claim("On Map 3 MVO finds the lowest mean best cost.", "4.1.1.1", order(_MVO_FIRST, ["map3"])),
    Claim("On Map 2 GSO finds the lowest mean best cost.", "4.1.1.1", order(_GSO_FIRST, ["map2"])),
    Claim("MVO takes about half of GSO's time.", "4.1.1.1", _half, "nodes"),
    Claim("BBO is the fastest of the three.", "4.1.1.1, 4.2", _bbo_fastest, "nodes"),
    Claim("BBO is trapped: its best costs are the worst.", "4.1.1.1, 4.2", order(_BBO_LAST)),
    Claim("The spread falls from the first case to the second.", "4.1.1.1", judges.spread_falls, "spread"),
    Claim("In the first case MVO's is least on Maps 2 and 3.", "4.1.1.1", _mvo_spreads_least, "spread"),
    Claim("BBO has the largest spread.", "4.1.1.1", _bbo_spreads_most, "spread"),
    Claim("The spread falls faster for GSO than for MVO.", "4.1.1.2", gso_settles_faster("MVO"), "spread"),
    Claim("At 30 iterations MVO has converged furthest.", "4.1.1.2", order(_MVO_FIRST, sizes=after(30))),
    Claim(_FEW, "4.1.1.2", order(_MVO_FIRST, ["map3"], after(5, 10, 15))),
    Claim("MVO starts out worse than GSO, but catches up.", "4.1.3", judges.mvo_catches_up),
    Claim("After 50 iterations MVO is better than BBO.", "4.2", order(_MVO_THEN_BBO, sizes=after(50))),
    Claim("After 50 iterations MVO and GSO are almost alike.", "4.1.3, 4.2", _alike),
    Claim("The best cost falls steeply at first, and hardly at last.", "4.1.3", judges.flattens),
    Claim("In most cases MVO is best and fastest.", "abstract", work_claims.best_and_fastest, "cost, nodes"),
    Claim("MVO is much faster than GSO with any population.", "4.2", _much_less, "nodes"),
    Claim("MVO's lead in time grows with the map's complexity.", "4.1.3", work_claims.lead_grows, "nodes"),
    Claim("Munkres lowers the cost of five UAVs on Map 3.", "4.1.2.1", munkres_lowers("MVO")),
    Claim("The time is close to linear in the number of UAVs.", "4.1.2.2", work_claims.linear_in_fleet, "nodes"),
    Claim("MVO's complexity is polynomial.", "4.1.3", work_claims.polynomial, "nodes"),
    Claim("MVO generates optimal paths.", "4.2", judges.optimal),
    Claim(
        "Meta-heuristics find the best paths in less time than A*.", "1", work_claims.beat_exact_search, "cost, nodes"
    ),
    Claim("The effect of Munkres is the same for GSO and BBO.", "4.1.2.1", munkres_lowers("GSO", "BBO")),
    Claim("Algorithm 2 gives better paths than Algorithm 1.", "3.3", judges.guided_paths_are_better),
    Claim("GSO's spread improves most of the three.", "4.1.1.1", gso_settles_faster("MVO", "BBO"), "spread"),
    Claim(
        "A very large population only takes more time.", "4.1.4.1", populations((160, 40), (-ALIKE_WITHIN, math.inf))
    ),
    Claim("Too small a population hardly finds good paths.", "4.1.4.1", populations((5, 40), (ALIKE_WITHIN, math.inf))),
    Claim("Obstacles take more iterations.", "4.1.4.2", judges.obstacles_take_iterations, "iterations"),
    Claim("The trajectory generator removes unwanted turns.", "4.1.4.3", judges.turns_are_removed, "turns"),
)
_CELLS = (
    *grid(THESIS_MAPS, [CASES[0], *EQUAL]),
    *grid(THESIS_MAPS, after(1, 2, 5, 10, 15, 30, 40, 50), ["MVO"]),
    *grid(THESIS_MAPS, [LAST]),
    *map(exact, THESIS_MAPS),
)
_FEW_CELLS = (
    *grid(FLEET_SCENARIOS.values(), assignment="euclidean"),
    *grid(THESIS_MAPS, WORK_SIZES, ["MVO", "GSO"]),
    *grid(THESIS_MAPS, CASES[:1], ["MVO uniform"]),
    *grid(THESIS_MAPS, [(population, SWEPT_ITERATIONS) for population in SWEPT_POPULATIONS], ["MVO"]),
    *grid(THESIS_MAPS, [LAST], ["MVO"], bare=True),
    *grid(["table-4.8"], CASES[1:], assignment="identity"),
    *grid(["table-4.8"], CASES[1:], assignment="euclidean"),
)
"""The cells by which claims are judged: with all seeds, and with few."""


def parts() -> list[ThesisPart]:
    """Return the page of claims."""
    return [ThesisPart("claims", page, _CELLS, _FEW_CELLS, _timed)]


def _timed(cells: CellRuns) -> list[Block]:
    on_time = [(number, claim.text, claim.judge) for number, claim in enumerate(CLAIMS, 1) if "nodes" in claim.measure]
    return work_claims.timed_blocks(on_time, (*_CELLS, *_FEW_CELLS), cells.seeds)


def judge_all(cells: CellRuns) -> list[list[Finding]]:
    """Judge each claim for each form."""
    return [[claim.judge(cells, form) for form in FORMS] for claim in CLAIMS]


def page(cells: CellRuns, elsewhere: Sequence[Sequence[Sequence[ClaimVerdict]]] = ()) -> list[Block]:
    """Return the page of claims; `elsewhere` has the verdicts of other, disjoint sets of seeds."""
    judged = judge_all(cells)
    rows, alike = [], 0
    for number, (claim, findings) in enumerate(zip(CLAIMS, judged, strict=True), 1):
        row = [str(number), claim.text, claim.where, claim.measure]
        for place, finding in enumerate(findings):
            same = sum(verdicts[number - 1][place] is finding.verdict for verdicts in elsewhere)
            alike += same
            row += [finding.verdict.value, *([f"{1 + same} of {1 + len(elsewhere)}"] if elsewhere else [])]
        rows.append(row)
    heads = [head for form in FORMS for head in ((form, "sets of seeds") if elsewhere else (form,))]
    blocks: list[Block] = [
        Text(_explained(cells.runs)),
        Table(["", "claim", "section", "judged by", *heads], rows),
        Text(_stability(len(elsewhere), alike, cells.runs)),
    ]
    for number, (claim, findings) in enumerate(zip(CLAIMS, judged, strict=True), 1):
        blocks += [SectionHeading(f"Claim {number}"), Text(f"{claim.text} ({claim.where})")]
        for form, finding in zip(FORMS, findings, strict=True):
            blocks += finding.blocks(form)
    return blocks


def _explained(runs: int) -> str:
    holds, as_published, unequal, not_shown, fails, undecided = (verdict.value for verdict in ClaimVerdict)
    return (
        "The verdict *as run* is on the experiment behind the published numbers; the verdict *as described* on "
        f"the algorithms that the text describes. **{holds}**: at equal iterations, as published, and at equal effort "
        f"({' and '.join(EQUAL_EFFORTS)} a run) as well. **{as_published}**: at equal iterations; equal effort is not "
        f"at issue, or no runs compare it. **{unequal}**: at equal iterations, where the methods do different amounts "
        "of work; at equal effort the contrary is found, or means that are equal within "
        f"{SAME_WITHIN:.0%} (two one-sided tests). **{not_shown}**: at equal iterations it holds; at equal effort "
        f"the runs show neither that it does nor that it does not. **{fails}**: at equal iterations the contrary is "
        f"found. **{undecided}**: the runs do not tell. Means are compared by Welch's two-sided test at 5 %. A claim "
        "that needs several comparisons needs each of them at 5 % (an intersection-union test); one of them refutes "
        "it, adjusted by Holm's method. *Could be seen* is the least difference that so many runs find at 5 % with "
        f"a power of 80 %. {runs} runs a cell, {FLEET_RUNS} for fleets, work, populations and obstacles.\n\n"
        "**nodes**: a claim on time is judged here as one on work, by generated nodes, which any machine counts alike. "
        "As run the nodes stand for time; as described they do not, because a node of GSO takes longer than one of "
        "MVO: [times](times.md) judges the same claims by measured seconds."
    )


def _stability(others: int, alike: int, runs: int) -> str:
    if not others:
        return "Other seeds may give other verdicts: `--sets 20` judges each claim by twenty disjoint sets of seeds."
    total = len(CLAIMS) * len(FORMS)
    changed = total - alike / others
    return (
        f"*Sets of seeds*: in how many of {1 + others} disjoint sets of {runs} seeds, this one among them, the verdict "
        f"is the same. With another set {changed:.1f} of the {total} verdicts change on average."
    )
