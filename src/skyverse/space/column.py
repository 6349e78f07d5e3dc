"""The column over a start or target: from there straight up to where a UAV may stray from its nominal position.

A UAV that stands on the ground or on a roof cannot keep its tracking error and the clearance from it. It takes off and
lands in a column in which only the nominal position keeps the clearance.
"""

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.numerics.tolerances import COLUMN_LIFT
from skyverse.space.tube import NO_ERROR
from skyverse.space.world import World

MAX_EXITS = 1000
"""Obstacles one above another that a column is followed through at most."""


def column_top(nominal: World, world: World, point: ArrayLike) -> Floats:
    """Return the lowest place straight above a point from which a UAV may stray, (3,) metres.

    Parameters
    ----------
    nominal
        The world without the tracking error, in which the whole column must be safe.
    world
        The world with the tracking error.
    point
        (3,) metres: a start or a target.

    Returns
    -------
    Floats
        The point itself where a UAV may stray from it, and also where no place above it is reached.
    """
    foot = np.array(point, dtype=np.float64)
    if world.error == NO_ERROR or world.free(foot)[0]:
        return foot
    top = foot.copy()
    for _ in range(MAX_EXITS):
        above = world.way_out_above(top)
        if above is None or above + COLUMN_LIFT > world.space.high[2]:
            return foot
        top[2] = max(above, top[2]) + COLUMN_LIFT
        if world.free(top)[0]:
            return top if nominal.segments_free(foot, top)[0] else foot
    return foot
