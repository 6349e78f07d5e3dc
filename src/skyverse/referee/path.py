"""Judges one UAV's result: its status, path, cost and bound."""

from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats
from skyverse.model.result import Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.boxes import TOLERANCE, array, beyond_bounds, place, triple
from skyverse.referee.clearance import Space, judge_legs
from skyverse.referee.soft import altitude, climb, risk


def judge_result(
    scenario: Scenario, space: Space, uav: int, target: int | None, result: Result, has_trajectory: bool | None
) -> Iterator[Violation]:
    """Yield what is wrong with UAV number `uav`'s result; `target` is its target's index where it has one.

    Where a trajectory is neither here nor there, `has_trajectory` is ``None``.
    """
    name = scenario.uavs[uav].name
    status = result.status
    if not isinstance(status, Status):
        yield Violation(Fault.STATUS, (uav,), f"{name}'s status is {status!r}, which is none.")
        return
    expected = has_trajectory in (None, status.reached) or (has_trajectory and target is None)
    if not expected:
        has = "a trajectory" if has_trajectory else "no trajectory"
        yield Violation(Fault.TRAJECTORY_SHAPE, (uav,), f"{name}'s status is {status.value}, but it has {has}.")
    yield from _judge_history(uav, name, result)

    path = array(result.path)
    if not status.reached and status is not Status.INCOMPLETE:
        if path is None or path.size:
            message = f"{name} has a path although its status, {status.value}, says that none was begun."
            yield Violation(Fault.STATUS, (uav,), message)
        claimed = {Status.START_OUT_OF_BOUNDS: scenario.uavs[uav].start}
        if target is not None:
            claimed[Status.TARGET_OUT_OF_BOUNDS] = scenario.targets[target].position
        if status in claimed and beyond_bounds(scenario, np.array([claimed[status]]))[0] <= 0:
            message = (
                f"{name}'s status is {status.value}, but {place(np.array(claimed[status]))} lies within the bounds."
            )
            yield Violation(Fault.STATUS, (uav,), message)
        if _number(result.cost) != np.inf:
            message = f"{name} has no path ({status.value}), so its cost must be infinite, but it is {result.cost}."
            yield Violation(Fault.COST, (uav,), message)
        return
    if path is None or path.ndim != 2 or path.shape[1] != 3 or not len(path) or not np.isfinite(path).all():
        found = "no numbers" if path is None else f"shape {path.shape}, {np.sum(~np.isfinite(path))} not finite"
        message = f"{name}'s path ({status.value}) must be one or more rows of x, y, z, but it has {found}."
        yield Violation(Fault.PATH_SHAPE, (uav,), message)
        return
    yield from _judge_safety(scenario, space, uav, path)
    if not isinstance(result.any_angle, bool):
        message = f"{name}'s any_angle must be true or false, but is {result.any_angle!r}."
        yield Violation(Fault.PATH_SHAPE, (uav,), message)
        return
    if not result.any_angle and (scenario.objective.unit == "nodes" or status is Status.OPTIMAL):
        yield from _judge_steps(scenario, uav, path)
    yield from _judge_ends(scenario, uav, target, path, result)
    goal = array(result.goal)
    if goal is not None and goal.shape == (3,) and np.isfinite(goal).all():
        yield from _judge_cost(scenario, space, uav, path, goal, result)


def _judge_safety(scenario: Scenario, space: Space, uav: int, path: Floats) -> Iterator[Violation]:
    name = scenario.uavs[uav].name
    excess = beyond_bounds(scenario, path)
    worst = int(np.argmax(excess))
    if not excess[worst] <= TOLERANCE:
        message = f"{name}'s path is {excess[worst]:.6g} m out of bounds at node {worst}, {place(path[worst])}."
        yield Violation(Fault.PATH_BOUNDS, (uav,), message, position=triple(path[worst]))
    # A path of one node is a segment of length zero.
    starts, ends = (path[:-1], path[1:]) if len(path) > 1 else (path, path)
    peaks, met = judge_legs(scenario, space, starts, ends)
    if met is not None:
        message = met.sentence(f"{name}'s path", f"after node {met.segment}", scenario)
        yield Violation(Fault.PATH_CLEARANCE, (uav,), message, position=triple(met.position))
    elif not peaks.proven(0.0)[0]:
        leg = max(int(peaks.stuck[0]), 0)
        message = f"Whether {name}'s path keeps clearance could not be decided after node {leg}, {place(starts[leg])}."
        yield Violation(Fault.UNDECIDED, (uav,), message, position=triple(starts[leg]))


