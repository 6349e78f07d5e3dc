"""Windows of rasters, and how a number that stands for no data is found there although the file does not declare it.

Such a number fills blocks of pixels that have a cliff nearly all around them.
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.maps.readers.raster import OpenRaster

Window = tuple[int, int, int, int]
"""The first column and row, and how many columns and rows."""

CLIFF_DOWN, CLIFF_UP = 100.0, 1000.0
"""Metres from one pixel to the next: no shore falls by more, and no roof or rock rises by more, nearly all around."""
CLIFF_SLOPE = 2.0
"""Metres of height a metre of width that a cliff has at least, as pixels may be wide."""
CLIFF_SHARE = 0.75
"""The share of a block's border that a cliff exceeds where the block holds no data."""
MIN_BORDER = 0.5
"""The least border of a block, in sides of a square of its area: the plain around a tower is not cut off by it."""
SURROUNDINGS = 300
"""Pixels around a doubtful window that are looked at as well."""


def extremes_of_blocks(raster: OpenRaster, window: Window, block: int) -> tuple[Floats, Floats]:
    """Read a window strip by strip, and return the greatest and the least height of each block, metres.

    Where a pixel has no data, the greatest height of its block is ``nan``; the least is that of the other pixels, and
    ``nan`` if there are none.

    Parameters
    ----------
    raster, window
        What to read.
    block
        How many pixels wide and high a block is.
    """
    left, top, width, height = window
    if block == 1:
        heights = raster.heights(left, top, width, height)
        return heights, heights
    columns, rows = -(-width // block), -(-height // block)
    highest, lowest = np.empty((2, rows, columns))
    strip = max(1, int(2e6 / (width * block)))
    for first in range(0, rows, strip):
        last = min(rows, first + strip)
        tall = min(height, last * block) - first * block
        part = raster.heights(left, top + first * block, width, tall)
        part = np.pad(part, ((0, (last - first) * block - tall), (0, columns * block - width)), mode="edge")
        part = part.reshape(last - first, block, columns, block)
        highest[first:last], lowest[first:last] = part.max(axis=(1, 3)), np.fmin.reduce(part, axis=(1, 3))
    return highest, lowest


def refuse_undeclared_nodata(raster: OpenRaster, window: Window, heights: Floats, block: int, width: float) -> None:
    """Raise `InputError` where a number in a window stands for no data, with the number, its share, and a place.

    A window of one height, and one that seems to hold such a number, is judged together with its surroundings.

    Parameters
    ----------
    raster, window
        The window.
    heights
        (rows, columns) the heights of its blocks, metres.
    block
        How many pixels wide and high a block is.
    width
        How wide a block is, metres.
    """
    if raster.all_heights or np.isnan(heights).all():
        return
    rows, columns = heights.shape
    level = np.nanmin(heights) == np.nanmax(heights)
    if not level and undeclared_gap(heights, width, (slice(0, rows), slice(0, columns)), 0.0) is None:
        return
    left, top, across, down = window
    before, above = min(SURROUNDINGS, left // block), min(SURROUNDINGS, top // block)
    first = left - before * block, top - above * block
    last = left + across + SURROUNDINGS * block, top + down + SURROUNDINGS * block
    size = raster.data.width, raster.data.height
    wide = (*first, *(min(end, most) - begin for end, most, begin in zip(last, size, first, strict=True)))
    core = slice(above, above + rows), slice(before, before + columns)
    found = undeclared_gap(extremes_of_blocks(raster, wide, block)[0], width, core, MIN_BORDER)
    if found is not None:
        height, (row, column), share = found
        pixel = first[0] + (column + 0.5) * block, first[1] + (row + 0.5) * block
        raster.refuse_height(height, share, pixel, "with a cliff all round it")


def undeclared_gap(
    heights: Floats, width: float, core: tuple[slice, slice], min_border: float
) -> tuple[float, tuple[int, int], float] | None:
    """Return the largest block of one height that cliffs cut off and that reaches into the core, or ``None``.

    It is returned as its height, metres, the row and column of one of its cells, and the share of the core's cells that
    have this height.

    Parameters
    ----------
    heights
        (rows, columns) metres, ``nan`` where there is no data.
    width
        How wide a cell is, metres.
    core
        The rows and columns that are judged; the others are their surroundings.
    min_border
        The least border of a block, in sides of a square of its area.
    """
    fall, rise = max(CLIFF_DOWN, CLIFF_SLOPE * width), max(CLIFF_UP, CLIFF_SLOPE * width)
    pairs = [(heights[:, :-1], heights[:, 1:]), (heights[:-1], heights[1:])]
    suspects = []
    for one, other in pairs:
        step = np.abs(other - one)
        cliff = step > fall
        if cliff.any():
            ends = one[cliff], other[cliff]
            suspects += [np.minimum(*ends), np.maximum(*ends)[step[cliff] > rise]]
    if not suspects:
        return None
    inner = heights[core]
    values = np.unique(inner[np.isin(inner, np.unique(np.concatenate(suspects)))])
    if not len(values):
        return None
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    doubtful = np.isin(heights, values)
    count = int(doubtful.sum())
    number = np.full(heights.shape, -1, dtype=np.int32)
    number[doubtful] = np.arange(count, dtype=np.int32)
    numbers = [(number[:, :-1], number[:, 1:]), (number[:-1], number[1:])]
    alike = [(h == k) & (a >= 0) for (a, _), (h, k) in zip(numbers, pairs, strict=True)]
    edges = tuple(np.concatenate([sides[k][same] for sides, same in zip(numbers, alike, strict=True)]) for k in (0, 1))
    many, block = connected_components(coo_array((np.ones(len(edges[0]), bool), edges), (count, count)), directed=False)
    border, falls, rises = np.zeros((3, many))
    span = np.sqrt(np.bincount(block, minlength=many))
    for (a, b), (h, k) in zip(numbers, pairs, strict=True):
        for mine, own, next_to in ((a, h, k), (b, k, h)):
            edge = (mine >= 0) & (own != next_to) & np.isfinite(next_to)
            owner = block[mine[edge]]
            step = next_to[edge] - own[edge]
            border += np.bincount(owner, minlength=many)
            falls += np.bincount(owner, step > fall, minlength=many)
            rises += np.bincount(owner, step < -rise, minlength=many)
    cut_off = (border > min_border * span) & (np.maximum(falls, rises) > CLIFF_SHARE * border)
    inside = number[core]
    here = block[inside[inside >= 0]]
    size = np.bincount(here, minlength=many) * cut_off
    if not size.any():
        return None
    size[size > inner.size / 2] = 1  # where a plain meets a block high above it, the plain is not the gap
    chosen = np.argmax(size)
    row, column = np.argwhere(inside >= 0)[np.flatnonzero(here == chosen)[0]]
    height = float(inner[row, column])
    cell = int(row) + core[0].start, int(column) + core[1].start
    return height, cell, float((inner == height).mean())
