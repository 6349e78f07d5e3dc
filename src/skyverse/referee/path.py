"""Judges a path: whether it is safe, moves on the lattice, starts and ends where it must, and costs what is claimed."""

from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats
from skyverse.model.result import Result, Status
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.clearance import judge_segments
from skyverse.referee.column import columns_of, parts_of_flight
from skyverse.referee.positions import position_text, position_tuple
from skyverse.referee.seams import find_seam
from skyverse.referee.soft_terms import altitude_term, climb_term, risk_term
from skyverse.referee.tolerances import BOUND_ROUNDING, COLUMN_SLACK, COST_LET_PASS, LET_PASS, STRAIGHT, UNDERFLOW
from skyverse.referee.tube import named
from skyverse.referee.untrusted import finite_point, float_array, number
from skyverse.referee.world import RefereeWorld


def judge_safety(world: RefereeWorld, uav: int, target: int | None, path: Floats) -> Iterator[Violation]:
    """Yield where a path (n, 3) is out of bounds or too close to an obstacle, at its worst.

    In the columns over the UAV's start and target its tracking error does not count.
    """
    if len(path) < 2:  # a path of one node is judged as a segment of length zero
        path = np.concatenate([path, path])
    legs = np.stack([path[:-1], path[1:]], axis=1)
    for judged_in, part in parts_of_flight(world, uav, target, legs, np.zeros(len(legs))):
        yield from _judge_part(judged_in, uav, path[part.start : part.stop + 1], part.start)


def _judge_part(world: RefereeWorld, uav: int, path: Floats, first: int) -> Iterator[Violation]:
    """Yield what is wrong with a part (n, 3) of a path that begins with node number `first`."""
    name = named(f"{world.scenario.uavs[uav].name}'s path", world.error)
    excess = world.beyond_bounds(path)
    worst = int(np.argmax(excess))
    if not excess[worst] <= LET_PASS:
        position = position_text(path[worst])
        message = f"{name} is {excess[worst]:.6g} m out of bounds at node {first + worst}, {position}."
        yield Violation(Fault.PATH_BOUNDS, (uav,), message, position=position_tuple(path[worst]))
    starts, ends = path[:-1], path[1:]
    peaks, incursion = judge_segments(world, starts, ends)
    if incursion is not None:
        message = incursion.sentence(world.scenario, name, f"after node {first + incursion.segment}")
        yield Violation(Fault.PATH_CLEARANCE, (uav,), message, position=position_tuple(incursion.position))
    elif not peaks.proven[0]:
        segment, _ = peaks.place()
        position = position_text(starts[segment])
        message = f"Whether {name} keeps clearance could not be decided after node {first + segment}, {position}."
        yield Violation(Fault.UNDECIDED, (uav,), message, position=position_tuple(starts[segment]))
    if incursion is None and excess[worst] <= LET_PASS:  # else the worst is said already
        seam = find_seam(world, np.stack([starts, ends], axis=1), np.zeros(len(starts)))
        if seam is not None and (seam.decided or peaks.proven[0]):
            message = seam.sentence(world.scenario, name, f"after node {first + seam.piece}")
            fault = Fault.PATH_CLEARANCE if seam.decided else Fault.UNDECIDED
            yield Violation(fault, (uav,), message, position=position_tuple(seam.position))