def _judge_steps(scenario: Scenario, uav: int, path: Floats) -> Iterator[Violation]:
    name, connectivity = scenario.uavs[uav].name, scenario.lattice.connectivity
    off = off_lattice(scenario, path)
    worst = int(np.argmax(off))
    if not off[worst] <= TOLERANCE:
        message = f"{name}'s path is {off[worst]:.6g} m off the lattice at node {worst}, {place(path[worst])}."
        yield Violation(Fault.PATH_STEP, (uav,), message, position=triple(path[worst]))
        return
    moves = np.diff(np.rint((path - np.array(scenario.bounds.min)) / np.array(scenario.lattice.step)), axis=0)
    axes = np.count_nonzero(moves, axis=1)
    wrong = (axes == 0) | (np.abs(moves) > 1).any(axis=1) | ((axes > 1) & (connectivity == 6))
    if wrong.any():
        k = int(np.argmax(wrong))
        cells = ", ".join(f"{move:g}" for move in moves[k])
        message = (
            f"{name}'s path goes ({cells}) lattice steps from node {k}, {place(path[k])}, to the next, "
            f"which is no move of {connectivity}-connectivity."
        )
        yield Violation(Fault.PATH_STEP, (uav,), message, position=triple(path[k]))


def off_lattice(scenario: Scenario, positions: Floats) -> Floats:
    """Return the distance of (n, 3) positions to the lattice's planes, along the worst axis; (n,) metres."""
    low, step = np.array(scenario.bounds.min), np.array(scenario.lattice.step)
    off: Floats = np.abs(positions - (low + np.rint((positions - low) / step) * step)).max(axis=1)
    return off


def _judge_ends(scenario: Scenario, uav: int, target: int | None, path: Floats, result: Result) -> Iterator[Violation]:
    name, status = scenario.uavs[uav].name, result.status
    ends = [("start", result.start, scenario.uavs[uav].start)]
    if target is not None:
        ends.append(("goal", result.goal, scenario.targets[target].position))
    for noun, given, place_of in ends:
        node, true = array(given), np.array(place_of)
        complaint = None
        if node is None or node.shape != (3,) or not np.isfinite(node).all():
            complaint = f"must be x, y, z, but is {given!r}"
        elif result.any_angle and not _same(node, true):
            complaint = f"{place(node)} is not {place(true)}, where an any-angle path has it"
        elif not result.any_angle and not off_lattice(scenario, node[None])[0] <= TOLERANCE:
            complaint = f"{place(node)} is no lattice node"
        elif not beyond_bounds(scenario, node[None])[0] <= TOLERANCE:
            complaint = f"{place(node)} is out of bounds"
        elif not (np.abs(node - true) <= np.array(scenario.lattice.step) + TOLERANCE).all():
            complaint = f"{place(node)} is no corner of the lattice cell of {place(true)}"
        elif noun == "start" and not _same(path[0], node):
            complaint = f"is {place(node)}, but the path begins at {place(path[0])}"
        if complaint is not None:
            message = f"{name}'s {noun} node {complaint}."
            yield Violation(Fault.PATH_ENDS, (uav,), message, position=triple(path[0 if noun == "start" else -1]))
    goal = array(result.goal)
    if goal is None or goal.shape != (3,):
        return
    if status.reached != _same(path[-1], goal):
        there = f"its path ends at {place(path[-1])} and the goal node is {place(goal)}"
        message = f"{name}'s status is {status.value}, but {there}."
        yield Violation(Fault.STATUS, (uav,), message, position=triple(path[-1]))


def _same(a: Floats, b: Floats) -> bool:
    return bool((np.abs(a - b) <= TOLERANCE).all())


