"""A quartic spline as polynomials, one for each span."""

import math

import numpy as np
from scipy.interpolate import BSpline

from skyverse._typing import Floats
from skyverse.numerics.tolerances import JERK_JUMP
from skyverse.trajectory.spline import DEGREE, time_of


def polynomial_pieces(points: Floats, spans: Floats) -> tuple[Floats, Floats]:
    """Return the knots (S + 1,) of a spline, seconds, and the coefficients (S, 5, 3) of its pieces.

    A piece is a polynomial of the time since its first knot.

    Parameters
    ----------
    points
        (S + 4, 3) control points.
    spans
        (S,) seconds.
    """
    knots = np.r_[0.0, np.cumsum(spans)]
    lasting = np.diff(knots)[:, None]
    spline = BSpline(np.r_[[0.0] * DEGREE, knots, [knots[-1]] * DEGREE], points, DEGREE)
    rows = np.stack([spline(knots[:-1], nu=j) / math.factorial(j) for j in range(DEGREE + 1)], axis=1)
    jumps = 6.0 * (rows[:-1, 3] + 4.0 * lasting[:-1] * rows[:-1, 4] - rows[1:, 3])
    if np.any(np.abs(jumps) > JERK_JUMP):  # far from 0, in short spans: share one jerk at each knot
        jerk = points
        for k in range(1, DEGREE):
            times = np.array([time_of(spans, i - DEGREE + k, i) for i in range(len(jerk) - 1)])
            jerk = (DEGREE + 1 - k) * np.diff(jerk, axis=0) / times[:, None]
        rows[:, 3], rows[:, 4] = jerk[:-1] / 6.0, np.diff(jerk, axis=0) / lasting / 24.0
    return knots, rows
