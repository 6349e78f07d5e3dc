"""Judges a trajectory at every instant: clearance, bounds, and what the UAV can do."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from skyverse.referee.boxes import TOLERANCE, Boxes, Closest, Floats, Ints, beyond_bounds, place, triple
from skyverse.referee.curve import Curve, curve_of, judge_continuity, judge_ends
from skyverse.referee.limits import FORGIVEN, limits
from skyverse.referee.polynomial import Peaks, Polynomials, bernstein, greatest, stack
from skyverse.result import Trajectory
from skyverse.scenario import Scenario
from skyverse.verdict import Fault, Violation

FINE = 1e-9
"""How near to the worst instant (metres, or a share of the limit) is near enough."""


class Judged(NamedTuple):
    """A trajectory's violations, how often pieces were cut in two, and its curve where it has a sound one."""

    violations: list[Violation]
    halvings: int
    curve: Curve | None


def judge_trajectory(scenario: Scenario, boxes: Boxes, uav: int, target: int | None, trajectory: Trajectory) -> Judged:
    """Judge UAV number `uav`'s trajectory; what is not proven is a violation."""
    vehicle = scenario.uavs[uav]
    curve = curve_of(trajectory)
    if isinstance(curve, str):
        return Judged([Violation(Fault.TRAJECTORY_SHAPE, (uav,), f"{vehicle.name}'s trajectory {curve}.")], 0, None)
    wrong = [
        *judge_ends(scenario, uav, target, curve),
        *judge_continuity(vehicle, uav, curve, trajectory.form),
    ]
    position = bernstein(curve.pieces, curve.durations)
    questions = [_bounds(scenario, uav, curve, position), _clearance(scenario, boxes, uav, curve, position)]
    for limit in limits(vehicle, curve):
        peaks = greatest(limit.excess.b, limit.excess.error, 0.0, FINE)
        found = None
        if peaks.refuted(0.0)[0]:
            time, motion = _instant(curve, int(peaks.piece[0]), float(peaks.share[0]))
            share, deed = limit.measure(motion)
            if share > 1 + FORGIVEN:
                found = _violation(limit.fault, scenario, uav, deed, time, motion[0])
        questions.append((limit.noun, peaks, found))
    halvings, doubts = 0, []
    for noun, peaks, found in questions:
        halvings += int(peaks.halvings[0])
        if found is not None:
            wrong.append(found)
        elif not peaks.proven(0.0)[0]:
            doubts.append((noun, peaks))
    if doubts:
        wrong.append(_undecided(scenario, uav, curve, *doubts[0]))
    return Judged(wrong, halvings, curve)


Question = tuple[str, Peaks, Violation | None]


def _instant(curve: Curve, piece: int, share: float) -> tuple[float, Floats]:
    """Return seconds into the mission, and the motion then, evaluated directly."""
    piece %= len(curve.pieces)
    local = share * float(curve.durations[piece])
    return float(curve.knots[piece] + local), curve.motion(piece, local)


def _violation(fault: Fault, scenario: Scenario, uav: int, deed: str, time: float, position: Floats) -> Violation:
    message = f"{scenario.uavs[uav].name} {deed} at t = {time:.6g} s, position {place(position)}."
    return Violation(fault, (uav,), message, time, triple(position))


def _undecided(scenario: Scenario, uav: int, curve: Curve, noun: str, peaks: Peaks) -> Violation:
    known = peaks.stuck[0] >= 0  # else refuted, but for rounding
    spot = (peaks.stuck[0], peaks.stuck_share[0]) if known else (peaks.piece[0], peaks.share[0])
    time, motion = _instant(curve, int(spot[0]), float(spot[1]))
    message = (
        f"{scenario.uavs[uav].name}'s {noun} could not be decided at t = {time:.6g} s, position {place(motion[0])}, "
        f"by cutting pieces in two {int(peaks.halvings[0])} times."
    )
    return Violation(Fault.UNDECIDED, (uav,), message, time, triple(motion[0]))


