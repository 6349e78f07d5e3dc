"""The claims of the thesis, and the page that judges them."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

from skyverse.lab.job import Job
from skyverse.lab.report import Block, SectionHeading, Table, Text
from skyverse.reproduction import cost_claims, effort_claims, fleets, parameter_claims
from skyverse.reproduction.cell_runs import (
    EQUAL_EFFORTS,
    FORMS,
    CellRuns,
    ThesisPart,
    all_methods,
    case,
    cell,
    exact_searches,
    without_obstacles,
)
from skyverse.reproduction.claim_verdict import SAME_WITHIN, ClaimVerdict, Finding
from skyverse.reproduction.convergence import up_to
from skyverse.reproduction.cost_claims import (
    ALIKE_WITHIN,
    EQUAL,
    LAST,
    gso_settles_faster,
    munkres_lowers,
    order,
    order_after,
)
from skyverse.reproduction.effort_claims import WORK_SIZES
from skyverse.reproduction.parameter_claims import SWEPT_ITERATIONS, SWEPT_POPULATIONS, populations
from skyverse.reproduction.published import CASES, FLEET_RUNS, METHODS, THESIS_MAPS

CLAIMED_ITERATIONS = (1, 2, 5, 10, 15, 30, 40, 50)
"""The numbers of iterations after which claims compare costs, with a population of 25."""


@dataclass(frozen=True)
class Claim:
    """A claim of the thesis, the section that makes it, how it is judged for one form of the methods, and by what."""

    text: str
    where: str
    judge: Callable[[CellRuns, str], Finding]
    measure: str = "cost"


_MVO_FIRST = (("MVO", "GSO"), ("MVO", "BBO"))
_GSO_FIRST = (("GSO", "MVO"), ("GSO", "BBO"))
_BBO_LAST = (("MVO", "BBO"), ("GSO", "BBO"))
_MVO_THEN_BBO = (("MVO", "BBO"),)
_NOT_LOWER, _HIGHER = (-ALIKE_WITHIN, math.inf), (ALIKE_WITHIN, math.inf)
_FEW = "On the most complex map MVO is best already after few iterations (the text says Map 2; Map 3 is judged)."

CLAIMS = (
    Claim("On Map 1 MVO finds the lowest mean best cost.", "4.1.1.1", partial(order, _MVO_FIRST, ("map1",))),
    Claim("On Map 3 MVO finds the lowest mean best cost.", "4.1.1.1", partial(order, _MVO_FIRST, ("map3",))),
    Claim("On Map 2 GSO finds the lowest mean best cost.", "4.1.1.1", partial(order, _GSO_FIRST, ("map2",))),
    Claim("MVO takes about half of GSO's time.", "4.1.1.1", effort_claims.half_the_time, "nodes"),
    Claim("BBO is the fastest of the three.", "4.1.1.1, 4.2", effort_claims.bbo_is_fastest, "nodes"),
    Claim("BBO is trapped: its best costs are the worst.", "4.1.1.1, 4.2", partial(order, _BBO_LAST, THESIS_MAPS)),
    Claim("The spread falls from the first case to the second.", "4.1.1.1", cost_claims.spread_falls, "spread"),
    Claim("In the first case MVO's is least on Maps 2 and 3.", "4.1.1.1", cost_claims.mvo_spreads_least, "spread"),
    Claim("BBO has the largest spread.", "4.1.1.1", cost_claims.bbo_spreads_most, "spread"),
    Claim("The spread falls faster for GSO than for MVO.", "4.1.1.2", partial(gso_settles_faster, ("MVO",)), "spread"),
    Claim(
        "At 30 iterations MVO has converged furthest.", "4.1.1.2", partial(order_after, _MVO_FIRST, (30,), THESIS_MAPS)
    ),
    Claim(_FEW, "4.1.1.2", partial(order_after, _MVO_FIRST, (5, 10, 15), ("map3",))),
    Claim("MVO starts out worse than GSO, but catches up.", "4.1.3", cost_claims.mvo_catches_up),
    Claim(
        "After 50 iterations MVO is better than BBO.", "4.2", partial(order_after, _MVO_THEN_BBO, (50,), THESIS_MAPS)
    ),
    Claim("After 50 iterations MVO and GSO are almost alike.", "4.1.3, 4.2", cost_claims.alike_in_the_end),
    Claim("The best cost falls steeply at first, and hardly at last.", "4.1.3", cost_claims.flattens),
    Claim("In most cases MVO is best and fastest.", "abstract", effort_claims.best_and_fastest, "cost, nodes"),
    Claim("MVO is much faster than GSO with any population.", "4.2", effort_claims.less_time_than_gso, "nodes"),
    Claim("MVO's lead in time grows with the map's complexity.", "4.1.3", effort_claims.lead_grows, "nodes"),
    Claim("Munkres lowers the cost of five UAVs on Map 3.", "4.1.2.1", partial(munkres_lowers, ("MVO",))),
    Claim("The time is close to linear in the number of UAVs.", "4.1.2.2", effort_claims.linear_in_fleet, "nodes"),
    Claim("MVO's complexity is polynomial.", "4.1.3", effort_claims.polynomial, "nodes"),
    Claim("MVO generates optimal paths.", "4.2", cost_claims.optimal),
    Claim(
        "Meta-heuristics find the best paths in less time than A*.",
        "1",
        parameter_claims.beat_exact_search,
        "cost, nodes",
    ),
    Claim("The effect of Munkres is the same for GSO and BBO.", "4.1.2.1", partial(munkres_lowers, ("GSO", "BBO"))),
    Claim("Algorithm 2 gives better paths than Algorithm 1.", "3.3", parameter_claims.guided_paths_are_better),
    Claim(
        "GSO's spread improves most of the three.",
        "4.1.1.1",
        partial(gso_settles_faster, ("MVO", "BBO")),
        "spread",
    ),
    Claim("A very large population only takes more time.", "4.1.4.1", partial(populations, (160, 40), _NOT_LOWER)),
    Claim("Too small a population hardly finds good paths.", "4.1.4.1", partial(populations, (5, 40), _HIGHER)),
    Claim("Obstacles take more iterations.", "4.1.4.2", parameter_claims.obstacles_take_iterations, "iterations"),
    Claim("The trajectory generator removes unwanted turns.", "4.1.4.3", parameter_claims.turns_are_removed, "turns"),
)


def parts() -> list[ThesisPart]:
    """Return the page of claims."""
    on_time = [(number, claim.text, claim.judge) for number, claim in enumerate(CLAIMS, 1) if "nodes" in claim.measure]
    return [ThesisPart("claims", claimed_jobs, page, partial(effort_claims.timed_blocks, on_time, claimed_jobs))]


def claimed_jobs(seeds: Sequence[int]) -> Iterable[Job]:
    """Yield the runs that the claims need."""
    maps, few = [case(name) for name in THESIS_MAPS], seeds[:FLEET_RUNS]
    yield from all_methods(maps, [CASES[0], *EQUAL], seeds)
    for given in maps:
        yield from up_to(given, CLAIMED_ITERATIONS, seeds)
        yield from exact_searches(given, seeds)
    for part in fleets.parts():
        if part.name == "table-4.10":
            yield from part.jobs(few)
    for form in FORMS:
        for given in maps:
            for method, size in product(("MVO", "GSO"), WORK_SIZES):
                yield from cell(given, method, form, *size, few)
            yield from cell(given, "MVO uniform", form, *CASES[0], few)
            for population in SWEPT_POPULATIONS:
                yield from cell(given, "MVO", form, population, SWEPT_ITERATIONS, few)
        for name in THESIS_MAPS:
            yield from cell(without_obstacles(name), "MVO", form, *LAST, few)
        for method, given in product(METHODS, (fleets.coordinated("identity"), fleets.coordinated("euclidean"))):
            yield from cell(given, method, form, *CASES[1], few)


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
