"""Where a UAV's nose points: along its course, at a point or in one direction, no faster than it may turn."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats
from skyverse.model.arrays import arctan2
from skyverse.model.trajectory import Pointing, Trajectory, spread_turns, wrapped
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import STRAIGHT_COURSE

SAMPLES = 16
"""Instants of each piece of a trajectory at which its course is taken."""
MIN_COURSE_SPEED = 0.1
"""m/s seen from above: a slower UAV hovers, climbs or turns back, and has no course."""
MIN_SIGHT = 0.1
"""Metres seen from above: from a nearer place there is no direction to a point."""
STEP = math.radians(2.0)
"""The turn, rad, in which the course's changes are gathered."""
MAX_AIM_ERROR = math.radians(5.0)
"""The angle, rad, between nose and place to look at above which a trajectory's note tells it."""
SHORTEST_SPREAD = 0.2
"""Seconds over which each turn is spread at least."""


class HeldYaw(NamedTuple):
    """A yaw, rad, that is wanted between two instants, and how long before and after the nose turns, seconds."""

    begin: float
    end: float
    yaw: float
    turn: float


def with_heading(trajectory: Trajectory, uav: UAV, held: Sequence[HeldYaw] = ()) -> Trajectory:
    """Return a trajectory with where the UAV's nose and camera point, within its limits on the yaw.

    By default the nose points along the course seen from above; with `uav.look_at`, at that point, and with
    `uav.heading`, that way. Where there is no course, as in a hover or a vertical climb, the heading is kept, and a
    turn from one course to the next is made half before and half after the middle of that time. Where the limits keep
    the nose off `uav.look_at`, the trajectory's note says by how much. While a yaw is `held`, the nose points there.
    """
    instants = trajectory.instants(SAMPLES)
    edges = [t for begin, end, _, turn in held for t in (begin - turn, begin, end, end + turn)]
    instants = np.union1d(instants, np.clip(edges, trajectory.start, trajectory.end)) if held else instants
    known, courses = wanted_yaws(trajectory, instants, uav)
    yaws = np.zeros(len(instants))
    yaws[known] = courses
    for begin, end, yaw, turn in held:
        within = (instants >= begin) & (instants <= end)
        known &= (instants <= begin - turn) | (instants >= end + turn)
        known, yaws = known | within, np.where(within, yaw, yaws)
    courses = yaws[known]
    at = instants[known]
    when, turns = _gathered(at, wrapped(np.diff(courses)))
    rate, acceleration = math.radians(uav.max_yaw_rate), math.radians(uav.max_yaw_acceleration)
    if uav.fixed_wing is not None:  # its course is its heading
        rate = acceleration = math.inf
    spread, rise = spread_turns(when, turns, rate, acceleration, SHORTEST_SPREAD)
    first = float(courses[0]) if len(courses) else 0.0
    told = replace(trajectory, pointing=Pointing(first, when, turns, spread, rise, uav.look_at))
    if uav.look_at is None:
        return told
    off = float(np.abs(wrapped(told.heading(at).yaw - courses)).max(initial=0.0))
    if off <= MAX_AIM_ERROR:
        return told
    note = f"Its limits on the yaw keep its nose up to {math.degrees(off):.0f} degrees off the place to look at."
    return replace(told, note=f"{trajectory.note} {note}".strip())


def wanted_yaws(trajectory: Trajectory, instants: Floats, uav: UAV) -> tuple[Bools, Floats]:
    """Return at which of m instants there is a direction for the nose, (m,), and the yaw at these k, (k,) rad."""
    if uav.heading is not None:
        return np.ones(len(instants), bool), np.full(len(instants), math.radians(90.0 - uav.heading))
    motion = trajectory.at(instants)
    way, least = motion.velocity, MIN_COURSE_SPEED
    if uav.look_at is not None:
        way, least = np.array(uav.look_at) - motion.position, MIN_SIGHT
    known = np.hypot(way[:, 0], way[:, 1]) > least
    return known, arctan2(way[known, 1], way[known, 0])


def _gathered(at: Floats, changes: Floats) -> tuple[Floats, Floats]:
    """Return the changes (n,) of a course between instants (n + 1,) as fewer turns: their instants and sizes."""
    when, turns, turn, begun = [], [], 0.0, 0
    for k, change in enumerate(changes.tolist()):
        if turn == 0.0:
            begun = k
        turn += change
        straight = abs(change) < STRAIGHT_COURSE or k == len(changes) - 1
        if abs(turn) >= STEP or (straight and abs(turn) >= STRAIGHT_COURSE):
            when.append(0.5 * (at[begun] + at[k + 1]))
            turns.append(turn)
            turn = 0.0
    return np.array(when), np.array(turns)
