"""A growing collection of trajectories and their swept volume trees, in arrays that kernels read.

A swept volume tree is a binary tree of boxes over a curve's time. A leaf's box encloses the curve during one of 2^m
equal intervals, each at most `LEAF_SECONDS` long: the box around the positions at both ends of the interval and at the
knots within it, widened by how far a curve can leave its chord, ``acceleration * interval^2 / 8`` along each axis. A
node's box encloses those of its two children.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.deconfliction.curves import Curves, curve_duration, evaluate_piece, make_curves, position_at
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.arrays import put, put_box
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.numerics.tolerances import BOX_SLACK

LEAF_SECONDS = 0.01
"""Seconds of a curve that a leaf's box encloses, at most."""
MAX_LEAVES = 1 << 16


@by_reference
class SweptCurves(NamedTuple):
    """Many curves and their trees, one after another.

    Attributes
    ----------
    curves
        The curves.
    base
        (n,) row of `boxes` at which each tree begins: first the point where the curve begins, then the tree with its
        root at `base + 1` and the children of node i at 2 i and 2 i + 1, then the point where the curve ends.
    leaves
        (n,) number of leaves of each tree, a power of 2.
    boxes
        (m, 6) low and high corners, metres.
    """

    curves: Curves
    base: Ints
    leaves: Ints
    boxes: Floats


@kernel
def grow_tree(curves: Curves, c: int) -> Floats:
    """Return the boxes of the tree of curve c, (2 leaves + 1, 6); see `SweptCurves`."""
    whole = curve_duration(curves, c)
    leaves = 1
    while leaves < MAX_LEAVES and whole > leaves * LEAF_SECONDS and not _is_constant(curves, c):
        leaves *= 2
    boxes = np.empty((2 * leaves + 1, 6))
    at, end = position_at(curves, c, 0.0), position_at(curves, c, whole)
    put_box(boxes, 0, at, at)
    put_box(boxes, 2 * leaves, end, end)
    accelerations = np.empty((curves.first[c + 1] - curves.first[c], 3))
    for k in range(len(accelerations)):
        piece = curves.first[c] + k
        put(accelerations, k, _largest_acceleration(curves.rows[piece], curves.duration[piece]))
    step = whole / leaves
    final = curves.first[c + 1] - 1
    k = curves.first[c]
    low, high, most = np.empty(3), np.empty(3), np.empty(3)
    for leaf in range(leaves):
        until = (leaf + 1) * step
        for axis in range(3):
            low[axis], high[axis], most[axis] = at[axis], at[axis], accelerations[k - curves.first[c], axis]
        while k < final and curves.begin[k + 1] < until:  # at a knot both pieces count, since they may not join exactly
            _widen(low, high, curves.rows[k, curves.rows.shape[1] - 1])
            k += 1
            _widen(low, high, curves.rows[k, 0])
            for axis in range(3):
                most[axis] = max(most[axis], accelerations[k - curves.first[c], axis])
        evaluate_piece(curves.rows[k], min((until - curves.begin[k]) / curves.duration[k], 1.0), at)
        _widen(low, high, at)
        for axis in range(3):
            slack = most[axis] * (step * step / 8) + BOX_SLACK
            boxes[leaves + leaf, axis], boxes[leaves + leaf, 3 + axis] = low[axis] - slack, high[axis] + slack
    enclose_children(boxes, leaves)
    return boxes


@inner
def _widen(low: Floats, high: Floats, position: Floats) -> None:
    """Widen a box so that it holds a position."""
    for axis in range(3):
        low[axis] = min(low[axis], position[axis])
        high[axis] = max(high[axis], position[axis])


@inner
def enclose_children(boxes: Floats, leaves: int) -> None:
    """Write the box of every inner node of a tree, from those of its leaves up to its root."""
    for node in range(leaves - 1, 0, -1):
        for axis in range(3):
            boxes[node, axis] = min(boxes[2 * node, axis], boxes[2 * node + 1, axis])
            boxes[node, 3 + axis] = max(boxes[2 * node, 3 + axis], boxes[2 * node + 1, 3 + axis])


