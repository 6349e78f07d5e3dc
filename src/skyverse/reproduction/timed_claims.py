"""The claims on time, judged by seconds: all methods in turn in one process, so that a slow moment hits all alike."""

import time
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from skyverse.lab.job import Job
from skyverse.lab.report import Block, SectionHeading, Table, Text
from skyverse.lab.rows import Rows
from skyverse.lab.run_study import run_jobs
from skyverse.mission.assignment import assign, straight_line
from skyverse.reproduction.cell_runs import FORMS, CellRuns, all_methods, case
from skyverse.reproduction.claim_verdict import ClaimVerdict, Finding
from skyverse.reproduction.published import CASES, THESIS_MAPS

TIMED_RUNS = 10
MUNKRES_SECONDS = (0.01, 1.0)
"""What is of the order of 0.1 s."""
_REPEATS = 200

Judge = Callable[[CellRuns, str], Finding]


def blocks(
    claims: Sequence[tuple[int, str, Judge]], jobs: Callable[[Sequence[int]], Iterable[Job]], cells: CellRuns
) -> list[Block]:
    """Make the runs of the claims once more, one after another, and judge those on time by their seconds."""
    seeds = cells.seeds[:TIMED_RUNS]
    with Rows(":memory:") as rows:
        for seed in (seeds[-1] + 1, *seeds):  # the first loads every kernel
            maps = all_methods(map(case, THESIS_MAPS), CASES, [seed])
            run_jobs({job.run: job for job in (*jobs([seed]), *maps)}.values(), rows)
        timed = CellRuns(rows, seeds, work="milliseconds")
        judged = [(f"Claim {number}", text, [judge(timed, form) for form in FORMS]) for number, text, judge in claims]
    judged.append(("Munkres", "Munkres's algorithm takes about 0.1 s for five UAVs.", [_munkres()] * len(FORMS)))
    verdicts = [[name, text, *(finding.verdict.value for finding in found)] for name, text, found in judged]
    shown: list[Block] = [
        SectionHeading("Claims on time"),
        Text(
            "The claims that [claims](claims.md) judges by nodes, judged by measured milliseconds: "
            f"{len(seeds)} runs of each method in turn, in one process."
        ),
        Table(["", "claim", *FORMS], verdicts),
    ]
    for name, text, found in judged:
        shown.append(Text(f"**{name}**: {text}"))
        for form, finding in zip(FORMS, found, strict=True):
            shown += finding.blocks(form)
    return shown


def _munkres() -> Finding:
    """Time the assignment of Table 4.8's fleet on straight lines."""
    scenario, spent = case("table-4.8").scenario, []
    starts, ends = [uav.start for uav in scenario.uavs], [target.position for target in scenario.targets]
    for _ in range(_REPEATS):
        start = time.perf_counter()
        assign(straight_line(starts, ends))
        spent.append(time.perf_counter() - start)
    seconds = float(np.median(spent))
    low, high = MUNKRES_SECONDS
    return Finding(
        ClaimVerdict.AS_PUBLISHED if low <= seconds <= high else ClaimVerdict.FAILS,
        f"{1e6 * seconds:.0f} microseconds (scipy's algorithm of Jonker and Volgenant; asked: {low} to {high:g} s). "
        "That it may be ignored holds all the more.",
    )
