"""Trajectories that are what was planned: straight along the path, with a blend at each bend that needs no stop.

A blend first cuts its corner on the inside. Where an obstacle is there, as at every bend of a shortest path, the corner
is moved outwards by as much as the blend cuts off, so that the UAV flies through the path's own bend, or past it on the
outside. Where that is not clear either, the blend becomes smaller, and at last the UAV stops at the bend. Bends that
are so near each other that they slow the UAV down are merged; see `merged_bends`.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.space.speed_zones import first_too_fast
from skyverse.space.world import World
from skyverse.trajectory.leg_parts import ZONE_MARGIN, LegParts, cut_legs, whole_legs
from skyverse.trajectory.limits import Limits, limits_of
from skyverse.trajectory.merged_bends import MovedWaypoints, merge_bends
from skyverse.trajectory.proof import clear_pieces
from skyverse.trajectory.straight_legs import (
    Legs,
    blend_depths,
    corner_speeds,
    pieces_along,
    trajectory_along,
    without_repeats,
)

MAX_ROUNDS = 24
"""How often blends that are not clear are changed, before the UAV stops at every bend."""
MAX_SHRINKS = 8
"""How often one blend is made smaller before the UAV stops at its bend."""
SHRINK = 0.7
"""The factor by which a blend is made smaller."""
OUTWARD_ROUNDS = 3
"""How often corners are moved outwards in a round, since the path turns more sharply at a corner that is moved."""
ADDED_TURNING = math.radians(10.0)
"""Radians by which a flight may turn more than its path, about, since corners that are moved outwards are sharper."""
ADDED_SHARE = 0.15
"""The same as a share of the path's own turning, where that is more."""
PASSING_SHARE = 0.25
"""The share of the tolerance by which the UAV passes outside of a bend, so that autopilots may cut corners there."""
PASSING_SLOPE = 0.01
"""The same distance at most as a share of the legs beside the bend, so that they hardly change their directions."""
MERGED_SHARES = (0.5, 0.25, 0.1, 0.03)
"""Shares of the tolerance by which a bend in place of several may be off the path, tried in turn."""


class BlendedLegs(NamedTuple):
    """A motion along waypoints.

    Attributes
    ----------
    waypoints
        The waypoints.
    legs
        The legs between the corners, which may lie outside of the waypoints.
    speeds
        (n,) at the corners, m/s.
    seconds
        How long it takes.
    """

    waypoints: MovedWaypoints
    legs: Legs
    speeds: Floats
    seconds: float


def blended(world: World, waypoints: Floats, uav: UAV, tolerance: float) -> Trajectory:
    """Fly along straight legs at the UAV's limits, with blends at the bends.

    Parameters
    ----------
    world
        With the obstacles.
    waypoints
        (n, 3) metres, two of them apart: a path of straight legs that are free.
    uav
        A multirotor, whose limits are kept.
    tolerance
        How far the UAV may be from the path, metres.

    Returns
    -------
    Trajectory
        Cubic pieces, twice continuously differentiable. Its form is ``"stop-and-go"`` where the UAV has to stop at
        every bend.
    """
    path = without_repeats(waypoints)
    limits = limits_of(uav, -LIMIT_MARGIN, world.scenario.winds)
    best = blended_legs(world, path, limits, tolerance)
    flows = len(path) == 2 or bool(best.speeds.any())
    flown = trajectory_along(best.legs, best.speeds, "blended" if flows else "stop-and-go")
    for margin in (ZONE_MARGIN, tolerance):  # blends and legs that were moved are within the tolerance of the path
        if first_too_fast(world.speed_zones, flown) is None:
            break
        flown = _slow_in_zones(world, best, limits, tolerance, margin)
    return flown


def blended_legs(world: World, path: Floats, limits: Limits, tolerance: float) -> BlendedLegs:
    """Return legs along a path (n, 3), and the speeds at their corners, with which a flight of them is clear.

    The path is free and has no repeated waypoints; it is flown within the limits and the tolerance, metres. Where no
    blends are clear, the speeds are 0.
    """
    whole = MovedWaypoints(path, np.zeros(len(path)))
    first = best = _fit(world, whole, limits, tolerance) or _with_stops(path, limits)
    slow = np.maximum(first.speeds[:-1], first.speeds[1:]) < first.legs.speeds
    for share in MERGED_SHARES:
        merged = merge_bends(world.space, path, slow, share * tolerance)
        if len(merged.points) < len(path):
            best = _fit(world, merged, limits, tolerance, best.seconds) or best
    if slow.any():
        best = _fit(world, best.waypoints, limits, tolerance, best.seconds, in_pairs=True) or best
    return best


