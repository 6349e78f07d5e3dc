"""Operators on lattice paths that the metaheuristics share: generate, splice, cut loops, price.

A path is a row of node numbers. All arrays are made at the start of a run, so that an iteration allocates nothing.
"""

from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.cost import Pricing
from skyverse.numerics.kernel import by_reference, inner_query, kernel, query
from skyverse.space.lattice import Grid

Exits = NDArray[np.int32]
Marks = NDArray[np.uint8]
Positions = NDArray[np.int32]

PATHS, NODES, EVALUATIONS = 0, 1, 2
"""Where `Workspace.spent` and `Workspace.limit` hold each counter."""

# for every set of the six moves, given as bits: how many moves it has, and its moves in order
_CHOICES = np.array([bits.bit_count() for bits in range(64)], np.uint8)
_CHOSEN = np.array([([m for m in range(6) if bits >> m & 1] + [0] * 8)[:8] for bits in range(64)], np.uint8)


@by_reference
class LatticeTask(NamedTuple):
    """What is sought on the lattice, and how paths are generated.

    Attributes
    ----------
    grid, pricing
        The lattice, and the prices of its paths.
    source, goal
        The nodes that a path is to join.
    directed
        Whether walks follow Algorithm 2 (goal-directed) instead of Algorithm 1 (uniform).
    threshold
        N: a walk gives up after so many non-viable steps (Algorithm 2) or nodes (Algorithm 1).
    repair_threshold
        The same for walks that change a path.
    retries
        How often a walk to a random node that gives up is replaced by a walk to another node.
    """

    grid: Grid
    pricing: Pricing
    source: int
    goal: int
    directed: bool = True
    threshold: int = 200
    repair_threshold: int = 100
    retries: int = 100


@by_reference
class Paths(NamedTuple):
    """Candidate paths: path i consists of ``nodes[i, :length[i]]`` and costs ``cost[i]``."""

    nodes: Ints
    length: Ints
    cost: Floats


@by_reference
class Workspace(NamedTuple):
    """Working memory of a run.

    Attributes
    ----------
    mark, stamp
        (nodes,) and (1,): the current walk has visited a node if the node's mark equals the stamp.
    position
        (nodes,) the position of a node in a path; meaningful only for the nodes of that path.
    draft
        (capacity,) the path under construction.
    spent, limit
        (3,) the generated paths, generated nodes and evaluations so far, and the most that are allowed.
    """

    mark: Marks
    stamp: Ints
    position: Positions
    draft: Ints
    spent: Ints
    limit: Ints


@query
def exhausted(workspace: Workspace) -> bool:
    """Tell whether a counted budget is spent."""
    return limit_reached(workspace.spent, workspace.limit)


@inner_query
def limit_reached(spent: Ints, limit: Ints) -> bool:
    """Tell whether one of the three counters has reached its limit."""
    return bool(
        spent[PATHS] >= limit[PATHS] or spent[NODES] >= limit[NODES] or spent[EVALUATIONS] >= limit[EVALUATIONS]
    )


@query
def generate(task: LatticeTask, workspace: Workspace, rng: Generator, length: int, goal: int, threshold: int) -> int:
    """Continue the draft by a random walk towards a goal (Algorithms 1 and 2), and cut out the walk's loops.

    Returns
    -------
    int
        The draft's new length. The walk reached the goal if the draft now ends there; otherwise it gave up.
    """
    return _cut(workspace, length, _walk(task, workspace, rng, length, goal, threshold))


@inner_query
def _cut(workspace: Workspace, length: int, walked: int) -> int:
    """Cut out the loops of a walk that began when the draft was `length` long.

    `walked` is the draft's length after the walk, negative if the walk may have visited a node twice.
    """
    return cut_loops(workspace, length - 1, -walked) if walked < 0 else walked


