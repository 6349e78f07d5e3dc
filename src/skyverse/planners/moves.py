"""Lattice paths: generate, splice, cut loops, judge. The operators that all metaheuristics share.

Paths are rows of node numbers in arrays made once a run; nothing is allocated while it lasts.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.cost import Pricing
from skyverse.numerics.kernel import inner, kernel
from skyverse.space.lattice import Grid

Marks = NDArray[np.uint8]
Places = NDArray[np.int32]
PATHS, NODES, EVALUATIONS = 0, 1, 2

# of six moves given as bits: how many they are, and which is the first, the second ...
_CHOICES = np.array([bits.bit_count() for bits in range(64)], np.uint8)
_CHOSEN = np.array([([m for m in range(6) if bits >> m & 1] + [0] * 8)[:8] for bits in range(64)], np.uint8)


class Task(NamedTuple):
    """What is sought, and how paths are generated.

    Attributes
    ----------
    directed
        Algorithm 2 (goal-directed) if true, otherwise Algorithm 1 (uniform).
    threshold
        N: the non-viable steps (Algorithm 2) or nodes (Algorithm 1) after which a walk gives up.
    """

    grid: Grid
    pricing: Pricing
    source: int
    goal: int
    directed: bool = True
    threshold: int = 200


class Paths(NamedTuple):
    """Candidate paths: ``nodes[i, :length[i]]`` costs ``cost[i]``."""

    nodes: Ints
    length: Ints
    cost: Floats


class Desk(NamedTuple):
    """Working memory of a run.

    Attributes
    ----------
    mark, stamp
        (nodes,) a node belongs to the walk under way if its mark is the stamp, (1,).
    place
        (nodes,) where in a path a node is; true only of nodes that are there.
    draft
        (capacity,) the path being drawn up.
    spent, limit
        (3,) generated paths, generated nodes, evaluations: so far, and at most.
    """

    mark: Marks
    stamp: Ints
    place: Places
    draft: Ints
    spent: Ints
    limit: Ints


@kernel
def exhausted(desk: Desk) -> bool:
    """Tell whether a counted budget is spent."""
    return (
        desk.spent[PATHS] >= desk.limit[PATHS]
        or desk.spent[NODES] >= desk.limit[NODES]
        or desk.spent[EVALUATIONS] >= desk.limit[EVALUATIONS]
    )


@kernel
def generate(task: Task, desk: Desk, rng: np.random.Generator, length: int, goal: int, threshold: int) -> int:
    """Walk on from the draft's last node towards a goal (Algorithms 1 and 2); return the draft's new length.

    The goal was reached if the draft now ends there. Loops of the walk are cut out.
    """
    return _cut(desk, length, _walk(task, desk, rng, length, goal, threshold))


@inner
def _cut(desk: Desk, length: int, walked: int) -> int:
    """Cut the loops of a walk that began at a length of the draft; a walk that never went back has none."""
    return cut_loops(desk, length - 1, -walked) if walked < 0 else walked


@kernel
def _walk(task: Task, desk: Desk, rng: np.random.Generator, length: int, goal: int, threshold: int) -> int:
    """Generate without cutting loops; return the draft's new length, negative if there may be any.

    Algorithm 2 takes at random one of the unvisited viable neighbours (those nearer to the goal on the axes that the
    move changes, but never the node just left); failing those any unvisited free neighbour, then a visited viable
    one, then any. The second and the last count as non-viable.
    """
    offsets, moves, exits, toward = task.grid.offsets, task.grid.moves, task.grid.exits, task.grid.toward
    ny, nz = task.grid.shape[1], task.grid.shape[2]
    draft, mark = desk.draft, desk.mark
    desk.spent[PATHS] += 1
    stamp = desk.stamp[0] + 1
    if stamp == 256:
        mark[:] = 0
        stamp = 1
    desk.stamp[0] = stamp
    node = int(draft[length - 1])
    mark[node] = stamp
    x, y, z = (
        goal // (ny * nz) - node // (ny * nz),
        (goal // nz) % ny - (node // nz) % ny,
        goal % nz - node % nz,
    )
    bits = np.uint64(rng.random() * 2**53) | np.uint64(1)  # a call at every step would cost a quarter of the walk
    not_back = -1
    counted = 0
    looped = 0
    begin = length
    while node != goal and counted <= threshold and length < len(draft) and exits[node]:
        free = int(np.int64(exits[node]))  # wider, or numba compiles what follows once more
        if task.directed:
            code = 13 + 9 * _sign(x) + 3 * _sign(y) + _sign(z)
            viable = free & int(toward[code]) & not_back
            fresh = _unvisited(offsets, mark, stamp, node, free)
            choice = viable & fresh
            if choice == 0:
                counted += 1
                choice = fresh
                if choice == 0:
                    looped = 1
                    choice = free
                    if viable:
                        counted -= 1
                        choice = viable
        else:
            counted += 1
            looped = 1
            choice = free
        bits ^= bits << np.uint64(13)  # Marsaglia's xorshift
        bits ^= bits >> np.uint64(7)
        bits ^= bits << np.uint64(17)
        move = _draw(offsets, choice, int(bits >> np.uint64(32)))
        not_back = ~(1 << (move ^ 1))
        node += int(offsets[move])
        x -= int(moves[move, 0])
        y -= int(moves[move, 1])
        z -= int(moves[move, 2])
        mark[node] = stamp
        draft[length] = node
        length += 1
    desk.spent[NODES] += length - begin
    return -length if looped else length


@inner
def _sign(v: int) -> int:
    return int(v > 0) - int(v < 0)


@inner
def _unvisited(offsets: Ints, mark: Marks, stamp: int, node: int, moves: int) -> int:
    """Keep of some moves, given as bits, those that lead to a node that the walk has not visited."""
    kept = 0
    seen = np.uint8(stamp)
    for m in range(len(offsets)):
        if moves & (1 << m):
            place = np.uint64(node + offsets[m])  # unsigned, so that numba need not look for an index from the end
            kept |= int(np.int64(mark[place] != seen)) << m
    return kept


@inner
def _draw(offsets: Ints, moves: int, share: int) -> int:
    """Draw one of some moves, given as bits, by a random number of 32 bits."""
    if len(offsets) == 6:
        row = np.uint64(moves)
        return int(_CHOSEN[row, np.uint64(share * int(_CHOICES[row]) >> 32)])
    count = 0
    rest = moves
    while rest:
        rest &= rest - 1
        count += 1
    skip = share * count >> 32
    m = 0
    while skip or not (moves >> m) & 1:
        skip -= (moves >> m) & 1
        m += 1
    return m


@kernel
def cut_loops(desk: Desk, first: int, length: int) -> int:
    """Remove from the draft, from a place on, what lies between two visits of a node; return its new length."""
    draft, place = desk.draft, desk.place
    kept = first
    for i in range(first, length):
        node = np.uint64(draft[i])
        before = place[node]
        if first <= before < kept and draft[before] == draft[i]:
            kept = before + 1
        else:
            place[node] = kept
            draft[kept] = draft[i]
            kept += 1
    return kept


@kernel
def judge(task: Task, desk: Desk, length: int) -> float:
    """Return the draft's cost, equation 3.4."""
    desk.spent[EVALUATIONS] += 1
    return cost.total(task.grid, task.pricing, desk.draft[:length], task.goal)


