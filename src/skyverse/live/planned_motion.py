"""The mission's own trajectory, followed for as long as the UAV can still come to rest by the horizon."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.change_of_velocity import braking_motion
from skyverse.live.course import later, of_one_degree
from skyverse.live.guidance import Way
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import MIN_PIECE
from skyverse.trajectory.limits import Limits


class Planned(NamedTuple):
    """What a UAV flies if nothing is met: the mission's trajectory.

    Attributes
    ----------
    motion
        The trajectory.
    passed
        (n,) seconds into the mission at which it is nearest to each point of the guidance, apart from the first.
    """

    motion: Trajectory
    passed: Floats


FOLLOWED = (1.0, 0.75, 0.5, 0.25)
"""Shares of the longest time for which the mission's trajectory can be followed, that are tried."""
ROUNDS, SOONER = 12, 0.02
"""How often an earlier instant to brake is tried, and by how many seconds it is earlier at least."""
SAMPLE = 0.05
"""Seconds between the instants at which it is looked for where a trajectory is nearest to a point."""


def planned_motion(motion: Trajectory | None, guidance: Way) -> Planned | None:
    """Return a mission's trajectory, and when it passes the points of a guidance, one after another."""
    if motion is None:
        return None
    instants = np.append(np.arange(motion.start, motion.end, SAMPLE), motion.end)
    places, first, passed = motion.at(instants).position, 0, []
    for point in guidance.points[1:]:
        first += int(np.argmin(np.linalg.norm(places[first:] - point, axis=1)))
        passed.append(float(instants[first]))
    return Planned(motion, np.array(passed))


def motions_along(
    planned: Trajectory, begin: float, until: float, limits: Limits
) -> Iterator[tuple[float, Floats, Floats]]:
    """Yield motions that follow a trajectory from an instant on, and then brake so as to rest in time.

    Parameters
    ----------
    planned
        The mission's trajectory; before it begins the UAV stays where it does.
    begin, until
        Seconds into the mission between which the motion lies.
    limits
        Those of a multirotor.

    Yields
    ------
    tuple
        The instant at which the trajectory is left, seconds; and pieces of (m,) seconds and (m, degree + 1, 3) metres,
        by powers of the time since the piece began. Those that follow it longest come first.
    """
    if planned.end <= until:
        yield planned.end, *followed(planned, begin, planned.end)
        return
    last = _last_to_brake(planned, begin, until, limits)
    if last is None:
        return
    for share in FOLLOWED:
        leaves = begin + share * (last - begin)
        durations, rows = followed(planned, begin, leaves)
        brakes, more = braking_motion(_state(planned, leaves), limits)
        yield leaves, np.append(durations, brakes), np.concatenate(of_one_degree(rows, more))


def _state(planned: Trajectory, t: float) -> Floats:
    return np.concatenate(planned.at([t]))


def _last_to_brake(planned: Trajectory, begin: float, until: float, limits: Limits) -> float | None:
    """Return the last instant found from which the UAV comes to rest in time, or ``None``."""
    leaves = until
    for _ in range(ROUNDS):
        durations, _ = braking_motion(_state(planned, leaves), limits)
        if leaves + durations.sum() <= until:
            return leaves
        leaves = min(until - float(durations.sum()), leaves - SOONER)
        if leaves <= begin:
            break
    return None


def followed(planned: Trajectory, begin: float, end: float) -> tuple[Floats, Floats]:
    """Return the pieces of a trajectory between two instants, and of the stay before it begins."""
    durations, rows = [], []
    if begin < planned.start - MIN_PIECE:
        stay = np.zeros(planned.coefficients.shape[1:])
        stay[0] = planned.coefficients[0, 0]
        durations.append(min(end, planned.start) - begin)
        rows.append(stay)
    for k, coefficients in enumerate(planned.coefficients):
        since, until = max(begin, float(planned.knots[k])), min(end, float(planned.knots[k + 1]))
        if until - since > MIN_PIECE:
            durations.append(until - since)
            rows.append(later(coefficients, since - float(planned.knots[k])))
    return np.array(durations), np.array(rows).reshape(-1, *planned.coefficients.shape[1:])
