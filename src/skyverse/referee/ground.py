"""The ground: heights on a grid, bilinear in between; how deep a part of a curve may be below what must be kept."""

from dataclasses import dataclass, replace
from functools import cached_property, reduce

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.referee.judgement import CEILING_NUMBER, GROUND_NUMBER
from skyverse.referee.polynomial import Polynomials
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import MAX_DEPTH
from skyverse.referee.tolerances import LET_PASS, MACHINE_EPSILON, SUMS_ROUNDING, SURELY_OUTSIDE
from skyverse.referee.tracking_error import EXACT, raised_heights, steepest_in_cells


@dataclass(frozen=True, eq=False)
class GrownGround(GrownSolids):
    """The terrain, raised by its clearance.

    Attributes
    ----------
    origin, step
        (2,) metres.
    heights
        (nx, ny) metres.
    raised_by
        Metres above ground that must be kept, less what is let pass.
    highest
        The greatest height of each cell, of each square of 2 x 2 cells, of 4 x 4 cells, and so on.
    slope
        Bound on how much the ground rises over a metre along x and a metre along y.
    """

    origin: Floats
    step: Floats
    heights: Floats
    raised_by: float
    highest: list[Floats]
    slope: float

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of one box that holds everything, since every curve may come near the ground."""
        return np.full((1, 3), -np.inf), np.full((1, 3), np.inf)

    @cached_property
    def largest(self) -> float:
        """The greatest height or depth of the ground, metres from z = 0."""
        return float(np.abs(self.heights).max())

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds on the errors of depths: those of the positions, of halvings, and of the products."""
        size = np.abs(b).max(axis=(1, 2), initial=0.0) + float(np.abs(self.origin).max())
        off = error + (MAX_DEPTH * b.shape[1] + 32) * MACHINE_EPSILON * size
        return (1 + 9 * self.slope) * off + SUMS_ROUNDING * (self.largest + size)

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how far parts may be below what must be kept.

        A part above the highest ground of all cells around it is certainly clear. Where a part lies over at most two by
        two cells, its height above the surface of each cell is a polynomial, which bounds the depth closely.
        """
        first, last = self._cell(part[:, :, :2].min(axis=1)), self._cell(part[:, :, :2].max(axis=1))
        depth: Floats = self._highest_around(first, last) + self.raised_by - part[:, :, 2].min(axis=1)
        close = np.flatnonzero(~(depth <= -SURELY_OUTSIDE) & (last - first <= 1).all(axis=1))
        below = np.full(len(close), -np.inf)
        for east, north in ((0, 0), (1, 0), (0, 1), (1, 1)):
            cell = first[close] + np.array([east, north])
            touched = np.flatnonzero((cell <= last[close]).all(axis=1))
            if len(touched):
                deeper = self._depth_over_cell(part[close[touched]], cell[touched])
                below[touched] = np.maximum(below[touched], deeper)
        depth[close] = np.minimum(depth[close], below)
        return depth

    def gap(self, position: Floats, which: int) -> float:
        """Return how far a position is above ground, metres."""
        return float(position[2] - self.height(position[None, :2])[0])

    def height(self, places: Floats) -> Floats:
        """Return the ground's z (n,) at places (n, 2), metres."""
        cell = self._cell(places)
        (h, a, b, e), (u, v) = self._surface(cell), self._shares(places, cell).T
        return h + a * u + b * v + e * u * v

    def steepest_about(self, place: Floats, radius: float) -> float:
        """Return the steepest slope of the cells that are nearer to a place than a radius, metres; 0 without any."""
        first, last = self._cell(place[:2] - radius), self._cell(place[:2] + radius)
        cell = np.stack(np.meshgrid(*map(np.arange, first, last + 1), indexing="ij"), axis=-1)
        corner = self.origin + cell * self.step
        beyond = np.maximum(np.maximum(corner - place[:2], place[:2] - corner - self.step), 0.0)
        beside = np.linalg.norm(beyond, axis=-1)
        h = self.heights[first[0] : last[0] + 2, first[1] : last[1] + 2]
        return float(steepest_in_cells(h, self.step)[beside < radius].max(initial=0.0))

    def _cell(self, places: Floats) -> Indices:
        """Return the indices (..., 2) of the cells below places (..., 2), or of the nearest cells beyond the grid."""
        index = np.floor((places - self.origin) / self.step)
        last = np.array(self.heights.shape) - 2
        return np.clip(np.nan_to_num(index), 0, last).astype(np.intp)

    def _surface(self, cell: Indices) -> tuple[Floats, Floats, Floats, Floats]:
        """Return h, a, b, e of the height h + a u + b v + e u v, where u and v are shares of a step in the cell."""
        i, j = cell[..., 0], cell[..., 1]
        h, a, b, far = (self.heights[i + di, j + dj] for di, dj in ((0, 0), (1, 0), (0, 1), (1, 1)))
        return h, a - h, b - h, far - a - b + h

    def _shares(self, places: Floats, cell: Indices) -> Floats:
        """Return the shares (..., 2) of a step between the corner of a cell and places (..., 2)."""
        return (places - (self.origin + cell * self.step)) / self.step

    def _depth_over_cell(self, part: Floats, cell: Indices) -> Floats:
        """Return how far parts may be below what must be kept above the surface of one cell, continued beside it."""
        exact = np.zeros(len(part))  # `error` counts all errors once
        shares = self._shares(part[:, :, :2], cell[:, None])
        u, v = (Polynomials(shares[:, :, axis], exact) for axis in (0, 1))
        h, a, b, e = (value[:, None] for value in self._surface(cell))
        level = Polynomials((h - part[:, :, 2]) + self.raised_by + a * u.b + b * v.b, exact)
        return (level.raised(2 * level.degree).b + e * (u * v).b).max(axis=1)

    def _highest_around(self, first: Indices, last: Indices) -> Floats:
        """Return the greatest height in blocks of cells (n, 2) to (n, 2), or in slightly larger blocks; (n,) metres."""
        span = np.maximum((last - first).max(axis=1), 1)
        level = np.ceil(np.log2(span)).astype(np.intp)
        highest = np.empty(len(first))
        for k in np.unique(level):
            these = level == k
            (i, j), (m, n) = (first[these] >> k).T, (last[these] >> k).T
            squares = self.highest[k]
            highest[these] = _maximum(squares[i, j], squares[m, j], squares[i, n], squares[m, n])
        return highest


