"""How claims on time are judged: by generated nodes, or by milliseconds, whichever counts as the cells' work."""

import math
from collections.abc import Iterable
from functools import partial
from itertools import product

import numpy as np

from skyverse._typing import Floats
from skyverse.reproduction.cell_runs import CellRuns, case
from skyverse.reproduction.claim_verdict import (
    ClaimVerdict,
    Comparison,
    Evidence,
    Finding,
    compare,
    counted,
    judged,
    verdict,
)
from skyverse.reproduction.cost_claims import LAST
from skyverse.reproduction.costs import MAP_TITLES
from skyverse.reproduction.fleets import FLEET_SCENARIOS
from skyverse.reproduction.mean_difference import MeanDifference, explained, mean_difference, sample
from skyverse.reproduction.published import (
    CASES,
    CONVERGENCE_POPULATION,
    COSTS,
    FLEET_RUNS,
    FLEETS,
    METHODS,
    POPULATIONS,
    THESIS_MAPS,
)

EQUAL_PATHS = "1000 paths"
"""The equal effort at which generated nodes are compared."""
ABOUT_HALF = (-0.6, -0.35)
"""The range of the thesis's own times of MVO, as differences from GSO's: 0.40 to 0.65 of them."""
MUCH_LESS = (-math.inf, -0.2)
NEAR_LINE = 0.1
"""Fleets' means that deviate from a straight line by at most this share lie on it."""
WORK_SIZES = tuple((population, iterations) for population in POPULATIONS for _, iterations in CASES)
"""The populations and iterations of Tables 4.6 and 4.7."""


