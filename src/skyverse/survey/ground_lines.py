"""The lines of a survey of the ground: strips in one direction or two, slanting ones, and those along a line."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.coverage import CoverageGap
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.model.uav import UAV, TrackingError
from skyverse.space.world import World
from skyverse.survey.footprints import GroundView, Unsteady, mark_seen, shared_depths
from skyverse.survey.free_area import FreeArea, free_area
from skyverse.survey.ground import GroundCells, ground_cells, wanted_ground
from skyverse.survey.heights import fewest_points, gentle
from skyverse.survey.lines import PhotoLine, SurveyLines
from skyverse.survey.spacing import LEAST_SHARE, STATIONS, GroundSight, ReliefOffsets
from skyverse.survey.sweep import LegTime, sweep

CELLS_ALONG = 60
"""Cells of the ground along the shorter side of a photo."""
STEEPEST = 1.0
"""Metres of height a metre: lines are nowhere steeper, whatever the UAVs can do."""
SHORTEST = 1.0
"""Metres: along a shorter line one photo is taken, in its middle."""
TUBE = 0.15
"""The share of the height above ground by which a line may be lower than it might be, to have fewer bends."""
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
        reach = 2.0 * self.survey.distance
        side = 2.0 * min(self.survey.camera.half_widths) * self.survey.distance
        return ground_cells(self.scenario, self.wanted, side / CELLS_ALONG, reach)

    @cached_property
    def world(self) -> World:
        """What must be kept clear of."""
        return World(self.scenario, self.error)

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
        overlap = survey.overlap[0] / 100.0, survey.overlap[1] / 100.0
        whole = survey.gsd is not None and survey.gsd_of == "photo"
        # how far from the optical axis what limits the height may be, for each metre of depth
        aside = math.hypot(across, along) if whole else math.hypot((1 - overlap[1]) * across, (1 - overlap[0]) * along)
        depth = survey.distance
        if survey.gsd is not None:
            stray = off.aside * c + off.up * s + math.hypot(off.aside, off.up) * off.sine
            depth = (depth - stray) / (math.sqrt(1.0 - off.sine**2) + aside * off.sine)
        elif survey.height is not None:
            depth = depth * s  # along the optical axis, where it meets level ground
        if depth <= 0.0:
            raise InputError("expected a camera that sees farther than UAVs stray", field="gsd")
        drop = depth * (s - along * c) if whole else depth * s
        far, near = drop * (c + along * s) / (s - along * c), drop * (c - along * s) / (s + along * c)
        photo = GroundView(depth, across, along, c, s, True, across * (far * c + drop * s), far, -near)
        # photos must overlap as asked, and what lies between two of them be seen however they are off
        least = drop / (s + along * c)
        shrink = [math.sqrt(1.0 + half * half) * math.hypot(1.0, across, along) * off.sine for half in (across, along)]
        certain = [
            2.0 * (least * (half - lost) - off.aside - off.up * half)
            for half, lost in zip((along, across), reversed(shrink), strict=True)
        ]
        steps = [
            min(2.0 * half * least * (1.0 - share), sure)
            for half, share, sure in zip((along, across), overlap, certain, strict=True)
        ]
        if min(steps) <= 0.0:
            raise InputError(
                "expected photos that show more ground than UAVs stray, and than gimbals turn", field="gsd"
            )
        limit = photo
        if not whole:
            middle = drop * c / s
            side, ahead = (0.5 * steps[1], 0.5 * steps[0]) if survey.gsd is not None else (0.0, 0.0)
            limit = photo._replace(whole=False, beside=side, before=middle + ahead, behind=ahead - middle)
            if survey.gsd is None:
                limit = limit._replace(before=0.0, behind=0.0, level=0.0, down=1.0, depth=depth / s)
        free = free_area(self.scenario, self.error, self.cells, limit)
        speed = min(min(uav.max_speed for uav in self.uavs), steps[0] / survey.camera.min_interval)
        sight = GroundSight(self.cells, limit, photo, (steps[0], steps[1]), overlap, free, self.world, STEEPEST)
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
        If the camera would see the horizon, or nothing of the area can be flown over.
    """
    task = GroundSurvey(scenario, number)
    if task.wanted.is_empty:
        raise InputError("expected an area of more than nothing", field="area")
    seen = np.zeros(task.cells.low.shape, dtype=np.bool_)
    lines: list[PhotoLine] = []
    direction = task.survey.direction
    for one in passes_of(task.survey):
        sight = task.sight(one.pitch)
        plan = _swept(task, sight, one, direction)
        if direction is None:
            direction = math.degrees(math.atan2(plan[1][0], plan[1][1])) % 360.0
        flown = [line for strip in plan[0] for line in _lines_along(task, sight, one, strip)]
        if one.pitch == -90.0 or len(passes_of(task.survey)) == 1:
            for line in flown:
                _mark(task, sight, line, seen)
        lines += flown
    free = task.sight(passes_of(task.survey)[0].pitch).free
    return SurveyLines(tuple(lines), _unseen(task, free, seen))


