"""Strips along a line, parallel to it with mitred bends, parted where it bends sharply, for aeroplanes at each bend."""

import math
from itertools import pairwise

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.survey import Survey
from skyverse.survey.footprints import shared_shares
from skyverse.survey.spacing import LEAST_SHARE, MOST_STRIPS, SHORTEST, STATIONS, GroundSight, LineWay

SHARP = 30.0
"""Degrees: where a line bends by more, strips end, beyond the bend by half of what is to be seen across."""
STRAIGHTENED = 0.1
"""The share of half the width by which the straight strips of aeroplanes may leave a line, and are wider instead."""


def corridor_strips(survey: Survey, sight: GroundSight) -> tuple[list[Floats], float]:
    """Return strips (k, 2) along the line of a survey where they are free, and the metres between them.

    Raises
    ------
    InputError
        Nothing along the line may be flown over, or too many strips are needed.
    """
    line, half, sharp = np.array(survey.line), 0.5 * (survey.width or 0.0) + survey.margin, SHARP
    if sight.link > 0.0:  # an aeroplane cannot bend at a place
        aside, sharp = STRAIGHTENED * half, 0.0
        line, half = shapely.get_coordinates(shapely.LineString(line).simplify(aside)), half + aside
    count = max(math.ceil(2.0 * half / sight.steps[1] - 1e-9), 1)
    if count > MOST_STRIPS:
        raise InputError(f"needs {count:,} strips, but {MOST_STRIPS:,} are the most; take a coarser gsd", field="width")
    runs = list(_runs(line, half, survey.margin, sharp))
    if sight.link > 0.0:  # whole steps, so that photos are not too near to each other for an aeroplane's speed
        for run in runs:
            length = LineWay.along(run).length
            run += np.outer((-0.5, 0.5), (run[-1] - run[0]) * (-length % sight.steps[0] / length))
    most = math.ceil(count / LEAST_SHARE)
    while count > 1 and count < most and not all(_overlap(sight, run, 2.0 * half / count, count) for run in runs):
        count = math.ceil(1.03 * count)
    gap, middle = 2.0 * half / count, sight.middle
    found = []
    for run in runs:
        begun = run.copy()
        if sight.photo.level > 0.0:  # the camera looks ahead, so that strips begin and end early
            first, last = LineWay.along(run[:2]).ahead(np.zeros(1))[0], LineWay.along(run[-2:]).ahead(np.zeros(1))[0]
            begun[0], begun[-1] = run[0] - middle * first, run[-1] - middle * last
        for number in range(count):
            line = shapely.offset_curve(shapely.LineString(begun), half - (number + 0.5) * gap, join_style="mitre")
            parts = shapely.get_parts(shapely.intersection(line, sight.free.polygon))
            found += [shapely.get_coordinates(part) for part in parts if part.length > SHORTEST]
    if not found:
        line = shapely.LineString(survey.line)
        raise InputError(f"expected a line that may be flown along, but {sight.free.why(line)}", field="line")
    return found, gap


def _runs(line: Floats, half: float, margin: float, sharp: float) -> list[Floats]:
    """Return the parts of a line between sharp bends, longer at their ends so that all about a bend is seen."""
    legs = np.diff(line, axis=0)
    course = np.degrees([math.atan2(x, y) for x, y in legs])
    turns = np.abs((np.diff(course) + 180.0) % 360.0 - 180.0)
    ends = [0, *(int(k) + 1 for k in np.flatnonzero(turns > sharp)), len(line) - 1]
    found = []
    for first, last in pairwise(ends):
        run = line[first : last + 1].copy()
        ahead = legs[[first, last - 1]] / np.hypot(*legs[[first, last - 1]].T)[:, None]
        run[0] -= (half if first > 0 else margin) * ahead[0]
        run[-1] += (half if last < len(line) - 1 else margin) * ahead[1]
        found.append(run)
    return found


def _overlap(sight: GroundSight, run: Floats, gap: float, count: int) -> bool:
    """Tell whether photos of neighbouring strips along a run overlap as asked."""
    way = LineWay.along(run)
    at = np.linspace(
        0.0, way.length, max(int(way.length * (1.0 - sight.overlap[0]) / sight.steps[0] * STATIONS), 1) + 1
    )
    ahead = way.ahead(at)
    right = np.column_stack([ahead[:, 1], -ahead[:, 0]])
    rows = [way.places(at) + ((k + 0.5) * gap - 0.5 * gap * count) * right for k in range(count)]
    cameras = [np.column_stack([row, sight.heights(at, row, ahead, at[1])[1]]) for row in rows]
    return all(
        float(shared_shares(sight.rough, sight.photo, one, other, ahead).min()) >= sight.overlap[1]
        for one, other in pairwise(cameras)
    )
