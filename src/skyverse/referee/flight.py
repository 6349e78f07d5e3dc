"""Judges trajectories, one by one and against each other."""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from skyverse.referee.boxes import TOLERANCE, Boxes, Floats, array, beyond_bounds, deepest, place, triple
from skyverse.result import Fault, Trajectory, Violation
from skyverse.scenario import Scenario

LONGEST_CHORD = 0.005  # seconds
DEVIATION = 1e-6  # metres that a curve may bend away from its chord
MOST_CHORDS = 1_000_000  # of a piece, and a tenth of a trajectory's: what memory and patience allow
TICK = 0.01  # seconds between the instants at which separations are first looked at
LATEST = 1e9  # seconds


class Curve(NamedTuple):
    """A trajectory that can be evaluated: (n + 1,) knots and (n, degree + 1, 3) pieces."""

    knots: Floats
    pieces: Floats


def judge_trajectory(
    scenario: Scenario, boxes: Boxes, uav: int, target: int | None, trajectory: Trajectory
) -> tuple[list[Violation], Curve | None]:
    """Return what is wrong with UAV number `uav`'s trajectory, and its curve where it has a sound one."""
    curve = _curve(trajectory)
    if isinstance(curve, str):
        message = f"{scenario.uavs[uav].name}'s trajectory {curve}."
        return [Violation(Fault.TRAJECTORY_SHAPE, (uav,), message)], None
    violations = [*_judge_ends(scenario, uav, target, curve), *_judge_continuity(scenario, uav, curve)]
    worst: dict[Fault, tuple[float, Violation]] = {}
    for begin, duration, piece in zip(curve.knots[:-1], np.diff(curve.knots), curve.pieces, strict=True):
        for excess, violation in _judge_piece(scenario, boxes, uav, begin, duration, piece):
            if violation.fault not in worst or excess > worst[violation.fault][0]:
                worst[violation.fault] = excess, violation
    return violations + [violation for _, violation in worst.values()], curve


def _curve(trajectory: Trajectory) -> Curve | str:
    """Return the curve, or why there is none to judge."""
    knots, pieces = array(trajectory.knots), array(trajectory.coefficients)
    if knots is None or pieces is None:
        return "must have numbers for knots and coefficients"
    if knots.ndim != 1 or len(knots) < 2:
        return f"must have two knots or more, but they have shape {knots.shape}"
    if pieces.ndim != 3 or len(pieces) != len(knots) - 1 or pieces.shape[1] < 1 or pieces.shape[2] != 3:
        return f"must have coefficients of shape ({len(knots) - 1}, degree + 1, 3), but has {pieces.shape}"
    if not np.isfinite(knots).all() or not np.isfinite(pieces).all():
        return "has knots or coefficients that are not finite"
    if not (np.diff(knots) > 0).all():
        k = int(np.argmin(np.diff(knots) > 0))
        return f"has knots that do not rise: {knots[k]:.9g} s, then {knots[k + 1]:.9g} s"
    if knots[0] < 0:
        return f"starts at t = {knots[0]:.6g} s, before the mission does"
    polynomials = list(zip(pieces, np.diff(knots), strict=True))
    reach = sum(_largest(piece, duration) for piece, duration in polynomials)
    chords = np.array([_chords(piece, duration) for piece, duration in polynomials])
    judgeable = chords.max() <= MOST_CHORDS and chords.sum() <= 10 * MOST_CHORDS
    if knots[-1] > LATEST or not np.isfinite(reach) or not judgeable:
        needs = f"{chords.sum():.3g} chords"
        return f"is too long or too wild to judge: it ends at t = {knots[-1]:.6g} s and needs {needs}"
    return Curve(knots, pieces)


def _values(piece: Floats, t: Floats) -> Floats:
    """Evaluate a polynomial, (degree + 1, 3), at (m,) seconds since its knot: (m, 3), by Horner's scheme."""
    value = np.zeros((len(t), 3))
    for row in piece[::-1]:
        value = value * t[:, None] + row
    return value


def _derivative(piece: Floats) -> Floats:
    if len(piece) == 1:
        return np.zeros((1, 3))
    slope: Floats = piece[1:] * np.arange(1, len(piece))[:, None]
    return slope


def _largest(piece: Floats, duration: float) -> float:
    """Return a crude upper bound on a polynomial's norm on [0, duration]: the sum of its terms' norms."""
    return float(np.sum(np.linalg.norm(piece, axis=1) * duration ** np.arange(len(piece))))


def _hardest(piece: Floats, duration: float) -> float:
    """Return a bound on a piece's acceleration, m/s^2: what 65 instants show, plus what jerk adds between."""
    acceleration = _derivative(_derivative(piece))
    shown = np.linalg.norm(_values(acceleration, np.linspace(0, duration, 65)), axis=1).max()
    return float(shown + duration / 64 / 2 * _largest(_derivative(acceleration), duration))


