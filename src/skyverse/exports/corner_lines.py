"""The straight lines by which all ways around a cut corner are judged."""

import math
from collections.abc import Callable

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.autopilots import PX4_ALTITUDE_RADII
from skyverse.exports.leg_segments import Checked
from skyverse.numerics.tolerances import MIN_GROWTH, SAME_PLACE

LINE_HALF_WIDTHS = (0.32, 0.08, 0.02)
"""Metres: half the distance between the lines by which a cut corner is judged, tried from coarse to fine.

With an acceptance radius above `WIDE_CORNER` they grow in proportion, so that a large corner takes no more lines.
"""
WIDE_CORNER = 2.0
"""Metres."""
CLIMB_HALF_WIDTH = 0.001
"""Metres: the same at last where PX4 cuts the end of a climb; with the rounding it is less than legs are allowed."""
LATE_SHARE = 1 / 8
"""The last share of those lines, judged by itself, because the lines converge there."""


def is_straight(cut: Floats, on: Floats) -> bool:
    """Tell whether there is no corner between the ways that may be cut, (2, 3), and the way on, (3,) metres each."""
    long = math.hypot(*on)
    return long == 0 or float(np.linalg.norm(np.cross(cut, on), axis=1).max()) / long < MIN_GROWTH / 10


def search_corner(
    cut: Floats,
    at: Floats,
    after: Floats,
    radius: float,
    slope: float,
    judge: Callable[[Floats, Floats, float], Checked],
) -> Checked:
    """Return what is found of all ways on from a corner that is cut.

    Parameters
    ----------
    cut
        (2, 3) metres: from the corner to where the UAV turns at the earliest, on the leg before, and on the way there
        from where it turned to that.
    at, after
        (3,) metres: the corner, and the next waypoint.
    radius
        The acceptance radius, metres.
    slope
        How many metres higher obstacles may be, at most, for each metre beside a line.
    judge
        Judges lines between (n, 3) and (n, 3) metres, beside which a UAV may be by some metres.
    """
    p, q = cut
    found = Checked(None)
    widths = (np.array(LINE_HALF_WIDTHS) * max(1.0, radius / WIDE_CORNER)).tolist()
    upright = not cut[:, :2].any()
    if upright and np.abs(cut[:, 2]).max() <= min(PX4_ALTITUDE_RADII[1], radius - SAME_PLACE):
        widths.append(CLIMB_HALF_WIDTH)
    for width in widths:
        deep = _middles(max(math.hypot(*p), math.hypot(*q)), width)
        wide = _middles(math.dist(p, q), width)
        sides = ((1 - wide)[:, None] * p + wide[:, None] * q)[None] * deep[:, None, None]
        starts = at + sides.reshape(-1, 3)
        # every possible way is at most this far from one of the lines to `after`, and nearer towards the end
        between = width * (1 if len(wide) == 1 else math.sqrt(2)) * (1 if upright else 1 + slope)
        whole = np.broadcast_to(after, starts.shape)
        hopeless = judge(starts, whole, 0.0)
        if hopeless.fault is not None:
            return hopeless  # the line itself meets something, so finer lines would, too
        late = starts + (1 - LATE_SHARE) * (after - starts)
        early_half = judge(starts, late, between)
        late_half = judge(late, whole, LATE_SHARE * between)
        if early_half.fault is None and late_half.fault is None:
            return Checked(None, (*early_half.clear, *late_half.clear))
        found = early_half if early_half.fault is not None else late_half
    return found


def _middles(length: float, half: float) -> Floats:
    """Return the midpoints, as shares of a length, of the fewest equal parts that are at most 2 * `half` long."""
    count = max(math.ceil(length / (2 * half)), 1)
    return (np.arange(count) + 0.5) / count