def _slow_in_zones(world: World, fit: BlendedLegs, limits: Limits, tolerance: float, margin: float) -> Trajectory:
    """Return a motion along the waypoints of another one that is slow within `margin` metres of zones."""
    points = fit.waypoints.points
    parts = cut_legs(world.speed_zones, points, limits, margin)
    slow = _fit(world, fit.waypoints, limits, tolerance, parts=parts) or _with_stops(points, limits, parts)
    flows = len(points) == 2 or bool(slow.speeds[parts.at_waypoint].any())
    return trajectory_along(slow.legs, slow.speeds, "blended" if flows else "stop-and-go")


def _fit(
    world: World,
    waypoints: MovedWaypoints,
    limits: Limits,
    tolerance: float,
    less_than: float = math.inf,
    parts: LegParts | None = None,
    *,
    in_pairs: bool = False,
) -> BlendedLegs | None:
    """Return a fast, clear motion along waypoints, or ``None``.

    There is none where it takes at least as many seconds as given, or where no smaller blends would make it clear. With
    parts of legs, the ends of the parts (m, 3) take the place of the waypoints, and the speed limit of each is kept.
    Where a corner was moved outwards and its leg is not clear, the leg's other corner is moved too if `in_pairs`, since
    that may take the leg past the obstacle; else the blend becomes smaller at once.
    """
    points, moved = waypoints
    parts = parts or whole_legs(points)
    ends = parts.ends(points)
    most = np.full(len(ends), math.inf)
    most[parts.at_waypoint] = tolerance - moved
    outside = np.zeros(len(ends), bool)
    shrinks = np.zeros(len(ends), int)
    straight, far = parts.legs(ends, limits), np.zeros(len(ends))
    shorter = np.minimum(np.r_[straight.lengths, np.inf], np.r_[np.inf, straight.lengths])
    turning = max(ADDED_TURNING, ADDED_SHARE * straight.sharpness.sum())
    for _ in range(MAX_ROUNDS):
        slope = 0.5 * turning / max(outside.sum(), 1)
        outward = np.minimum((1.0 - PASSING_SHARE) * most, slope * shorter)
        legs, speeds = straight, corner_speeds(straight, np.where(outside, outward, most))
        if outside.any():
            for _ in range(OUTWARD_ROUNDS):
                far = np.where(outside, blend_depths(legs, speeds), 0.0)
                passing = np.minimum(PASSING_SHARE * most, PASSING_SLOPE * shorter)
                corners = ends - np.where(outside, far + passing, 0.0)[:, None] * straight.turns
                legs = parts.legs(parts.ends(corners[parts.at_waypoint]), limits)
                speeds = corner_speeds(legs, np.where(outside, outward, most))
            speeds = corner_speeds(legs, np.where(outside, far, most))
        durations, rows, pieces = pieces_along(legs, speeds)
        if durations.sum() >= less_than:
            return None
        clear = clear_pieces(world.space, durations, rows)
        if clear.all():
            return BlendedLegs(waypoints, legs, speeds, float(durations.sum()))
        failed = _corners_at_fault(pieces[~clear], outside, parts, in_pairs)
        if not failed.any():
            return None
        again = failed & outside
        shrinks[again] += 1
        most[again] = np.where(shrinks[again] > MAX_SHRINKS, 0.0, SHRINK * far[again])
        outside = (outside | failed) & (most > 0.0)
    return None


def _with_stops(path: Floats, limits: Limits, parts: LegParts | None = None) -> BlendedLegs:
    """Return the motion along a path that stops at every bend."""
    parts = parts or whole_legs(path)
    legs = parts.legs(parts.ends(path), limits)
    speeds = corner_speeds(legs, np.where(parts.at_waypoint, 0.0, math.inf))
    return BlendedLegs(
        MovedWaypoints(path, np.zeros(len(path))), legs, speeds, float(pieces_along(legs, speeds)[0].sum())
    )


def _corners_at_fault(pieces: Ints, outside: Bools, parts: LegParts, in_pairs: bool) -> Bools:
    """Tell which corners, (n,), are to be changed where pieces of legs and blends are not clear.

    These are the corners of blends, and those at either end of a leg that were moved outwards, (n,); or, `in_pairs`,
    the other corner of a leg of which one was. The pieces are numbered as by `pieces_along`.
    """
    failed = np.zeros(len(outside), bool)
    failed[(pieces[pieces % 2 == 1] + 1) // 2] = True
    begins, ends = (corners[pieces[pieces % 2 == 0] // 2] for corners in parts.neighbours)
    lone = in_pairs & (outside[begins] != outside[ends]) & (begins > 0) & (ends < len(outside) - 1)
    for corners in (begins, ends):
        failed[corners] |= outside[corners] != lone
    return failed
