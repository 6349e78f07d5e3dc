"""The lines of a survey of the ground: strips in one direction or two, slanting ones, and those along a line."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import shapely

from skyverse._typing import Bools, Floats
from skyverse.errors import InputError
from skyverse.interrupt import raise_if_interrupted
from skyverse.model.coverage import CoverageGap
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.survey.corridor import corridor_strips
from skyverse.survey.footprints import mark_seen
from skyverse.survey.free_area import FreeArea
from skyverse.survey.ground_survey import GroundSurvey, Pass, passes_of
from skyverse.survey.leg_time import LegTime
from skyverse.survey.lines import PhotoLine, SurveyLines
from skyverse.survey.spacing import (
    MOST_STRIPS,
    STATIONS,
    GroundSight,
    LineWay,
    ReliefOffsets,
    best_direction,
    unit,
)
from skyverse.survey.strip_lines import StripFlown, lines_along
from skyverse.survey.sweep import sweep
from skyverse.survey.sweep_lines import polygons, widest_gaps

EARLY = 0.5
"""The share that photos overlap at least where strips over relief end before the area does."""


def ground_lines(scenario: Scenario, number: int) -> SurveyLines:
    """Return the lines of a survey of the ground, and the parts of the ground that none of them sees.

    Raises
    ------
    InputError
        If the camera would see the horizon, nothing of the area can be flown over, or too many strips are needed.
    """
    task = GroundSurvey(scenario, number)
    _require_above_clearance(task)
    if not task.wanted.area:
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
            raise_if_interrupted()
            for line in lines_along(StripFlown(task, sight, one, float(gap)), strip):
                lines.append(line)
                if len(passes) <= 2 or one.pitch == -90.0:  # slanting photos show far ground too coarsely to count
                    _mark(task, sight, line, seen)
    assert free is not None
    unseen = _unseen(task, free, seen)
    if unseen and task.wings and direction is not None:
        unseen = _told_by_heights(task, unit(direction), unseen)
    return SurveyLines(tuple(lines), unseen)


def _require_above_clearance(task: GroundSurvey) -> None:
    """Refuse photos that would be taken from below the clearance from the ground, whatever the relief."""
    survey, kept = task.survey, task.scenario.ground_clearance + task.error.vertical
    high = survey.distance * math.sin(math.radians(-survey.pitch))
    if 0.0 < high < kept:
        raise InputError(
            f"expected photos from {kept:.4g} m above ground or more, the clearance and the tracking error, found "
            f"{high:.4g} m",
            field="height" if survey.gsd is None else "gsd",
        )


def _swept(
    task: GroundSurvey, sight: GroundSight, one: Pass, direction: float | None
) -> tuple[list[Floats], Floats, Floats]:
    """Return the ends of strips, metres, how far each is from its neighbours, and where the camera looks."""
    low, high = np.array(task.wanted.bounds).reshape(2, 2)
    if np.hypot(*(high - low)) / sight.steps[1] > MOST_STRIPS:
        count = np.hypot(*(high - low)) / sight.steps[1]
        said = f"needs up to {count:,.0f} strips, but {MOST_STRIPS:,} are the most; take a smaller area"
        raise InputError(f"{said} or a coarser gsd", field="area")
    way = None if direction is None else unit(direction + one.turned)
    if way is None and not sight.even:
        way = best_direction(sight, task.wanted)
    apart: Any = sight.steps[1] if way is None else ReliefOffsets(sight, way)
    uav = task.uavs[0]
    cost = LegTime(min(uav.max_speed, sight.steps[0] / task.survey.camera.min_interval), uav.max_acceleration)
    wanted = task.wanted
    if way is not None and sight.middle != 0.0:
        wanted = shapely.transform(wanted, lambda p: p - sight.middle * way)
    if polygons(wanted.intersection(sight.free.polygon)).is_empty:
        raise InputError(f"expected an area that may be flown over, but {sight.free.why(wanted)}", field="area")
    only = None if way is None else way[None]
    # straight down, half a step beyond the first and the last photo of a strip is shown as often as elsewhere, unless
    # ground that is higher is nearer to a photo that has little to spare
    spare = sight.even or sight.overlap[0] >= EARLY
    early = 0.5 * sight.steps[0] if sight.photo.level == 0.0 and spare else 0.0
    plan = sweep(
        wanted,
        sight.free.polygon,
        apart,
        cost=cost,
        directions=only,
        ends="swath" if sight.limit.whole else "corners",
        reach=early,
    )
    strips, ways = np.asarray(plan.strips), plan.directions[plan.cell]
    gaps = np.full(len(strips), sight.steps[1])
    if not sight.even:
        across = np.einsum("ij,ij->i", strips[:, 0], np.column_stack([ways[:, 1], -ways[:, 0]]))
        gaps = np.minimum(widest_gaps(np.round(across, 3), sight.steps[1]), gaps)
    if way is not None:  # the camera looks along it, wherever a strip is begun
        backward = np.einsum("ij,j->i", strips[:, 1] - strips[:, 0], way) < 0.0
        strips = np.where(backward[:, None, None], strips[:, ::-1], strips)
    return list(strips), gaps, plan.directions[0] if way is None else way


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


def _told_by_heights(task: GroundSurvey, way: Floats, gaps: tuple[CoverageGap, ...]) -> tuple[CoverageGap, ...]:
    """Return gaps, told by the heights where aeroplanes cannot climb as a strip through them would have to."""
    most, told = task.scenario.max_height, list[CoverageGap]()
    sight = task.sight(-90.0)
    opened = sight if most is None else GroundSurvey(derived(task.scenario, max_height=None), task.number).sight(-90.0)
    for gap in gaps:
        x, y = shapely.Polygon(gap.outline).representative_point().coords[0]
        if not _suits(task, sight, way, (x, y)):
            high = f"the ceiling of {most:g} m above it" if _suits(task, opened, way, (x, y)) else "what the GSD allows"
            gap = replace(gap, why=f"aeroplanes climb too gently to keep between its clearance and {high}")
        told.append(gap)
    return tuple(told)


def _suits(task: GroundSurvey, sight: GroundSight, way: Floats, place: tuple[float, float]) -> bool:
    """Tell whether a strip through a place along a unit vector would have a height there."""
    x0, y0, x1, y1 = task.wanted.bounds
    pace = sight.steps[0] / (1.0 - sight.overlap[0]) / STATIONS
    reach = math.ceil(math.hypot(x1 - x0, y1 - y0) / pace)
    at = pace * np.arange(-reach, reach + 1)
    places = place + at[:, None] * way
    kept = shapely.contains_xy(task.wanted, places) | (at == 0.0)
    ahead = np.tile(way, (int(kept.sum()), 1))
    floor, most = sight.heights(at[kept], places[kept], ahead, 0.5 * pace)
    return bool((floor <= most)[at[kept] == 0.0][0])
