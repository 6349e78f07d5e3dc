"""An oracle of the lattice: which moves are free, and what the cheapest path between two nodes costs, by Dijkstra.

It is slow and obvious on purpose: every move is judged by the referee's geometry, and nothing is shared with the
planners, whose optima it is compared with.
"""

import heapq
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.referee.boxes import GrownBoxes
from skyverse.referee.overlaps import blocks
from skyverse.referee.round_solids import GrownCylinders, GrownEllipsoids
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import find_peaks
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.tracking_error import EXACT
from skyverse.referee.world import RefereeWorld, referee_world
from soft_terms import altitude_term, climb_term, risk_term

MOVES_AT_ONCE = 200_000
"""Moves judged together, which bounds the memory."""
LATTICE_ROUNDING = 1e-9
"""Share of a lattice step: bounds that are shorter than whole steps by no more than this hold their last nodes."""
LATTICE_MARGIN = 4e-6
"""Metres: planners need not use nodes that keep clear by less; they block those within 3e-6 m of an obstacle."""


def cheapest_costs(scenario: Scenario, start: Floats, goal: Floats) -> tuple[float, float]:
    """Return what the cheapest path between two nodes, (3,) metres, costs at least and at most.

    The least counts moves that are free with what the referee lets pass, the most only those that every planner has to
    use, and of zones along a surface all the risk that may be counted.
    """
    least = _cheapest(referee_world(scenario), start, goal, strict=False)
    return least, _cheapest(referee_world(_farther(scenario)), start, goal, strict=True)


def _cheapest(world: RefereeWorld, start: Floats, goal: Floats, strict: bool) -> float:
    lattice, objective = judged_lattice(world, strict=strict), world.scenario.objective
    first, last = lattice.node(start), lattice.node(goal)
    assert first is not None
    assert last is not None
    lengths = np.linalg.norm(lattice.moves * lattice.step, axis=1)
    by_nodes = objective.unit == "nodes"
    fuel = objective.fuel * (np.ones(len(lengths)) if by_nodes else lengths)

    def price(a: int, b: int) -> float:
        return soft_price(world, np.stack([lattice.position(a), lattice.position(b)]), by_nodes, strict)

    soft = objective.altitude is not None or objective.climb is not None or bool(world.scenario.risky_zones)
    cost, _ = cheapest_path(lattice, first, last, price if soft else fuel, objective.divergence)
    return cost + (objective.fuel if by_nodes else 0.0)


def soft_price(world: RefereeWorld, leg: Floats, by_nodes: bool, strict: bool) -> float:
    """Return what a leg (2, 3) costs with its soft terms; of risks along a surface the least, or if strict the most."""
    objective = world.scenario.objective
    total = objective.fuel * (1.0 if by_nodes else math.dist(leg[1], leg[0]))
    if objective.altitude is not None:
        total += objective.altitude.weight * altitude_term(objective.altitude, leg)
    if objective.climb is not None:
        total += objective.climb.weight * climb_term(objective.climb, leg)
    if world.scenario.risky_zones:
        _, least, most = risk_term(world.scenario, leg)
        total += objective.risk * (most if strict else least)
    return total


def _farther(scenario: Scenario) -> Scenario:
    """Return a scenario in which everything must be kept farther away by `LATTICE_MARGIN`."""
    return derived(scenario, clearance=scenario.clearance + LATTICE_MARGIN)


@dataclass(frozen=True, eq=False)
class RefereeLattice:
    """A lattice whose moves were judged.

    Attributes
    ----------
    low, step
        (3,) metres: the first node, and the distance between neighbours.
    shape
        (3,) nodes along each axis.
    moves
        (m, 3) steps; each stands for both directions.
    free
        (m, n) whether the move from each of the n nodes is free, with the last axis of nodes running fastest.
    """

    low: Floats
    step: Floats
    shape: Indices
    moves: Indices
    free: NDArray[np.bool_]

    def node(self, position: Floats) -> int | None:
        """Return the number of the node at a position (3,), or ``None`` if there is none within `LET_PASS`."""
        index = np.rint((position - self.low) / self.step)
        if (np.abs(self.low + index * self.step - position) > LET_PASS).any():
            return None
        if (index < 0).any() or (index >= self.shape).any():
            return None
        return int(np.ravel_multi_index(tuple(index.astype(np.intp)), tuple(self.shape)))

    def is_free(self, move: int, node: int) -> bool:
        """Tell whether a move from a node, which may be a number that no node has, is free."""
        return 0 <= node < self.free.shape[1] and bool(self.free[move, node])

    @property
    def offsets(self) -> list[int]:
        """The difference in number that each move makes."""
        strides = np.array([self.shape[1] * self.shape[2], self.shape[2], 1])
        return [int(offset) for offset in np.sum(self.moves * strides, axis=1)]

    def position(self, node: int) -> Floats:
        """Return the position (3,) of a node, metres."""
        return self.low + np.array(np.unravel_index(node, tuple(self.shape))) * self.step


def lattice_shape(world: RefereeWorld) -> Indices:
    """Return the number of nodes along each axis, (3,)."""
    extent = np.array(world.scenario.bounds.max) - world.first_node
    return np.floor(extent / world.step + LATTICE_ROUNDING).astype(np.intp) + 1