def half_the_time(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO's work is about half of GSO's, at equal iterations and at equal paths."""
    pair, (low, high) = ("MVO", "GSO"), ABOUT_HALF
    told = f"Asked: {1 + low:.2f} to {1 + high:.2f} of GSO's {cells.unit}, as the published times."
    return judged(_nodes(cells, form, pair, CASES, ABOUT_HALF), _equal_nodes(cells, form, pair, ABOUT_HALF), told)


def bbo_is_fastest(cells: CellRuns, form: str) -> Finding:
    """Judge whether BBO works least, at equal iterations and at equal paths."""
    pairs = [("BBO", rival) for rival in ("GSO", "MVO")]
    return judged(
        [one for pair in pairs for one in _nodes(cells, form, pair, CASES)],
        [one for pair in pairs for one in _equal_nodes(cells, form, pair)],
    )


def best_and_fastest(cells: CellRuns, form: str) -> Finding:
    """Judge on how many maps MVO has both the lowest cost and the least work after fifty iterations."""
    compared: list[Comparison] = []
    verdicts = []
    for name in THESIS_MAPS:
        found = [
            compare(f"{MAP_TITLES[name]}, {what}", ("MVO", rival), partial(_last, cells, form, name, column))
            for (what, column), rival in product((("cost", "cost"), (cells.unit, cells.work)), ("GSO", "BBO"))
        ]
        verdicts.append(verdict([one.evidence() for one in found]))
        compared += found
    holds, fails = (verdicts.count(which) for which in (ClaimVerdict.HOLDS, ClaimVerdict.FAILS))
    return Finding(
        ClaimVerdict.HOLDS if holds >= 2 else ClaimVerdict.FAILS if fails >= 2 else ClaimVerdict.OPEN,
        f"On {holds} of 3 maps MVO has both the lowest mean cost and the fewest {cells.unit}; on {fails} it is shown "
        "not to. In the thesis's own Tables 4.2 to 4.7 BBO takes less time than MVO in 28 of 30 cells.",
        compared,
    )


def less_time_than_gso(cells: CellRuns, form: str) -> Finding:
    """Judge whether MVO works at least 20 % less than GSO with every population."""
    few, pair = cells.first(FLEET_RUNS), ("MVO", "GSO")
    told = f"Much less is taken to mean at least 20 % less. {few.runs} runs a cell at equal iterations."
    found = _nodes(few, form, pair, WORK_SIZES, MUCH_LESS)
    return judged(found, _equal_nodes(cells, form, pair, MUCH_LESS), told)


def lead_grows(cells: CellRuns, form: str) -> Finding:
    """Judge whether GSO's work lies farther above MVO's on Map 3, with the most obstacles, than on Map 1."""
    told, evidence = [], []
    for size in CASES:
        lead = []
        for name in ("map1", "map3"):
            gso, mvo = (sample(cells.values(cells.work, case(name), m, form, *size)) for m in ("GSO", "MVO"))
            lead.append(mean_difference(gso, mvo))
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
    equal = [
        Evidence(1.0, min(1.0, 2 * one.difference.above(0.0))) for one in _equal_nodes(cells, form, ("MVO", "GSO"))
    ]
    return Finding(
        verdict(evidence, equal),
        f"GSO's {cells.unit} less MVO's, {'; '.join(told)}. As a share of GSO's the published lead does not grow "
        "(0.38 and 0.37, 0.40 and 0.37). There is no lead where GSO has no more than MVO, as at equal paths.",
    )


def linear_in_fleet(cells: CellRuns, form: str) -> Finding:
    """Judge how far the mean work for fleets lies from a straight line over the number of UAVs."""
    few, off, fits = cells.first(FLEET_RUNS), [], []
    given = [case(FLEET_SCENARIOS[uavs], "euclidean") for uavs in FLEETS]
    for which, method in product(CASES, METHODS):
        nodes = np.array([few.values(few.work, fleet, method, form, *which).mean() for fleet in given])
        line, _, fit = explained(FLEETS, nodes)
        off.append(float(np.max(np.abs(nodes / line - 1))))
        fits.append(fit)
    return Finding(
        ClaimVerdict.HOLDS if max(off) <= NEAR_LINE else ClaimVerdict.OPEN,
        f"The mean {cells.unit} of {FLEETS[0]} to {FLEETS[-1]} UAVs lie at most {max(off):.0%} off a straight line (R² "
        f"{min(fits):.2f} to {max(fits):.2f}; three methods, two cases; asked: {NEAR_LINE:.0%}). Four points, each of "
        "another fleet with ways of its own, are no test of linearity; UAVs are planned one after another, so that "
        "work adds up.",
    )


def polynomial(cells: CellRuns, form: str) -> Finding:
    """Say what the runs show of complexity: the work is linear in population times iterations."""
    few, sizes, fits = cells.first(FLEET_RUNS), [n * t for n, t in WORK_SIZES], []
    for name in THESIS_MAPS:
        nodes = [few.values(few.work, case(name), "MVO", form, *size).mean() for size in WORK_SIZES]
        fits.append(explained(sizes, nodes)[2])
    return Finding(
        ClaimVerdict.OPEN,
        "No experiment of the thesis varies the size of the problem. What can be told: MVO's generated nodes are "
        f"linear in population times iterations (R² {min(fits):.2f} to {max(fits):.2f} on the three maps).",
    )


def _last(cells: CellRuns, form: str, name: str, column: str, method: str) -> Floats:
    return cells.values(column, case(name), method, form, *LAST)


def _nodes(
    cells: CellRuns,
    form: str,
    pair: tuple[str, str],
    sizes: Iterable[tuple[int, int]],
    asked: tuple[float, float] = (-math.inf, 0.0),
) -> list[Comparison]:
    def read(name: str, size: tuple[int, int], method: str) -> Floats:
        return cells.values(cells.work, case(name), method, form, *size)

    return [
        compare("{}, {} x {}".format(MAP_TITLES[name], *size), pair, partial(read, name, size), asked)
        for name, size in product(THESIS_MAPS, sizes)
    ]


def _equal_nodes(
    cells: CellRuns, form: str, pair: tuple[str, str], asked: tuple[float, float] = (-math.inf, 0.0)
) -> list[Comparison]:
    def read(name: str, method: str) -> Floats:
        return cells.equal(cells.work, case(name), method, form, CONVERGENCE_POPULATION, EQUAL_PATHS)

    return [compare(f"{MAP_TITLES[name]}, {EQUAL_PATHS}", pair, partial(read, name), asked) for name in THESIS_MAPS]
