"""The ellipsoids that UAVs must stay out of about others, which fly known trajectories, as arrays."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse.model.trajectory import Trajectory
from skyverse.space.timed_shapes import ELLIPSOID, STAYS, MovingShapes


class MovingEllipsoid(NamedTuple):
    """An upright ellipsoid about a UAV.

    Attributes
    ----------
    motion
        The UAV's, which stays where that ends.
    semi_axis_xy, semi_axis_z
        Horizontal and vertical, metres.
    speed
        M/s that the motion nowhere exceeds.
    """

    motion: Trajectory
    semi_axis_xy: float
    semi_axis_z: float
    speed: float


def with_ellipsoids(shapes: MovingShapes, given: Sequence[MovingEllipsoid]) -> MovingShapes:
    """Return shapes and, after them, ellipsoids as arrays."""
    n = len(given)
    if not n:
        return shapes
    rows = [one.motion.coefficients for one in given]
    degree = max(shapes.rows.shape[1], *(own.shape[1] for own in rows))
    pieces = np.zeros((len(shapes.rows) + sum(map(len, rows)), degree, 3))
    pieces[: len(shapes.rows), : shapes.rows.shape[1]] = shapes.rows
    last = len(shapes.rows) + np.cumsum([len(own) for own in rows])
    for own, stop in zip(rows, last, strict=True):
        pieces[stop - len(own) : stop, : own.shape[1]] = own
    size = np.zeros((n, 6))
    size[:, 3:5] = [(one.semi_axis_xy, one.semi_axis_z) for one in given]
    return shapes._replace(
        active=np.concatenate([shapes.active, np.tile((-math.inf, math.inf), (n, 1))]),
        first=np.concatenate([shapes.first, last]),
        begin=np.concatenate([shapes.begin, *(one.motion.knots[:-1] for one in given)]),
        rows=pieces,
        span=np.concatenate([shapes.span, [(one.motion.start, one.motion.end) for one in given]]),
        then=np.concatenate([shapes.then, np.full(n, STAYS)]),
        first_term=np.concatenate([shapes.first_term, np.full(n, shapes.first_term[-1])]),
        period=np.concatenate([shapes.period, np.ones(n)]),
        kind=np.concatenate([shapes.kind, np.full(n, ELLIPSOID)]),
        size=np.concatenate([shapes.size, size]),
        rings=np.concatenate([shapes.rings, np.full((n, 2), len(shapes.edges))]),
        keep=np.concatenate([shapes.keep, np.zeros(n)]),
        doubt=np.concatenate([shapes.doubt, np.tile((0.0, 0.0, 0.0, math.inf, 0.0, math.inf), (n, 1))]),
        seen=np.concatenate([shapes.seen, np.zeros((n, 3))]),
        rate=np.concatenate([shapes.rate, [one.speed for one in given]]),
    )
