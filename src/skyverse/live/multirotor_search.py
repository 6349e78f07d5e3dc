"""What a multirotor may fly from now on: along the mission's trajectory, along ways, or to rest.

Ways are tried in the order of when they could arrive at best. Motions along them end at rest within the horizon, and
are proven clear of what stands still, and of where movers may be up to the horizon.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.course import STAY, Course, Planned, motions_along, part_of, place_of_rest, staying, stopping, timed
from skyverse.live.guidance import AT_REST, GATE_SHARES, SHARES, Way, escapes, gates, ways_ahead
from skyverse.live.search import BLOCKED, KEEP_ON, Choice, Search, Step
from skyverse.live.steered_motion import seconds_left, steered_motion
from skyverse.live.surroundings import FirstContact, Surroundings, way_back
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import ACCELERATION_LEFT
from skyverse.space.speed_zones import seconds_lost
from skyverse.space.world import path_free

REST = 0.5
"""Seconds by which another way must be faster than resting, for a UAV that rests or is near its target."""
SLOWER_IN_ZONES = 0.999
"""The share of zones' speed limits that is flown in them."""
AT_END = 1e-6
"""Metres from the end of a way at which a UAV has arrived."""

Outcome = tuple[Course, Choice]


class Branch(NamedTuple):
    """A motion that leaves the present course when it begins, unless it is `kept`: the present course itself."""

    motion: Trajectory
    way: Way
    passed: Floats
    leaves: float = -math.inf
    kept: bool = False


