"""Judges photos that were taken: what they show of surveys, whoever flew them and in whatever order of strips.

Their strips are found anew: photos that follow each other in one direction, with cameras that look as the survey's.
"""

import math
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from skyverse._typing import Bools, Floats
from skyverse.errors import InputError, require_kind
from skyverse.model.asked_ground import asked_ground
from skyverse.model.coverage import Coverage, CoverageGap
from skyverse.model.pad import ground_height
from skyverse.model.photos import Photos
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import told_metres
from skyverse.model.survey import Survey
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Verdict
from skyverse.referee.coverage import judge_coverage, neighbours
from skyverse.referee.ground_cells import CellGrid, grid_of
from skyverse.referee.photo_overlaps import MOST_NODES, PARALLEL, SHORT
from skyverse.referee.photo_views import PhotoView, views_of
from skyverse.referee.tolerances import LET_PASS, LIMIT_LET_PASS, MORE_THAN_HALF, NO_LENGTH
from skyverse.referee.tracking_error import EXACT

ASTRAY = 15.0
"""Degrees by which the camera may look otherwise than planned in a photo of a strip."""
LONG_STEP = 1.5
"""How far apart photos are, as a multiple of the usual, between which others may have been taken later."""
FROM_STRIP = 0.27
"""Of the way between strips with one missing, the share by which a gap is away from each; more than half, otherwise."""
BELOW = "taken below the ground"
COARSE = "showing nothing of it as finely as asked"
ELSEWHERE = "showing nothing of it"
SHARES_LESS = "photos about it share less than asked"


def check_photos(scenario: Scenario, photos: Photos, *, position_error: float = 0.0) -> tuple[Coverage, ...]:
    """Judge what photos that were taken show of each survey of a scenario.

    They are judged as those of missions are, by the ground that each shows over the terrain, wherever within the error
    of its position the camera was and however it was turned within its attitude error. A photo that shows less than
    planned harms no other: the ground sample distance is that of the best photo of each place. One that shows nothing
    of a survey as finely as asked, or was taken below the ground, is left out before neighbours are sought, and named.
    Gaps are also where neighbouring photos share less than asked.

    Parameters
    ----------
    scenario
        What was to be seen, and over which terrain.
    photos
        In the order in which each UAV took them; strips are found by that. Those of one place, direction and time are
        one photo.
    position_error
        Metres by which their positions may be off, in any direction: 0 for those of RTK, some metres without it.

    Raises
    ------
    InputError
        If the scenario has no surveys, there are no photos, one of their numbers is not finite, or most are below the
        ground.
    """
    require_kind(scenario, Scenario, "scenario")
    require_kind(photos, Photos, "photos")
    if not scenario.surveys:
        raise InputError("expected a scenario with surveys, found none", field="scenario")
    if not len(photos):
        raise InputError("expected photos, found none")
    if not 0 <= position_error < math.inf:
        raise InputError(f"expected metres from 0 on, found {position_error!r}", field="position_error")
    for name in ("position", "heading", "pitch", "roll"):
        if not np.isfinite(getattr(photos, name)).all():
            raise InputError("expected finite numbers of each photo, found others", field=f"photos.{name}")
    numbered = np.char.add("photo ", np.arange(1, len(photos) + 1).astype(np.str_))
    photos = _each_once(replace(photos, name=np.where(photos.name == "", numbered, photos.name)))
    below = ground_height(scenario, photos.position[:, :2]) - photos.position[:, 2]
    if np.median(below) > position_error:
        deep = f"{(below > 0).sum()} of {len(photos)} up to {told_metres(float(below.max()))} below it"
        raise InputError(
            f"expected photos from above the ground, found {deep}: are altitudes counted from the start, not the sea?"
        )
    errors = [TrackingError(horizontal=position_error, vertical=position_error)]
    surveys = tuple(one.model_copy(update={"gsd_of": "place"}) for one in scenario.surveys)
    judged = scenario.model_copy(update={"surveys": surveys})
    found = []
    for number, survey in enumerate(surveys):
        why = _left_out(judged, survey, photos, below > position_error)
        own = in_strips(photos.taken(why == ""), survey)
        coverage = judge_coverage(judged, number, own, errors)
        names = {str(one): tuple(photos.name[why == one].tolist()) for one in np.unique(why[why != ""])}
        found.append(
            replace(_with_short(judged, number, own, coverage) if coverage.short else coverage, left_out=names)
        )
    return tuple(found)


def _left_out(scenario: Scenario, survey: Survey, photos: Photos, below: Bools) -> NDArray[np.str_]:
    """Return why each photo does not count, (n,); empty for those that do."""
    depth, most = np.zeros(len(photos)), math.inf
    if survey.of_ground:
        grid = grid_of(scenario, survey, asked_ground(survey))
        views = views_of(photos, survey.camera, [EXACT] * len(photos), 0.0)
        depth = np.array([_nearest(view, grid) for view in views])
    if survey.gsd is not None:
        most = survey.gsd / survey.camera.pixel * (1 + LIMIT_LET_PASS)
    return np.select([below, np.isinf(depth), depth > most], [BELOW, ELSEWHERE, COARSE], "")


