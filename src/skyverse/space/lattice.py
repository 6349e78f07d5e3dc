"""The lattice over a world: its nodes, the safe moves from each, and the nodes that stand for given points.

The node with the indices (i, j, k) is the integer ``(i * ny + j) * nz + k``. Moves come in opposite pairs: moves ``m``
and ``m ^ 1`` undo each other, and ``m >> 1`` is their common axis. ``exits[node]`` has bit m set where move m is safe.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skyverse._typing import Floats, Ints
from skyverse.model.scenario import Lattice
from skyverse.numerics.kernel import by_reference, inner_query, kernel
from skyverse.numerics.tolerances import CLOSED_MARGIN, GRID_INDEX, SURFACE_DEPTH
from skyverse.space import blocks
from skyverse.space.obstacles import Space
from skyverse.space.tracking_error import NO_ERROR
from skyverse.space.world import World, segment_free


@by_reference
class Grid(NamedTuple):
    """A compiled lattice.

    Attributes
    ----------
    origin, step, shape
        (3,) each: the first node's place in metres, the metres between nodes, and the nodes along each axis.
    exits
        (nodes,) int32, the safe moves of each node as bits; 0 for a blocked or enclosed node.
    moves, offsets
        (k, 3) index steps and (k,) steps in node numbers.
    toward
        (27,) the moves, as bits, that lead nearer to a goal on every axis that they change; indexed by the signs of the
        steps left to it on the three axes.
    """

    origin: Floats
    step: Floats
    shape: Ints
    exits: NDArray[np.int32]
    moves: Ints
    offsets: Ints
    toward: Ints


def lattice_moves(connectivity: int) -> Ints:
    """Return the (k, 3) index steps of a 6- or 26-connected lattice, in opposite pairs, axes first."""
    half = [m for m in itertools.product((1, 0, -1), repeat=3) if m > (0, 0, 0)]
    half.sort(key=lambda m: (sum(map(abs, m)), [-v for v in m]))
    pairs = [step for m in half[: connectivity // 2] for step in (m, tuple(-v for v in m))]
    return np.array(pairs, dtype=np.int64)


def make_grid(world: World, lattice: Lattice) -> Grid:
    """Compile a lattice over a world: which nodes are blocked, and which moves from the others are safe."""
    space = world.space
    step = np.array(lattice.step)
    origin = world.low
    shape = np.floor((world.high - origin) / step + GRID_INDEX).astype(np.int64) + 1
    touched = np.zeros(tuple(shape), np.uint8)
    growth = space.clearance + CLOSED_MARGIN  # moves may not even touch what is grown by the clearance
    blocks.mark_boxes(space.boxes, growth, origin, step, shape, touched)
    blocks.mark_solids(space.solids, growth, origin, step, shape, touched)
    blocks.mark_ground(space.ground, growth, origin, step, shape, touched)
    blocks.mark_ceiling(space.ceiling, growth, origin, step, shape, touched)
    if world.error != NO_ERROR:
        _mark_outside(space, origin, step, touched)
    moves = lattice_moves(lattice.connectivity)
    offsets = np.sum(moves * np.array([shape[1] * shape[2], shape[2], 1]), axis=1)
    exits = _safe_moves(touched, moves)
    return Grid(origin, step, shape, exits, moves, offsets, _toward(moves))


def _mark_outside(space: Space, origin: Floats, step: Floats, touched: NDArray[np.uint8]) -> None:
    """Mark the blocks that are not within the bounds, which do not end where the lattice does for a UAV that strays."""
    for axis in range(3):
        places = origin[axis] + np.arange(touched.shape[axis]) * step[axis]
        out = (places < space.low[axis] - SURFACE_DEPTH) | (places > space.high[axis] + SURFACE_DEPTH)
        if not out.any():
            continue
        either = out | np.append(out[1:], False)
        marks = np.zeros(len(out), np.uint8)
        for block in range(8):
            marks |= (either if block >> axis & 1 else out).astype(np.uint8) << block
        touched |= marks.reshape([-1 if other == axis else 1 for other in range(3)])


def _toward(moves: Ints) -> Ints:
    """Return `Grid.toward` for these moves."""
    masks = np.zeros(27, np.int64)
    for code, signs in enumerate(itertools.product((-1, 0, 1), repeat=3)):
        for m, move in enumerate(moves):
            if all(v in (0, s) for v, s in zip(move, signs, strict=True)):
                masks[code] |= 1 << m
    return masks


@kernel
def _safe_moves(touched: NDArray[np.uint8], moves: Ints) -> NDArray[np.int32]:
    """Return `Grid.exits`: the moves whose blocks are not touched, from nodes that are not touched."""
    nx, ny, nz = touched.shape
    exits = np.zeros(nx * ny * nz, np.int32)
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if touched[i, j, k] & 1:
                    continue
                open_moves = 0
                for m in range(moves.shape[0]):
                    dx, dy, dz = moves[m, 0], moves[m, 1], moves[m, 2]
                    if not (0 <= i + dx < nx and 0 <= j + dy < ny and 0 <= k + dz < nz):
                        continue
                    block = abs(dx) + 2 * abs(dy) + 4 * abs(dz)
                    if not (touched[i + min(dx, 0), j + min(dy, 0), k + min(dz, 0)] >> block) & 1:
                        open_moves |= 1 << m
                exits[(i * ny + j) * nz + k] = open_moves
    return exits


@kernel
def position(grid: Grid, node: int) -> Floats:
    """Return a node's place, (3,) metres."""
    p = np.empty(3)
    write_position(grid, node, p)
    return p


@inner_query
def write_position(grid: Grid, node: int, p: Floats) -> None:
    """Write a node's place, (3,) metres, into `p`."""
    rest = node
    for axis in range(2, -1, -1):
        p[axis] = grid.origin[axis] + (rest % grid.shape[axis]) * grid.step[axis]
        rest //= grid.shape[axis]


def positions(grid: Grid, nodes: ArrayLike) -> Floats:
    """Return the places of (n,) nodes, (n, 3) metres."""
    indices = np.stack(np.unravel_index(np.asarray(nodes, dtype=np.int64), tuple(grid.shape)), axis=-1)
    return np.asarray(grid.origin + indices * grid.step)


def snap(grid: Grid, space: Space, point: Floats) -> tuple[int, bool]:
    """Find the node that stands for a point: within a step of it on every axis, and seen from it.

    The lower corner of the point's cell is tried first, because the thesis rounds down, then others by distance.

    Returns
    -------
    node
        Its number; -1 where none can be reached.
    shut_in
        Whether no safe move leads on from any node that can be reached.
    """
    cell = (point - grid.origin) / grid.step
    lowest = np.clip(np.floor(cell + GRID_INDEX).astype(np.int64), 0, grid.shape - 1)
    near = [lowest + np.array(reach) for reach in itertools.product((-1, 0, 1), repeat=3) if any(reach)]
    near = [c for c in near if np.all((c >= 0) & (c < grid.shape) & (np.abs(c - cell) <= 1 + GRID_INDEX))]
    near.sort(key=lambda c: math.dist(c * grid.step, cell * grid.step))
    fallback = -1
    for i, j, k in (lowest, *near):
        node = int((i * grid.shape[1] + j) * grid.shape[2] + k)
        if segment_free(space, point, position(grid, node)):
            if grid.exits[node]:
                return node, False
            fallback = node if fallback < 0 else fallback
    return fallback, fallback >= 0