@query
def _walk(task: LatticeTask, workspace: Workspace, rng: Generator, length: int, goal: int, threshold: int) -> int:
    """Walk without cutting out loops; return the draft's new length, negative if the walk may have loops.

    A neighbour is viable if the move to it comes nearer to the goal on every axis that it changes, and if it is not the
    node just left. Algorithm 2 moves to a random neighbour among the unvisited viable ones. If there are none, it
    chooses among all unvisited free neighbours, else among the visited viable ones, else among all free ones. The
    second and the fourth of these count as non-viable steps. Algorithm 1 chooses among all free neighbours.
    """
    offsets, moves, exits, toward = task.grid.offsets, task.grid.moves, task.grid.exits, task.grid.toward
    ny, nz = task.grid.shape[1], task.grid.shape[2]
    draft, mark = workspace.draft, workspace.mark
    workspace.spent[PATHS] += 1
    stamp = workspace.stamp[0] + 1
    if stamp == 256:
        mark[:] = 0
        stamp = 1
    workspace.stamp[0] = stamp
    node = int(draft[length - 1])
    mark[node] = stamp
    x, y, z = (
        goal // (ny * nz) - node // (ny * nz),
        (goal // nz) % ny - (node // nz) % ny,
        goal % nz - node % nz,
    )
    bits = np.uint64(rng.random() * 2**53) | np.uint64(1)  # faster than a call of rng at every step
    not_back = -1
    counted = 0
    looped = 0
    begin = length
    while node != goal and counted <= threshold and length < len(draft) and exits[node]:
        free = int(np.int64(exits[node]))  # the wider type keeps numba from compiling what follows twice
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
        bits ^= bits << np.uint64(13)  # Marsaglia's xorshift generator
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
    workspace.spent[NODES] += length - begin
    return -length if looped else length


@inner_query
def _sign(v: int) -> int:
    return int(v > 0) - int(v < 0)


@inner_query
def _unvisited(offsets: Ints, mark: Marks, stamp: int, node: int, moves: int) -> int:
    """Return those of some moves, given as bits, that lead to a node that the walk has not visited."""
    kept = 0
    seen = np.uint8(stamp)
    for m in range(len(offsets)):
        if moves & (1 << m):
            place = np.uint64(node + offsets[m])  # unsigned, so that numba does not test for a negative index
            kept |= int(np.int64(mark[place] != seen)) << m
    return kept


@inner_query
def _draw(offsets: Ints, moves: int, share: int) -> int:
    """Return one of some moves, given as bits, chosen by a random number of 32 bits."""
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


@query
def cut_loops(workspace: Workspace, first: int, length: int) -> int:
    """Remove what lies between two visits of a node from the draft, from position `first` on; return its new length."""
    draft, position = workspace.draft, workspace.position
    for i in range(first, length):
        position[np.uint64(draft[i])] = i  # in the end: where the node is visited for the last time
    kept = begin = first
    while begin < length:
        end = begin
        while end < length - 1 and position[np.uint64(draft[end])] == end:
            end += 1
        after = position[np.uint64(draft[end])] + 1
        for i in range(begin, end + 1):
            draft[kept] = draft[i]
            kept += 1
        begin = after
    return kept


@query
def judge(task: LatticeTask, workspace: Workspace, length: int) -> float:
    """Return the draft's cost (equation 3.4), and count an evaluation."""
    workspace.spent[EVALUATIONS] += 1
    return cost.total(task.grid, task.pricing, workspace.draft[:length], task.goal)


@inner_query
def begin_at(workspace: Workspace, node: int) -> int:
    """Let the draft consist of one node; return its length."""
    workspace.draft[0] = node
    return int(np.int64(1))  # a literal 1 has a type of its own, for which numba would compile again


@inner_query
def begin_with(workspace: Workspace, paths: Paths, i: int, end: int) -> int:
    """Let the draft consist of the first `end` nodes of path i; return its length."""
    draft, row = workspace.draft, paths.nodes[i]
    for j in range(end):
        draft[j] = row[j]
    return end


@query
def copy_in(workspace: Workspace, at: int, paths: Paths, i: int, first: int, end: int) -> int:
    """Copy nodes first:end of path i into the draft, from position `at` on; return the draft's new length.

    What exceeds the draft's capacity is left out: the draft is still a path, but one that does not reach the goal.
    """
    draft, row = workspace.draft, paths.nodes[i]
    end = min(end, first + len(draft) - at)
    for j in range(first, end):
        draft[at + j - first] = row[j]
    return at + max(0, end - first)


@query
def put(paths: Paths, i: int, workspace: Workspace, length: int, price: float) -> None:
    """Replace path i by the draft, whose cost is `price`."""
    draft, row = workspace.draft, paths.nodes[i]
    for j in range(length):
        row[j] = draft[j]
    paths.length[i] = length
    paths.cost[i] = price


@query
def random_node(grid: Grid, rng: Generator) -> int:
    """Return a random node from which a move leads."""
    while True:
        node = int(rng.random() * len(grid.exits))
        if grid.exits[node]:
            return node


@query
def random_node_near(
    exits: Exits, nx: int, ny: int, nz: int, rng: Generator, node: int, tdr: float, least: float
) -> int:
    """Return a random free node that lies near a node on every axis; the node itself if 100 tries find none.

    Near is within the share TDR of the lattice's extent, or within `least` steps where that is more.
    """
    i, j, k = node // (ny * nz), (node // nz) % ny, node % nz
    for _ in range(100):
        x = min(max(i + round((2.0 * rng.random() - 1.0) * max(least, tdr * (nx - 1))), 0), nx - 1)
        y = min(max(j + round((2.0 * rng.random() - 1.0) * max(least, tdr * (ny - 1))), 0), ny - 1)
        z = min(max(k + round((2.0 * rng.random() - 1.0) * max(least, tdr * (nz - 1))), 0), nz - 1)
        near = (x * ny + y) * nz + z
        if exits[near]:
            return near
    return node


@query
def detour(task: LatticeTask, workspace: Workspace, rng: Generator, length: int, threshold: int, retries: int) -> int:
    """Continue the draft by a walk to a random free node; return the draft's new length.

    A walk that gives up is replaced by one to another node, at most `retries` times; the last one stays in any case.
    """
    walked = length
    for _ in range(retries + 1):
        node = random_node(task.grid, rng)
        walked = _walk(task, workspace, rng, length, node, threshold)
        if workspace.draft[abs(walked) - 1] == node:
            break
    return _cut(workspace, length, walked)


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


@query
def adopt(task: LatticeTask, workspace: Workspace, U: Paths, i: int, best: Paths, length: int) -> None:
    """Price the draft, replace path i by it, and the best path too if the draft is cheaper."""
    price = judge(task, workspace, length)
    put(U, i, workspace, length, price)
    if price < best.cost[0]:
        put(best, 0, workspace, length, price)