@inner
def _is_constant(curves: Curves, c: int) -> bool:
    """Tell whether a curve never moves."""
    for k in range(curves.first[c], curves.first[c + 1]):
        for axis in range(3):
            if curves.low[k, axis] != curves.high[k, axis]:
                return False
    return True


@inner
def _largest_acceleration(rows: Floats, duration: float) -> Floats:
    """Return a bound on the acceleration along each axis within a piece, (3,) m/s^2."""
    n = len(rows) - 1
    most = np.zeros(3)
    for i in range(n - 1):
        for axis in range(3):
            second = rows[i, axis] - 2 * rows[i + 1, axis] + rows[i + 2, axis]
            most[axis] = max(most[axis], abs(second) * (n * (n - 1) / (duration * duration)))
    return most


MIN_COEFFICIENTS = 6
"""Coefficients that each piece has room for at first, those of a quintic, so that arrays are seldom laid out anew."""


class CurveStore:
    """A growing collection of trajectories; each is stored as a curve with local time.

    Attributes
    ----------
    trajectories
        In the order in which they were added.
    seconds
        How long each takes.
    """

    def __init__(self) -> None:
        self.trajectories: list[Trajectory] = []
        self.seconds: list[float] = []
        self._coefficients = 0
        self._columns: list[Floats] = []
        self._counts = np.zeros(3, np.int64)  # curves, pieces, boxes
        self._first = np.zeros(1, np.int64)
        self._base, self._leaves = np.zeros(0, np.int64), np.zeros(0, np.int64)

    def add(self, trajectory: Trajectory) -> int:
        """Store a trajectory and return the number of its curve."""
        self.trajectories.append(trajectory)
        coefficients = max(trajectory.coefficients.shape[1], MIN_COEFFICIENTS)
        if coefficients > self._coefficients:  # all pieces have the same degree: lay out everything anew
            self._coefficients = coefficients
            self._columns = [np.empty((0, *shape)) for shape in ((), (), (coefficients, 3), (3,), (3,), (6,))]
            self._counts[:] = 0
            again, self.trajectories, self.seconds = self.trajectories, [], []
            for one in again:
                self.trajectories.append(one)
                self._append(one)
        else:
            self._append(trajectory)
        return len(self.trajectories) - 1

    def drop_last(self) -> None:
        """Forget the trajectory that was added last."""
        self.trajectories.pop()
        self.seconds.pop()
        n, _, _ = self._counts.tolist()
        self._counts -= (1, int(self._first[n] - self._first[n - 1]), 2 * int(self._leaves[n - 1]) + 1)

    def _append(self, trajectory: Trajectory) -> None:
        """Write a trajectory's pieces and boxes behind those of the others."""
        padded = np.zeros((len(trajectory.coefficients), self._coefficients, 3))
        padded[:, : trajectory.coefficients.shape[1]] = trajectory.coefficients
        one = make_curves([Trajectory(trajectory.knots, padded)])
        boxes = grow_tree(one, 0)
        n, pieces, used = self._counts.tolist()
        parts = (one.begin, one.duration, one.rows, one.low, one.high, boxes)
        for i, part in enumerate(parts):
            self._columns[i] = _written(self._columns[i], used if i == 5 else pieces, part)
        self._first = _written(self._first, n + 1, np.array([pieces + len(one.begin)]))
        self._base = _written(self._base, n, np.array([used]))
        self._leaves = _written(self._leaves, n, np.array([(len(boxes) - 1) // 2]))
        self._counts += (1, len(one.begin), len(boxes))
        self.seconds.append(float(curve_duration(one, 0)))

    @property
    def arrays(self) -> SweptCurves:
        """The curves and their trees as kernels take them; what follows what is stored is not to be read."""
        begin, duration, rows, low, high, boxes = self._columns
        curves = Curves(self._first, begin, duration, rows, low, high)
        return SweptCurves(curves, self._base, self._leaves, boxes)


def _written(column: np.ndarray, at: int, part: np.ndarray) -> np.ndarray:
    """Write rows into a column from a row on, and return it, or a copy twice as long where it is full."""
    if at + len(part) > len(column):
        longer = np.zeros((2 * (at + len(part)), *column.shape[1:]), column.dtype)
        longer[: len(column)] = column
        column = longer
    column[at : at + len(part)] = part
    return column
