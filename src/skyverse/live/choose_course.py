"""Chooses what a UAV flies from now on: of the motions that are proven, the one that arrives first.

Ways are tried in the order of when they could arrive at best. Motions along them end at rest within the horizon, and
are proven clear of what stands still, and of where movers may be up to the horizon.
"""

import heapq
import math
import time
from collections.abc import Iterable, Iterator
from itertools import count
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.course import STAY, Course, Planned, motions_along, stop_or_stay
from skyverse.live.guidance import AT_REST, GATE_SHARES, SHARES, Way, escapes, gates, ways_ahead
from skyverse.live.replan import BLOCKED, KEEP_ON, LOOKED_AT, Choice, Span
from skyverse.live.steered_motion import seconds_left, steered_motion
from skyverse.live.surroundings import Surroundings, barred, first_contact, seconds_lost, share_avoided, way_back
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import ACCELERATION_LEFT, LIMIT_EASE
from skyverse.space.world import path_free

REST = 0.5
"""Seconds by which another way must be faster than resting, for a UAV that rests or is near its target."""
SLOWER_IN_ZONES = 0.999
"""The share of zones' speed limits that is flown in them."""


class _Idea(NamedTuple):
    """A way that may be tried from an instant of the present course, at a share of the largest speed."""

    begin: float
    way: Way
    share: float
    dearer: float


class _Candidate(NamedTuple):
    """A motion that may be flown; with no pieces, the present course goes on."""

    begin: float
    durations: Floats
    rows: Floats
    way: Way
    passed: Floats
    leaves: float = -math.inf


