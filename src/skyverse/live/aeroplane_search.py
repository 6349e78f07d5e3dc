"""What an aeroplane may fly from now on: along a reference, and then a loiter, or to the end at its target.

References go on as before, lead back to what was planned, or turn away. They are tried in the order of when they could
arrive at best; but where the present way to the target is proven, an aeroplane keeps to it. A motion is proven if all
of it, with a full turn of its loiter, is clear of what stands still, and up to the horizon of wherever movers may be.
"""

import math
from collections.abc import Iterator
from functools import partial
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
    pose_at,
    poses_at,
    turns_away,
)
from skyverse.live.course import part_of, spliced
from skyverse.live.search import BLOCKED, KEEP_ON, Choice, Search, Step
from skyverse.live.surroundings import FirstContact, Surroundings
from skyverse.model.trajectory import Trajectory
from skyverse.trajectory.dubins import pose
from skyverse.trajectory.dubins_leg import DubinsLeg

FOLLOWED = (1.0, 0.75, 0.5, 0.25, 0.1, 0.0)
"""Shares of the longest time for which a reference can be followed up to the horizon, that are tried."""
LATER, APART = 8, 0.25
"""How many loiters beyond the horizon are tried, and how far apart they begin, in full turns."""
DELAYS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Seconds by which a departure is delayed."""

Outcome = tuple[AeroplaneCourse, Choice]


class Followed(NamedTuple):
    """A motion from the instant on at which it begins, what it follows, and when it leaves that.

    `clear` tells whether all of it is clear of what stands still, and `kept` whether it is the present course.
    """

    motion: Trajectory
    reference: Reference | None
    leaves: float
    clear: bool = True
    kept: bool = False


class AeroplaneSearch(Search[AeroplaneCourse, Followed]):
    """One search for one aeroplane.

    Parameters
    ----------
    course
        What it flies now.
    ahead
        Where it can get back to what was planned, if anything was.
    able
        What it can do.
    around
        What it keeps clear of, the instants that matter, and how long may be searched.
    """

    def __init__(self, course: AeroplaneCourse, ahead: Ahead | None, able: Flying, around: Surroundings) -> None:
        super().__init__(around)
        span = self.span
        self.course, self.ahead, self.able = course, ahead, able
        self.begin = max(span.join, course.motion.start)
        self.looked_at = max(self.looked_at, self.begin)
        self.pose = pose_at(course.motion, self.begin)
        self.before = self.contact(course.motion, span.now, self.begin)
        self.barred_before = around.barred(part_of(course.motion, span.now, self.begin))
        self.held = False

    def first(self) -> Iterator[Step[AeroplaneCourse]]:
        """Yield the steps along the present way to the target, if the aeroplane is on one."""
        reference = self.present()
        if reference is not None and reference.joins < math.inf:
            self.follow(self.begin, reference, first=True)
        while self.queue and self.queue[0][0] == -math.inf:
            yield self.pop()

    def fill(self) -> None:
        """Push all other references: as before, later before the departure, back to what was planned, and away."""
        reference, begin = self.present(), self.begin
        if reference is not None and reference.joins == math.inf:
            self.push(self.arrival(reference), partial(self.try_following, begin, reference))
        elif reference is not None and begin > self.span.join:
            for delay in DELAYS:
                motion = reference.motion.retimed(begin + delay)
                later = Reference(motion, reference.joins + delay, reference.later + delay)
                self.push(motion.end, partial(self.try_following, begin + delay, later))
        self.push(self.arrival_as_before(), self.keep)
        if self.ahead is not None:
            for k, seconds in enumerate(self.seconds_left(self.pose[None])[0].tolist()):
                self.push(begin + seconds + KEEP_ON, partial(self.try_back, self.ahead, k))
        legs = list(turns_away(self.pose, self.able))
        for leg, left in zip(legs, self.left(np.array([end_of(leg) for leg in legs])).tolist(), strict=True):
            seconds = (leg.a + leg.b) / self.able.speed
            self.push(begin + seconds + left + KEEP_ON, partial(self.try_away, leg))

    def last(self) -> Iterator[Step[AeroplaneCourse]]:
        """Yield to keep on, unless that was examined."""
        if not self.held:
            yield self.keep

    def contact(self, motion: Trajectory, begin: float, until: float) -> FirstContact:
        """Return what moves that a motion first comes too near to between two instants."""
        return FirstContact() if begin >= until else self.around.contact(motion, begin, until)

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

    def try_following(self, begin: float, reference: Reference) -> None:
        """Push the motions that follow a reference from an instant on."""
        self.tried += 1
        self.follow(begin, reference)

    def try_away(self, leg: DubinsLeg) -> None:
        """Push the motions that follow a leg away."""
        self.try_following(self.begin, away_along(leg, self.begin, self.pose, self.able))

    def try_back(self, ahead: Ahead, k: int) -> None:
        """Push the motions along the two shortest ways back to the k-th place ahead."""
        self.tried += 1
        longer = back_to(ahead, k, 1, self.begin, self.pose, self.able)
        if longer is not None:
            self.push(longer.motion.end + KEEP_ON, partial(self.try_following, self.begin, longer))
        reference = back_to(ahead, k, 0, self.begin, self.pose, self.able)
        if reference is not None:
            self.follow(self.begin, reference)

    def follow(self, begin: float, reference: Reference, first: bool = False) -> None:
        """Push motions that follow a reference, as the `first` that are tried if those loiter late."""
        curve = part_of(reference.motion, begin, reference.motion.end)
        contact = self.contact(curve, self.begin, min(curve.end, self.span.apart))
        barred = self.around.barred(curve)
        clear = min(contact.instant, barred, curve.end)
        if min(contact.instant, barred) < math.inf:
            self.judged(Followed(curve, reference, curve.end), contact, barred)
        leaves = self.cuts(begin, clear, curve.end)
        found: list[tuple[float, int | None]] = [(t, side) for t in leaves for side in (LEFT, RIGHT)]
        if clear == curve.end and reference.joins < math.inf:
            found.append((curve.end, None))
        arrival, looked_at = self.arrival(reference), min(self.looked_at, curve.end)
        for t, side in found:
            if t >= looked_at:
                self.push(-math.inf if first else arrival, partial(self.proven, begin, reference, t, side))
        soon = [one for one in found if one[0] < looked_at]
        left = self.left(self.poses_then(reference.motion, soon))
        for (t, side), seconds in zip(soon, left.tolist(), strict=True):
            self.push(max(self.looked_at + seconds, arrival), partial(self.proven, begin, reference, t, side))

    def cuts(self, begin: float, clear: float, end: float) -> list[float]:
        """Return the instants, as they are tried, at which a reference that is clear up to an instant may be left."""
        last, turn = min(clear, self.span.until), 2.0 * math.pi * self.able.radius / self.able.speed
        found = [] if clear < end else [end]
        found += [begin + share * (last - begin) for share in FOLLOWED if share < 1.0 or clear > last]
        found += [t for t in last + APART * turn * np.arange(1, LATER) if t < clear]
        return found

    def poses_then(self, motion: Trajectory, found: list[tuple[float, int | None]]) -> Floats:
        """Return about the poses (m, 5) of motions that loiter already, since when and to which side, when compared."""
        poses = poses_at(motion, np.array([leaves for leaves, _ in found]))
        for row, (leaves, side) in zip(poses, found, strict=True):
            way = (self.looked_at - leaves) * self.able.speed
            row[4] = 0.0
            row[0], row[1], row[3] = pose(row[0], row[1], row[3], side or LEFT, way, 0.0, self.able.radius, way)
        return poses

    def proven(self, begin: float, reference: Reference, leaves: float, side: int | None) -> Outcome | None:
        """Return the motion that leaves a reference to loiter to a side, if it is proven; else note what it meets.

        Without a side the reference ends there.
        """
        self.tried += 1
        motion = part_of(reference.motion, begin, leaves)
        if side is None:  # as far as is known, it stays where it has landed
            return self.judged(Followed(motion, reference, leaves), self.contact(motion, leaves, self.span.apart))
        circle = loiter(leaves, pose_at(reference.motion, leaves), side, self.span.apart - leaves, self.able)
        contact = self.contact(circle, leaves, self.span.apart)
        return self.judged(Followed(spliced(motion, circle), reference, leaves), contact, self.around.barred(circle))

    def keep(self) -> Outcome | None:
        """Return the present course, with more full turns where needed, if it is proven."""
        self.held = True
        motion = self.course.lasting(self.span.apart, self.able).motion
        contact = self.contact(motion, self.span.now, self.span.apart)
        kept = Followed(self.course.motion, None, 0.0, kept=True)
        return self.judged(kept, contact, self.around.barred(part_of(motion, self.begin, motion.end)))

    def judged(self, found: Followed, contact: FirstContact, barred: float = math.inf) -> Outcome | None:
        """Return a motion that meets nothing; otherwise take note of what it meets, also before it begins."""
        met = min(self.before, contact)
        static = min(barred, self.barred_before)
        if min(met.instant, static) == math.inf:
            return self.outcome(found)
        self.met.append(
            (met if met.instant <= static else FirstContact(static), found._replace(clear=barred == math.inf))
        )
        return None

    def flown(self, found: Followed) -> AeroplaneCourse:
        """Return the course of a motion, or the present one, with as many full turns as the horizon needs."""
        course = self.course
        if not found.kept:
            departed = course.motion.start <= self.span.join
            follows = (found.motion, found.reference, found.leaves)
            course = course.joined(*follows) if departed else AeroplaneCourse(course.flown, *follows)
        return course.lasting(self.span.apart, self.able)

    def clear(self, found: Followed) -> bool:
        """Tell whether all of a motion is clear of what stands still."""
        return found.clear
