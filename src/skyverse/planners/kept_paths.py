"""Paths of an earlier search taken up by a new one, for which the start, the target or the obstacles may have moved."""

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner_query, query
from skyverse.planners.base import points_of
from skyverse.planners.moves import LatticeTask, Paths, Workspace, begin_at, cut_loops, generate
from skyverse.space.lattice import Grid, positions


def checked_paths(given: Sequence[ArrayLike]) -> tuple[Floats, ...]:
    """Return paths as arrays (n, 3), and raise `InputError` for what is none."""
    return tuple(points_of(one, f"population[{number}]") for number, one in enumerate(given))


def nodes_ahead(grid: Grid, source: int, path: Floats) -> Ints:
    """Return the nodes nearest to the points of a path (n, 3), metres, from the free one on that is nearest to a node.

    None are left where no point of the path is near a free node.
    """
    indices = np.clip(np.rint((path - grid.origin) / grid.step).astype(np.int64), 0, grid.shape - 1)
    nodes = np.ravel_multi_index(tuple(indices.T), tuple(grid.shape))
    nodes = nodes[np.r_[True, nodes[1:] != nodes[:-1]][: len(nodes)]]
    nodes = nodes[grid.exits[nodes] != 0]
    if not len(nodes):
        return nodes
    away = np.linalg.norm(positions(grid, nodes) - positions(grid, [source]), axis=1)
    return nodes[int(np.argmin(away)) :].copy()


@query
def rejoin(task: LatticeTask, workspace: Workspace, rng: Generator, row: Ints) -> int:
    """Draft a path from the source along the nodes (n,) of an earlier path to the goal; return the draft's length.

    Walks of the generator lead from the source to the first of the nodes, from each to the next where no move of the
    lattice does, and from the last one to the goal. Where one gives up, the draft ends short of the goal.
    """
    draft = workspace.draft
    length = begin_at(workspace, task.source)
    for node in row:
        if length >= len(draft):
            break
        if node == draft[length - 1]:
            continue
        if _joined(task.grid, draft[length - 1], node):
            draft[length] = node
            length += 1
            continue
        length = generate(task, workspace, rng, length, node, task.repair_threshold)
        if draft[length - 1] != node:
            return cut_loops(workspace, 0, length)
    if draft[length - 1] != task.goal:
        length = generate(task, workspace, rng, length, task.goal, task.repair_threshold)
    return cut_loops(workspace, 0, length)


@inner_query
def _joined(grid: Grid, a: int, b: int) -> bool:
    """Tell whether a safe move leads from node a to node b."""
    m = 0
    while m < len(grid.offsets) and (a + grid.offsets[m] != b or not (grid.exits[a] >> m) & 1):
        m += 1
    return m < len(grid.offsets)


def kept_paths(grid: Grid, paths: Paths, best: Paths) -> tuple[Floats, ...]:
    """Return the best path and the others of a population, the cheapest first, (n, 3) metres each, none twice."""
    rows = [best.nodes[0, : best.length[0]]]
    rows += [paths.nodes[i, : paths.length[i]] for i in np.argsort(paths.cost, kind="stable")]
    found = {row.tobytes(): row for row in rows if len(row)}
    return tuple(positions(grid, row) for row in found.values())
