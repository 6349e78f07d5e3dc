"""How fast a stated motion ever is, and how hard it ever accelerates."""

import math
from functools import lru_cache

import numpy as np

from skyverse._typing import Floats
from skyverse.model.mover_motions import CircularMotion, MoverMotion, PeriodicMotion, PolynomialMotion, WaypointMotion

SAMPLES = 4097
"""Instants of a period at which a closed curve is looked at."""
SAME_VELOCITY = 1e-9
"""M/s by which the velocities on both sides of a knot may differ because of rounding."""


@lru_cache(maxsize=256)
def motion_bounds(motion: MoverMotion) -> tuple[float, float | None]:
    """Return bounds of a motion's speed and acceleration at all instants.

    Returns
    -------
    tuple
        M/s and m/s^2 that are not exceeded; ``None`` for the acceleration where the velocity changes in an instant.
    """
    match motion:
        case CircularMotion():
            return _of_closed_curve(motion.as_periodic)
        case PeriodicMotion():
            return _of_closed_curve(motion)
        case WaypointMotion():
            steps = np.diff(np.array(motion.points), axis=0)
            speeds = np.linalg.norm(steps, axis=1) / np.diff(np.array(motion.times))
            fastest = float(speeds.max(initial=0.0))
            return fastest, 0.0 if fastest == 0.0 else None
        case PolynomialMotion():
            return _of_polynomials(motion)


def _of_closed_curve(motion: PeriodicMotion) -> tuple[float, float]:
    """Return the bounds of a closed curve: the largest values at samples, and what they can change by in between."""
    cosine, sine = np.array(motion.cosine), np.array(motion.sine)
    squares, mixed = (np.sum(cosine**2, axis=1), np.sum(sine**2, axis=1)), np.sum(cosine * sine, axis=1)
    # of each ellipse the larger semi-axis: the norm of the two vectors that span it, as a matrix
    sizes = np.sqrt((squares[0] + squares[1]) / 2 + np.hypot((squares[0] - squares[1]) / 2, mixed))
    rates = 2.0 * math.pi * np.arange(1, len(sizes) + 1) / motion.period
    if len(sizes) == 1:
        return float(np.sum(sizes * rates)), float(np.sum(sizes * rates**2))
    angles = np.linspace(0.0, 2.0 * math.pi, SAMPLES)[:, None] * np.arange(1, len(sizes) + 1)
    half = 0.5 * motion.period / (SAMPLES - 1)
    c, s = np.cos(angles), np.sin(angles)
    velocity = np.einsum("ij,jk->ik", c * rates, sine) - np.einsum("ij,jk->ik", s * rates, cosine)
    acceleration = -np.einsum("ij,jk->ik", c * rates**2, cosine) - np.einsum("ij,jk->ik", s * rates**2, sine)
    fastest = np.linalg.norm(velocity, axis=1).max() + half * float(np.sum(sizes * rates**2))
    hardest = np.linalg.norm(acceleration, axis=1).max() + half * float(np.sum(sizes * rates**3))
    return float(fastest), float(hardest)


def _of_polynomials(motion: PolynomialMotion) -> tuple[float, float | None]:
    seconds, fastest, hardest = np.diff(np.array(motion.knots)), 0.0, 0.0
    before, jumps = np.zeros(3), False  # it stands before its first knot
    for given, lasts in zip(motion.coefficients, seconds, strict=True):
        rows: Floats = np.array(given)
        velocity: Floats = rows[1:] * np.arange(1, len(rows))[:, None]
        acceleration: Floats = velocity[1:] * np.arange(1, len(velocity))[:, None]
        fastest = max(fastest, _largest(velocity, lasts))
        hardest = max(hardest, _largest(acceleration, lasts))
        begins = velocity[0] if len(velocity) else np.zeros(3)
        jumps = jumps or bool(np.abs(begins - before).max() > SAME_VELOCITY)
        before = np.array([_value(velocity[:, axis], lasts) for axis in range(3)])
    jumps = jumps or bool(np.abs(before).max() > SAME_VELOCITY)  # it stands after its last knot
    return fastest, None if jumps else hardest


def _largest(rows: Floats, lasts: float) -> float:
    """Return a bound of the norm of a polynomial (k, 3) between 0 and `lasts` seconds."""
    return float(np.sum(np.linalg.norm(rows, axis=1) * np.vander([lasts], len(rows), increasing=True)[0]))


def _value(row: Floats, t: float) -> float:
    return float(np.sum(row * np.vander([t], len(row), increasing=True)[0]))
