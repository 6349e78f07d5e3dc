"""Motions that lead a UAV back to where nothing is too near, if it was found where it may not be."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import LIMIT_EASE
from skyverse.space.world import World
from skyverse.trajectory.proof import clear_pieces

SAMPLES = 8
"""Instants of each piece at which it is looked at how near to obstacles and bounds it leads."""
NEARER = 0.01
"""Metres by which a UAV may come nearer to an obstacle, or farther out of bounds, than it is."""


def way_back(world: World, durations: Floats, rows: Floats) -> tuple[float, float]:
    """Return how a motion leads to where it is clear of what stands still, and slow enough in zones.

    Parameters
    ----------
    world
        What stands still.
    durations, rows
        Pieces of (m,) seconds, and their coefficients (m, k, 3), metres.

    Returns
    -------
    seconds
        After which it is so for good, infinite if it never is.
    missing
        Metres that it lacks where it ends: infinite if it first leads nearer to obstacles or farther out of bounds, or
        ends no nearer to where it is clear.
    """
    if not len(durations):
        return math.inf, math.inf
    clear = clear_pieces(world.space, durations, rows)
    knots = np.append(0.0, np.cumsum(durations))
    slow = _seconds_too_fast(world, Trajectory(knots, rows))
    if clear.all():
        return slow, 0.0
    count = len(clear) - int(np.argmin(clear[::-1]))  # pieces up to the last one that is not clear
    steps = np.arange(SAMPLES + 1) / SAMPLES
    t = (knots[:count, None] + durations[:count, None] * steps).ravel()
    places = Trajectory(knots, rows).at(t).position
    inside = np.minimum(places - world.space.low, world.space.high - places).min(axis=1)
    before = missing = 0.0
    for left, need in ((world.distance(places), world.space.clearance), (inside, 0.0)):
        if left.min() < min(left[0], need) - NEARER:
            return math.inf, math.inf
        before, missing = before + max(need - left[0], 0.0), missing + max(need - left[-1], 0.0)
    if clear[-1]:
        return max(float(knots[count]), slow), 0.0
    return math.inf, missing if missing < before - NEARER else math.inf


def _seconds_too_fast(world: World, motion: Trajectory) -> float:
    """Return the last of the instants that are looked at when a motion, from 0 s on, is too fast for a zone; else 0."""
    if not world.speed_zones:
        return 0.0
    t = np.unique(np.linspace(motion.knots[:-1], motion.knots[1:], SAMPLES + 1))
    places, velocities, _ = motion.at(t)
    speeds, last = np.linalg.norm(velocities, axis=1), 0.0
    for now, place, speed in zip(t.tolist(), places, speeds.tolist(), strict=True):
        if any(speed > zone.max_speed * (1.0 + LIMIT_EASE) and zone.holds(place) for zone in world.speed_zones):
            last = now
    return last
