"""A scenario as it is for the nominal position of a UAV that may stray from it.

The flown position stays within an upright cylinder about the nominal one: a radius and half a height. The nominal
position is safe if that whole cylinder is, which is the case outside of obstacles that are grown by it. Obstacles are
grown by one number on all sides, the clearance, to which the radius is added. What the half height is more than the
radius, or less, is added to the altitudes at which the shapes begin and end.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.model.quantities import derived
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError
from skyverse.numerics.kernel import kernel, writable
from skyverse.numerics.tolerances import REACH_ROUNDING

NO_ERROR = TrackingError()
"""The error of a UAV that keeps to its nominal position."""


def reach(clearance: float, error: TrackingError) -> float:
    """Return how far a nominal position keeps from shapes that are made `taller`, metres: the radius is added."""
    return clearance + error.horizontal


def taller(error: TrackingError) -> float:
    """Return by how many metres shapes are taller at either end that hold, grown by the radius, what is unsafe.

    A shape that is lower than the radius exceeds the half height may end below where it begins: grown by the radius it
    is as high as it must be.
    """
    return error.vertical - error.horizontal


def wider(error: TrackingError) -> float:
    """Return how much larger the radius is of a sphere that holds, grown by the error's radius, what is unsafe, metres.

    A sphere that is grown by a cylinder lies within one whose radius is larger by the diagonal of the cylinder's half.
    """
    return math.hypot(error.horizontal, error.vertical) - error.horizontal


def raised(terrain: Terrain | None, error: TrackingError) -> Terrain | None:
    """Return a terrain that is at each place at least as high as the highest one within the radius, and half a height.

    Each node is raised by the radius times the steepest slope of the cells that are within the radius of any cell
    around the node. At every place between nodes the raised ground then exceeds the ground by what it may rise there.
    """
    if terrain is None or error == NO_ERROR:
        return terrain
    h = writable(terrain.heights)
    x, y = (min(math.ceil(error.horizontal / one), n) for one, n in zip(terrain.step, h.shape, strict=True))
    slope = steepest_near(h, terrain.step, (x, y))
    return derived(terrain, heights=h + (error.horizontal * slope + error.vertical), lowest=None)


WALL_SLOPE = 1.0
"""Metres of height a metre, 45 degrees: ground that is steeper is a wall beside a UAV."""


def is_wall_within(terrain: Terrain | None, place: Floats, radius: float) -> bool:
    """Tell whether the ground is steeper than `WALL_SLOPE` within a radius of x, y, (2,); all metres."""
    return terrain is not None and steepest_within(terrain, place, radius) > WALL_SLOPE


def steepest_within(terrain: Terrain, place: Floats, radius: float) -> float:
    """Return the steepest slope, metres of height a metre, of the cells of a terrain that are nearer to x, y.

    Parameters
    ----------
    terrain
        The terrain.
    place
        (2,) metres.
    radius
        Metres. Where it is 0, no cell is nearer, and the answer is 0.
    """
    near, parts = radius * (1.0 + REACH_ROUNDING), []
    for axis, (origin, step) in enumerate(zip(terrain.origin, terrain.step, strict=True)):
        first, last = np.floor((place[axis] + np.array([-near, near]) - origin) / step).astype(int)
        cells = terrain.heights.shape[axis] - 1
        index = np.arange(max(first - 1, 0), min(last + 1, cells - 1) + 1)
        low = origin + index * step
        parts.append((index, np.maximum(np.maximum(low - place[axis], place[axis] - low - step), 0.0)))
    (i, aside), (j, along) = parts
    if not (len(i) and len(j)):
        return 0.0
    slope = steepest_in_cells(writable(terrain.heights[i[0] : i[-1] + 2, j[0] : j[-1] + 2]), *terrain.step)
    return float(slope[np.hypot(aside[:, None], along) < near].max(initial=0.0))


STEEPEST = 15.0
"""Degrees: nobody lands on steeper ground. Above it no helicopter does (FM 3-21.38, Pathfinder Operations, 2006)."""
LEAST_REACH = 1.0
"""Metres around the place that are asked at least: a UAV has legs."""


def landing_slope(terrain: Terrain, place: Floats, error: TrackingError) -> float:
    """Return by how many degrees the ground slopes at most about a place (2,) where a UAV is to land."""
    return math.degrees(math.atan(steepest_within(terrain, place, max(error.horizontal, LEAST_REACH))))


@kernel
def steepest_in_cells(h: Floats, dx: float, dy: float) -> Floats:
    """Return the steepest slope in each cell between heights (n, m), metres of height a metre, (n - 1, m - 1)."""
    found = np.empty((h.shape[0] - 1, h.shape[1] - 1))
    for i in range(found.shape[0]):
        for j in range(found.shape[1]):
            along_x = max(abs(h[i + 1, j] - h[i, j]), abs(h[i + 1, j + 1] - h[i, j + 1])) / dx
            along_y = max(abs(h[i, j + 1] - h[i, j]), abs(h[i + 1, j + 1] - h[i + 1, j])) / dy
            found[i, j] = math.sqrt(along_x * along_x + along_y * along_y)
    return found


@kernel
def steepest_near(h: Floats, step: tuple[float, float], reach: tuple[int, int]) -> Floats:
    """Return for each node of heights (n, m) the steepest slope of the cells beside it and `reach` more on each side.

    The greatest of several neighbours is found in place, of twice as many with each pass.
    """
    slope, beside = steepest_in_cells(h, step[0], step[1]), (reach[0] + 1, reach[1] + 1)
    found = np.zeros((slope.shape[0] + 2 * beside[0], slope.shape[1] + 2 * beside[1]))
    for i in range(slope.shape[0]):
        for j in range(slope.shape[1]):
            found[i + beside[0], j + beside[1]] = slope[i, j]
    for axis in range(2):
        wide = 1
        while wide < 2 * beside[axis]:
            shift = min(wide, 2 * beside[axis] - wide)
            right, up = (shift, 0) if axis == 0 else (0, shift)
            for i in range(found.shape[0] - right):
                for j in range(found.shape[1] - up):
                    found[i, j] = max(found[i, j], found[i + right, j + up])
            wide += shift
    return found[: h.shape[0], : h.shape[1]].copy()


def inner_bounds(low: Floats, high: Floats, error: TrackingError) -> tuple[Floats, Floats]:
    """Return the corners of the bounds, (3,) metres, from which the whole cylinder stays within them."""
    if error == NO_ERROR:
        return low, high
    reach = np.array([error.horizontal, error.horizontal, error.vertical])
    return low + reach, high - reach
