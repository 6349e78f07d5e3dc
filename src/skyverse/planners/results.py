"""Results made of paths: priced, compared with a lower bound, and given a status."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.model.result import Effort, History, Provenance, Result, Status, no_history
from skyverse.numerics.tolerances import LENGTH_ROUNDING, OPTIMALITY_GAP
from skyverse.problem import Problem


@dataclass(frozen=True)
class SearchRecord:
    """What a search took and what ended it; the attributes are those of `Result`."""

    provenance: Provenance
    effort: Effort = field(default_factory=Effort)
    seconds: float = 0.0
    history: History = field(default_factory=no_history)
    stopped_by: str = "finished"


def refused_result(problem: Problem, status: Status, origin: Provenance) -> Result:
    """Return the result of a problem that has no path, for the reason that the status gives."""
    record = SearchRecord(origin, stopped_by="refused")
    ends = problem.uav_place, problem.target_place
    return Result(status, np.empty((0, 3)), math.inf, {}, None, *ends, **vars(record))


def lattice_result(problem: Problem, nodes: Ints, record: SearchRecord) -> Result:
    """Return the result of a path over lattice nodes (n,); its bound is the exact optimum on the lattice."""
    grid, pricing = problem.airspace.grid, problem.airspace.pricing
    terms = cost.terms_of_nodes(problem.scenario, grid, pricing, nodes, problem.goal)
    bound = None if problem.route is None else problem.route.price
    ends = problem.places([problem.source, problem.goal])
    return _priced(problem.places(nodes), ends, terms, bound, bool(nodes[-1] == problem.goal), record)


def any_angle_result(problem: Problem, path: Floats, bound: float | None, record: SearchRecord) -> Result:
    """Return the result of a path (n, 3) of straight legs from the problem's start; the bound must be proven, if given.

    The legs on the pads at the UAV's start and target, where there are any, are added to the path, its price and bound.
    """
    terms = cost.terms_of_legs(problem.scenario, problem.airspace.rates, path, problem.end)
    straight = problem.airspace.rates.metre * math.dist(problem.start, problem.end)
    straight_bound = bound is not None and bound <= straight * (1 + LENGTH_ROUNDING)
    reached = np.array_equal(path[-1], problem.end)
    up, down = problem.lifts
    if len(up) or (len(down) and reached):
        price = sum(terms.values())
        path = np.vstack([up, path, down[: int(reached)]])
        terms = cost.terms_of_legs(problem.scenario, problem.airspace.rates, path, problem.target_place)
        if bound is not None:
            height = problem.start[2] - problem.uav_place[2] + problem.end[2] - problem.target_place[2]
            bound += problem.airspace.rates.metre * float(height)
        history = replace(record.history, cost=record.history.cost + (sum(terms.values()) - price))
        record = replace(record, history=history)
    ends = problem.uav_place, problem.target_place
    priced = _priced(path, ends, terms, bound, reached, record)
    return replace(priced, any_angle=True, straight_bound=straight_bound)


def _priced(
    path: Floats,
    ends: Floats | tuple[Floats, Floats],
    terms: dict[str, float],
    bound: float | None,
    reached: bool,
    record: SearchRecord,
) -> Result:
    price, (start, goal) = sum(terms.values()), ends
    optimal = bound is not None and price <= bound * (1 + OPTIMALITY_GAP)
    status = Status.INCOMPLETE if not reached else Status.OPTIMAL if optimal else Status.COMPLETE
    return Result(status, path, price, terms, bound, start, goal, **vars(record))
