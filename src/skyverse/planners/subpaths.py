"""Stretches of lattice paths: straight flights between two nodes, and the replacement of a stretch by a draft.

These kernels take single arrays, because handing over a `LatticeTask` or a `Workspace` would take longer than most of
their work.
"""

import numpy as np

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.cost import Pricing
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.moves import NODES, PATHS, LatticeTask
from skyverse.space.lattice import Grid

_ORDERS = np.array([(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)])
"""All orders of three straight runs."""


@inner
def _straight_run(diagonal: bool, k: int, x: int, y: int, z: int) -> tuple[int, int, int, int]:
    """Return the k-th straight run over x, y, z lattice steps: the number of moves, and a move's step on each axis."""
    if not diagonal:
        x, y, z = x * int(k == 0), y * int(k == 1), z * int(k == 2)
    least = max(abs(x), abs(y), abs(z))
    for way in (x, y, z):
        if way:
            least = min(least, abs(way))
    return least, int(x > 0) - int(x < 0), int(y > 0) - int(y < 0), int(z > 0) - int(z < 0)


@kernel
def flight_price(steps: Floats, ny: int, nz: int, diagonal: bool, a: int, b: int) -> float:
    """Return the fuel of a flight from node a to node b in empty space: no path between them takes less."""
    x, y, z = b // (ny * nz) - a // (ny * nz), (b // nz) % ny - (a // nz) % ny, b % nz - a % nz
    if not diagonal:
        return float(abs(x) * steps[1] + abs(y) * steps[2] + abs(z) * steps[4])
    total = 0.0
    for k in range(3):
        n, ex, ey, ez = _straight_run(diagonal, k, x, y, z)
        total += n * steps[abs(ex) + 2 * abs(ey) + 4 * abs(ez)]
        x, y, z = x - n * ex, y - n * ey, z - n * ez
    return total


@kernel
def fly(grid: Grid, draft: Ints, spent: Ints, order: int, length: int, goal: int) -> int:
    """Continue the draft to the node `goal` by at most three straight runs, in one of six orders.

    It counts as a generated path, whether it is safe or not.

    Returns
    -------
    int
        The draft's new length, 0 where a move is not safe or the draft is full.
    """
    exits, offsets, moves = grid.exits, grid.offsets, grid.moves
    ny, nz, diagonal = grid.shape[1], grid.shape[2], len(offsets) > 6
    node = int(draft[length - 1])
    x, y, z = goal // (ny * nz) - node // (ny * nz), (goal // nz) % ny - (node // nz) % ny, goal % nz - node % nz
    n0, m0 = 0, 0
    n1, m1 = 0, 0
    n2, m2 = 0, 0
    for k in range(3):
        n, ex, ey, ez = _straight_run(diagonal, k, x, y, z)
        m = 0
        while n and (moves[m, 0] != ex or moves[m, 1] != ey or moves[m, 2] != ez):
            m += 1
        if k == 0:
            n0, m0 = n, m
        elif k == 1:
            n1, m1 = n, m
        else:
            n2, m2 = n, m
        if diagonal:
            x, y, z = x - n * ex, y - n * ey, z - n * ez
    begin = length
    safe = length + n0 + n1 + n2 < len(draft)
    for turn in range(3):
        k = _ORDERS[order, turn]
        n, m = (n0, m0) if k == 0 else ((n1, m1) if k == 1 else (n2, m2))
        bit, step = 1 << m, int(offsets[m])
        while n and safe:
            if exits[np.uint64(node)] & bit:  # unsigned, so that numba does not test for a negative index
                node += step
                draft[length] = node
                length += 1
                n -= 1
            else:
                safe = False
    spent[PATHS] += 1
    spent[NODES] += length - begin
    return length if safe else 0


@inner
def counts_nodes_only(pricing: Pricing) -> bool:
    """Tell whether a path's price is its number of nodes times a constant."""
    same = pricing.first > 0.0 and pricing.steps[1] == pricing.steps[7]
    return bool(same and pricing.turn == 0.0 and not pricing.rates.soft)


@inner
def price_of(grid: Grid, pricing: Pricing, nodes: Ints) -> float:
    """Return the price of a stretch: its moves, its turns and its soft terms."""
    price = cost.fuel(grid, pricing, nodes) - pricing.first + cost.divergence(grid, pricing, nodes)
    if pricing.rates.soft:
        price += cost.soft(grid, pricing, nodes).sum()
    return price


@kernel
def begin_stretch(draft: Ints, row: Ints, a: int) -> int:
    """Let the draft begin with node a of a path, and with the node before it, so that a turn there is priced.

    Returns
    -------
    int
        The draft's length.
    """
    draft[0] = row[max(0, a - 1)]
    draft[min(1, a)] = row[a]
    return min(1, a) + 1


@kernel
def gain_of(task: LatticeTask, row: Ints, n: int, a: int, b: int, draft: Ints, length: int) -> float:
    """Return by how much a path of n nodes gets cheaper if its nodes a to b are replaced by the draft.

    The draft was begun by `begin_stretch`.
    """
    grid, pricing = task.grid, task.pricing
    after = int(b + 1 < n)
    draft[length] = row[min(b + 1, n - 1)]
    old, new = row[max(0, a - 1) : b + 1 + after], draft[: length + after]
    gain = price_of(grid, pricing, old) - price_of(grid, pricing, new)
    return gain + cost.end(grid, pricing, old, task.goal) - cost.end(grid, pricing, new, task.goal)


@kernel
def replace_stretch(row: Ints, n: int, a: int, b: int, draft: Ints, length: int) -> int:
    """Replace nodes a to b of a path by the draft, which was begun by `begin_stretch`; return the path's new length."""
    before = min(1, a)
    shift = length - before - (b - a + 1)
    if shift > 0:
        for j in range(n - 1, b, -1):
            row[j + shift] = row[j]
    elif shift < 0:
        for j in range(b + 1, n):
            row[j + shift] = row[j]
    for j in range(length - before):
        row[a + j] = draft[before + j]
    return n + shift
