"""Optimal assignment of UAVs to targets (the thesis's Algorithm 4, solved exactly by scipy)."""

from bisect import bisect_left
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import InputError

Criterion = Literal["min-sum", "min-max"]


def assign(costs: ArrayLike, criterion: Criterion = "min-sum") -> tuple[int | None, ...]:
    """Assign as many UAVs to targets as possible, at the least cost.

    Parameters
    ----------
    costs
        (m, n) the cost for UAV i to reach target j; infinite where it cannot.
    criterion
        ``"min-sum"`` minimises the total cost; ``"min-max"`` the largest single cost, and among such assignments the
        total.

    Returns
    -------
    tuple
        For each of the m UAVs the index of its target, or ``None`` where it gets none.

    Raises
    ------
    ValueError
        If `costs` is not a matrix, or holds NaN or minus infinity, or the criterion is unknown.
    """
    matrix = np.array(costs, dtype=np.float64)
    if matrix.ndim != 2:
        raise InputError(f"costs are a matrix, one row a UAV and one column a target, not of shape {matrix.shape}")
    if np.any(np.isnan(matrix)) or np.any(matrix == -np.inf):
        raise InputError("costs are numbers, or infinite where a UAV cannot reach a target")
    if criterion not in ("min-sum", "min-max"):
        raise InputError(f"criterion is 'min-sum' or 'min-max', not {criterion!r}")
    possible = np.isfinite(matrix)
    if not possible.any():
        return (None,) * len(matrix)
    if len(matrix) == 1:  # this needs no solver, which takes long to import
        return (int(np.argmin(matrix[0])),)
    from scipy.optimize import linear_sum_assignment

    if criterion == "min-max":
        possible &= matrix <= _smallest_maximum(matrix, possible)
    # an impossible pair costs more than any assignment of possible ones, so that as few as possible are assigned
    span = np.ptp(matrix[possible])
    size = min(matrix.shape)
    dear = matrix[possible].max() + (span + 1.0) * (size + 1)
    rows, columns = linear_sum_assignment(np.where(possible, matrix, dear))
    chosen = {int(i): int(j) for i, j in zip(rows, columns, strict=True) if possible[i, j]}
    return tuple(chosen.get(i) for i in range(len(matrix)))


def straight_line(starts: ArrayLike, targets: ArrayLike) -> Floats:
    """Return the Euclidean metres between (m, 3) starts and (n, 3) targets, (m, n), as Algorithm 4 prices them."""
    from scipy.spatial.distance import cdist

    return np.asarray(cdist(np.reshape(starts, (-1, 3)), np.reshape(targets, (-1, 3))), dtype=np.float64)


def _smallest_maximum(matrix: Floats, possible: np.ndarray) -> float:
    """Return the smallest cost such that pairs up to it still assign as many UAVs as all pairs do."""
    from scipy.optimize import linear_sum_assignment

    def matched(level: float) -> int:
        dearer = ~possible | (matrix > level)
        return min(matrix.shape) - int(dearer[linear_sum_assignment(dearer)].sum())

    levels = np.unique(matrix[possible]).tolist()
    return float(levels[bisect_left(levels, matched(levels[-1]), key=matched)])
