"""Where straight segments run through grown boxes, in closed form: the slab method."""

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.referee.boxes import GrownBoxes
from skyverse.referee.incursion import Incursion
from skyverse.referee.overlaps import overlapping_pairs

SAMPLES = 101
"""Points along the inner part of the deepest segment, of which the deepest is named."""


def deepest_in_boxes(boxes: GrownBoxes, starts: Floats, ends: Floats) -> Incursion | None:
    """Return where segments between starts and ends, (n, 3) metres, are deepest inside a grown box, if they are."""
    deepest = None
    for k in _entered_boxes(boxes, starts, ends):
        enter, leave = crossing_shares(starts, ends, boxes.grown_low[k], boxes.grown_high[k])
        hits = np.flatnonzero(enter < leave)
        middle = ((enter + leave) / 2)[hits]
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
    for pairs in overlapping_pairs(np.minimum(starts, ends), np.maximum(starts, ends), *boxes.hulls()):
        segment, box = pairs.T
        enter, leave = crossing_shares(starts[segment], ends[segment], boxes.grown_low[box], boxes.grown_high[box])
        found.append(box[enter < leave])
    return np.unique(np.concatenate(found))


def crossing_shares(starts: Floats, ends: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
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
