"""The ground: heights on a grid, bilinear between; and how deep a part of a curve may be below what must be kept."""

from functools import reduce
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.referee.boxes import GROUND, TOLERANCE, keeps
from skyverse.referee.polynomial import DEPTH, EPS, Polynomials


class Ground(NamedTuple):
    """The terrain.

    Attributes
    ----------
    origin, step
        (2,) metres.
    heights
        (nx, ny) metres.
    shut
        Metres above ground that must be kept, less the tolerance.
    highest
        The greatest height in each cell, in each square of 2 x 2 cells, of 4 x 4, and so on.
    slope
        How much the heights change at most over a metre along x and a metre along y.
    obstacle
        (1,) the ground's number.
    """

    origin: Floats
    step: Floats
    heights: Floats
    shut: float
    highest: list[Floats]
    slope: float
    obstacle: Indices

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of a box that holds everything: all may be near the ground."""
        return np.full((1, 3), -np.inf), np.full((1, 3), np.inf)

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds on the errors of depths of pieces: those of places, of their halvings, and of the products."""
        size = np.abs(b).max(axis=(1, 2), initial=0.0) + float(np.abs(self.origin).max())
        off = error + (DEPTH * b.shape[1] + 32) * EPS * size
        whole: Floats = (1 + 9 * self.slope) * off + 64 * EPS * (float(np.abs(self.heights).max()) + size)
        return whole

    def cell(self, places: Floats) -> Indices:
        """Return the indices (..., 2) of the cells of places (..., 2); of places beside the ground, the nearest."""
        index = np.floor((places - self.origin) / self.step)
        last = np.array(self.heights.shape) - 2
        cell: Indices = np.clip(np.nan_to_num(index), 0, last).astype(np.intp)
        return cell

    def surface(self, cell: Indices) -> tuple[Floats, Floats, Floats, Floats]:
        """Return each cell's height as h + a u + b v + e u v, with u and v the shares of a step from its corner."""
        i, j = cell[..., 0], cell[..., 1]
        h, a, b, far = (self.heights[i + di, j + dj] for di, dj in ((0, 0), (1, 0), (0, 1), (1, 1)))
        return h, a - h, b - h, far - a - b + h

    def shares(self, places: Floats, cell: Indices) -> Floats:
        """Return the shares (..., 2) of a step that places are from their cell's corner."""
        shares: Floats = (places - (self.origin + cell * self.step)) / self.step
        return shares

    def height(self, places: Floats) -> Floats:
        """Return the ground's z at places (n, 2); (n,) metres."""
        cell = self.cell(places)
        (h, a, b, e), (u, v) = self.surface(cell), self.shares(places, cell).T
        height: Floats = h + a * u + b * v + e * u * v
        return height

    def gap(self, position: Floats, which: int) -> float:
        """Return how far one position is above ground, metres."""
        return float(position[2] - self.height(position[None, :2])[0])

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how far parts may be below what must be kept.

        Above the highest ground of all cells around, for certain not. Else, in two by two cells at most, height and
        place are polynomials, and so is their difference in each cell.
        """
        first, last = self.cell(part[:, :, :2].min(axis=1)), self.cell(part[:, :, :2].max(axis=1))
        deep: Floats = self._highest(first, last) + self.shut - part[:, :, 2].min(axis=1)
        close = np.flatnonzero(~(deep <= -TOLERANCE) & (last - first <= 1).all(axis=1))
        below = np.full(len(close), -np.inf)
        for east, north in ((0, 0), (1, 0), (0, 1), (1, 1)):
            cell = first[close] + np.array([east, north])
            touched = np.flatnonzero((cell <= last[close]).all(axis=1))
            if len(touched):
                deeper = self._below(part[close[touched]], cell[touched])
                below[touched] = np.maximum(below[touched], deeper)
        deep[close] = np.minimum(deep[close], below)
        return deep

    def _below(self, part: Floats, cell: Indices) -> Floats:
        """Return how far parts may be below what must be kept above one cell's surface, carried on beside it."""
        exact = np.zeros(len(part))  # errors are counted once, by `error`
        shares = self.shares(part[:, :, :2], cell[:, None])
        u, v = (Polynomials(shares[:, :, axis], exact) for axis in (0, 1))
        h, a, b, e = (value[:, None] for value in self.surface(cell))
        level = Polynomials((h - part[:, :, 2]) + self.shut + a * u.b + b * v.b, exact)
        deep: Floats = (level.raised(2 * level.degree).b + e * (u * v).b).max(axis=1)
        return deep

    def _highest(self, first: Indices, last: Indices) -> Floats:
        """Return the greatest height in blocks of cells or a little around them."""
        span = np.maximum((last - first).max(axis=1), 1)
        level = np.ceil(np.log2(span)).astype(np.intp)
        highest = np.empty(len(first))
        for k in np.unique(level):
            these = level == k
            (i, j), (m, n) = (first[these] >> k).T, (last[these] >> k).T
            squares = self.highest[k]
            highest[these] = _greatest(squares[i, j], squares[m, j], squares[i, n], squares[m, n])
        return highest

    def pieces(self, a: Floats, b: Floats) -> tuple[Floats, Floats]:
        """Cut the straight leg from a to b (3,) where it meets borders of cells.

        Returns
        -------
        cuts
            (n + 1,) shares of the leg, from 0 to 1.
        above
            (n, 3) coefficients of its height above ground in each piece, as a polynomial in the share, from the
            constant on; metres.
        """
        way = b - a
        shares = [np.array([0.0, 1.0])]
        for axis in (0, 1):
            if way[axis] != 0:
                low, high = np.sort((np.array([a[axis], b[axis]]) - self.origin[axis]) / self.step[axis])
                borders = np.arange(max(np.floor(low), 0), min(np.ceil(high), self.heights.shape[axis] - 1) + 1)
                shares.append((self.origin[axis] + borders * self.step[axis] - a[axis]) / way[axis])
        cuts = np.unique(np.clip(np.concatenate(shares), 0.0, 1.0))
        middles = a[:2] + ((cuts[:-1] + cuts[1:]) / 2)[:, None] * way[:2]
        cell = self.cell(middles)
        (h, p, q, e), (u, v) = self.surface(cell), self.shares(np.broadcast_to(a[:2], middles.shape), cell).T
        du, dv = way[:2] / self.step
        constant = a[2] - (h + p * u + q * v + e * u * v)
        slope = way[2] - (p * du + q * dv + e * (u * dv + v * du))
        return cuts, np.column_stack([constant, slope, -e * du * dv])


def ground_of(scenario: Scenario) -> Ground | None:
    """Return the scenario's ground, if it has a terrain."""
    terrain = scenario.terrain
    if terrain is None:
        return None
    heights, step = terrain.heights, np.array(terrain.step)
    highest = [_greatest(heights[:-1, :-1], heights[1:, :-1], heights[:-1, 1:], heights[1:, 1:])]
    while max(highest[-1].shape) > 1:
        squares = np.pad(highest[-1], [(0, n % 2) for n in highest[-1].shape], mode="edge")
        highest.append(_greatest(squares[::2, ::2], squares[1::2, ::2], squares[::2, 1::2], squares[1::2, 1::2]))
    steepest = [float(np.abs(np.diff(heights, axis=axis)).max()) / step[axis] for axis in (0, 1)]
    shut = keeps(scenario, GROUND) - TOLERANCE
    return Ground(np.array(terrain.origin), step, heights, shut, highest, sum(steepest), np.array([GROUND]))


def _greatest(*values: Floats) -> Floats:
    return reduce(np.maximum, values)
