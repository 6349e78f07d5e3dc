"""The convex edges of free space: where a shortest path can bend.

A shortest path among boxes is straight except where it wraps around an edge of a grown box. Edges end at the bounds and
where other boxes cover them. What is left of them are pieces, each parallel to an axis.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import doubled, order_of, put, put_box
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.numerics.tolerances import SIGHT_MARGIN
from skyverse.space import tree
from skyverse.space.obstacles import Space
from skyverse.space.tree import Tree


@by_reference
class Edges(NamedTuple):
    """Pieces of edges, in the order of their index.

    Attributes
    ----------
    ends
        (k, 6) metres: min and max corner of each piece; they differ only on its own axis.
    axis
        (k,) the axis that each piece is parallel to.
    side
        (k, 2) on the two axes that follow its own: +1 where free space lies above the piece, -1 where it lies below.
    box
        (k,) the box whose edge each is.
    tree
        The index over the pieces.
    """

    ends: Floats
    axis: Ints
    side: Ints
    box: Ints
    tree: Tree


@kernel
def make_edges(space: Space, growth: float) -> Edges:
    """Return the edges of a world's boxes, grown by `growth` metres.

    Left out is what lies inside other boxes, which are grown by `SIGHT_MARGIN` less.
    """
    aside = 1.5 * SIGHT_MARGIN  # there must be a passage so far beside an edge: between coplanar faces there is none
    others = growth - SIGHT_MARGIN
    ends = np.empty((64, 6))
    kind = np.empty((64, 4), np.int64)
    count = 0
    cuts = np.empty((64, 2))
    low, high = np.empty(3), np.empty(3)
    for i in range(len(space.boxes)):
        for axis in range(3):
            b, c = (axis + 1) % 3, (axis + 2) % 3
            for corner in range(4):
                up_b, up_c = 2 * (corner & 1) - 1, 2 * (corner >> 1) - 1
                at_b = space.boxes[i, b + 3] + growth if up_b > 0 else space.boxes[i, b] - growth
                at_c = space.boxes[i, c + 3] + growth if up_c > 0 else space.boxes[i, c] - growth
                if not (
                    space.low[b] + aside < at_b < space.high[b] - aside
                    and space.low[c] + aside < at_c < space.high[c] - aside
                ):
                    continue
                low[axis] = max(space.boxes[i, axis] - growth, space.low[axis])
                high[axis] = min(space.boxes[i, axis + 3] + growth, space.high[axis])
                low[b] = high[b] = at_b
                low[c] = high[c] = at_c
                found = 0
                for j in tree.touching(space.tree, space.boxes, others + aside, low, high):
                    # the box holds the edge, or the passage along one of its two faces
                    if j != i and (
                        _covers(space.boxes, j, others, (b, c), at_b, at_c)
                        or _covers(space.boxes, j, others, (b, c), at_b + up_b * aside, at_c - up_c * aside)
                        or _covers(space.boxes, j, others, (b, c), at_b - up_b * aside, at_c + up_c * aside)
                    ):
                        if found == len(cuts):
                            cuts = doubled(cuts)
                        cuts[found, 0] = space.boxes[j, axis] - growth
                        cuts[found, 1] = space.boxes[j, axis + 3] + growth
                        found += 1
                order = order_of(cuts[:found, 0].copy())
                begin = low[axis]
                for cut in range(found + 1):
                    stop = min(cuts[order[cut], 0], high[axis]) if cut < found else high[axis]
                    if stop > begin:
                        if count == len(ends):
                            ends, kind = doubled(ends), doubled(kind)
                        put_box(ends, count, low, high)
                        ends[count, axis], ends[count, axis + 3] = begin, stop
                        kind[count, 0], kind[count, 1], kind[count, 2], kind[count, 3] = axis, up_b, up_c, i
                        count += 1
                    if cut < found:
                        begin = max(begin, cuts[order[cut], 1])
    index, order = tree.build(ends[:count])
    sorted_ends = np.empty((count, 6))
    axis_of, side, of = np.empty(count, np.int64), np.empty((count, 2), np.int64), np.empty(count, np.int64)
    for e in range(count):
        put(sorted_ends, e, ends[order[e]])
        axis_of[e], of[e] = kind[order[e], 0], kind[order[e], 3]
        side[e, 0], side[e, 1] = kind[order[e], 1], kind[order[e], 2]
    return Edges(sorted_ends, axis_of, side, of, index)


@inner
def _covers(boxes: Floats, j: int, growth: float, axes: tuple[int, int], at_b: float, at_c: float) -> bool:
    """Tell whether box j, grown by `growth`, covers a place in the plane of two axes."""
    b, c = axes
    return (
        boxes[j, b] - growth < at_b < boxes[j, b + 3] + growth
        and boxes[j, c] - growth < at_c < boxes[j, c + 3] + growth
    )
