"""How far the surface of a grid is above that of a raster at most, cell by cell; a bound that is never too small.

Between the centres of four pixels the raster's surface is bilinear in columns and rows; within a cell of the grid, the
grid's is bilinear in x and y. Over the part of a patch of pixels that lies over one cell both are polynomials of degree
(2, 2) in columns and rows. Their difference is at most its greatest Bernstein coefficient.

Source: R. T. Farouki, "The Bernstein polynomial basis: a centennial retrospective", Computer Aided Geometric Design 29
(2012), 379-419.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.maps.readers.raster_tiles import Tile

STRIP_PATCHES = 20_000
"""Patches of a raster that are handled together."""
_EDGE = 1e-3
"""Pixels that a surface reaches beyond a raster's edge, as places so near count as inside."""
_ROUNDING = 1e-9
"""Steps of the grid by which a patch of pixels is taken to be wider, because of rounding."""


@dataclass(frozen=True)
class Patches:
    """Parts of a raster's surface, bilinear in shares s of columns and t of rows, from 0 to 1.

    Places in steps of the grid are affine in the shares, x = middle + (s - 1/2) along + (t - 1/2) aside, to a bend.

    Attributes
    ----------
    middle, along, aside
        (2, n) steps of the grid.
    bend
        (n,) steps of the grid, at most.
    z
        (2, 2, n) heights of the corners, metres; the first index is s, the second is t.
    """

    middle: Floats
    along: Floats
    aside: Floats
    bend: Floats
    z: Floats

    @property
    def reach(self) -> Floats:
        """(2, n) steps of the grid that a patch reaches around its middle."""
        return np.asarray((np.abs(self.along) + np.abs(self.aside)) / 2 + self.bend)

    def of(self, some: Indices) -> "Patches":
        """Return some of the patches."""
        middle, along, aside, bend, z = (
            part[..., some] for part in (self.middle, self.along, self.aside, self.bend, self.z)
        )
        return Patches(middle, along, aside, bend, z)


def surface_excess(tile: Tile, place: tuple[Floats, Floats], heights: Floats, sign: float) -> Floats:
    """Return how far a grid's surface is beyond a raster's at most over each cell, (nx - 1, ny - 1) metres.

    Where the raster has no data nothing is known, and the bound is minus infinity.

    Parameters
    ----------
    tile
        The raster's window.
    place
        x (nx,) and y (ny,) of the grid's nodes, metres, with equal steps.
    heights
        (nx, ny) z of the nodes, metres.
    sign
        1 for how far the grid's surface is above the raster's, -1 for how far it is below.
    """
    heights = sign * heights
    cells = np.full((heights.shape[0] - 1, heights.shape[1] - 1), -np.inf)
    for patches in _patches(tile, place, sign):
        first, last = np.floor(patches.middle - patches.reach), np.floor(patches.middle + patches.reach)
        ends = np.array(cells.shape)[:, None] - 1
        first, last = (np.clip(some, -1, ends + 1).astype(np.intp) for some in (first, last))
        for shift in product(*(range(int(most) + 1) for most in (last - first).max(axis=1, initial=-1))):
            cell = first + np.array(shift)[:, None]
            over = np.flatnonzero(((cell <= last) & (cell >= 0) & (cell <= ends)).all(axis=0))
            if len(over):
                i, j = cell[:, over]
                np.maximum.at(cells, (i, j), _excess(patches.of(over), heights, i, j))
    return cells


