"""What metaheuristics share: selection among candidates by their costs, and changes of lattice paths."""

import numpy as np
from numpy.random import Generator

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import kernel, query
from skyverse.planners.moves import (
    LatticeTask,
    Paths,
    Workspace,
    begin_with,
    copy_in,
    cut_loops,
    detour,
    generate,
)


@query
def reroute(task: LatticeTask, workspace: Workspace, rng: Generator, U: Paths, i: int) -> int:
    """Draft Case 2: path i up to a random node of it, a walk to a random free node, and a walk to the goal."""
    length = begin_with(workspace, U, i, 1 + int(rng.random() * U.length[i]))
    length = detour(task, workspace, rng, length, task.repair_threshold, task.retries)
    return cut_loops(workspace, 0, generate(task, workspace, rng, length, task.goal, task.repair_threshold))


@query
def graft(task: LatticeTask, workspace: Workspace, rng: Generator, U: Paths, i: int, j: int) -> int:
    """Draft path i with a stretch of path j in it; return the draft's length.

    The draft follows path i to a random node. A walk leads to the node of path j before which the same share of path j
    lies. A stretch of path j of random length follows, and a walk back to path i, unless the stretch reaches the end
    of path j. Wherever a walk gives up, another one leads to the goal.
    """
    ni, nj = U.length[i], U.length[j]
    a = int(rng.random() * ni)
    p = min(nj - 1, a * nj // ni + 1)
    q = min(nj, p + 1 + int(rng.random() * nj))
    length = begin_with(workspace, U, i, a + 1)
    length = generate(task, workspace, rng, length, U.nodes[j, p], task.repair_threshold)
    if workspace.draft[length - 1] == U.nodes[j, p]:
        length = copy_in(workspace, length, U, j, p + 1, q)
        b = max(a, q * ni // nj)
        if q < nj and b < ni:
            length = generate(task, workspace, rng, length, U.nodes[i, b], task.repair_threshold)
            if workspace.draft[length - 1] == U.nodes[i, b]:
                length = copy_in(workspace, length, U, i, b + 1, ni)
    if workspace.draft[length - 1] != task.goal:
        length = generate(task, workspace, rng, length, task.goal, task.repair_threshold)
    return cut_loops(workspace, 0, length)


@kernel
def ranked(costs: Floats) -> Ints:
    """Return the indices of candidates in order of cost, (n,); those of equal cost keep their order."""
    order = np.empty(len(costs), np.int64)
    for i in range(len(costs)):
        j = i
        while j > 0 and costs[order[j - 1]] > costs[i]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = i
    return order


@query
def rank_wheel(n: int, rng: Generator) -> int:
    """Return a random rank from 0 to n - 1 by a roulette wheel, on which rank r has the weight n - r."""
    spin = rng.random() * (n * (n + 1) // 2)
    rank = 0
    while rank < n - 1 and spin >= n - rank:
        spin -= n - rank
        rank += 1
    return rank
