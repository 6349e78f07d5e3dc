"""Chooses what an aeroplane flies from now on: of the motions that are proven, the one that arrives first.

Every motion follows a reference, and then loiters, or ends at the target. References go on as before, lead back to what
was planned, or turn away. They are tried in the order of when they could arrive at best; but where the present way to
the target is proven, an aeroplane keeps to it. A motion is proven if all of it, with a full turn of its loiter, is
clear of what stands still, and up to the horizon of wherever movers may be.
"""

import heapq
import math
import time
from itertools import count
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.aeroplane_course import (
    LEFT,
    RIGHT,
    AeroplaneCourse,
    Ahead,
    Flying,
    Reference,
    away_along,
    back_to,
    end_of,
    loiter,
    part_of,
    pose_at,
    poses_at,
    timed,
    turns_away,
)
from skyverse.live.course import followed, of_one_degree
from skyverse.live.replan import BLOCKED, KEEP_ON, LOOKED_AT, Choice, Span
from skyverse.live.surroundings import Surroundings, barred, first_contact, share_avoided
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import LIMIT_EASE
from skyverse.trajectory.dubins import pose
from skyverse.trajectory.dubins_leg import DubinsLeg

FOLLOWED = (1.0, 0.75, 0.5, 0.25, 0.1, 0.0)
"""Shares of the longest time for which a reference can be followed up to the horizon, that are tried."""
LATER, APART = 8, 0.25
"""How many loiters beyond the horizon are tried, and how far apart they begin, in full turns."""
DELAYS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Seconds by which a departure is delayed."""


class _Idea(NamedTuple):
    """What may be followed from an instant on: a reference, a leg away, or a way back to a place ahead, by its rank."""

    begin: float
    reference: Reference | None = None
    away: DubinsLeg | None = None
    place: int = -1
    rank: int = 0


class _Candidate(NamedTuple):
    """A reference from an instant on, until it is left to loiter to a side, or where it ends if there is no side."""

    begin: float
    reference: Reference
    leaves: float
    side: int | None


class _Flight(NamedTuple):
    """A motion from the instant on at which it begins, the reference that it follows, and when it leaves that."""

    motion: Trajectory
    reference: Reference
    leaves: float


class _Met(NamedTuple):
    """What a flight meets first: when, and which mover, -1 for what stands still; no flight is the present course.

    `clear` tells whether all of it is clear of what stands still.
    """

    instant: float
    mover: int
    clear: bool
    flight: _Flight | None


class _Search:
    """One search for one aeroplane."""

    def __init__(
        self, course: AeroplaneCourse, ahead: Ahead | None, able: Flying, around: Surroundings, span: Span
    ) -> None:
        self.course, self.ahead, self.able, self.around, self.span = course, ahead, able, around, span
        self.queue: list[tuple[float, int, _Idea | _Candidate | None]] = []
        self.numbers = count()
        self.met: list[_Met] = []
        self.begin = max(span.join, course.motion.start)
        self.looked_at = max(span.now + LOOKED_AT * (span.until - span.now), self.begin)
        self.pose = pose_at(course.motion, self.begin)
        self.before = self.contact(course.motion, span.now, self.begin)
        self.barred_before = self.barred(part_of(course.motion, span.now, self.begin))

    def push(self, arrival: float, entry: _Idea | _Candidate | None) -> None:
        heapq.heappush(self.queue, (arrival, next(self.numbers), entry))

    def contact(self, motion: Trajectory, begin: float, until: float) -> tuple[float, int]:
        """Return when a motion is first too near to a mover between two instants, infinite if never, and to which."""
        if begin >= until:
            return math.inf, -1
        fastest = self.around.limits.speed * (1.0 + LIMIT_EASE)
        knots, rows = motion.knots.copy(), motion.coefficients.copy()
        mover, instant = first_contact(self.around.moving.shapes, knots, rows, fastest, begin, until)
        return instant, mover

    def barred(self, motion: Trajectory) -> float:
        """Return from when on it is not proven that a motion is clear of what stands still, infinite if it is."""
        return barred(self.around.world, motion.start, np.diff(motion.knots), motion.coefficients.copy())

    def seconds_left(self, poses: Floats) -> Floats:
        """Return about how many seconds it takes at least to the target from poses (m, 5), by each place ahead, (m, n).

        Places that are out of sight count as farther.
        """
        if self.ahead is None:
            return np.zeros((len(poses), 1))
        begin, end = np.repeat(poses, len(self.ahead.poses), axis=0), np.tile(self.ahead.poses, (len(poses), 1))
        seen = self.around.world.segments_free(begin[:, :3].copy(), end[:, :3].copy()).reshape(len(poses), -1)
        return self.ahead.seconds_left(poses, self.able) + np.where(seen, 0.0, BLOCKED)

    def left(self, poses: Floats) -> Floats:
        """Return the same by the best place, (m,)."""
        least: Floats = self.seconds_left(poses).min(axis=1)
        return least

    def arrival(self, reference: Reference) -> float:
        """Return when a reference arrives, or could at best."""
        end = reference.motion.end
        if reference.joins < math.inf:
            return end
        return end + float(self.left(pose_at(reference.motion, end)[None])[0])

    def arrival_as_before(self) -> float:
        """Return when the present course arrives, or could at best."""
        reference, t = self.course.reference, self.looked_at
        if reference is not None and t <= min(self.course.leaves, reference.motion.end):
            return self.arrival(reference)
        course = self.course.lasting(t, self.able)
        return t + float(self.left(pose_at(course.motion, t)[None])[0])

    def present(self) -> Reference | None:
        """Return the reference that is followed where new motions begin, ``None`` if the aeroplane loiters there."""
        reference = self.course.reference
        if reference is None or self.begin >= min(self.course.leaves, reference.motion.end):
            return None
        return reference

    def keep_on(self) -> None:
        """Add the motions along the present way to the target, if the aeroplane is on one."""
        reference = self.present()
        if reference is not None and reference.joins < math.inf:
            self.follow(_Idea(self.begin, reference), first=True)

    def consider(self) -> None:
        """Add all other references: as before, later before the departure, back to what was planned, and away."""
        reference, begin = self.present(), self.begin
        if reference is not None and reference.joins == math.inf:
            self.push(self.arrival(reference), _Idea(begin, reference))
        elif reference is not None and begin > self.span.join:
            for delay in DELAYS:
                motion = reference.motion.retimed(begin + delay)
                later = Reference(motion, reference.joins + delay, reference.later + delay)
                self.push(motion.end, _Idea(begin + delay, later))
        self.push(self.arrival_as_before(), None)
        if self.ahead is not None:
            for k, seconds in enumerate(self.seconds_left(self.pose[None])[0].tolist()):
                self.push(begin + seconds + KEEP_ON, _Idea(begin, place=k))
        legs = list(turns_away(self.pose, self.able))
        for leg, left in zip(legs, self.left(np.array([end_of(leg) for leg in legs])).tolist(), strict=True):
            seconds = (leg.a + leg.b) / self.able.speed
            self.push(begin + seconds + left + KEEP_ON, _Idea(begin, away=leg))

    def made(self, idea: _Idea) -> Reference | None:
        """Return the reference of an idea; ``None`` if there is none."""
        if idea.away is not None:
            return away_along(idea.away, idea.begin, self.pose, self.able)
        if idea.place < 0 or self.ahead is None:
            return idea.reference
        if idea.rank == 0:
            longer = back_to(self.ahead, idea.place, 1, idea.begin, self.pose, self.able)
            if longer is not None:
                self.push(longer.motion.end + KEEP_ON, _Idea(idea.begin, longer))
        return back_to(self.ahead, idea.place, idea.rank, idea.begin, self.pose, self.able)

    def follow(self, idea: _Idea, first: bool = False) -> None:
        """Add motions that follow a reference, as the `first` that are tried if those loiter late."""
        reference = self.made(idea)
        if reference is None:
            return
        curve = part_of(reference.motion, idea.begin, reference.motion.end)
        contact, mover = self.contact(curve, self.begin, min(curve.end, self.span.apart))
        barred = self.barred(curve)
        clear = min(contact, barred, curve.end)
        if min(contact, barred) < math.inf:
            self.judges(_Flight(curve, reference, curve.end), (contact, mover), barred)
        leaves = self.cuts(idea.begin, clear, curve.end)
        found = [_Candidate(idea.begin, reference, t, side) for t in leaves for side in (LEFT, RIGHT)]
        if clear == curve.end and reference.joins < math.inf:
            found.append(_Candidate(idea.begin, reference, curve.end, None))
        arrival, looked_at = self.arrival(reference), min(self.looked_at, curve.end)
        for one in found:
            if one.leaves >= looked_at:
                self.push(-math.inf if first else arrival, one)
        soon = [one for one in found if one.leaves < looked_at]
        left = self.left(self.poses_then(reference.motion, soon))
        for one, seconds in zip(soon, left.tolist(), strict=True):
            self.push(max(self.looked_at + seconds, arrival), one)

    def cuts(self, begin: float, clear: float, end: float) -> list[float]:
        """Return the instants, as they are tried, at which a reference that is clear up to an instant may be left."""
        last, turn = min(clear, self.span.until), 2.0 * math.pi * self.able.radius / self.able.speed
        found = [] if clear < end else [end]
        found += [begin + share * (last - begin) for share in FOLLOWED if share < 1.0 or clear > last]
        found += [t for t in last + APART * turn * np.arange(1, LATER) if t < clear]
        return found

    def poses_then(self, motion: Trajectory, found: list[_Candidate]) -> Floats:
        """Return about the poses (m, 5) of candidates that loiter already when motions are compared."""
        poses = poses_at(motion, np.array([one.leaves for one in found]))
        for row, one in zip(poses, found, strict=True):
            way = (self.looked_at - one.leaves) * self.able.speed
            row[4] = 0.0
            row[0], row[1], row[3] = pose(row[0], row[1], row[3], one.side or LEFT, way, 0.0, self.able.radius, way)
        return poses

    def proves(self, found: _Candidate) -> _Flight | None:
        """Return the flight of a candidate if it is proven; if not, take note of what it meets."""
        begin, reference, leaves, side = found
        durations, rows = followed(reference.motion, begin, leaves)
        if side is None:  # as far as is known, it stays where it has landed
            motion = timed(begin, durations, rows)
            return self.judges(_Flight(motion, reference, leaves), self.contact(motion, leaves, self.span.apart))
        more = loiter(pose_at(reference.motion, leaves), side, self.span.apart - leaves, self.able)
        circle = timed(leaves, *more)
        motion = timed(begin, np.append(durations, more[0]), np.concatenate(of_one_degree(rows, more[1])))
        contact = self.contact(circle, leaves, self.span.apart)
        return self.judges(_Flight(motion, reference, leaves), contact, self.barred(circle))

    def judges(self, flight: _Flight | None, contact: tuple[float, int], barred: float = math.inf) -> _Flight | None:
        """Return a flight that meets nothing; otherwise take note of what it meets, also before it begins."""
        instant, mover = min(self.before, contact)
        meets = min(instant, barred, self.barred_before)
        if meets < math.inf:
            self.met.append(_Met(meets, mover if instant == meets else -1, barred == math.inf, flight))
            return None
        return flight

    def holds(self) -> bool:
        """Tell whether the present course, with more full turns where needed, is proven."""
        course, known = self.flown(None), len(self.met)
        contact = self.contact(course.motion, self.span.now, self.span.apart)
        self.judges(None, contact, self.barred(part_of(course.motion, self.begin, course.motion.end)))
        return len(self.met) == known

    def flown(self, flight: _Flight | None) -> AeroplaneCourse:
        """Return the course of a flight, or the present one, with as many full turns as the horizon needs."""
        course = self.course
        if flight is not None:
            departed = course.motion.start <= self.span.join
            course = course.joined(*flight) if departed else AeroplaneCourse(course.flown, *flight)
        return course.lasting(self.span.apart, self.able)


def choose_loiter(
    course: AeroplaneCourse,
    ahead: Ahead | None,
    able: Flying,
    around: Surroundings,
    span: Span,
    most_tried: int,
    deadline: float = math.inf,
) -> tuple[AeroplaneCourse, Choice]:
    """Return what an aeroplane flies from now on, and what is known of it.

    Parameters
    ----------
    course
        What it flies now.
    ahead
        Where it can get back to what was planned, if anything was.
    able
        What it can do.
    around, span
        What it keeps clear of, and the instants that matter.
    most_tried
        How many motions are made at most.
    deadline
        The reading of `time.perf_counter` at which the search ends, with the best that is known then.
    """
    search = _Search(course, ahead, able, around, span)
    tried, held = 0, False
    for more, latest in ((search.keep_on, -math.inf), (search.consider, math.inf)):
        if tried and (tried >= most_tried or time.perf_counter() >= deadline):
            break
        more()
        while search.queue and search.queue[0][0] <= latest and tried < most_tried and time.perf_counter() < deadline:
            _, _, entry = heapq.heappop(search.queue)
            tried += 1
            if isinstance(entry, _Idea):
                search.follow(entry)
                continue
            if entry is None:
                held = True
                if search.holds():
                    return search.flown(None), Choice(True, True, -1, math.inf, tried)
                continue
            found = search.proves(entry)
            if found is not None:
                return search.flown(found), Choice(False, True, -1, math.inf, tried)
    if not held and search.holds():  # whatever the effort, the present course is examined
        return search.flown(None), Choice(True, True, -1, math.inf, tried)
    return _least_bad(search, tried)


def _least_bad(search: _Search, tried: int) -> tuple[AeroplaneCourse, Choice]:
    """Return the course that is clear of most of what movers may do from when it can begin, and for longest.

    One that is not clear of what stands still is flown only if there is no other.
    """
    span, shapes, ranked = search.span, search.around.moving.shapes, []
    for number, met in enumerate(search.met):
        motion = search.course.motion if met.flight is None else met.flight.motion
        share, missing = share_avoided(shapes, motion.knots.copy(), motion.coefficients.copy(), span.join, span.apart)
        ranked.append((not met.clear, -share, missing, number, met))
    best = min(ranked, key=lambda one: one[:4])[-1]
    return search.flown(best.flight), Choice(best.flight is None, False, best.mover, best.instant, tried)
