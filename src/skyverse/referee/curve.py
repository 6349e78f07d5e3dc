"""A trajectory as polynomial pieces that the referee evaluates itself, or the reason why it cannot be judged."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.trajectory import Trajectory
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
