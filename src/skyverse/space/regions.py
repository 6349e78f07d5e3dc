"""Regions of free space: which places the lattice joins, so that a UAV can fly from one to another."""

import itertools

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skyverse._typing import Floats, Ints
from skyverse.model.scenario import Lattice
from skyverse.space.lattice import make_grid, positions
from skyverse.space.world import World

CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
"""The index steps from the lowest node of a lattice's cell to its eight corners."""


class Regions:
    """The regions of free space that the moves of a lattice join.

    Parameters
    ----------
    world
        What is free.
    lattice
        The lattice.
    """

    def __init__(self, world: World, lattice: Lattice) -> None:
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        self._world, self._grid = world, make_grid(world, lattice)
        exits, count = self._grid.exits, len(self._grid.exits)
        begins = [np.flatnonzero(exits & (1 << move)) for move in range(0, len(self._grid.moves), 2)]
        ends = [nodes + self._grid.offsets[2 * axis] for axis, nodes in enumerate(begins)]
        a, b = np.concatenate(begins), np.concatenate(ends)
        joined = coo_array((np.ones(len(a), dtype=np.bool_), (a, b)), shape=(count, count))
        self._label: Ints = np.where(exits != 0, connected_components(joined, directed=False)[1], -1)

    def of(self, points: ArrayLike) -> set[int]:
        """Return the regions that any of (n, 3) places in metres lie in."""
        return set(self._labels(np.array(points, dtype=np.float64).reshape(-1, 3)).ravel().tolist()) - {-1}

    @property
    def largest(self) -> int:
        """The region of most nodes."""
        return int(np.bincount(self._label[self._label >= 0], minlength=1).argmax())

    def hold(self, points: Floats, regions: set[int]) -> NDArray[np.bool_]:
        """Tell for each of (n, 3) places in metres whether it lies in one of some regions, (n,)."""
        return np.asarray(np.isin(self._labels(points), list(regions)).any(axis=1))

    def _labels(self, points: Floats) -> Ints:
        """Return the regions of the nodes around each place that are joined to it, (n, 8), -1 for others."""
        shape = np.array(self._grid.shape)
        low = np.floor((points - self._grid.origin) / self._grid.step).astype(np.int64)
        nodes = np.sum(np.clip(low[:, None] + CORNERS, 0, shape - 1) * [shape[1] * shape[2], shape[2], 1], axis=2)
        found = self._label[nodes]
        asked = np.argwhere(found >= 0)
        starts = points[asked[:, 0]]
        free = self._world.segments_free(starts, positions(self._grid, nodes[tuple(asked.T)]))
        found[tuple(asked[~free].T)] = -1
        return found
