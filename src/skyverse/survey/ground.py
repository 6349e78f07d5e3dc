"""The ground of a survey: its least and greatest heights, cell by cell, where it is to be seen and everywhere.

A cell of bilinear ground, or a part of one, has its extremes at its corners, so the bounds of each cell are exact. What
is asked of turned rectangles counts every cell that touches them.
"""

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import shapely

from skyverse._typing import Bools, Floats
from skyverse.model.scenario import Scenario
from skyverse.numerics.kernel import by_reference

BLOCK = 16
"""Cells along each side of a block, whose least and greatest heights stand for all of its cells in a first look."""
MOST_CELLS = 6e6
"""Cells at most, or else they are made larger."""


@by_reference
class GroundCells(NamedTuple):
    """Ground in cells.

    Attributes
    ----------
    low, high
        (nx, ny) metres: the least and the greatest z in each cell that is to be seen, plus and minus infinity in all
        others.
    middle
        (nx, ny) metres: the z in the middle of each cell, seen or not.
    block_low
        The same as `low` for every `BLOCK` by `BLOCK` cells.
    origin, step
        (2,) metres: x, y of the corner of the first cell, and the sides of a cell.
    """

    low: Floats
    high: Floats
    middle: Floats
    block_low: Floats
    origin: Floats
    step: Floats


def ground_cells(scenario: Scenario, wanted: Any, cell: float, reach: float, *, touched: bool = True) -> GroundCells:
    """Return the ground in and around what is wanted, in cells of about a size.

    Parameters
    ----------
    scenario
        Whose terrain it is, or the level of the lower side of its bounds.
    wanted
        What is to be seen.
    cell, reach
        Metres: about the side of a cell, and how far around it reaches.
    touched
        Whether all cells that touch what is wanted are to be seen, or those whose middle is in it.
    """
    x0, y0, x1, y1 = wanted.buffer(reach).bounds
    cell = max(cell, math.sqrt((x1 - x0) * (y1 - y0) / MOST_CELLS))
    terrain = scenario.terrain
    if terrain is None:
        cell = max(cell, reach / (4 * BLOCK))  # on level ground the size matters little
        origin, step, heights = np.array([x0, y0]), (x1 - x0, y1 - y0), np.full((2, 2), scenario.bounds.min[2])
    else:
        origin, step, heights = np.array(terrain.origin), terrain.step, terrain.heights
    nodes, merged, begin, size = [], [], [], []
    for axis, (first, last) in enumerate(((x0, x1), (y0, y1))):
        parts, block = max(math.ceil(step[axis] / cell), 1), max(math.floor(cell / step[axis]), 1)
        fine = step[axis] / parts
        i = math.floor((first - origin[axis]) / fine)
        count = max(math.ceil((last - origin[axis]) / fine) - i, 1)
        count = -(-count // block) * block
        nodes.append((i + np.arange(count + 1)) / parts)
        merged.append(block)
        begin.append(origin[axis] + i * fine)
        size.append(fine * block)
    at = _interpolated(_interpolated(heights, nodes[0]).T, nodes[1]).T
    low, high = (_merged(_of_corners(at, pick), merged, pick) for pick in (np.minimum, np.maximum))
    middle = 0.5 * (low + high)
    around = wanted.buffer(0.51 * math.hypot(*size), quad_segs=2) if touched else wanted
    seen = _inside(around, np.array(begin), np.array(size), low.shape)
    below, above = np.where(seen, low, np.inf), np.where(seen, high, -np.inf)
    padded = np.pad(below, [(0, -count % BLOCK) for count in below.shape], constant_values=np.inf)
    block_low = _merged(padded, (BLOCK, BLOCK), np.minimum)
    return GroundCells(below, above, middle, block_low, np.array(begin), np.array(size))


def _interpolated(heights: Floats, at: Floats) -> Floats:
    """Return heights along their first axis at row numbers with shares, those beyond the ends as at the ends."""
    at = np.clip(at, 0.0, len(heights) - 1.0)
    row = np.minimum(at.astype(np.intp), len(heights) - 2)
    share = (at - row)[:, None]
    return heights[row] * (1.0 - share) + heights[row + 1] * share


def _of_corners(at: Floats, pick: np.ufunc) -> Floats:
    return pick(pick(at[1:, 1:], at[:-1, 1:]), pick(at[1:, :-1], at[:-1, :-1]))


def _merged(cells: Floats, block: "list[int] | tuple[int, int]", pick: np.ufunc) -> Floats:
    """Return the extremes of blocks of cells."""
    (nx, ny), (a, b) = cells.shape, block
    return np.ascontiguousarray(pick.reduce(pick.reduce(cells.reshape(nx // a, a, ny // b, b), axis=3), axis=1))


def _inside(area: Any, origin: Floats, step: Floats, shape: tuple[int, int]) -> Bools:
    """Tell of each cell whether its middle is inside an area.

    An edge that the ray from a cell's middle to smaller x crosses is counted at the first cell from which it does.
    """
    crossings = np.zeros((shape[0] + 1, shape[1]), np.int64)
    for ring in shapely.get_rings(shapely.get_parts(area)):
        at = (shapely.get_coordinates(ring) - origin) / step - 0.5
        for (ax, ay), (bx, by) in pairwise(at):
            low, high = min(ay, by), max(ay, by)
            rows = np.arange(max(math.ceil(low), 0), min(math.ceil(high), shape[1]))
            if len(rows):
                x = np.ceil(ax + (rows - ay) * ((bx - ax) / (by - ay)))
                crossings[np.clip(x, 0, shape[0]).astype(np.intp), rows] += 1
    return np.cumsum(crossings, axis=0)[:-1] % 2 == 1
