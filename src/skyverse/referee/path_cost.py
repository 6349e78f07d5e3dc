"""Judges what a result claims that its path costs, and the bound on the cost."""

from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats
from skyverse.model.result import Result, Status
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.soft_terms import altitude_term, climb_term, risk_term
from skyverse.referee.tolerances import BOUND_ROUNDING, COST_LET_PASS, STRAIGHT, UNDERFLOW
from skyverse.referee.untrusted import number
from skyverse.referee.world import RefereeWorld


def judge_cost(world: RefereeWorld, uav: int, path: Floats, goal: Floats, result: Result) -> Iterator[Violation]:
    """Yield what is wrong with the cost of a path (n, 3) towards a goal node (3,), with its terms and its bound."""
    name, objective = world.scenario.uavs[uav].name, world.scenario.objective
    steps = np.diff(path, axis=0)
    lengths = _norms(steps)
    crossed = _norms(np.cross(steps[:-1], steps[1:])) if len(steps) > 1 else np.zeros(0)
    turns = np.count_nonzero(crossed > STRAIGHT * lengths[:-1] * lengths[1:])
    by_nodes = objective.unit == "nodes" and not result.any_angle
    terms = {
        "fuel": objective.fuel * (len(path) if by_nodes else float(lengths.sum())),
        "divergence": objective.divergence * turns,
        "end": objective.end * float(_norms(path[-1:] - goal)[0]),
    }
    given = result.terms if isinstance(result.terms, dict) else {}
    claimed = {str(term): number(share) for term, share in given.items()}
    terms |= _soft_terms(world, path, claimed)
    cost = sum(terms.values())
    agree = claimed.keys() == terms.keys() and all(costs_agree(claimed[term], terms[term]) for term in terms)
    if not agree or not costs_agree(number(result.cost), cost):
        message = f"{name} claims {_bill(claimed, result.cost)}, but its path makes {_bill(terms, cost)}."
        yield Violation(Fault.COST, (uav,), message)

    bound = None if result.bound is None else number(result.bound)
    if result.status is Status.OPTIMAL and (bound is None or not costs_agree(bound, cost)):
        message = f"{name}'s path is called optimal at cost {cost:.9g}, but its bound is {bound}."
        yield Violation(Fault.BOUND, (uav,), message)
    elif result.status.reached and bound is not None and not cost >= bound * (1 - BOUND_ROUNDING):
        message = f"{name}'s path costs {cost:.9g}, less than the bound {bound:.9g} that no path can beat."
        yield Violation(Fault.BOUND, (uav,), message)


def costs_agree(claimed: float, true: float) -> bool:
    """Tell whether a claimed cost differs from the true one by no more than what is let pass."""
    return abs(claimed - true) <= max(COST_LET_PASS, COST_LET_PASS * abs(true))


def _norms(vectors: Floats) -> Floats:
    """Return the Euclidean norms (n,) of (n, 3) vectors, also where squares of their components underflow."""
    norms: Floats = np.linalg.norm(vectors, axis=1)
    tiny = norms < UNDERFLOW
    norms[tiny] = np.linalg.norm(vectors[tiny] * 2.0**600, axis=1) / 2.0**600  # a power of two rounds nothing
    return norms


def _soft_terms(world: RefereeWorld, path: Floats, claimed: dict[str, float]) -> dict[str, float]:
    """Return the soft terms that the objective prices; of the risks that may be right, the one nearest to the claim."""
    scenario, objective = world.scenario, world.scenario.objective
    terms: dict[str, float] = {}
    corners = _without_straight_nodes(path)
    if objective.altitude is not None:
        terms["altitude"] = objective.altitude.weight * altitude_term(objective.altitude, corners, world.ground)
    if objective.risk > 0 and scenario.zones:
        as_it_is, least, most = (objective.risk * metres for metres in risk_term(scenario, corners))
        claim = claimed.get("risk", np.nan)
        terms["risk"] = min(max(claim, least), most) if np.isfinite(claim) else as_it_is
    if objective.climb is not None:
        terms["climb"] = objective.climb.weight * climb_term(objective.climb, corners)
    return terms


def _without_straight_nodes(path: Floats) -> Floats:
    """Return a path without the nodes between two equal steps."""
    steps = np.diff(path, axis=0)
    straight = (steps[1:] == steps[:-1]).all(axis=1)
    return path[np.r_[True, ~straight, True][: len(path)]]


def _bill(terms: dict[str, float], cost: object) -> str:
    return ", ".join(f"{term} {share:.9g}" for term, share in terms.items()) + f" and cost {number(cost):.9g}"
