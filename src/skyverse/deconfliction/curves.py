"""Trajectories as arrays for kernels: the Bernstein pieces of many curves, one curve after another.

The time along a curve is counted in seconds from the curve's own beginning; this is called its local time.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.arrays import put
from skyverse.numerics.bernstein import part, to_bernstein
from skyverse.numerics.kernel import by_reference, inner, kernel


@by_reference
class Curves(NamedTuple):
    """Many curves, each a sequence of polynomial pieces.

    Attributes
    ----------
    first
        (n + 1,) index of the first piece of each curve; the last entry is the number of pieces.
    begin, duration
        (p,) local time at which each piece begins, and how long it lasts, seconds.
    rows
        (p, degree + 1, 3) Bernstein coefficients of each piece, metres.
    low, high
        (p, 3) corners of the bounding box of each piece's coefficients, metres.
    """

    first: Ints
    begin: Floats
    duration: Floats
    rows: Floats
    low: Floats
    high: Floats


@by_reference
class TimedCurve(NamedTuple):
    """One flight along a curve: it departs at `departure` seconds and takes `time_scale` times as long as the curve.

    The UAV waits where the curve begins until it departs, and stays where the curve ends after it has arrived.
    """

    curve: int
    departure: float
    time_scale: float


@by_reference
class Schedule(NamedTuple):
    """Many flights as arrays, (n,) each; see `TimedCurve`."""

    curve: Ints
    departure: Floats
    time_scale: Floats


def stay_at_start(uav: UAV) -> Trajectory:
    """Return the trajectory of a UAV that stays at its start for one second."""
    return Trajectory(np.array([0.0, 1.0]), np.array([[uav.start]]))


def make_curves(trajectories: Iterable[Trajectory]) -> Curves:
    """Convert trajectories to Bernstein pieces of one common degree."""
    given = list(trajectories)
    degree = max((t.coefficients.shape[1] for t in given), default=1)
    parts = [_pieces(t, degree) for t in given]
    counts = [len(begin) for begin, _, _ in parts]
    begin, duration, rows = (
        (np.concatenate(column) for column in zip(*parts, strict=True))
        if parts
        else (np.zeros(0), np.zeros(0), np.zeros((0, 1, 3)))
    )
    return Curves(np.cumsum([0, *counts]).astype(np.int64), begin, duration, rows, rows.min(axis=1), rows.max(axis=1))


def _pieces(trajectory: Trajectory, degree: int) -> tuple[Floats, Floats, Floats]:
    """Return local begin, duration and Bernstein coefficients of a trajectory's pieces."""
    power = np.zeros((len(trajectory.coefficients), degree, 3))
    power[:, : trajectory.coefficients.shape[1]] = trajectory.coefficients
    duration = np.diff(trajectory.knots)
    return trajectory.knots[:-1] - trajectory.knots[0], duration, _all_to_bernstein(power, duration)


@kernel
def _all_to_bernstein(power: Floats, duration: Floats) -> Floats:
    """Convert the power-basis coefficients (p, n, 3) of pieces to Bernstein coefficients of the same shape."""
    rows = np.empty(power.shape)
    for k in range(len(power)):
        converted = to_bernstein(power[k], duration[k])
        for i in range(power.shape[1]):
            for axis in range(3):
                rows[k, i, axis] = converted[i, axis]
    return rows


@kernel
def curve_duration(curves: Curves, c: int) -> float:
    """Return how long curve c takes, seconds."""
    last = curves.first[c + 1] - 1
    return curves.begin[last] + curves.duration[last]


@inner
def piece_at(curves: Curves, c: int, local: float) -> int:
    """Return the piece of curve c that is flown at a local time; on a knot, the piece before it."""
    low, high = curves.first[c], curves.first[c + 1] - 1
    while low < high:
        middle = (low + high + 1) // 2
        if curves.begin[middle] < local:
            low = middle
        else:
            high = middle - 1
    return low


@inner
def evaluate_piece(rows: Floats, share: float, out: Floats) -> None:
    """Write the position after a share of a piece's time into `out`, (3,) metres: Horner's rule for Bernstein form."""
    n = len(rows) - 1
    rest = 1.0 - share
    weight = 1.0
    for axis in range(3):
        out[axis] = rows[0, axis] * rest if n > 0 else rows[0, axis]
    for i in range(1, n):
        weight *= share * (n - i + 1) / i
        for axis in range(3):
            out[axis] = (out[axis] + weight * rows[i, axis]) * rest
    if n > 0:
        for axis in range(3):
            out[axis] += share**n * rows[n, axis]


@kernel
def position_at(curves: Curves, c: int, local: float) -> Floats:
    """Return the position on curve c at a local time, (3,) metres; beyond the ends, that of the end."""
    k = piece_at(curves, c, local)
    out = np.empty(3)
    evaluate_piece(curves.rows[k], min(max((local - curves.begin[k]) / curves.duration[k], 0.0), 1.0), out)
    return out


@inner
def constant_piece(position: Floats, count: int) -> Floats:
    """Return the (count, 3) Bernstein coefficients of a UAV that stays at a position."""
    rows = np.empty((count, 3))
    for i in range(count):
        put(rows, i, position)
    return rows


@inner
def piece_between(curves: Curves, k: int, since: float, until: float) -> Floats:
    """Return the Bernstein coefficients of the part of piece k between two local times of its curve."""
    u = min(max((since - curves.begin[k]) / curves.duration[k], 0.0), 1.0)
    v = min(max((until - curves.begin[k]) / curves.duration[k], 0.0), 1.0)
    if u <= 0.0 and v >= 1.0:
        return curves.rows[k]
    if v <= 0.0:
        return constant_piece(curves.rows[k, 0], curves.rows.shape[1])
    return part(curves.rows[k], u, v)