def _chords(piece: Floats, duration: float) -> float:
    """Return how many chords keep to the curve; one of h seconds is off by acceleration * h**2 / 8."""
    bend = duration * np.sqrt(_hardest(piece, duration) / (8 * DEVIATION))
    return float(np.max([64.0, np.ceil(duration / LONGEST_CHORD), np.ceil(bend)]))


def _judge_ends(scenario: Scenario, uav: int, target: int | None, curve: Curve) -> Iterator[Violation]:
    name, (knots, pieces) = scenario.uavs[uav].name, curve
    ends = [("starts", knots[0], pieces[0], 0.0, scenario.uavs[uav].start)]
    if target is not None:
        ends.append(("ends", knots[-1], pieces[-1], knots[-1] - knots[-2], scenario.targets[target].position))
    for verb, time, piece, local, due in ends:
        at = np.array([local])
        position, velocity = _values(piece, at)[0], _values(_derivative(piece), at)[0]
        miss, speed = float(np.linalg.norm(position - np.array(due))), float(np.linalg.norm(velocity))
        if not (miss <= TOLERANCE and speed <= TOLERANCE):
            message = (
                f"{name}'s trajectory {verb} at t = {time:.6g} s, position {place(position)}, "
                f"with {speed:.6g} m/s, {miss:.6g} m from {place(np.array(due))}; it must be there at rest."
            )
            yield Violation(Fault.TRAJECTORY_ENDS, (uav,), message, float(time), triple(position))
            return


def _judge_continuity(scenario: Scenario, uav: int, curve: Curve) -> Iterator[Violation]:
    knots, pieces = curve
    if len(pieces) < 2:
        return
    jumps = []
    for before, after, duration in zip(pieces[:-1], pieces[1:], np.diff(knots), strict=False):
        end, start = np.array([duration]), np.array([0.0])
        leap = _values(before, end) - _values(after, start)
        kick = _values(_derivative(before), end) - _values(_derivative(after), start)
        jumps.append((np.linalg.norm(leap), np.linalg.norm(kick)))
    k = int(np.argmax(np.max(jumps, axis=1)))
    leap_m, leap_m_s = jumps[k]
    if not max(leap_m, leap_m_s) <= TOLERANCE:
        name, position, time = scenario.uavs[uav].name, pieces[k + 1, 0], float(knots[k + 1])
        message = (
            f"{name}'s trajectory jumps by {leap_m:.6g} m and {leap_m_s:.6g} m/s at t = {time:.6g} s, "
            f"position {place(position)}."
        )
        yield Violation(Fault.CONTINUITY, (uav,), message, time, triple(position))


def _judge_piece(
    scenario: Scenario, boxes: Boxes, uav: int, begin: float, duration: float, piece: Floats
) -> Iterator[tuple[float, Violation]]:
    """Yield what is wrong within one piece, each with how wrong it is."""
    vehicle = scenario.uavs[uav]
    local = np.linspace(0, duration, int(_chords(piece, duration)) + 1)
    position = _values(piece, local)
    velocity = _derivative(piece)
    speed = np.linalg.norm(_values(velocity, local), axis=1)
    acceleration = np.linalg.norm(_values(_derivative(velocity), local), axis=1)
    outside = beyond_bounds(scenario, position)
    top_speed, top_acceleration = vehicle.max_speed, vehicle.max_acceleration
    sampled = [
        (Fault.TRAJECTORY_BOUNDS, outside, TOLERANCE, "is out of bounds by {:.6g} m"),
        (Fault.SPEED, speed, top_speed * (1 + 1e-6), f"flies {{:.7g}} m/s (of {top_speed:.7g})"),
        (
            Fault.ACCELERATION,
            acceleration,
            top_acceleration * (1 + 1e-6),
            f"accelerates by {{:.7g}} m/s^2 (of {top_acceleration:.7g})",
        ),
    ]
    for fault, values, limit, deed in sampled:
        k = int(np.argmax(values))
        if not values[k] <= limit:
            time, what = float(begin + local[k]), deed.format(values[k])
            message = f"{vehicle.name} {what} at t = {time:.6g} s, position {place(position[k])}."
            yield float(values[k]), Violation(fault, (uav,), message, time, triple(position[k]))
    met = deepest(boxes, position[:-1], position[1:])
    if met is not None:
        time = float(begin + local[met.segment] + met.fraction * (local[1] - local[0]))
        message = met.sentence(vehicle.name, f"at t = {time:.6g} s", scenario.clearance)
        violation = Violation(Fault.TRAJECTORY_CLEARANCE, (uav,), message, time, triple(met.position))
        yield -met.gap, violation