def _bounds(scenario: Scenario, uav: int, curve: Curve, position: list[Polynomials]) -> Question:
    low, high = scenario.bounds.min, scenario.bounds.max
    beyond = [part * -1.0 + (low[axis] - TOLERANCE) for axis, part in enumerate(position)]
    beyond += [part + -(high[axis] + TOLERANCE) for axis, part in enumerate(position)]
    excess = stack(beyond)
    peaks = greatest(excess.b, excess.error, 0.0, FINE)
    found = None
    if peaks.refuted(0.0)[0]:
        time, motion = _instant(curve, int(peaks.piece[0]), float(peaks.share[0]))
        outside = float(beyond_bounds(scenario, motion[:1])[0])
        if outside > TOLERANCE:
            deed = f"is out of bounds by {outside:.6g} m"
            found = _violation(Fault.TRAJECTORY_BOUNDS, scenario, uav, deed, time, motion[0])
    return "place within the bounds", peaks, found


def _clearance(scenario: Scenario, boxes: Boxes, uav: int, curve: Curve, position: list[Polynomials]) -> Question:
    b = np.stack([part.b for part in position], axis=2)
    error = np.max([part.error for part in position], axis=0)
    near = [np.zeros((0, 2), dtype=np.intp), *_near(boxes, b, error)]
    piece, box = np.concatenate(near).T

    def depth(part: Floats, pair: Ints) -> Floats:
        """Return how deep parts of pieces may be inside a box: what is not, is on one side of it along some axis."""
        low, high = boxes.shut_low[box[pair]], boxes.shut_high[box[pair]]
        deep: Floats = np.minimum(part.max(axis=1) - low, high - part.min(axis=1)).min(axis=1)
        return deep

    # the last term: rounding where a box's face is subtracted
    peaks = greatest(b[piece], error[piece] + _face_error(boxes), 0.0, FINE, depth)
    found = None
    if peaks.refuted(0.0)[0]:
        pair = int(peaks.piece[0])
        time, motion = _instant(curve, int(piece[pair]), float(peaks.share[0]))
        k = int(box[pair])
        if np.all((motion[0] > boxes.shut_low[k]) & (motion[0] < boxes.shut_high[k])):
            gap = float(np.maximum(boxes.low[k] - motion[0], motion[0] - boxes.high[k]).max())
            met = Closest(gap, k, int(piece[pair]), float(peaks.share[0]), motion[0])
            message = met.sentence(scenario.uavs[uav].name, f"at t = {time:.6g} s", scenario.clearance)
            found = Violation(Fault.TRAJECTORY_CLEARANCE, (uav,), message, time, triple(motion[0]))
    # from pairs back to pieces, for whoever asks where
    stuck = np.where(peaks.stuck >= 0, piece[peaks.stuck] if len(piece) else -1, -1)
    spot = piece[peaks.piece] if len(piece) else peaks.piece
    return "clearance", peaks._replace(piece=spot, stuck=stuck), found


def _near(boxes: Boxes, b: Floats, error: Floats) -> Iterator[Ints]:
    """Yield (pairs, 2) indices of pieces and boxes that may meet: those whose hulls do."""
    low, high = b.min(axis=1) - error[:, None], b.max(axis=1) + error[:, None]
    reach = _face_error(boxes)
    at_once = max(1, 1_000_000 // len(b))
    for first in range(0, len(boxes.low), at_once):
        these = slice(first, first + at_once)
        apart = np.zeros((len(b), len(boxes.low[these])), dtype=bool)
        for axis in range(3):
            apart |= low[:, None, axis] >= boxes.shut_high[None, these, axis] + reach
            apart |= high[:, None, axis] <= boxes.shut_low[None, these, axis] - reach
        piece, box = np.nonzero(~apart)
        yield np.column_stack([piece, box + first])


def _face_error(boxes: Boxes) -> float:
    return float(np.abs([boxes.shut_low, boxes.shut_high]).max(initial=0.0)) * 4e-16
