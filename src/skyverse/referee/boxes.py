"""Grown boxes, those of voxels among them: how deep a part of a curve, or a straight segment, may be inside."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices, Ints
from skyverse.model.shapes import Box, Voxels
from skyverse.model.uav import TrackingError
from skyverse.referee.judgement import Incursion
from skyverse.referee.solid_shapes import SolidShapes
from skyverse.referee.solids import GrownSolids, grown
from skyverse.referee.tolerances import TWO_ROUNDINGS
from skyverse.referee.tracking_error import EXACT, reach, taller


def disjoint_boxes(occupied: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """Return boxes that hold exactly the occupied cells, each cell in one box.

    Parameters
    ----------
    occupied
        (nx, ny, nz) booleans.

    Returns
    -------
    first, beyond
        (m, 3) indices of each box's first cell, and of the cell diagonally beyond its last one.
    """
    edges = np.diff(occupied.astype(np.int8), axis=0, prepend=0, append=0)
    # in this order of axes, the n-th run to begin is also the n-th to end
    starts = np.argwhere(np.moveaxis(edges == 1, 0, -1))
    stops = np.argwhere(np.moveaxis(edges == -1, 0, -1))
    first = np.column_stack([starts[:, 2], starts[:, :2]]).astype(np.int64)
    beyond = np.column_stack([stops[:, 2], stops[:, :2] + 1]).astype(np.int64)
    for axis in (1, 2):
        first, beyond = _joined(first, beyond, axis)
    return first, beyond


def _joined(first: Ints, beyond: Ints, axis: int) -> tuple[Ints, Ints]:
    """Join boxes that touch along one axis and extend equally along the others."""
    same = np.zeros(len(first), dtype=np.int64)  # one number for the extent along the other axes
    for other in (k for k in range(3) if k != axis):
        count = int(beyond[:, other].max(initial=0)) + 1
        same = (same * count + first[:, other]) * count + beyond[:, other]
    order = np.lexsort([first[:, axis], same])
    first, beyond, same = first[order], beyond[order], same[order]
    follows = (same[1:] == same[:-1]) & (first[1:, axis] == beyond[:-1, axis])
    begins = np.r_[True, ~follows][: len(first)]
    ends = np.r_[~follows, True][: len(first)]
    joined = beyond[begins].copy()
    joined[:, axis] = beyond[ends][:, axis]
    return first[begins], joined


@dataclass(frozen=True, eq=False)
class GrownBoxes(GrownSolids):
    """Axis-aligned boxes.

    Attributes
    ----------
    low, high
        (m, 3) corners as given, metres.
    grown_low, grown_high
        (m, 3) corners of the grown boxes, metres.
    """

    low: Floats
    high: Floats
    grown_low: Floats
    grown_high: Floats

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of the grown boxes."""
        return self.grown_low, self.grown_high

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds on the errors of depths: those of the positions, and rounding at the faces of the boxes."""
        return error + self.farthest * TWO_ROUNDINGS

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts may be inside: a part outside lies beyond one face along some axis."""
        low, high = self.grown_low[which], self.grown_high[which]
        return np.minimum(part.max(axis=1) - low, high - part.min(axis=1)).min(axis=1)

    def gap(self, position: Floats, which: int) -> float:
        """Return the distance of a position to a box along the axis where it is largest, metres."""
        return float(self.gaps(position[None], which)[0])

    def gaps(self, positions: Floats, which: int) -> Floats:
        """Return the distances (n,) of positions (n, 3) to one box as `gap` does, metres."""
        return np.maximum(self.low[which] - positions, positions - self.high[which]).max(axis=1)


def grown_boxes(shapes: SolidShapes, error: TrackingError = EXACT) -> GrownBoxes:
    """Return all boxes, and voxels as boxes, for a UAV with a tracking error."""
    boxes, obstacles = shapes.of(Box)
    corners = np.reshape([(*box.min, *box.max) for box in boxes], (len(boxes), 6))
    lows, highs, numbers = [corners[:, :3]], [corners[:, 3:]], [obstacles]
    for voxels, number in zip(*shapes.of(Voxels), strict=True):
        first, beyond = disjoint_boxes(voxels.occupied)
        lows.append(np.array(voxels.origin) + first * np.array(voxels.step))
        highs.append(np.array(voxels.origin) + beyond * np.array(voxels.step))
        numbers.append(np.full(len(first), number))
    low, high = np.concatenate(lows), np.concatenate(highs)
    if error != EXACT:
        low[:, 2], high[:, 2] = taller(low[:, 2], high[:, 2], error)
    clearance = reach(shapes.clearance, error)
    return GrownBoxes(clearance, np.concatenate(numbers), low, high, *grown(low, high, clearance))


SAMPLES = 101
"""Points along the inner part of the deepest segment, of which the deepest is named."""


def deepest_in_boxes(boxes: GrownBoxes, starts: Floats, ends: Floats) -> Incursion | None:
    """Return where segments between starts and ends, (n, 3) metres, are deepest inside a grown box, if they are."""
    deepest = None
    for k in _entered_boxes(boxes, starts, ends):
        enter, leave = _crossing_shares(starts, ends, boxes.grown_low[k], boxes.grown_high[k])
        hits = np.flatnonzero(enter < leave)
        middle = (enter[hits] + leave[hits]) / 2
        gaps = boxes.gaps(starts[hits] + middle[:, None] * (ends - starts)[hits], k)
        s = hits[np.argmin(gaps)]
        shares = np.linspace(enter[s], leave[s], SAMPLES)
        points = starts[s] + shares[:, None] * (ends - starts)[s]
        gaps = boxes.gaps(points, k)
        i = int(np.argmin(gaps))
        if deepest is None or gaps[i] < deepest.gap:
            number = int(boxes.obstacle[k])
            deepest = Incursion(float(gaps[i]), boxes.clearance, number, int(s), float(shares[i]), points[i])
    return deepest


def _entered_boxes(boxes: GrownBoxes, starts: Floats, ends: Floats) -> Indices:
    """Return the indices of the boxes that some segment enters."""
    found = [np.zeros(0, dtype=np.intp)]
    for pairs in boxes.tree.overlapping(np.minimum(starts, ends), np.maximum(starts, ends)):
        segment, box = pairs.T
        enter, leave = _crossing_shares(starts[segment], ends[segment], boxes.grown_low[box], boxes.grown_high[box])
        found.append(box[enter < leave])
    return np.unique(np.concatenate(found))


def _crossing_shares(starts: Floats, ends: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return the shares (n,), (n,) of segments at which they enter and leave open boxes.

    A segment runs through the box where it enters the box before it leaves it.

    Parameters
    ----------
    starts, ends
        (n, 3) metres.
    low, high
        (3,) or (n, 3) corners of the box, metres.
    """
    direction = ends - starts
    moves = direction != 0
    divisor = np.where(moves, direction, 1.0)
    to_low, to_high = (low - starts) / divisor, (high - starts) / divisor
    between = (starts > low) & (starts < high)
    enters = np.where(moves, np.minimum(to_low, to_high), np.where(between, -np.inf, np.inf))
    leaves = np.where(moves, np.maximum(to_low, to_high), np.where(between, np.inf, -np.inf))
    return np.maximum(enters.max(axis=1), 0.0), np.minimum(leaves.min(axis=1), 1.0)
