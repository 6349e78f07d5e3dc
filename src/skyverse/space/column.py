"""The column over a start or target: from there straight up to where a UAV may stray from its nominal position.

A UAV that stands on the ground or on a roof cannot keep its tracking error and the clearance from it. It takes off and
lands in a column in which the error does not count for what lies below: the bounds' floor, the ground where it is
nowhere steeper than 45 degrees within the horizontal error, and obstacles that end, grown by the clearance, no higher
than the start or target. From all else it keeps both, also from airspace below, on which nothing stands.
"""

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import CLEARANCE_EASE, COLUMN_LIFT, SURFACE_DEPTH
from skyverse.space.tube import NO_ERROR
from skyverse.space.world import World

MAX_EXITS = 1000
"""Obstacles one above another that a column is followed through at most."""
HEIGHTS = 20
"""Heights in a column at which it is asked what is too near."""
HALVINGS = 40
"""Of the metres by which something is too near a column."""


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
        The point itself where a UAV may stray from it, and also where there is no column: something beside it or above
        is too near, or it would have to be higher than `highest_top`.
    """
    foot = np.array(point, dtype=np.float64)
    if world.error == NO_ERROR or world.free(foot)[0]:
        return foot
    top = foot.copy()
    for _ in range(MAX_EXITS):
        above = world.way_out_above(top)
        if above is None or above > highest_top(nominal, world.error, foot):
            return foot
        top[2] = max(above, top[2]) + COLUMN_LIFT
        if world.free(top)[0]:
            clear = nominal.segments_free(foot, top)[0] and beside_column(nominal, world, foot).segments_free(foot, top)
            return top if clear else foot
    return foot


def highest_top(nominal: World, error: TrackingError, foot: Floats) -> float:
    """Return the greatest z at which a column over a start or target may end, metres.

    What lies below keeps a UAV from straying for no more than its error, beside ground that slopes by about 45 degrees.
    """
    return float(foot[2]) + nominal.space.clearance + error.horizontal + error.vertical


def beside_column(nominal: World, world: World, foot: Floats) -> World:
    """Return the world for a column over a start or target: with the tracking error, but without what lies below."""
    return world.beside(foot, float(foot[2]) - nominal.space.clearance + SURFACE_DEPTH)


def why_no_column(nominal: World, world: World, point: ArrayLike) -> str | None:
    """Return a sentence's end that says what keeps a UAV from rising in a column over a safe point, or ``None``.

    Parameters are those of `column_top`.
    """
    foot = np.array(point, dtype=np.float64)
    error, clearance = world.error, nominal.space.clearance + CLEARANCE_EASE
    if world.free(foot)[0] or column_top(nominal, world, foot)[2] > foot[2]:
        return None
    must = (
        f"the clearance of {clearance:g} m and the tracking error of {error.horizontal:g} m horizontally and "
        f"{error.vertical:g} m vertically, from which only ground and roofs below it are exempt"
    )
    beside = beside_column(nominal, world, foot)
    most = highest_top(nominal, error, foot)
    top = foot.copy()
    for _ in range(MAX_EXITS):
        for height in np.linspace(foot[2], top[2], HEIGHTS):
            number = beside.blocker((*foot[:2], height))
            if number is not None:
                return f"is {_too_near(beside, foot, top):.3g} m too near {beside.named(number)} for {must}"
            ground = beside.way_out_above((*foot[:2], height)) if beside.is_steep_about(foot) else None
            if ground is not None:
                higher = f"it would have to be {ground - height:.3g} m higher"
                return f"is within its tracking error of ground that is steeper than 45 degrees: {higher}"
            reason = beside.why_unsafe((*foot[:2], height))
            if reason is not None:
                return f"{reason}; only ground and roofs below a start or target are exempt from the error"
        above = None if world.free(top)[0] else world.way_out_above(top)
        if above is None:
            break
        if above > most:
            return (
                f"is beside ground that rises so steeply that it may stray by its tracking error only from "
                f"{above - foot[2]:.4g} m above; no more than {most - foot[2]:.4g} m are allowed"
            )
        top[2] = max(above, top[2]) + COLUMN_LIFT
    return world.why_unsafe(foot)


def _too_near(beside: World, foot: Floats, top: Floats) -> float:
    """Return by how many metres what is beside a column, or above it, is too near."""
    near, far = 0.0, beside.space.clearance
    for _ in range(HALVINGS):
        middle = (near + far) / 2
        if beside.first_crossing(foot, top, -middle) is None:
            far = middle
        else:
            near = middle
    return far
