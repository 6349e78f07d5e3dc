"""Curves and their trees, kept side by side while options come up; kernels see them as arrays."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.curves import Curves, length, make_curves
from skyverse.deconfliction.swept_volume_tree import Tubes, grow_tree
from skyverse.model.trajectory import Trajectory


class Laid(NamedTuple):
    """All curves on the shelf, as kernels take them."""

    curves: Curves
    tubes: Tubes


class Shelf:
    """A growing collection of trajectories, each flown from its own instant zero on."""

    def __init__(self) -> None:
        self.trajectories: list[Trajectory] = []
        self.seconds: list[float] = []
        self._degree = 0
        self._columns: list[Floats] = []
        self._counts = np.zeros(3, np.int64)  # curves, pieces, boxes
        self._first = np.zeros(1, np.int64)
        self._base, self._leaves = np.zeros(0, np.int64), np.zeros(0, np.int64)

    def add(self, trajectory: Trajectory) -> int:
        """Put a trajectory on the shelf and return its number."""
        self.trajectories.append(trajectory)
        degree = max(trajectory.coefficients.shape[1], 6)
        if degree > self._degree:  # all have the same degree: lay them out anew
            self._degree = degree
            self._columns = [np.empty((0, *shape)) for shape in ((), (), (degree, 3), (3,), (3,), (6,))]
            self._counts[:] = 0
            again, self.trajectories, self.seconds = self.trajectories, [], []
            for one in again:
                self.trajectories.append(one)
                self._append(one)
        else:
            self._append(trajectory)
        return len(self.trajectories) - 1

    def _append(self, trajectory: Trajectory) -> None:
        padded = np.zeros((len(trajectory.coefficients), self._degree, 3))
        padded[:, : trajectory.coefficients.shape[1]] = trajectory.coefficients
        one = make_curves([Trajectory(trajectory.knots, padded)])
        boxes = grow_tree(one, 0)
        n, pieces, used = self._counts.tolist()
        parts = (one.begin, one.duration, one.rows, one.low, one.high, boxes)
        for i, part in enumerate(parts):
            self._columns[i] = _laid_at(self._columns[i], used if i == 5 else pieces, part)
        self._first = _laid_at(self._first, n + 1, np.array([pieces + len(one.begin)]))
        self._base = _laid_at(self._base, n, np.array([used]))
        self._leaves = _laid_at(self._leaves, n, np.array([(len(boxes) - 1) // 2]))
        self._counts += (1, len(one.begin), len(boxes))
        self.seconds.append(float(length(one, 0)))

    @property
    def laid(self) -> Laid:
        """The arrays; room that is not used yet stands behind what is."""
        begin, duration, rows, low, high, boxes = self._columns
        return Laid(Curves(self._first, begin, duration, rows, low, high), Tubes(self._base, self._leaves, boxes))


def _laid_at(column: np.ndarray, at: int, part: np.ndarray) -> np.ndarray:
    """Put rows into a column at a place, in a longer one where it is full."""
    if at + len(part) > len(column):
        longer = np.zeros((2 * (at + len(part)), *column.shape[1:]), column.dtype)
        longer[: len(column)] = column
        column = longer
    column[at : at + len(part)] = part
    return column
