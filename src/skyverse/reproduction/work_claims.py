"""How claims on time are judged: by generated nodes, and once more by milliseconds, all methods in turn."""

import math
import time
from collections.abc import Sequence
from itertools import product

import numpy as np

from skyverse.lab import Rows, SectionHeading, Table, Text, run_jobs, sample
from skyverse.lab.report import Block
from skyverse.mission.assignment import assign, straight_line
from skyverse.reproduction.cells import EXACT, FORMS, Cell, CellRuns, exact, grid, jobs_of
from skyverse.reproduction.claim_verdict import (
    ClaimVerdict,
    Comparison,
    Evidence,
    Finding,
    MeanDifference,
    counted,
    judged,
    mean_difference,
    verdict,
)
from skyverse.reproduction.convergence import LAST
from skyverse.reproduction.judges import ALIKE_WITHIN, EQUAL, Judge, compared, contrast
from skyverse.reproduction.published import CASES, COSTS, FLEETS, MAP_TITLES, METHODS, POPULATIONS, THESIS_MAPS
from skyverse.reproduction.work import FLEET_SCENARIOS

ABOUT_HALF = (-0.6, -0.35)
"""The range of the thesis's own times of MVO, as differences from GSO's: 0.40 to 0.65 of them."""
MUCH_LESS = (-math.inf, -0.2)
NEAR_LINE = 0.1
"""Fleets' means that deviate from a straight line by at most this share lie on it."""
EQUAL_PATHS = EQUAL[:1]
"""The equal effort at which work is compared."""
WORK_SIZES = tuple((population, iterations) for population in POPULATIONS for _, iterations in CASES)
"""The populations and iterations of Tables 4.6 and 4.7."""
TIMED_RUNS = 10
MUNKRES_SECONDS = (0.01, 1.0)
"""What is of the order of 0.1 s."""
_REPEATS = 200


def best_and_fastest(cells: CellRuns, form: str) -> Finding:
    """Judge on how many maps MVO has both the lowest cost and the least work after fifty iterations."""
    rows: list[Comparison] = []
    verdicts = []
    for name in THESIS_MAPS:
        found = [
            contrast(
                cells,
                f"{MAP_TITLES[name]}, {what}",
                ("MVO", rival),
                grid([name], [LAST], ("MVO", rival), [form]),
                column=column,
            )
            for (what, column), rival in product((("cost", "cost"), (cells.unit, "work")), ("GSO", "BBO"))
        ]
        verdicts.append(verdict([one.evidence() for one in found]))
        rows += found
    holds, fails = (verdicts.count(which) for which in (ClaimVerdict.AS_PUBLISHED, ClaimVerdict.FAILS))
    return Finding(
        ClaimVerdict.AS_PUBLISHED if holds >= 2 else ClaimVerdict.FAILS if fails >= 2 else ClaimVerdict.OPEN,
        f"On {holds} of 3 maps MVO has both the lowest mean cost and the fewest {cells.unit}; on {fails} it is shown "
        "not to. In the thesis's own Tables 4.2 to 4.7 BBO takes less time than MVO in 28 of 30 cells.",
        rows,
    )


def lead_grows(cells: CellRuns, form: str) -> Finding:
    """Judge whether GSO's work lies farther above MVO's on Map 3, with the most obstacles, than on Map 1."""
    told, evidence = [], []
    for size in CASES:
        lead = []
        for name in ("map1", "map3"):
            both = (sample(cells.values("work", cell)) for cell in grid([name], [size], ("GSO", "MVO"), [form]))
            lead.append(mean_difference(*both))
        grown = MeanDifference(
            lead[1].value - lead[0].value, math.hypot(lead[0].error, lead[1].error), min(d.freedom for d in lead)
        )
        ahead = max(each.above(0.0) for each in lead)
        behind = min(each.below(0.0) for each in lead)
        evidence.append(Evidence(2 * max(grown.above(0.0), ahead), min(1.0, 2 * min(grown.below(0.0), behind))))
        seconds = [COSTS[m, "GSO", *size].seconds - COSTS[m, "MVO", *size].seconds for m in ("map1", "map3")]
        told.append(
            "{} x {}: ".format(*size) + f"{counted(lead[0].value)} on Map 1 (8 obstacles), "
            f"{counted(lead[1].value)} on Map 3 (14); published {seconds[0]:.2f} and {seconds[1]:.2f} s"
        )
    at_equal = [compared(cells, form, ("MVO", "GSO"), name, EQUAL_PATHS[0], column="work") for name in THESIS_MAPS]
    equal = [Evidence(1.0, min(1.0, 2 * one.difference.above(0.0))) for one in at_equal]
    return Finding(
        verdict(evidence, equal),
        f"GSO's {cells.unit} less MVO's, {'; '.join(told)}. As a share of GSO's the published lead does not grow "
        "(0.38 and 0.37, 0.40 and 0.37). There is no lead where GSO has no more than MVO, as at equal paths.",
    )