@inner
def begin_at(desk: Desk, node: int) -> int:
    """Begin the draft with a node; return the draft's length."""
    desk.draft[0] = node
    return int(np.int64(1))  # of a literal, numba would make a type of its own, and compile all callers' callees for it


@inner
def begin_with(desk: Desk, paths: Paths, i: int, end: int) -> int:
    """Begin the draft with the nodes of path i up to an end; return the draft's length."""
    for j in range(end):
        desk.draft[j] = paths.nodes[i, j]
    return end


@kernel
def copy_in(desk: Desk, at: int, paths: Paths, i: int, first: int, end: int) -> int:
    """Copy nodes first:end of path i into the draft at a place; return the draft's new length.

    A draft that is full is cut short there: still a path, only one that does not arrive.
    """
    for j in range(first, min(end, first + len(desk.draft) - at)):
        desk.draft[at] = paths.nodes[i, j]
        at += 1
    return at


@kernel
def put(paths: Paths, i: int, desk: Desk, length: int, price: float) -> None:
    """Let the draft be path i."""
    for j in range(length):
        paths.nodes[i, j] = desk.draft[j]
    paths.length[i] = length
    paths.cost[i] = price


@kernel
def random_node(grid: Grid, rng: np.random.Generator) -> int:
    """Draw a free node."""
    while True:
        node = int(rng.random() * len(grid.exits))
        if grid.exits[node]:
            return node


