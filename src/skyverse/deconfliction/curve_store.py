"""A growing collection of trajectories and their swept volume trees, in arrays that kernels read."""

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.curves import Curves, curve_duration, make_curves
from skyverse.deconfliction.swept_volume_tree import SweptCurves, grow_tree
from skyverse.model.trajectory import Trajectory

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