def _swept(task: GroundSurvey, sight: GroundSight, one: Pass, direction: float | None) -> tuple[list[Floats], Floats]:
    """Return strips as (2, 2) ends of each, metres, and the unit vector along which the camera looks."""
    way = None if direction is None else _unit(direction + one.turned)
    uav = task.uavs[0]
    speed = min(uav.max_speed, sight.steps[0] / task.survey.camera.min_interval)
    relief: Any = sight.steps[1] if task.scenario.terrain is None else ReliefOffsets(sight)
    cost = LegTime(speed, uav.max_acceleration)
    ahead = sight.photo.before - 0.5 * (sight.photo.before + sight.photo.behind)
    wanted = task.wanted
    if way is not None and sight.photo.level > 0.0:
        wanted = shapely.transform(wanted, lambda p: p - ahead * way)
    flown = wanted.intersection(sight.free.polygon)
    if flown.area <= 0.0:
        raise InputError(f"expected an area that may be flown over, but {sight.free.why(wanted)}", field="area")
    plan = sweep(wanted, sight.free.polygon, relief, cost=cost, directions=None if way is None else way[None])
    return [np.asarray(strip) for strip in plan.strips], plan.directions[0] if way is None else way


def _unit(direction: float) -> Floats:
    angle = math.radians(direction)
    return np.array([math.sin(angle), math.cos(angle)])


def _lines_along(task: GroundSurvey, sight: GroundSight, one: Pass, strip: Floats) -> Iterator[PhotoLine]:
    """Yield the lines along one strip: its clear parts, at heights that suit the ground."""
    length = float(np.hypot(*(strip[-1] - strip[0])))
    way = (strip[-1] - strip[0]) / length if length > 0.0 else np.array([0.0, 1.0])
    pace = 2.0 * sight.steps[0] / (1.0 - sight.overlap[0]) / STATIONS / 2.0
    count = max(math.ceil(length / pace), 1)
    at = (np.arange(count) + 0.5) * length / count
    places = strip[0] + at[:, None] * way
    ahead = np.tile(way, (count, 1))
    floor, most = sight.heights(at, places, ahead, 0.5 * length / count)
    usable = floor <= most
    edges = np.flatnonzero(np.diff(np.r_[False, usable, False].astype(np.int8)))
    for first, stop in edges.reshape(-1, 2):
        nodes = np.arange(first, stop + 1) * (length / count)
        low = gentle(nodes, _at_nodes(floor[first:stop], np.maximum), sight.steepest, -1.0)
        high = gentle(nodes, _at_nodes(most[first:stop], np.minimum), sight.steepest, 1.0)
        if np.all(low <= high):
            yield from _clear(task, sight, one, (strip[0], way), nodes, (low, high))


def _at_nodes(limits: Floats, pick: np.ufunc) -> Floats:
    return pick(np.r_[limits[0], limits], np.r_[limits, limits[-1]])