@kernel
def detour(task: Task, desk: Desk, rng: np.random.Generator, length: int, threshold: int, retries: int) -> int:
    """Walk from the draft's end to a free point drawn anywhere; the last try stands even if it gives up."""
    walked = length
    for _ in range(retries + 1):
        node = random_node(task.grid, rng)
        walked = _walk(task, desk, rng, length, node, threshold)
        if desk.draft[abs(walked) - 1] == node:
            break
    return _cut(desk, length, walked)


@kernel
def reroute(task: Task, desk: Desk, rng: np.random.Generator, U: Paths, i: int, threshold: int, retries: int) -> int:
    """Case 2: follow path i to a random node of it, walk through a free point drawn anywhere, then to the goal."""
    length = begin_with(desk, U, i, 1 + int(rng.random() * U.length[i]))
    length = detour(task, desk, rng, length, threshold, retries)
    return cut_loops(desk, 0, generate(task, desk, rng, length, task.goal, threshold))


@kernel
def graft(task: Task, desk: Desk, rng: np.random.Generator, U: Paths, i: int, j: int, threshold: int) -> int:
    """Draw up path i with a stretch of path j in it; return the draft's length.

    Path i is followed to a random node; a walk leads to path j, where as large a share of it lies behind; after the
    stretch another walk leads back to path i. Where a walk gives up, a last one makes for the goal; where the
    stretch ends with path j, so does the draft.
    """
    ni, nj = U.length[i], U.length[j]
    a = int(rng.random() * ni)
    p = min(nj - 1, a * nj // ni + 1)
    q = min(nj, p + 1 + int(rng.random() * nj))
    length = begin_with(desk, U, i, a + 1)
    length = generate(task, desk, rng, length, U.nodes[j, p], threshold)
    if desk.draft[length - 1] == U.nodes[j, p]:
        length = copy_in(desk, length, U, j, p + 1, q)
        b = max(a, q * ni // nj)
        if q < nj and b < ni:
            length = generate(task, desk, rng, length, U.nodes[i, b], threshold)
            if desk.draft[length - 1] == U.nodes[i, b]:
                length = copy_in(desk, length, U, i, b + 1, ni)
    if desk.draft[length - 1] != task.goal:
        length = generate(task, desk, rng, length, task.goal, threshold)
    return cut_loops(desk, 0, length)


@kernel
def ranked(costs: Floats) -> Ints:
    """Return the candidates from the cheapest on; equal ones in their old order."""
    order = np.empty(len(costs), np.int64)
    for i in range(len(costs)):
        j = i
        while j > 0 and costs[order[j - 1]] > costs[i]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = i
    return order


@kernel
def rank_wheel(n: int, rng: np.random.Generator) -> int:
    """Draw a rank from 0 on, rank r with a weight of n - r."""
    spin = rng.random() * (n * (n + 1) // 2)
    rank = 0
    while rank < n - 1 and spin >= n - rank:
        spin -= n - rank
        rank += 1
    return rank


@kernel
def adopt(task: Task, desk: Desk, U: Paths, i: int, best: Paths, length: int) -> None:
    """Judge the draft and let it be path i, and the archived best if it is better."""
    price = judge(task, desk, length)
    put(U, i, desk, length, price)
    if price < best.cost[0]:
        put(best, 0, desk, length, price)
