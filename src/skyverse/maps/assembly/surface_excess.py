"""How far the surface of a grid is beyond that of a raster at most, cell by cell; a bound that is never too small.

Between the centres of four pixels the raster's surface is bilinear in columns and rows; within a cell of the grid, the
grid's is bilinear in x and y. Over the part of a patch of pixels that lies over one cell both are polynomials of degree
(2, 2) in columns and rows. Their difference is at most its greatest Bernstein coefficient.

Source: R. T. Farouki, "The Bernstein polynomial basis: a centennial retrospective", Computer Aided Geometric Design 29
(2012), 379-419.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.maps.readers.raster_tiles import Tile
from skyverse.numerics.kernel import inner_query, query

STRIP_PATCHES = 100_000
"""Patches of a raster that are handled together, which bounds the memory."""
_EDGE = 1e-3
"""Pixels that a surface reaches beyond a raster's edge, as places so near count as inside."""
_ROUNDING = 1e-9
"""Steps of the grid by which a patch of pixels is taken to be wider, because of rounding."""
Pair = tuple[float, float]


def surface_excess(tile: Tile, place: tuple[Floats, Floats], heights: Floats, lowest: Floats) -> Floats:
    """Return how far two surfaces of a grid are beyond a raster's at most over each cell, (2, nx - 1, ny - 1) metres.

    That is how far that of `heights` is below the raster's, and that of `lowest` above its lowest. Where the raster has
    no data nothing is known, and the bound is minus infinity.

    Parameters
    ----------
    tile
        The raster's window.
    place
        x (nx,) and y (ny,) of the grid's nodes, metres, with equal steps.
    heights, lowest
        (nx, ny) z of the nodes of each surface, metres.
    """
    surfaces, values = np.stack([-heights, lowest]), np.stack([-tile.heights, tile.lowest])
    cells = np.full((2, heights.shape[0] - 1, heights.shape[1] - 1), -np.inf)
    corner, step = (np.array([line[k] for line in place])[:, None, None] for k in (0, 1))
    step -= corner
    across, down = (_patch_ends(tile, axis) for axis in (0, 1))
    if tile.block == 1:
        stride, values = 1, np.pad(values, ((0, 0), (1, 1), (1, 1)), mode="edge")
    else:
        stride, values = 2, values.repeat(2, axis=1).repeat(2, axis=2)
    bend = (
        _curvature(tile, *((ends[:-1:stride], ends[1::stride]) for ends in (across, down))) / float(step.min())
        + _ROUNDING
    )
    many = stride * max(1, STRIP_PATCHES // len(across))
    for first in range(0, len(down) - 1, many):
        part = slice(first, first + many + 1)
        at = (tile.local.grid(across, down[part]) - corner) / step
        raise_cells(cells, surfaces, at, np.ascontiguousarray(values[:, part]), stride, bend)
    return cells


def _patch_ends(tile: Tile, axis: int) -> Floats:
    """Return where the patches of a tile end along columns, or rows.

    Single pixels have patches between their centres, and narrow ones at the raster's edge, where the surface is level:
    one begins where the one before ends. A block of pixels has one level patch up to the centres of the pixels beside
    it, with two ends of its own.
    """
    begin, count = tile.corner[axis], tile.heights.shape[1 - axis]
    if tile.block == 1:
        return begin + np.clip(np.arange(-1, count + 1) + 0.5, -_EDGE, count + _EDGE)
    blocks = begin + tile.block * np.arange(count)
    return np.column_stack([blocks - 0.5, blocks + tile.block + 0.5]).ravel()


def _curvature(tile: Tile, *spans: tuple[Floats, Floats]) -> float:
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


@query
def raise_cells(cells: Floats, surfaces: Floats, places: Floats, z: Floats, stride: int, curved: float) -> None:
    """Raise the excess of cells (n, nx - 1, ny - 1) of each surface of a grid to that over each patch of a raster.

    Within a patch places are affine in the shares s of columns and t of rows, from 0 to 1, to a bend:
    middle + (s - 1/2) along + (t - 1/2) aside. Where some of its corners have no data, the lowest of the others counts.

    Parameters
    ----------
    cells, surfaces
        The excess, metres, and the z (n, nx, ny) of the nodes.
    places, z
        (2, k, m) steps of the grid, and (n, m, k) metres for each surface, at the ends of k columns and m rows of
        patches.
    stride
        How many ends of patches there are from one patch to the next.
    curved
        Steps of the grid that places are off the bilinear ones between the corners of a patch, at most.
    """
    for k in range(0, places.shape[1] - 1, stride):
        for m in range(0, places.shape[2] - 1, stride):
            x_0, x_t, x_s, x_st = (places[0, k, m], places[0, k, m + 1], places[0, k + 1, m], places[0, k + 1, m + 1])
            y_0, y_t, y_s, y_st = (places[1, k, m], places[1, k, m + 1], places[1, k + 1, m], places[1, k + 1, m + 1])
            x, y = (x_0 + x_t + x_s + x_st) / 4, (y_0 + y_t + y_s + y_st) / 4
            along = (x_s + x_st - x_0 - x_t) / 2, (y_s + y_st - y_0 - y_t) / 2
            aside = (x_t + x_st - x_0 - x_s) / 2, (y_t + y_st - y_0 - y_s) / 2
            bend = (abs(x_0 + x_st - x_t - x_s) + abs(y_0 + y_st - y_t - y_s)) / 4 + curved
            wide = (abs(along[0]) + abs(aside[0])) / 2 + bend
            tall = (abs(along[1]) + abs(aside[1])) / 2 + bend
            i_0, i_1 = max(0, math.floor(x - wide)), min(cells.shape[1] - 1, math.floor(x + wide)) + 1
            j_0, j_1 = max(0, math.floor(y - tall)), min(cells.shape[2] - 1, math.floor(y + tall)) + 1
            for which in range(len(cells)):
                lowest = math.inf
                a, b, c, d = z[which, m, k], z[which, m + 1, k], z[which, m, k + 1], z[which, m + 1, k + 1]
                for one in (a, b, c, d):
                    if one < lowest:
                        lowest = one
                if lowest == math.inf:
                    continue
                level = (
                    lowest if math.isnan(a) else a,
                    lowest if math.isnan(b) else b,
                    lowest if math.isnan(c) else c,
                    lowest if math.isnan(d) else d,
                )
                for i in range(i_0, i_1):
                    for j in range(j_0, j_1):
                        most = _excess(surfaces[which], i, j, (x - i, y - j), along, aside, bend, level)
                        cells[which, i, j] = max(cells[which, i, j], most)


@inner_query
def _excess(
    heights: Floats, i: int, j: int, middle: Pair, along: Pair, aside: Pair, bend: float, level: tuple[float, ...]
) -> float:
    """Return a bound on how far cell [i, j] is above that part of a patch that lies over it, metres.

    The middle of the patch is counted from the corner of the cell; see `raise_cells`.
    """
    (u, v), (u_s, v_s), (u_t, v_t) = middle, along, aside
    area = u_s * v_t - v_s * u_t
    s, width = _window((v_t * (0.5 - u) - u_t * (0.5 - v)) / area, (abs(v_t) + abs(u_t)) / area, bend)
    t, height = _window((u_s * (0.5 - v) - v_s * (0.5 - u)) / area, (abs(u_s) + abs(v_s)) / area, bend)
    if not (width >= 0 and height >= 0):
        return -math.inf
    # from here on the shares s and t run from 0 to 1 over the window
    u, v = u + (s - 0.5) * u_s + (t - 0.5) * u_t, v + (s - 0.5) * v_s + (t - 0.5) * v_t
    u_s, v_s, u_t, v_t = u_s * width, v_s * width, u_t * height, v_t * height
    h = heights[i, j]
    a, b = heights[i + 1, j] - h, heights[i, j + 1] - h
    twist = heights[i + 1, j + 1] - h - a - b
    z = level[0]
    z_t, z_s = level[1] - z, level[2] - z
    z_st = level[3] - z - z_s - z_t
    # the difference of h + a u + b v + twist u v and z + z_s s + z_t t + z_st s t, by powers of s and t
    constant = h + a * u + b * v + twist * u * v - (z + z_s * s + z_t * t + z_st * s * t)
    in_s = a * u_s + b * v_s + twist * (u * v_s + u_s * v) - (z_s + z_st * t) * width
    in_t = a * u_t + b * v_t + twist * (u * v_t + u_t * v) - (z_t + z_st * s) * height
    in_st = twist * (u_s * v_t + u_t * v_s) - z_st * width * height
    most = -math.inf
    for k in range(3):
        for m in range(3):
            one = constant + in_s * (k / 2) + in_t * (m / 2) + in_st * (k * m / 4)
            one += (twist * u_s * v_s if k == 2 else 0.0) + (twist * u_t * v_t if m == 2 else 0.0)
            most = max(most, one)
    return most + bend * (abs(a) + abs(b) + 2 * abs(twist))


@inner_query
def _window(middle: float, reach: float, bend: float) -> Pair:
    """Return where the shares begin, and how far they run, for which a patch may lie over a cell.

    Parameters
    ----------
    middle
        The shares, less 1/2, of the middle of the cell.
    reach
        How far the shares run over the cell.
    bend
        Steps of the grid by which the patch is bent.
    """
    half = abs(reach) * (0.5 + bend)
    begin, end = max(0.5 + middle - half, 0.0), min(0.5 + middle + half, 1.0)
    return begin, end - begin


def greatest_around_nodes(cells: Floats) -> Floats:
    """Return for each node the greatest of the values (nx - 1, ny - 1) of the cells around it, (nx, ny)."""
    padded = np.pad(cells, 1, mode="edge")
    return np.maximum.reduce([padded[:-1, :-1], padded[1:, :-1], padded[:-1, 1:], padded[1:, 1:]])
