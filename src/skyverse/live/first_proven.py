"""Of the motions along given ways, the first that is proven; otherwise the UAV goes on with its last proven motion."""

import math
from collections.abc import Sequence

import numpy as np

from skyverse.live.course import Course
from skyverse.live.guidance import Way
from skyverse.live.replan import KEEP_ON, LOOKED_AT, Choice, Span
from skyverse.live.steered_motion import seconds_left, steered_motion
from skyverse.live.surroundings import Surroundings, barred, first_contact
from skyverse.numerics.tolerances import ACCELERATION_LEFT, LIMIT_EASE

SAME_PLACE = 0.02
"""Metres between points of two ways that count as one."""
AT_END, NEAR_END = 1e-6, 0.1
"""Metres from the end of a way at which a UAV has arrived, and from which on it had better not come to rest."""


def first_proven(
    course: Course, around: Surroundings, span: Span, ways: Sequence[Way], shares: Sequence[float], proof: bool = True
) -> tuple[Course, Choice]:
    """Return what a UAV flies from now on.

    Parameters
    ----------
    course
        What it flies now.
    around, span
        What it keeps clear of, and the instants that matter.
    ways
        From where it is. Motions along them are tried in the order of their arrival.
    shares
        Of the largest speed, at which each way is tried.
    proof
        Whether only what is proven is flown; otherwise the first motion that can be made is.

    Returns
    -------
    tuple
        The course, and what is known of it. The present motion is tried too, in its place by when it could arrive along
        the first way, so that a UAV does not waver between ways that take as long. Where no motion along a way is
        proven, the present one goes on if it still is, or else the UAV brakes. Of motions of which none is proven, the
        one that meets a mover last is taken.
    """
    looked_at = span.now + LOOKED_AT * (span.until - span.now)
    found = _motions(course, around, span, ways, shares)
    tried = len(found)
    if tried:
        found.insert(0, (_kept_arrival(course, around, ways[0], looked_at) - KEEP_ON, course))
    moved = [one for _, one in sorted(found, key=lambda one: one[0])]
    if not proof and moved:
        mover, contact = _contact(moved[0], around, span)
        proven = contact == math.inf and _clear(moved[0], around, span)
        return moved[0], Choice(moved[0] is course, proven, mover, contact, tried)
    met: list[tuple[float, Course, int, bool]] = []
    for one in (*moved, course, course.stopping(span.join, around.limits)):
        if not _clear(one, around, span):
            continue
        mover, contact = _contact(one, around, span)
        if contact == math.inf:
            return one, Choice(one is course, True, -1, math.inf, tried)
        met.append((contact, one, mover, one is course))
    if not met:
        mover, contact = _contact(course, around, span)
        return course, Choice(True, False, mover, contact, tried)
    contact, one, mover, kept = max(met, key=lambda entry: entry[0])
    return one, Choice(kept, False, mover, contact, tried)


def _kept_arrival(course: Course, around: Surroundings, way: Way, looked_at: float) -> float:
    """Return about when a UAV arrives that keeps its course for now, and follows a way later.

    Never, if it would come to rest so near to the end of the way that no motion leads there any more.
    """
    off = math.dist(course.state(course.motion.end)[0], way.points[-1])
    if off <= AT_END:
        return course.motion.end
    if off <= NEAR_END:
        return math.inf
    place, velocity, _ = course.state(looked_at)
    done = course.way.points[course.passed <= looked_at]
    k = 0
    while k < len(way.points) - 1 and np.any(np.linalg.norm(done - way.points[k], axis=1) < SAME_PLACE):
        k += 1
    return looked_at + seconds_left(around.limits, place, velocity, way.points[k:])


def _motions(
    course: Course, around: Surroundings, span: Span, ways: Sequence[Way], shares: Sequence[float]
) -> list[tuple[float, Course]]:
    """Return courses along ways, each with about when it arrives."""
    begins, looked_at = [span.join], span.now + LOOKED_AT * (span.until - span.now)
    if math.hypot(*course.state(span.join)[2]) > ACCELERATION_LEFT:
        end = course.ramp_end(span.join, span.until)
        begins += [] if end is None else [end]
    found = []
    for begin in begins:
        state, left = course.state(begin), span.until - begin
        for way in ways:
            for share in shares:
                ahead = max(looked_at - begin, 0.0)
                made = steered_motion(state, way.points, way.most, around.limits, share, left, ahead)
                durations, rows, passed, arrival = made
                if len(durations):
                    found.append((begin + arrival, course.joined(begin, durations, rows, way, begin + passed)))
    return found


def _contact(course: Course, around: Surroundings, span: Span) -> tuple[int, float]:
    """Return the mover that a course comes too near to first up to the horizon, and when."""
    knots, rows = course.motion.knots.copy(), course.motion.coefficients.copy()
    fastest = around.limits.speed * (1.0 + LIMIT_EASE)
    return first_contact(around.moving.shapes, knots, rows, fastest, span.now, span.until)


def _clear(course: Course, around: Surroundings, span: Span) -> bool:
    """Tell whether what is left of a course is clear of what stands still, and slow enough in zones."""
    end = max(course.motion.end, span.until)
    return barred(around.world, span.now, *course.part(span.now, end)) == math.inf
