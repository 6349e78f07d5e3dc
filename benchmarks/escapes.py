"""Whether a UAV that touched a mover could have avoided that, had it known everything since it first saw the mover.

This is decided by a tree of motions, far more than a replanner tries: from each instant since then to the contact, the
fastest stop, and motions in many directions, at many speeds, some of which turn once more. One that keeps clear of all
that truly moves and stands for some seconds beyond the contact is an escape. So an escape that is found exists; where
none is found, none may exist.
"""

import numpy as np

import skyverse as sky
from skyverse.live import braking_motion, steered_motion
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.problem import Airspace
from skyverse.space.contact import first_contact
from skyverse.space.timed_shapes import moving_shapes, timed_parts
from skyverse.trajectory.limits import limits_of
from skyverse.trajectory.proof import clear_pieces

BEYOND = 1.0
"""Seconds beyond the contact for which an escape must be clear."""
STEP = 0.1
"""Seconds between the instants at which escapes begin."""
DIRECTIONS = 60
SPEEDS = (1.0, 0.6, 0.3)


def directions() -> np.ndarray:
    """Return unit vectors that are spread evenly over a sphere."""
    k = np.arange(DIRECTIONS) + 0.5
    up, turn = 1.0 - 2.0 * k / DIRECTIONS, np.pi * (1.0 + 5.0**0.5) * k
    level = np.sqrt(1.0 - up * up)
    return np.column_stack([level * np.cos(turn), level * np.sin(turn), up])


def contacts(replanner: sky.Replanner, truth: sky.Scenario, sensor: sky.Sensor) -> str:
    """Return ``"escape"`` if a UAV touches a mover that it could have avoided, ``"no escape"`` if not, else ``""``."""
    airspace = Airspace(truth)
    shapes, said = timed_parts(truth), ""
    for uav, vehicle in enumerate(truth.uavs):
        flown = replanner.flown(uav)
        moving = moving_shapes(shapes, vehicle.tracking_error)
        who, when = first_contact(moving, flown.knots, flown.coefficients, vehicle.max_speed, flown.start, flown.end)
        if who < 0:
            continue
        since = _first_seen(flown, truth.movers[who], sensor, when)
        limits, world = limits_of(vehicle, -LIMIT_MARGIN), airspace.of(uav).world
        if not any(
            _escapes(flown, moving, world.space, limits, begin, when + BEYOND)
            for begin in np.arange(since + replanner.lead, when, STEP)
        ):
            said = said or "no escape"
        else:
            return "escape"
    return said


def _first_seen(flown: sky.Trajectory, mover: sky.Mover, sensor: sky.Sensor, until: float) -> float:
    """Return the first instant since when a mover has been within range without a break, up to a contact."""
    instants = np.arange(0.0, until, 1.0 / sensor.rate)
    far = np.linalg.norm(flown.at(instants).position - mover.at(instants), axis=1) > sensor.reach
    return float(instants[np.flatnonzero(far)[-1] + 1]) if far.any() and not far[-1] else 0.0


def _escapes(flown, shapes, space, limits, begin: float, until: float) -> bool:
    state = np.concatenate(flown.at([begin]))
    seconds = until - begin
    tries = [braking_motion(state, limits)]
    for to in directions():
        for share in SPEEDS:
            for reach in (0.5, 1.5, limits.speed * seconds):
                points = (state[0] + reach * to)[None]
                made = steered_motion(state, points, np.zeros(1), limits, share, seconds, 0.5 * seconds)
                tries.append(made[:2])
    for durations, rows in tries:
        if not len(durations):
            continue
        knots = begin + np.append(0.0, np.cumsum(durations))
        who, _ = first_contact(shapes, knots, rows, limits.speed, begin, until)
        if who < 0 and clear_pieces(space, durations, rows).all():
            return True
    return False
