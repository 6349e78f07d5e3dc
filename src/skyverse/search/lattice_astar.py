"""Cheapest lattice paths, exactly: A* and Dijkstra over nodes, or over nodes and headings where turns are priced.

A turn is a non-zero cross product of consecutive steps, which does not tell a direction from its opposite. So a state
is a node and the *axis* of the last move, which makes half as many states as nodes and directions would. The cheapest
state of a node can move on along every axis for one turn more. So another state of the node matters only if it is
cheaper than that, and then only for the moves along its own axis.

States wait in buckets by their f = g + h; a bucket is as wide as the cheapest step. Within a bucket a state that
improves is opened again, so that the order inside does not matter and the answer is exact for any weights.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.cost import Pricing, add_soft
from skyverse.numerics.arrays import doubled
from skyverse.numerics.kernel import inner, inner_query, kernel, query
from skyverse.numerics.tolerances import PRICE_ROUNDING
from skyverse.search.few_turns import CLOSED, ORIGIN, SEEN, price_with_few_turns
from skyverse.space.lattice import Grid, write_position

BYTES_PER_STATE = 9
"""A float64 for g, and a byte for flags and parent; each state that waits takes another 16 bytes."""

_SOFT_BUCKETS = 4096


class LatticePath(NamedTuple):
    """A cheapest path: its nodes (n,) from source to goal, its price without the end term, and the states expanded."""

    nodes: Ints
    price: float
    expanded: int


def shortest_route(grid: Grid, pricing: Pricing, source: int, goal: int, most: float = math.inf) -> LatticePath | None:
    """Find a cheapest path between two nodes under fuel, turns and soft terms.

    ``None`` is returned where there is no path, or none whose price is at most `most`.

    Soft terms are paid move by move. The bounds on the price that is left do without them, since none is below 0.

    Where turns are priced, a search backward from the goal over nodes alone first gives the exact length left from
    every node that can matter. The search over node and axis is guided by it, and cut off at the full price of a
    shortest path with few turns.
    """
    unguided = np.empty(0)
    most -= pricing.first
    if pricing.turn == 0.0:
        found = _search(grid, pricing, _Query(False, _unseen(grid, 1), source, np.array([goal]), goal, unguided, most))
        expanded = found.expanded
    else:
        query = _Query(False, _unseen(grid, 1), goal, np.array([source]), source, unguided, math.inf)
        back = _search(grid, pricing, query)
        if len(back.nodes) == 0:
            return None
        info, ceiling = _unseen(grid, len(grid.offsets) // 2), min(back.ceiling, most)
        found = _search(grid, pricing, _Query(True, info, source, np.array([goal]), goal, back.lengths, ceiling))
        expanded = back.expanded + found.expanded
    if len(found.nodes) == 0:
        return None
    return LatticePath(found.nodes, float(pricing.first + found.prices[0]), int(expanded))


def prices_to(grid: Grid, pricing: Pricing, source: int, goals: Ints) -> Floats:
    """Return the price of a cheapest path from one node to each of (n,) goals, infinite where there is none."""
    wanted, order = np.unique(np.asarray(goals, dtype=np.int64), return_inverse=True)
    turning = pricing.turn > 0.0
    info = _unseen(grid, len(grid.offsets) // 2 if turning else 1)
    found = _search(grid, pricing, _Query(turning, info, source, wanted, -1, np.empty(0), math.inf))
    return np.asarray(pricing.first + found.prices[order])


def _unseen(grid: Grid, axes: int) -> NDArray[np.uint8]:
    """Return the flags of states, none of which was seen yet.

    A kernel would clear all of them, numpy only those that are read.
    """
    return np.zeros(len(grid.exits) * axes, np.uint8)


class _Query(NamedTuple):
    """What a search is for.

    Attributes
    ----------
    turning
        Whether states have an axis and turns are paid. If not, and turns have a price, the ceiling becomes the full
        price of a shortest path with few turns, and every state below it is settled.
    info
        (states,) the flags of every state, which are 0.
    source, goals
        The node where it begins, and sorted nodes.
    towards
        The goal of the bound that ignores obstacles; -1 for no bound (Dijkstra).
    guide
        (nodes,) exact lengths left to the goal, or empty.
    ceiling
        States whose f lies above it are dropped.
    """

    turning: bool
    info: NDArray[np.uint8]
    source: int
    goals: Ints
    towards: int
    guide: Floats
    ceiling: float


class _Settled(NamedTuple):
    """What a search found.

    Attributes
    ----------
    nodes
        (n,) the path to the goal that was settled last; empty if none was.
    prices
        The goals' prices.
    lengths
        (nodes,) the length to each settled node, infinite for others; empty where it is not needed.
    ceiling
        The f above which states were dropped in the end.
    expanded
        How many states were expanded.
    """

    nodes: Ints
    prices: Floats
    lengths: Floats
    ceiling: float
    expanded: int


@query
def _steps_left(grid: Grid, pricing: Pricing, x: int, y: int, z: int) -> float:
    """Return the price of the steps that lead x, y, z nodes farther, without obstacles."""
    dx, dy, dz = abs(x), abs(y), abs(z)
    if len(grid.offsets) == 6:
        return pricing.steps[1] * dx + pricing.steps[2] * dy + pricing.steps[4] * dz
    # a step along several axes costs less than one along each (the price is submodular): combine as many as possible
    three = min(dx, dy, dz)
    rx, ry, rz = dx - three, dy - three, dz - three
    if rz == 0:
        pair, both, rest = min(rx, ry), 3, 1 if rx > ry else 2
    elif ry == 0:
        pair, both, rest = min(rx, rz), 5, 1 if rx > rz else 4
    else:
        pair, both, rest = min(ry, rz), 6, 2 if ry > rz else 4
    single = rx + ry + rz - 2 * pair
    return pricing.steps[7] * three + pricing.steps[both] * pair + pricing.steps[rest] * single


@query
def _turns_left(grid: Grid, axis: int, x: int, y: int, z: int) -> int:
    """Return how many turns a path at least makes that goes x, y, z nodes farther after a move along an axis."""
    if len(grid.offsets) == 6:
        axes_left = (1 if x else 0) + (1 if y else 0) + (1 if z else 0)
        along = (axis == 0 and x != 0) or (axis == 1 and y != 0) or (axis == 2 and z != 0)
        return axes_left - 1 if along and axes_left else axes_left
    longest = max(abs(x), abs(y), abs(z))
    straight = (x == 0 or abs(x) == longest) and (y == 0 or abs(y) == longest) and (z == 0 or abs(z) == longest)
    if straight:
        mx, my, mz = grid.moves[2 * axis, 0], grid.moves[2 * axis, 1], grid.moves[2 * axis, 2]
        straight = y * mz == z * my and z * mx == x * mz and x * my == y * mx
    return 0 if straight else 1


@inner
def _walk_back(grid: Grid, info: NDArray[np.uint8], state: int, axes: int) -> Ints:
    """Return the nodes from the source to a state."""
    length = 1
    at = state
    while info[at] & ORIGIN != ORIGIN:
        at = _parent(grid, info, at, axes)
        length += 1
    nodes = np.empty(length, np.int64)
    at = state
    for i in range(length - 1, 0, -1):
        nodes[i] = at // axes
        at = _parent(grid, info, at, axes)
    nodes[0] = at // axes
    return nodes


@inner_query
def _parent(grid: Grid, info: NDArray[np.uint8], state: int, axes: int) -> int:
    """Return the state from which a state was reached."""
    flags = info[state]
    if axes == 1:
        return state - grid.offsets[flags & ORIGIN]
    move = 2 * (state % axes) + ((flags >> 5) & 1)
    return (state // axes - grid.offsets[move]) * axes + (flags & ORIGIN)


@inner_query
def _index(goals: Ints, node: int) -> int:
    """Return the place of a node among sorted goals, or where it would be inserted."""
    low, high = 0, len(goals)
    while low < high:
        middle = (low + high) // 2
        if goals[middle] < node:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _search(grid: Grid, pricing: Pricing, query: _Query) -> _Settled:
    """Search from one node until every goal is settled, and every state whose f is at most the ceiling, too."""
    turning, info, source, goals, towards, guide, ceiling = query
    # least: the least price seen of each node; turned: the price from which all moves of a node were last priced
    # read once: in the loop they would be read again after every write to an array
    offsets, moves, safe_moves, turn = grid.offsets, grid.moves, grid.exits, pricing.turn
    axes = len(offsets) // 2 if turning else 1
    count = len(info)
    g = np.empty(count, np.float64)
    step_price = np.empty(len(offsets))
    width, dearest = math.inf, 0.0
    for m in range(len(offsets)):
        step_price[m] = pricing.steps[abs(moves[m, 0]) + 2 * abs(moves[m, 1]) + 4 * abs(moves[m, 2])]
        width, dearest = min(width, step_price[m]), max(dearest, step_price[m])
    if turning:
        width = max(min(width, turn), 0.02 * dearest)
    widest = 2.0 * dearest + turn * 2.0
    buckets = math.ceil(widest / width) + 3
    soft = pricing.rates.soft
    if soft:  # moves may cost any amount: a state that belongs beyond all buckets waits in the last one
        buckets = max(buckets, _SOFT_BUCKETS)
    least = np.full(len(safe_moves) if turning else 0, math.inf)
    turned = np.full(len(safe_moves) if turning else 0, math.inf)
    shares = np.zeros(3)
    a, b = np.empty(3), np.empty(3)
    head = np.full(buckets, -1, np.int64)
    waiting_state = np.empty(1024, np.int64)
    waiting_next = np.empty(1024, np.int64)
    prices = np.full(len(goals), math.inf)
    unsettled = len(goals)
    reached = -1
    lengths_wanted = not turning and turn > 0.0 and towards >= 0

    ny, nz = grid.shape[1], grid.shape[2]
    tx, ty, tz = towards // (ny * nz), (towards // nz) % ny, towards % nz
    base = 0.0
    if towards >= 0:
        x, y, z = tx - source // (ny * nz), ty - (source // nz) % ny, tz - source % nz
        base = guide[source] if len(guide) else _steps_left(grid, pricing, x, y, z)
    state = source * axes
    g[state] = 0.0
    if turning:
        least[source] = 0.0
    info[state] = SEEN | ORIGIN
    waiting_state[0] = state
    waiting_next[0] = -1
    head[0] = 0
    entries = 1
    spare = -1
    waiting = 1
    current = 0
    expanded = 0
    while waiting:
        slot = current % buckets
        entry = head[slot]
        if entry < 0:
            current += 1
            if unsettled == 0 and lengths_wanted and ceiling == math.inf and base + current * width > prices[0]:
                ceiling = price_with_few_turns(grid, pricing, info, g, goals[0])
            if unsettled == 0 and base + current * width > ceiling:
                break
            continue
        head[slot] = waiting_next[entry]
        waiting_next[entry] = spare
        spare = entry
        waiting -= 1
        state = waiting_state[entry]
        if info[state] & CLOSED:
            continue
        here = g[state]
        node = state // axes
        if soft:
            f = here
            if towards >= 0:
                bx, by, bz = tx - node // (ny * nz), ty - (node // nz) % ny, tz - node % nz
                f += guide[node] if len(guide) else _steps_left(grid, pricing, bx, by, bz)
                if turning and info[state] & ORIGIN != ORIGIN:
                    f += turn * _turns_left(grid, state % axes, bx, by, bz)
            due = int((f - base) / width)
            if due > current:
                slot = min(due, current + buckets - 1) % buckets
                spare = waiting_next[entry]
                waiting_next[entry] = head[slot]
                head[slot] = entry
                waiting += 1
                continue
        info[state] |= CLOSED
        if turning and here > least[node] + turn:
            continue
        expanded += 1
        where = _index(goals, node)
        if where < len(goals) and goals[where] == node and here < prices[where]:
            if prices[where] == math.inf:
                unsettled -= 1
            prices[where] = here
            reached = state
            if unsettled == 0 and not lengths_wanted:
                furthest = 0.0
                for settled in prices:
                    furthest = max(furthest, settled)
                ceiling = min(ceiling, furthest)
        exits = int(np.int64(safe_moves[node]))
        axis = state % axes
        fresh = info[state] & ORIGIN == ORIGIN
        if turning:
            if here < turned[node] - PRICE_ROUNDING * here and here <= least[node] + PRICE_ROUNDING * here:
                turned[node] = here
            else:
                exits &= 3 << 2 * axis
        x, y, z = tx - node // (ny * nz), ty - (node // nz) % ny, tz - node % nz
        if soft:
            write_position(grid, node, a)
        for m in range(len(offsets)):
            if not (exits >> m) & 1:
                continue
            beyond = node + offsets[m]
            price = here + step_price[m]
            after = beyond
            if turning:
                if m >> 1 != axis and not fresh:
                    price += turn
                if price >= least[beyond] + turn - PRICE_ROUNDING * price:
                    continue
                if len(guide) and price + guide[beyond] > ceiling + PRICE_ROUNDING * ceiling:
                    continue
                after = beyond * axes + (m >> 1)
            if info[after] & SEEN and price >= g[after] - PRICE_ROUNDING * price:
                continue
            left = 0.0
            if towards >= 0:
                bx, by, bz = x - moves[m, 0], y - moves[m, 1], z - moves[m, 2]
                left = guide[beyond] if len(guide) else _steps_left(grid, pricing, bx, by, bz)
                if turning:
                    left += turn * _turns_left(grid, m >> 1, bx, by, bz)
            if price + left > ceiling + PRICE_ROUNDING * ceiling:
                continue
            if soft:
                write_position(grid, beyond, b)
                shares[0] = shares[1] = shares[2] = 0.0
                add_soft(pricing.rates, a, b, shares)
                price += shares[0] + shares[1] + shares[2]
                known = g[after] if info[after] & SEEN else math.inf
                if turning:
                    known = min(known, least[beyond] + turn)
                if price >= known - PRICE_ROUNDING * price or price + left > ceiling + PRICE_ROUNDING * ceiling:
                    continue
            f = price + left
            if turning:
                least[beyond] = min(least[beyond], price)
            g[after] = price
            info[after] = SEEN | (((m & 1) << 5) | axis if turning else m)
            slot = min(max(int((f - base) / width), current), current + buckets - 1) % buckets
            if spare >= 0:
                entry = spare
                spare = waiting_next[entry]
            else:
                if entries == len(waiting_state):
                    waiting_state = doubled(waiting_state)
                    waiting_next = doubled(waiting_next)
                entry = entries
                entries += 1
            waiting_state[entry] = after
            waiting_next[entry] = head[slot]
            head[slot] = entry
            waiting += 1
    lengths = np.empty(0)
    if lengths_wanted:
        if unsettled == 0 and ceiling == math.inf:  # nothing waits that is longer than the path
            ceiling = price_with_few_turns(grid, pricing, info, g, goals[0])
        lengths = np.full(count, math.inf)
        for node in range(count):
            if info[node] & CLOSED:
                lengths[node] = g[node]
    nodes = _walk_back(grid, info, reached, axes) if reached >= 0 else np.empty(0, np.int64)
    return _Settled(nodes, prices, lengths, ceiling, expanded)
