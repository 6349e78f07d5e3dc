"""Where strips are flown, and how far apart: so near that the photos of neighbours overlap as asked on all relief."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.interrupt import raise_if_interrupted
from skyverse.numerics.kernel import kernel
from skyverse.numerics.tolerances import SWEEP_CONTACT
from skyverse.space.agility import CLIMB_SHARE
from skyverse.space.ground import height
from skyverse.space.obstacles import Space
from skyverse.space.world import World
from skyverse.survey.footprints import GroundView, height_limits, shared_shares
from skyverse.survey.free_area import FreeArea
from skyverse.survey.ground import GroundCells
from skyverse.survey.heights import gentle
from skyverse.survey.sweep_lines import across

LEAST_SHARE = 0.2
"""Of what level ground allows: strips and photos are not nearer to each other, however steep the ground is."""
SURER = 2e-3
"""By which shares of overlap are more than asked, as they are found from larger cells."""
SPARED = 0.025
"""The share by which strips are nearer than they need be, so that altitudes may be chosen between limits."""
STATIONS = 16
"""Places in what a photo shows along the flight at which heights are found."""
COMPARED = 4
"""Of so many of these places, what photos share is found at one to compare directions."""
SEARCHED = 8
"""Distances between neighbours that are tried."""
MOST_STRIPS = 2000
"""Strips at most of one direction."""
MOVED = (6, 3)
"""Strips before a border that are moved where not all can be."""
SHORTEST = 1.0
"""Metres: along a shorter line one photo is taken, in its middle."""
LOST = 10.0
"""How many times the photos of a direction a part of its strips counts where no height suits."""
TRIED_STRIPS = 4
"""Strips in each direction by which directions are compared."""


@dataclass(frozen=True, eq=False)
class LineWay:
    """A way seen from above: its points (k, 2), and how far along it each is, (k,), metres."""

    points: Floats
    at: Floats

    @classmethod
    def along(cls, points: Floats) -> "LineWay":
        """Return the way along points (k, 2)."""
        legs = np.diff(points, axis=0)
        return cls(points, np.r_[0.0, np.cumsum(np.hypot(legs[:, 0], legs[:, 1]))])

    @property
    def length(self) -> float:
        """Metres."""
        return float(self.at[-1])

    def places(self, at: Floats) -> Floats:
        """Return x, y so far along the way, (n, 2) metres."""
        return np.column_stack([np.interp(at, self.at, self.points[:, axis]) for axis in range(2)])

    def ahead(self, at: Floats) -> Floats:
        """Return the unit vectors along the way, (n, 2)."""
        leg = np.clip(np.searchsorted(self.at, at, side="right") - 1, 0, len(self.at) - 2)
        return ((self.points[1:] - self.points[:-1]) / np.diff(self.at)[:, None])[leg]


def unit(direction: float) -> Floats:
    """Return the unit vector (2,) of a direction, degrees clockwise from north."""
    angle = math.radians(direction)
    return np.array([math.sin(angle), math.cos(angle)])


@dataclass(frozen=True, eq=False)
class GroundSight:
    """How the ground is photographed from lines in one direction.

    Attributes
    ----------
    cells, rough
        The ground, and the same in larger cells, from which overlaps are found.
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
    link
        Metres between bends at least, 0 for multirotors: at each of them aeroplanes are level.
    """

    cells: GroundCells
    rough: GroundCells
    limit: GroundView
    photo: GroundView
    steps: tuple[float, float]
    overlap: tuple[float, float]
    free: FreeArea
    world: World
    steepest: float
    link: float

    @property
    def even(self) -> bool:
        """Whether what photos show is as large everywhere: the ground is level, and they look straight down."""
        return self.world.scenario.terrain is None and self.photo.level == 0.0

    @property
    def middle(self) -> float:
        """Metres ahead of a camera over level ground of the middle of what it shows finely enough."""
        view = self.photo
        return 0.5 * (view.before - view.behind) if self.limit.whole else self.limit.drop * view.level / view.down

    def held(self, spacing: float, share: float, side: bool) -> float:
        """Return about how far apart photos overlap as asked that overlap by a share when they are so far apart."""
        return (
            spacing * (1.0 - self.overlap[side]) * (1.0 - SPARED) / max(1.0 - share, 0.1 * (1.0 - self.overlap[side]))
        )

    def heights(self, at: Floats, places: Floats, ahead: Floats, half: float) -> tuple[Floats, Floats]:
        """Return the least and the greatest z (n,) between which lines may be, nowhere too steep.

        `at` are metres along the way, and the limits hold `half` metres before and after each of (n, 2) `places`.
        """
        most = height_limits(self.cells, self.limit, places, ahead, half)
        # what lies below tells the height where nothing in view is to be seen, and over level ground anyway
        under = _under(self.cells, places) + self.limit.drop
        floor, ceiling = clear_heights(self.world.space, places, ahead, half)
        if len(self.free.roofs):
            tree = shapely.STRtree(self.free.roofs)
            which, roof = tree.query(shapely.points(places), predicate="dwithin", distance=half)
            np.maximum.at(floor, which, self.free.tops[roof])
        level = self.world.scenario.terrain is None
        most = np.minimum(under if level else np.where(np.isinf(most), under, most), ceiling)
        floor, most = floor + self.off, most - self.off
        return gentle(at, floor, self.steepest, -1.0), gentle(at, most, self.steepest, 1.0)

    @property
    def off(self) -> float:
        """Metres by which aeroplanes that are level at bends are above or below a line at most."""
        return 0.5 * (1.0 - CLIMB_SHARE) * self.link * self.steepest


def _under(cells: GroundCells, places: Floats) -> Floats:
    index = np.floor((places - cells.origin) / cells.step).astype(np.intp)
    i, j = np.clip(index, 0, np.array(cells.middle.shape) - 1).T
    return cells.middle[i, j]


def greatest_spacing(
    sight: GroundSight, share: Callable[[float, int], float], most: float, *, side: bool, finely: bool = True
) -> float:
    """Return about the greatest distance, metres, at which photos share what is asked.

    Parameters
    ----------
    sight
        How the ground is photographed.
    share
        Tells of a distance the least share, found at one of so many places.
    most
        Metres that it is at most.
    side
        Whether it is that of strips, or of photos on one.
    finely
        Whether all places are asked in the end.
    """
    if sight.even:
        return most
    asked, high, spacing, low = sight.overlap[side] + SURER, most, most, 0.0
    for every in (COMPARED, 1) if finely else (COMPARED,):
        low = LEAST_SHARE * sight.steps[side]
        for _ in range(SEARCHED):
            found = share(spacing, every)
            low, high = (max(low, spacing), high) if found >= asked else (low, min(high, spacing))
            if low >= high * (1.0 - 0.5 * SPARED):
                break
            spacing = min(max(sight.held(spacing, found, side), low + 0.1 * (high - low)), high - 0.1 * (high - low))
        spacing = low
    return low


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
    """Where strips are flown over relief: called by the sweep with a direction, an area, and its extent across.

    Cameras look along the unit vector `look`, or along the direction without one.
    """

    sight: GroundSight
    look: Floats | None = None
    known: list[tuple[Floats, Floats]] = field(default_factory=list)

    def __call__(self, way: Floats, area: Any, low: float, high: float) -> Floats:
        """Return the offsets (n,) of strips, metres to the right of a unit vector along them."""
        for known, offsets in self.known:
            if np.array_equal(known, way):
                return offsets
            if np.array_equal(known, -way):
                return -offsets[::-1]
        turned = across(area, way)
        widest = self.sight.steps[1]
        if high - low <= widest:
            return np.array([0.5 * (low + high)])
        gap = self.gap(way, turned, low, widest)
        found = [low + 0.5 * gap]
        while True:
            gap = self.gap(way, turned, found[-1], widest)
            if found[-1] + 0.5 * gap >= high - SWEEP_CONTACT:
                break
            found.append(found[-1] + gap)
        offsets = self._evenly(way, turned, np.array([low, *found, found[-1] + 0.5 * gap]), high)
        self.known.append((way, offsets))
        return offsets

    def _evenly(self, way: Floats, turned: Any, places: Floats, high: float) -> Floats:
        """Return offsets a little nearer to each other than at `places`, which begin and end at borders.

        The last of those strips may lie beyond what is to be seen, or beside the one before. All of them are moved, or
        fewer where photos would not overlap.
        """
        count, widest = len(places) - 2, self.sight.steps[1]
        index = np.r_[0.0, np.arange(count) + 0.5, count]
        used = float(np.interp(high, places, index))
        for kept in sorted({max(count - moved, 0) for moved in (count, *MOVED)}):
            found = list(places[1 : kept + 1])
            step = (used - kept + 0.5) / (count - kept + 0.5) if kept else used / count
            begin = kept - 0.5 + step if kept else 0.5 * step
            for at in np.interp(begin + step * np.arange(count - kept), index, places):
                found.append(found[-1] + self.gap(way, turned, found[-1], min(at - found[-1], widest)) if found else at)
            left = 2.0 * (high - found[-1])
            if self.gap(way, turned, found[-1], min(left, widest)) >= left - SWEEP_CONTACT:
                return np.array(found)
        return np.array([*places[1:-2], min(places[-2], high - (places[-1] - places[-2]))])

    def gap(self, way: Floats, turned: Any, offset: float, most: float, finely: bool = True) -> float:
        """Return the greatest distance to the next strip at which the photos of both overlap as asked, metres."""
        raise_if_interrupted()
        sight, widest = self.sight, self.sight.steps[1]
        band = shapely.intersection(turned, shapely.box(offset - widest, -1e9, offset + widest, 1e9))
        if band.is_empty or sight.even:
            return most
        _, begin, _, end = band.bounds
        length = sight.steps[0] / (1.0 - sight.overlap[0])
        at = np.linspace(begin, end, max(int((end - begin) / length * STATIONS), 1) + 1)
        ahead = np.tile(way if self.look is None else self.look, (len(at), 1))

        def cameras(x: float, every: int) -> Floats:
            places = at[::every, None] * way + x * np.array([way[1], -way[0]])
            return np.column_stack([places, sight.heights(at[::every], places, ahead[::every], at[1] - at[0])[1]])

        first = cameras(offset, 1 if finely else COMPARED)

        def share(gap: float, every: int) -> float:
            here = first[:: every if finely else 1]
            return float(
                shared_shares(sight.rough, sight.photo, here, cameras(offset + gap, every), ahead[::every]).min()
            )

        return greatest_spacing(sight, share, most, side=True, finely=finely)


def best_direction(sight: GroundSight, area: Any) -> Floats:
    """Return the unit vector along which strips over relief take the fewest photos, by a few strips each.

    Tried are the sides of the smallest rectangle around the area, the contours of the ground, and across them.
    """
    corners = shapely.get_coordinates(area.minimum_rotated_rectangle)
    ways = [corners[1] - corners[0], corners[2] - corners[1]]
    seen = np.isfinite(sight.cells.low)
    slope_x, slope_y = np.gradient(sight.cells.middle, *sight.cells.step) if min(seen.shape) > 1 else (0.0, 0.0)
    xx, xy, yy = ((one * seen).sum() for one in (slope_x * slope_x, slope_x * slope_y, slope_y * slope_y))
    steep = 0.5 * math.atan2(2.0 * xy, xx - yy)
    if xx + yy > 0.0:
        ways += [np.array([-math.sin(steep), math.cos(steep)]), np.array([math.cos(steep), math.sin(steep)])]
    found = [way / math.hypot(*way) for way in ways]
    return min(found, key=lambda way: _photos(sight, area, way))


def _photos(sight: GroundSight, area: Any, way: Floats) -> float:
    """Return about how many photos strips along a unit vector take, each counted with the time of a turn."""
    turned, offsets = across(area, way), ReliefOffsets(sight)
    x0, y0, x1, y1 = turned.bounds
    photos, lost = 0.0, 0.0
    for x in x0 + (np.arange(TRIED_STRIPS) + 0.5) * (x1 - x0) / TRIED_STRIPS:
        raise_if_interrupted()
        at = np.linspace(y0, y1, max(int((y1 - y0) * (1.0 - sight.overlap[0]) / sight.steps[0] * STATIONS), 1) + 1)
        places, ahead = at[:, None] * way + x * np.array([way[1], -way[0]]), np.tile(way, (len(at), 1))
        floor, z = sight.heights(at, places, ahead, at[1] - at[0])
        lost += float((floor > z).mean()) / TRIED_STRIPS
        cameras = np.column_stack([places, z])
        ahead_too = np.column_stack([places + sight.steps[0] * way, z])
        share = float(
            shared_shares(sight.rough, sight.photo, cameras[::COMPARED], ahead_too[::COMPARED], ahead[::COMPARED]).min()
        )
        step = min(max(sight.held(sight.steps[0], share, False), LEAST_SHARE * sight.steps[0]), sight.steps[0])
        gap = offsets.gap(way, turned, float(x), sight.steps[1], finely=False)
        photos += ((y1 - y0) / step + 2.0) * (x1 - x0) / TRIED_STRIPS / gap
    return photos * (1.0 + LOST * lost)
