"""Judges a trajectory at every instant: clearance, bounds, and what the UAV can do."""

from typing import NamedTuple

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.boxes import TOLERANCE, beyond_bounds, place, triple
from skyverse.referee.clearance import FINE, Space, judge_curve
from skyverse.referee.curve import Curve, curve_of, judge_continuity, judge_ends
from skyverse.referee.limits import FORGIVEN, limits
from skyverse.referee.polynomial import Peaks, Polynomials, bernstein, greatest, stack


class Judged(NamedTuple):
    """A trajectory's violations, how often pieces were cut in two, and its curve where it has a sound one."""

    violations: list[Violation]
    halvings: int
    curve: Curve | None


def judge_trajectory(scenario: Scenario, space: Space, uav: int, target: int | None, trajectory: Trajectory) -> Judged:
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
    questions = [_bounds(scenario, uav, curve, position), _clearance(scenario, space, uav, curve, position)]
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


def _clearance(scenario: Scenario, space: Space, uav: int, curve: Curve, position: list[Polynomials]) -> Question:
    peaks, met = judge_curve(scenario, space, curve, position)
    found = None
    if met is not None:
        time = float(curve.knots[met.segment] + met.fraction * curve.durations[met.segment])
        message = met.sentence(scenario.uavs[uav].name, f"at t = {time:.6g} s", scenario)
        found = Violation(Fault.TRAJECTORY_CLEARANCE, (uav,), message, time, triple(met.position))
    return "clearance", peaks, found
