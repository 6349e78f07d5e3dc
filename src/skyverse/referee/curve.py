"""A trajectory as the referee sees it: whether it has a shape, where it begins and ends, whether it jumps."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.boxes import TOLERANCE, array, place, triple

LATEST = 1e9  # seconds
HIGHEST = 30  # degree
ROUNDING = 8 * float(np.finfo(np.float64).eps)
SMOOTH = ("smooth", "slowed", "straightened")


class Curve(NamedTuple):
    """A trajectory that can be evaluated: (n + 1,) knots and (n, degree + 1, 3) pieces."""

    knots: Floats
    pieces: Floats

    @property
    def durations(self) -> Floats:
        """(n,) seconds."""
        return np.diff(self.knots)

    def motions(self, pieces: Indices, local: Floats) -> Floats:
        """Return position, velocity, acceleration and jerk, (m, 4, 3), `local` (m,) seconds after knots."""
        rows, motions = self.pieces[pieces], []
        for _ in range(4):
            value = np.zeros((len(rows), 3))
            for power in range(rows.shape[1] - 1, -1, -1):
                value = value * local[:, None] + rows[:, power]
            motions.append(value)
            rows = derivative(rows)
        return np.stack(motions, axis=1)

    def motion(self, piece: int, local: float) -> Floats:
        """Return the same at one instant, (4, 3)."""
        motion: Floats = self.motions(np.array([piece]), np.array([local]))[0]
        return motion


def derivative(pieces: Floats) -> Floats:
    """Return the derivatives of (n, degree + 1, 3) pieces; of a constant, that of degree 0."""
    if pieces.shape[1] == 1:
        return np.zeros_like(pieces)
    slopes: Floats = pieces[:, 1:] * np.arange(1, pieces.shape[1])[:, None]
    return slopes


def curve_of(trajectory: Trajectory) -> Curve | str:
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
    if knots[-1] > LATEST or pieces.shape[1] > HIGHEST + 1:
        return (
            f"is too long or too wild to judge: it ends at t = {knots[-1]:.6g} s (of {LATEST:.6g}), "
            f"and its degree is {pieces.shape[1] - 1} (of {HIGHEST})"
        )
    return Curve(knots, pieces)


def judge_ends(scenario: Scenario, uav: int, target: int | None, curve: Curve) -> Iterator[Violation]:
    """Yield what is wrong with where a trajectory starts and ends, and how."""
    vehicle, (knots, pieces) = scenario.uavs[uav], curve
    ends = [("starts", knots[0], curve.motion(0, 0.0), vehicle.start)]
    if target is not None:
        last = curve.motion(len(pieces) - 1, curve.durations[-1])
        ends.append(("ends", knots[-1], last, scenario.targets[target].position))
    for verb, time, motion, due in ends:
        miss, speed, acceleration = np.linalg.norm(motion[:3] - [due, np.zeros(3), np.zeros(3)], axis=1)
        rests = vehicle.fixed_wing is not None or (speed <= TOLERANCE and acceleration <= TOLERANCE)
        if not (miss <= TOLERANCE and rests):
            must = "there" if vehicle.fixed_wing is not None else "there at rest"
            message = (
                f"{vehicle.name}'s trajectory {verb} at t = {time:.6g} s, position {place(motion[0])}, "
                f"with {speed:.6g} m/s and {acceleration:.6g} m/s^2, {miss:.6g} m from {place(np.array(due))}; "
                f"it must be {must}."
            )
            yield Violation(Fault.TRAJECTORY_ENDS, (uav,), message, float(time), triple(motion[0]))
            return


def judge_continuity(vehicle: UAV, uav: int, curve: Curve, form: object) -> Iterator[Violation]:
    """Yield the worst jump: of position and velocity, of multirotors' acceleration, of smooth forms' jerk."""
    knots, pieces = curve
    if len(pieces) < 2:
        return
    kinds = 2 if vehicle.fixed_wing is not None else 4 if isinstance(form, str) and form in SMOOTH else 3
    each = np.arange(len(pieces))
    before, after = curve.motions(each[:-1], curve.durations[:-1]), curve.motions(each[1:], np.zeros(len(each) - 1))
    jumps = np.linalg.norm(before - after, axis=2)[:, :kinds]
    sizes = np.linalg.norm(after, axis=2)[:, :kinds]
    let_pass = TOLERANCE * np.maximum(1.0, sizes)
    let_pass[:, 0] = TOLERANCE + ROUNDING * sizes[:, 0]  # a jump through a wall is one however far from zero
    k = int(np.argmax((jumps / let_pass).max(axis=1)))
    if not (jumps[k] <= let_pass[k]).all():
        numbers = [f"{jump:.6g} {unit}" for jump, unit in zip(jumps[k], ("m", "m/s", "m/s^2", "m/s^3"), strict=False)]
        message = (
            f"{vehicle.name}'s trajectory jumps by {', '.join(numbers[:-1])} and {numbers[-1]} "
            f"at t = {knots[k + 1]:.6g} s, position {place(after[k, 0])}."
        )
        yield Violation(Fault.CONTINUITY, (uav,), message, float(knots[k + 1]), triple(after[k, 0]))
