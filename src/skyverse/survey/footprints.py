"""What photos show of the ground: how high a camera may be for it, and how much of it two photos share.

A camera looks ahead and down. What it shows of ground so many metres ahead, beside and below it is told by the depth of
that ground along the optical axis, and by where that is in the picture.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats
from skyverse.numerics.kernel import by_reference, inner_query, kernel
from skyverse.survey.ground import BLOCK, GroundCells

AIMED = 6
"""Steps by which it is found where an optical axis meets the ground."""


@by_reference
class GroundView(NamedTuple):
    """How a camera looks at the ground.

    Attributes
    ----------
    depth
        Metres along the optical axis at which what it shows is as coarse as it may be.
    across, along
        Half of what it shows in either direction, for each metre of depth.
    level, down
        The cosine and the sine of the angle at which it looks below the horizon.
    whole
        Whether all of the ground that a photo shows limits its height, or only what is in a rectangle.
    beside, before, behind
        Metres: half of the rectangle's width, and how far it reaches ahead and back; if `whole`, of what is in view of
        a camera over level ground.
    """

    depth: float
    across: float
    along: float
    level: float
    down: float
    whole: bool
    beside: float
    before: float
    behind: float

    @property
    def drop(self) -> float:
        """Metres from the camera down to level ground, all of which is shown finely enough."""
        return (
            self.depth * (self.down - self.along * self.level)
            if self.whole
            else (self.depth - self.before * self.level) / self.down
        )


@inner_query
def _least_drop(view: GroundView, beside: float, near: float, far: float) -> float:
    """Return how far at least a camera is above ground that it shows too coarsely: infinite where it does not.

    The ground is from `near` to `far` metres ahead, and at least `beside` metres beside.
    """
    c, s, w = view.level, view.down, view.along
    if not view.whole:
        inside = beside <= view.beside and near <= view.before and far >= -view.behind
        return (view.depth - min(far, view.before) * c) / s if inside else math.inf
    drop = max(view.depth - far * c, beside / view.across - far * c) / s
    if near > 0.0:
        drop = max(drop, near * (s - w * c) / (c + w * s))
    if far < 0.0:
        drop = max(drop, -far * (s + w * c) / (w * s - c)) if w * s > c else math.inf
    return drop


@inner_query
def _blocks(cells: GroundCells, x: float, y: float, reach: tuple[float, float]) -> tuple[int, int, int, int]:
    """Return from which and before which block, along x and along y, blocks meet a rectangle about a place."""
    sx, sy = cells.step[0] * BLOCK, cells.step[1] * BLOCK
    mx, my = cells.block_low.shape
    x, y = x - cells.origin[0], y - cells.origin[1]
    return (
        min(max(math.floor((x - reach[0]) / sx), 0), mx),
        max(min(math.floor((x + reach[0]) / sx) + 1, mx), 0),
        min(max(math.floor((y - reach[1]) / sy), 0), my),
        max(min(math.floor((y + reach[1]) / sy) + 1, my), 0),
    )


@kernel
def height_limits(cells: GroundCells, view: GroundView, places: Floats, ahead: Floats, half: float) -> Floats:
    """Return the greatest z (n,) from which none of the ground to be seen is shown too coarsely.

    It is infinite where no such ground is shown. The ground that is near is looked at first, and then what is farther,
    which is in view where the ground falls steeply. Blocks whose lowest ground is no limit are passed over.

    Parameters
    ----------
    cells
        The ground.
    view
        What a photo shows of it.
    places, ahead
        (n, 2) metres: x, y, and the unit vectors in which the camera looks.
    half
        Metres: the limits hold as far before and behind each place.
    """
    limits = np.empty(len(places))
    lowest = np.min(cells.block_low)
    level_drop = view.depth * (view.down - view.along * view.level)
    nx, ny = cells.low.shape
    for k in range(len(places)):
        x, y, ex, ey = places[k, 0], places[k, 1], ahead[k, 0], ahead[k, 1]
        wide, deep = cells.step[0], cells.step[1]
        ra, rb = 0.5 * (abs(ex) * wide + abs(ey) * deep) + half, 0.5 * (abs(ey) * wide + abs(ex) * deep)
        block_a, block_b = (ra - half) * BLOCK + half, rb * BLOCK
        limit, scale = math.inf, 1.0
        done = (0, 0, 0, 0)
        for turn in range(2):
            reach = max(view.before, view.behind) * scale + half
            side = view.beside * scale
            these = _blocks(cells, x, y, (abs(ex) * reach + abs(ey) * side, abs(ey) * reach + abs(ex) * side))
            for bi in range(these[0], these[1]):
                for bj in range(these[2], these[3]):
                    if turn == 1 and done[0] <= bi < done[1] and done[2] <= bj < done[3]:
                        continue
                    u = cells.origin[0] + (bi + 0.5) * BLOCK * wide - x
                    v = cells.origin[1] + (bj + 0.5) * BLOCK * deep - y
                    a, b = u * ex + v * ey, max(abs(u * ey - v * ex) - block_b, 0.0)
                    if cells.block_low[bi, bj] + _least_drop(view, b, a - block_a, a + block_a) >= limit:
                        continue
                    for i in range(bi * BLOCK, min((bi + 1) * BLOCK, nx)):
                        for j in range(bj * BLOCK, min((bj + 1) * BLOCK, ny)):
                            ground = cells.low[i, j]
                            if ground < limit:
                                u = cells.origin[0] + (i + 0.5) * wide - x
                                v = cells.origin[1] + (j + 0.5) * deep - y
                                a, b = u * ex + v * ey, max(abs(u * ey - v * ex) - rb, 0.0)
                                limit = min(limit, ground + _least_drop(view, b, a - ra, a + ra))
            done = these
            scale = (limit - lowest) / level_drop
            if not (view.whole and 1.0 < scale < math.inf):
                break
        limits[k] = limit
    return limits


@kernel
def shared_shares(cells: GroundCells, view: GroundView, first: Floats, other: Floats, ahead: Floats) -> Floats:
    """Return the share (n,) that two photos show in common of the ground to be seen, of which one shows less.

    Areas are those on a map. The share is infinite where the middle between them is not to be seen.

    Parameters
    ----------
    cells
        The ground; of those that photos show in part, the part counts.
    view
        What photos show of it.
    first, other
        (n, 3) metres: where the cameras are.
    ahead
        (n, 2) the unit vectors in which both look.
    """
    shares = np.empty(len(first))
    nx, ny = cells.low.shape
    wide, deep = cells.step[0], cells.step[1]
    level_drop = view.depth * (view.down - view.along * view.level)
    c, s, w = view.level, view.down, view.along
    for k in range(len(first)):
        x, y, z, ex, ey = first[k, 0], first[k, 1], first[k, 2], ahead[k, 0], ahead[k, 1]
        u, v, up = other[k, 0] - x, other[k, 1] - y, other[k, 2] - z
        da, db = u * ex + v * ey, u * ey - v * ex
        ra, rb = 0.5 * (abs(ex) * wide + abs(ey) * deep), 0.5 * (abs(ey) * wide + abs(ex) * deep)
        i, j = int((x + 0.5 * u - cells.origin[0]) / wide), int((y + 0.5 * v - cells.origin[1]) / deep)
        i0, j0, fall = min(max(i, 0), nx - 1), min(max(j, 0), ny - 1), 0.0
        for turn in range(AIMED):  # where the optical axis meets the ground
            i, j = i0 + math.floor(0.5 + fall * ex / wide), j0 + math.floor(0.5 + fall * ey / deep)
            ground = cells.middle[min(max(i, 0), nx - 1), min(max(j, 0), ny - 1)]
            fall += (1.0 if turn == 0 else 0.5) * ((z + 0.5 * up - ground) * view.level / view.down - fall)
        i, j = i0 + math.floor(0.5 + fall * ex / wide), j0 + math.floor(0.5 + fall * ey / deep)
        if not (0 <= i < nx and 0 <= j < ny and cells.low[i, j] < math.inf):
            shares[k] = math.inf
            continue
        scale, along, beside = 2.0, 0.0, 0.0
        for _ in range(2):  # first as wide as can be, and then as the lowest ground there allows
            reach, side = max(view.before, view.behind) * scale + abs(da), view.beside * scale + abs(db)
            along, beside = abs(ex) * reach + abs(ey) * side, abs(ey) * reach + abs(ex) * side
            these = _blocks(cells, x, y, (along, beside))
            lowest = math.inf
            for i in range(these[0], these[1]):
                for j in range(these[2], these[3]):
                    lowest = min(lowest, cells.block_low[i, j])
            scale = min(max(z + max(up, 0.0) - lowest, 0.0) / level_drop, scale)
        i0, i1 = int((x - along - cells.origin[0]) / wide), int((x + along - cells.origin[0]) / wide) + 1
        j0, j1 = int((y - beside - cells.origin[1]) / deep), int((y + beside - cells.origin[1]) / deep) + 1
        # from the middle of a cell to its sides is half a unit, along and across
        ka, kb = 0.5 / ra, 0.5 / rb
        near, far, half = ka * (c - w * s) / (s + w * c), ka * (c + w * s) / (s - w * c), kb * view.across
        da, db, one, another, both = da * ka, db * kb, 0.0, 0.0, 0.0
        for i in range(max(i0, 0), min(i1, nx)):
            u = cells.origin[0] + (i + 0.5) * wide - x
            for j in range(max(j0, 0), min(j1, ny)):
                v = cells.origin[1] + (j + 0.5) * deep - y
                a, drop = (u * ex + v * ey) * ka, z - cells.middle[i, j]
                p0, p1 = max(near * drop - a, -0.5), min(far * drop - a, 0.5)
                q0, q1 = max(near * (drop + up) - a + da, -0.5), min(far * (drop + up) - a + da, 0.5)
                if (p1 <= p0 and q1 <= q0) or cells.low[i, j] == math.inf:
                    continue
                b, depth = (u * ey - v * ex) * kb, a / ka * c + drop * s
                side, beyond = half * depth, half * (depth - da / ka * c + up * s)
                r0, r1, t0, t1 = (
                    max(-side - b, -0.5),
                    min(side - b, 0.5),
                    max(db - beyond - b, -0.5),
                    min(db + beyond - b, 0.5),
                )
                one += max(p1 - p0, 0.0) * max(r1 - r0, 0.0)
                another += max(q1 - q0, 0.0) * max(t1 - t0, 0.0)
                both += max(min(p1, q1) - max(p0, q0), 0.0) * max(min(r1, t1) - max(r0, t0), 0.0)
        least = min(one, another)
        shares[k] = both / least if least > 0.0 else math.inf
    return shares


@by_reference
class Unsteady(NamedTuple):
    """By how much a camera may be off.

    Attributes
    ----------
    sine
        Of the angle by which it may be turned.
    aside, up
        Metres: how far it may be from its place seen from above, and in altitude.
    """

    sine: float
    aside: float
    up: float


@kernel
def mark_seen(cells: GroundCells, view: GroundView, off: Unsteady, photos: Floats, ahead: Floats, seen: Bools) -> None:
    """Mark the cells whose middles photos are certain to show, however the camera is off.

    Parameters
    ----------
    cells
        The ground.
    view
        What photos show of it.
    off
        By how much the camera may be off.
    photos
        (n, 3) metres.
    ahead
        (n, 2) the unit vectors in which the cameras look.
    seen
        (nx, ny) of the cells; those that are seen become true.
    """
    nx, ny = cells.middle.shape
    c, s = view.level, view.down
    lowest = np.min(cells.middle)
    off_axis = math.sqrt(off.aside * off.aside + off.up * off.up) * off.sine
    for k in range(len(photos)):
        x, y, z, ex, ey = photos[k, 0], photos[k, 1], photos[k, 2], ahead[k, 0], ahead[k, 1]
        scale = min(max((z - lowest) / (view.depth * (s - view.along * c)), 1.0), 2.0)
        reach, side = max(view.before, view.behind) * scale, view.beside * scale
        these = _blocks(cells, x, y, (abs(ex) * reach + abs(ey) * side, abs(ey) * reach + abs(ex) * side))
        for i in range(these[0] * BLOCK, min(these[1] * BLOCK, nx)):
            for j in range(these[2] * BLOCK, min(these[3] * BLOCK, ny)):
                if seen[i, j]:
                    continue
                u = cells.origin[0] + (i + 0.5) * cells.step[0] - x
                v = cells.origin[1] + (j + 0.5) * cells.step[1] - y
                a, b, drop = u * ex + v * ey, u * ey - v * ex, z - cells.middle[i, j]
                far = math.sqrt(a * a + b * b + drop * drop) * off.sine + off_axis
                depth, high = a * c + drop * s, a * s - drop * c
                shown = True
                for half, at, turn in ((view.across, abs(b), 0.0), (view.along, high, 1.0), (view.along, -high, -1.0)):
                    # how far the inward normal of the side of the view, of length `long`, is level and upright
                    long = math.sqrt(1.0 + half * half)
                    level = abs(half * c - turn * s) if turn != 0.0 else math.sqrt(half * half * c * c + 1.0)
                    steep = abs(half * s + turn * c)
                    shown &= half * depth - at >= long * far + level * off.aside + steep * off.up
                seen[i, j] = shown
