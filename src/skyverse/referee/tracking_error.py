"""What a UAV's tracking error adds to the shapes that its nominal position must not enter, as the referee sees it.

The flown position lies within an upright cylinder about the nominal one. What must not be entered grows by it: to the
side by its radius, up and down by half its height. The kinds of grown shapes grow by one clearance on all sides, to
which the radius is added; by what the half height is more than the radius, the shapes themselves become taller.
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError

EXACT = TrackingError()
"""The error of a UAV that keeps to its nominal position."""


def named(name: str, error: TrackingError) -> str:
    """Return a UAV's name as messages have it that are about all places where it may be."""
    return name if error == EXACT else f"{name}, with its tracking error,"


def reach(clearance: float, error: TrackingError) -> float:
    """Return how far a nominal position keeps from shapes that are made `taller`, metres: the radius is added."""
    return clearance + error.horizontal


def taller(low: Floats, high: Floats, error: TrackingError) -> tuple[Floats, Floats]:
    """Return the altitudes, (n,) metres, between which shapes lie that then grow by the radius on all sides."""
    return low + error.horizontal - error.vertical, high - error.horizontal + error.vertical


def shorter(high: Floats, error: TrackingError) -> Floats:
    """Return the altitudes, (n,) metres, at which shapes end that are made `taller`."""
    return high + error.horizontal - error.vertical


def wider(radius: Floats, error: TrackingError) -> Floats:
    """Return the radii (n,) of spheres that hold, when they grow by the radius, all that the error makes unsafe."""
    return radius + (np.hypot(error.horizontal, error.vertical) - error.horizontal)


def narrower(radius: Floats, error: TrackingError) -> Floats:
    """Return the radii (n,), metres, of spheres that are made `wider`."""
    return radius - (np.hypot(error.horizontal, error.vertical) - error.horizontal)


def steepest_in_cells(h: Floats, step: Floats) -> Floats:
    """Return the steepest slopes (n, m), metres of height a metre, of the cells between heights h (n + 1, m + 1).

    Within a cell the ground is nowhere steeper than its steeper edges along x and along y together.
    """
    east, north = h[1:] - h[:-1], h[:, 1:] - h[:, :-1]
    for rise, length in ((east, step[0]), (north, step[1])):  # in place, as memory takes longer than arithmetic
        np.square(np.divide(rise, length, out=rise), out=rise)
    slope: Floats = np.maximum(east[:, 1:], east[:, :-1])
    slope += np.maximum(north[1:], north[:-1])
    return np.sqrt(slope, out=slope)


def raised_heights(terrain: Terrain, error: TrackingError) -> Floats:
    """Return heights (nx, ny), metres, that are nowhere lower than the highest ground within the radius and the error.

    Within the radius of a place the ground rises by no more than the radius times the steepest slope there. For a place
    in a cell that slope is found in the cells that are so near to this cell. Each of the cell's corners is raised with
    the steepest slope of these, and so is every place between the corners.
    """
    radius, h = error.horizontal, terrain.heights
    steepest = steepest_in_cells(h, np.array(terrain.step))
    reach = [int(np.ceil(radius / step)) for step in terrain.step]
    for axis in (0, 1):
        more = min(reach[axis], steepest.shape[axis])
        padding = [(0, 0), (0, 0)]
        padding[axis] = (more + 1, more + 1)
        steepest = _greatest_of_neighbours(np.pad(steepest, padding), 2 * more + 2, axis)
    raised: Floats = steepest * radius
    raised += h
    raised += error.vertical
    return raised


def _greatest_of_neighbours(values: Floats, count: int, axis: int) -> Floats:
    """Return the greatest of every `count` values that follow each other along an axis."""
    found, held = np.moveaxis(values, axis, 0), 1
    while held < count:
        more = min(held, count - held)
        found, held = np.maximum(found[:-more], found[more:]), held + more
    return np.moveaxis(found, 0, axis)