def _nearest(view: PhotoView, grid: CellGrid) -> float:
    """Return about how deep the nearest ground is that a photo shows, metres; infinite where it shows none."""
    here = grid.within(view)
    if here is None:
        return math.inf
    x, y, z = grid.nodes(here)
    i, j = (slice(None, None, max(len(line) // MOST_NODES, 1)) for line in (x, y))
    margin, depth = view.look(x[i, None], y[j], z[i, j])
    return float(depth[margin >= -max(i.step, j.step) * grid.reach[here].max()].min(initial=math.inf))


def _each_once(photos: Photos) -> Photos:
    """Return photos without those that equal one before them in place, direction and, if it is known, time."""
    time = np.nan_to_num(photos.time, nan=-1.0)
    poses = np.column_stack([photos.position, photos.heading, photos.pitch, photos.roll, time])
    return photos.taken(np.sort(np.unique(poses, axis=0, return_index=True)[1]))


def in_strips(photos: Photos, survey: Survey) -> Photos:
    """Return photos with the numbers of their strips; last are those whose camera looks otherwise than in strips."""
    pitches = np.array([-90.0, survey.pitch] if survey.pattern == "oblique" else [survey.pitch])
    upright = np.abs(photos.pitch[:, None] - pitches).min(axis=1) <= ASTRAY
    order = np.concatenate([np.flatnonzero(upright), np.flatnonzero(~upright)])
    count, none = int(upright.sum()), np.full(len(photos), -1)
    photos = replace(photos.taken(order), uav=none, strip=none)
    if count < 2:
        return photos
    level = photos.position[:count, :2]
    steps = np.diff(level, axis=0)
    length = np.hypot(*steps.T)
    ahead = steps / np.maximum(length, NO_LENGTH)[:, None]
    alike = (ahead[1:] * ahead[:-1]).sum(axis=1) > PARALLEL
    look = photos.frames[:count, 0]
    on = (np.r_[alike, False] | np.r_[False, alike]) & ((look[1:] * look[:-1]).sum(axis=1) > PARALLEL)
    if on.any():
        usual = float(np.median(length[on]))
        for k in np.flatnonzero(on & (length > LONG_STEP * usual)).tolist():
            on[k] = not _between(level, k, ahead[k], length[k], _half_step(survey, 1)).any()
    strip = np.full(len(photos), -1)
    strip[:count] = np.cumsum(np.r_[0, ~on])
    return replace(photos, strip=strip)


def _between(level: Floats, k: int, ahead: Floats, length: float, aside: float) -> Bools:
    """Return which photos were taken between one and the next, on the same strip or near it."""
    way = level - level[k]
    along, off = way[:, 0] * ahead[0] + way[:, 1] * ahead[1], way[:, 1] * ahead[0] - way[:, 0] * ahead[1]
    share = along / length
    inner: Bools = (share > LET_PASS) & (share < 1 - LET_PASS) & (np.abs(off) < aside)
    return inner


def _half_step(survey: Survey, axis: int) -> float:
    """Return half of the way from photo to photo on a strip, or from strip to strip, on level ground, metres."""
    return float(survey.camera.half_widths[1 - axis]) * survey.distance * (1 - survey.overlap[axis] / 100)


def _with_short(scenario: Scenario, number: int, photos: Photos, coverage: Coverage) -> Coverage:
    """Return a coverage whose gaps are also the places between neighbours that share less than asked."""
    survey = scenario.surveys[number]
    asked = asked_ground(survey)
    grid = grid_of(scenario, survey, asked)
    step, spacing = (_half_step(survey, axis) for axis in (0, 1))
    along, between = (
        found.centre[found.share < share - SHORT]
        for found, share in zip(neighbours(scenario, survey, photos, grid), survey.overlap, strict=True)
    )
    way = between[:, 1] - between[:, 0]
    most = np.maximum(np.round(np.hypot(*way.T) / (2 * spacing)), 2)  # how many strips wide it is
    held = np.where(most > 2, 0.5 / most + MORE_THAN_HALF, FROM_STRIP)[:, None]
    between = np.stack([between[:, 0] + held * way, between[:, 1] - held * way], axis=1)
    groups = [shapely.buffer(shapely.linestrings(between[most == n]), step, cap_style="flat") for n in np.unique(most)]
    groups.append(shapely.buffer(shapely.linestrings(along), (1 - 2 * FROM_STRIP) * 2 * spacing, cap_style="flat"))
    parts, done = list[shapely.Geometry](), shapely.union_all([])
    for group in groups:  # one after the other, so that parts are as broad as a number of strips
        one = shapely.union_all(group)
        parts.extend(shapely.get_parts(shapely.intersection(shapely.difference(one, done), asked)))
        done = shapely.union(done, one)
    gaps = [
        CoverageGap(
            number, tuple(map(tuple, shapely.get_coordinates(part.exterior)[:-1].tolist())), part.area, SHARES_LESS
        )
        for part in parts
        if isinstance(part, shapely.Polygon) and part.area > LET_PASS
    ]
    every = sorted((*coverage.gaps, *gaps), key=lambda gap: -gap.area)
    return replace(coverage, verdict=Verdict.REFUTED, gaps=tuple(every))
