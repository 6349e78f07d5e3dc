"""Judges a path: whether it is safe, moves on the lattice, and starts and ends where it must."""

from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats
from skyverse.model.pad import Pad
from skyverse.model.result import Result
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.clearance import judge_segments
from skyverse.referee.judgement import position_text, position_tuple
from skyverse.referee.pads import pads_of, parts_of_flight
from skyverse.referee.sorties import Tour
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.tracking_error import named
from skyverse.referee.untrusted import finite_point, float_array
from skyverse.referee.world import RefereeWorld


def judge_safety(world: RefereeWorld, uav: int, tour: Tour, path: Floats) -> Iterator[Violation]:
    """Yield where a path (n, 3) is out of bounds or too close to an obstacle, at its worst.

    On the pads at the UAV's start and targets its tracking error does not count.
    """
    if len(path) < 2:  # a path of one node is judged as a segment of length zero
        path = np.concatenate([path, path])
    legs = np.stack([path[:-1], path[1:]], axis=1)
    for judged_in, part in parts_of_flight(world, uav, tour, legs, np.zeros(len(legs))):
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


def judge_ends(world: RefereeWorld, uav: int, tour: Tour, path: Floats, result: Result) -> Iterator[Violation]:
    """Yield what is wrong with a result's start and goal nodes, and with a status that says the goal is reached."""
    scenario = world.scenario
    name, status = scenario.uavs[uav].name, result.status
    pads = {pad.place: pad for _, pad in pads_of(world, uav, tour)}
    ends = [("start", result.start, scenario.uavs[uav].start)]
    if tour.end is not None:
        ends.append(("goal", result.goal, tour.end))
    for noun, given, place in ends:
        complaint = _end_complaint(world, noun, given, np.array(place), pads.get(place), path, result.any_angle)
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
    world: RefereeWorld, noun: str, given: object, due: Floats, pad: Pad | None, path: Floats, any_angle: bool
) -> str | None:
    """Return what is wrong with a start or goal node that stands for the position `due`, or ``None``."""
    node = finite_point(given)
    if node is None:
        return f"must be x, y, z, but is {given!r}"
    if any_angle and not _same(node, due):
        return f"{position_text(node)} is not {position_text(due)}, where an any-angle path has it"
    if not any_angle and not world.off_lattice(node[None])[0] <= LET_PASS:
        return f"{position_text(node)} is no lattice node"
    if not (world.nominal if any_angle else world).beyond_bounds(node[None])[0] <= LET_PASS:
        return f"{position_text(node)} is out of bounds"
    if pad is not None and not any_angle:  # the node stands for some place on the pad's axis
        due = np.array([*due[:2], np.clip(node[2], due[2], pad.top)])
    if not (np.abs(node - due) <= world.step + LET_PASS).all():
        return f"{position_text(node)} is no corner of the lattice cell of {position_text(due)}"
    if noun == "start" and not _same(path[0], node):
        return f"is {position_text(node)}, but the path begins at {position_text(path[0])}"
    return None


def _same(a: Floats, b: Floats) -> bool:
    return bool((np.abs(a - b) <= LET_PASS).all())
