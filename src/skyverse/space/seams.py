"""Seams: places between obstacles, or an obstacle and the bounds, that leave less than a micrometre.

Obstacles may be touched from outside, but nothing may be squeezed between two that touch each other. A line is outside
all seams if it can be moved, part by part, by small steps, so that it keeps `SEAM_MARGIN` from everything.
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.arrays import put, towards
from skyverse.numerics.kernel import inner, inner_query
from skyverse.numerics.norm import distance
from skyverse.numerics.tolerances import LEAST_SEALED_PART, SEAM_MARGIN, SEAM_REACH
from skyverse.space import solids, tree
from skyverse.space.obstacles import Space, crosses, terrain_crossed, terrain_reaches


@inner_query
def within_bounds(space: Space, margin: float, p: Floats) -> bool:
    """Tell whether a point lies at least so many metres inside the bounds."""
    inside = True
    for axis in range(3):
        inside &= space.low[axis] + margin <= p[axis] <= space.high[axis] - margin
    return inside


@inner_query
def bounds_are_wide(space: Space) -> bool:
    """Tell whether the bounds leave space for a step away from each of their faces."""
    wide = True
    for axis in range(3):
        wide &= space.high[axis] - space.low[axis] > 2.0 * SEAM_REACH
    return wide


def _steps_aside() -> Floats:
    """Return small steps (k, 3) in metres that may lead out of a seam: none first, then in 50 directions of each size.

    The directions are up and down, and 16 all around, each of them level, half up and half down.
    """
    turns = np.arange(16) * (2.0 * np.pi / 16)
    turns = np.concatenate((turns[::4], turns[2::4], turns[1::2]))
    level = np.column_stack((np.cos(turns), np.sin(turns), np.zeros(16)))
    ways = [np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), level]
    ways += [(level + np.array([0.0, 0.0, up])) / np.sqrt(2.0) for up in (1.0, -1.0)]
    all_ways = np.concatenate(ways)
    return np.concatenate([np.zeros((1, 3)), *(size * SEAM_MARGIN * all_ways for size in (2.5, 5.0, 10.0, 1.1))])


STEPS_ASIDE = _steps_aside()


@inner
def step_aside(space: Space, part: Floats, off: float, before: int) -> int:
    """Return the index of a step that moves a part of a line clear of all obstacles and bounds by `SEAM_MARGIN`, or -1.

    Parameters
    ----------
    space
        With the obstacles.
    part
        (4, 3) metres: where the part begins and ends, and the corners of a box around it. It keeps the clearance and
        the bounds.
    off
        How far the part is from the segment between its ends at most, metres.
    before
        The step of the part that ends where this one begins, or -1 for none. A change of step must be clear, too:
        otherwise the moved line would lead through what lies between the two.
    """
    moved, change = np.empty((4, 3)), np.empty((4, 3))
    if before >= 0:
        _move(part, before, moved)
        if _clear(space, moved, off):
            return before
        put(change, 0, moved[0])
    for step in range(len(STEPS_ASIDE)):
        if step == before:
            continue
        _move(part, step, moved)
        if not _clear(space, moved, off) or _crosses_aside(space, part, moved):
            continue
        if before >= 0:
            put(change, 1, moved[0])
            write_box(change)
        if before < 0 or _clear(space, change, 0.0):
            return step
    return -1


@inner_query
def write_box(part: Floats) -> None:
    """Write the corners of the box around a part that is straight, (4, 3)."""
    for axis in range(3):
        part[2, axis] = min(part[0, axis], part[1, axis])
        part[3, axis] = max(part[0, axis], part[1, axis])


@inner_query
def _move(part: Floats, step: int, moved: Floats) -> None:
    """Write into `moved` a part moved by one of `STEPS_ASIDE`."""
    for row in range(4):
        for axis in range(3):
            moved[row, axis] = part[row, axis] + STEPS_ASIDE[step, axis]


@inner
def _crosses_aside(space: Space, part: Floats, moved: Floats) -> bool:
    """Tell whether a step leads through an obstacle to its far side, at either end of a part or in its middle."""
    growth = space.clearance - SEAM_MARGIN  # a trajectory may be a little inside
    if crosses(space, growth, part[0], moved[0]) or crosses(space, growth, part[1], moved[1]):
        return True
    return crosses(space, growth, towards(part[0], part[1], 0.5), towards(moved[0], moved[1], 0.5))


@inner
def _clear(space: Space, part: Floats, off: float) -> bool:
    """Tell whether a part is clear of obstacles and bounds by `SEAM_MARGIN`, by its chord or by the box around it."""
    growth = space.clearance + SEAM_MARGIN
    a, b, low, high = part[0], part[1], part[2], part[3]
    if not (within_bounds(space, SEAM_MARGIN, low) and within_bounds(space, SEAM_MARGIN, high)):
        return False
    curved = off > 0.0
    if tree.crossed(space.tree, space.boxes, growth + off, a, b) >= 0 and not (
        curved and len(tree.touching(space.tree, space.boxes, growth, low, high)) == 0
    ):
        return False
    if solids.crossed(space.solids, growth + off, a, b) >= 0 and not (
        curved and solids.reaching(space.solids, growth, low, high) < 0
    ):
        return False
    return not terrain_crossed(space, growth, off, a, b) or (curved and not terrain_reaches(space, growth, low, high))


@inner
def avoids_seams(space: Space, a: Floats, b: Floats) -> bool:
    """Tell whether a segment that crosses no grown obstacle can be moved, part by part, out of every seam.

    Each part is as long as one step can move, and the moved parts follow one another without passing through anything.
    """
    least = LEAST_SEALED_PART / max(distance(a, b), LEAST_SEALED_PART)
    part = np.empty((4, 3))
    put(part, 0, a)
    at, step = 0.0, -1
    while True:
        share = 1.0 - at
        while True:
            to = 1.0 if share == 1.0 - at else at + share
            put(part, 1, towards(a, b, to))
            write_box(part)
            found = step_aside(space, part, 0.0, step)
            if found >= 0 or share < least:
                break
            share *= 0.25
        if found < 0 or to >= 1.0:
            return found >= 0
        put(part, 0, part[1])
        at, step = to, found
