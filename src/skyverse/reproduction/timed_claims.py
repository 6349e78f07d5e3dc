"""The claims on time, judged by seconds: all methods in turn in one process, so that a slow moment hits all alike."""

import time
from collections.abc import Callable, Iterable, Sequence
from itertools import product

import numpy as np

from skyverse.lab.report import Block, Heading, Table, Text
from skyverse.lab.run_job import Job
from skyverse.mission.assignment import assign, straight_line
from skyverse.planners.astar import AStar
from skyverse.reproduction import effort_claims, fleets
from skyverse.reproduction.cell_runs import (
    EXACT,
    EXACT_BUDGET,
    FORMS,
    LAST_ITERATION,
    CellRuns,
    all_methods,
    case,
    cell,
    equal,
)
from skyverse.reproduction.claim_verdict import ClaimVerdict, Finding
from skyverse.reproduction.lean_runs import run_lean
from skyverse.reproduction.published import CASES, CONVERGENCE_POPULATION, METHODS, THESIS_MAPS
from skyverse.stop import MaxIterations

TIMED_RUNS = 10
MUNKRES_SECONDS = (0.01, 1.0)
"""What is of the order of 0.1 s."""
_REPEATS = 200

Judge = Callable[[CellRuns, str], Finding]


def blocks(claims: Sequence[tuple[int, str, Judge]], cells: CellRuns) -> list[Block]:
    """Make the runs of the claims on time once more, one after another, and judge these claims by their seconds."""
    seeds = cells.seeds[:TIMED_RUNS]
    run_lean(list(_jobs(seeds[:1])))  # loads every kernel
    timed = CellRuns(run_lean(list(_jobs(seeds))), seeds, work="milliseconds")
    judged = [(f"Claim {number}", text, [judge(timed, form) for form in FORMS]) for number, text, judge in claims]
    judged.append(("Munkres", "Munkres's algorithm takes about 0.1 s for five UAVs.", [_munkres()] * len(FORMS)))
    rows = [[name, text, *(finding.verdict.value for finding in found)] for name, text, found in judged]
    shown: list[Block] = [
        Heading("Claims on time"),
        Text(
            "The claims that [claims](claims.md) judges by nodes, judged by the processor's milliseconds: "
            f"{len(seeds)} runs of each method in turn, in one process."
        ),
        Table(["", "claim", *FORMS], rows),
    ]
    for name, text, found in judged:
        shown.append(Text(f"**{name}**: {text}"))
        for form, finding in zip(FORMS, found, strict=True):
            shown += finding.blocks(form)
    return shown


def _jobs(seeds: Sequence[int]) -> Iterable[Job]:
    """Yield the runs, all of a seed before those of the next."""
    maps = [case(name) for name in THESIS_MAPS]
    for seed in seeds:
        yield from all_methods(maps, CASES, [seed])
        yield from all_methods(maps, [(CONVERGENCE_POPULATION, LAST_ITERATION)], [seed])
        yield from all_methods([case(name, "euclidean") for name in fleets.FLEET_SCENARIOS.values()], CASES, [seed])
        for given in maps:
            yield Job(given, AStar(), EXACT, MaxIterations(1), EXACT_BUDGET, seed)
            for method, form in product(METHODS, FORMS):
                yield from equal(given, method, form, CONVERGENCE_POPULATION, [seed])
            for method, form, size in product(("MVO", "GSO"), FORMS, effort_claims.WORK_SIZES):
                if size not in CASES:
                    yield from cell(given, method, form, *size, [seed])


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
        ClaimVerdict.HOLDS if low <= seconds <= high else ClaimVerdict.FAILS,
        f"{1e6 * seconds:.0f} microseconds (scipy's algorithm of Jonker and Volgenant; asked: {low} to {high:g} s). "
        "That it may be ignored holds all the more.",
    )
