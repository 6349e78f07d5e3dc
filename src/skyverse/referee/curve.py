"""Trajectories as curves, and whether they jump: whether their pieces join in position, velocity and acceleration."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.judgement import position_text, position_tuple
from skyverse.referee.tolerances import JUMP_ROUNDING, LET_PASS, LIMIT_LET_PASS, MACHINE_EPSILON
from skyverse.referee.untrusted import float_array

MAX_END = 1e9
"""Seconds: a trajectory that ends later is not judged."""
MAX_DEGREE = 30
"""The highest degree of a trajectory that is judged."""


class PolynomialCurve(NamedTuple):
    """A trajectory that can be evaluated: (n + 1,) knots in seconds and (n, degree + 1, 3) pieces in metres."""

    knots: Floats
    pieces: Floats

    @property
    def durations(self) -> Floats:
        """The durations of the pieces, (n,) seconds."""
        return np.diff(self.knots)

    def motions(self, pieces: Indices, local: Floats) -> Floats:
        """Return position, velocity, acceleration and jerk, (m, 4, 3), `local` (m,) seconds into pieces (m,)."""
        rows, motions = self.pieces[pieces], []
        for _ in range(4):
            value = np.zeros((len(rows), 3))
            for power in range(rows.shape[1] - 1, -1, -1):
                value = value * local[:, None] + rows[:, power]
            motions.append(value)
            rows = derivative(rows)
        return np.stack(motions, axis=1)

    def motion(self, piece: int, local: float) -> Floats:
        """Return position, velocity, acceleration and jerk, (4, 3), `local` seconds into one piece."""
        return self.motions(np.array([piece]), np.array([local]))[0]

    def at(self, time: float) -> Floats:
        """Return position, velocity, acceleration and jerk, (4, 3), at an instant of the curve, seconds."""
        piece = min(max(int(np.searchsorted(self.knots, time, side="right")) - 1, 0), len(self.pieces) - 1)
        return self.motion(piece, time - float(self.knots[piece]))


def derivative(pieces: Floats) -> Floats:
    """Return the derivatives of (n, degree + 1, 3) pieces; that of a constant is a zero of degree 0."""
    if pieces.shape[1] == 1:
        return np.zeros_like(pieces)
    return pieces[:, 1:] * np.arange(1, pieces.shape[1])[:, None]


def curve_of(trajectory: Trajectory) -> PolynomialCurve | str:
    """Return a trajectory as a curve, or in words why there is none to judge."""
    knots, pieces = float_array(trajectory.knots), float_array(trajectory.coefficients)
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
    if knots[-1] > MAX_END or pieces.shape[1] > MAX_DEGREE + 1:
        return (
            f"is too long or too wild to judge: it ends at t = {knots[-1]:.6g} s (of {MAX_END:.6g}), "
            f"and its degree is {pieces.shape[1] - 1} (of {MAX_DEGREE})"
        )
    return PolynomialCurve(knots, pieces)


UNITS = ("m", "m/s", "m/s^2")
"""Of jumps in position, velocity and acceleration."""


def judge_continuity(vehicle: UAV, uav: int, curve: PolynomialCurve) -> Iterator[Violation]:
    """Yield the jumps of a curve where they add up to more than one trajectory may jump in all.

    Position and velocity may not jump, and the acceleration of a multirotor may not either. Of all the jumps of one
    kind in a trajectory, `LET_PASS` in sum is let pass. What rounding may add at each knot is not counted; it is no
    more than a small share of the way that the UAV may make in the piece before the knot, so that even endlessly many
    short pieces cannot carry it faster than its limits allow.
    """
    if len(curve.pieces) < 2:
        return
    kinds = 2 if vehicle.fixed_wing is not None else 3
    before, error = ends_of_pieces(curve)
    each = np.arange(1, len(curve.pieces))
    after = curve.motions(each, np.zeros(len(each)))
    jumps = np.linalg.norm(before - after[:, :3], axis=2)[:, :kinds]
    beyond_rounding, error = jumps - _rounding(vehicle, curve, after)[:, :kinds], error[:, :kinds]
    least, most = (np.maximum(some, 0.0).sum(axis=0) for some in (beyond_rounding - error, beyond_rounding + error))
    if (most <= LET_PASS).all():
        return
    k = int(np.argmax(np.nan_to_num(beyond_rounding + error, nan=np.inf).max(axis=1)))
    time, position = float(curve.knots[k + 1]), after[k, 0]
    there = f"at t = {time:.6g} s, position {position_text(position)}"
    if (least <= LET_PASS).all():
        message = f"Whether {vehicle.name}'s trajectory jumps could not be decided {there}, because of rounding."
        yield Violation(Fault.UNDECIDED, (uav,), message, time, position_tuple(position))
        return
    message = (
        f"{vehicle.name}'s trajectory jumps by {_numbers(jumps[k])} {there}, "
        f"and by {_numbers(jumps.sum(axis=0))} in all; {LET_PASS:g} of each in all is let pass."
    )
    yield Violation(Fault.CONTINUITY, (uav,), message, time, position_tuple(position))


def _numbers(sizes: Floats) -> str:
    numbers = [f"{size:.6g} {unit}" for size, unit in zip(sizes, UNITS, strict=False)]
    return f"{', '.join(numbers[:-1])} and {numbers[-1]}"


def ends_of_pieces(curve: PolynomialCurve) -> tuple[Floats, Floats]:
    """Return the motion at the end of every piece but the last, and bounds on the rounding errors of its evaluation.

    Returns
    -------
    motion
        (n - 1, 3, 3): position, velocity and acceleration.
    error
        (n - 1, 3): bounds on how far each of these is from the motion that the coefficients make.
    """
    each, durations = np.arange(len(curve.pieces) - 1), curve.durations[:-1]
    motion = curve.motions(each, durations)[:, :3]
    rows, errors = curve.pieces[:-1], []
    for _ in range(3):
        power = np.arange(rows.shape[1])
        terms = np.linalg.norm(rows, axis=2) * durations[:, None] ** power
        # Horner's scheme rounds the j-th term 2 j + 1 times, its factors 3 times, and T^j is off by j roundings of T
        errors.append(MACHINE_EPSILON * np.sum((1.5 * power + 2) * terms, axis=1))
        rows = derivative(rows)
    return motion, np.stack(errors, axis=1)


def _rounding(vehicle: UAV, curve: PolynomialCurve, after: Floats) -> Floats:
    """Return what rounding may add to the jumps at each knot, (n - 1, 3).

    The places where two pieces meet, and the knots, are rounded to a few units in their last place. A knot that is
    off by an instant moves the place by the speed times that instant, and likewise the velocity and the acceleration.

    Parameters
    ----------
    vehicle
        The UAV.
    curve
        Its trajectory.
    after
        (n - 1, 4, 3) motion right after each knot.
    """
    sizes = np.linalg.norm(after, axis=2)
    units = JUMP_ROUNDING * (sizes[:, :3] + curve.knots[1:-1, None] * sizes[:, 1:])
    rates = np.array([vehicle.max_speed, vehicle.max_acceleration, vehicle.max_jerk])
    return np.minimum(units, LIMIT_LET_PASS * rates * curve.durations[:-1, None])