def judged_lattice(world: RefereeWorld, *, strict: bool) -> RefereeLattice:
    """Judge every move of a world's lattice; what cannot be decided is free, or blocked if `strict`."""
    shape, connectivity = lattice_shape(world), world.scenario.lattice.connectivity
    steps = np.array([move for move in product((-1, 0, 1), repeat=3) if move > (0, 0, 0)], dtype=np.intp)
    if connectivity == 6:
        steps = steps[np.count_nonzero(steps, axis=1) == 1]
    index = np.argwhere(np.ones(shape, dtype=bool))
    places = world.first_node + index * world.step
    usable = np.ones(shape, dtype=bool)
    if world.error != EXACT:  # then the bounds do not end where the lattice does
        inset = LET_PASS if strict else -LET_PASS
        within = (places >= world.low + inset) & (places <= world.high - inset)
        usable = within.all(axis=1).reshape(shape)
    free = np.zeros((len(steps), len(index)), dtype=bool)
    for row, move in zip(free, steps, strict=True):
        inside = np.flatnonzero(((index + move >= 0) & (index + move < shape)).all(axis=1))
        for some in (inside[block] for block in blocks(len(inside), MOVES_AT_ONCE)):
            row[some] = free_moves(world, places[some], world.first_node + (index[some] + move) * world.step, strict)
            row[some] &= usable[tuple(index[some].T)] & usable[tuple((index[some] + move).T)]
    return RefereeLattice(world.first_node, world.step, shape, steps, free)


def free_moves(world: RefereeWorld, starts: Floats, ends: Floats, strict: bool) -> NDArray[np.bool_]:
    """Tell which moves between starts and ends, (n, 3) metres, are free; see `judged_lattice`.

    A move is free if the whole block is clear of all grown shapes of which the two nodes are opposite corners, as no
    corner may be cut. The block of a straight move is the move itself.
    """
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    free = np.ones(len(low), dtype=bool)
    for kind in (world.boxes, *world.others):
        if not isinstance(kind, (GrownBoxes, *_ROUND)):
            some = np.flatnonzero(free)
            free[some] = _clear_of(kind, np.stack([starts[some], ends[some]], axis=1), strict)
            continue
        for pairs in kind.tree.overlapping(low, high):
            block, shape = pairs.T
            if isinstance(kind, _ROUND):
                axes = slice(0, 3 if isinstance(kind, GrownEllipsoids) else 2)
                centre = kind.centre[shape]
                nearest = np.clip(centre, low[block, axes], high[block, axes])
                block = block[np.linalg.norm(nearest - centre, axis=1) < kind.grown_radius[shape]]
            free[block] = False
    return free


_ROUND = (GrownEllipsoids, GrownCylinders)


def _clear_of(kind: GrownSolids, b: Floats, strict: bool) -> NDArray[np.bool_]:
    """Tell which segments (n, 2, 3) may be clear of the grown shapes of one kind, or if `strict` which surely are."""
    wrong = kind.error(b, np.zeros(len(b)))
    low, high = b.min(axis=1) - wrong[:, None], b.max(axis=1) + wrong[:, None]
    clear = np.ones(len(b), dtype=bool)
    for pairs in kind.tree.overlapping(low, high):
        if len(pairs):
            segment, shape = pairs.T
            of, question = np.unique(segment, return_inverse=True)

            def depth(part: Floats, pair: Indices, shape: Indices = shape) -> Floats:
                return kind.depth(part, shape[pair])

            peaks = find_peaks(b[segment], wrong[segment], depth, question, len(of))
            clear[of[~peaks.proven if strict else peaks.refuted]] = False
    return clear


Price = Callable[[int, int], float]
"""The price of the move between two nodes, in the objective's unit."""


def cheapest_path(
    lattice: RefereeLattice, start: int, goal: int, price: Price | Floats, price_of_turn: float
) -> tuple[float, list[int]]:
    """Return the price of the cheapest path from a start to a goal, and its nodes; infinite and none if there is none.

    A state is a node and the move by which it was entered, where turns have a price, and otherwise a node. Going back
    the way one came is no turn.

    Parameters
    ----------
    lattice
        The lattice.
    start, goal
        The numbers of nodes.
    price
        (m,) the price of each move, or a function of two nodes.
    price_of_turn
        What a turn costs.
    """
    offsets = lattice.offsets
    kinds = len(offsets) if price_of_turn > 0 else 1
    best, came_from, done = {(start, -1): 0.0}, {(start, -1): (start, -1)}, set()
    queue = [(0.0, start, -1)]
    while queue:
        cost, node, entered = heapq.heappop(queue)
        if node == goal:
            return cost, _walked_back(came_from, (node, entered))
        if (node, entered) in done:
            continue
        done.add((node, entered))
        for move, offset in enumerate(offsets):
            for other, at in ((node + offset, node), (node - offset, node - offset)):
                if not lattice.is_free(move, at):
                    continue
                turned = price_of_turn if entered not in (-1, move) and kinds > 1 else 0.0
                step = price(node, other) if callable(price) else float(price[move])
                state = (other, move if kinds > 1 else 0)
                total = cost + step + turned
                if total < best.get(state, np.inf):
                    best[state], came_from[state] = total, (node, entered)
                    heapq.heappush(queue, (total, *state))
    return np.inf, []


def reachable_nodes(lattice: RefereeLattice, starts: Iterable[int]) -> set[int]:
    """Return all nodes to which free moves lead from any of the starts, the starts included."""
    offsets = lattice.offsets
    reached = set(starts)
    queue = list(reached)
    while queue:
        node = queue.pop()
        for move, offset in enumerate(offsets):
            for other, at in ((node + offset, node), (node - offset, node - offset)):
                if lattice.is_free(move, at) and other not in reached:
                    reached.add(other)
                    queue.append(other)
    return reached


def _walked_back(came_from: dict[tuple[int, int], tuple[int, int]], state: tuple[int, int]) -> list[int]:
    """Return the nodes of a path from its start to a state."""
    nodes = [state[0]]
    while came_from[state] != state:
        state = came_from[state]
        nodes.append(state[0])
    return nodes[::-1]