def linear_in_fleet(cells: CellRuns, form: str) -> Finding:
    """Judge how far the mean work for fleets lies from a straight line over the number of UAVs."""
    from scipy.stats import linregress

    few, off, fits = cells.first(), [], []
    for which, method in product(CASES, METHODS):
        fleets = grid(FLEET_SCENARIOS.values(), [which], [method], [form], assignment="euclidean")
        work = np.array([few.values("work", cell).mean() for cell in fleets])
        line = linregress(FLEETS, work)
        off.append(float(np.max(np.abs(work / (line.intercept + line.slope * np.array(FLEETS)) - 1))))
        fits.append(line.rvalue**2)
    return Finding(
        ClaimVerdict.AS_PUBLISHED if max(off) <= NEAR_LINE else ClaimVerdict.OPEN,
        f"The mean {cells.unit} of {FLEETS[0]} to {FLEETS[-1]} UAVs lie at most {max(off):.0%} off a straight line (R² "
        f"{min(fits):.2f} to {max(fits):.2f}; three methods, two cases; asked: {NEAR_LINE:.0%}). Four points, each of "
        "another fleet with ways of its own, are no test of linearity; UAVs are planned one after another, so that "
        "work adds up.",
    )


def polynomial(cells: CellRuns, form: str) -> Finding:
    """Say what the runs show of complexity: the work is linear in population times iterations."""
    from scipy.stats import linregress

    few, sizes, fits = cells.first(), [n * t for n, t in WORK_SIZES], []
    for name in THESIS_MAPS:
        work = [few.values("work", cell).mean() for cell in grid([name], WORK_SIZES, ["MVO"], [form])]
        fits.append(linregress(sizes, work).rvalue ** 2)
    return Finding(
        ClaimVerdict.OPEN,
        "No experiment of the thesis varies the size of the problem. What can be told: MVO's generated nodes are "
        f"linear in population times iterations (R² {min(fits):.2f} to {max(fits):.2f} on the three maps).",
    )


def beat_exact_search(cells: CellRuns, form: str) -> Finding:
    """Judge whether the three methods come within `ALIKE_WITHIN` of A*'s paths with fewer nodes than A* generates."""
    found = [
        contrast(
            cells,
            f"{MAP_TITLES[name]}, 25 x 40, {unit}",
            (method, EXACT),
            [Cell(name, method, form, *CASES[1]), exact(name)],
            (-math.inf, most),
            what,
        )
        for name, method in product(THESIS_MAPS, METHODS)
        for what, unit, most in (("cost", "cost", ALIKE_WITHIN), ("work", cells.unit, 0.0))
    ]
    told = f"Asked: a mean cost at most {ALIKE_WITHIN:.0%} above A*'s, whose path is optimal, with fewer {cells.unit}."
    return judged(found, text=told)


def timed_blocks(claims: Sequence[tuple[int, str, Judge]], wanted: Sequence[Cell], seeds: Sequence[int]) -> list[Block]:
    """Make the runs of the claims once more, one after another, and judge those on time by their seconds."""
    seeds = seeds[:TIMED_RUNS]
    with Rows(":memory:") as rows:
        for seed in (seeds[-1] + 1, *seeds):  # the first loads every kernel
            run_jobs(jobs_of((cell, [seed]) for cell in (*wanted, *grid(THESIS_MAPS))), rows)
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
    scenario, spent = exact("table-4.8").make_case().scenario, []
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
