"""The lines of a survey of the ground: strips in one direction or two, slanting ones, and those along a line."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import shapely

from skyverse._typing import Bools, Floats
from skyverse.errors import InputError
from skyverse.model.coverage import CoverageGap
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.model.uav import UAV, TrackingError
from skyverse.space.world import World
from skyverse.survey.corridor import corridor_strips
from skyverse.survey.footprints import GroundView, Unsteady, mark_seen, shared_shares
from skyverse.survey.free_area import FreeArea, free_area
from skyverse.survey.ground import GroundCells, ground_cells, wanted_ground
from skyverse.survey.heights import fewest_points, gentle
from skyverse.survey.leg_time import LegTime
from skyverse.survey.lines import PhotoLine, SurveyLines
from skyverse.survey.spacing import (
    MOST_STRIPS,
    SHORTEST,
    STATIONS,
    GroundSight,
    LineWay,
    ReliefOffsets,
    best_direction,
    clear_heights,
    even_offsets,
    greatest_spacing,
    unit,
)
from skyverse.survey.sweep import sweep

CELLS_ALONG = 60
"""Cells of the ground along the shorter side of a photo."""
ROUGH_ALONG = 18
"""Those from which overlaps are found."""
SPARE = 0.004
"""By so much more than asked photos overlap, as the ground is looked at by places."""
STEEPEST = 1.0
"""Metres of height a metre: lines are nowhere steeper, whatever the UAVs can do."""
ROOM_ALONG = 40
"""Cells along the side of a square as large as the area, in which the heights are found that the ceiling allows."""
NEAREST = 1.0
"""Metres from which photos are taken at least."""
TUBE = 0.15
"""The share of the height above ground by which a line may be lower than it might be, to have fewer bends."""
LEAST_TUBE = 0.001
"""By so much of it a line may be lower in any case: overlaps suffer less than it matters."""
MORE_PHOTOS = 4
"""Numbers of photos on a line that are tried till they overlap as asked on the ground in small cells."""
CLEAR_PARTS = 7
"""How often a line that is not clear is halved to find its clear parts."""


@dataclass(frozen=True)
class Pass:
    """Strips that are flown together.

    Attributes
    ----------
    pitch
        Degrees above the horizon at which the camera looks.
    turned
        Degrees clockwise from the direction of the strips of a survey; the camera looks ahead along it.
    """

    pitch: float
    turned: float


def passes_of(survey: Survey) -> tuple[Pass, ...]:
    """Return the passes of a pattern over an area."""
    if survey.pattern == "cross":
        return Pass(survey.pitch, 0.0), Pass(survey.pitch, 90.0)
    if survey.pattern == "oblique":
        return Pass(-90.0, 0.0), *(Pass(survey.pitch, turned) for turned in (0.0, 180.0, 90.0, 270.0))
    return (Pass(survey.pitch, 0.0),)


@dataclass(frozen=True)
class GroundSurvey:
    """A survey of the ground, and what all of its lines share."""

    scenario: Scenario
    number: int

    @property
    def survey(self) -> Survey:
        """What is to be seen."""
        return self.scenario.surveys[self.number]

    @cached_property
    def uavs(self) -> tuple[UAV, ...]:
        """Those that may fly it."""
        names = self.survey.uavs
        found = tuple(uav for uav in self.scenario.uavs if not names or uav.name in names)
        return found or (UAV(start=(0.0, 0.0, 0.0)),)

    @cached_property
    def error(self) -> TrackingError:
        """How far any of them may stray."""
        errors = [uav.tracking_error for uav in self.uavs]
        return TrackingError(horizontal=max(e.horizontal for e in errors), vertical=max(e.vertical for e in errors))

    @cached_property
    def wanted(self) -> Any:
        """The ground that is to be seen, a shapely geometry."""
        return wanted_ground(self.survey)

    @cached_property
    def cells(self) -> GroundCells:
        """That ground, and what is around it."""
        return self._cells(CELLS_ALONG)

    @cached_property
    def rough(self) -> GroundCells:
        """The same in larger cells."""
        return self._cells(ROUGH_ALONG, touched=False)

    def _cells(self, along: int, *, touched: bool = True) -> GroundCells:
        distance = min(self.survey.distance, max(self.room, NEAREST))
        side = 2.0 * min(self.survey.camera.half_widths) * distance
        return ground_cells(self.scenario, self.wanted, side / along, 2.0 * distance, touched=touched)

    @cached_property
    def world(self) -> World:
        """What must be kept clear of."""
        return World(self.scenario, self.error)

    @cached_property
    def room(self) -> float:
        """Metres from most of the ground to the ceiling there."""
        cells = ground_cells(self.scenario, self.wanted, math.sqrt(self.wanted.area) / ROOM_ALONG, 0.0)
        wanted = np.argwhere(np.isfinite(cells.low))
        places = cells.origin + (wanted + 0.5) * cells.step
        _, ceiling = clear_heights(self.world.space, places, np.zeros_like(places), 0.0)
        return float(np.median(ceiling - cells.middle[tuple(wanted.T)]))

    @property
    def off(self) -> Unsteady:
        """By how much cameras may be off."""
        turned = math.radians(self.survey.camera.attitude_error)
        return Unsteady(math.sin(turned), self.error.horizontal, self.error.vertical)

    def sight(self, pitch: float) -> GroundSight:
        """Return how the ground is photographed by a camera that looks so many degrees above the horizon.

        Raises
        ------
        InputError
            It would see the horizon.
        """
        survey, off = self.survey, self.off
        across, along = survey.camera.half_widths
        c, s = math.cos(math.radians(pitch)), math.sin(math.radians(-pitch))
        highest = math.degrees(math.atan(along)) + survey.camera.attitude_error
        if -pitch <= highest + 1.0:
            raise InputError(
                f"expected a camera that sees no horizon, {-math.ceil(highest + 1.0):d} degrees or less above it, "
                f"found {pitch:g}",
                field="gimbal",
            )
        c = 0.0 if pitch == -90.0 else c
        front, side = (share / 100.0 + SPARE * (share > 0) for share in survey.overlap)
        overlap = front, side
        whole = survey.fine_all_over
        # how far from the optical axis what limits the height may be, for each metre of depth
        aside = math.hypot(across, along) if whole else math.hypot((1 - overlap[1]) * across, (1 - overlap[0]) * along)
        depth = survey.distance
        if survey.gsd is not None:
            stray = off.aside * c + off.up * s + math.hypot(off.aside, off.up) * off.sine
            depth = (depth - stray) / (math.sqrt(1.0 - off.sine**2) + aside * off.sine)
        elif survey.height is not None:
            depth = depth / s  # along the optical axis, where it meets level ground
        if depth <= 0.0:
            raise InputError("expected a camera that sees farther than UAVs stray", field="gsd")
        drop = depth * (s - along * c) if whole else depth * s
        lower = min(1.0, max(self.room, NEAREST) / drop)
        depth, drop = depth * lower, drop * lower
        far, near = drop * (c + along * s) / (s - along * c), drop * (c - along * s) / (s + along * c)
        photo = GroundView(depth, across, along, c, s, True, across * (far * c + drop * s), far, -near)
        least, most = drop / (s + along * c), drop / (s - along * c)
        # two photos ahead of each other do not share what is farthest; beside each other, they share the less the
        # narrower what they show is: at the border of what is to be seen, that is the nearer half of a photo
        middle = 0.5 * (far + near) if whole else drop * c / s
        alone = (far - near) * (least + most) / (2.0 * most), across * (least + middle * c + drop * s)
        # photos must overlap as asked, and what lies between two of them be seen however they are off
        shrink = [math.sqrt(1.0 + half * half) * math.hypot(1.0, across, along) * off.sine for half in (across, along)]
        certain = [
            2.0 * (least * (half - lost) - off.aside - off.up * half)
            for half, lost in zip((along, across), reversed(shrink), strict=True)
        ]
        steps = [min(size * (1.0 - share), sure) for size, share, sure in zip(alone, overlap, certain, strict=True)]
        if min(steps) <= 0.0:
            raise InputError(
                "expected photos that show more ground than UAVs stray, and than gimbals turn", field="gsd"
            )
        limit = photo
        if survey.gsd is None or (survey.pattern == "oblique" and c > 0.0 and not whole):
            # above the ground below: the photos that look straight down show all of it finely enough
            limit = photo._replace(
                whole=False, beside=0.0, before=0.0, behind=0.0, level=0.0, down=1.0, depth=depth * s
            )
        elif not whole:
            side, ahead = 0.5 * steps[1], 0.5 * steps[0]
            limit = photo._replace(whole=False, beside=side, before=middle + ahead, behind=ahead - middle)
        free = free_area(self.scenario, self.error, self.cells, limit)
        speed = min(min(uav.max_speed for uav in self.uavs), steps[0] / survey.camera.min_interval)
        sight = GroundSight(
            self.cells, self.rough, limit, photo, (steps[0], steps[1]), overlap, free, self.world, STEEPEST
        )
        return replace(sight, steepest=min(self.steepest(speed), STEEPEST))

    def steepest(self, speed: float) -> float:
        """Return how steeply all UAVs can climb and descend at a speed over ground, metres a metre."""
        found = [math.inf]
        for uav in self.uavs:
            found += [limit / speed for limit in (uav.max_climb, uav.max_descent) if limit is not None]
            found += [math.tan(math.radians(uav.fixed_wing.climb))] if uav.fixed_wing is not None else []
        return min(found)


def ground_lines(scenario: Scenario, number: int) -> SurveyLines:
    """Return the lines of a survey of the ground, and the parts of the ground that none of them sees.

    Raises
    ------
    InputError
        If the camera would see the horizon, nothing of the area can be flown over, or too many strips are needed.
    """
    task = GroundSurvey(scenario, number)
    if task.wanted.is_empty:
        raise InputError("expected an area of more than nothing", field="area")
    seen = np.zeros(task.cells.low.shape, dtype=np.bool_)
    lines: list[PhotoLine] = []
    direction, free, passes = task.survey.direction, None, passes_of(task.survey)
    for one in passes:
        sight = task.sight(one.pitch)
        free = free or sight.free
        if task.survey.line:
            strips, gap = corridor_strips(task.survey, sight)
            gaps = np.full(len(strips), gap)
        else:
            strips, gaps, way = _swept(task, sight, one, direction)
            direction = math.degrees(math.atan2(way[0], way[1])) % 360.0 if direction is None else direction
        if len(strips) > MOST_STRIPS:
            raise InputError(f"needs {len(strips):,} strips, but {MOST_STRIPS:,} are the most", field="area")
        for strip, gap in zip(strips, gaps, strict=True):
            for line in _lines_along(_LineFlown(task, sight, one, float(gap)), strip):
                lines.append(line)
                if len(passes) <= 2 or one.pitch == -90.0:
                    _mark(task, sight, line, seen)
    assert free is not None
    return SurveyLines(tuple(lines), _unseen(task, free, seen))


def _swept(
    task: GroundSurvey, sight: GroundSight, one: Pass, direction: float | None
) -> tuple[list[Floats], Floats, Floats]:
    """Return the ends of strips, metres, how far each is from its neighbours, and where the camera looks."""
    low, high = np.array(task.wanted.bounds).reshape(2, 2)
    if np.hypot(*(high - low)) / sight.steps[1] > MOST_STRIPS:
        count = np.hypot(*(high - low)) / sight.steps[1]
        said = f"needs up to {count:,.0f} strips, but {MOST_STRIPS:,} are the most; take a smaller area"
        raise InputError(f"{said} or a coarser gsd", field="area")
    relief: Any = sight.steps[1] if sight.even else ReliefOffsets(sight)
    way = None if direction is None else unit(direction + one.turned)
    if way is not None and sight.even:
        relief = partial(even_offsets, sight.steps[1])
    if way is None and not sight.even:
        way = best_direction(sight, task.wanted)
    uav = task.uavs[0]
    cost = LegTime(min(uav.max_speed, sight.steps[0] / task.survey.camera.min_interval), uav.max_acceleration)
    wanted = task.wanted
    if way is not None and sight.middle != 0.0:
        wanted = shapely.transform(wanted, lambda p: p - sight.middle * way)
    if wanted.intersection(sight.free.polygon).area <= 0.0:
        raise InputError(f"expected an area that may be flown over, but {sight.free.why(wanted)}", field="area")
    only = None if way is None else way[None]
    # straight down, half a step beyond the first and the last photo of a strip is shown as often as elsewhere
    early = 0.5 * sight.steps[0] if sight.photo.level == 0.0 else 0.0
    plan = sweep(
        wanted, sight.free.polygon, relief, cost=cost, directions=only, reach=early, beside=not sight.limit.whole
    )
    strips, ways = np.asarray(plan.strips), plan.directions[plan.cell]
    gaps = np.full(len(strips), sight.steps[1])
    if not sight.even:
        across = np.einsum("ij,ij->i", strips[:, 0], np.column_stack([ways[:, 1], -ways[:, 0]]))
        offsets, which = np.unique(np.round(across, 3), return_inverse=True)
        if len(offsets) > 1:
            between = np.diff(offsets)
            gaps = np.minimum(np.maximum(np.r_[between[0], between], np.r_[between, between[-1]])[which], gaps)
    if way is not None:  # the camera looks along it, wherever a strip is begun
        backward = np.einsum("ij,j->i", strips[:, 1] - strips[:, 0], way) < 0.0
        strips = np.where(backward[:, None, None], strips[:, ::-1], strips)
    return list(strips), gaps, plan.directions[0] if way is None else way


@dataclass(frozen=True)
class _LineFlown:
    """What the lines along one strip need: the strip beside it is `gap` metres away."""

    task: GroundSurvey
    sight: GroundSight
    one: Pass
    gap: float


def _lines_along(flown: _LineFlown, strip: Floats) -> Iterator[PhotoLine]:
    """Yield the lines along one strip: its clear parts, at heights that suit the ground."""
    sight, way = flown.sight, LineWay.along(strip)
    pace = sight.steps[0] / (1.0 - sight.overlap[0]) / STATIONS
    count = max(math.ceil(way.length / pace), 1)
    at = (np.arange(count) + 0.5) * way.length / count
    floor, most = sight.heights(at, way.places(at), way.ahead(at), 0.5 * way.length / count)
    edges = np.flatnonzero(np.diff(np.r_[False, floor <= most, False].astype(np.int8)))
    for first, stop in edges.reshape(-1, 2):
        nodes = np.arange(first, stop + 1) * (way.length / count)
        low = gentle(nodes, _at_nodes(floor[first:stop], np.maximum), sight.steepest, -1.0)
        high = gentle(nodes, _at_nodes(most[first:stop], np.minimum), sight.steepest, 1.0)
        if np.all(low <= high):
            yield from _clear(flown, way, nodes, (low, high), CLEAR_PARTS)


def _at_nodes(limits: Floats, pick: np.ufunc) -> Floats:
    return pick(np.r_[limits[0], limits], np.r_[limits, limits[-1]])


def _clear(
    flown: _LineFlown, way: LineWay, at: Floats, limits: tuple[Floats, Floats], halvings: int
) -> Iterator[PhotoLine]:
    """Yield a line between the least and the greatest heights, or those of its parts that are clear."""
    sight, task = flown.sight, flown.task
    length = float(at[-1] - at[0])
    if length < SHORTEST:
        middle = 0.5 * (at[0] + at[-1])
        path, every = np.column_stack([way.places(np.array([middle])), [np.interp(middle, at, limits[1])]]), 0.0
    else:
        every, path = _path(flown, way, at, limits)
    if not bool(sight.world.segments_free(path[: max(len(path) - 1, 1)], path[min(len(path) - 1, 1) :]).all()):
        half = len(at) // 2
        for part in (slice(0, half + 1), slice(half, len(at))) if halvings and len(at) > 2 else ():
            yield from _clear(flown, way, at[part], (limits[0][part], limits[1][part]), halvings - 1)
        return
    fastest = max(uav.max_speed for uav in task.uavs)
    speed = min(fastest, every / task.survey.camera.min_interval) if every > 0.0 else fastest
    east, north = way.ahead(at[:1])[0]
    heading = None if flown.one.pitch == -90.0 or task.survey.line else math.degrees(math.atan2(east, north)) % 360.0
    yield PhotoLine(
        task.number, path, every, speed, flown.one.pitch, heading, heading is not None or not sight.photo.level
    )


def _path(flown: _LineFlown, way: LineWay, at: Floats, limits: tuple[Floats, Floats]) -> tuple[float, Floats]:
    """Return the metres from photo to photo, and a path (k, 3) of few points between heights."""
    sight, (floor, most) = flown.sight, limits
    places, ahead, length = way.places(at), way.ahead(at), float(at[-1] - at[0])
    cameras = np.column_stack([places, most])
    step = greatest_spacing(
        sight,
        lambda step, every: float(_shared_ahead(sight, cameras[::every], ahead[::every], at[::every], step).min()),
        sight.steps[0],
        side=False,
    )
    every = length / max(math.ceil(length / step - 1e-9), 1)
    spare = _spare(at, _shared_ahead(sight, cameras, ahead, at, every), sight.overlap[0])
    right = np.column_stack([ahead[:, 1], -ahead[:, 0]])
    for side in (-flown.gap, flown.gap):
        z = sight.heights(at, places + side * right, ahead, at[1] - at[0])[1]
        beside = np.column_stack([places + side * right, z])
        spare = np.minimum(
            spare, _spare(at, shared_shares(sight.rough, sight.photo, cameras, beside, ahead), sight.overlap[1])
        )
    lower = np.clip(spare, LEAST_TUBE, TUBE) * sight.limit.drop
    low = np.maximum(most - lower, floor)
    low = np.minimum(gentle(at, np.minimum(low, most), sight.steepest, -1.0), most)
    found = fewest_points(at, low, most, sight.steepest)
    found = found if len(found) else np.column_stack([at, most])
    inner = way.at[1:-1]
    bends = inner[(inner > found[0, 0]) & (inner < found[-1, 0])]
    along = np.unique(np.r_[found[:, 0], bends])
    photos = round(length / every)
    for more in range(MORE_PHOTOS * (not sight.even)):
        every, taken = length / (photos + more), np.linspace(at[0], at[-1], photos + more + 1)
        cameras = np.column_stack([way.places(taken), np.interp(taken, found[:, 0], found[:, 1])])
        shares = shared_shares(sight.cells, sight.photo, cameras[:-1], cameras[1:], way.ahead(taken[:-1]))
        if shares.min() >= sight.overlap[0] - SPARE:
            break
    return every, np.column_stack([way.places(along), np.interp(along, found[:, 0], found[:, 1])])


def _spare(at: Floats, shares: Floats, asked: float) -> Floats:
    """Return by which share of their height photos may be lower that overlap by more than is asked.

    It is a third of what it is over level ground, as ground beside may be nearer, and cut off. Where there is no
    neighbour, that of the next photo that has one counts.
    """
    known = np.isfinite(shares)
    if not known.any():
        return np.full(len(at), np.inf)
    spare = 1.0 - np.maximum(1.0 - shares[known], 0.0) / (1.0 - asked)
    return np.interp(at, at[known], 0.3 * np.maximum(spare, 0.0))


def _shared_ahead(sight: GroundSight, cameras: Floats, ahead: Floats, at: Floats, step: float) -> Floats:
    """Return for each camera the least share that it shows together with the next photo or the one before."""
    shares = np.full(len(at), np.inf)
    for side in (-step, step):
        there = at + side
        others = np.column_stack([cameras[:, :2] + side * ahead, np.interp(there, at, cameras[:, 2])])
        both = shared_shares(sight.rough, sight.photo, cameras, others, ahead)
        inside = (there >= at[0] - 0.5 * step) & (there <= at[-1] + 0.5 * step)
        shares = np.minimum(shares, np.where(inside, both, np.inf))
    return shares


def _mark(task: GroundSurvey, sight: GroundSight, line: PhotoLine, seen: Bools) -> None:
    """Mark the cells that the photos of a line are certain to show."""
    if len(line.path) == 1:
        photos, ahead = line.path, np.array([[0.0, 1.0]])
    else:
        way = LineWay.along(line.path[:, :2])
        at = np.linspace(0.0, way.length, round(way.length / line.every) + 1)
        photos, ahead = np.column_stack([way.places(at), np.interp(at, way.at, line.path[:, 2])]), way.ahead(at)
    mark_seen(sight.cells, sight.photo, task.off, photos, ahead, seen)


def _unseen(task: GroundSurvey, free: FreeArea, seen: Bools) -> tuple[CoverageGap, ...]:
    """Return the parts of what is wanted that are not certain to be seen."""
    cells = task.cells
    missing = np.argwhere(np.isfinite(cells.low) & ~seen)
    low, high = cells.origin + missing * cells.step, cells.origin + (missing + 1) * cells.step
    shapely.prepare(task.wanted)
    inside = shapely.contains_xy(task.wanted, 0.5 * (low + high))
    boxes = shapely.box(*low[inside].T, *high[inside].T)
    parts = shapely.get_parts(shapely.union_all(boxes).intersection(task.wanted))
    return tuple(
        CoverageGap(task.number, tuple(map(tuple, part.exterior.coords[:-1])), part.area, free.why(part))
        for part in parts
        if part.geom_type == "Polygon"
    )
