"""Which cells the photos of a survey are certain to show, how often, and how finely."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Bools, Floats
from skyverse.interrupt import raise_if_interrupted
from skyverse.referee.blockers import Blockers
from skyverse.referee.ground_cells import CellGrid, Pieces, joined
from skyverse.referee.photo_views import PhotoView
from skyverse.referee.relief import GroundRelief, Places
from skyverse.referee.tolerances import LET_PASS, LIMIT_LET_PASS

IN_BLOCK = 8
"""Cells along each side of the blocks that are looked at together for whether the ground hides them."""
CLOSER = 4
"""How often cells are cut in four to tell how deep they are where a photo shows them."""


@dataclass(frozen=True, eq=False)
class Shown:
    """How often cells are certain to be shown, and how deep they are in the photo that shows them best.

    Attributes
    ----------
    count
        (...,) photos.
    depth
        (...,) metres along the optical axis at most; infinite where no photo counts.
    touched
        (...,) whether a corner is in view of some photo, fine enough, and not behind a wall with all of the cell.
    """

    count: Floats
    depth: Floats
    touched: Bools

    @classmethod
    def nothing(cls, shape: tuple[int, ...]) -> "Shown":
        """Return that nothing is shown."""
        return cls(np.zeros(shape, dtype=np.uint16), np.full(shape, np.inf), np.zeros(shape, dtype=np.bool_))

    def add(self, where: Any, inside: Bools, depth: Floats, touched: Bools) -> None:
        """Count a photo at some cells."""
        self.count[where] += inside
        self.depth[where] = np.where(inside, np.minimum(self.depth[where], depth), self.depth[where])
        self.touched[where] |= touched


class Viewers:
    """What is between cells and the cameras of photos, and the greatest depth that counts.

    Attributes
    ----------
    views
        Of the photos.
    relief
        The ground that may hide cells; ``None`` where it is level.
    blockers
        What else may hide them.
    most
        Metres along the optical axis: what is deeper is shown too coarsely.
    deepest, deepest_cell
        Metres: the greatest depth at which any photo is certain to show a place, at most, and all of a cell.
    coarse
        Views that may show places deeper than what counts.
    """

    def __init__(
        self, views: Sequence[PhotoView], relief: GroundRelief | None, blockers: Blockers, most: float
    ) -> None:
        self.views, self.relief, self.blockers = views, relief, blockers
        self.most, self.deepest, self.deepest_cell = most * (1 + LIMIT_LET_PASS), 0.0, 0.0
        self.coarse: dict[PhotoView, None] = {}

    def show_grid(self, grid: CellGrid) -> Shown:
        """Return how often the whole cells of a grid are shown."""
        shown = Shown.nothing(grid.whole.shape)
        for view in self.views:
            raise_if_interrupted()
            here = grid.within(view)
            if here is None:
                continue
            (x, y, z), slack = grid.nodes(here), grid.slack[here]
            margin, depth = view.look(x[:, None], y, z)
            touched = grid.whole[here] & (_of_four(np.maximum, np.where(depth <= self.most, margin, -1.0)) >= 0)
            least, depth = _of_four(np.minimum, margin), _of_four(np.maximum, depth) + slack
            partly = grid.whole[here] & (_of_four(np.maximum, margin) >= -(1 + view.sine) * grid.reach[here])
            inside = (least >= slack * (1 + view.sine) - LET_PASS) & grid.whole[here]
            self._hide_by_ground(view, inside, grid, here)
            self._hide_by_walls(view, inside, touched, grid, here)
            self._count(shown, view, here, inside, partly, depth, touched)
        return shown

    def show_pieces(self, pieces: Pieces, normal: Floats | None = None, hidden: Bools | None = None) -> Shown:
        """Return how often pieces are shown, but those that are `hidden` (n,) from all photos.

        Those with normals (n, 3) are shown from their front, and not too flatly.
        """
        shown = Shown.nothing(pieces.area.shape)
        if not len(pieces.area):
            return shown
        low, high = pieces.corners.min(axis=1), pieces.corners.max(axis=1)
        order = np.argsort(low[:, 0])
        begins, wide = low[order, 0], float((high[:, 0] - low[:, 0]).max())
        ends = low.min(axis=0), high.max(axis=0)
        for view in self.views:
            raise_if_interrupted()
            (west, south), (east, north) = view.window(*ends)
            some = order[slice(*np.searchsorted(begins, (west - wide, east)))]
            some = some[(high[some, 1] >= south) & (low[some, 1] <= north) & (high[some, 0] >= west)]
            if not len(some):
                continue
            part = pieces.of(some)
            margin, depth = view.look(*np.moveaxis(part.corners, 2, 0))
            partly = margin.max(axis=1) >= -(1 + view.sine) * part.reach
            inside = margin.min(axis=1) >= part.slack * (1 + view.sine) - LET_PASS
            if normal is not None:
                inside &= (view.facing(part.corners, normal[some]) >= 0).all(axis=1)
            if hidden is not None:
                inside &= ~hidden[some]
            if self.relief is not None:
                near = np.flatnonzero(inside)
                inside[near] = self.relief.hides_nothing(_places(part.of(near)), view.position, view.error)
            touched = np.any((margin >= 0) & (depth <= self.most), axis=1)
            self._hide_pieces_by_walls(view, inside, touched, part)
            self._count(shown, view, some, inside, partly, depth.max(axis=1) + part.slack, touched)
        return shown

    def look_closer(self, grid: CellGrid) -> None:
        """Look more finely how deep what photos are certain to show may be, where cells are deeper than what counts."""
        self.deepest = min(self.deepest, self.most)
        for view in self.coarse:
            raise_if_interrupted()
            here = grid.within(view)
            if here is None:
                continue
            x, y, z = grid.nodes(here)
            depth = _of_four(np.maximum, view.look(x[:, None], y, z)[1]) + grid.slack[here]
            deep = grid.cells(grid.whole[here] & (depth > self.most), (here[0].start, here[1].start))
            pieces = joined(grid.pieces, deep)
            for left in range(CLOSER, -1, -1):
                margin, depth = view.look(*np.moveaxis(pieces.corners, 2, 0))
                depth = depth.max(axis=1) + pieces.slack
                partly = (margin.max(axis=1) >= -(1 + view.sine) * pieces.reach) & (depth > self.most)
                if not partly.any():
                    break
                pieces = grid.halved(pieces.of(partly)) if left else pieces
            else:
                self.deepest = max(self.deepest, float(depth[partly].max()))

    def _count(
        self, shown: Shown, view: PhotoView, where: Any, inside: Bools, partly: Bools, depth: Floats, touched: Bools
    ) -> None:
        deepest = float(depth.max(initial=0.0, where=partly))
        self.deepest = max(self.deepest, deepest)
        if deepest > self.most:
            self.coarse[view] = None
        self.deepest_cell = max(self.deepest_cell, float(depth.max(initial=0.0, where=inside)))
        shown.add(where, inside & (depth <= self.most), depth, touched)

    def _hide_by_ground(self, view: PhotoView, inside: Bools, grid: CellGrid, here: tuple[slice, slice]) -> None:
        """Take out of cells what the ground may hide: first of whole blocks of cells, then of cells."""
        if self.relief is None:
            return
        (x, y, z), slack = grid.nodes(here), grid.slack[here]
        low, high = _of_four(np.minimum, z) - slack, _of_four(np.maximum, z) + slack
        undecided = inside.copy()
        for size in (IN_BLOCK, 1):
            k, m = np.nonzero(_in_blocks(np.logical_or, undecided, size))
            least, most = _in_blocks(np.minimum, low, size)[k, m], _in_blocks(np.maximum, high, size)[k, m]
            ends = [(line[n * size], line[np.minimum((n + 1) * size, len(line) - 1)]) for n, line in ((k, x), (m, y))]
            radius = np.maximum(*(b - a for a, b in ends)) / 2
            (a, b), (c, d) = ends
            places = Places((a + b) / 2, (c + d) / 2, radius, least, most)
            hidden = ~self.relief.hides_nothing(places, view.position, view.error)
            blocks = np.zeros(tuple(-(-n // size) for n in undecided.shape), dtype=np.bool_)
            blocks[k[hidden], m[hidden]] = True
            undecided &= blocks.repeat(size, axis=0).repeat(size, axis=1)[: undecided.shape[0], : undecided.shape[1]]
            if not undecided.any():
                return
        inside &= ~undecided

    def _hide_by_walls(
        self, view: PhotoView, inside: Bools, touched: Bools, grid: CellGrid, here: tuple[slice, slice]
    ) -> None:
        """Take out of cells what walls and facets may hide; what they hide wholly is not touched either."""
        if not len(self.blockers.top) or not inside.any():
            return
        (x, y, z), slack = grid.nodes(here), grid.slack[here]
        rising = bool(z.max() + slack.max() < view.position[2] - view.error.vertical)
        parts, low, high = self.blockers.shadows(view, float(z.min() - slack.max()), rising)
        begin = [np.clip(np.searchsorted(line, low[:, k], side="right") - 1, 0, None) for k, line in enumerate((x, y))]
        end = [np.minimum(np.searchsorted(line, high[:, k]), len(line) - 1) for k, line in enumerate((x, y))]
        wide, long = (np.maximum(b - a, 0) for a, b in zip(begin, end, strict=True))
        count = wide * long
        of = np.repeat(np.arange(len(parts)), count)
        rank = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
        m, n = begin[0][of] + rank // np.maximum(long[of], 1), begin[1][of] + rank % np.maximum(long[of], 1)
        met = inside[m, n]
        m, n, of = m[met], n[met], of[met]
        corners = np.stack(
            [np.stack([x[m + a], y[n + b], z[m + a, n + b]], axis=1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))],
            axis=1,
        )
        hidden, wholly = self.blockers.hide(_thick(corners, slack[m, n]), parts[of], view)
        inside[m[hidden], n[hidden]] = False
        touched[m[wholly], n[wholly]] = False

    def _hide_pieces_by_walls(self, view: PhotoView, inside: Bools, touched: Bools, pieces: Pieces) -> None:
        """Take out of pieces what walls and facets may hide; what they hide wholly is not touched either."""
        near = np.flatnonzero(inside)
        if not len(self.blockers.top) or not len(near):
            return
        corners = _thick(pieces.corners[near], pieces.slack[near])
        low, high = corners.min(axis=1), corners.max(axis=1)
        rising = bool(high[:, 2].max() < view.position[2] - view.error.vertical)
        parts, least, most = self.blockers.shadows(view, float(low[:, 2].min()), rising)
        order = np.argsort(low[:, 0])
        wide = float((high[:, 0] - low[:, 0]).max())
        begin, end = np.searchsorted(low[order, 0], least[:, 0] - wide), np.searchsorted(low[order, 0], most[:, 0])
        of = np.repeat(np.arange(len(parts)), end - begin)
        piece = order[np.arange(len(of)) - np.repeat(np.cumsum(end - begin) - end, end - begin)]
        met = (high[piece] >= np.column_stack([least, np.full(len(parts), -np.inf)])[of]).all(axis=1) & (
            low[piece, 1] <= most[of, 1]
        )
        hidden, wholly = self.blockers.hide(corners[piece[met]], parts[of[met]], view)
        inside[near[piece[met][hidden]]] = False
        touched[near[piece[met][wholly]]] = False


def _thick(corners: Floats, slack: Floats) -> Floats:
    """Return the corners of hulls that are thicker by some slack, upwards and downwards, where there is any."""
    if not slack.any():
        return corners
    more = np.zeros_like(corners)
    more[:, :, 2] = slack[:, None]
    return np.concatenate([corners - more, corners + more], axis=1)


def _in_blocks(choose: np.ufunc, values: NDArray[Any], size: int) -> NDArray[Any]:
    """Return the least, the greatest or any of the values in each block of cells."""
    even = np.pad(values, [(0, -n % size) for n in values.shape], mode="edge")
    rows = choose.reduce(even.reshape(even.shape[0] // size, size, -1), axis=1)
    found: NDArray[Any] = choose.reduce(rows.reshape(len(rows), -1, size), axis=2)
    return found


def _places(pieces: Pieces) -> Places:
    low, high = pieces.corners.min(axis=1), pieces.corners.max(axis=1)
    x, y, _ = ((low + high) / 2).T
    radius = (high - low)[:, :2].max(axis=1) / 2
    return Places(x, y, radius, low[:, 2] - pieces.slack, high[:, 2] + pieces.slack)


def _of_four(choose: np.ufunc, values: Floats) -> Floats:
    """Return the least or the greatest of the values at the four corners of each cell."""
    rows = choose(values[:-1], values[1:])
    found: Floats = choose(rows[:, :-1], rows[:, 1:])
    return found