def judge_moves(world: RefereeWorld, uav: int, path: Floats) -> Iterator[Violation]:
    """Yield where a path (n, 3) leaves the lattice, or else its first step that is no move of the lattice."""
    scenario = world.scenario
    name, connectivity = scenario.uavs[uav].name, scenario.lattice.connectivity
    off = world.off_lattice(path)
    worst = int(np.argmax(off))
    if not off[worst] <= LET_PASS:
        message = f"{name}'s path is {off[worst]:.6g} m off the lattice at node {worst}, {position_text(path[worst])}."
        yield Violation(Fault.PATH_STEP, (uav,), message, position=position_tuple(path[worst]))
        return
    moves = np.diff(np.rint((path - world.first_node) / world.step), axis=0)
    axes = np.count_nonzero(moves, axis=1)
    wrong = (axes == 0) | (np.abs(moves) > 1).any(axis=1) | ((axes > 1) & (connectivity == 6))
    if wrong.any():
        k = int(np.argmax(wrong))
        cells = ", ".join(f"{move:g}" for move in moves[k])
        message = (
            f"{name}'s path goes ({cells}) lattice steps from node {k}, {position_text(path[k])}, to the next, "
            f"which is no move of {connectivity}-connectivity."
        )
        yield Violation(Fault.PATH_STEP, (uav,), message, position=position_tuple(path[k]))


def judge_ends(world: RefereeWorld, uav: int, target: int | None, path: Floats, result: Result) -> Iterator[Violation]:
    """Yield what is wrong with a result's start and goal nodes, and with a status that says the goal is reached."""
    scenario = world.scenario
    name, status = scenario.uavs[uav].name, result.status
    columns = columns_of(world, uav, target)
    ends = [("start", result.start, scenario.uavs[uav].start, columns.start)]
    if target is not None:
        ends.append(("goal", result.goal, scenario.targets[target].position, columns.target))
    for noun, given, place, column in ends:
        due, slack = np.array(place), LET_PASS
        if column is not None and not result.any_angle:  # on the lattice, a node stands for the top of the column
            due[2], slack = column.top, COLUMN_SLACK
        complaint = _end_complaint(world, noun, given, due, path, result.any_angle, slack)
        if complaint is not None:
            message = f"{name}'s {noun} node {complaint}."
            at = position_tuple(path[0 if noun == "start" else -1])
            yield Violation(Fault.PATH_ENDS, (uav,), message, position=at)
    goal = float_array(result.goal)
    if goal is None or goal.shape != (3,):
        return
    if status.reached != _same(path[-1], goal):
        there = f"its path ends at {position_text(path[-1])} and the goal node is {position_text(goal)}"
        message = f"{name}'s status is {status.value}, but {there}."
        yield Violation(Fault.STATUS, (uav,), message, position=position_tuple(path[-1]))


def _end_complaint(
    world: RefereeWorld, noun: str, given: object, due: Floats, path: Floats, any_angle: bool, slack: float
) -> str | None:
    """Return what is wrong with a start or goal node that stands for the position `due`, or ``None``.

    `slack` is let pass in metres where the node must be within a step of that position.
    """
    node = finite_point(given)
    if node is None:
        return f"must be x, y, z, but is {given!r}"
    if any_angle and not _same(node, due):
        return f"{position_text(node)} is not {position_text(due)}, where an any-angle path has it"
    if not any_angle and not world.off_lattice(node[None])[0] <= LET_PASS:
        return f"{position_text(node)} is no lattice node"
    if not (world.nominal if any_angle else world).beyond_bounds(node[None])[0] <= LET_PASS:
        return f"{position_text(node)} is out of bounds"
    if not (np.abs(node - due) <= world.step + slack).all():
        return f"{position_text(node)} is no corner of the lattice cell of {position_text(due)}"
    if noun == "start" and not _same(path[0], node):
        return f"is {position_text(node)}, but the path begins at {position_text(path[0])}"
    return None


def _same(a: Floats, b: Floats) -> bool:
    return bool((np.abs(a - b) <= LET_PASS).all())


def judge_cost(world: RefereeWorld, uav: int, path: Floats, goal: Floats, result: Result) -> Iterator[Violation]:
    """Yield what is wrong with the cost of a path (n, 3) towards a goal node (3,), with its terms and its bound."""
    name, objective = world.scenario.uavs[uav].name, world.scenario.objective
    steps = np.diff(path, axis=0)
    steps = steps[steps.any(axis=1)]  # a place twice in a row hides no turn
    lengths = _norms(steps)
    crossed = _norms(np.cross(steps[:-1], steps[1:]))
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
    if scenario.risky_zones:
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
