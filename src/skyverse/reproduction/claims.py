"""The claims of the thesis, and the page that judges them."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

from skyverse.lab.report import Block, Heading, Table, Text
from skyverse.lab.run_job import Job
from skyverse.reproduction import cost_claims, costs, effort_claims, fleets, populations
from skyverse.reproduction.cell_runs import EQUAL_EFFORTS, FORMS, CellRuns, ThesisPart, case, equal
from skyverse.reproduction.claim_verdict import ClaimVerdict, Finding
from skyverse.reproduction.convergence import up_to
from skyverse.reproduction.cost_claims import order, order_after
from skyverse.reproduction.published import (
    CONVERGENCE_ITERATIONS,
    CONVERGENCE_POPULATION,
    FLEET_RUNS,
    METHODS,
    THESIS_MAPS,
)


@dataclass(frozen=True)
class Claim:
    """A claim of the thesis, the section that makes it, and the function that judges it for one form of the methods."""

    text: str
    where: str
    judge: Callable[[CellRuns, str], Finding]


_MVO_FIRST = (("MVO", "GSO"), ("MVO", "BBO"))
_GSO_FIRST = (("GSO", "MVO"), ("GSO", "BBO"))
_BBO_LAST = (("MVO", "BBO"), ("GSO", "BBO"))

CLAIMS = tuple(
    Claim(*claim)
    for claim in (
        ("On Map 1 MVO finds the lowest mean best cost.", "4.1.1.1", partial(order, _MVO_FIRST, ("map1",))),
        ("On Map 3 MVO finds the lowest mean best cost.", "4.1.1.1", partial(order, _MVO_FIRST, ("map3",))),
        (
            "On Map 2 GSO finds a lower mean best cost than MVO and BBO.",
            "4.1.1.1",
            partial(order, _GSO_FIRST, ("map2",)),
        ),
        ("MVO takes about half of GSO's time.", "4.1.1.1", effort_claims.half_the_time),
        ("BBO is the fastest of the three.", "4.1.1.1, 4.2", effort_claims.bbo_is_fastest),
        (
            "BBO is trapped in local minima: its best costs are the worst of the three.",
            "4.1.1.1, 4.2",
            partial(order, _BBO_LAST, THESIS_MAPS),
        ),
        ("The spread of the best cost falls from the first case to the second.", "4.1.1.1", effort_claims.spread_falls),
        ("In the first case MVO has the smallest spread on Maps 2 and 3.", "4.1.1.1", effort_claims.mvo_spreads_least),
        ("BBO has the largest spread.", "4.1.1.1", effort_claims.bbo_spreads_most),
        (
            "With more iterations the spread falls faster for GSO than for MVO.",
            "4.1.1.2",
            effort_claims.gso_settles_faster,
        ),
        (
            "At 30 iterations MVO has converged further than GSO and BBO.",
            "4.1.1.2",
            partial(order_after, _MVO_FIRST, (30,), THESIS_MAPS),
        ),
        (
            "On the most complex map MVO is better than GSO and BBO already after few iterations (the text says Map 2, "
            "where Table 4.5 has GSO ahead throughout; Map 3, with the most obstacles, is judged here, from 5 to 15 "
            "iterations).",
            "4.1.1.2",
            partial(order_after, _MVO_FIRST, (5, 10, 15), ("map3",)),
        ),
        ("MVO starts out worse than GSO, but catches up as iterations increase.", "4.1.3", cost_claims.mvo_catches_up),
        (
            "After 50 iterations MVO is better than BBO.",
            "4.2",
            partial(order_after, (("MVO", "BBO"),), (50,), THESIS_MAPS),
        ),
        ("After 50 iterations MVO and GSO perform almost alike.", "4.1.3, 4.2", cost_claims.alike_in_the_end),
        (
            "The best cost falls steeply over the first iterations, and hardly over the last.",
            "4.1.3",
            cost_claims.flattens,
        ),
        (
            "In most cases MVO finds the lowest cost in the least time (50 iterations).",
            "abstract",
            effort_claims.best_and_fastest,
        ),
        ("MVO takes much less time than GSO whatever the population.", "4.2", effort_claims.less_time_than_gso),
        ("MVO's lead in time grows with the complexity of the map.", "4.1.3", effort_claims.lead_grows),
        ("Munkres lowers the total cost of five UAVs on Map 3.", "4.1.2.1", cost_claims.munkres_lowers),
        ("The time is close to linear in the number of UAVs.", "4.1.2.2", effort_claims.linear_in_fleet),
        ("MVO's complexity is polynomial.", "4.1.3", effort_claims.polynomial),
        ("MVO generates optimal paths.", "4.2", cost_claims.optimal),
    )
)


def parts() -> list[ThesisPart]:
    """Return the page of claims, and the summary of the 18 cells of Tables 4.2 to 4.4."""
    return [ThesisPart("claims", _jobs, _blocks)]


def _jobs(seeds: Sequence[int]) -> Iterable[Job]:
    tables = (*costs.parts(), *populations.parts(), *fleets.parts())
    for part in tables:
        if part.name in ("table-4.2", "table-4.3", "table-4.4", "table-4.6", "table-4.7", "table-4.10", "fig-4.28"):
            yield from part.jobs(seeds)
    for name in THESIS_MAPS:
        yield from up_to(case(name), CONVERGENCE_ITERATIONS, seeds)
        for method in METHODS:
            for form in FORMS:
                yield from equal(case(name), method, form, CONVERGENCE_POPULATION, seeds)


def _blocks(cells: CellRuns) -> list[Block]:
    judged = [(claim, [claim.judge(cells, form) for form in FORMS]) for claim in CLAIMS]
    rows = [
        [str(number), claim.text, claim.where, *(finding.verdict.value for finding in findings)]
        for number, (claim, findings) in enumerate(judged, 1)
    ]
    holds, unequal, fails, undecided = (verdict.value for verdict in ClaimVerdict)
    blocks: list[Block] = [
        Text(
            "The verdict *as run* is on the experiment behind the published numbers; the verdict *as described* on "
            f"the algorithms that the text describes. **{holds}**: at equal iterations, as published, "
            f"and at equal effort ({' and '.join(EQUAL_EFFORTS)} a run) as well. **{unequal}**: at equal "
            "iterations, where the methods do different amounts of work; at equal effort it is not found. "
            f"**{fails}**: at equal iterations the contrary is found, or the numbers miss what is asked "
            f"of them. **{undecided}**: the runs do not tell. Costs are compared by two-sided Mann-Whitney "
            "tests at 5 %, adjusted by Holm's method over all comparisons of a claim. Claims on time are judged by "
            "generated nodes, which it follows and which any machine counts alike; for them, and for shares of runs, "
            f"what is asked stands with the numbers, and there is no test. {cells.runs} runs a cell (fleets: at most "
            f"{FLEET_RUNS})."
        ),
        Table(["", "claim", "section", "as run", "as described"], rows),
    ]
    for number, (claim, findings) in enumerate(judged, 1):
        blocks += [Heading(f"Claim {number}"), Text(f"{claim.text} ({claim.where})")]
        for form, finding in zip(FORMS, findings, strict=True):
            blocks.append(Text(f"*{form.capitalize()}*: **{finding.verdict.value}**. {finding.evidence}"))
    return blocks
