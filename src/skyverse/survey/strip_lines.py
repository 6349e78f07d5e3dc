"""The lines along one strip: its clear parts, with few bends at heights that suit the ground."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Bools, Floats
from skyverse.survey.footprints import shared_shares
from skyverse.survey.ground_survey import SPARE, GroundSurvey, Pass
from skyverse.survey.heights import fewest_points, gentle, linked
from skyverse.survey.lines import PhotoLine
from skyverse.survey.spacing import (
    SHORTEST,
    STATIONS,
    GroundSight,
    LineWay,
    greatest_spacing,
)

TUBE = 0.15
"""The share of the height above ground by which a line may be lower than it might be, to have fewer bends."""
LEAST_TUBE = 0.001
"""By so much of it a line may be lower in any case: overlaps suffer less than it matters."""
MORE_PHOTOS = 4
"""Numbers of photos on a line that are tried till they overlap as asked on the ground in small cells."""
CLEAR_PARTS = 7
"""How often a line that is not clear is halved to find its clear parts."""


@dataclass(frozen=True)
class StripFlown:
    """What the lines along one strip need: the strip beside it is `gap` metres away."""

    task: GroundSurvey
    sight: GroundSight
    one: Pass
    gap: float


def lines_along(flown: StripFlown, strip: Floats) -> Iterator[PhotoLine]:
    """Yield the lines along one strip: its clear parts, at heights that suit the ground."""
    sight, way = flown.sight, LineWay.along(strip)
    pace = sight.steps[0] / (1.0 - sight.overlap[0]) / STATIONS
    count = max(math.ceil(way.length / pace), 1)
    at = (np.arange(count) + 0.5) * way.length / count
    floor, most = sight.heights(at, way.places(at), way.ahead(at), 0.5 * way.length / count)
    todo = _runs(floor <= most)
    while todo:
        first, stop = todo.pop(0)
        # between stations the narrower of both limits counts, so that what was not too steep may be
        nodes = np.arange(first, stop + 1, dtype=np.float64) * (way.length / count)
        low = gentle(nodes, _at_nodes(floor[first:stop], np.maximum), sight.steepest, -1.0)
        high = gentle(nodes, _at_nodes(most[first:stop], np.minimum), sight.steepest, 1.0)
        flat = (low <= high)[1:] & (low <= high)[:-1]  # elsewhere it is too steep from one limit to the other
        if flat.all():
            yield from _clear(flown, way, nodes, (low, high), CLEAR_PARTS)
        else:
            todo = [(first + begin, first + end) for begin, end in _runs(flat)] + todo


def _runs(some: Bools) -> list[tuple[int, int]]:
    """Return the first index of each run of true values, and the one after its last."""
    edges = np.flatnonzero(np.diff(np.r_[False, some, False].astype(np.int8)))
    return [(int(first), int(stop)) for first, stop in edges.reshape(-1, 2)]


def _at_nodes(limits: Floats, pick: np.ufunc) -> Floats:
    return pick(np.r_[limits[0], limits], np.r_[limits, limits[-1]])


def _clear(
    flown: StripFlown, way: LineWay, at: Floats, limits: tuple[Floats, Floats], halvings: int
) -> Iterator[PhotoLine]:
    """Yield a line between the least and the greatest heights, or those of its parts that are clear."""
    sight, task = flown.sight, flown.task
    length = float(at[-1] - at[0])
    if length < SHORTEST:
        middle = 0.5 * (at[0] + at[-1])
        path, every = np.column_stack([way.places(np.array([middle])), [np.interp(middle, at, limits[1])]]), 0.0
    else:
        every, path = _path(flown, way, at, limits)
    begins, ends = path[: max(len(path) - 1, 1)], path[min(len(path) - 1, 1) :]
    swerves = [np.array([0.0, 0.0, off]) for off in {-sight.off, sight.off}]
    if not all(sight.world.segments_free(begins + off, ends + off).all() for off in swerves):
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


def _path(flown: StripFlown, way: LineWay, at: Floats, limits: tuple[Floats, Floats]) -> tuple[float, Floats]:
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
    found = linked(found, at, most, sight.steepest, sight.link)
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