class _Search:
    """One search for one UAV."""

    def __init__(
        self, course: Course, guidance: Way, planned: Planned | None, around: Surroundings, span: Span
    ) -> None:
        self.course, self.guidance, self.planned = course, guidance, planned
        self.around, self.span = around, span
        self.queue: list[tuple[float, int, _Idea | _Candidate]] = []
        self.numbers = count()
        self.met: list[tuple[float, int, _Candidate]] = []
        self.looked_at = span.now + LOOKED_AT * (span.until - span.now)
        self.widened = False
        self.states: dict[float, Floats] = {}
        self.before: dict[float, tuple[int, float]] = {}
        self.clear_before: dict[float, bool] = {}
        self.fastest = math.hypot(*self.state(span.now)[1])  # of a UAV that was found too fast, and brakes
        self.taken = self.is_taken()

    def state(self, t: float) -> Floats:
        """Return position, velocity and acceleration on the present course, (3, 3)."""
        if t not in self.states:
            self.states[t] = self.course.state(t)
        return self.states[t]

    def push(self, arrival: float, entry: _Idea | _Candidate) -> None:
        heapq.heappush(self.queue, (arrival, next(self.numbers), entry))

    def consider(self, begin: float, ways: Iterable[Way], shares: tuple[float, ...], dearer: float = 0.0) -> None:
        """Add ways from an instant on, in the order of when they could arrive at best."""
        place, velocity, _ = self.state(begin)
        mark = self.course.next_mark(begin)
        for way in ways:
            more = dearer if self.leads_on(place, way, mark) else dearer + BLOCKED
            seconds = seconds_left(self.around.limits, place, velocity, way.points)
            for share in shares:
                slower = (1.0 - share) * max(self.looked_at - begin, 0.0)
                self.push(begin + seconds + slower + more, _Idea(begin, way, share, more))

    def leads_on(self, place: Floats, way: Way, mark: int) -> bool:
        """Tell whether nothing that stands still is in those legs of a way that are not the guidance's own."""
        first = way.marks[0]
        legs = 0 if 0 <= first <= mark else (2 if first < 0 else 1)
        ends = np.vstack([place, way.points[:legs]])
        return path_free(self.around.world.space, ends)

    def made(self, idea: _Idea) -> tuple[_Candidate, float] | None:
        """Return the motion along a way and about when it arrives, or ``None`` if there is none."""
        begin, way, share, dearer = idea
        left = self.span.until - begin
        looked_at = max(self.looked_at - begin, 0.0)
        durations, rows, passed, arrival = steered_motion(
            self.state(begin), way.points, way.most, self.around.limits, share, left, looked_at
        )
        if not len(durations):
            return None
        found = _Candidate(begin, durations, rows, way, begin + passed)
        if self.taken:
            return found, self.nearest_rest(self.applied(found)) + dearer
        if self.around.world.speed_zones:
            motion = Trajectory(np.append(0.0, np.cumsum(durations)), rows)
            ahead = way.points[int(np.sum(passed <= looked_at)) :]
            dearer += self.seconds_lost(motion.at([looked_at]).position[0], ahead)
        return found, begin + arrival + dearer

    def seconds_lost(self, place: Floats, points: Floats) -> float:
        """Return by about how many seconds zones' speed limits make the rest of a way longer."""
        return seconds_lost(self.around.world.speed_zones, self.around.limits.speed, place, points)

    def along_plan(self) -> Iterator[_Candidate]:
        """Yield motions that go on along the mission's trajectory, as far as the UAV is on it."""
        own, join = self.planned, self.span.join
        if own is None or not join <= self.course.leaves < own.motion.end:
            return
        behind = int(np.sum(own.passed[:-1] <= join))
        way, ahead = self.guidance.after(1 + behind), own.passed[behind:]
        for leaves, durations, rows in motions_along(own.motion, join, self.span.until, self.around.limits):
            passed = np.where(ahead <= leaves, ahead, np.inf)
            yield _Candidate(join, durations, rows, way, passed, leaves)

    def keeps_plan(self, hold: _Candidate) -> bool:
        """Tell whether a UAV on the mission's trajectory goes on as it does, since no mover is in its way.

        The mission is clear of what stands still, though a stop from it may not be at every instant; and other UAVs,
        which fly the mission too, go out of the way in time.
        """
        if self.planned is None or self.course.leaves < self.span.join:
            return False
        return not any(0 <= who < self.around.uavs for _, who, _ in self.met) and self.proves(hold)

    def stop(self, begin: float) -> _Candidate:
        """Return the motion that stops as fast as possible."""
        durations, rows = stop_or_stay(self.state(begin), self.around.limits)
        way = self.course.remaining(begin)
        return _Candidate(begin, durations, rows, way, np.full(len(way.points), np.inf))

    def applied(self, found: _Candidate) -> Course:
        if not len(found.durations):
            return self.course
        _, durations, rows, way, passed, leaves = found
        return self.course.joined(found.begin, durations, rows, way, passed, leaves)

    def contact(self, found: _Candidate) -> tuple[int, float]:
        """Return the mover that a candidate first comes too near to, counted from now, and when."""
        motion, begin = self.course.motion, self.span.now
        if len(found.durations):
            if found.begin not in self.before:
                self.before[found.begin] = self.first_contact(motion.knots, motion.coefficients, begin, found.begin)
            mover, contact = self.before[found.begin]
            if mover >= 0:
                return mover, contact
            knots = found.begin + np.append(0.0, np.cumsum(found.durations))
            return self.first_contact(knots, found.rows, found.begin, self.span.apart)
        return self.first_contact(motion.knots, motion.coefficients, begin, self.span.apart)

    def first_contact(self, knots: Floats, rows: Floats, begin: float, until: float) -> tuple[int, float]:
        """Return the mover that a motion first comes too near to between two instants, and when."""
        fastest = max(self.around.limits.speed * (1.0 + LIMIT_EASE), self.fastest)
        return first_contact(self.around.moving.shapes, knots.copy(), rows.copy(), fastest, begin, until)

    def clear(self, found: _Candidate) -> bool:
        """Tell whether all that a candidate flies from now on is clear of what stands still, and slow enough there."""
        if not len(found.durations):
            return self.barred(found) == math.inf
        world, begin = self.around.world, found.begin
        if begin not in self.clear_before:
            self.clear_before[begin] = barred(world, begin, *self.course.part(self.span.now, begin)) == math.inf
        return self.clear_before[begin] and barred(world, begin, found.durations, found.rows) == math.inf

    def barred(self, found: _Candidate) -> float:
        """Return from when on a candidate is not proven to be clear of what stands still, infinite if it is."""
        course, now = self.applied(found), self.span.now
        return barred(self.around.world, now, *course.part(now, max(course.motion.end, self.span.until)))

    def arrival(self, found: _Candidate) -> float:
        """Return about when a UAV arrives that stops, or keeps its course.

        A UAV that has waited for another one is held to wait as long again, so that after a while it tries another way:
        otherwise UAVs that wait for each other would do so for ever. One that a mover keeps from going on, and that
        rests or is near its target, does not leave for what is gained by less than `REST`, so that it does not waver.
        """
        course = self.applied(found)
        target, end = self.guidance.points[-1], course.motion.end
        state = course.state(end)
        if math.dist(state[0], target) < 1e-6 and not len(found.durations):
            return end
        if self.taken:
            return self.nearest_rest(course) - (REST if self.rests() else 0.0)
        place, velocity, _ = course.state(max(self.looked_at, found.begin))
        left = self.left(course, self.looked_at)
        seconds = seconds_left(self.around.limits, place, velocity, left.points)
        later = self.looked_at + seconds + self.seconds_lost(place, left.points)
        later += 0.0 if self.leads_on(place, left, course.next_mark(self.looked_at)) else BLOCKED
        waited = self.span.now - self.course.motion.end
        if waited > 0.0 and any(who >= self.around.uavs for _, who, _ in self.met):
            return later + waited
        kept_back = any(0 <= who < self.around.uavs for _, who, _ in self.met)
        return later - (REST if kept_back and self.may_rest(left) else 0.0)

    def left(self, course: Course, t: float) -> Way:
        """Return the points of a course's way that are not yet passed at an instant, the target at least."""
        left = course.remaining(t)
        return left if len(left.points) else self.guidance.after(len(self.guidance.points) - 1)

    def is_taken(self) -> bool:
        """Tell whether a mover may be at the target at the horizon, by which the UAV could rest there otherwise.

        Then nothing that can be flown arrives, whatever is promised of the rest of its way. So motions are compared by
        where they come to rest, and aside of its way the UAV goes only for what brings it nearer by more than `REST`:
        thus it comes to rest itself.
        """
        target, span = self.guidance.points[-1], self.span
        reach = self.around.limits.speed * (span.until - span.now)
        if math.dist(self.state(span.now)[0], target) > reach:
            return False
        knots, rows = np.array([span.until, span.until + STAY]), target.reshape(1, 1, 3)
        return 0 <= self.first_contact(knots, rows, span.until, span.until)[0] < self.around.uavs

    def nearest_rest(self, course: Course) -> float:
        """Return about when a UAV arrives that rests at the end of a course until the horizon, and goes on then."""
        end = course.motion.end
        place, left = course.state(end)[0], self.left(course, end)
        seconds = seconds_left(self.around.limits, place, np.zeros(3), left.points)
        return self.span.until + seconds + self.seconds_lost(place, left.points)

    def rests(self) -> bool:
        """Tell whether a UAV rests already."""
        return self.course.motion.end < self.span.now

    def may_rest(self, onwards: Way) -> bool:
        """Tell whether a UAV rests already, or can be at the end of a way by the horizon."""
        if self.rests():
            return True
        place, velocity, _ = self.state(self.span.join)
        seconds = seconds_left(self.around.limits, place, velocity, onwards.points)
        return self.span.join + seconds < self.span.until

    def proves(self, found: _Candidate) -> bool:
        """Tell whether a candidate is proven; if not, take note of what it meets."""
        mover, contact = self.contact(found)
        if contact == math.inf and self.clear(found):
            return True
        self.met.append((contact, mover, found))
        if not self.widened:
            self.widen(found, mover, contact)
        return False

    def held_up(self) -> bool:
        """Tell whether another UAV is in the way of the motion that would arrive first."""
        return bool(self.met) and self.met[0][1] >= self.around.uavs

    def chosen(self, found: _Candidate, tried: int) -> tuple[Course, Choice]:
        """Return the choice of a candidate that is proven."""
        return self.applied(found), Choice(not len(found.durations), True, -1, math.inf, tried, self.held_up())

    def unproven(self, found: _Candidate, mover: int, contact: float, tried: int) -> tuple[Course, Choice]:
        """Return the choice of a candidate that is not proven, and meets a mover, if any, at an instant."""
        instant = self.barred(found)
        mover, contact = (mover, contact) if contact <= instant else (-1, instant)
        return self.applied(found), Choice(not len(found.durations), False, mover, contact, tried, self.held_up())

    def way_back(self, found: _Candidate) -> tuple[float, float]:
        """Return after how many seconds a candidate is clear of what stands still, and what it lacks at its end."""
        durations, rows = found.durations, found.rows
        if not len(durations):
            durations, rows = self.course.part(self.span.join, max(self.course.motion.end, self.span.until))
        return way_back(self.around.world, durations, rows)

    def widen(self, found: _Candidate, mover: int, contact: float) -> None:
        """Add ways past the place where a motion meets a mover, and away from where the UAV is."""
        self.widened = True
        place = self.state(found.begin)[0]
        limits, left = self.around.limits, self.span.until - found.begin
        aside = REST if self.taken else 0.0
        if mover >= 0 and len(found.way.points):
            k = min(int(np.sum(found.passed <= contact)), len(found.way.points) - 1)
            meeting = self.applied(found).state(contact)[0]
            need = float(self.around.moving.needs[mover])
            self.consider(found.begin, gates(found.way, place, meeting, k, need), GATE_SHARES, aside)
        guidance = self.guidance.after(min(self.course.next_mark(found.begin), len(self.guidance.points) - 1))
        reach = 0.25 * limits.acceleration * left * left
        reach = min(reach, 0.5 * limits.speed * left)
        self.consider(self.span.join, escapes(guidance, place, reach), (1.0,), aside)


