"""Overlaps: what neighbouring photos share, one after the other on a strip, and from strip to strip.

They are judged by the nominal poses: the area, on a map, of the ground to be seen that both photos show, as a share of
what that one of them shows which shows less, as if nothing stood on it. Over level ground this is what is left of a
picture's width or height when the way from camera to camera is taken off. Photos of strips beside each other are seldom
taken abreast, so the other one is taken to be where its UAV flies abreast of the first. Pairs count whose middle is
ground to be seen.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from skyverse._typing import Bools, Floats, Indices, Ints
from skyverse.interrupt import raise_if_interrupted
from skyverse.model.camera import Camera
from skyverse.model.photos import Photos
from skyverse.referee.ground_cells import CellGrid
from skyverse.referee.photo_views import PhotoView, views_of
from skyverse.referee.tolerances import APART, NEARER_AHEAD, NO_LENGTH, STEEP_VIEW
from skyverse.referee.tracking_error import EXACT

PARALLEL = 0.966
"""The cosine of 15 degrees, by which strips, and the directions of cameras, may differ that are neighbours."""
FACING = 0.75
"""How far ahead a neighbour on another strip may be, as a share of the way to the next photo on its own."""
MOST_NODES = 80
"""Cells along x and along y at whose middles the ground is looked at that two photos show, about."""
SHORT = 0.3
"""Per cent by which an overlap may be less than asked: it depends on how finely the ground is looked at."""
PAIRS_AT_ONCE = 2**20
"""Photos compared at once, at most, which bounds the memory."""


class Neighbours(NamedTuple):
    """Pairs (n, 2) of photos, what each share (n,), per cent, and where both look, (n, 2, 2) metres, about."""

    pairs: Indices
    share: Floats
    centre: Floats


def neighbours_of(
    photos: Photos,
    camera: Camera,
    grid: CellGrid,
    closed: shapely.Geometry | None = None,
    *,
    one_direction: bool = True,
) -> tuple[Neighbours, Neighbours]:
    """Return the neighbours along strips and between strips whose middle is ground to be seen, in whole cells.

    Strips that are farther apart than a picture is wide are neighbours as well, which share nothing; where each part of
    the area is flown in one direction, only if no other photo was taken about the middle between them. Photos with
    closed air between them, in which no strip can be, are no neighbours.
    """
    if len(photos) < 2:
        none = Neighbours(np.zeros((0, 2), dtype=np.intp), np.zeros(0), np.zeros((0, 2, 2)))
        return none, none
    same, course, spacing = _courses(photos)
    first, level = np.flatnonzero(same), photos.position[:, :2]
    frames, views = photos.frames, views_of(photos, camera, [EXACT] * len(photos), 0.0)
    centre, deep = _centres(photos.position, frames[:, 0], grid)
    width = _width(np.column_stack([-course[:, 1], course[:, 0]]), frames, camera) * deep
    beside = _neighbours(level, course, spacing, frames[:, 0], width)
    if one_direction:
        beside = _with_none_between(beside, centre, width)
    found: list[Neighbours] = []
    for pairs in (np.column_stack([first, first + 1]), beside):
        if closed is not None and not shapely.is_empty(closed):
            ways = shapely.linestrings(np.stack([level[pairs[:, 0]], level[pairs[:, 1]]], axis=1))
            shapely.prepare(closed)
            pairs = pairs[~shapely.intersects(closed, ways)]
        pairs = pairs[_in_area((centre[pairs[:, 0]] + centre[pairs[:, 1]]) / 2, grid)]
        others = photos.position[pairs[:, 1]] if not found else _abreast(pairs, photos.position, course, same)
        shares = [
            _shared(views[i], replace(views[j], position=place), grid)
            for (i, j), place in zip(pairs.tolist(), others, strict=True)
        ]
        share = np.array(shares).reshape(len(pairs))
        some = np.isfinite(share)
        found.append(Neighbours(pairs[some], share[some], centre[pairs[some]]))
    return found[0], found[1]


def _with_none_between(pairs: Indices, centre: Floats, width: Floats) -> Indices:
    """Return the pairs (n, 2) that are no farther apart than a picture is wide, or have no photo about their middle."""
    a, b = centre[pairs[:, 0]], centre[pairs[:, 1]]
    middle, wide = (a + b) / 2, np.minimum(width[pairs[:, 0]], width[pairs[:, 1]])
    kept = np.hypot(*(b - a).T) < wide
    for k in np.flatnonzero(~kept).tolist():
        kept[k] = not (np.hypot(*(centre - middle[k]).T) < wide[k] / 2).any()
    return pairs[kept]


def directions_of(photos: Photos, oblique: bool) -> Ints:
    """Return in which direction each photo looks, or along which line its strip leads, (n,) numbers; -1 where in none.

    Photos that look straight down look in one direction.
    """
    number = np.full(len(photos), -1)
    if oblique:
        turned, slanting = np.radians(photos.heading), np.abs(np.cos(np.radians(photos.pitch))) > STEEP_VIEW
        ways = np.where(slanting[:, None], np.column_stack([np.sin(turned), np.cos(turned)]), 0.0)
        number[~slanting] = 0
    else:
        ways = _courses(photos)[1]
    left = np.hypot(*ways.T) > 0.0
    while left.any():
        way = ways[np.argmax(left)]
        alike = (ways * way).sum(axis=1)
        here = left & ((alike if oblique else np.abs(alike)) > PARALLEL)
        number[here] = number.max() + 1
        left &= ~here
    return number


def _courses(photos: Photos) -> tuple[Bools, Floats, Floats]:
    """Return whether the next photo is on the same strip, (n - 1,), and of each its unit course and metres to others.

    The course is zero where a photo is alone on its strip.
    """
    same = (photos.uav[1:] == photos.uav[:-1]) & (photos.strip[1:] == photos.strip[:-1]) & (photos.strip[1:] >= 0)
    first = np.flatnonzero(same)
    level = photos.position[:, :2]
    steps = np.zeros((len(photos) + 1, 2))
    steps[first + 1] = level[first + 1] - level[first]
    course = steps[1:] + steps[:-1]
    length = np.hypot(*course.T)
    course = np.divide(course, length[:, None], out=course, where=length[:, None] > 0)
    return same, course, np.maximum(np.hypot(*steps[1:].T), np.hypot(*steps[:-1].T))


def _abreast(pairs: Indices, position: Floats, course: Floats, same: Bools) -> Floats:
    """Return where the second UAVs of pairs (n, 2) fly abreast of the first ones, (n, 3) metres.

    `same` tells of each photo but the last whether the next one is on its strip.
    """
    i, j = pairs.T
    on = course[j]
    ahead = np.einsum("ij,ij->i", position[i, :2] - position[j, :2], on)
    k = np.clip(j + np.where(ahead > 0, 1, -1), 0, len(position) - 1)
    leads = same[np.minimum(np.minimum(j, k), len(same) - 1)] & (k != j)
    run = np.hypot(*(position[k] - position[j])[:, :2].T)
    rise = np.where(leads, position[k, 2] - position[j, 2], 0.0) / np.where(run > 0, run, 1.0)
    return position[j] + np.column_stack([ahead[:, None] * on, np.abs(ahead) * rise])


def _width(direction: Floats, frames: Floats, camera: Camera) -> Floats:
    """Return how wide pictures are, seen from above, along directions (n, 2), for each metre of depth."""
    wide, high = camera.half_widths
    right, top = (np.abs(np.einsum("ij,ij->i", direction, frames[:, k, :2])) for k in (1, 2))
    share = np.maximum(right, top)
    whole: Floats = 2.0 * np.where(right >= top, wide, high) / np.where(share > 0, share, 1.0)
    return whole


def _centres(position: Floats, axis: Floats, grid: CellGrid) -> tuple[Floats, Floats]:
    """Return where the axes of cameras meet the ground, about, (n, 2) and at what depths (n,), metres."""
    centre, deep = position[:, :2], np.zeros(len(position))
    for _ in range(4):
        i, j = (
            np.clip(np.searchsorted(line, centre[:, k]) - 1, 0, len(line) - 1)
            for k, line in enumerate((grid.x, grid.y))
        )
        fall = np.maximum(-axis[:, 2], STEEP_VIEW)
        deep = np.maximum(position[:, 2] - grid.z[i, j], 0.0) / fall
        centre = position[:, :2] + deep[:, None] * axis[:, :2]
    return centre, deep


def _in_area(places: Floats, grid: CellGrid) -> Indices:
    """Return which places (n, 2) lie in whole cells of what is to be seen."""
    i, j = (np.searchsorted(line, places[:, k]) - 1 for k, line in enumerate((grid.x, grid.y)))
    n, m = grid.whole.shape
    on = (i >= 0) & (i < n) & (j >= 0) & (j < m)
    on[on] = grid.whole[i[on], j[on]]
    return np.flatnonzero(on)


def _neighbours(level: Floats, course: Floats, spacing: Floats, axis: Floats, width: Floats) -> Indices:
    """Return pairs (m, 2) of photos on parallel strips, each with the nearest one on either side that it faces."""
    points, found = shapely.points(level), [np.zeros((0, 2), dtype=np.intp)]
    tree, most_ahead = shapely.STRtree(points), FACING * float(spacing.max())
    left, reach = np.flatnonzero(course.any(axis=1)), float(np.median(width)) + most_ahead
    while len(left):  # those that have no neighbour in reach on a side are looked for again, farther away
        settled, whole = np.zeros(len(level), dtype=np.intp), reach >= np.hypot(*np.ptp(level, axis=0))
        for begin in range(0, len(left), max(PAIRS_AT_ONCE // len(level), 1)):
            raise_if_interrupted()
            rows = left[begin : begin + max(PAIRS_AT_ONCE // len(level), 1)]
            i, j = tree.query(points[rows], "dwithin", distance=reach)
            i = rows[i]
            way, on = level[j] - level[i], course[i]
            along, aside = (way * on).sum(axis=1), way[:, 1] * on[:, 0] - way[:, 0] * on[:, 1]
            fits = np.abs(aside) > APART * width[i]
            fits &= np.abs(along) <= FACING * np.maximum(spacing[i], spacing[j])
            fits &= np.abs((course[j] * on).sum(axis=1)) > PARALLEL
            fits &= (axis[j] * axis[i]).sum(axis=1) > PARALLEL
            far = np.abs(aside) + NEARER_AHEAD * np.abs(along)
            for side in (aside > 0, aside < 0):
                some = np.flatnonzero(fits & side)
                some = some[np.lexsort((j[some], far[some], i[some]))]
                nearest = some[np.unique(i[some], return_index=True)[1]]
                nearest = nearest[whole | (far[nearest] <= reach - most_ahead)]
                settled[i[nearest]] += 1
                found.append(np.column_stack([i[nearest], j[nearest]]))
        left, reach = (left[:0] if whole else left[settled[left] < 2]), 4 * reach
    return np.unique(np.sort(np.concatenate(found), axis=1), axis=0)


def _shared(one: PhotoView, other: PhotoView, grid: CellGrid) -> float:
    """Return what two photos share of the ground that one of them shows, per cent; NaN where one shows none.

    A cell at the edge of a picture counts in part, as told by how far its middle is from that edge, and by how much
    that changes from cell to cell.
    """
    raise_if_interrupted()
    a, b = (view.window(*grid.ends) for view in (one, other))
    here = grid.between(np.array([np.minimum(a[0], b[0]), np.maximum(a[1], b[1])]))
    if here is None:
        return np.nan
    i, j = (slice(s.start, s.stop, max((s.stop - s.start) // MOST_NODES, 1)) for s in here)
    x, y = (0.5 * (line[:-1] + line[1:])[part] for line, part in ((grid.x, i), (grid.y, j)))
    z, asked = 0.5 * (grid.z[:-1, :-1][i, j] + grid.z[1:, 1:][i, j]), grid.whole[i, j]
    if min(z.shape) < 2:
        return np.nan
    inside, another = (view.look(x[:, None], y[None], z)[0] for view in (one, other))
    shown = [float(_part(margin)[asked].sum()) for margin in (inside, another, np.minimum(inside, another))]
    return 100.0 * shown[2] / min(shown[:2]) if min(shown[:2]) > 0.0 else np.nan


def _part(margin: Floats) -> Floats:
    """Return which part of each cell (n, m) lies in a picture, by how far its middle does."""
    change = sum(np.abs(one) for one in np.gradient(margin))
    part: Floats = np.clip(0.5 + margin / np.maximum(change, NO_LENGTH), 0.0, 1.0)
    return part
