"""Judges a trajectory at every instant: its ends and knots, clearance, bounds, and the limits of the UAV."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.clearance import judge_curve
from skyverse.referee.curve import PolynomialCurve, curve_of, judge_continuity
from skyverse.referee.judgement import Judgement, position_text, position_tuple
from skyverse.referee.limits import FlightLimit, flight_limits, judge_heading
from skyverse.referee.pads import parts_of_flight
from skyverse.referee.polynomial import Polynomials, bernstein, stack
from skyverse.referee.sorties import Tour
from skyverse.referee.speed_zones import judge_zone_speed
from skyverse.referee.subdivision import Peaks, find_peaks
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.tracking_error import EXACT, named
from skyverse.referee.wind import judge_wind
from skyverse.referee.world import RefereeWorld


class _Answer(NamedTuple):
    """One condition at all instants of a curve: its noun, bounds on the excess, and the violation if it is broken."""

    noun: str
    peaks: Peaks
    violation: Violation | None
    curve: PolynomialCurve


def judge_trajectory(world: RefereeWorld, uav: int, tour: Tour, trajectory: Trajectory) -> Judgement:
    """Judge UAV number `uav`'s trajectory along its tour; what is not proven is a violation."""
    vehicle = world.scenario.uavs[uav]
    name = vehicle.name
    curve = curve_of(trajectory)
    if isinstance(curve, str):
        malformed = Violation(Fault.TRAJECTORY_SHAPE, (uav,), f"{name}'s trajectory {curve}.")
        return Judgement([malformed])
    violations = [*_judge_ends(world, uav, tour, curve), *judge_continuity(vehicle, uav, curve)]
    parts = _parts(world, uav, tour, curve)
    positions = [bernstein(part.pieces, part.durations) for _, part in parts]
    safe: list[_Answer] = []
    for (judged_in, part), position in zip(parts, positions, strict=True):
        safe.append(_judge_limit(named(name, judged_in.error), uav, part, _bounds(judged_in, position)))
        safe.append(_judge_clearance(judged_in, uav, part, position))
    answers = safe + [_judge_limit(name, uav, curve, limit) for limit in flight_limits(vehicle, curve)]
    wrong = [answer.violation for answer in answers if answer.violation is not None]
    violations += _one_of_each(wrong)
    undecided = [answer for answer in answers if answer.violation is None and not answer.peaks.proven[0]]
    if undecided:
        violations.append(_undecided(name, uav, undecided[0]))
    violations += judge_heading(vehicle, uav, trajectory.pointing)
    slowed = [judge(world.scenario, uav, curve) for judge in (judge_zone_speed, judge_wind)]
    violations += [violation for judged in slowed for violation in judged.violations]
    halvings = sum(judged.halvings for judged in slowed) + sum(int(answer.peaks.halvings[0]) for answer in answers)
    return Judgement(violations, halvings)


def _parts(
    world: RefereeWorld, uav: int, tour: Tour, curve: PolynomialCurve
) -> list[tuple[RefereeWorld, PolynomialCurve]]:
    """Return the parts of a curve with the worlds in which they are judged: on a pad, that without an error."""
    if world.error == EXACT:
        return [(world, curve)]
    position = bernstein(curve.pieces, curve.durations)
    b, error = np.stack([part.b for part in position], axis=2), np.max([part.error for part in position], axis=0)
    return [
        (judged_in, PolynomialCurve(curve.knots[part.start : part.stop + 1], curve.pieces[part]))
        for judged_in, part in parts_of_flight(world, uav, tour, b, error)
    ]


def _one_of_each(violations: list[Violation]) -> list[Violation]:
    """Return the first violation of each kind: several parts of a trajectory may be wrong in the same way."""
    return list({violation.fault: violation for violation in reversed(violations)}.values())[::-1]


