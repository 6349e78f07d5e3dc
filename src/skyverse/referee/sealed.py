"""Proves that a curve leads through a seam: that no second curve beside it keeps clear of everything.

The space around the curve is cut into cubes. A cube is closed if each place in it is surely too deep in some widened
shape or too near to the bounds. If the cubes that are not closed do not join the space where the curve comes from to
that where it goes, no second curve can accompany it that is nowhere farther from it than `SEAM_SEARCH` / 2.
"""

import math
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.referee.overlaps import BoxTree
from skyverse.referee.polynomial import halve
from skyverse.referee.solids import GrownSolids
from skyverse.referee.tolerances import HALF_SEAM, LET_PASS, SEAM_SEARCH
from skyverse.referee.world import RefereeWorld

REACH = SEAM_SEARCH / 2
"""Metres: how far from the curve a second one is sought."""
COARSE = REACH / 2
"""Metres: the side of the first cubes."""
MAX_SIZES = 5
"""Sizes of cubes at most: those that are neither closed nor open are cut into eight."""
MAX_CUBES = 2**15
"""Cubes beyond which nothing is proven, which bounds the time."""
MAX_WAY_PARTS = 64
"""Parts of the curve at most on either side of a place."""
CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))
"""Where the corners of a cube are, seen from its middle, as multiples of half its side."""


class _Way(NamedTuple):
    """A short part of the curve about a place: boxes around it, (k, 3) metres, and its two ends, (3,)."""

    low: Floats
    high: Floats
    begin: Floats
    end: Floats


def is_sealed(world: RefereeWorld, b: Floats, error: Floats, piece: int, share: float) -> bool:
    """Tell whether it is proven that no curve beside a curve leads past a place.

    Parameters
    ----------
    world
        What to keep clear of, by half a micrometre.
    b, error
        (n, degree + 1, 3) coefficients of consecutive pieces, metres, and (n,) bounds on their errors.
    piece, share
        The place: the index of the piece, and how far along it, 0 to 1.
    """
    place = _after(b[piece], share)[0]
    there = _Way(place[None], place[None], place, place)
    return _parts_space(world, there, b, error) or _parts_space(world, _way_past(b, piece, share), b, error)


def _way_past(b: Floats, piece: int, share: float) -> _Way:
    """Return the part of the curve that leads past a place, as far as it is near."""
    onwards = _leading_away(b, piece, share)
    back = _leading_away(b[::-1, ::-1], len(b) - 1 - piece, 1 - share)
    parts = onwards + back
    low, high = np.array([part.min(axis=0) for part in parts]), np.array([part.max(axis=0) for part in parts])
    return _Way(low, high, back[-1][-1], onwards[-1][-1])


def _leading_away(b: Floats, piece: int, share: float) -> list[Floats]:
    """Return consecutive short parts of a curve, from a place on until they are away from it."""
    place = _after(b[piece], share)[0]
    parts = [np.stack([place, place])]
    while piece < len(b) and len(parts) < MAX_WAY_PARTS:
        part, width = _after(b[piece], share), 1 - share
        while float(np.ptp(part, axis=0).max()) > REACH:
            part, width = halve(part[None])[0][0], width / 2
        parts.append(part)
        if math.dist(part[-1], place) > 3 * REACH:
            break
        share += width
        if share >= 1:
            piece, share = piece + 1, 0.0
    return parts


def _after(part: Floats, share: float) -> Floats:
    """Return the coefficients (degree + 1, 3) of what follows after a share of a piece, by de Casteljau's algorithm."""
    row, rest = part, part.copy()
    for k in range(1, len(part) + 1):
        rest[len(part) - k] = row[-1]
        row = row[:-1] * (1 - share) + row[1:] * share
    return rest


def _parts_space(world: RefereeWorld, way: _Way, b: Floats, error: Floats) -> bool:
    """Tell whether closed cubes surely part the space at the begin of a way from that at its end."""
    low, high = way.low.min(axis=0) - REACH, way.high.max(axis=0) + REACH
    near = _shapes_near(world, low - COARSE, high + COARSE, b, error)
    count = np.ceil((high - low) / COARSE)
    if not count.prod() <= MAX_CUBES:  # nor where numbers are too large to be counted
        return False
    half = COARSE / 2
    middle = low + half + np.argwhere(np.ones(count.astype(np.intp), dtype=bool)) * COARSE
    halves, is_open = np.full(len(middle), half), np.zeros(len(middle), dtype=bool)
    for _ in range(MAX_SIZES):
        near_way = (_gaps(middle, halves, way.low, way.high) <= REACH).any(axis=1)
        closed, surely_open = _judged(world, near, middle, halves)
        kept = near_way & (is_open | ~closed)
        middle, halves, is_open = middle[kept], halves[kept], (is_open | surely_open)[kept]
        if not _joined(way, middle, halves):
            return True
        cut = np.flatnonzero(~is_open)
        if _joined(way, middle[is_open], halves[is_open]) or len(middle) + 7 * len(cut) > MAX_CUBES:
            return False
        finer = middle[cut, None] + CORNERS / 2 * halves[cut, None, None]
        middle = np.concatenate([middle[is_open], *finer])
        halves = np.concatenate([halves[is_open], np.repeat(halves[cut] / 2, 8)])
        is_open = np.arange(len(middle)) < np.count_nonzero(is_open)
    return False


