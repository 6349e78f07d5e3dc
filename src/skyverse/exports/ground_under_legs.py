"""The ground under straight legs: how steep it is, how far it is off a straight line, and how far below a ceiling."""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING
from skyverse.space.tube import raised


def ceiling_margin(scenario: Scenario) -> float:
    """Return how many metres below the ceiling above ground waypoints are, so that flown legs do not exceed it."""
    slope = 0.0 if scenario.terrain is None else steepest(scenario.terrain.lowest_ground)
    return LEG_ALLOWANCE * (1 + slope)


def ground_allowance(scenario: Scenario) -> float:
    """Return by how many metres an exported leg may come nearer to the ground than its clearance.

    That is what rounding takes of the altitude, and sideways where the ground is steepest: starts and targets may lie
    on their limits.
    """
    slope = 0.0 if scenario.terrain is None else steepest(scenario.terrain)
    return LEG_ALLOWANCE + MAVLINK_ROUNDING * slope


def lowered(terrain: Terrain, error: TrackingError) -> Terrain:
    """Return a terrain that is at each place at least as low as the lowest one within an error, and half its height."""
    higher = raised(derived(terrain, heights=-terrain.heights), error)
    assert higher is not None
    return derived(higher, heights=-higher.heights)


def greatest_height(points: Floats, terrain: Terrain, least: float) -> Floats:
    """Return how high above a terrain a polyline (n, 3) is at most, on both legs at each vertex; (n,) metres.

    Where that is no more than `least`, the height of the legs' ends may be returned.
    """
    above = points[:, 2] - terrain.height(points[:, :2])
    if len(points) < 2:
        return above
    ends = np.stack([points[:-1], points[1:]], axis=1)
    rise = steepest(terrain) * np.linalg.norm(ends[:, 1, :2] - ends[:, 0, :2], axis=1)
    legs = np.maximum(above[:-1], above[1:])
    for k in np.flatnonzero((rise > 0) & (legs + rise > least)):
        at = breaks(terrain, *ends[k])
        places = ends[k, 0] + at[:, None] * (ends[k, 1] - ends[k, 0])
        height = places[:, 2] - terrain.height(places[:, :2])
        legs[k] = height.max() + second_differences(height).max() / 8
    return np.maximum(np.r_[legs, -np.inf], np.r_[-np.inf, legs])


def steepest(terrain: Terrain) -> float:
    """Return a bound of the ground's slope, from the slopes along the edges of its bilinear cells."""
    east = np.abs(np.diff(terrain.heights, axis=0)).max() / terrain.step[0]
    north = np.abs(np.diff(terrain.heights, axis=1)).max() / terrain.step[1]
    return float(np.hypot(east, north))


class GroundUnder(NamedTuple):
    """What a leg that follows the ground has to allow for: metres, metres, and metres for each metre aside.

    Attributes
    ----------
    bend
        How far the ground is off a straight line between any two places, at most.
    lower
        How much lower the ground may be that the autopilot knows: it is taken for any between a terrain's `lowest` and
        its `heights`. Nothing else is allowed for how an autopilot's terrain may differ from the scenario's.
    slope
        How steep the ground is at most, and the lowest ground.
    """

    bend: float
    lower: float
    slope: float


def ground_under(terrain: Terrain, points: Floats, near: float) -> GroundUnder:
    """Return what the ground is within `near` metres of the rectangle around some points, (n, 3) metres.

    Bilinear ground is as far off a plane, and as steep, as it is at the corners of its cells at most.
    """
    east, north = (_corners(terrain, axis, points[:, axis], near) for axis in range(2))
    places = np.stack(np.meshgrid(east, north, indexing="ij"), axis=-1)
    heights, lowest = (surface.height(places) for surface in (terrain, terrain.lowest_ground))
    x, y = (east - east.mean())[:, None], (north - north.mean())[None]
    plane = x * (np.sum(x * heights) / (np.sum(x**2) * len(north)))
    plane = plane + y * (np.sum(y * heights) / (np.sum(y**2) * len(east))) + heights.mean()
    slope = max(
        math.hypot(
            float(np.abs(np.diff(one, axis=0) / np.diff(east)[:, None]).max()),
            float(np.abs(np.diff(one, axis=1) / np.diff(north)[None]).max()),
        )
        for one in (heights, lowest)
    )
    return GroundUnder(2 * float(np.abs(heights - plane).max()), float((heights - lowest).max()), slope)


def _corners(terrain: Terrain, axis: int, values: Floats, near: float) -> Floats:
    """Return the coordinates along an axis at which a rectangle begins and ends, and those of cells between."""
    low, high = float(values.min()) - max(near, MAVLINK_ROUNDING), float(values.max()) + max(near, MAVLINK_ROUNDING)
    origin, step = terrain.origin[axis], terrain.step[axis]
    lines = origin + step * np.arange(math.floor((low - origin) / step) + 1, math.ceil((high - origin) / step))
    return np.concatenate([[low], lines[(lines > low) & (lines < high)], [high]])


def breaks(terrain: Terrain, a: Floats, b: Floats) -> Floats:
    """Return where a leg crosses the lines of a terrain's grid, and the middles between them, as shares, (2n + 1,)."""
    shares = [0.0, 1.0]
    for axis in range(2):
        if a[axis] != b[axis]:
            lines = (np.array([a[axis], b[axis]]) - terrain.origin[axis]) / terrain.step[axis]
            whole = np.arange(math.ceil(lines.min()), math.floor(lines.max()) + 1)
            shares += list((whole - lines[0]) / (lines[1] - lines[0]))
    at = np.unique(np.clip(shares, 0.0, 1.0))
    return np.sort(np.concatenate([at, (at[:-1] + at[1:]) / 2]))


def second_differences(values: Floats) -> Floats:
    """Return the second differences, (n,), of what is quadratic between `breaks`: it exceeds them by 1/8 at most."""
    return np.abs(values[:-2:2] - 2 * values[1:-1:2] + values[2::2])
