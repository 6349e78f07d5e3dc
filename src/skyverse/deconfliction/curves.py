"""Trajectories as kernels see them: Bernstein pieces side by side in a few arrays, from each one's own instant zero."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.arrays import put
from skyverse.numerics.bernstein import part, to_bernstein
from skyverse.numerics.kernel import inner, kernel

FORGIVEN = 1e-6
"""Metres off both semi-axes by which UAVs may be too close: what the referee lets pass."""


class Curves(NamedTuple):
    """Many curves, piece after piece.

    Attributes
    ----------
    first
        (n + 1,) where each curve's pieces begin.
    begin, duration
        (p,) seconds of each piece, counted from its curve's beginning.
    rows
        (p, degree + 1, 3) Bernstein coefficients, metres.
    low, high
        (p, 3) a box around each piece.
    """

    first: Ints
    begin: Floats
    duration: Floats
    rows: Floats
    low: Floats
    high: Floats


class Placed(NamedTuple):
    """How curves are flown: `curve[i]` begins at `at[i]` seconds and takes `scale[i]` times as long; (n,) each.

    Before that its UAV stands where the curve begins, afterwards where it ends.
    """

    curve: Ints
    at: Floats
    scale: Floats


def standing(uav: UAV) -> Trajectory:
    """Return the curve of a UAV that stays at its start."""
    return Trajectory(np.array([0.0, 1.0]), np.array([[uav.start]]))


def make_curves(trajectories: Iterable[Trajectory]) -> Curves:
    """Lay trajectories out for the kernels."""
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
    power = np.zeros((len(trajectory.coefficients), degree, 3))
    power[:, : trajectory.coefficients.shape[1]] = trajectory.coefficients
    duration = np.diff(trajectory.knots)
    return trajectory.knots[:-1] - trajectory.knots[0], duration, _all_to_bernstein(power, duration)


@kernel
def _all_to_bernstein(power: Floats, duration: Floats) -> Floats:
    rows = np.empty(power.shape)
    for k in range(len(power)):
        rows_of = to_bernstein(power[k], duration[k])
        for i in range(power.shape[1]):
            for axis in range(3):
                rows[k, i, axis] = rows_of[i, axis]
    return rows


@kernel
def length(curves: Curves, c: int) -> float:
    """Return how long curve c takes, seconds."""
    last = curves.first[c + 1] - 1
    return curves.begin[last] + curves.duration[last]


@inner
def piece_at(curves: Curves, c: int, local: float) -> int:
    """Return the piece of curve c that is flown at a local instant; that before it on a knot."""
    low, high = curves.first[c], curves.first[c + 1] - 1
    while low < high:
        middle = (low + high + 1) // 2
        if curves.begin[middle] < local:
            low = middle
        else:
            high = middle - 1
    return low


@inner
def point(rows: Floats, share: float, out: Floats) -> None:
    """Put where a piece is, after a share of its time, into `out`, (3,) metres: Horner's rule for Bernstein form."""
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
def place(curves: Curves, c: int, local: float) -> Floats:
    """Return where curve c is at a local instant, (3,) metres."""
    k = piece_at(curves, c, local)
    out = np.empty(3)
    point(curves.rows[k], min(max((local - curves.begin[k]) / curves.duration[k], 0.0), 1.0), out)
    return out


@inner
def resting(at: Floats, count: int) -> Floats:
    """Return the (count, 3) coefficients of staying at a point."""
    rows = np.empty((count, 3))
    for i in range(count):
        put(rows, i, at)
    return rows


@inner
def stretch(curves: Curves, k: int, since: float, until: float) -> Floats:
    """Return the Bernstein coefficients of piece k between two local instants of its curve."""
    u = min(max((since - curves.begin[k]) / curves.duration[k], 0.0), 1.0)
    v = min(max((until - curves.begin[k]) / curves.duration[k], 0.0), 1.0)
    if u <= 0.0 and v >= 1.0:
        return curves.rows[k]
    if v <= 0.0:
        return resting(curves.rows[k, 0], curves.rows.shape[1])
    return part(curves.rows[k], u, v)
