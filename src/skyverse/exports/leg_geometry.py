"""How flown legs differ from straight ones, and the lines that stand for what is flown around cut corners."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.exports.autopilots import PX4_ALTITUDE_RADII
from skyverse.model.geodesy import LEAST_RADIUS
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, MIN_GROWTH, SAME_PLACE
from skyverse.space.tracking_error import raised


def towards(way: Floats, radius: float) -> Floats:
    """Return a vector, (3,), cut to the length `radius`."""
    length = math.hypot(*way)
    return way * min(radius / length, 1.0) if length else way


NEAR_POLE = math.radians(89.4)
"""The latitude, radians, up to which ArduPilot scales longitudes as they are."""
MARGIN = 1.1
"""By what a deviation that is reckoned on a sphere is multiplied."""


def leg_deviation(scenario: Scenario, lengths: ArrayLike) -> Floats:
    """Return how many metres legs (...) metres long may be flown beside straight lines, (...).

    PX4 flies straight on an azimuthal map about its home, ArduPilot in degrees that are scaled to metres, and DJI along
    geodesics. A leg of length d is off another line by d^2 / 8 times the difference of their curvatures. Between a
    geodesic and a straight line in degrees that is 1.16 tan(latitude) / R at most, what is off along the leg included,
    and between a geodesic and a straight line on a map r / R^2, where r is the distance from the map's origin, and R
    the Earth's radius. Altitudes change linearly along all of these lines.
    """
    origin, corners = scenario.frame.origin, np.abs([scenario.bounds.min, scenario.bounds.max])
    assert origin is not None
    far = math.hypot(*corners[:, :2].max(axis=0).tolist())
    latitude = math.radians(abs(origin.latitude)) + far / LEAST_RADIUS
    latitude = latitude if latitude < NEAR_POLE else math.pi / 2  # where nothing is known of legs
    # home, in the bounds as the leg is, is up to twice as far from it as the origin
    curvature = (1.16 * math.tan(latitude) + 3 * far / LEAST_RADIUS) / LEAST_RADIUS
    return np.asarray(MARGIN * curvature / 8 * np.asarray(lengths, dtype=np.float64) ** 2)


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
    if len(points) < 2:
        return points[:, 2] - terrain.height(points[:, :2])
    legs = greatest_on_legs(np.stack([points[:-1], points[1:]], axis=1), terrain, least)
    return np.maximum(np.r_[legs, -np.inf], np.r_[-np.inf, legs])


def greatest_on_legs(ends: Floats, terrain: Terrain, least: float) -> Floats:
    """Return how high above a terrain straight legs, (n, 2, 3) metres, are at most, (n,) metres."""
    above = ends[..., 2] - terrain.height(ends[..., :2])
    rise = steepest(terrain) * np.linalg.norm(ends[:, 1, :2] - ends[:, 0, :2], axis=1)
    legs = np.maximum(above[:, 0], above[:, 1])
    for k in np.flatnonzero((rise > 0) & (legs + rise > least)):
        at = _crossings(terrain, *ends[k])
        places = ends[k, 0] + at[:, None] * (ends[k, 1] - ends[k, 0])
        height = places[:, 2] - terrain.height(places[:, :2])
        curved = np.abs(height[:-2:2] - 2 * height[1:-1:2] + height[2::2])  # quadratic between two crossings
        legs[k] = height.max() + curved.max() / 8
    return legs


def _crossings(terrain: Terrain, a: Floats, b: Floats) -> Floats:
    """Return where a leg crosses the lines of a terrain's grid, and the middles between them, as shares, (2n + 1,)."""
    shares = [0.0, 1.0]
    for axis in range(2):
        if a[axis] != b[axis]:
            lines = (np.array([a[axis], b[axis]]) - terrain.origin[axis]) / terrain.step[axis]
            whole = np.arange(math.ceil(lines.min()), math.floor(lines.max()) + 1)
            shares += list((whole - lines[0]) / (lines[1] - lines[0]))
    at = np.unique(np.clip(shares, 0.0, 1.0))
    return np.sort(np.concatenate([at, (at[:-1] + at[1:]) / 2]))


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


def growth_of(extra: float) -> float:
    """Return the least `MIN_GROWTH` times a power of two that is not below `extra`, metres: few worlds are needed."""
    return float(MIN_GROWTH * 2.0 ** max(math.ceil(math.log2(extra / MIN_GROWTH)), 0))


LINE_HALF_WIDTHS = (0.32, 0.08, 0.02)
"""Metres: half the distance between the lines by which a cut corner is judged, tried from coarse to fine.

With an acceptance radius above `WIDE_CORNER` they grow in proportion, so that a large corner takes no more lines.
"""
WIDE_CORNER = 2.0
"""Metres."""
CLIMB_HALF_WIDTH = 0.001
"""Metres: the same at last where PX4 cuts the end of a climb; with the rounding it is less than legs are allowed."""
LATE_SHARE = 1 / 8
"""The last share of those lines, judged by itself, because the lines converge there."""


def is_straight(cut: Floats, on: Floats) -> bool:
    """Tell whether there is no corner between the ways that may be cut, (2, 3), and the way on, (3,) metres each."""
    long = math.hypot(*on)
    return long == 0 or float(np.linalg.norm(np.cross(cut, on), axis=1).max()) / long < MIN_GROWTH / 10


def corner_lines(
    cut: Floats, at: Floats, after: Floats, radius: float
) -> Iterator[tuple[Floats, Floats, Floats, float, float]]:
    """Yield lines that stand for all ways on from a corner that is cut, from coarse to fine.

    These are (n, 3) metres where they begin, where their last share does, and where they end; and how near each
    possible way is to one of them, and to its last share, metres.

    Parameters
    ----------
    cut
        (2, 3) metres: from the corner to where the UAV turns at the earliest, on the leg before, and on the way there
        from where it turned to that.
    at, after
        (3,) metres: the corner, and the next waypoint.
    radius
        The acceptance radius, metres.
    """
    p, q = cut
    widths = (np.array(LINE_HALF_WIDTHS) * max(1.0, radius / WIDE_CORNER)).tolist()
    upright = not cut[:, :2].any()
    if upright and np.abs(cut[:, 2]).max() <= min(PX4_ALTITUDE_RADII[1], radius - SAME_PLACE):
        widths.append(CLIMB_HALF_WIDTH)
    for width in widths:
        deep = _middles(max(math.hypot(*p), math.hypot(*q)), width)
        wide = _middles(math.dist(p, q), width)
        sides = ((1 - wide)[:, None] * p + wide[:, None] * q)[None] * deep[:, None, None]
        starts = at + sides.reshape(-1, 3)
        near = math.hypot(width, min(width, math.dist(p, q) / 2))
        ends = np.broadcast_to(after, starts.shape)
        yield starts, starts + (1 - LATE_SHARE) * (ends - starts), ends, near, LATE_SHARE * near


def _middles(length: float, half: float) -> Floats:
    """Return the midpoints, as shares of a length, of the fewest equal parts that are at most 2 * `half` long."""
    count = max(math.ceil(length / (2 * half)), 1)
    return (np.arange(count) + 0.5) / count