def _bounds(world: RefereeWorld, position: list[Polynomials]) -> FlightLimit:
    """Return the bounds as a limit on a position, measured in metres out of bounds."""
    low, high = world.low, world.high
    beyond = [part * -1.0 + (low[axis] - LET_PASS) for axis, part in enumerate(position)]
    beyond += [part + -(high[axis] + LET_PASS) for axis, part in enumerate(position)]

    def outside(motion: Floats) -> tuple[float, str]:
        metres = float(world.beyond_bounds(motion[:1])[0])
        return metres, f"is out of bounds by {metres:.6g} m"

    return FlightLimit(Fault.TRAJECTORY_BOUNDS, "place within the bounds", stack(beyond), outside, LET_PASS)


def _judge_clearance(world: RefereeWorld, uav: int, curve: PolynomialCurve, position: list[Polynomials]) -> _Answer:
    peaks, incursion = judge_curve(world, curve, position)
    violation = None
    if incursion is not None:
        time = float(curve.knots[incursion.segment] + incursion.fraction * curve.durations[incursion.segment])
        message = incursion.sentence(
            world.scenario, named(world.scenario.uavs[uav].name, world.error), f"at t = {time:.6g} s"
        )
        where = position_tuple(incursion.position)
        violation = Violation(Fault.TRAJECTORY_CLEARANCE, (uav,), message, time, where)
    return _Answer("clearance", peaks, violation, curve)


def _judge_limit(name: str, uav: int, curve: PolynomialCurve, limit: FlightLimit) -> _Answer:
    peaks = find_peaks(limit.excess.b, limit.excess.error)
    violation = None
    if peaks.refuted[0]:
        time, motion = _instant(curve, *peaks.place())
        measured, deed = limit.measure(motion)
        if measured > limit.most:
            message = f"{name} {deed} at t = {time:.6g} s, position {position_text(motion[0])}."
            violation = Violation(limit.fault, (uav,), message, time, position_tuple(motion[0]))
    return _Answer(limit.noun, peaks, violation, curve)


def _instant(curve: PolynomialCurve, row: int, share: float) -> tuple[float, Floats]:
    """Return seconds into the mission, and the motion (4, 3) then, evaluated without Bernstein coefficients.

    `row` counts on beyond the last piece where several polynomials were stacked for each piece.
    """
    piece = row % len(curve.pieces)
    local = share * float(curve.durations[piece])
    return float(curve.knots[piece] + local), curve.motion(piece, local)


def _undecided(name: str, uav: int, answer: _Answer) -> Violation:
    peaks, curve = answer.peaks, answer.curve
    time, motion = _instant(curve, *peaks.place())  # a peak above 0 where the motion, as evaluated, breaks nothing
    message = (
        f"{name}'s {answer.noun} could not be decided at t = {time:.6g} s, position {position_text(motion[0])}, "
        f"by cutting pieces in two {int(peaks.halvings[0])} times."
    )
    return Violation(Fault.UNDECIDED, (uav,), message, time, position_tuple(motion[0]))


def _judge_ends(world: RefereeWorld, uav: int, tour: Tour, curve: PolynomialCurve) -> Iterator[Violation]:
    """Yield the first end of a trajectory at which the UAV is not where it must be, or not at rest."""
    scenario, (knots, pieces) = world.scenario, curve
    vehicle = scenario.uavs[uav]
    ends = [("starts", knots[0], curve.motion(0, 0.0), vehicle.start)]
    if tour.end is not None:
        last = curve.motion(len(pieces) - 1, curve.durations[-1])
        ends.append(("ends", knots[-1], last, tour.end))
    for verb, time, motion, due in ends:
        miss, speed, acceleration = np.linalg.norm(motion[:3] - [due, np.zeros(3), np.zeros(3)], axis=1)
        rests = vehicle.fixed_wing is not None or (speed <= LET_PASS and acceleration <= LET_PASS)
        if not (miss <= LET_PASS and rests):
            must = "there" if vehicle.fixed_wing is not None else "there at rest"
            message = (
                f"{vehicle.name}'s trajectory {verb} at t = {time:.6g} s, position {position_text(motion[0])}, "
                f"with {speed:.6g} m/s and {acceleration:.6g} m/s^2, {miss:.6g} m from {position_text(np.array(due))}; "
                f"it must be {must}."
            )
            yield Violation(Fault.TRAJECTORY_ENDS, (uav,), message, float(time), position_tuple(motion[0]))
            return
