"""What the thesis claims, and what becomes of it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

from skyverse.lab.report import Block, Heading, Table, Text
from skyverse.lab.run_job import Job
from skyverse.reproduction import costs, efforts, fleets, populations, verdicts
from skyverse.reproduction.cells import EQUAL, FORMS, Cells, Part, case, equal
from skyverse.reproduction.convergence import up_to
from skyverse.reproduction.published import CONVERGENCE_ITERATIONS, CONVERGENCE_POPULATION, FLEET_RUNS, MAPS, METHODS
from skyverse.reproduction.verdicts import Finding, Verdict


@dataclass(frozen=True)
class Claim:
    """A claim in our words, the section where it stands, and how it is judged in one form of the methods."""

    text: str
    where: str
    judge: Callable[[Cells, str], Finding]


_MVO_FIRST = (("MVO", "GSO"), ("MVO", "BBO"))

CLAIMS = (
    Claim(
        "On Map 1 MVO finds the lowest mean best cost.",
        "4.1.1.1",
        partial(verdicts.order, _MVO_FIRST, ("map1",)),
    ),
    Claim(
        "On Map 3 MVO finds the lowest mean best cost.",
        "4.1.1.1",
        partial(verdicts.order, _MVO_FIRST, ("map3",)),
    ),
    Claim(
        "On Map 2 GSO finds a lower mean best cost than MVO and BBO.",
        "4.1.1.1",
        partial(verdicts.order, (("GSO", "MVO"), ("GSO", "BBO")), ("map2",)),
    ),
    Claim("MVO takes about half of GSO's time.", "4.1.1.1", efforts.half_the_time),
    Claim("BBO is the fastest of the three.", "4.1.1.1, 4.2", efforts.bbo_is_fastest),
    Claim(
        "BBO is trapped in local minima: its best costs are the worst of the three.",
        "4.1.1.1, 4.2",
        partial(verdicts.order, (("MVO", "BBO"), ("GSO", "BBO")), MAPS),
    ),
    Claim("The spread of the best cost falls from the first case to the second.", "4.1.1.1", efforts.spread_falls),
    Claim("In the first case MVO has the smallest spread on Maps 2 and 3.", "4.1.1.1", efforts.mvo_spreads_least),
    Claim("BBO has the largest spread.", "4.1.1.1", efforts.bbo_spreads_most),
    Claim("With more iterations the spread falls faster for GSO than for MVO.", "4.1.1.2", efforts.gso_settles_faster),
    Claim(
        "At 30 iterations MVO has converged further than GSO and BBO.",
        "4.1.1.2",
        partial(verdicts.order_after, _MVO_FIRST, (30,), MAPS),
    ),
    Claim(
        "On the most complex map MVO is better than GSO and BBO already after few iterations (the text says Map 2, "
        "where Table 4.5 has GSO ahead throughout; Map 3, with the most obstacles, is judged here, from 5 to 15 "
        "iterations).",
        "4.1.1.2",
        partial(verdicts.order_after, _MVO_FIRST, (5, 10, 15), ("map3",)),
    ),
    Claim("MVO starts out worse than GSO, but catches up as iterations increase.", "4.1.3", verdicts.mvo_catches_up),
    Claim(
        "After 50 iterations MVO is better than BBO.",
        "4.2",
        partial(verdicts.order_after, (("MVO", "BBO"),), (50,), MAPS),
    ),
    Claim("After 50 iterations MVO and GSO perform almost alike.", "4.1.3, 4.2", verdicts.alike_in_the_end),
    Claim(
        "The best cost falls steeply over the first iterations, and hardly over the last.", "4.1.3", verdicts.flattens
    ),
    Claim(
        "In most cases MVO finds the lowest cost in the least time (50 iterations).",
        "abstract",
        efforts.best_and_fastest,
    ),
    Claim("MVO takes much less time than GSO whatever the population.", "4.2", efforts.less_time_than_gso),
    Claim("MVO's lead in time grows with the complexity of the map.", "4.1.3", efforts.lead_grows),
    Claim("Munkres lowers the total cost of five UAVs on Map 3.", "4.1.2.1", verdicts.munkres_lowers),
    Claim("The time is close to linear in the number of UAVs.", "4.1.2.2", efforts.linear_in_fleet),
    Claim("MVO's complexity is polynomial.", "4.1.3", efforts.polynomial),
    Claim("MVO generates optimal paths.", "4.2", verdicts.optimal),
)


def parts() -> list[Part]:
    """Return the page of claims, and the summary of the 18 cells of Tables 4.2 to 4.4."""
    return [Part("claims", _jobs, _blocks)]


def _jobs(seeds: Sequence[int]) -> Iterable[Job]:
    tables = (*costs.parts(), *populations.parts(), *fleets.parts())
    for part in tables:
        if part.name in ("table-4.2", "table-4.3", "table-4.4", "table-4.6", "table-4.7", "table-4.10", "fig-4.28"):
            yield from part.jobs(seeds)
    for name in MAPS:
        yield from up_to(case(name), CONVERGENCE_ITERATIONS, seeds)
        for method in METHODS:
            for form in FORMS:
                yield from equal(case(name), method, form, CONVERGENCE_POPULATION, seeds)


def _blocks(cells: Cells) -> list[Block]:
    judged = [(claim, [claim.judge(cells, form) for form in FORMS]) for claim in CLAIMS]
    rows = [
        [str(number), claim.text, claim.where, *(finding.verdict.value for finding in findings)]
        for number, (claim, findings) in enumerate(judged, 1)
    ]
    blocks: list[Block] = [
        Text(
            "The verdict *as run* is on the experiment behind the published numbers; the verdict *as described* on "
            f"the algorithms that the text describes. **{Verdict.HOLDS.value}**: at equal iterations, as published, "
            f"and at equal effort ({' and '.join(EQUAL)} a run) as well. **{Verdict.UNEQUAL.value}**: at equal "
            "iterations, where the methods do different amounts of work; at equal effort it is not found. "
            f"**{Verdict.FAILS.value}**: at equal iterations the contrary is found, or the numbers miss what is asked "
            f"of them. **{Verdict.OPEN.value}**: the runs do not tell. Costs are compared by two-sided Mann-Whitney "
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