class MultirotorSearch(Search[Course, Branch]):
    """One search for one multirotor.

    Parameters
    ----------
    course
        What it flies now.
    guidance, planned
        The way that it would fly if nothing moved, and the mission's trajectory, ``None`` if it flies another way.
    around
        What it keeps clear of, the instants that matter, and how long may be searched.
    """

    def __init__(self, course: Course, guidance: Way, planned: Planned | None, around: Surroundings) -> None:
        super().__init__(around)
        self.course, self.guidance, self.planned = course, guidance, planned
        self.widened = False
        self.states: dict[float, Floats] = {}
        self.before: dict[float, FirstContact] = {}
        self.clear_before: dict[float, bool] = {}
        self.fastest = math.hypot(*self.state(self.span.now)[1])  # of a UAV that was found too fast, and brakes
        self.hold = Branch(course.motion, course.way, course.passed, course.leaves, kept=True)

    def state(self, t: float) -> Floats:
        """Return position, velocity and acceleration on the present course, (3, 3)."""
        if t not in self.states:
            self.states[t] = self.course.state(t)
        return self.states[t]

    def first(self) -> Iterator[Step[Course]]:
        """Yield the steps along the mission's trajectory, and along the present way, which shows what is in its way."""
        for found in self.along_plan():
            yield partial(self.counted, found)
        # The mission is clear of what stands still, though a stop from it may not be at every instant; and other UAVs,
        # which fly the mission too, go out of the way in time. So the present course goes on if no mover is met.
        if self.planned is not None and self.course.leaves >= self.span.join and not self.kept_back:
            yield partial(self.examine, self.hold)
        onwards = self.course.remaining(self.span.join)
        if not self.taken and len(onwards.points) and self.may_rest(onwards):
            yield partial(self.probe, onwards)

    def counted(self, found: Branch) -> Outcome | None:
        """Examine a motion that was made."""
        self.tried += 1
        return self.examine(found)

    def probe(self, onwards: Way) -> Outcome | None:
        """Examine the motion along a way at full speed at once."""
        self.tried += 1
        made = self.along(self.span.join, onwards, 1.0)
        return None if made is None else self.examine(made[0])

    def fill(self) -> None:
        """Push to keep on, the ways ahead at all speeds, and to stop."""
        self.push(self.arrival(self.hold), partial(self.examine, self.hold))
        limited = {
            SLOWER_IN_ZONES * zone.max_speed / self.around.limits.speed for zone in self.around.world.speed_zones
        }
        shares = sorted({*SHARES, *(share for share in limited if share < 1.0)}, reverse=True)
        for begin in self.begins():
            place, velocity, _ = self.state(begin)
            mark, kept = self.course.next_mark(begin), self.course.remaining(begin)
            lead = AT_REST + float(np.sum(velocity**2)) / self.around.limits.acceleration
            self.consider(begin, [kept] if len(kept.points) else [], shares)
            self.consider(begin, ways_ahead(self.guidance, mark, place, lead), shares, KEEP_ON)
        self.push(self.arrival(self.stop), partial(self.examine, self.stop))

    def begins(self) -> list[float]:
        """Return the instants at which a new motion may begin: at once, and when the UAV accelerates no more."""
        join = self.span.join
        end = None
        if math.hypot(*self.state(join)[2]) > ACCELERATION_LEFT:
            end = self.course.ramp_end(join, self.span.until)
        return [join] if end is None else [join, end]

    def last(self) -> Iterator[Step[Course]]:
        """Yield to keep on, and to stop, unless these were examined."""
        for entry in (self.hold, self.stop):
            if all(entry is not found for _, found in self.met):
                yield partial(self.proven, entry)

    def consider(self, begin: float, ways: Iterable[Way], shares: Sequence[float], dearer: float = 0.0) -> None:
        """Push ways from an instant on, in the order of when they could arrive at best."""
        place, velocity, _ = self.state(begin)
        mark = self.course.next_mark(begin)
        for way in ways:
            more = dearer if self.leads_on(place, way, mark) else dearer + BLOCKED
            seconds = seconds_left(self.around.limits, place, velocity, way.points)
            for share in shares:
                slower = (1.0 - share) * max(self.looked_at - begin, 0.0)
                self.push(begin + seconds + slower + more, partial(self.make, begin, way, share, more))

    def make(self, begin: float, way: Way, share: float, dearer: float) -> None:
        """Push the motion along a way from an instant on, at a share of the largest speed, if there is one."""
        self.tried += 1
        made = self.along(begin, way, share)
        if made is not None:
            found, arrival = made
            self.push(arrival + dearer, partial(self.examine, found))

    def along(self, begin: float, way: Way, share: float) -> tuple[Branch, float] | None:
        """Return the motion along a way and about when it arrives, or ``None`` if there is none."""
        looked_at = max(self.looked_at - begin, 0.0)
        durations, rows, passed, arrival = steered_motion(
            self.state(begin), way.points, way.most, self.around.limits, share, self.span.until - begin, looked_at
        )
        if not len(durations):
            return None
        found = Branch(timed(begin, durations, rows), way, begin + passed)
        if self.taken:
            return found, self.nearest_rest(self.flown(found))
        if self.around.world.speed_zones:
            ahead = way.points[int(np.sum(passed <= looked_at)) :]
            arrival += self.seconds_lost(found.motion.at([begin + looked_at]).position[0], ahead)
        return found, begin + arrival

    def leads_on(self, place: Floats, way: Way, mark: int) -> bool:
        """Tell whether nothing that stands still is in those legs of a way that are not the guidance's own."""
        first = way.marks[0]
        legs = 0 if 0 <= first <= mark else (2 if first < 0 else 1)
        return path_free(self.around.world.space, np.vstack([place, way.points[:legs]]))

    def seconds_lost(self, place: Floats, points: Floats) -> float:
        """Return by about how many seconds zones' speed limits make the rest of a way longer."""
        return seconds_lost(self.around.world.speed_zones, self.around.limits.speed, place, points)

    def along_plan(self) -> Iterator[Branch]:
        """Yield motions that go on along the mission's trajectory, as far as the UAV is on it."""
        own, join = self.planned, self.span.join
        if own is None or not join <= self.course.leaves < own.motion.end:
            return
        behind = int(np.sum(own.passed[:-1] <= join))
        way, ahead = self.guidance.after(1 + behind), own.passed[behind:]
        for leaves, motion in motions_along(own.motion, join, self.span.until, self.around.limits):
            yield Branch(motion, way, np.where(ahead <= leaves, ahead, np.inf), leaves)

    @cached_property
    def stop(self) -> Branch:
        """The motion that stops as fast as possible."""
        begin = self.span.join
        way = self.course.remaining(begin)
        motion = stopping(self.state(begin), begin, self.around.limits)
        return Branch(motion, way, np.full(len(way.points), np.inf))

    def flown(self, found: Branch) -> Course:
        """Return the course of a motion."""
        return self.course if found.kept else self.course.joined(*found[:-1])

    def begin(self, found: Branch) -> float:
        """Return when a motion begins to differ from the present course, or could."""
        return self.span.join if found.kept else found.motion.start

    def contact(self, found: Branch) -> FirstContact:
        """Return the mover that a motion first comes too near to, counted from now."""
        present, now, begin, apart = self.course.motion, self.span.now, self.begin(found), self.span.apart
        if found.kept:
            return self.around.contact(present, now, apart, self.fastest)
        if begin not in self.before:
            self.before[begin] = self.around.contact(present, now, begin, self.fastest)
        before = self.before[begin]
        return before if before.mover >= 0 else self.around.contact(found.motion, begin, apart, self.fastest)

    def clear(self, found: Branch) -> bool:
        """Tell whether all that is flown from now on is clear of what stands still, and slow enough there."""
        if found.kept:
            return self.barred(found) == math.inf
        begin = found.motion.start
        if begin not in self.clear_before:
            before = part_of(self.course.motion, self.span.now, begin)
            self.clear_before[begin] = self.around.barred(before) == math.inf
        return self.clear_before[begin] and self.around.barred(found.motion) == math.inf

    def barred(self, found: Branch) -> float:
        """Return from when on a motion is not proven to be clear of what stands still, infinite if it is."""
        motion = self.flown(found).motion
        return self.around.barred(part_of(motion, self.span.now, max(motion.end, self.span.until)))

    def examine(self, found: Branch) -> Outcome | None:
        """Return a motion if it may be flown."""
        return self.proven(found)

    def proven(self, found: Branch) -> Outcome | None:
        """Return a motion if it is proven; if not, take note of what it meets, and push ways past the first."""
        contact = self.contact(found)
        if contact.instant == math.inf and self.clear(found):
            return self.outcome(found)
        self.met.append((contact, found))
        if not self.widened:
            self.widened = True
            self.widen(found, contact)
        return None

    def widen(self, found: Branch, contact: FirstContact) -> None:
        """Push ways past the place where a motion meets a mover, and away from where the UAV is."""
        begin = self.begin(found)
        place = self.state(begin)[0]
        limits, left = self.around.limits, self.span.until - begin
        aside = REST if self.taken else 0.0
        if contact.mover >= 0 and len(found.way.points):
            k = min(int(np.sum(found.passed <= contact.instant)), len(found.way.points) - 1)
            meeting = self.flown(found).state(contact.instant)[0]
            need = float(self.around.moving.needs[contact.mover])
            self.consider(begin, gates(found.way, place, meeting, k, need), GATE_SHARES, aside)
        guidance = self.guidance.after(min(self.course.next_mark(begin), len(self.guidance.points) - 1))
        reach = min(0.25 * limits.acceleration * left * left, 0.5 * limits.speed * left)
        self.consider(self.span.join, escapes(guidance, place, reach), (1.0,), aside)

    @property
    def kept_back(self) -> bool:
        """Whether a mover is in the way of a motion that was examined."""
        return any(0 <= contact.mover < self.around.uavs for contact, _ in self.met)

    def arrival(self, found: Branch) -> float:
        """Return about when a UAV arrives that stops, or keeps its course.

        A UAV that has waited for another one is held to wait as long again, so that after a while it tries another way:
        otherwise UAVs that wait for each other would do so for ever. One that a mover keeps from going on, and that
        rests or is near its target, does not leave for what is gained by less than `REST`, so that it does not waver.
        """
        course, looked_at = self.flown(found), self.looked_at
        end = course.motion.end
        if found.kept and math.dist(place_of_rest(course.motion), self.guidance.points[-1]) < AT_END:
            return end
        if self.taken:
            return self.nearest_rest(course) - (REST if self.rests else 0.0)
        place, velocity, _ = course.state(max(looked_at, self.begin(found)))
        left = self.left(course, looked_at)
        seconds = seconds_left(self.around.limits, place, velocity, left.points)
        later = looked_at + seconds + self.seconds_lost(place, left.points)
        later += 0.0 if self.leads_on(place, left, course.next_mark(looked_at)) else BLOCKED
        waited = self.span.now - self.course.motion.end
        if waited > 0.0 and any(contact.mover >= self.around.uavs for contact, _ in self.met):
            return later + waited
        return later - (REST if self.kept_back and self.may_rest(left) else 0.0)

    def left(self, course: Course, t: float) -> Way:
        """Return the points of a course's way that are not yet passed at an instant, the target at least."""
        left = course.remaining(t)
        return left if len(left.points) else self.guidance.after(len(self.guidance.points) - 1)

    @cached_property
    def taken(self) -> bool:
        """Whether a mover may be at the target at the horizon, by which the UAV could rest there otherwise.

        Then nothing that can be flown arrives, whatever is promised of the rest of its way. So motions are compared by
        where they come to rest, and aside of its way the UAV goes only for what brings it nearer by more than `REST`:
        thus it comes to rest itself.
        """
        target, span = self.guidance.points[-1], self.span
        reach = self.around.limits.speed * (span.until - span.now)
        if math.dist(self.state(span.now)[0], target) > reach:
            return False
        there = staying(target, span.until, span.until + STAY)
        return 0 <= self.around.contact(there, span.until, span.until).mover < self.around.uavs

    def nearest_rest(self, course: Course) -> float:
        """Return about when a UAV arrives that rests at the end of a course until the horizon, and goes on then."""
        end = course.motion.end
        place, left = course.state(end)[0], self.left(course, end)
        seconds = seconds_left(self.around.limits, place, np.zeros(3), left.points)
        return self.span.until + seconds + self.seconds_lost(place, left.points)

    @property
    def rests(self) -> bool:
        """Whether the UAV rests already."""
        return self.course.motion.end < self.span.now

    def may_rest(self, onwards: Way) -> bool:
        """Tell whether a UAV rests already, or can be at the end of a way by the horizon."""
        if self.rests:
            return True
        place, velocity, _ = self.state(self.span.join)
        seconds = seconds_left(self.around.limits, place, velocity, onwards.points)
        return self.span.join + seconds < self.span.until

    def first_meeting(self, found: Branch, contact: FirstContact) -> FirstContact:
        """Return what a motion meets first, of movers and of what stands still."""
        return min(contact, FirstContact(self.barred(found)), key=lambda one: one.instant)

    def nearest_to_clear(self, ranked: list[tuple[FirstContact, Branch]]) -> tuple[FirstContact, Branch]:
        """Return the motion that leads soonest to where it is clear, or else nearest to there; or to keep on."""

        def lacks(met: tuple[FirstContact, Branch]) -> tuple[float, float]:
            motion = met[1].motion
            if met[1].kept:
                motion = part_of(motion, self.span.join, max(motion.end, self.span.until))
            return way_back(self.around.world, motion)

        back = [(lacks(met), met) for met in ranked]
        (_, missing), best = min(back, key=lambda one: one[0])
        return best if missing < math.inf else (self.contact(self.hold), self.hold)
