"""Where movers may be in the next seconds, as boxes: obstacles for planners that know no time."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.model.mover import Doubt, Ellipsoid
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Shape
from skyverse.space.timed_shapes import TimedShape

SLICES = 4
"""Parts of the time ahead; where a mover may be in each is one box."""
SAMPLES = 5
"""Instants of each part at which the stated motion is looked at; those of seen movers are straight."""


def swept_boxes(
    movers: Sequence[TimedShape], begin: float, end: float, clearance: float, kept_free: Sequence[Floats]
) -> list[Box]:
    """Return boxes that hold movers wherever they may be between two instants.

    Parameters
    ----------
    movers
        Of any shape but voxels and prisms.
    begin, end
        Seconds into the mission.
    clearance
        Metres that are kept from the boxes anyway.
    kept_free
        Places (3,). Boxes that are nearer to one of them than the clearance are left out: no path keeps clear of where
        it begins or ends, and the proof of the motion judges what happens there.
    """
    edges = np.linspace(begin, end, SLICES + 1)
    found = []
    for mover in movers:
        low, high = _corners(mover.shape)
        more = mover.keep - clearance
        for early, late in pairwise(edges):
            least, most = _places(mover, float(early), float(late))
            box_low, box_high = least + low - more, most + high + more
            if np.any(box_high <= box_low):
                continue
            near = (np.all((box_low - clearance < at) & (at < box_high + clearance)) for at in kept_free)
            if not any(near):
                found.append(Box(min=tuple(box_low.tolist()), max=tuple(box_high.tolist())))
    return found


def _places(mover: TimedShape, early: float, late: float) -> tuple[Floats, Floats]:
    """Return the corners of a box that holds the moving point between two instants."""
    doubt: Doubt = mover.doubt
    places = mover.motion.at(np.linspace(early, late, SAMPLES))
    off = float(doubt.at(late)[0])
    low, high = places.min(axis=0) - off, places.max(axis=0) + off
    if doubt.top_speed is not None and late > doubt.since:
        seen, far = mover.motion.at([doubt.since])[0], doubt.radius + doubt.top_speed * (late - doubt.since)
        low, high = np.maximum(low, seen - far), np.minimum(high, seen + far)
    return low, high


def _corners(shape: Shape) -> tuple[Floats, Floats]:
    """Return the corners of the box around a mover's shape, metres from its moving point."""
    if isinstance(shape, Ellipsoid):
        size = np.array([shape.semi_axis_xy, shape.semi_axis_xy, shape.semi_axis_z])
        return np.array(shape.centre) - size, np.array(shape.centre) + size
    return extent(shape)  # type: ignore[arg-type]