def _patches(tile: Tile, place: tuple[Floats, Floats], sign: float) -> Iterator[Patches]:
    """Yield the patches of a tile with the signs of their heights, some at a time.

    Single pixels have patches between their centres, and narrow ones at the raster's edge, where the surface is level.
    A block of pixels has one level patch up to the centres of the pixels beside it.
    """
    values = sign * (tile.lowest if sign > 0 else tile.heights)
    if tile.block == 1:
        values = np.pad(values, 1, mode="edge")
        spans = []
        for begin, count in zip(tile.corner, tile.heights.shape[::-1], strict=True):
            centres = begin + np.clip(np.arange(-1, count + 1) + 0.5, -_EDGE, count + _EDGE)
            spans.append((centres[:-1], centres[1:]))
        ends = values[:-1], values[1:]
        corners = [[row[:, side : side + values.shape[1] - 1] for row in ends] for side in (0, 1)]
    else:
        spans = [
            (begin + tile.block * np.arange(count) - 0.5, begin + tile.block * np.arange(1, count + 1) + 0.5)
            for begin, count in zip(tile.corner, tile.heights.shape[::-1], strict=True)
        ]
        corners = [[values, values], [values, values]]
    corner, steps = np.array([[line[0]] for line in place]), np.array([[line[1] - line[0]] for line in place])
    curved = _curvature(tile, spans)
    (across, down), many = spans, max(1, STRIP_PATCHES // len(spans[0][0]))
    for top in range(0, len(down[0]), many):
        part = slice(top, top + many)
        z = np.stack([np.stack([row[part].T.ravel() for row in pair]) for pair in corners])
        z = np.where(np.isnan(z), np.fmin.reduce(z, axis=(0, 1)), z)
        known = np.flatnonzero(np.isfinite(z).all(axis=(0, 1)))
        if not len(known):
            continue
        at = np.empty((2, 2, 2, len(known)))
        for side, end in product((0, 1), (0, 1)):
            here = tile.local.grid(across[side], down[end][part]).reshape(2, -1)[:, known]
            at[:, side, end] = (here - corner) / steps
        (a, b), (c, d) = at.transpose(1, 2, 0, 3)
        bend = np.abs(a + d - b - c).sum(axis=0) / 4 + curved / float(steps.min()) + _ROUNDING
        yield Patches((a + b + c + d) / 4, (c + d - a - b) / 2, (b + d - a - c) / 2, bend, z[..., known])


def _curvature(tile: Tile, spans: Sequence[tuple[Floats, Floats]]) -> float:
    """Return how far places between the corners of patches are off the bilinear ones, metres.

    It is a little more than what some patches, from all over the window, are off in their middles.
    """
    across, down = (
        np.stack([begin, (begin + end) / 2, end])[:, np.linspace(0, len(begin) - 1, 9).astype(int)]
        for begin, end in spans
    )
    at = tile.local.grid(across.ravel(), down.ravel()).reshape(2, 3, 9, 3, 9)
    off = at[:, 1, :, 1] - (at[:, 0, :, 0] + at[:, 0, :, 2] + at[:, 2, :, 0] + at[:, 2, :, 2]) / 4
    return 1.1 * float(np.hypot(*off).max())


def _excess(patches: Patches, heights: Floats, i: Indices, j: Indices) -> Floats:
    """Return bounds (n,) on how far cells [i, j] are above those parts of patches that lie over them, metres."""
    (u, v), (u_s, v_s), (u_t, v_t) = patches.middle - np.stack([i, j]), patches.along, patches.aside
    area = u_s * v_t - v_s * u_t
    s, width = _window((v_t * (0.5 - u) - u_t * (0.5 - v)) / area, (np.abs(v_t) + np.abs(u_t)) / area, patches.bend)
    t, height = _window((u_s * (0.5 - v) - v_s * (0.5 - u)) / area, (np.abs(u_s) + np.abs(v_s)) / area, patches.bend)
    # from here on the shares s and t run from 0 to 1 over the window
    u, v = (at + (s - 0.5) * along + (t - 0.5) * aside for at, along, aside in ((u, u_s, u_t), (v, v_s, v_t)))
    u_s, v_s, u_t, v_t = u_s * width, v_s * width, u_t * height, v_t * height
    h = heights[i, j]
    a, b = heights[i + 1, j] - h, heights[i, j + 1] - h
    twist = heights[i + 1, j + 1] - h - a - b
    z, z_s, z_t = patches.z[0, 0], patches.z[1, 0] - patches.z[0, 0], patches.z[0, 1] - patches.z[0, 0]
    z_st = patches.z[1, 1] - z - z_s - z_t
    # the difference of h + a u + b v + twist u v and z + z_s s + z_t t + z_st s t, by powers of s and t
    constant = h + a * u + b * v + twist * u * v - (z + z_s * s + z_t * t + z_st * s * t)
    in_s = a * u_s + b * v_s + twist * (u * v_s + u_s * v) - (z_s + z_st * t) * width
    in_t = a * u_t + b * v_t + twist * (u * v_t + u_t * v) - (z_t + z_st * s) * height
    in_st = twist * (u_s * v_t + u_t * v_s) - z_st * width * height
    in_ss, in_tt = twist * u_s * v_s, twist * u_t * v_t
    most = np.full(len(i), -np.inf)
    for k, m in product(range(3), range(3)):
        linear = constant + in_s * (k / 2) + in_t * (m / 2) + in_st * (k * m / 4)
        most = np.maximum(most, linear + (in_ss if k == 2 else 0.0) + (in_tt if m == 2 else 0.0))
    slack = patches.bend * (np.abs(a) + np.abs(b) + 2 * np.abs(twist))
    return np.where((width >= 0) & (height >= 0), most + slack, -np.inf)


def _window(middle: Floats, reach: Floats, bend: Floats) -> tuple[Floats, Floats]:
    """Return where the shares begin, and how far they run, for which patches may lie over a cell.

    Parameters
    ----------
    middle
        (n,) the shares, less 1/2, of the middle of the cell.
    reach
        (n,) how far the shares run over the cell.
    bend
        (n,) steps of the grid by which patches are bent.
    """
    half = np.abs(reach) * (0.5 + bend)
    begin, end = np.maximum(0.5 + middle - half, 0.0), np.minimum(0.5 + middle + half, 1.0)
    return begin, end - begin


def greatest_around_nodes(cells: Floats) -> Floats:
    """Return for each node the greatest of the values (nx - 1, ny - 1) of the cells around it, (nx, ny)."""
    padded = np.pad(cells, 1, mode="edge")
    return np.maximum.reduce([padded[:-1, :-1], padded[1:, :-1], padded[:-1, 1:], padded[1:, 1:]])
