"""What a UAV is flying: a motion that ends at rest, the way that it follows, and how long it is proven.

At first it follows the mission's own trajectory, for as long as the UAV can still come to rest by the horizon.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from skyverse._typing import Floats
from skyverse.live.guidance import Way
from skyverse.live.steered_motion import braking_motion
from skyverse.model.trajectory import Form, Trajectory
from skyverse.numerics.tolerances import ACCELERATION_LEFT, MIN_PIECE
from skyverse.trajectory.limits import Limits

STAY = 1.0
"""Seconds of the motion of a UAV that stays where it is."""


@dataclass(frozen=True)
class AnyCourse:
    """What any UAV is flying.

    Attributes
    ----------
    flown
        The motions flown before `motion` begins, one after another.
    motion
        From some instant before now on.
    """

    flown: tuple[Trajectory, ...]
    motion: Trajectory

    def since(self, now: float) -> Self:
        """Return the same course, of which the pieces that end before now are counted as flown."""
        past, motion = parted(self.motion, now)
        return replace(self, flown=(*self.flown, *past), motion=motion)

    def state(self, t: float) -> Floats:
        """Return position, velocity and acceleration at an instant, also one at which it flew before, (3, 3)."""
        past = reversed(self.flown if t < self.motion.start else ())
        return state_at(next((one for one in past if one.start <= t), self.motion), t)


@dataclass(frozen=True)
class Course(AnyCourse):
    """What a multirotor is flying, to rest.

    Attributes
    ----------
    way, passed
        The way that it follows, and the instants at which its points are passed, (n,) seconds, infinite for those that
        it does not reach.
    ahead
        The next point of the guidance to fly to, apart from those of the way.
    leaves
        The instant at which `motion` leaves the mission's own trajectory; minus infinity if it has left it already.
    """

    way: Way
    passed: Floats
    ahead: int
    leaves: float = -math.inf

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

    def stop(self, t: float, limits: Limits) -> Floats:
        """Return where the UAV comes to rest if it brakes from an instant on, (3,) metres."""
        return place_of_rest(stopping(self.state(t), t, limits))

    def restarted(self, t: float, state: Floats, limits: Limits) -> "Course":
        """Return the course of a UAV that brakes from a state (3, 3), where it was found to be at an instant."""
        past = part_of(self.motion, self.motion.start, t)
        flown = (*self.flown, past) if len(past.coefficients) else self.flown
        passed = np.where(self.passed <= t, self.passed, np.inf)
        return replace(self, flown=flown, motion=stopping(state, t, limits), passed=passed, leaves=-math.inf)

    def guided_by(self, guidance: Way) -> "Course":
        """Return the same course of a UAV that follows another guidance from now on."""
        never = np.full(len(guidance.points) - 1, np.inf)
        return replace(self, way=guidance.after(1), passed=never, ahead=1, leaves=-math.inf)

    def joined(self, motion: Trajectory, way: Way, passed: Floats, leaves: float = -math.inf) -> "Course":
        """Return the course that leaves this one for a motion when that begins."""
        ahead = self.next_mark(motion.start)
        return replace(self, motion=spliced(self.motion, motion), way=way, passed=passed, ahead=ahead, leaves=leaves)


def timed(begin: float, durations: Floats, rows: Floats, form: Form = "stop-and-go") -> Trajectory:
    """Return the motion that begins at an instant, of pieces (m,) seconds and (m, k, 3) metres."""
    return Trajectory(begin + np.append(0.0, np.cumsum(durations)), rows, form)


def state_at(motion: Trajectory, t: float) -> Floats:
    """Return position, velocity and acceleration at an instant of a motion, (3, 3)."""
    return np.concatenate(motion.at([t]))


def place_of_rest(motion: Trajectory) -> Floats:
    """Return where a motion ends, (3,) metres."""
    return motion.at([motion.end]).position[0]


def staying(place: Floats, begin: float, end: float) -> Trajectory:
    """Return the stay at a place (3,) between two instants."""
    return Trajectory(np.array([begin, end]), place[None, None])


def stopping(state: Floats, t: float, limits: Limits) -> Trajectory:
    """Return the fastest stop from a state (3, 3) at an instant, or a stay where that is at rest."""
    motion = timed(t, *braking_motion(state, limits))
    return motion if len(motion.coefficients) else staying(state[0], t, t + STAY)


def parted(motion: Trajectory, now: float) -> tuple[list[Trajectory], Trajectory]:
    """Return the pieces of a motion that end before now, as one motion if there are any, and those that follow."""
    k = int(np.searchsorted(motion.knots, now, side="right")) - 1
    if not 0 < k < len(motion.coefficients):
        return [], motion
    past = Trajectory(motion.knots[: k + 1], motion.coefficients[:k], motion.form)
    return [past], Trajectory(motion.knots[k:], motion.coefficients[k:], motion.form)


def spliced(motion: Trajectory, more: Trajectory) -> Trajectory:
    """Return the motion that leaves another one for a motion when that begins."""
    kept = part_of(motion, min(motion.start, more.start), more.start)
    most = max(kept.coefficients.shape[1], more.coefficients.shape[1])
    rows = [np.pad(one.coefficients, ((0, 0), (0, most - one.coefficients.shape[1]), (0, 0))) for one in (kept, more)]
    return Trajectory(np.append(kept.knots[:-1], more.knots), np.concatenate(rows), motion.form)


def part_of(motion: Trajectory, begin: float, end: float) -> Trajectory:
    """Return what is flown of a motion between two instants, with the stays before it begins and after it ends."""
    knots, rows = motion.knots, motion.coefficients
    stays = np.zeros((2, 1, *rows.shape[1:]))
    if begin < motion.start - MIN_PIECE:
        stays[0, 0, 0] = rows[0, 0]
        knots, rows = np.append(begin, knots), np.concatenate([stays[0], rows])
    if end > motion.end + MIN_PIECE:
        stays[1, 0, 0] = place_of_rest(motion)
        knots, rows = np.append(knots, end), np.concatenate([rows, stays[1]])
    clipped = np.clip(knots, begin, end)
    pieces = np.flatnonzero(np.diff(clipped) > MIN_PIECE)
    rows = rows[pieces]
    if len(pieces):
        rows[0] = _later(rows[0], clipped[pieces[0]] - knots[pieces[0]])
    return Trajectory(np.append(clipped[pieces], end), rows, motion.form)


def _later(rows: Floats, seconds: float) -> Floats:
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
) -> Iterator[tuple[float, Trajectory]]:
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
        The instant at which the trajectory is left, seconds, and the motion. Those that follow it longest come first.
    """
    if planned.end <= until:
        yield planned.end, part_of(planned, begin, planned.end)
        return
    last = _last_to_brake(planned, begin, until, limits)
    if last is None:
        return
    for share in FOLLOWED:
        leaves = begin + share * (last - begin)
        brakes = timed(leaves, *braking_motion(state_at(planned, leaves), limits))
        yield leaves, spliced(part_of(planned, begin, leaves), brakes)


def _last_to_brake(planned: Trajectory, begin: float, until: float, limits: Limits) -> float | None:
    """Return the last instant found from which the UAV comes to rest in time, or ``None``."""
    leaves = until
    for _ in range(ROUNDS):
        seconds = braking_motion(state_at(planned, leaves), limits)[0].sum()
        if leaves + seconds <= until:
            return leaves
        leaves = min(until - float(seconds), leaves - SOONER)
        if leaves <= begin:
            break
    return None
