"""Trajectories that are what was planned: straight along the path, with a blend at each bend that needs no stop.

A blend first cuts its corner on the inside. Where an obstacle is there, as at every bend of a shortest path, the corner
is moved outwards by as much as the blend cuts off, so that the UAV flies through the path's own bend, or past it on the
outside. Where that is not clear either, the blend becomes smaller, and at last the UAV stops at the bend. Two bends
that are so near each other that they slow the UAV down are replaced by the point at which the legs before and after
them meet.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import LIMIT_MARGIN, MIN_CROSS_PRODUCT
from skyverse.space.world import World, segment_free
from skyverse.trajectory.leg_parts import ZONE_MARGIN, LegParts, cut_legs, whole_legs
from skyverse.trajectory.limits import Limits, limits_of
from skyverse.trajectory.proof import clear_pieces
from skyverse.trajectory.speed_in_zones import first_too_fast
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
SHRINK = 0.5
"""The factor by which a blend is made smaller."""
OUTWARD_ROUNDS = 3
"""How often corners are moved outwards in a round, since the path turns more sharply at a corner that is moved."""
ADDED_TURNING = math.radians(10.0)
"""Radians by which a flight may turn more than its path, about, as corners that are moved outwards are sharper."""
PASSING_SHARE = 0.25
"""The share of the tolerance by which the UAV passes outside of a bend, so that autopilots may cut corners there."""
PASSING_SLOPE = 0.01
"""The same distance at most as a share of the legs beside the bend, so that they hardly change their directions."""
MERGED_SHARE = 0.5
"""The share of the tolerance by which a point in place of two bends may be off the path; the rest is for its blend."""


class _Fit(NamedTuple):
    """A motion along waypoints.

    Attributes
    ----------
    points
        (n, 3) the waypoints, metres.
    moved
        (n,) how far these are from the path at most, metres.
    legs
        The legs between the corners, which may lie outside of the waypoints.
    speeds
        (n,) at the corners, m/s.
    seconds
        How long it takes.
    """

    points: Floats
    moved: Floats
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
    limits = limits_of(uav, -LIMIT_MARGIN)
    best = _fit(world, path, np.zeros(len(path)), limits, tolerance) or _with_stops(path, limits)
    leg = 1
    while leg < len(best.points) - 2:
        merged = _merged(best, leg, MERGED_SHARE * tolerance)
        if merged is not None and all(segment_free(world.space, *merged[0][k : k + 2]) for k in (leg - 1, leg)):
            tried = _fit(world, *merged, limits, tolerance, best.seconds)
            if tried is not None:
                best, leg = tried, max(leg - 1, 1)
                continue
        leg += 1
    flows = len(path) == 2 or bool(best.speeds.any())
    flown = trajectory_along(best.legs, best.speeds, "blended" if flows else "stop-and-go")
    for margin in (ZONE_MARGIN, tolerance):  # blends and legs that were moved are within the tolerance of the path
        if first_too_fast(world.speed_zones, flown) is None:
            break
        flown = _slow_in_zones(world, best, limits, tolerance, margin)
    return flown


def _slow_in_zones(world: World, fit: _Fit, limits: Limits, tolerance: float, margin: float) -> Trajectory:
    """Return a motion along the waypoints of another one that is slow within `margin` metres of zones."""
    parts = cut_legs(world.speed_zones, fit.points, limits, margin)
    slow = _fit(world, fit.points, fit.moved, limits, tolerance, parts=parts) or _with_stops(fit.points, limits, parts)
    flows = len(fit.points) == 2 or bool(slow.speeds[parts.at_waypoint].any())
    return trajectory_along(slow.legs, slow.speeds, "blended" if flows else "stop-and-go")


def _fit(
    world: World,
    points: Floats,
    moved: Floats,
    limits: Limits,
    tolerance: float,
    less_than: float = math.inf,
    parts: LegParts | None = None,
) -> _Fit | None:
    """Return a fast, clear motion along waypoints (n, 3) that are (n,) metres from the path, or ``None``.

    There is none where it takes at least as many seconds as given, or where no smaller blends would make it clear. With
    parts of legs, the ends of the parts (m, 3) take the place of the waypoints, and the speed limit of each is kept.
    """
    parts = parts or whole_legs(points)
    ends = parts.ends(points)
    most = np.full(len(ends), math.inf)
    most[parts.at_waypoint] = tolerance - moved
    outside = np.zeros(len(ends), bool)
    shrinks = np.zeros(len(ends), int)
    straight, far = parts.legs(ends, limits), np.zeros(len(ends))
    shorter = np.minimum(np.r_[straight.lengths, np.inf], np.r_[np.inf, straight.lengths])
    for _ in range(MAX_ROUNDS):
        slope = 0.5 * ADDED_TURNING / max(outside.sum(), 1)
        outward = np.minimum((1.0 - PASSING_SHARE) * most, slope * shorter)
        legs, speeds = straight, corner_speeds(straight, np.where(outside, outward, most))
        if outside.any():
            for _ in range(OUTWARD_ROUNDS):
                far = np.where(outside, blend_depths(legs, speeds), 0.0)
                passing = np.minimum(PASSING_SHARE * most, PASSING_SLOPE * shorter)
                corners = ends - np.where(outside, far + passing, 0.0)[:, None] * straight.turns
                legs = parts.legs(parts.ends(corners[parts.at_waypoint]), limits)
                speeds = corner_speeds(legs, np.where(outside, far, most))
        durations, rows, pieces = pieces_along(legs, speeds)
        if durations.sum() >= less_than:
            return None
        clear = clear_pieces(world.space, durations, rows)
        if clear.all():
            return _Fit(points, moved, legs, speeds, float(durations.sum()))
        failed = _corners_at_fault(pieces[~clear], outside, parts)
        if not failed.any():
            return None
        again = failed & outside
        shrinks[again] += 1
        most[again] = np.where(shrinks[again] > MAX_SHRINKS, 0.0, SHRINK * far[again])
        outside = (outside | failed) & (most > 0.0)
    return None


def _with_stops(path: Floats, limits: Limits, parts: LegParts | None = None) -> _Fit:
    """Return the motion along a path that stops at every bend."""
    parts = parts or whole_legs(path)
    legs = parts.legs(parts.ends(path), limits)
    speeds = corner_speeds(legs, np.where(parts.at_waypoint, 0.0, math.inf))
    return _Fit(path, np.zeros(len(path)), legs, speeds, float(pieces_along(legs, speeds)[0].sum()))


def _corners_at_fault(pieces: Ints, outside: Bools, parts: LegParts) -> Bools:
    """Tell which corners, (n,), are to be changed where pieces of legs and blends are not clear.

    These are the corners of blends, and those at either end of a leg that were moved outwards, (n,). The pieces are
    numbered as by `pieces_along`.
    """
    failed = np.zeros(len(outside), bool)
    failed[(pieces[pieces % 2 == 1] + 1) // 2] = True
    for ends in parts.neighbours:
        corners = ends[pieces[pieces % 2 == 0] // 2]
        failed[corners] |= outside[corners]
    return failed


def _merged(fit: _Fit, leg: int, most: float) -> tuple[Floats, Floats] | None:
    """Return waypoints with a point in place of both ends of a leg, and how far they are from the path at most.

    The point is the one at which the legs before and after meet when they are made longer; where they pass each other
    it is moved outwards by the distance between them. ``None`` where they do not meet, or too far from the path.
    """
    points = fit.points
    before, after = points[leg] - points[leg - 1], points[leg + 1] - points[leg + 2]
    gap = points[leg + 1] - points[leg]
    mixed, squares = before @ after, (before @ before, after @ after)
    determinant = squares[0] * squares[1] - mixed * mixed
    if determinant <= MIN_CROSS_PRODUCT * squares[0] * squares[1]:
        return None
    on = (squares[1] * (before @ gap) - mixed * (after @ gap)) / determinant
    back = (mixed * (before @ gap) - squares[0] * (after @ gap)) / determinant
    if on < 0.0 or back < 0.0:
        return None
    ahead, behind = points[leg] + on * before, points[leg + 1] + back * after
    meeting = 0.5 * (ahead + behind)
    share = float((meeting - points[leg]) @ gap / (gap @ gap))
    outward = meeting - points[leg] - share * gap
    away, apart = float(np.linalg.norm(outward)), float(np.linalg.norm(ahead - behind))
    moved = float(fit.moved[leg : leg + 2].max()) + away + apart
    if not 0.0 <= share <= 1.0 or away == 0.0 or moved > most:
        return None
    meeting += apart / away * outward
    rest = slice(leg + 2, None)
    return np.vstack([points[:leg], meeting, points[rest]]), np.r_[fit.moved[:leg], moved, fit.moved[rest]]
