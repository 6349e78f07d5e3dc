"""What a UAV is flying: a motion that ends at rest, the way that it follows, and how long it is proven.

The mission's own trajectory, followed for as long as the UAV can still come to rest by the horizon.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.guidance import Way
from skyverse.live.steered_motion import braking_motion
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import ACCELERATION_LEFT, MIN_PIECE
from skyverse.trajectory.limits import Limits

STAY = 1.0
"""Seconds of the motion of a UAV that stays where it is."""


@dataclass(frozen=True)
class Course:
    """What a UAV is flying.

    Attributes
    ----------
    flown
        The motions flown before `motion` begins, one after another.
    motion
        From some instant before now to rest.
    way, passed
        The way that it follows, and the instants at which its points are passed, (n,) seconds, infinite for those that
        it does not reach.
    ahead
        The next point of the guidance to fly to, apart from those of the way.
    leaves
        The instant at which `motion` leaves the mission's own trajectory; minus infinity if it has left it already.
    """

    flown: tuple[Trajectory, ...]
    motion: Trajectory
    way: Way
    passed: Floats
    ahead: int
    leaves: float = -math.inf

    def state(self, t: float) -> Floats:
        """Return position, velocity and acceleration at an instant, (3, 3)."""
        return np.concatenate(self.motion.at([t]))

    def remaining(self, t: float) -> Way:
        """Return the points of the way that are not yet passed at an instant."""
        return self.way.after(int(np.sum(self.passed <= t)))

    def next_mark(self, t: float) -> int:
        """Return the next point of the guidance to fly to at an instant."""
        passed = self.way.marks[self.passed <= t]
        return max(self.ahead, int(passed.max(initial=-1)) + 1)

    def ramp_end(self, t: float, until: float) -> float | None:
        """Return the first instant after `t`, up to `until`, at which a UAV accelerates no more; ``None`` if none."""
        knots, rows = self.motion.knots, self.motion.coefficients
        for k in range(1, len(rows)):
            if t < knots[k] <= until and math.hypot(*rows[k, 2]) <= ACCELERATION_LEFT:
                return float(knots[k])
        return None

    def since(self, now: float) -> "Course":
        """Return the same course, of which the pieces that end before now are counted as flown."""
        past, motion = parted(self.motion, now)
        if past is None:
            return self
        return replace(self, flown=(*self.flown, past), motion=motion)

    def part(self, begin: float, end: float) -> tuple[Floats, Floats]:
        """Return what is flown between two instants: pieces of (m,) seconds, and coefficients (m, k, 3), metres."""
        motion = hovering(self.motion, end)
        knots, last = motion.knots, int(np.searchsorted(motion.knots, end, side="left"))
        first = min(max(int(np.searchsorted(knots, begin, side="right")) - 1, 0), last)
        rows = motion.coefficients[first:last].copy()
        if len(rows):
            rows[0] = later(rows[0], max(begin - knots[first], 0.0))
        return np.diff(np.clip(knots[first : last + 1], begin, end)), rows

    def stopping(self, t: float, limits: Limits) -> "Course":
        """Return the course that stops as fast as possible from an instant on."""
        durations, rows = stop_or_stay(self.state(t), limits)
        way = self.remaining(t)
        return self.joined(t, durations, rows, way, np.full(len(way.points), np.inf))

    def stop(self, t: float, limits: Limits) -> Floats:
        """Return where the UAV comes to rest if it brakes from an instant on, (3,) metres."""
        durations, rows = stop_or_stay(self.state(t), limits)
        return Trajectory(np.append(0.0, np.cumsum(durations)), rows).at([durations.sum()]).position[0]

    def restarted(self, t: float, state: Floats, limits: Limits) -> "Course":
        """Return the course of a UAV that brakes from a state (3, 3), where it was found to be at an instant."""
        durations, rows = stop_or_stay(state, limits)
        past = self.joined(t, np.zeros(0), np.zeros((0, 4, 3)), self.way, self.passed)
        flown = (*self.flown, past.motion) if len(past.motion.coefficients) else self.flown
        knots = t + np.append(0.0, np.cumsum(durations))
        passed = np.where(self.passed <= t, self.passed, np.inf)
        return replace(self, flown=flown, motion=Trajectory(knots, rows), passed=passed, leaves=-math.inf)

    def guided_by(self, guidance: Way) -> "Course":
        """Return the same course of a UAV that follows another guidance from now on."""
        never = np.full(len(guidance.points) - 1, np.inf)
        return replace(self, way=guidance.after(1), passed=never, ahead=1, leaves=-math.inf)

    def joined(
        self, t: float, durations: Floats, rows: Floats, way: Way, passed: Floats, leaves: float = -math.inf
    ) -> "Course":
        """Return the course that leaves this one at an instant, with pieces (m,) seconds and (m, k, 3) metres."""
        motion = hovering(self.motion, t) if t > self.motion.end else self.motion
        both = spliced(motion, t, durations, rows)
        return replace(self, motion=both, way=way, passed=passed, ahead=self.next_mark(t), leaves=leaves)


def stop_or_stay(state: Floats, limits: Limits) -> tuple[Floats, Floats]:
    """Return the fastest stop from a state (3, 3), or a stay where that is at rest, as `braking_motion` does."""
    durations, rows = braking_motion(state, limits)
    if len(durations):
        return durations, rows
    durations, rows = np.array([STAY]), np.zeros((1, 4, 3))
    rows[0, 0] = state[0]
    return durations, rows


def parted(motion: Trajectory, now: float) -> tuple[Trajectory | None, Trajectory]:
    """Return the pieces of a motion that end before now, ``None`` if there are none, and those that follow."""
    k = int(np.searchsorted(motion.knots, now, side="right")) - 1
    if not 0 < k < len(motion.coefficients):
        return None, motion
    past = Trajectory(motion.knots[: k + 1], motion.coefficients[:k])
    return past, Trajectory(motion.knots[k:], motion.coefficients[k:])


def spliced(motion: Trajectory, t: float, durations: Floats, rows: Floats) -> Trajectory:
    """Return the motion that leaves another at an instant, with pieces (m,) seconds and (m, k, 3) metres."""
    k = int(np.searchsorted(motion.knots, t, side="left"))  # pieces before the instant
    if k and t - motion.knots[k - 1] <= MIN_PIECE:
        k -= 1
    knots, kept = np.append(motion.knots[:k], t), motion.coefficients[:k]
    pieces = np.concatenate(of_one_degree(kept, rows))
    return Trajectory(np.concatenate([knots, t + np.cumsum(durations)]), pieces)


def hovering(motion: Trajectory, until: float) -> Trajectory:
    """Return a motion that stays where it ends until an instant."""
    if until - motion.end <= MIN_PIECE:
        return motion
    stay = np.zeros((1, *motion.coefficients.shape[1:]))
    stay[0, 0] = motion.at([motion.end]).position[0]
    return Trajectory(np.append(motion.knots, until), np.concatenate([motion.coefficients, stay]))


def of_one_degree(*parts: Floats) -> list[Floats]:
    """Return the coefficients of pieces, each (m, k, 3), padded by zeros to the largest degree of any of them."""
    most = max(part.shape[1] for part in parts)
    return [
        np.pad(part, ((0, 0), (0, most - part.shape[1]), (0, 0))) if part.shape[1] < most else part for part in parts
    ]


def later(rows: Floats, seconds: float) -> Floats:
    """Return the coefficients (k, 3) of a polynomial whose time begins some seconds later."""
    shifted = rows.copy()
    for i in range(len(rows) - 1):
        for j in range(len(rows) - 2, i - 1, -1):
            shifted[j] += seconds * shifted[j + 1]
    return shifted


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
