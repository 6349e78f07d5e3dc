"""Where strips are flown, and how far apart: so near that the photos of neighbours overlap as asked on all relief."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.numerics.kernel import kernel
from skyverse.space.ground import height
from skyverse.space.obstacles import Space
from skyverse.space.world import World
from skyverse.survey.footprints import GroundView, height_limits, shared_depths
from skyverse.survey.free_area import FreeArea
from skyverse.survey.ground import GroundCells
from skyverse.survey.heights import gentle

LEAST_SHARE = 0.2
"""Of what level ground allows: strips and photos are not nearer to each other, however steep the ground is."""
SPARED = 0.02
"""The share by which strips are nearer than they need be, so that altitudes may be chosen between limits."""
STATIONS = 12
"""Places in what a photo shows along the flight at which strips are compared, and twice as many of those flown."""
MOST_STRIPS = 2000
"""Strips at most of one direction."""


@dataclass(frozen=True, eq=False)
class GroundSight:
    """How the ground is photographed from lines in one direction.

    Attributes
    ----------
    cells
        The ground.
    limit
        What of it limits the heights.
    photo
        What photos show.
    steps
        Metres from photo to photo, and from strip to strip, over level ground.
    overlap
        Shares that photos show of the one before and of the strip beside.
    free
        Where the UAVs may be.
    world
        What must be kept clear of.
    steepest
        Metres of height a metre that they climb or descend.
    """

    cells: GroundCells
    limit: GroundView
    photo: GroundView
    steps: tuple[float, float]
    overlap: tuple[float, float]
    free: FreeArea
    world: World
    steepest: float

    def needed(self, spacing: float, side: bool) -> float:
        """Return the depth below cameras so far apart at which they still overlap as asked, metres."""
        half = self.photo.across if side else self.photo.along
        return spacing / ((1.0 - self.overlap[side]) * 2.0 * half)

    def heights(self, at: Floats, places: Floats, ahead: Floats, half: float) -> tuple[Floats, Floats]:
        """Return the least and the greatest z (n,) between which lines may be, nowhere too steep.

        `at` are metres along the way, and the limits hold `half` metres before and after each of (n, 2) `places`.
        """
        most = height_limits(self.cells, self.limit, places, ahead, half)
        under = _under(self.cells, places) + self.limit.drop
        floor, ceiling = clear_heights(self.world.space, places, ahead, half)
        if len(self.free.roofs):
            tree = shapely.STRtree(self.free.roofs)
            which, roof = tree.query(shapely.points(places), predicate="dwithin", distance=half)
            np.maximum.at(floor, which, self.free.tops[roof])
        most = np.minimum(np.where(np.isinf(most), under, most), ceiling)
        return gentle(at, floor, self.steepest, -1.0), gentle(at, most, self.steepest, 1.0)


def _under(cells: GroundCells, places: Floats) -> Floats:
    index = np.floor((places - cells.origin) / cells.step).astype(np.intp)
    i, j = np.clip(index, 0, np.array(cells.middle.shape) - 1).T
    return cells.middle[i, j]


@kernel
def clear_heights(space: Space, places: Floats, ahead: Floats, half: float) -> tuple[Floats, Floats]:
    """Return the least and the greatest z (n,) that keep clear of ground, ceiling and bounds near places (n, 2).

    Near is as far as `half` metres before and behind, sampled four times a cell of the ground.
    """
    floor, ceiling = np.full(len(places), space.low[2]), np.full(len(places), space.high[2])
    if space.ground.heights.size == 0:
        return floor, ceiling
    count = 2 * int(np.ceil(2.0 * half / min(space.ground.step[0], space.ground.step[1]))) + 1
    for k in range(len(places)):
        for i in range(-count, count + 1):
            x, y = places[k, 0] + ahead[k, 0] * half * i / count, places[k, 1] + ahead[k, 1] * half * i / count
            floor[k] = max(floor[k], height(space.ground, x, y) + space.clearance + space.ground.extra)
            if space.ceiling.heights.size > 0:
                top = -height(space.ceiling, x, y) - space.clearance - space.ceiling.extra
                ceiling[k] = min(ceiling[k], top)
    return floor, ceiling


@dataclass(frozen=True, eq=False)
class ReliefOffsets:
    """Where strips are flown over relief: called by the sweep with a direction, an area, and its extent across."""

    sight: GroundSight

    def __call__(self, way: Floats, area: Any, low: float, high: float) -> Floats:
        """Return the offsets (n,) of strips, metres to the right of a unit vector along them.

        Raises
        ------
        InputError
            Too many strips are needed.
        """
        ux, uy = way
        turned = shapely.transform(
            area, lambda p: np.stack([p[:, 0] * uy - p[:, 1] * ux, p[:, 0] * ux + p[:, 1] * uy], 1)
        )
        widest = self.sight.steps[1]
        if (high - low) / widest > MOST_STRIPS:
            said = f"needs {(high - low) / widest:,.0f} strips, but {MOST_STRIPS:,} are the most; take a larger area"
            raise InputError(f"{said} or a coarser gsd", field="area")
        if high - low <= widest:
            return np.array([0.5 * (low + high)])
        gap = self.gap(way, turned, low)
        found = [low + 0.5 * gap]
        while True:
            gap = self.gap(way, turned, found[-1])
            if found[-1] + 0.5 * gap >= high:
                return np.array(found)
            found.append(min(found[-1] + gap, high))

    def gap(self, way: Floats, turned: Any, offset: float) -> float:
        """Return the greatest distance to the next strip at which the photos of both overlap as asked, metres."""
        sight, (widest, least) = self.sight, (self.sight.steps[1], LEAST_SHARE * self.sight.steps[1])
        band = shapely.intersection(turned, shapely.box(offset - widest, -1e9, offset + widest, 1e9))
        if band.is_empty:
            return widest
        _, begin, _, end = band.bounds
        length = 2.0 * sight.steps[0] / (1.0 - sight.overlap[0])
        at = np.linspace(begin, end, max(int((end - begin) / length * STATIONS), 1) + 1)
        ahead = np.tile(way, (len(at), 1))

        def cameras(x: float) -> Floats:
            places = at[:, None] * way + x * np.array([way[1], -way[0]])
            return np.column_stack([places, sight.heights(at, places, ahead, 0.5 * (at[1] - at[0]))[1]])

        first, gap = cameras(offset), widest
        for _ in range(20):
            depth = float(shared_depths(sight.cells, sight.photo, first, cameras(offset + gap), ahead).min())
            held = max(min((1.0 - SPARED) * depth / sight.needed(1.0, True), gap), least)
            if held >= gap * (1.0 - 0.25 * SPARED):
                break
            gap = held
        return max(held, least)