def choose_course(
    course: Course,
    guidance: Way,
    planned: Planned | None,
    around: Surroundings,
    span: Span,
    most_tried: int,
    deadline: float = math.inf,
) -> tuple[Course, Choice]:
    """Return what a UAV flies from now on.

    Parameters
    ----------
    course
        What it flies now.
    guidance, planned
        The way that it would fly if nothing moved, and the mission's trajectory, ``None`` if it flies another way.
    around, span
        What it keeps clear of, and the instants that matter.
    most_tried
        How many motions are made at most.
    deadline
        The reading of `time.perf_counter` at which the search ends, with the best that is known then.
    """
    search = _Search(course, guidance, planned, around, span)
    nothing = np.zeros(0)
    hold = _Candidate(span.join, nothing, nothing, course.way, course.passed)
    tried = 0
    for found in search.along_plan():
        if tried == most_tried or time.perf_counter() >= deadline:
            break
        tried += 1
        if search.proves(found):
            return search.chosen(found, tried)
    if search.keeps_plan(hold):
        return search.chosen(hold, tried)
    onwards, spare = course.remaining(span.join), tried < most_tried and time.perf_counter() < deadline
    if not search.taken and len(onwards.points) and spare and search.may_rest(onwards):
        tried += 1  # what is in its way?
        made = search.made(_Idea(span.join, onwards, 1.0, 0.0))
        if made is not None and search.proves(made[0]):
            return search.chosen(made[0], tried)
    search.push(search.arrival(hold), hold)
    joins, shares = [span.join], _shares(around)
    state = search.state(span.join)
    if math.hypot(*state[2]) > ACCELERATION_LEFT:
        end = course.ramp_end(span.join, span.until)
        joins += [] if end is None else [end]
    for begin in joins:
        place, velocity, _ = search.state(begin)
        mark, kept = course.next_mark(begin), course.remaining(begin)
        lead = AT_REST + float(np.sum(velocity**2)) / around.limits.acceleration
        search.consider(begin, [kept] if len(kept.points) else [], shares)
        search.consider(begin, ways_ahead(guidance, mark, place, lead), shares, KEEP_ON)
    stop = search.stop(span.join)
    search.push(search.arrival(stop), stop)
    while search.queue and tried < most_tried and time.perf_counter() < deadline:
        _, _, entry = heapq.heappop(search.queue)
        if isinstance(entry, _Idea):
            tried += 1
            made = search.made(entry)
            if made is not None:
                search.push(made[1], made[0])
        elif search.proves(entry):
            return search.chosen(entry, tried)
    for entry in (hold, stop):  # whatever the effort, these two are examined
        if all(entry is not one for _, _, one in search.met) and search.proves(entry):
            return search.chosen(entry, tried)
    return _least_bad(search, hold, tried)