def judge_separation(scenario: Scenario, curves: Sequence[Curve | None], unknown: set[int]) -> list[Violation]:
    """Return every pair of UAVs that comes too close.

    UAVs without a trajectory stay parked at their start; the `unknown` have a misshapen one and are left out.
    """
    known = [uav for uav in range(len(scenario.uavs)) if uav not in unknown]
    hardest = {uav: _hardest_of(curves[uav]) for uav in known}
    closest: dict[tuple[int, int], tuple[float, float]] = {}
    for times in _windows(curves):
        positions = {uav: _positions(scenario, uav, curves[uav], times) for uav in known}
        for i, j in combinations(known, 2):
            required = max(scenario.uavs[i].separation, scenario.uavs[j].separation)
            apart, _ = _nearest(positions[i] - positions[j])
            # Between two instants both may bend away from their chords: look closer where that could matter.
            bend = (hardest[i] + hardest[j]) * TICK**2 / 8
            doubtful = np.flatnonzero(apart < required + bend)
            if not len(doubtful):
                continue
            share = np.linspace(0, 1, 101)
            fine = times[doubtful, None] + share * np.diff(times)[doubtful, None]
            first, second = (_positions(scenario, uav, curves[uav], fine.ravel()) for uav in (i, j))
            apart, fraction = _nearest((first - second).reshape(len(doubtful), len(share), 3))
            row, k = np.unravel_index(np.argmin(apart), apart.shape)
            time = fine[row, k] + fraction[row, k] * (fine[row, k + 1] - fine[row, k])
            if apart[row, k] < min(required - TOLERANCE, closest.get((i, j), (np.inf, 0.0))[0]):
                closest[i, j] = float(apart[row, k]), float(time)
    return [_too_close(scenario, curves, pair, *closest[pair]) for pair in sorted(closest)]


def _too_close(
    scenario: Scenario, curves: Sequence[Curve | None], pair: tuple[int, int], apart: float, time: float
) -> Violation:
    i, j = pair
    first, second = scenario.uavs[i], scenario.uavs[j]
    middle = sum(_positions(scenario, uav, curves[uav], np.array([time]))[0] for uav in pair) / 2
    deed = f"come within {apart:.6g} m of each other"
    if time == 0:
        deed = f"are {apart:.6g} m apart already at the start,"
    message = (
        f"{first.name} and {second.name} {deed} at t = {time:.6g} s, around {place(middle)}; "
        f"{max(first.separation, second.separation):.6g} m are required."
    )
    return Violation(Fault.SEPARATION, pair, message, time, triple(middle))


def _hardest_of(curve: Curve | None) -> float:
    if curve is None:
        return 0.0
    return max(_hardest(piece, length) for piece, length in zip(curve.pieces, np.diff(curve.knots), strict=True))


def _windows(curves: Sequence[Curve | None]) -> Iterator[Floats]:
    """Yield instants, a tick apart while anybody moves, in windows that fit in memory and overlap by one."""
    spans = [np.arange(2.0)]
    spans += [
        np.arange(np.floor(curve.knots[0] / TICK), np.ceil(curve.knots[-1] / TICK) + 1)
        for curve in curves
        if curve is not None
    ]
    ticks = np.unique(np.concatenate(spans))
    for first in range(0, len(ticks) - 1, 5000):
        yield ticks[first : first + 5001] * TICK


def _positions(scenario: Scenario, uav: int, curve: Curve | None, times: Floats) -> Floats:
    """Return where a UAV is, (m, 3) metres: at its start until it moves, and where it ended from then on."""
    start = np.array(scenario.uavs[uav].start)
    if curve is None:
        return np.broadcast_to(start, (len(times), 3))
    knots, pieces = curve
    clipped = np.clip(times, knots[0], knots[-1])
    piece = np.clip(np.searchsorted(knots, clipped, side="right") - 1, 0, len(pieces) - 1)
    local = (clipped - knots[piece])[:, None]
    value = np.zeros((len(times), 3))
    for power in range(pieces.shape[1] - 1, -1, -1):
        value = value * local + pieces[piece, power]
    return np.where((times < knots[0])[:, None], start, value)


def _nearest(relative: Floats) -> tuple[Floats, Floats]:
    """Return how near to zero each chord of (..., n, 3) relative positions comes, and at which fraction."""
    begin, chord = relative[..., :-1, :], np.diff(relative, axis=-2)
    squared = np.sum(chord**2, axis=-1)
    ahead = -np.sum(begin * chord, axis=-1)
    fraction = np.clip(np.where(squared > 0, ahead / np.where(squared > 0, squared, 1.0), 0.0), 0.0, 1.0)
    apart: Floats = np.linalg.norm(begin + fraction[..., None] * chord, axis=-1)
    return apart, fraction
