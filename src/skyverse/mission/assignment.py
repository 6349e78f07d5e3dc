"""Optimal assignment of UAVs to targets (the thesis's Algorithm 4, solved exactly by scipy)."""

from bisect import bisect_left
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats, Ints
from skyverse.errors import InputError, require_choice
from skyverse.interrupt import raise_if_interrupted
from skyverse.numerics.side_by_side import side_by_side
from skyverse.problem import Airspace, snap_endpoint
from skyverse.search.lattice_astar import prices_to

Assignment = Literal["euclidean", "path-cost", "identity"]
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
    require_choice(criterion, get_args(Criterion), "criterion")
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


def cost_matrix(airspace: Airspace, assignment: Assignment, workers: int = 1) -> Floats:
    """Return the cost (m, n) for each of m UAVs to reach each of n targets, infinite where it cannot."""
    scenario = airspace.scenario
    uavs, targets = len(scenario.uavs), len(scenario.targets)
    if assignment == "euclidean":
        return straight_line([u.start for u in scenario.uavs], [t.position for t in scenario.targets])
    matrix = np.full((uavs, targets), np.inf)
    if assignment == "identity":
        np.fill_diagonal(matrix, 1.0)
        return matrix
    kinds: dict[tuple[Airspace, bool], list[int]] = {}
    for i, uav in enumerate(scenario.uavs):
        kinds.setdefault((airspace.of(i), uav.fixed_wing is None), []).append(i)
    starts, places = np.array([uav.start for uav in scenario.uavs]), [target.position for target in scenario.targets]
    for (own, _), alike in kinds.items():
        matrix[alike] = lattice_prices(own, alike[0], starts[alike], places, workers)
    return matrix


def lattice_prices(airspace: Airspace, uav: int, begins: ArrayLike, ends: ArrayLike, workers: int = 1) -> Floats:
    """Return the prices (m, n) of cheapest paths on the lattice, infinite where there is none.

    Parameters
    ----------
    airspace, uav
        Of a UAV, and its index: others that stray as far, and have pads as it has, share the prices.
    begins, ends
        (m, 3) and (n, 3) metres: places where UAVs are and where they go, without the height above their pads.
    workers
        Threads that search.
    """
    sources, goals = np.reshape(begins, (-1, 3)), np.reshape(ends, (-1, 3))
    found = [snap_endpoint(airspace, airspace.lifted(uav, tuple(place)), start=False) for place in goals.tolist()]
    free = [j for j, (_, refusal) in enumerate(found) if refusal is None]
    nodes: Ints = np.array([found[j][0] for j in free], dtype=np.int64)

    def row(i: int) -> Floats:
        prices = np.full(len(goals), np.inf)
        source, refusal = snap_endpoint(airspace, airspace.lifted(uav, tuple(sources[i].tolist())), start=True)
        if refusal is None and free:
            prices[free] = prices_to(airspace.grid, airspace.pricing, source, nodes)
        return prices

    rows = [*side_by_side(row, len(sources), workers)]
    raise_if_interrupted()
    return np.array(rows).reshape(len(sources), len(goals))


def assign_targets(
    airspace: Airspace, assignment: Assignment = "path-cost", criterion: Criterion = "min-sum", workers: int = 1
) -> tuple[int | None, ...]:
    """Return for each UAV the index of its target, or ``None``; see `plan_mission`."""
    require_choice(assignment, get_args(Assignment), "assignment")
    if assignment == "path-cost" and len(airspace.scenario.uavs) == len(airspace.scenario.targets) == 1:
        assignment = "identity"  # there is nothing to choose, so that no pair has to be priced
    chosen = assign(cost_matrix(airspace, assignment, workers), criterion)
    if assignment != "path-cost":
        return chosen
    # UAVs that can reach no target still get one that is left, so that their results say why
    left = [j for j in range(len(airspace.scenario.targets)) if j not in chosen]
    return tuple(left.pop(0) if j is None and left else j for j in chosen)