def _judge_cost(
    scenario: Scenario, space: Space, uav: int, path: Floats, goal: Floats, result: Result
) -> Iterator[Violation]:
    name, objective = scenario.uavs[uav].name, scenario.objective
    steps = np.diff(path, axis=0)
    lengths = _norms(steps)
    crossed = _norms(np.cross(steps[:-1], steps[1:])) if len(steps) > 1 else np.zeros(0)
    turns = np.count_nonzero(crossed > 1e-9 * lengths[:-1] * lengths[1:])
    by_nodes = objective.unit == "nodes" and not result.any_angle
    true = {
        "fuel": objective.fuel * (len(path) if by_nodes else float(lengths.sum())),
        "divergence": objective.divergence * turns,
        "end": objective.end * float(_norms(path[-1:] - goal)[0]),
    }
    terms = result.terms if isinstance(result.terms, dict) else {}
    claimed = {str(term): _number(share) for term, share in terms.items()}
    true |= _soft_terms(scenario, space, path, claimed)
    cost = sum(true.values())
    agree = claimed.keys() == true.keys() and all(_close(claimed[term], true[term]) for term in true)
    if not agree or not _close(_number(result.cost), cost):
        message = f"{name} claims {_bill(claimed, result.cost)}, but its path makes {_bill(true, cost)}."
        yield Violation(Fault.COST, (uav,), message)

    bound = None if result.bound is None else _number(result.bound)
    if result.status is Status.OPTIMAL and (bound is None or not _close(bound, cost)):
        message = f"{name}'s path is called optimal at cost {cost:.9g}, but its bound is {bound}."
        yield Violation(Fault.BOUND, (uav,), message)
    elif result.status.reached and bound is not None and not cost >= bound * (1 - 1e-9):
        message = f"{name}'s path costs {cost:.9g}, less than the bound {bound:.9g} that no path can beat."
        yield Violation(Fault.BOUND, (uav,), message)


def _norms(vectors: Floats) -> Floats:
    """Return the Euclidean norms of (n, 3) vectors, (n,), also where squares of their components underflow."""
    norms: Floats = np.linalg.norm(vectors, axis=1)
    tiny = norms < 1e-145
    norms[tiny] = np.linalg.norm(vectors[tiny] * 2.0**600, axis=1) / 2.0**600  # a power of two rounds nothing
    return norms


def _soft_terms(scenario: Scenario, space: Space, path: Floats, claimed: dict[str, float]) -> dict[str, float]:
    """Return the soft terms that the objective prices; of the risks that can stand, the one nearest to the claim."""
    objective = scenario.objective
    true: dict[str, float] = {}
    corners = _without_straight_nodes(path)
    if objective.altitude is not None:
        true["altitude"] = objective.altitude.weight * altitude(objective.altitude, corners, space.ground)
    if objective.risk > 0 and scenario.zones:
        stands, least, most = (objective.risk * metres for metres in risk(scenario, corners))
        says = claimed.get("risk", np.nan)
        true["risk"] = min(max(says, least), most) if np.isfinite(says) else stands
    if objective.climb is not None:
        true["climb"] = objective.climb.weight * climb(objective.climb, corners)
    return true


def _without_straight_nodes(path: Floats) -> Floats:
    steps = np.diff(path, axis=0)
    straight = (steps[1:] == steps[:-1]).all(axis=1)
    corners: Floats = path[np.r_[True, ~straight, True][: len(path)]]
    return corners


def _judge_history(uav: int, name: str, result: Result) -> Iterator[Violation]:
    best = array(getattr(result.history, "cost", None))
    if best is not None and best.size == 0:
        return
    cost = _number(result.cost)
    if best is None or best.ndim != 1:
        complaint = "is no list of numbers"
    elif not (best[1:] <= best[:-1]).all():
        k = int(np.argmin(best[1:] <= best[:-1]))
        complaint = f"goes from {best[k]:.9g} to {best[k + 1]:.9g} at row {k + 1}, though it is the best so far"
    elif not (best[-1] == cost or _close(float(best[-1]), cost)):
        complaint = f"ends at {best[-1]:.9g}, but the result costs {cost:.9g}"
    else:
        return
    yield Violation(Fault.COST, (uav,), f"{name}'s history of costs {complaint}.")


def _bill(terms: dict[str, float], cost: object) -> str:
    return ", ".join(f"{term} {share:.9g}" for term, share in terms.items()) + f" and cost {_number(cost):.9g}"


def _close(claimed: float, true: float) -> bool:
    return abs(claimed - true) <= max(1e-6, 1e-6 * abs(true))


def _number(value: object) -> float:
    """Return `value` as a float, NaN where it is no number."""
    number = array(value)
    return float(number) if number is not None and number.shape == () else float("nan")