def _shapes_near(
    world: RefereeWorld, low: Floats, high: Floats, b: Floats, error: Floats
) -> list[tuple[GrownSolids, int, float]]:
    """Return the shapes that may close places in a box: the kind and number of each, and a bound on errors, metres."""
    more = LET_PASS + HALF_SEAM
    found = []
    for kind in (world.boxes, *world.others):
        wrong = float(kind.error(b, error).max())
        for pairs in kind.tree.overlapping((low - more)[None], (high + more)[None]):
            found += [(kind, int(shape), wrong) for shape in pairs[:, 1]]
    return found


def _judged(
    world: RefereeWorld, near: list[tuple[GrownSolids, int, float]], middle: Floats, halves: Floats
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Tell which cubes are surely closed, and which are surely open, (n,) each.

    A depth changes by no more than its steepness while a place moves by one metre, so that in the whole cube it differs
    from that in the middle by no more than half the diagonal times that.
    """
    diagonal = np.sqrt(3) * halves
    beyond = _beyond_bounds(world, middle).max(axis=1)
    closed, surely_open = beyond > halves, beyond <= -halves
    for kind, shape, wrong in near:
        depth = kind.depth(middle[:, None], np.full(len(middle), shape)) + LET_PASS + HALF_SEAM
        closed |= depth - wrong - kind.steepness * diagonal > 0
        surely_open &= depth + wrong + kind.steepness * diagonal <= 0
    doubtful = np.flatnonzero(~closed & ~surely_open)
    closed[doubtful] = _closed_by_two(world, near, middle[doubtful], halves[doubtful])
    return closed, surely_open


def _closed_by_two(
    world: RefereeWorld, near: list[tuple[GrownSolids, int, float]], middle: Floats, halves: Floats
) -> NDArray[np.bool_]:
    """Tell in which cubes, (n,), each place is surely too deep in one of two convex shapes, or beyond a face of bounds.

    The sum of two concave functions is nowhere smaller than at a corner. Where the sum of two depths is above 0, so is
    one of the depths.
    """
    corners = np.reshape(middle[:, None] + CORNERS * halves[:, None, None], (len(CORNERS) * len(middle), 3))
    depths = list(_beyond_bounds(world, corners).T)
    for kind, shape, wrong in near:
        if kind.is_convex(shape):
            depths.append(kind.depth(corners[:, None], np.full(len(corners), shape)) + LET_PASS + HALF_SEAM - wrong)
    closed = np.zeros(len(middle), dtype=bool)
    for k, one in enumerate(depths):
        for other in depths[: k + 1]:
            closed |= (one + other).reshape(len(middle), len(CORNERS)).min(axis=1) > 0
    return closed


def _beyond_bounds(world: RefereeWorld, places: Floats) -> Floats:
    """Return how far places (n, 3) are beyond the six faces of bounds that are narrower by half a seam, (n, 6)."""
    return np.hstack([world.low + HALF_SEAM - places, places - world.high + HALF_SEAM])


def _gaps(middle: Floats, halves: Floats, low: Floats, high: Floats) -> Floats:
    """Return the distances (n, k) between cubes and boxes with corners (k, 3), metres."""
    apart = np.maximum(low - middle[:, None], middle[:, None] - high) - halves[:, None, None]
    gaps: Floats = np.linalg.norm(np.maximum(apart, 0.0), axis=2)
    return gaps


def _joined(way: _Way, middle: Floats, halves: Floats) -> bool:
    """Tell whether cubes that touch one another lead from the begin of a way to its end."""
    begin, end = (_gaps(middle, halves, place[None], place[None])[:, 0] <= REACH for place in (way.begin, way.end))
    if not begin.any() or not end.any():
        return False
    wide = 1.01 * halves[:, None]
    tree = BoxTree(middle - wide, middle + wide)
    one, other = np.concatenate(list(tree.overlapping(middle - wide, middle + wide))).T
    group: Indices = np.arange(len(middle))
    while True:  # each cube takes the least number among its neighbours, and the number that this one has taken
        least = group.copy()
        np.minimum.at(least, one, group[other])
        least = least[least]
        if (least == group).all():
            return bool(np.isin(group[begin], group[end]).any())
        group = least
