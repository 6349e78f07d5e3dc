"""The first guess of a spline through a corridor: control points strictly within their bounds."""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import kernel
from skyverse.trajectory.newton_equations import FIXED
from skyverse.trajectory.spline import DEGREE

FACE_SHARE = 0.45
"""The share of a box's width that a point keeps from either face at most."""
FACE_MARGIN = 0.02
"""Metres that a point keeps from either face otherwise."""
OVERLAP_MARGIN = 0.3
"""The same where two boxes overlap."""
LEG_SAMPLES = 21
"""Points of each leg of the path that are compared."""
FIRST_DURATION = 0.1
"""Seconds of each span."""


@kernel
def control_point_bounds(boxes: Floats, box_of: Ints) -> tuple[Floats, Floats]:
    """Return low and high bounds (N, 3) of each control point: it lies in the boxes of all spans that it influences."""
    n = len(box_of) + DEGREE
    low, high = np.full((n, 3), -np.inf), np.full((n, 3), np.inf)
    for k in range(len(box_of)):
        for i in range(k, k + DEGREE + 1):
            for a in range(3):
                low[i, a] = max(low[i, a], boxes[box_of[k], a])
                high[i, a] = min(high[i, a], boxes[box_of[k], a + 3])
    return low, high


def first_guess(path: Floats, low: Floats, high: Floats, box_of: Ints) -> tuple[Floats, Floats]:
    """Return control points strictly within their bounds, (N, 3) metres, and equal durations (S,) of the spans.

    Where two boxes overlap the points coincide, near the path but away from the faces; in between they are spaced
    evenly on a straight line.
    """
    n, s = len(low), len(box_of)
    passes = np.flatnonzero(np.diff(box_of)) + 1  # the first of the control points that lie in two boxes
    within = [_nearest_inside(path, low[k], high[k]) for k in passes]
    stops = np.r_[FIXED - 1, np.ravel(np.column_stack([passes, passes + DEGREE - 1])), s]
    at = np.vstack([path[:1], np.repeat(np.reshape(within, (-1, 3)), 2, axis=0), path[-1:]])
    points = np.column_stack([np.interp(np.arange(n), stops, at[:, a]) for a in range(3)])
    free = slice(FIXED, n - FIXED)
    margin = np.minimum(FACE_SHARE * (high - low)[free], FACE_MARGIN)
    points[free] = np.clip(points[free], low[free] + margin, high[free] - margin)
    return points, np.full(s, FIRST_DURATION)


def _nearest_inside(path: Floats, low: Floats, high: Floats) -> Floats:
    """Return a point of a box, away from its faces, that is about the nearest to a path."""
    shares = np.linspace(0.0, 1.0, LEG_SAMPLES)[:, None, None]
    on_path = ((1.0 - shares) * path[:-1] + shares * path[1:]).reshape(-1, 3)
    margin = np.minimum(FACE_SHARE * (high - low), OVERLAP_MARGIN)
    inside = np.clip(on_path, low + margin, high - margin)
    return inside[np.argmin(np.sum((inside - on_path) ** 2, axis=1))]
