"""Windows of rasters, and blocks in them that hold a number for no data unsaid: all round them is a cliff."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skyverse._typing import Floats

if TYPE_CHECKING:
    from skyverse.maps.readers.raster import Opened

Window = tuple[int, int, int, int]
"""First column and row, how many columns and rows."""

DROP, RISE = 100.0, 1000.0
"""Metres from one cell to the next that no shore falls by, and no roof or rock rises by, nearly all round a level."""
STEEP = 2.0
"""And that many metres a metre, as cells may be wide."""
SHARE = 0.75
"""More of a block's border than this is such a cliff."""
LEAST = 0.5
"""Of the side of a square as large, what a block's border is at least: a plain around a tower is not cut off."""
AROUND = 300
"""Cells that are looked at beyond a window in doubt."""


@dataclass(frozen=True)
class Gap:
    """A block of one height that is no ground.

    Attributes
    ----------
    height
        Metres.
    cell
        Row and column of one of its cells.
    share
        Of all cells, those of that height.
    """

    height: float
    cell: tuple[int, int]
    share: float


def blocks(opened: "Opened", window: Window, block: int) -> Floats:
    """Read a window, strip by strip; of each block of pixels the highest, none where one is missing."""
    left, top, width, height = window
    if block == 1:
        return opened.heights(left, top, width, height)
    columns, rows = -(-width // block), -(-height // block)
    pooled = np.empty((rows, columns))
    strip = max(1, int(2e6 / (width * block)))
    for first in range(0, rows, strip):
        last = min(rows, first + strip)
        tall = min(height, last * block) - first * block
        part = opened.heights(left, top + first * block, width, tall)
        part = np.pad(part, ((0, (last - first) * block - tall), (0, columns * block - width)), mode="edge")
        pooled[first:last] = part.reshape(last - first, block, columns, block).max(axis=(1, 3))
    return pooled


def refuse_gaps(opened: "Opened", window: Window, heights: Floats, block: int, pitch: float) -> None:
    """Refuse a window of blocks of pixels, `pitch` metres wide, in which a number stands for no data.

    A window that is all of one height, or seems to hold a gap, is judged by what is around it.

    Raises
    ------
    InputError
        With the number, its share, and a place.
    """
    if opened.all_heights or np.isnan(heights).all():
        return
    rows, columns = heights.shape
    level = np.nanmin(heights) == np.nanmax(heights)
    if not level and gap(heights, pitch, (slice(0, rows), slice(0, columns)), 0.0) is None:
        return
    left, top, width, height = window
    before, above = min(AROUND, left // block), min(AROUND, top // block)
    first = left - before * block, top - above * block
    last = left + width + AROUND * block, top + height + AROUND * block
    size = opened.data.width, opened.data.height
    wide = (*first, *(min(end, most) - begin for end, most, begin in zip(last, size, first, strict=True)))
    core = slice(above, above + rows), slice(before, before + columns)
    found = gap(blocks(opened, wide, block), pitch, core, LEAST)
    if found is not None:
        row, column = (first[1] + (found.cell[0] + 0.5) * block, first[0] + (found.cell[1] + 0.5) * block)
        opened.refuse_height(found.height, found.share, (column, row), "with a cliff all round it")


def gap(heights: Floats, pitch: float, core: tuple[slice, slice], least: float) -> Gap | None:
    """Return the block of one height that is cut off by cliffs and reaches into the core; ``None`` where none does.

    Its border is more than `least` sides of a square as large.
    """
    fall, rise = max(DROP, STEEP * pitch), max(RISE, STEEP * pitch)
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
    cut_off = (border > least * span) & (np.maximum(falls, rises) > SHARE * border)
    inside = number[core]
    here = block[inside[inside >= 0]]
    size = np.bincount(here, minlength=many) * cut_off
    if not size.any():
        return None
    size[size > inner.size / 2] = 1  # of a plain and a block high above it, it is not the plain
    chosen = np.argmax(size)
    row, column = np.argwhere(inside >= 0)[np.flatnonzero(here == chosen)[0]]
    height = float(inner[row, column])
    cell = int(row) + core[0].start, int(column) + core[1].start
    return Gap(height, cell, float((inner == height).mean()))