def grown_ground(
    scenario: Scenario, error: TrackingError = EXACT, like: GrownGround | None = None
) -> GrownGround | None:
    """Return the scenario's ground for a UAV with a tracking error, or ``None`` if it has no terrain.

    `like` is that of the same terrain and error with another clearance, if it is made already.
    """
    terrain, clearance = scenario.terrain, scenario.ground_clearance
    if terrain is None:
        return None
    if like is not None:
        return replace(like, clearance=clearance, raised_by=clearance - LET_PASS)
    heights, step = terrain.heights, np.array(terrain.step)
    if error != EXACT:
        heights = raised_heights(terrain, error)
    highest = [_maximum(heights[:-1, :-1], heights[1:, :-1], heights[:-1, 1:], heights[1:, 1:])]
    while max(highest[-1].shape) > 1:
        squares = np.pad(highest[-1], [(0, n % 2) for n in highest[-1].shape], mode="edge")
        highest.append(_maximum(squares[::2, ::2], squares[1::2, ::2], squares[::2, 1::2], squares[1::2, 1::2]))
    slope = sum(float(np.abs(np.diff(heights, axis=axis)).max()) / step[axis] for axis in (0, 1))
    number = np.array([GROUND_NUMBER])
    return GrownGround(clearance, number, np.array(terrain.origin), step, heights, clearance - LET_PASS, highest, slope)


MIRROR = np.array([1.0, 1.0, -1.0])
"""Factors of x, y and z that turn the world upside down."""


@dataclass(frozen=True, eq=False)
class Ceiling(GrownSolids):
    """What is too high above the terrain.

    Attributes
    ----------
    upside_down
        A ground whose z are the negative z of the ceiling: whatever is above the ceiling is below this ground.
    """

    upside_down: GrownGround

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of one box that holds everything, since every curve may come near the ceiling."""
        return self.upside_down.hulls()

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds on the errors of depths; see `GrownGround.error`."""
        return self.upside_down.error(b, error)

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how far parts may be above the ceiling."""
        return self.upside_down.depth(part * MIRROR, which)

    def gap(self, position: Floats, which: int) -> float:
        """Return how far a position is below the ceiling, metres; negative above it."""
        return self.upside_down.gap(position * MIRROR, which)


def ceiling_above_ground(scenario: Scenario, error: TrackingError = EXACT) -> Ceiling | None:
    """Return the ceiling above the scenario's terrain for a UAV with an error, or ``None`` if there is none.

    It is counted from the terrain's `lowest` heights where these are given.
    """
    terrain, most = scenario.terrain, scenario.max_height
    if terrain is None or most is None:
        return None
    base = terrain.heights if terrain.lowest is None else terrain.lowest
    below = derived(terrain, heights=-(base + most), lowest=None, clearance=0.0)
    upside_down = grown_ground(derived(scenario, terrain=below), error)
    assert upside_down is not None
    return Ceiling(0.0, np.array([CEILING_NUMBER]), upside_down)


def _maximum(*values: Floats) -> Floats:
    return reduce(np.maximum, values)