def _shares(around: Surroundings) -> tuple[float, ...]:
    """Return the shares of the largest speed at which ways are tried, those of zones' limits among them."""
    limited = {SLOWER_IN_ZONES * zone.max_speed / around.limits.speed for zone in around.world.speed_zones}
    return tuple(sorted({*SHARES, *(share for share in limited if share < 1.0)}, reverse=True))


def _least_bad(search: _Search, hold: _Candidate, tried: int) -> tuple[Course, Choice]:
    """Return the course that is clear of most of what movers may do from when it can begin, and for longest.

    Where none is clear of what stands still, one that leads soonest to where it is, or else nearest to there; if none
    does, the UAV keeps on.
    """
    span, shapes = search.span, search.around.moving.shapes
    ranked = []
    for number, (contact, mover, found) in enumerate(search.met):
        motion = search.applied(found).motion
        share, missing = share_avoided(shapes, motion.knots.copy(), motion.coefficients.copy(), span.join, span.apart)
        ranked.append((-share, missing, number, mover, contact, found))
    ranked.sort(key=lambda one: one[:3])
    for *_, mover, contact, found in ranked:
        if search.clear(found):
            return search.unproven(found, mover, contact, tried)
    back = [(*search.way_back(one[-1]), *one) for one in ranked]
    soonest = min(back, key=lambda one: one[:5], default=None)
    if soonest is not None and soonest[1] < math.inf:
        return search.unproven(soonest[-1], soonest[-3], soonest[-2], tried)
    mover, contact = search.contact(hold)
    return search.unproven(hold, mover, contact, tried)