def _clear(
    task: GroundSurvey,
    sight: GroundSight,
    one: Pass,
    frame: tuple[Floats, Floats],
    at: Floats,
    limits: tuple[Floats, Floats],
) -> Iterator[PhotoLine]:
    """Yield a line between heights, or the clear parts of one."""
    survey, (begin, way), (floor, most) = task.survey, frame, limits
    ahead = np.tile(way, (len(at), 1))
    cameras = np.column_stack([begin + at[:, None] * way, most])
    step = sight.steps[0]
    for _ in range(8):
        depth = _shared_ahead(sight, cameras, ahead, at, step)
        held = max(min(step, float(depth.min()) / sight.needed(1.0, False)), LEAST_SHARE * sight.steps[0])
        if held >= 0.999 * step:
            break
        step = held
    length = float(at[-1] - at[0])
    if length < SHORTEST:
        middle = np.array([[*(begin + (at[0] + 0.5 * length) * way), float(np.interp(at[0] + 0.5 * length, at, most))]])
        points, every = middle, 0.0
    else:
        every = length / max(math.ceil(length / step - 1e-9), 1)
        depth = _shared_ahead(sight, cameras, ahead, at, every)
        spare = np.maximum(depth - sight.needed(every, False), 0.0)
        for side in (-1.0, 1.0):
            aside = cameras + np.r_[side * sight.steps[1] * np.array([way[1], -way[0]]), 0.0]
            both = shared_depths(sight.cells, sight.photo, cameras, aside, ahead)
            spare = np.minimum(spare, np.maximum(both - sight.needed(sight.steps[1], True), 0.0))
        rate = max(sight.photo.down, 1.0 / (sight.photo.down + sight.photo.along * sight.photo.level))
        low = np.maximum(most - np.minimum(spare / rate, TUBE * sight.limit.drop), floor)
        low = np.minimum(gentle(at, np.minimum(low, most), sight.steepest, -1.0), most)
        found = fewest_points(at, low, most, sight.steepest)
        if not len(found):
            found = np.column_stack([at, most])
        points = np.column_stack([begin + found[:, :1] * way, found[:, 1]])
    speed = min(max(uav.max_speed for uav in task.uavs), every / survey.camera.min_interval if every else math.inf)
    heading = None if one.pitch == -90.0 else math.degrees(math.atan2(way[0], way[1])) % 360.0
    line = PhotoLine(task.number, points, every, speed, one.pitch, heading)
    if bool(
        sight.world.segments_free(
            points[:-1] if len(points) > 1 else points, points[1:] if len(points) > 1 else points
        ).all()
    ):
        yield line


def _shared_ahead(sight: GroundSight, cameras: Floats, ahead: Floats, at: Floats, step: float) -> Floats:
    """Return for each camera the depth of what it and the next photo show, or the one before where there is no next."""
    depths = np.full(len(at), np.inf)
    for side in (-1.0, 1.0):
        there = at + side * step
        z = np.interp(there, at, cameras[:, 2])
        others = np.column_stack([cameras[:, :2] + side * step * ahead, z])
        both = shared_depths(sight.cells, sight.photo, cameras, others, ahead)
        inside = (there >= at[0] - 0.5 * step) & (there <= at[-1] + 0.5 * step)
        depths = np.minimum(depths, np.where(inside, both, np.inf))
    return depths


def _mark(task: GroundSurvey, sight: GroundSight, line: PhotoLine, seen: Any) -> None:
    """Mark the cells that the photos of a line are certain to show."""
    steps = np.diff(line.path, axis=0)
    way = np.r_[0.0, np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))]
    count = round(way[-1] / line.every) if line.every > 0 else 0
    along = np.linspace(0.0, way[-1], count + 1)
    photos = np.column_stack([np.interp(along, way, line.path[:, k]) for k in range(3)])
    way_ahead = np.array([0.0, 1.0]) if len(steps) == 0 else (line.path[-1] - line.path[0])[:2] / max(way[-1], 1e-9)
    mark_seen(sight.cells, sight.photo, task.off, photos, np.tile(way_ahead, (len(photos), 1)), seen)


def _unseen(task: GroundSurvey, free: FreeArea, seen: Any) -> tuple[CoverageGap, ...]:
    """Return the parts of what is wanted that are not certain to be seen."""
    cells = task.cells
    missing = np.argwhere(np.isfinite(cells.low) & ~seen)
    corners = cells.origin + missing * cells.step
    if not len(missing):
        return ()
    middles = shapely.points(corners + 0.5 * cells.step)
    shapely.prepare(task.wanted)
    corners = corners[shapely.contains(task.wanted, middles)]
    boxes = shapely.box(corners[:, 0], corners[:, 1], *(corners + cells.step).T)
    parts = shapely.get_parts(shapely.union_all(boxes).intersection(task.wanted))
    return tuple(
        CoverageGap(
            task.number,
            tuple(map(tuple, shapely.get_coordinates(part.exterior)[:-1].tolist())),
            part.area,
            free.why(part),
        )
        for part in parts
        if part.geom_type == "Polygon"
    )
